/* SPDX-License-Identifier: Apache-2.0 */
/* .vdb files from strangers: whatever stands in them, they are read, or refused with one message, within bounds. */
#include "test_support.h"

#include <stdlib.h>
#include <sys/resource.h>
#include <time.h>

#include <nephos/nephos.h>

#include "core/alloc.h"
#include "core/file.h"
#include "test_box_files.h"
#include "test_grids.h"
#include "volume/volume_private.h"

#define DATA NEPHOS_TEST_SOURCE_DIR "/data/"

static int set_up(void **state) { return test_set_up(state, 1, "cloud.vdb"); }

/* ---- Reading ---- */

/* Runs `nephos info` and `nephos info --json`. */
static neph_result describe(neph_context *context, const char *path, neph_text_format format) {
  char *text;
  const neph_result result = neph_volume_describe_file(context, path, format, &text);
  neph_text_destroy(context, text);
  return result;
}

static neph_result describe_as_json(neph_context *context, const char *path) {
  return describe(context, path, NEPH_TEXT_JSON);
}

static neph_result load(neph_context *context, const char *path) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_volume *volume;
  desc.policy = NEPH_IMPORT_REPAIR;
  const neph_result result = neph_volume_load(context, path, &desc, &volume);
  neph_volume_release(volume);
  return result;
}

static long get_peak_kilobytes(void) {
  struct rusage usage;
  assert_int_equal(getrusage(RUSAGE_SELF, &usage), 0);
  return usage.ru_maxrss;
}

/* A bad file may take 64 times its bytes and 256 MB, and 5 s. Sanitizers keep what was freed, and shadows of it. */
static void assert_within_bounds(long kilobytes_before, clock_t clock_before, uint64_t file_bytes) {
#ifndef __SANITIZE_ADDRESS__
  assert_in_range(get_peak_kilobytes() - kilobytes_before, 0, 256000 + 64 * file_bytes / 1000);
#else
  (void)kilobytes_before, (void)file_bytes;
#endif
  assert_true(clock() - clock_before < 5 * CLOCKS_PER_SEC);
}

/* ---- Files that were found to do harm ---- */

static void assert_refused(test_fixture *f, const char *path, const char *word) {
  const long kilobytes = get_peak_kilobytes();
  const clock_t start = clock();
  assert_int_equal(describe(f->context, path, NEPH_TEXT_PLAIN), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, path, word);
  assert_int_equal(describe(f->context, path, NEPH_TEXT_JSON), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, path, word);
  if (load(f->context, path)) assert_one_error(&f->log, path); /* the grid that is loaded may be a sound one */
  assert_within_bounds(kilobytes, start, np_file_get_size(path));
}

/* They wrote past a buffer of values, left a tree behind, or took gigabytes. */
static void files_that_did_harm_are_refused(void **state) {
  static const char *const files[][2] = {
      {"crash-1d5ab8.vdb", "inactive values"}, {"crash-6ee71b.vdb", "buffers"},
      {"crash-9ed5f4.vdb", "inactive values"}, {"leak-09c4906.vdb", "chunk"},
      {"leak-c83e811.vdb", "chunk"},           {"oom-07c7d517.vdb", "truncated"},
      {"oom-1a60f257.vdb", "truncated"},       {"timeout-4d0c.vdb", "truncated"},
  };
  char path[512];
  for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
    snprintf(path, sizeof path, DATA "hostile/%s", files[i][0]);
    assert_refused(*state, path, files[i][1]);
  }
}

/* A voxel far from the others is odd, and allowed. */
static void a_stray_voxel_is_read(void **state) {
  test_fixture *f = *state;
  assert_int_equal(describe_as_json(f->context, DATA "hostile/stray20000.vdb"), NEPH_OK);
  assert_int_equal(load(f->context, DATA "hostile/stray20000.vdb"), NEPH_OK);
}

/* A hundred grids share 32768 tiles of one: they are measured once. */
static void instances_cost_no_more_than_their_grid(void **state) {
  test_fixture *f = *state;
  const long kilobytes = get_peak_kilobytes();
  const clock_t start = clock();
  assert_int_equal(describe_as_json(f->context, DATA "hostile/instances.vdb"), NEPH_OK);
  assert_within_bounds(kilobytes, start, np_file_get_size(DATA "hostile/instances.vdb"));
}

/* ---- Every way to store a grid ---- */

/* Written by OpenVDB 10: each compression, with active values alone or all, halves, every type of value, files without
 * offsets, instances, a frustum, points. */
static const char *const kinds[] = {"blosc",           "mask",          "zipmask_half", "stream",
                                    "stream_instance", "points_stream", "types_stream", "frustum"};

static void every_way_to_store_a_grid_is_read(void **state) {
  test_fixture *f = *state;
  static const char *const voxels[] = {"2097909", "2097909", "2097909", "2097909", "763", "29", "93", "763"};
  char path[512], expected[64], *text;
  for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
    snprintf(path, sizeof path, DATA "vdb/%s.vdb", kinds[i]);
    snprintf(expected, sizeof expected, "\"active_voxels\": %s,", voxels[i]);
    assert_int_equal(neph_volume_describe_file(f->context, path, NEPH_TEXT_JSON, &text), NEPH_OK);
    assert_non_null(strstr(text, expected));
    neph_text_destroy(f->context, text);
  }
  assert_int_equal(f->log.counts[NEPH_LOG_ERROR], 0);
}

/* Without offsets, what stands behind points cannot be found without reading them. */
static void grids_behind_points_need_offsets(void **state) {
  test_fixture *f = *state;
  const char *path = DATA "vdb/points_first_stream.vdb";
  assert_int_equal(describe_as_json(f->context, path), NEPH_ERROR_UNSUPPORTED);
  assert_one_error(&f->log, path, "'points'", "offsets");
}

/* Headers stand within the first 1200 bytes, nodes and leaves behind them. */
static void changed_bytes_do_no_harm(void **state) {
  test_fixture *f = *state;
  char path[512];
  const long kilobytes = get_peak_kilobytes();
  for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
    snprintf(path, sizeof path, DATA "vdb/%s.vdb", kinds[i]);
    const test_file file = test_file_read(path);
    const clock_t start = clock();
    test_file_write(f->path, file.bytes, file.size);
    assert_survives_changed_bytes(f, 1200, 60, describe_as_json);
    assert_survives_changed_bytes(f, file.size, 40, describe_as_json);
    assert_survives_changed_bytes(f, 1200, 40, load);
    assert_true(clock() - start < 140 * 5 * CLOCKS_PER_SEC);
    free(file.bytes);
  }
  assert_within_bounds(kilobytes, clock(), 0);
}

/* ---- Odd contents ---- */

static void save_named(test_fixture *f, const char *grid_name, const char *attribute_name) {
  np_sparse_grid grid;
  test_make_grid(f->context, 5, 2, &grid);
  np_alloc_free(f->context, grid.name);
  grid.name = np_alloc_text(f->context, grid_name);
  const np_vdb_attribute attribute = {.name = attribute_name, .text = "\xff\x1b[31mred"};
  const np_vdb_write_grid output = {.grid = &grid, .attributes = &attribute, .attribute_count = 1};
  assert_int_equal(np_volume_save_grids(f->context, f->path, &output, 1, NULL), NEPH_OK);
  np_sparse_grid_clear(&grid);
}

/* JSON holds UTF-8 alone, and a terminal obeys what it is sent. */
static void names_of_any_bytes_are_described(void **state) {
  test_fixture *f = *state;
  char *text;
  save_named(f, "od\xff", "bytes\xfe");
  assert_int_equal(neph_volume_describe_file(f->context, f->path, NEPH_TEXT_JSON, &text), NEPH_OK);
  assert_non_null(strstr(text, "\"od?\""));
  assert_non_null(strstr(text, "\"bytes?\": \"?\\u001B[31mred\""));
  neph_text_destroy(f->context, text);
  assert_int_equal(neph_volume_describe_file(f->context, f->path, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  assert_null(strchr(text, '\x1b'));
  assert_non_null(strstr(text, "?[31mred"));
  neph_text_destroy(f->context, text);
}

static void a_message_is_one_line_whatever_a_grid_is_called(void **state) {
  test_fixture *f = *state;
  save_named(f, "two\nlines", "a");
  assert_int_equal(load(f->context, f->path), NEPH_OK);
  test_file file = test_file_read(f->path);
  test_file_write(f->path, file.bytes, file.size - 100);
  free(file.bytes);
  assert_int_equal(load(f->context, f->path), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, "'two?lines'", "truncated");
}

/* Newer than what is known: read as if it were not, and said once, in the log alone. */
static void a_newer_format_is_a_warning(void **state) {
  test_fixture *f = *state;
  enum { VERSION_AT = 8 };
  save_named(f, "density", "a");
  test_file file = test_file_read(f->path);
  file.bytes[VERSION_AT] = 225;
  test_file_write(f->path, file.bytes, file.size);
  free(file.bytes);
  assert_int_equal(describe_as_json(f->context, f->path), NEPH_OK);
  assert_int_equal(f->log.counts[NEPH_LOG_WARNING], 1);
  assert_non_null(strstr(f->log.text, "version 225"));
}

/* A filled block of 4096³ in a file of a few hundred bytes: separate bricks for its faces would take gigabytes. */
static void a_large_tile_costs_little(void **state) {
  test_fixture *f = *state;
  test_tile_write(f->context, f->path);
  const long kilobytes = get_peak_kilobytes();
  const clock_t start = clock();
  assert_int_equal(describe(f->context, f->path, NEPH_TEXT_PLAIN), NEPH_OK);
  assert_int_equal(load(f->context, f->path), NEPH_OK);
  assert_within_bounds(kilobytes, start, 0);
}

/* Its light is solved for in cells as large as what varies, not as its voxels: 46656 of them in cloud, not four
 * million. Of 1.65 kB each at the most they take 77 MB, bricks 11. */
static void a_large_tile_is_rendered(void **state) {
  static const char *const integrators[] = {"march", "path"};
  test_fixture *f = *state;
  test_tile_write(f->context, f->path);
  for (int i = 0; i < 2; i++) {
    char text[800];
    (void)snprintf(text, sizeof text,
                   "version: 1\n"
                   "camera: {position: [0, -9 km, 1 km], look_at: [0, 0, 2 km], fov: 50 deg, resolution: [8, 5]}\n"
                   "sun: {elevation: 35 deg, azimuth: 120 deg}\n"
                   "atmosphere: none\n"
                   "clouds: [{vdb: cloud.vdb, voxel: 1 m, optical_depth: 40}]\n"
                   "render: {integrator: %s, samples: 1, sun_optical_depth: march}\n",
                   integrators[i]);
    neph_scene *scene = NULL;
    neph_image *image = NULL;
    char *path = test_path(f->folder, "scene.yaml");
    const size_t before = f->context->allocated_bytes;
    f->context->allocated_bytes_peak = before;
    assert_int_equal(neph_scene_load_text(f->context, text, path, &scene), NEPH_OK);
    assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
    print_message("%s: %zu MB\n", integrators[i], (f->context->allocated_bytes_peak - before) / 1000000);
    assert_true(f->context->allocated_bytes_peak - before < 100000000);
    neph_image_destroy(image);
    neph_scene_destroy(scene);
    free(path);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(files_that_did_harm_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(instances_cost_no_more_than_their_grid, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_stray_voxel_is_read, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(every_way_to_store_a_grid_is_read, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(grids_behind_points_need_offsets, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(changed_bytes_do_no_harm, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(names_of_any_bytes_are_described, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_message_is_one_line_whatever_a_grid_is_called, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_newer_format_is_a_warning, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_large_tile_costs_little, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_large_tile_is_rendered, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

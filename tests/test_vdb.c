/* SPDX-License-Identifier: Apache-2.0 */
#include "test_grids.h"

#include <stdlib.h>
#include <time.h>

#include "core/alloc.h"
#include "volume/volume_file.h"

static neph_result load(neph_context *context, const char *path, const char *grid, neph_volume **out_volume) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  desc.grid = grid;
  return neph_volume_load(context, path, &desc, out_volume);
}

static void assert_load_fails(neph_context *context, test_log *log, const char *path, const char *grid,
                              neph_result expected, const char *word, const char *other_word) {
  neph_volume *volume;
  assert_int_equal(load(context, path, grid, &volume), expected);
  assert_null(volume);
  assert_one_error(log, path, word, other_word);
}

/* ---- Round trip ---- */

static neph_result save(neph_context *context, const char *path, const np_sparse_grid *grid, int is_half) {
  const np_vdb_attribute attributes[] = {{.name = "nephos:seed", .number = 7},
                                         {.name = "nephos:unit", .text = "extinction 1/m"}};
  const np_vdb_write_grid output = {.grid = grid, .is_half = is_half, .attributes = attributes, .attribute_count = 2};
  return np_volume_save_grids(context, path, &output, 1, NULL);
}

static void read_first(neph_context *context, const char *path, np_sparse_grid *out_grid) {
  np_volume_file file;
  uint64_t tree_bytes;
  assert_int_equal(np_volume_file_open(context, path, NULL, NULL, &file), NEPH_OK);
  assert_int_equal(np_volume_file_read(&file, 0, out_grid, &tree_bytes), NEPH_OK);
  np_volume_file_close(&file);
}

static void make_placed_grid(neph_context *context, np_sparse_grid *out_grid) {
  test_make_grid(context, 21, 5, out_grid);
  out_grid->index_to_world = (np_affine){{{1.25, -0.5, 0, 1e5 / 3}, {0.5, 1.75, 0.125, -7}, {0, 0.25, 2.5, 1200.1}}};
}

/* Bits of values, topology and transform survive; the fingerprint says so, and stands in the file. */
static void a_grid_survives_the_way_through_a_file(void **state) {
  (void)state;
  char *folder = test_folder_create(), *path = test_path(folder, "grid.vdb");
  neph_context *context = test_context_create(2, NULL);
  np_sparse_grid grid, back;
  char before[33], after[33], *text;
  make_placed_grid(context, &grid);
  assert_int_equal(save(context, path, &grid, 0), NEPH_OK);
  assert_int_equal(test_folder_count(folder), 1);
  read_first(context, path, &back);
  assert_int_equal(back.leaf_count, grid.leaf_count);
  assert_memory_equal(back.leaves, grid.leaves, grid.leaf_count * sizeof *grid.leaves);
  assert_memory_equal(&back.index_to_world, &grid.index_to_world, sizeof grid.index_to_world);
  assert_int_equal(np_sparse_grid_hash_all(&(const np_sparse_grid *){&grid}, 1, false, before), NEPH_OK);
  assert_int_equal(np_sparse_grid_hash_all(&(const np_sparse_grid *){&back}, 1, false, after), NEPH_OK);
  assert_string_equal(before, after);
  assert_int_equal(neph_volume_describe_file(context, path, NEPH_TEXT_JSON, &text), NEPH_OK);
  assert_non_null(strstr(text, before));
  assert_non_null(strstr(text, "extinction 1/m"));
  assert_non_null(strstr(text, "\"class\": \"fog volume\""));
  neph_text_destroy(context, text);
  np_sparse_grid_clear(&grid);
  np_sparse_grid_clear(&back);
  neph_context_destroy(context);
  free(path);
  test_folder_destroy(folder);
}

static void halves_on_disk_have_the_fingerprint_of_what_is_read_back(void **state) {
  (void)state;
  char *folder = test_folder_create(), *path = test_path(folder, "half.vdb");
  neph_context *context = test_context_create(2, NULL);
  np_sparse_grid grid, back;
  char before[33], after[33];
  make_placed_grid(context, &grid);
  assert_int_equal(save(context, path, &grid, 1), NEPH_OK);
  read_first(context, path, &back);
  const np_sparse_grid *const grids[] = {&grid};
  assert_int_equal(np_sparse_grid_hash_all(grids, 1, true, before), NEPH_OK);
  assert_int_equal(np_sparse_grid_hash_all(&(const np_sparse_grid *){&back}, 1, false, after), NEPH_OK);
  assert_string_equal(before, after);
  np_sparse_grid_clear(&grid);
  np_sparse_grid_clear(&back);
  neph_context_destroy(context);
  free(path);
  test_folder_destroy(folder);
}

static void what_halves_cannot_hold_is_not_written(void **state) {
  (void)state;
  test_log log;
  np_sparse_grid grid;
  test_log_start(&log);
  char *folder = test_folder_create(), *path = test_path(folder, "large.vdb");
  neph_context *context = test_context_create(1, &log);
  make_placed_grid(context, &grid);
  grid.tiles[0] = (np_tile){{0, 0, 512}, 8, 1e6f, true};
  assert_int_equal(save(context, path, &grid, 1), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, path, "1e+06", "floats");
  assert_int_equal(test_folder_count(folder), 0);
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
  free(path);
  test_folder_destroy(folder);
}

static void a_folder_that_is_not_there_is_an_error(void **state) {
  (void)state;
  test_log log;
  np_sparse_grid grid;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  make_placed_grid(context, &grid);
  assert_true(save(context, "/nowhere/at/all.vdb", &grid, 0) != NEPH_OK);
  assert_one_error(&log, "/nowhere/at");
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

/* ---- Values that a cloud cannot have ---- */

typedef struct disk {
  char *folder, *path;
  test_log log;
  neph_context *context;
  np_sparse_grid grid;
} disk;

static void start_disk(disk *d) {
  test_log_start(&d->log);
  d->folder = test_folder_create();
  d->path = test_path(d->folder, "cloud.vdb");
  d->context = test_context_create(2, &d->log);
  test_make_grid(d->context, 5, 2, &d->grid);
}

static void write_disk(disk *d) { assert_int_equal(save(d->context, d->path, &d->grid, 0), NEPH_OK); }

static void end_disk(disk *d) {
  np_sparse_grid_clear(&d->grid);
  neph_context_destroy(d->context);
  free(d->path);
  test_folder_destroy(d->folder);
}

/* Voxel (1, 2, 3) of the second leaf is invalid: refused with its place, or repaired with a warning. Values above the
 * range of the file become the largest value, all others 0. */
static void assert_value_is_refused_or_repaired(float value, const char *word) {
  disk d;
  start_disk(&d);
  np_leaf *leaf = &d.grid.leaves[1];
  leaf->values[64 + 16 + 3] = value;
  leaf->active[1] |= UINT64_C(1) << 19;
  write_disk(&d);
  char place[64];
  snprintf(place, sizeof place, "(%d, %d, %d)", leaf->origin[0] + 1, leaf->origin[1] + 2, leaf->origin[2] + 3);
  assert_load_fails(d.context, &d.log, d.path, NULL, NEPH_ERROR_BAD_FILE, word, place);
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  desc.policy = NEPH_IMPORT_REPAIR;
  neph_volume *volume;
  assert_int_equal(neph_volume_load(d.context, d.path, &desc, &volume), NEPH_OK);
  assert_int_equal(d.log.counts[NEPH_LOG_WARNING], 1);
  assert_non_null(strstr(d.log.text, place));
  np_dvec3 at = np_dvec3_make(leaf->origin[0] + 1, leaf->origin[1] + 2, leaf->origin[2] + 3);
  const float expected = value > 0.0f ? volume->value_max : 0.0f;
  assert_near((double)np_bricks_sample(&volume->bricks, at), (double)expected,
              1e-3 * (double)expected); /* stored as halves */
  neph_volume_release(volume);
  end_disk(&d);
}

static void values_that_a_cloud_cannot_have_are_refused(void **state) {
  (void)state;
  assert_value_is_refused_or_repaired(NAN, "1 value is NaN");
  assert_value_is_refused_or_repaired(INFINITY, "1 value is infinite");
  assert_value_is_refused_or_repaired(-INFINITY, "1 value is infinite");
  assert_value_is_refused_or_repaired(-0.25f, "1 value is negative");
}

/* −1e-6 of the largest is what rounding leaves of 0. The largest of these grids is below 1. */
static void what_is_rounding_is_clamped_and_counted(void **state) {
  (void)state;
  disk d;
  start_disk(&d);
  d.grid.leaves[0].values[0] = -5e-7f;
  d.grid.leaves[1].values[9] = -4e-7f;
  d.grid.leaves[2].values[9] = 1e-40f;
  write_disk(&d);
  neph_volume *volume;
  assert_int_equal(load(d.context, d.path, NULL, &volume), NEPH_OK);
  assert_int_equal(d.log.counts[NEPH_LOG_WARNING], 2);
  assert_non_null(strstr(d.log.text, "2 values are negative by rounding"));
  assert_non_null(strstr(d.log.text, "1 value is subnormal"));
  assert_true(volume->value_min >= 0.0f);
  neph_volume_release(volume);
  end_disk(&d);
}

static void a_background_that_is_not_zero_is_refused(void **state) {
  (void)state;
  disk d;
  start_disk(&d);
  d.grid.background = 0.5f;
  write_disk(&d);
  assert_load_fails(d.context, &d.log, d.path, NULL, NEPH_ERROR_BAD_FILE, "background 0.5", "density");
  end_disk(&d);
}

/* Active voxels at both ends of the index range: a table for all between is refused before it is allocated. */
static void a_bomb_is_refused(void **state) {
  (void)state;
  disk d;
  start_disk(&d);
  (void)np_sparse_grid_add_tile(&d.grid, (const int32_t[3]){2000000000, 2000000000, -2000000000}, 8, 1.0f, true);
  write_disk(&d);
  assert_load_fails(d.context, &d.log, d.path, NULL, NEPH_ERROR_BAD_FILE, "2000000", "too large, or damaged");
  end_disk(&d);
}

/* ---- Choice of a grid ---- */

static void a_grid_is_chosen_by_name_and_number(void **state) {
  (void)state;
  char *path = test_data_path("vdb/arnold_grids.vdb");
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  static const uint64_t voxels[3] = {491, 2222, 803};
  static const double shift_m[3] = {4, 2, 0};
  for (int n = 0; n < 3; n++) {
    char name[16];
    neph_volume *volume;
    neph_volume_info info = NEPH_VOLUME_INFO_DEFAULT;
    snprintf(name, sizeof name, "density[%d]", n);
    assert_int_equal(load(context, path, name, &volume), NEPH_OK);
    assert_int_equal(neph_volume_get_info(volume, &info), NEPH_OK);
    assert_int_equal(info.active_voxel_count, voxels[n]);
    assert_near(info.index_to_world[0][3], shift_m[n], 1e-12);
    neph_volume_release(volume);
  }
  assert_load_fails(context, &log, path, NULL, NEPH_ERROR_BAD_FILE, "3 grids", "density[0]");
  assert_load_fails(context, &log, path, "density", NEPH_ERROR_BAD_FILE, "3 grids", "density[2]");
  assert_load_fails(context, &log, path, "density[3]", NEPH_ERROR_BAD_FILE, "no grid 'density[3]'",
                    "'density' (float)");
  assert_load_fails(context, &log, path, "smoke", NEPH_ERROR_BAD_FILE, "no grid 'smoke'", "'density' (float)");
  neph_context_destroy(context);
  free(path);
}

static void what_is_no_density_is_refused(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  char *points = test_data_path("vdb/gaffer_points.vdb"), *colour = test_data_path("vdb/oiio_sphereCd.vdb");
  char *empty = test_data_path("vdb/usd_smoke_000001.vdb");
  assert_load_fails(context, &log, points, NULL, NEPH_ERROR_BAD_FILE, "no fog volume", "'points' (ptdataidx32)");
  assert_load_fails(context, &log, colour, NULL, NEPH_ERROR_BAD_FILE, "no density, only colours or velocities",
                    "found 'Cd' (vec3s)");
  assert_load_fails(context, &log, colour, "Cd", NEPH_ERROR_BAD_FILE, "vec3s", "must hold numbers or marks");
  assert_load_fails(context, &log, empty, NULL, NEPH_ERROR_BAD_FILE, "density", "is empty");
  neph_context_destroy(context);
  free(points);
  free(colour);
  free(empty);
}

/* ---- Real files ---- */

static void the_disney_cloud_is_what_its_makers_say(void **state) {
  (void)state;
  char *path = test_data_path("vdb/wdas_cloud_sixteenth.vdb");
  neph_context *context = test_context_create(2, NULL);
  np_sparse_grid grid;
  neph_volume *volume;
  neph_volume_info info = NEPH_VOLUME_INFO_DEFAULT;
  assert_int_equal(load(context, path, NULL, &volume), NEPH_OK);
  assert_int_equal(neph_volume_get_info(volume, &info), NEPH_OK);
  assert_int_equal(info.active_voxel_count, 415642);
  assert_int_equal(volume->active_max[0] - volume->active_min[0] + 1, 126);
  assert_int_equal(volume->active_max[1] - volume->active_min[1] + 1, 86);
  assert_int_equal(volume->active_max[2] - volume->active_min[2] + 1, 154);
  assert_near(info.index_to_world[0][0], 10.0 / 3.0, 1e-6);
  assert_true(info.value_min == 0.0f && info.value_max == 1.0f);
  read_first(context, path, &grid);
  size_t active_tiles = 0;
  for (size_t i = 0; i < grid.tile_count; i++) active_tiles += grid.tiles[i].is_active;
  assert_int_equal(active_tiles, 130);
  np_sparse_grid_clear(&grid);
  neph_volume_release(volume);
  neph_context_destroy(context);
  free(path);
}

/* Every file can be described, and every scalar grid in it that is not empty can be loaded. */
static void every_real_file_is_described_and_loaded(void **state) {
  (void)state;
  static const char *const names[] = {"vdb/wdas_cloud_sixteenth.vdb",  "vdb/arnold_smoke.vdb",
                                      "vdb/usd_smoke_000002.vdb",      "vdb/usd_densityAndHeat.vdb",
                                      "vdb/vpt_dragon_with_xform.vdb", "vdb/usd_smoke_000001.vdb",
                                      "vdb/oiio_sphere.vdb",           "vdb/oiio_sphereCd.vdb",
                                      "vdb/arnold_grids.vdb",          "vdb/gaffer_points.vdb"};
  neph_context *context = test_context_create(2, NULL);
  int loaded = 0;
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    char *path = test_data_path(names[i]), *lines, *json;
    assert_int_equal(neph_volume_describe_file(context, path, NEPH_TEXT_PLAIN, &lines), NEPH_OK);
    assert_int_equal(neph_volume_describe_file(context, path, NEPH_TEXT_JSON, &json), NEPH_OK);
    assert_non_null(strstr(lines, "index→world"));
    assert_non_null(strstr(json, "\"tree_bytes\""));
    for (int n = 0; strstr(json, "\"value_max\"") && n < 3; n++) {
      char name[16];
      neph_volume *volume;
      snprintf(name, sizeof name, "density[%d]", n);
      neph_result result = load(context, path, name, &volume);
      loaded += !result;
      neph_volume_release(volume);
    }
    neph_text_destroy(context, lines);
    neph_text_destroy(context, json);
    free(path);
  }
  assert_int_equal(loaded, 9);
  neph_context_destroy(context);
}

static void threads_do_not_change_a_bit(void **state) {
  (void)state;
  char *path = test_data_path("vdb/arnold_smoke.vdb");
  neph_context *contexts[2];
  neph_volume *volumes[2];
  for (unsigned n = 0; n < 2; n++) {
    contexts[n] = test_context_create(n + 1, NULL);
    assert_int_equal(load(contexts[n], path, NULL, &volumes[n]), NEPH_OK);
  }
  const np_bricks *a = &volumes[0]->bricks, *b = &volumes[1]->bricks;
  assert_int_equal(a->brick_count, b->brick_count);
  assert_memory_equal(a->halves, b->halves, a->brick_count * NP_BRICK_STRIDE * sizeof *a->halves);
  assert_memory_equal(a->nodes, b->nodes, a->node_count * sizeof *a->nodes);
  for (unsigned n = 0; n < 2; n++) {
    neph_volume_release(volumes[n]);
    neph_context_destroy(contexts[n]);
  }
  free(path);
}

/* ---- Damage ---- */

static void missing_files_and_folders_are_told_apart(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  char *text;
  assert_load_fails(context, &log, "/nowhere/cloud.vdb", NULL, NEPH_ERROR_NOT_FOUND, "cannot open", "No such file");
  assert_load_fails(context, &log, "/tmp", NULL, NEPH_ERROR_BAD_FILE, "is a folder", ".vdb");
  assert_int_equal(neph_volume_describe_file(context, "/nowhere/cloud.vdb", NEPH_TEXT_PLAIN, &text),
                   NEPH_ERROR_NOT_FOUND);
  assert_one_error(&log, "/nowhere/cloud.vdb");
  neph_context_destroy(context);
}

static void damaged_files_are_refused(void **state) {
  (void)state;
  static const char *const names[] = {"oiio_14b0_truncated", "oiio_2c9b_bad-bbox-overflow", "oiio_389d_bad-bbox-empty",
                                      "oiio_40ba_bad-bbox-bomb"};
  static const char *const words[] = {"truncated", "empty", "empty", "empty"};
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    char name[64];
    snprintf(name, sizeof name, "vdb/damaged/%s.vdb", names[i]);
    char *path = test_data_path(name);
    assert_load_fails(context, &log, path, NULL, NEPH_ERROR_BAD_FILE, words[i], path);
    free(path);
  }
  neph_context_destroy(context);
}

/* A file cut anywhere is refused with one message that names it; nothing crashes. */
static void a_file_cut_anywhere_is_refused(void **state) {
  (void)state;
  enum { CUTS = 150 };
  disk d;
  start_disk(&d);
  write_disk(&d);
  const test_file whole = test_file_read(d.path);
  char *cut = test_path(d.folder, "cut.vdb");
  for (size_t i = 0; i < CUTS; i++) {
    test_file_write(cut, whole.bytes, i < 50 ? i : whole.size * i / CUTS);
    neph_volume *volume;
    assert_int_equal(load(d.context, cut, NULL, &volume), NEPH_ERROR_BAD_FILE);
    assert_null(volume);
    assert_one_error(&d.log, cut);
  }
  free(cut);
  free(whole.bytes);
  end_disk(&d);
}

static void what_is_no_vdb_is_refused(void **state) {
  (void)state;
  disk d;
  start_disk(&d);
  test_file_write(d.path, "P6 64 64 255 this is a picture, and not a small one at that", 60);
  assert_load_fails(d.context, &d.log, d.path, NULL, NEPH_ERROR_BAD_FILE, "not a VDB file", d.path);
  end_disk(&d);
}

/* ---- Cancel ---- */

typedef struct canceller {
  const char *stage; /* cancel when this one is reached */
  struct timespec when;
  bool has_cancelled;
} canceller;

static bool cancel_at_stage(void *user, const neph_progress *progress) {
  canceller *c = user;
  if (!strcmp(progress->stage, c->stage) && !c->has_cancelled) {
    clock_gettime(CLOCK_MONOTONIC, &c->when);
    c->has_cancelled = true;
  }
  return !c->has_cancelled;
}

static double compute_seconds_since(const struct timespec *then) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)(now.tv_sec - then->tv_sec) + 1e-9 * (double)(now.tv_nsec - then->tv_nsec);
}

/* A cloud of 16 million voxels, which takes about a second to load. */
static void write_large(disk *d) {
  np_sparse_grid_clear(&d->grid);
  assert_int_equal(np_sparse_grid_init(d->context, "density", &d->grid), NEPH_OK);
  np_random random = np_random_start(9, 0, 0, 0, 0);
  for (int32_t n = 0; n < 32 * 32 * 32; n++)
    test_fill_leaf(np_sparse_grid_add_leaf(&d->grid, (const int32_t[3]){n / 1024 * 8, n / 32 % 32 * 8, n % 32 * 8}),
                   &random);
  write_disk(d);
}

/* Whether the file is being read, checked or built into bricks: half a second is what design promises. */
static void a_load_can_be_cancelled_in_every_stage(void **state) {
  (void)state;
  static const char *const stages[] = {"loading", "checking values", "building bricks"};
  disk d;
  start_disk(&d);
  write_large(&d);
  for (size_t i = 0; i < sizeof stages / sizeof *stages; i++) {
    canceller c = {.stage = stages[i]};
    neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
    desc.progress = cancel_at_stage;
    desc.progress_user = &c;
    neph_volume *volume;
    assert_int_equal(neph_volume_load(d.context, d.path, &desc, &volume), NEPH_ERROR_CANCELLED);
    assert_null(volume);
    assert_true(c.has_cancelled && compute_seconds_since(&c.when) < 0.5);
    assert_int_equal(d.log.counts[NEPH_LOG_ERROR], 0);
  }
  end_disk(&d);
}

/* ---- Memory ---- */

static neph_result load_and_release(neph_context *context, void *path) {
  neph_volume *volume;
  neph_result result = load(context, path, "density", &volume);
  neph_volume_release(volume);
  return result;
}

/* Peak of nephos's own allocations, within OpenVDB's reading too. */
static void failed_allocations_are_survived(void **state) {
  (void)state;
  disk d;
  start_disk(&d);
  write_disk(&d);
  assert_survives_failed_allocations(load_and_release, d.path);
  end_disk(&d);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_grid_survives_the_way_through_a_file),
      cmocka_unit_test(halves_on_disk_have_the_fingerprint_of_what_is_read_back),
      cmocka_unit_test(what_halves_cannot_hold_is_not_written),
      cmocka_unit_test(a_folder_that_is_not_there_is_an_error),
      cmocka_unit_test(values_that_a_cloud_cannot_have_are_refused),
      cmocka_unit_test(what_is_rounding_is_clamped_and_counted),
      cmocka_unit_test(a_background_that_is_not_zero_is_refused),
      cmocka_unit_test(a_bomb_is_refused),
      cmocka_unit_test(a_grid_is_chosen_by_name_and_number),
      cmocka_unit_test(what_is_no_density_is_refused),
      cmocka_unit_test(the_disney_cloud_is_what_its_makers_say),
      cmocka_unit_test(every_real_file_is_described_and_loaded),
      cmocka_unit_test(threads_do_not_change_a_bit),
      cmocka_unit_test(missing_files_and_folders_are_told_apart),
      cmocka_unit_test(damaged_files_are_refused),
      cmocka_unit_test(a_file_cut_anywhere_is_refused),
      cmocka_unit_test(what_is_no_vdb_is_refused),
      cmocka_unit_test(a_load_can_be_cancelled_in_every_stage),
      cmocka_unit_test(failed_allocations_are_survived),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

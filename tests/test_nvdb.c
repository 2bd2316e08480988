/* SPDX-License-Identifier: Apache-2.0 */
/* .nvdb files of NanoVDB's own tool hold the grids of the .vdb files that they come from; and its tools accept the
 * files that nephos writes. */
#include "test_tools.h"

#include <stdlib.h>

#include <nephos/nephos.h>

#include "test_velocity_files.h"
#include "volume/volume_choice.h"
#include "volume/volume_file.h"

#define DATA NEPHOS_TEST_SOURCE_DIR "/data/vdb"

/* "folder/name.ending", to be freed. */
static char *make_path(const char *folder, const char *name, const char *ending) {
  char *path;
  assert_true(asprintf(&path, "%s/%s%s", folder, name, ending) >= 0);
  return path;
}

static int set_up(void **state) {
  test_require_tool("nanovdb_convert --version >/dev/null 2>&1", "libnanovdb-tools");
  test_require_tool("/usr/bin/python3 -c 'import pyopenvdb' >/dev/null 2>&1", "python3-openvdb");
  const int failed = test_set_up(state, 2, NULL);
  const test_fixture *f = *state;
  if (!failed) test_run_command("/usr/bin/python3 " NEPHOS_TEST_SOURCE_DIR "/write_vdb.py %s", f->folder);
  return failed;
}

static void convert(const char *options, const char *from, const char *to) {
  test_run_command("nanovdb_convert -f %s %s %s", options, from, to);
}

/* ---- Grids ---- */

/* A hash of one component of a grid, as a file has it. */
static void hash(const test_fixture *f, const char *path, size_t index, int component, char out_hash[33]) {
  np_volume_file file;
  np_sparse_grid grid = {0};
  const np_sparse_grid *grids[] = {&grid};
  const np_volume_choice choice = {.indices = {index}, .count = 1};
  uint64_t bytes;
  assert_int_equal(np_volume_file_open(f->context, path, NULL, NULL, &file), NEPH_OK);
  if (np_volume_file_describe(&file, index).is_count)
    assert_int_equal(np_volume_file_read_density(&file, &choice, &grid, &bytes), NEPH_OK);
  else
    assert_int_equal(np_volume_file_read_component(&file, index, component, &grid, &bytes), NEPH_OK);
  assert_true(bytes > 0);
  assert_int_equal(np_sparse_grid_hash_all(grids, 1, false, out_hash), NEPH_OK);
  np_sparse_grid_clear(&grid);
  np_volume_file_close(&file);
}

static void assert_same_grid(const test_fixture *f, const char *expected, size_t expected_index, const char *actual,
                             size_t index) {
  np_volume_file files[2];
  assert_int_equal(np_volume_file_open(f->context, expected, NULL, NULL, &files[0]), NEPH_OK);
  assert_int_equal(np_volume_file_open(f->context, actual, NULL, NULL, &files[1]), NEPH_OK);
  const np_vdb_grid_info info = np_volume_file_describe(&files[0], expected_index),
                         other = np_volume_file_describe(&files[1], index);
  assert_string_equal(other.name, info.name);
  assert_string_equal(other.grid_class, info.grid_class);
  assert_int_equal(other.is_scalar, info.is_scalar);
  assert_int_equal(other.is_count, info.is_count);
  assert_int_equal(other.is_vector, info.is_vector);
  assert_int_equal(other.is_level_set, info.is_level_set);
  assert_memory_equal(other.index_to_world, info.index_to_world, sizeof info.index_to_world);
  for (int component = 0; component < (info.is_vector ? 3 : 1); component++) {
    char first[33], second[33];
    hash(f, expected, expected_index, component, first);
    hash(f, actual, index, component, second);
    assert_string_equal(second, first);
  }
  for (int i = 0; i < 2; i++) np_volume_file_close(&files[i]);
}

/* The tool sorts grids by their names. */
static size_t search_grid(const test_fixture *f, const char *path, const char *name) {
  np_volume_file file;
  size_t index = 0;
  assert_int_equal(np_volume_file_open(f->context, path, NULL, NULL, &file), NEPH_OK);
  while (strcmp(np_volume_file_describe(&file, index).name, name) != 0)
    assert_true(++index < np_volume_file_count(&file));
  np_volume_file_close(&file);
  return index;
}

/* Names, transforms, topologies and values to the bit, of each codec. */
static void grids_are_those_of_the_vdb(void **state) {
  static const struct {
    const char *file, *grid;
    bool is_of_data;
  } files[] = {{"blosc", "odd", true},     {"mask", "odd", true},    {"zipmask_half", "half", true},
               {"ball", "surface", false}, {"mark", "mark", false},  {"both", "Smoke", false},
               {"both", "surface", false}, {"parts", "fuel", false}, {"parts", "DENSITY", false}};
  static const char *const options[] = {"", "-z", "-b", "-c full"};
  test_fixture *f = *state;
  for (size_t i = 0; i < sizeof files / sizeof *files; i++)
    for (size_t o = 0; o < (files[i].is_of_data ? 4 : 3); o++) { /* the tool fails to sum what has no leaves */
      char *vdb = make_path(files[i].is_of_data ? DATA : f->folder, files[i].file, ".vdb"),
           *nvdb = make_path(f->folder, "converted", ".nvdb");
      convert(options[o], vdb, nvdb);
      assert_same_grid(f, vdb, search_grid(f, vdb, files[i].grid), nvdb, search_grid(f, nvdb, files[i].grid));
      free(vdb);
      free(nvdb);
    }
  assert_int_equal(f->log.counts[NEPH_LOG_ERROR] + f->log.counts[NEPH_LOG_WARNING], 0);
}

/* The tool stops at types that it does not convert; the first four are double, int32, int64 and vectors. */
static void other_types_are_read(void **state) {
  test_fixture *f = *state;
  char *nvdb = make_path(f->folder, "types", ".nvdb"), *back = make_path(f->folder, "types", ".vdb");
  test_run_command("nanovdb_convert -f %s %s >/dev/null 2>&1; test -s %s", DATA "/types_stream.vdb", nvdb, nvdb);
  convert("", nvdb, back);
  for (size_t g = 0; g < 4; g++) assert_same_grid(f, back, g, nvdb, g);
  free(nvdb);
  free(back);
}

/* The tool writes the values that it takes them for. */
static void quantised_values_are_those_of_the_tool(void **state) {
  static const char *const options[] = {"--fp4", "--fp8", "--fp16", "--fpN", "--fpN -r 0.5", "--fp8 -b"};
  static const char *const types[] = {"fp4", "fp8", "fp16", "fpN", "fpN", "fp8"};
  test_fixture *f = *state;
  char *nvdb = make_path(f->folder, "quantised", ".nvdb"), *back = make_path(f->folder, "back", ".vdb");
  for (size_t i = 0; i < sizeof options / sizeof *options; i++) {
    np_volume_file file;
    convert(options[i], DATA "/blosc.vdb", nvdb);
    convert("", nvdb, back);
    assert_same_grid(f, back, 0, nvdb, 0);
    assert_int_equal(np_volume_file_open(f->context, nvdb, NULL, NULL, &file), NEPH_OK);
    assert_string_equal(np_volume_file_describe(&file, 0).value_type, types[i]);
    np_volume_file_close(&file);
  }
  free(nvdb);
  free(back);
}

/* ---- Densities ---- */

static void assert_same_volume(const test_fixture *f, const char *name, const char *grid, double level_set_voxels) {
  char *paths[2] = {make_path(f->folder, name, ".vdb"), make_path(f->folder, name, ".nvdb")};
  neph_volume *volumes[2];
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  desc.grid = grid;
  desc.level_set_voxels = level_set_voxels;
  desc.precision = NEPH_PRECISION_FLOAT;
  convert("", paths[0], paths[1]);
  for (int i = 0; i < 2; i++) assert_int_equal(neph_volume_load(f->context, paths[i], &desc, &volumes[i]), NEPH_OK);
  for (int n = 0; n < 4000; n++) {
    const double position[3] = {n % 17 - 1.3, n / 17 % 17 - 0.7, n / 289 % 17 - 0.9};
    float values[2];
    for (int i = 0; i < 2; i++) neph_volume_sample(volumes[i], 1, position, &values[i]);
    assert_memory_equal(&values[0], &values[1], sizeof values[0]);
  }
  for (int i = 0; i < 2; i++) {
    neph_volume_release(volumes[i]);
    free(paths[i]);
  }
}

static void level_sets_sums_and_marks_are_those_of_the_vdb(void **state) {
  test_fixture *f = *state;
  assert_same_volume(f, "ball", "surface", 2.0);
  assert_same_volume(f, "mark", "mark", 0.0);
  assert_same_volume(f, "parts", "DENSITY + Smoke + fuel", 0.0);
  assert_same_volume(f, "both", "Smoke", 0.0);
}

static void a_grid_is_chosen_by_name(void **state) {
  test_fixture *f = *state;
  char *vdb = make_path(f->folder, "both", ".vdb"), *nvdb = make_path(f->folder, "both", ".nvdb");
  neph_volume *volume;
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  convert("", vdb, nvdb);
  desc.grid = "soot";
  assert_int_equal(neph_volume_load(f->context, nvdb, &desc, &volume), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, nvdb, "no grid 'soot': found 'Smoke' (float), 'surface' (float, a level set)");
  desc.grid = "surface";
  assert_int_equal(neph_volume_load(f->context, nvdb, &desc, &volume), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, nvdb, "'surface' is a level set, which holds distances");
  free(vdb);
  free(nvdb);
}

/* ---- Pictures ---- */

static neph_image *render(const test_fixture *f, const char *file, const char *integrator) {
  char text[800];
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  char *path = test_path(f->folder, "scene.yaml");
  (void)snprintf(text, sizeof text,
                 "version: 1\n"
                 "camera: {position: [0, -120, 10], look_at: [0, 0, 0], fov: 40 deg, resolution: [16, 12],\n"
                 "  motion_blur: {shutter: 0.5}}\n"
                 "sun: {elevation: 35 deg, azimuth: 120 deg}\n"
                 "atmosphere: none\n"
                 "clouds: [{vdb: %s, velocity: vel, extinction: 0.1}]\n"
                 "render: {integrator: %s, samples: 1}\n",
                 file, integrator);
  assert_int_equal(neph_scene_load_text(f->context, text, path, &scene), NEPH_OK);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  neph_scene_destroy(scene);
  free(path);
  return image;
}

/* A moving ball: density and velocity, by both integrators. */
static void pictures_are_those_of_the_vdb(void **state) {
  static const char *const integrators[] = {"march", "path"};
  static const test_velocity moving = {.names = {"vel"}, .radius = 20.0, .value = 1.0f, .at = {9.0f, 3.0f, -2.0f}};
  test_fixture *f = *state;
  char *vdb = test_path(f->folder, "moving.vdb"), *nvdb = test_path(f->folder, "moving.nvdb");
  test_velocity_write(f->context, vdb, &moving);
  convert("", vdb, nvdb);
  for (int i = 0; i < 2; i++) {
    neph_image *images[2] = {render(f, "moving.vdb", integrators[i]), render(f, "moving.nvdb", integrators[i])};
    for (unsigned c = 0; c < neph_image_get_channel_count(images[0]); c++) {
      const char *name = neph_image_get_channel_name(images[0], c);
      assert_memory_equal(neph_image_get_values(images[0], name), neph_image_get_values(images[1], name),
                          16 * 12 * sizeof(float));
    }
    for (int k = 0; k < 2; k++) neph_image_destroy(images[k]);
  }
  free(vdb);
  free(nvdb);
}

/* ---- Writing ---- */

/* Bakes a field of cumuli to a file: its grids are a density and a velocity. */
static void bake(const test_fixture *f, const char *path, neph_precision precision) {
  neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(f->context, "cumulus_humilis", &cloud), NEPH_OK);
  cloud.extent_m[0] = cloud.extent_m[1] = 1500.0;
  cloud.voxel_m = 40.0;
  cloud.seed = 5;
  desc.file_precision = precision;
  desc.has_velocity = true;
  assert_int_equal(neph_cloud_bake_file(f->context, &cloud, &desc, "density", path), NEPH_OK);
}

/* The same bits as a .vdb of the same bake, in floats and rounded to half; the tool that validates accepts the file,
 * the tool that converts gives the same grids; a rebake from the file's own parameters too. */
static void written_files_hold_what_a_vdb_holds(void **state) {
  const test_fixture *f = *state;
  for (int i = 0; i < 2; i++) {
    const neph_precision precision = i ? NEPH_PRECISION_HALF : NEPH_PRECISION_FLOAT;
    char *vdb = make_path(f->folder, "own", ".vdb"), *nvdb = make_path(f->folder, "own", ".nvdb"),
         *back = make_path(f->folder, "back", ".vdb");
    bake(f, vdb, precision);
    bake(f, nvdb, precision);
    test_run_command("nanovdb_validate %s >/dev/null", nvdb);
    convert("", nvdb, back);
    bool is_same = false;
    assert_int_equal(neph_cloud_verify_file(f->context, nvdb, NULL, NULL, &is_same), NEPH_OK);
    assert_true(is_same);
    for (size_t grid = 0; grid < 2; grid++) {
      assert_same_grid(f, vdb, grid, nvdb, grid);
      assert_same_grid(f, vdb, grid, back, search_grid(f, back, grid ? "vel" : "density"));
    }
    free(vdb);
    free(nvdb);
    free(back);
  }
}

/* A file that cannot be written leaves nothing, neither under its name nor under a temporary one. */
static void a_failed_write_leaves_nothing(void **state) {
  const test_fixture *f = *state;
  char *folder = make_path(f->folder, "none", "/own.nvdb");
  neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
  const neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(f->context, "cumulus_humilis", &cloud), NEPH_OK);
  cloud.extent_m[0] = cloud.extent_m[1] = 500.0;
  cloud.voxel_m = 50.0;
  assert_int_equal(neph_cloud_bake_file(f->context, &cloud, &desc, "density", folder), NEPH_ERROR_IO);
  test_run_command("test -z \"$(find %s -name '*own.nvdb*')\"", f->folder);
  free(folder);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(grids_are_those_of_the_vdb, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(other_types_are_read, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(quantised_values_are_those_of_the_tool, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(level_sets_sums_and_marks_are_those_of_the_vdb, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_grid_is_chosen_by_name, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(pictures_are_those_of_the_vdb, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(written_files_hold_what_a_vdb_holds, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_failed_write_leaves_nothing, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Rules of checks that no other test breaks, a file each. check_rules.sh holds that every rule has such a test. */
#include <nephos/check.h>
#include <nephos/image.h>

#include "test_tools.h"

#include "core/alloc.h"
#include "core/frame_name.h"
#include "volume/volume_private.h"

static int set_up(void **state) { return test_set_up(state, 2, "cloud.vdb"); }

/* ---- Findings ---- */

/* Checks a file afresh: it breaks a rule, with its severity. */
static void assert_breaks(test_fixture *f, const char *path, const char *rule, neph_severity severity) {
  neph_check *check = NULL;
  bool is_found = false;
  assert_int_equal(neph_check_create(f->context, &check), NEPH_OK);
  assert_int_equal(neph_check_file(check, path), NEPH_OK);
  for (size_t i = 0; i < neph_check_get_finding_count(check); i++) {
    neph_finding finding = NEPH_FINDING_DEFAULT;
    assert_int_equal(neph_check_get_finding(check, i, &finding), NEPH_OK);
    is_found = is_found || (!strcmp(finding.rule, rule) && finding.severity == severity);
  }
  char *text = NULL;
  assert_int_equal(neph_check_describe(check, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  if (!is_found) fail_msg("no finding of %s in:\n%s", rule, text);
  neph_text_destroy(f->context, text);
  neph_check_destroy(check);
}

/* ---- Clouds ---- */

/* A block of voxels of 10 m, all of one value, and empty where that is NaN. */
static void make_grid(test_fixture *f, const char *name, float value, np_sparse_grid *grid) {
  assert_int_equal(np_sparse_grid_init(f->context, name, grid), NEPH_OK);
  for (int a = 0; a < 3; a++) grid->index_to_world.m[a][a] = 10.0;
  if (isnan(value)) return;
  np_leaf *leaf = np_sparse_grid_add_leaf(grid, (const int32_t[3]){0, 0, 0});
  assert_non_null(leaf);
  memset(leaf->active, 0xff, sizeof leaf->active);
  for (int n = 0; n < NP_LEAF_SIZE; n++) leaf->values[n] = value;
}

/* Grids of a file, to be changed before they are written. */
typedef struct grid_pair {
  np_sparse_grid at[2];
  size_t count;
} grid_pair;

static grid_pair make_pair(test_fixture *f, const char *first, const char *second, float value) {
  grid_pair pair = {.count = second ? 2 : 1};
  make_grid(f, first, second ? 0.5f : value, &pair.at[0]);
  if (second) make_grid(f, second, value, &pair.at[1]);
  return pair;
}

static void write_pair(test_fixture *f, const char *path, grid_pair *pair) {
  const np_vdb_write_grid outputs[2] = {{.grid = &pair->at[0]}, {.grid = &pair->at[1]}};
  assert_int_equal(np_volume_save_grids(f->context, path, outputs, pair->count, NULL), NEPH_OK);
  for (size_t g = 0; g < pair->count; g++) np_sparse_grid_clear(&pair->at[g]);
}

static void files_of_other_grids_are_found(void **state) {
  static const struct {
    const char *first, *second;
    float value;
    const char *rule;
    neph_severity severity;
  } cases[] = {{"temperature", NULL, 300.0f, "file.no_density", NEPH_SEVERITY_WARNING},
               {"temperature", "fuel", 300.0f, "file.no_density", NEPH_SEVERITY_WARNING},
               {"density", "density", 0.5f, "file.same_names", NEPH_SEVERITY_NOTE},
               {"density", "temperature", NAN, "grid.empty_field", NEPH_SEVERITY_NOTE},
               {"density", NULL, 0.0f, "values.none", NEPH_SEVERITY_WARNING}};
  test_fixture *f = *state;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    grid_pair pair = make_pair(f, cases[i].first, cases[i].second, cases[i].value);
    write_pair(f, f->path, &pair);
    assert_breaks(f, f->path, cases[i].rule, cases[i].severity);
  }
  grid_pair none = {.count = 0};
  write_pair(f, f->path, &none);
  assert_breaks(f, f->path, "file.no_grid", NEPH_SEVERITY_WARNING);
}

/* Temperatures may end in any number, but it must be one. */
static void a_field_that_ends_in_no_number_is_found(void **state) {
  test_fixture *f = *state;
  grid_pair pair = make_pair(f, "density", "temperature", 300.0f);
  pair.at[1].background = INFINITY;
  write_pair(f, f->path, &pair);
  assert_breaks(f, f->path, "values.field_background", NEPH_SEVERITY_ERROR);
}

/* OpenVDB neither writes nor reads voxels without a volume, but it reads those of one beyond all numbers: an edge of
 * 1e308 m is put into the file, in whose header edges are doubles. */
static void voxels_without_a_volume_are_found(void **state) {
  test_fixture *f = *state;
  const double edge = 12345.0, endless = 1e308;
  grid_pair pair = make_pair(f, "density", NULL, 0.5f);
  pair.at[0].index_to_world.m[2][2] = edge;
  write_pair(f, f->path, &pair);
  assert_true(test_file_replace(f->path, &edge, &endless, sizeof edge) > 0);
  assert_breaks(f, f->path, "transform.degenerate", NEPH_SEVERITY_ERROR);
}

/* Files that other programs wrote. */
static void grids_of_other_kinds_are_found(void **state) {
  static const struct {
    const char *file, *rule;
  } cases[] = {
      {"points_stream.vdb", "grid.points"}, {"types_stream.vdb", "grid.class"}, {"frustum.vdb", "transform.frustum"}};
  test_fixture *f = *state;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    char path[1200];
    (void)snprintf(path, sizeof path, NEPHOS_TEST_SOURCE_DIR "/data/vdb/%s", cases[i].file);
    assert_breaks(f, path, cases[i].rule, NEPH_SEVERITY_NOTE);
  }
}

/* The files of write_vdb.py. */
static int set_up_kinds(void **state) {
  test_require_tool("/usr/bin/python3 -c 'import pyopenvdb' >/dev/null 2>&1", "python3-openvdb");
  const int failed = test_set_up(state, 2, "ball.vdb");
  const test_fixture *f = *state;
  char command[1024];
  (void)snprintf(command, sizeof command, "/usr/bin/python3 " NEPHOS_TEST_SOURCE_DIR "/write_vdb.py %s", f->folder);
  return failed ? failed : system(command);
}

static void a_level_set_is_found(void **state) {
  test_fixture *f = *state;
  assert_breaks(f, f->path, "grid.level_set", NEPH_SEVERITY_NOTE);
}

/* The second frame has other voxels, or a box that has moved by far. */
static void changes_within_a_sequence_are_found(void **state) {
  static const char *const rules[] = {"sequence.voxels", "sequence.box"};
  test_fixture *f = *state;
  char *pattern = test_path(f->folder, "frame.####.vdb");
  for (int r = 0; r < 2; r++) {
    for (int number = 1; number <= 2; number++) {
      char *path = np_frame_name_make(f->context, pattern, number);
      grid_pair pair = make_pair(f, "density", NULL, 0.5f);
      for (int a = 0; a < 3 && number == 2 && r == 0; a++) pair.at[0].index_to_world.m[a][a] = 15.0;
      if (number == 2 && r == 1) pair.at[0].index_to_world.m[0][3] = 400.0;
      write_pair(f, path, &pair);
      np_alloc_free(f->context, path);
    }
    assert_breaks(f, pattern, rules[r], NEPH_SEVERITY_WARNING);
  }
  free(pattern);
}

/* ---- Others ---- */

enum { SIDE = 1201 };

/* One void, in a tile whose name gives its place; and rows of numbers with neither place nor unit, whose width the
 * scene states. */
static int eval_hole(unsigned column, unsigned row) {
  return column == 7 && row == 7 ? -32768 : (int)(300 + column % 300 + row);
}

static void lacks_of_heights_are_found(void **state) {
  test_fixture *f = *state;
  char *path = test_hgt_write(f->folder, "N44W072.hgt", SIDE, eval_hole), text[4096] = "ncols 9\nnrows 9\n";
  assert_breaks(f, path, "heights.few_voids", NEPH_SEVERITY_NOTE);
  free(path);
  path = test_path(f->folder, "h.asc");
  (void)strcat(text, "xllcorner 0\nyllcorner 0\ncellsize 30\n");
  for (int i = 0; i < 81; i++) (void)snprintf(text + strlen(text), sizeof text - strlen(text), "%d.5\n", 100 + i * i);
  test_file_write_text(path, text);
  free(path);
  path = test_path(f->folder, "scene.yaml");
  test_file_write_text(path, "version: 1\nterrain: {heightfield: h.asc, width: 1 km}\n");
  if (neph_feature_is_present(f->context, NEPH_FEATURE_GDAL)) {
    assert_breaks(f, path, "heights.place", NEPH_SEVERITY_NOTE);
    assert_breaks(f, path, "heights.unit", NEPH_SEVERITY_NOTE);
  }
  free(path);
}

static void samples_that_are_no_numbers_are_found(void **state) {
  test_fixture *f = *state;
  const char *name = "R";
  neph_image *image = NULL;
  char *path = test_path(f->folder, "picture.exr");
  assert_int_equal(neph_image_create(f->context, 4, 4, 1, &name, &image), NEPH_OK);
  neph_image_get_channel(image, name)[5] = NAN;
  assert_int_equal(neph_image_save_exr(image, path, NEPH_PIXEL_FLOAT), NEPH_OK);
  assert_breaks(f, path, "picture.values", NEPH_SEVERITY_WARNING);
  neph_image_destroy(image);
  free(path);
}

static void a_camera_that_stands_still_is_found(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "still.gltf");
  test_file_write_text(path, "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
                             "\"nodes\":[{\"name\":\"shot\",\"camera\":0,\"translation\":[1,2,3]}],"
                             "\"cameras\":[{\"type\":\"perspective\",\"perspective\":"
                             "{\"yfov\":0.7,\"znear\":0.1,\"aspectRatio\":1.5}}]}");
  neph_check *check = NULL;
  assert_int_equal(neph_check_create(f->context, &check), NEPH_OK);
  assert_int_equal(neph_check_file(check, path), NEPH_OK);
  const bool is_read = neph_check_count(check, NEPH_SEVERITY_ERROR) == 0;
  neph_check_destroy(check);
  if (is_read) assert_breaks(f, path, "camera.still", NEPH_SEVERITY_NOTE); /* not in a build without Assimp */
  free(path);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(files_of_other_grids_are_found),
      TEST(a_field_that_ends_in_no_number_is_found),
      TEST(voxels_without_a_volume_are_found),
      TEST(grids_of_other_kinds_are_found),
      cmocka_unit_test_setup_teardown(a_level_set_is_found, set_up_kinds, test_tear_down),
      TEST(changes_within_a_sequence_are_found),
      TEST(lacks_of_heights_are_found),
      TEST(samples_that_are_no_numbers_are_found),
      TEST(a_camera_that_stands_still_is_found)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}

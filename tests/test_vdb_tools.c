/* SPDX-License-Identifier: Apache-2.0 */
/* Whether what a bake writes opens elsewhere: OpenVDB's own command line, vdb_print, and its Python module read a file,
 * and find the values and the metadata that were written. Both are Debian's packages; where a tool is missing the test
 * says so and is skipped, but not by tests/run.sh, which installs them. */
#include "test_tools.h"

#include <stdlib.h>

#include "cloud/bake_field.h"
#include "cloud/bake_grid.h"
#include "cloud/bake_velocity.h"

typedef struct fixture {
  neph_context *context;
  char *folder, *path;
  np_bake bake;
  np_sparse_grid density, velocity[3];
} fixture;

static neph_cloud_desc small_field(void) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  desc.seed = 18446744073709551615u;
  desc.extent_m[0] = desc.extent_m[1] = 1500;
  desc.voxel_m = 75;
  desc.center_m[0] = 250;
  desc.coverage = 0.6;
  desc.wind_m_s[0] = 6;
  desc.wind_m_s[1] = -2.5;
  return desc;
}

/* A file of two levels and a velocity, and the same in memory. */
static int set_up(void **state) {
  fixture *f = calloc(1, sizeof *f);
  const neph_cloud_desc cloud = small_field();
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  np_monitor monitor;
  f->context = test_context_create(2, NULL);
  f->folder = test_folder_create();
  f->path = test_path(f->folder, "cloud.vdb");
  desc.level_count = 2;
  desc.has_velocity = true;
  assert_int_equal(neph_cloud_bake_file(f->context, &cloud, &desc, "density", f->path), NEPH_OK);
  assert_int_equal(np_bake_start_checked(f->context, &cloud, &desc, NP_BAKE_FOR_FILE, &monitor, &f->bake), NEPH_OK);
  assert_int_equal(np_bake_make_grid(&f->bake, "density", &f->density), NEPH_OK);
  assert_int_equal(np_bake_make_velocity(&f->bake, &f->density, f->velocity), NEPH_OK);
  *state = f;
  return 0;
}

static int tear_down(void **state) {
  fixture *f = *state;
  for (int a = 0; a < 3; a++) np_sparse_grid_clear(&f->velocity[a]);
  np_sparse_grid_clear(&f->density);
  np_bake_end(&f->bake);
  free(f->path);
  test_folder_destroy(f->folder);
  neph_context_destroy(f->context);
  free(f);
  return 0;
}

/* Skips unless `command` succeeds; fails where tools are required. */
/* Output of a command, which must succeed; to be freed. */
static char *run(const char *command, const char *argument) {
  char *line = NULL, *text = NULL;
  size_t size = 0;
  assert_true(asprintf(&line, "%s '%s'", command, argument) > 0);
  FILE *output = popen(line, "r");
  assert_non_null(output);
  FILE *copy = open_memstream(&text, &size);
  for (int c; (c = fgetc(output)) != EOF;) fputc(c, copy);
  fclose(copy);
  assert_int_equal(pclose(output), 0);
  free(line);
  return text;
}

static void assert_says(const char *text, const char *words) {
  if (!strstr(text, words)) fail_msg("'%s' is not in:\n%.4000s", words, text);
}

static void vdb_print_lists_the_grids(void **state) {
  fixture *f = *state;
  char expected[128];
  test_require_tool("vdb_print -version >/dev/null 2>&1", "libopenvdb-tools");
  char *text = run("vdb_print -l -m", f->path);
  static const char *const words[] = {"Name: density\n",
                                      "Name: density_2\n",
                                      "Name: vel\n",
                                      "Type: Tree_float_5_4_3",
                                      "Type: Tree_vec3s_5_4_3",
                                      "class: fog volume",
                                      "class: unknown",
                                      "creator: nephos",
                                      "nephos:seed: 18446744073709551615",
                                      "nephos:params: {",
                                      "\"voxel_m\": 75.0",
                                      "nephos:hash: ",
                                      "units: 1/m",
                                      "units: m/s",
                                      "nephos:extinction_per_value: 1\n",
                                      "vector_type: contravariant relative",
                                      "is_local_space: false",
                                      "is_saved_as_half_float: false"};
  for (size_t i = 0; i < sizeof words / sizeof *words; i++) assert_says(text, words[i]);
  snprintf(expected, sizeof expected, "file_voxel_count: %llu\n",
           (unsigned long long)np_sparse_grid_count_active(&f->density));
  assert_says(text, expected);
  assert_says(text, "voxel size: 75\n");
  free(text);
}

/* ---- Values, by OpenVDB's Python module ---- */

/* Value of an active voxel in memory; NaN, which is near to nothing, when there is none. */
static double get_value(const np_sparse_grid *grid, const int at[3]) {
  for (size_t l = 0; l < grid->leaf_count; l++) {
    int offset = 0;
    bool is_inside = true;
    for (int a = 0; a < 3; a++) {
      const int local = at[a] - grid->leaves[l].origin[a];
      is_inside = is_inside && local >= 0 && local < NP_LEAF_EDGE;
      offset = offset * NP_LEAF_EDGE + local;
    }
    if (is_inside && grid->leaves[l].active[offset / 64] >> (offset % 64) & 1u)
      return (double)grid->leaves[l].values[offset];
  }
  return (double)NAN;
}

/* One line "voxel GRID I J K X [Y Z]": the very floats, for Python prints all their digits. */
static bool check_voxel(const fixture *f, const char *line, uint64_t counts[2]) {
  char name[32];
  int at[3];
  double values[3] = {0, 0, 0};
  const int fields =
      sscanf(line, "voxel %31s %d %d %d %lf %lf %lf", name, &at[0], &at[1], &at[2], &values[0], &values[1], &values[2]);
  if (fields < 5) return false;
  const bool is_velocity = !strcmp(name, "vel");
  assert_int_equal(fields, is_velocity ? 7 : 5);
  if (!is_velocity && strcmp(name, "density") != 0) return true;
  for (int c = 0; c < fields - 4; c++)
    assert_near(values[c], get_value(is_velocity ? &f->velocity[c] : &f->density, at), 0);
  counts[is_velocity]++;
  return true;
}

static void python_reads_the_same_values(void **state) {
  fixture *f = *state;
  test_require_tool("/usr/bin/python3 -c 'import pyopenvdb' >/dev/null 2>&1", "python3-openvdb");
  char *text = run("/usr/bin/python3 " NEPHOS_TEST_SOURCE_DIR "/read_vdb.py", f->path);
  const np_affine *transform = &f->density.index_to_world;
  char expected[128];
  static const char *const facts[] = {"type density float\n",
                                      "type density_2 float\n",
                                      "type vel vec3s\n",
                                      "voxel_size density 75.0 75.0 75.0\n",
                                      "voxel_size density_2 150.0 150.0 150.0\n",
                                      "background density 0.0\n",
                                      "background vel 6.0 -2.5 0.0\n",
                                      "meta density class fog volume\n",
                                      "meta density nephos:extinction_per_value 1.0\n"};
  for (size_t i = 0; i < sizeof facts / sizeof *facts; i++) assert_says(text, facts[i]);
  snprintf(expected, sizeof expected, "origin density %.1f %.1f %.1f\n", transform->m[0][3], transform->m[1][3],
           transform->m[2][3]);
  assert_says(text, expected);
  uint64_t counts[2] = {0, 0};
  for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) check_voxel(f, line, counts);
  assert_int_equal(counts[0], np_sparse_grid_count_active(&f->density));
  assert_int_equal(counts[1], np_sparse_grid_count_active(&f->velocity[0]));
  free(text);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(vdb_print_lists_the_grids, set_up, tear_down),
      cmocka_unit_test_setup_teardown(python_reads_the_same_values, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Mended copies of .nvdb files: their grids are those of the mended copies of .vdb files with the same faults. */
#include "test_tools.h"

#include <stdlib.h>

#include <nephos/nephos.h>

#include "volume/volume_file.h"

#define DATA NEPHOS_TEST_SOURCE_DIR "/data/vdb"

static int set_up(void **state) {
  test_require_tool("nanovdb_validate --version >/dev/null 2>&1 || nanovdb_convert --version >/dev/null 2>&1",
                    "libnanovdb-tools");
  return test_set_up(state, 2, "cloud.nvdb");
}

/* ---- Files ---- */

enum { LEAVES = 3, COMPONENTS = 3 };

/* Leaves along x, with inactive voxels, and an active tile behind them. */
static void make_grid(const test_fixture *f, const char *name, np_sparse_grid *grid) {
  assert_int_equal(np_sparse_grid_init(f->context, name, grid), NEPH_OK);
  for (int i = 0; i < LEAVES; i++) {
    np_leaf *leaf = np_sparse_grid_add_leaf(grid, (const int32_t[3]){8 * i, 0, 0});
    assert_non_null(leaf);
    memset(leaf->active, 0x7f, sizeof leaf->active);
    for (int n = 0; n < NP_LEAF_SIZE; n++) leaf->values[n] = n % 8 == 7 ? 0.0f : 0.5f + (float)(n % 7) / 14.0f;
  }
  assert_non_null(np_sparse_grid_add_tile(grid, (const int32_t[3]){0, 8, 0}, 8, 0.75f, true));
}

static void put_faults(np_sparse_grid *grid) {
  static const float bad[] = {NAN, -3.0f, INFINITY, -0.0f, 1e-40f, -INFINITY};
  grid->background = 0.25f;
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) grid->leaves[1].values[16 + i] = bad[i];
  grid->leaves[0].values[15] = INFINITY; /* not active */
  grid->leaves[2].values[23] = 0.25f;    /* not active, the background's */
  grid->tiles[0].value = NAN;
}

typedef struct grids {
  np_sparse_grid density, heat, speed[COMPONENTS];
} grids;

static void make_grids(const test_fixture *f, grids *g) {
  make_grid(f, "density", &g->density);
  make_grid(f, "temperature", &g->heat);
  for (int k = 0; k < COMPONENTS; k++) make_grid(f, "vel", &g->speed[k]);
  put_faults(&g->density);
  g->heat.background = 300.0f;
  g->heat.leaves[0].values[0] = INFINITY;
  g->speed[0].leaves[0].values[5] = NAN;
  g->speed[2].leaves[0].values[5] = -INFINITY;
  g->speed[1].leaves[2].values[7] = -4.0f;
  g->speed[1].tiles[0].value = INFINITY;
}

static void save(const test_fixture *f, const char *path, const grids *g, bool is_half) {
  const np_vdb_attribute attributes[] = {{.name = "units", .text = "1/m"}, {.name = "nephos:extinction", .number = 2}};
  const np_vdb_write_grid outputs[] = {
      {.grid = &g->density, .is_half = is_half, .attributes = attributes, .attribute_count = 2},
      {.grid = &g->heat},
      {.grid = &g->speed[0], .y = &g->speed[1], .z = &g->speed[2]}};
  assert_int_equal(np_volume_save_grids(f->context, path, outputs, 3, NULL), NEPH_OK);
}

static void clear_grids(grids *g) {
  np_sparse_grid_clear(&g->density);
  np_sparse_grid_clear(&g->heat);
  for (int k = 0; k < COMPONENTS; k++) np_sparse_grid_clear(&g->speed[k]);
}

static void hash(const test_fixture *f, const char *path, size_t index, int component, char out_hash[33]) {
  np_volume_file file;
  np_sparse_grid grid = {0};
  const np_sparse_grid *all[] = {&grid};
  uint64_t bytes;
  assert_int_equal(np_volume_file_open(f->context, path, NULL, NULL, &file), NEPH_OK);
  assert_int_equal(np_volume_file_read_component(&file, index, component, &grid, &bytes), NEPH_OK);
  assert_int_equal(np_sparse_grid_hash_all(all, 1, false, out_hash), NEPH_OK);
  np_sparse_grid_clear(&grid);
  np_volume_file_close(&file);
}

static void assert_same_grid(const test_fixture *f, const char *a, const char *b, size_t index, int component) {
  char hashes[2][33];
  hash(f, a, index, component, hashes[0]);
  hash(f, b, index, component, hashes[1]);
  assert_string_equal(hashes[0], hashes[1]);
}

static char *describe(const test_fixture *f, const char *path) {
  char *text;
  assert_int_equal(neph_volume_describe_file(f->context, path, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  return text;
}

/* ---- Copies ---- */

static void mend(const test_fixture *f, const char *from, const char *to, char **out_text) {
  assert_int_equal(neph_check_mend_file(f->context, from, to, out_text), NEPH_OK);
}

/* Both formats: the same changes, the same grids; metadata stay, and NanoVDB's own tool accepts the copy. */
static void copies_are_those_of_a_vdb(void **state) {
  test_fixture *f = *state;
  char *vdb = test_path(f->folder, "a.vdb"), *vdb_copy = test_path(f->folder, "b.vdb"),
       *copy = test_path(f->folder, "b.nvdb"), *texts[2];
  grids g = {0};
  make_grids(f, &g);
  save(f, vdb, &g, false);
  save(f, f->path, &g, false);
  mend(f, vdb, vdb_copy, &texts[0]);
  mend(f, f->path, copy, &texts[1]);
  assert_string_equal(texts[0], texts[1]);
  assert_non_null(strstr(texts[1], "grid 'density': 8 values mended, background made 0\n"));
  assert_non_null(strstr(texts[1], "grid 'vel': 2 values mended\n"));
  for (size_t i = 0; i < 3; i++)
    for (int k = 0; k < (i == 2 ? COMPONENTS : 1); k++) assert_same_grid(f, vdb_copy, copy, i, k);
  for (int i = 0; i < 2; i++) neph_text_destroy(f->context, texts[i]);
  texts[0] = describe(f, copy);
  assert_non_null(strstr(texts[0], "units"));
  assert_non_null(strstr(texts[0], "nephos:extinction"));
  neph_text_destroy(f->context, texts[0]);
  test_run_command("nanovdb_validate %s >/dev/null", copy);
  neph_volume *volume;
  assert_int_equal(neph_volume_load(f->context, copy, NULL, &volume), NEPH_OK);
  neph_volume_release(volume);
  assert_int_equal(f->log.counts[NEPH_LOG_ERROR] + f->log.counts[NEPH_LOG_WARNING], 0);
  clear_grids(&g);
  free(vdb);
  free(vdb_copy);
  free(copy);
}

/* A sound file is copied to the bit, values rounded to half too. */
static void sound_grids_stay(void **state) {
  test_fixture *f = *state;
  char *copy = test_path(f->folder, "b.nvdb"), *text;
  grids g = {0};
  make_grid(f, "density", &g.density);
  make_grid(f, "temperature", &g.heat);
  for (int k = 0; k < COMPONENTS; k++) make_grid(f, "vel", &g.speed[k]);
  save(f, f->path, &g, true);
  mend(f, f->path, copy, &text);
  assert_string_equal(text, "  grid 'density': 0 values mended, unchanged\n"
                            "  grid 'temperature': 0 values mended, unchanged\n"
                            "  grid 'vel': 0 values mended, unchanged\n");
  const test_file files[] = {test_file_read(f->path), test_file_read(copy)};
  assert_int_equal(files[0].size, files[1].size);
  for (size_t i = 0; i < 3; i++) assert_same_grid(f, f->path, copy, i, 0);
  for (int i = 0; i < 2; i++) free(files[i].bytes);
  neph_text_destroy(f->context, text);
  clear_grids(&g);
  free(copy);
}

/* Files of NanoVDB's tool: compressed ones, level sets, which keep their class, and quantised values. */
static void files_of_the_tool_are_copied(void **state) {
  static const char *const options[] = {"-z", "-b", "--fp8", "--fpN"};
  test_fixture *f = *state;
  char *copy = test_path(f->folder, "b.nvdb");
  test_require_tool("nanovdb_convert --version >/dev/null 2>&1", "libnanovdb-tools");
  for (size_t i = 0; i < sizeof options / sizeof *options; i++) {
    test_run_command("nanovdb_convert -f %s " DATA "/blosc.vdb %s", options[i], f->path);
    mend(f, f->path, copy, NULL);
    assert_same_grid(f, f->path, copy, 0, 0);
    if (options[i][1] == '-') assert_one_warning(&f->log, "grid 'odd' is of type fp", "its copy of floats");
  }
  test_run_command("/usr/bin/python3 " NEPHOS_TEST_SOURCE_DIR "/write_vdb.py %s", f->folder);
  test_run_command("nanovdb_convert -f %s/ball.vdb %s", f->folder, f->path);
  mend(f, f->path, copy, NULL);
  assert_same_grid(f, f->path, copy, 0, 0);
  char *text = describe(f, copy);
  assert_non_null(strstr(text, "level set"));
  neph_text_destroy(f->context, text);
  free(copy);
}

/* ---- Refusals ---- */

static void what_cannot_be_copied_is_refused(void **state) {
  test_fixture *f = *state;
  char *copy = test_path(f->folder, "b.nvdb"), *other = test_path(f->folder, "b.vdb");
  test_run_command("nanovdb_convert -f " DATA "/types_stream.vdb %s >/dev/null 2>&1; test -s %s", f->path, f->path);
  assert_int_equal(neph_check_mend_file(f->context, f->path, copy, NULL), NEPH_ERROR_UNSUPPORTED);
  assert_one_error(&f->log, f->path, "is of type double", "floats and vectors of three floats alone");
  test_run_command("test ! -e %s", copy);
  test_run_command("nanovdb_convert -f " DATA "/blosc.vdb %s", f->path);
  assert_int_equal(neph_check_mend_file(f->context, f->path, f->path, NULL), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, f->path, "must be another");
  assert_int_equal(neph_check_mend_file(f->context, f->path, other, NULL), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, other, "must end in .nvdb");
  const test_file file = test_file_read(f->path);
  test_file_write(f->path, file.bytes, file.size - 100);
  assert_int_equal(neph_check_mend_file(f->context, f->path, copy, NULL), NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, f->path, "truncated");
  test_run_command("test ! -e %s", copy);
  free(file.bytes);
  free(copy);
  free(other);
}

static neph_result attempt(neph_context *context, void *user) {
  char *copy = test_path(user, "b.nvdb"), *path = test_path(user, "cloud.nvdb");
  const neph_result result = neph_check_mend_file(context, path, copy, NULL);
  free(copy);
  free(path);
  return result;
}

static void memory_may_run_out_anywhere(void **state) {
  test_fixture *f = *state;
  grids g = {0};
  make_grids(f, &g);
  save(f, f->path, &g, false);
  clear_grids(&g);
  assert_survives_failed_allocations(attempt, f->folder);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(copies_are_those_of_a_vdb, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(sound_grids_stay, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(files_of_the_tool_are_copied, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(what_cannot_be_copied_is_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(memory_may_run_out_anywhere, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

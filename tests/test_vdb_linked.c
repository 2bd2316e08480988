/* SPDX-License-Identifier: Apache-2.0 */
/* OpenVDB linked into the program in place of the module, and what it does without memory. */
#include "test_grids.h"

#include <stdlib.h>

#include "operator_new.h"

static void a_program_can_do_without_the_module(void **state) {
  (void)state;
  char *folder = test_folder_create(), *path = test_path(folder, "cloud.vdb");
  neph_context *context = test_context_create(1, NULL);
  const np_vdb_module *module;
  np_sparse_grid grid;
  neph_volume *volume;
  assert_int_equal(np_vdb_module_get(context, &module), NEPH_OK);
  assert_ptr_equal(module, nephos_vdb_module());
  test_make_grid(context, 1, 2, &grid);
  const np_vdb_write_grid output = {.grid = &grid};
  assert_int_equal(np_volume_save_grids(context, path, &output, 1, NULL), NEPH_OK);
  assert_int_equal(neph_volume_load(context, path, NULL, &volume), NEPH_OK);
  assert_int_equal(volume->active_voxel_count, np_sparse_grid_count_active(&grid));
  neph_volume_release(volume);
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
  free(path);
  test_folder_destroy(folder);
}

typedef struct vdb_files {
  neph_context *context;
  test_log *log;
  const np_vdb_write_grid *output;
  const char *path;
} vdb_files;

static neph_result save(const vdb_files *files) {
  return np_volume_save_grids(files->context, files->path, files->output, 1, NULL);
}

static neph_result load(const vdb_files *files) {
  neph_volume *volume;
  const neph_result result = neph_volume_load(files->context, files->path, NULL, &volume);
  neph_volume_release(volume);
  return result;
}

/* Has memory for 0, 1, 2, … allocations until `work` succeeds; returns that number. */
static int count_allocations(neph_result (*work)(const vdb_files *), const vdb_files *files) {
  for (int count = 0; count < 100000; count++) {
    test_operator_new_limit(count);
    const neph_result result = work(files);
    test_operator_new_limit(TEST_ALLOCATIONS_ALL);
    if (result == NEPH_OK) {
      test_log_clear(files->log);
      return count;
    }
    assert_one_error(files->log, "out of memory");
    assert_int_equal(result, NEPH_ERROR_OUT_OF_MEMORY);
  }
  fail_msg("no success with memory for a hundred thousand allocations");
  return 0;
}

/* Each failure unwinds through trees that are half built. OpenVDB ends the process where its destructors allocate. */
static void openvdb_may_run_out_of_memory_anywhere(void **state) {
  (void)state;
  char *folder = test_folder_create(), *path = test_path(folder, "cloud.vdb");
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  np_sparse_grid grid;
  test_make_grid(context, 1, 2, &grid);
  const np_vdb_write_grid output = {.grid = &grid};
  const vdb_files files = {context, &log, &output, path};
  assert_int_equal(save(&files), NEPH_OK); /* what is set up once may not fail */
  assert_true(count_allocations(save, &files) > 20);
  assert_true(count_allocations(load, &files) > 20);
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
  free(path);
  test_folder_destroy(folder);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(a_program_can_do_without_the_module),
                                     cmocka_unit_test(openvdb_may_run_out_of_memory_anywhere)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}

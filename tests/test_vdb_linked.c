/* SPDX-License-Identifier: Apache-2.0 */
/* OpenVDB linked into the program in place of the module. */
#include "test_grids.h"

#include <stdlib.h>

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

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(a_program_can_do_without_the_module)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}

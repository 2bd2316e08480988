/* SPDX-License-Identifier: Apache-2.0 */
/* NetCDF files that hold no cloud, or a broken one: each is refused with one message that names the file, the variable,
 * what is there and what is allowed. */
#include "test_models.h"

#include <sys/stat.h>
#include <unistd.h>

#include <nephos/nephos.h>

static int set_up(void **state) { return test_set_up(state, 2, "broken.nc"); }

/* Writes a file of the classic format: one of HDF5 takes a process to open. */
static void write_plain(const test_fixture *f, const char *model) {
  static const model_file plain = {.levels = LEVELS_EVEN, .step_count = 2};
  model_case classic = *model_get_case(model);
  classic.mode = 0;
  model_write(f->path, &classic, &plain);
}

#define assert_refused(f, desc, ...)                                                                                   \
  do {                                                                                                                 \
    neph_volume *refused_;                                                                                             \
    assert_int_not_equal(neph_volume_load((f)->context, (f)->path, desc, &refused_), NEPH_OK);                         \
    assert_null(refused_);                                                                                             \
    assert_one_error(&(f)->log, "broken.nc: ", __VA_ARGS__);                                                           \
    test_log_clear(&(f)->log);                                                                                         \
  } while (0)

/* ---- Changes of a good file ---- */

static int reopen(const test_fixture *f) {
  int id;
  forge_check(nc_open(f->path, NC_WRITE, &id));
  return id;
}

static int search(int id, const char *name) {
  int variable;
  forge_check(nc_inq_varid(id, name, &variable));
  return variable;
}

static void set_text(const test_fixture *f, const char *variable, const char *attribute, const char *text) {
  const int id = reopen(f);
  const int status = nc_redef(id);
  if (status != NC_EINDEFINE) forge_check(status);
  forge_check(nc_put_att_text(id, search(id, variable), attribute, strlen(text), text));
  forge_check(nc_close(id));
}

static void set_value(const test_fixture *f, const char *variable, const size_t *index, double value) {
  const int id = reopen(f);
  forge_check(nc_put_var1_double(id, search(id, variable), index, &value));
  forge_check(nc_close(id));
}

/* One level a metre below the level before it: faces halfway between levels still ascend. */
static void levels_that_turn_back_are_refused(void **state) {
  test_fixture *f = *state;
  static const size_t before = 1, turned = 2;
  double height;
  write_plain(f, "MicroHH");
  const int id = reopen(f);
  forge_check(nc_get_var1_double(id, search(id, "z"), &before, &height));
  forge_check(nc_close(id));
  set_value(f, "z", &turned, height - 1.0);
  assert_refused(f, NULL, "heights of levels do not ascend");
}

static void packing_by_a_text_is_refused(void **state) {
  test_fixture *f = *state;
  write_plain(f, "MicroHH");
  set_text(f, "ql", "scale_factor", "two");
  assert_refused(f, NULL, "variable 'ql' has the text 'two' as scale_factor", "must be a number");
}

static void integers_without_a_sign_are_refused(void **state) {
  test_fixture *f = *state;
  write_plain(f, "MicroHH");
  set_text(f, "ql", "_Unsigned", "true");
  assert_refused(f, NULL, "variable 'ql' holds integers without a sign", "ushort or ubyte");
}

static void units_are_refused_by_name(void **state) {
  test_fixture *f = *state;
  write_plain(f, "MicroHH");
  set_text(f, "ql", "units", "m s-1");
  assert_refused(f, NULL, "variable 'ql', the liquid water, has units 'm s-1', must be a mixing ratio (kg kg-1, g/kg)",
                 "content (kg m-3, g m-3)");
  set_text(f, "ql", "units", "furlongs");
  assert_refused(f, NULL, "'ql'", "'furlongs'");
  set_text(f, "ql", "units", "g/kg");
  set_text(f, "x", "units", "K");
  assert_refused(f, NULL, "axis 'x' has units 'K', must be a length (m, km) or an angle");
  set_text(f, "x", "units", "m");
  set_text(f, "z", "units", "1");
  assert_refused(f, NULL, "axis 'z' has units '1', must be a length (m, km) or a pressure (Pa, hPa)");
}

static void a_unit_of_air_is_left_out(void **state) {
  test_fixture *f = *state;
  neph_volume *volume;
  write_plain(f, "PALM");
  set_text(f, "hyp", "units", "K");
  assert_int_equal(neph_volume_load(f->context, f->path, NULL, &volume), NEPH_OK);
  assert_one_warning(&f->log, "variable 'hyp' is left out: its units 'K' are not a pressure (Pa, hPa, mb)");
  neph_volume_release(volume);
}

static void axes_are_refused(void **state) {
  test_fixture *f = *state;
  write_plain(f, "MicroHH");
  set_value(f, "x", (const size_t[]){5}, 300.0);
  assert_refused(f, NULL, "axis 'x' is not monotonic: 450 m at index 4 is followed by 300 m");
  set_value(f, "x", (const size_t[]){5}, 600.0);
  assert_refused(f, NULL, "axis 'x' is uneven: 150 m between indices 4 and 5, 100 m in the mean");
  set_value(f, "x", (const size_t[]){5}, NAN);
  assert_refused(f, NULL, "axis 'x' is -inf at index 5, must be a finite length");
  set_value(f, "x", (const size_t[]){5}, 550.0);
  set_value(f, "z", (const size_t[]){3}, 1e4);
  assert_refused(f, NULL, "heights of levels do not ascend");
  set_value(f, "z", (const size_t[]){3}, NAN);
  assert_refused(f, NULL, "heights of levels do not ascend");
}

static void water_is_refused(void **state) {
  test_fixture *f = *state;
  neph_volume *volume;
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  write_plain(f, "MicroHH");
  set_value(f, "ql", (const size_t[]){0, 3, 4, 5}, NAN);
  assert_refused(f, NULL, "variable 'ql' is NaN or infinite at level 3, row 4, column 5", "clouds[].import: repair");
  desc.policy = NEPH_IMPORT_REPAIR;
  assert_int_equal(neph_volume_load(f->context, f->path, &desc, &volume), NEPH_OK);
  neph_volume_release(volume);
  set_value(f, "ql", (const size_t[]){0, 3, 4, 5}, 1e6);
  assert_refused(f, NULL, "variable 'ql' is 1e+06 at level 3, row 4, column 5", "below 1000");
  desc.model.step = 3.0;
  assert_refused(f, &desc, "step 3 is not there, must be within 1 to 2");
  desc.model.step = 1.0;
  desc.model.variable = "cloud";
  assert_refused(f, &desc, "has no variable 'cloud', which clouds[].netcdf names for liquid water");
  desc.model.variable = "z";
  assert_refused(f, &desc, "variable 'z', the liquid water, has units 'm'");
}

static void negative_water_is_counted(void **state) {
  test_fixture *f = *state;
  neph_volume *volume;
  write_plain(f, "MicroHH");
  set_value(f, "ql", (const size_t[]){0, 0, 0, 0}, -1e-3);
  assert_int_equal(neph_volume_load(f->context, f->path, NULL, &volume), NEPH_OK);
  assert_one_warning(&f->log, "1 negative values of water", "are taken as 0");
  neph_volume_release(volume);
}

/* ---- Files ---- */

static void fill_values_alone_are_refused(void **state) {
  test_fixture *f = *state;
  forge g = forge_create(f->path, NC_NETCDF4);
  const int dimensions[3] = {forge_dimension(&g, "z", 4), forge_dimension(&g, "y", 4), forge_dimension(&g, "x", 4)};
  static const char *const names[3] = {"z", "y", "x"};
  int variable;
  for (int d = 0; d < 3; d++) {
    double *values = forge_alloc(4);
    for (int i = 0; i < 4; i++) values[i] = 10.0 * i;
    forge_variable(&g, names[d], NC_FLOAT, 1, &dimensions[d], "m", values);
  }
  forge_check(nc_def_var(g.id, "ql", NC_FLOAT, 3, dimensions, &variable));
  forge_text(&g, variable, "units", "kg/kg");
  forge_close(&g);
  assert_refused(f, NULL, "variable 'ql' holds fill values alone at step 1");
}

static void huge_dimensions_are_refused(void **state) {
  static const char *const names[3] = {"z", "y", "x"};
  static const size_t sizes[3] = {1000, 100000, 100000};
  test_fixture *f = *state;
  forge g = forge_create(f->path, NC_NETCDF4);
  int dimensions[3], variable;
  for (int d = 0; d < 3; d++) dimensions[d] = forge_dimension(&g, names[d], sizes[d]);
  forge_check(nc_def_var(g.id, "ql", NC_FLOAT, 3, dimensions, &variable));
  forge_check(nc_def_var_chunking(g.id, variable, NC_CHUNKED, (const size_t[]){16, 16, 16}));
  forge_text(&g, variable, "units", "kg/kg");
  forge_close(&g);
  assert_refused(f, NULL, "variable 'ql' is of 100000 x 100000 x 1000 values, more than a file of");
}

static void strange_dimensions_are_refused(void **state) {
  test_fixture *f = *state;
  forge g = forge_create(f->path, 0);
  const int dimensions[3] = {forge_dimension(&g, "z", 4), forge_dimension(&g, "spin", 4), forge_dimension(&g, "x", 4)};
  const int variable = forge_variable(&g, "clw", NC_FLOAT, 3, dimensions, "kg m-3", forge_alloc(64));
  forge_text(&g, variable, "standard_name", "mass_concentration_of_cloud_liquid_water_in_air");
  forge_close(&g);
  assert_refused(f, NULL, "dimension 'spin' of variable 'clw' is along neither height, y, x nor time");
}

static void positions_are_needed(void **state) {
  static const char *const names[3] = {"z", "y", "x"};
  test_fixture *f = *state;
  forge g = forge_create(f->path, 0);
  int dimensions[3];
  for (int d = 0; d < 3; d++) dimensions[d] = forge_dimension(&g, names[d], 4);
  forge_variable(&g, "ql", NC_FLOAT, 3, dimensions, "kg/kg", forge_alloc(64));
  forge_close(&g);
  assert_refused(f, NULL, "has no positions along y");
}

static void dry_files_are_refused(void **state) {
  test_fixture *f = *state;
  forge g = forge_create(f->path, 0);
  const int dimension = forge_dimension(&g, "x", 4);
  forge_variable(&g, "u", NC_FLOAT, 1, &dimension, "m/s", forge_alloc(4));
  forge_variable(&g, "w", NC_FLOAT, 1, &dimension, "m/s", forge_alloc(4));
  forge_close(&g);
  assert_refused(f, NULL, "has no variable of liquid water or ice", "clouds[].netcdf.variable", "(u, w)");
}

static void text_is_refused(void **state) {
  test_fixture *f = *state;
  test_file_write_text(f->path, "# An isolated cloud\n2,2,4,0.00675,12.521\n");
  assert_refused(f, NULL, "not a NetCDF file");
}

/* Whatever is cut off, the file is read or refused with one message: never half a cloud without one. */
static void truncated_files_are_refused(void **state) {
  static const char *const models[] = {"DALES", "PALM", "MicroHH"};
  test_fixture *f = *state;
  for (size_t i = 0; i < sizeof models / sizeof *models; i++)
    for (int eighth = 0; eighth < 8; eighth++) {
      struct stat status;
      neph_volume *volume;
      write_plain(f, models[i]);
      assert_int_equal(stat(f->path, &status), 0);
      assert_int_equal(truncate(f->path, status.st_size * eighth / 8), 0);
      test_log_clear(&f->log);
      const neph_result result = neph_volume_load(f->context, f->path, NULL, &volume);
      if (result != NEPH_ERROR_BAD_FILE) print_message("%s cut to %d/8: %s", models[i], eighth, f->log.text);
      assert_int_equal(result, NEPH_ERROR_BAD_FILE);
      assert_one_error(&f->log, "broken.nc: ");
    }
}

static neph_result load_once(neph_context *context, const char *path) {
  neph_volume *volume;
  const neph_result result = neph_volume_load(context, path, NULL, &volume);
  neph_volume_release(volume);
  return result;
}

/* Heads of both kinds of file, and the attributes and positions behind them. */
static void changed_bytes_are_survived(void **state) {
  test_fixture *f = *state;
  write_plain(f, "DALES");
  assert_survives_changed_bytes(f, 1200, 150, load_once);
  write_plain(f, "MicroHH");
  assert_survives_changed_bytes(f, 8000, 150, load_once);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(units_are_refused_by_name, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(levels_that_turn_back_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(integers_without_a_sign_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(packing_by_a_text_is_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_unit_of_air_is_left_out, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(axes_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(water_is_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(negative_water_is_counted, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(fill_values_alone_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(huge_dimensions_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(strange_dimensions_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(positions_are_needed, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(dry_files_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(text_is_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(truncated_files_are_refused, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(changed_bytes_are_survived, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

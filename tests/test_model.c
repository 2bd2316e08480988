/* SPDX-License-Identifier: Apache-2.0 */
/* Fields of atmospheric models in NetCDF: a ball of known water in the convention of each model, its columns of water
 * and optical depth against sums of the formula. */
#include "test_models.h"

#include <nephos/nephos.h>

#include "core/context_private.h"
#include "core/units.h"
#include "volume/volume_private.h"

static int set_up(void **state) { return test_set_up(state, 2, "field.nc"); }

/* ---- Columns ---- */

typedef struct columns {
  double values[MODEL_Y][MODEL_X]; /* integral along each column */
  double first_m[3], step_m[3];
  uint64_t active_count;
} columns;

static neph_result load_grid(const test_fixture *f, const neph_volume_load_desc *desc, np_sparse_grid *grid) {
  bool has_content;
  return np_volume_load_grid(f->context, f->path, desc, NULL, grid, &has_content);
}

static columns load_columns(const test_fixture *f, const neph_volume_load_desc *desc) {
  np_sparse_grid grid;
  columns out = {.active_count = 0};
  const neph_result result = load_grid(f, desc, &grid);
  if (result) print_message("%s", f->log.text);
  assert_int_equal(result, NEPH_OK);
  for (int a = 0; a < 3; a++) out.first_m[a] = grid.index_to_world.m[a][3], out.step_m[a] = grid.index_to_world.m[a][a];
  for (size_t n = 0; n < grid.leaf_count; n++)
    for (int v = 0; v < NP_LEAF_SIZE; v++) {
      const np_leaf *leaf = &grid.leaves[n];
      const int x = leaf->origin[0] + v / 64, y = leaf->origin[1] + v / 8 % 8;
      if (!(leaf->values[v] > 0.0f)) continue;
      assert_true(x >= 0 && x < MODEL_X && y >= 0 && y < MODEL_Y);
      out.values[y][x] += out.step_m[2] * (double)leaf->values[v];
    }
  out.active_count = np_sparse_grid_count_active(&grid);
  np_sparse_grid_clear(&grid);
  return out;
}

typedef double (*content_fn)(int x, int y, int k, int step);

static double sum_column(const model_file *file, content_fn content, int x, int y, int step) {
  double sum = 0.0;
  if (file->has_fill && x == 0 && y == 0) return 0.0;
  for (int k = 0; k < MODEL_Z; k++)
    sum += content(x, y, k, step) * (model_face(file->levels, x, y, k + 1) - model_face(file->levels, x, y, k));
  return sum;
}

/* A thousandth of each column, beside a millionth of the thickest: floats, and shorts in steps of 4e-5 of the peak. */
static void assert_columns(const columns *actual, const model_file *file, content_fn content, int step, double scale) {
  double total = 0.0, expected_total = 0.0, thickest = 0.0;
  for (int y = 0; y < MODEL_Y; y++)
    for (int x = 0; x < MODEL_X; x++) thickest = fmax(thickest, scale * sum_column(file, content, x, y, step));
  for (int y = 0; y < MODEL_Y; y++)
    for (int x = 0; x < MODEL_X; x++) {
      const double expected = scale * sum_column(file, content, x, y, step);
      assert_near(actual->values[y][x], expected, 1e-3 * expected + (file->is_packed ? 2e-4 : 1e-6) * thickest);
      total += actual->values[y][x];
      expected_total += expected;
    }
  assert_near_relative(total, expected_total, 1e-3);
}

/* ---- Conventions ---- */

static const double grams = 1000.0, per_metre_liquid = 1.5 / (1000.0 * 10e-6), per_metre_ice = 1.5 / (917.0 * 30e-6);

static double content_depth(int x, int y, int k, int step) {
  return per_metre_liquid * model_liquid(x, y, k, step) + per_metre_ice * model_ice(x, y, k, step);
}

static void check_file(const test_fixture *f, const model_case *c, const model_file *file) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  model_write(f->path, c, file);
  columns depth = load_columns(f, &desc);
  if (file->has_ice)
    assert_columns(&depth, file, content_depth, 0, 1.0);
  else
    assert_columns(&depth, file, model_liquid, 0, per_metre_liquid);
  desc.grid = "liquid_water";
  const columns water = load_columns(f, &desc);
  assert_columns(&water, file, model_liquid, 0, grams);
  assert_near(water.step_m[0], model_dx_m, 1e-3);
  assert_near(water.step_m[1], model_dy_m, 1e-3);
  if (file->levels == LEVELS_EVEN) assert_near(water.step_m[2], model_dz_m, 1e-3);
  if (c->axes[0]) assert_near(water.first_m[0], 0.5 * model_dx_m, 1e-3);
  if (!file->has_ice) return;
  desc.grid = "ice_water";
  const columns ice = load_columns(f, &desc);
  assert_columns(&ice, file, model_ice, 0, grams);
}

static bool may_have_hill(const model_case *c) { return c->heights || c->faces; }

static void columns_keep_their_water(void **state) {
  static const model_file files[] = {
      {.levels = LEVELS_EVEN, .step_count = 1},
      {.levels = LEVELS_EVEN, .step_count = 2, .has_ice = true},
      {.levels = LEVELS_EVEN, .step_count = 1, .is_packed = true, .has_fill = true},
      {.levels = LEVELS_EVEN, .step_count = 1, .has_fill = true, .is_descending = true},
      {.levels = LEVELS_UNEVEN, .step_count = 1, .has_ice = true},
      {.levels = LEVELS_UNEVEN, .step_count = 1, .is_packed = true, .is_descending = true},
      {.levels = LEVELS_HILL, .step_count = 2, .has_ice = true},
      {.levels = LEVELS_HILL, .step_count = 1, .is_descending = true, .has_fill = true}};
  const test_fixture *f = *state;
  for (int i = 0; i < MODEL_CASES; i++)
    for (size_t k = 0; k < sizeof files / sizeof *files; k++) {
      model_file file = files[k];
      if (file.levels == LEVELS_HILL && !may_have_hill(&model_cases[i])) continue;
      if (!model_cases[i].axes[0]) file.is_descending = false; /* levels and rows of WRF ascend */
      check_file(f, &model_cases[i], &file);
    }
}

/* ---- Steps ---- */

static const model_file three_steps = {.levels = LEVELS_EVEN, .step_count = 3};

static void steps_are_those_of_the_file(void **state) {
  static const struct {
    double step;
    neph_step_beyond beyond;
    int expected;
  } rows[] = {{1, NEPH_STEP_REFUSE, 0}, {3, NEPH_STEP_REFUSE, 2}, {5, NEPH_STEP_HOLD, 2},
              {-4, NEPH_STEP_HOLD, 0},  {5, NEPH_STEP_LOOP, 1},   {0, NEPH_STEP_LOOP, 2}};
  test_fixture *f = *state;
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  model_write(f->path, model_get_case("SAM"), &three_steps);
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    desc.model.step = rows[i].step;
    desc.model.beyond = rows[i].beyond;
    const columns depth = load_columns(f, &desc);
    assert_columns(&depth, &three_steps, model_liquid, rows[i].expected, per_metre_liquid);
  }
  desc.model.step = 4.0;
  desc.model.beyond = NEPH_STEP_EMPTY;
  test_log_clear(&f->log);
  const columns none = load_columns(f, &desc);
  assert_true(none.active_count == 0);
  assert_non_null(strstr(f->log.text, "step 4 is empty: the file has 3"));
}

/* ---- Size of droplets ---- */

static double depth_of_radius(const test_fixture *f, const neph_volume_load_desc *desc) {
  const columns depth = load_columns(f, desc);
  return depth.values[5][8];
}

static void a_constant_radius_holds_everywhere(void **state) {
  test_fixture *f = *state;
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  model_write(f->path, model_get_case("MicroHH"), &three_steps);
  const double expected = sum_column(&three_steps, model_liquid, 8, 5, 0);
  desc.model.r_eff_m = 14e-6;
  assert_near_relative(depth_of_radius(f, &desc), expected * 1.5 / (1000.0 * 14e-6), 1e-3);
}

/* Extinction of droplets of a number: 3/2·W/(ρ·r) with r³ = 3·W/(4π·ρ·k·N). */
static double extinction_of_number(double content, double number, double dispersion) {
  const double radius = cbrt(3.0 * content / (4.0 * NP_PI * 1000.0 * dispersion * number));
  return content > 0.0 ? 1.5 * content / (1000.0 * fmin(fmax(radius, 2e-6), 50e-6)) : 0.0;
}

static void a_number_of_droplets_gives_their_radius(void **state) {
  test_fixture *f = *state;
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  model_write(f->path, model_get_case("MicroHH"), &three_steps);
  double expected = 0.0;
  desc.model.number_per_m3 = 70e6;
  desc.model.dispersion = 0.67;
  for (int k = 0; k < MODEL_Z; k++) expected += model_dz_m * extinction_of_number(model_liquid(8, 5, k, 0), 70e6, 0.67);
  assert_near_relative(depth_of_radius(f, &desc), expected, 1e-3);
}

/* A further field of the file: constant. */
static void add_constant(const test_fixture *f, const char *name, const char *unit, double value) {
  int id, dimensions[4], variable;
  double *values = forge_alloc((size_t)3 * MODEL_CELLS);
  for (int i = 0; i < 3 * MODEL_CELLS; i++) values[i] = value;
  forge_check(nc_open(f->path, NC_WRITE, &id));
  const int status = nc_redef(id);
  if (status != NC_EINDEFINE) forge_check(status);
  forge_check(nc_inq_vardimid(id, 0, dimensions));
  forge_check(nc_inq_varid(id, "ql", &variable));
  forge_check(nc_inq_vardimid(id, variable, dimensions));
  forge_check(nc_def_var(id, name, NC_FLOAT, 4, dimensions, &variable));
  forge_check(nc_put_att_text(id, variable, "units", strlen(unit), unit));
  forge_check(nc_enddef(id));
  forge_check(nc_put_var_double(id, variable, values));
  forge_check(nc_close(id));
  free(values);
}

static void the_file_gives_radius_and_number(void **state) {
  test_fixture *f = *state;
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  model_write(f->path, model_get_case("MicroHH"), &three_steps);
  add_constant(f, "reff", "um", 7.0);
  add_constant(f, "nd", "cm-3", 120.0);
  const double content = sum_column(&three_steps, model_liquid, 8, 5, 0);
  desc.model.radius = "reff";
  assert_near_relative(depth_of_radius(f, &desc), content * 1.5 / (1000.0 * 7e-6), 1e-3);
  desc.model.radius = NULL;
  desc.model.number = "nd";
  double expected = 0.0;
  for (int k = 0; k < MODEL_Z; k++) expected += model_dz_m * extinction_of_number(model_liquid(8, 5, k, 0), 120e6, 0.8);
  assert_near_relative(depth_of_radius(f, &desc), expected, 1e-3);
}

/* Radii of 0 and below, and NaN, are none: droplets have the usual 10 um. Radii beyond the limits get these. A warning
 * says so. */
static void radii_that_cannot_be_are_reported(void **state) {
  test_fixture *f = *state;
  static const struct {
    double radius_um, taken_um;
    const char *words;
  } cases[] = {{0.0, 10.0, "no effective radius above 0"},
               {-5.0, 10.0, "no effective radius above 0"},
               {NAN, 10.0, "no effective radius above 0"},
               {1e30, 50.0, "beyond 2 to 50 um"},
               {0.1, 2.0, "beyond 2 to 50 um"}};
  const double content = sum_column(&three_steps, model_liquid, 8, 5, 0);
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  desc.model.radius = "reff";
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    model_write(f->path, model_get_case("MicroHH"), &three_steps);
    add_constant(f, "reff", "um", cases[n].radius_um);
    test_log_clear(&f->log);
    const double expected = content * 1.5 / (1000.0 * 1e-6 * cases[n].taken_um);
    assert_near_relative(depth_of_radius(f, &desc), expected, 1e-3);
    assert_one_warning(&f->log, "1 of the water has", cases[n].words);
  }
}

/* ---- Names and lattice ---- */

static void named_variables_win(void **state) {
  test_fixture *f = *state;
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  model_write(f->path, model_get_case("MicroHH"), &three_steps);
  add_constant(f, "fog", "g m-3", 0.25);
  desc.model.variable = "fog";
  const columns depth = load_columns(f, &desc);
  assert_near_relative(depth.values[0][0], MODEL_Z * model_dz_m * 0.25e-3 * per_metre_liquid, 1e-6);
}

/* Voxels of any height hold the same columns. */
static void spacing_keeps_columns(void **state) {
  test_fixture *f = *state;
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  static const double spacings_m[] = {3.0, 17.0, 40.0, 95.0};
  static const model_file uneven = {.levels = LEVELS_UNEVEN, .step_count = 1};
  model_write(f->path, model_get_case("PALM"), &uneven);
  for (size_t i = 0; i < sizeof spacings_m / sizeof *spacings_m; i++) {
    desc.model.spacing_m = spacings_m[i];
    const columns depth = load_columns(f, &desc);
    assert_near(depth.step_m[2], spacings_m[i], 1e-9);
    assert_columns(&depth, &uneven, model_liquid, 0, per_metre_liquid);
  }
}

static void memory_reads_as_the_file(void **state) {
  test_fixture *f = *state;
  for (int i = 0; i < MODEL_CASES; i++) {
    neph_volume *volumes[2];
    neph_volume_info infos[2] = {NEPH_VOLUME_INFO_DEFAULT, NEPH_VOLUME_INFO_DEFAULT};
    model_write(f->path, &model_cases[i], &three_steps);
    const test_file file = test_file_read(f->path);
    assert_int_equal(neph_volume_load(f->context, f->path, NULL, &volumes[0]), NEPH_OK);
    assert_int_equal(neph_volume_load_memory(f->context, file.bytes, file.size, NULL, &volumes[1]), NEPH_OK);
    for (int k = 0; k < 2; k++) assert_int_equal(neph_volume_get_info(volumes[k], &infos[k]), NEPH_OK);
    assert_true(infos[0].value_max == infos[1].value_max && infos[0].value_max > 0.0f);
    assert_true(infos[0].active_voxel_count == infos[1].active_voxel_count);
    for (int k = 0; k < 2; k++) neph_volume_release(volumes[k]);
    free(file.bytes);
  }
}

/* Room for rows is that of the file: a field of some kilobytes takes less than a megabyte while it is read. */
static void a_small_field_takes_little_memory(void **state) {
  test_fixture *f = *state;
  neph_volume *volume;
  model_write(f->path, model_get_case("PALM"), &three_steps);
  const size_t before = atomic_load(&f->context->allocated_bytes);
  assert_int_equal(neph_volume_load(f->context, f->path, NULL, &volume), NEPH_OK);
  const size_t peak = atomic_load(&f->context->allocated_bytes_peak) - before;
  print_message("%zu bytes\n", peak);
  assert_in_range(peak, 1000, 1000000);
  neph_volume_release(volume);
}

static neph_result load_once(neph_context *context, void *user) {
  neph_volume *volume;
  const neph_result result = neph_volume_load(context, user, NULL, &volume);
  neph_volume_release(volume);
  return result;
}

static void failed_allocations_are_survived(void **state) {
  test_fixture *f = *state;
  static const model_file hill = {.levels = LEVELS_HILL, .step_count = 1, .has_ice = true};
  model_write(f->path, model_get_case("CM1"), &hill);
  assert_survives_failed_allocations(load_once, f->path);
}

/* ---- A field of others ---- */

enum { RICO_X = 32, RICO_Y = 37, RICO_Z = 26 };

/* Reads a cloud of the RICO case: cells with their content in g/m³ and effective radius in um. */
static void read_rico(double *content_kg_m3, double *radius_m) {
  char *path = test_data_path("les/rico32x37x26.txt"), line[512];
  FILE *file = fopen(path, "r");
  assert_non_null(file);
  free(path);
  while (fgets(line, sizeof line, file)) {
    int x, y, z;
    double content, radius;
    if (sscanf(line, "%d,%d,%d,%lf,%lf", &x, &y, &z, &content, &radius) != 5) continue;
    assert_true(x >= 0 && x < RICO_X && y >= 0 && y < RICO_Y && z >= 0 && z < RICO_Z);
    const size_t at = (size_t)((z * RICO_Y + y) * RICO_X + x);
    content_kg_m3[at] = 1e-3 * content;
    radius_m[at] = 1e-6 * radius;
  }
  (void)fclose(file);
}

static void write_rico(const char *path, const double *content_kg_m3, const double *radius_m) {
  static const char *const names[3] = {"z", "y", "x"};
  static const int sizes[3] = {RICO_Z, RICO_Y, RICO_X};
  static const double first_km[3] = {0.44, 0.0, 0.0}, step_km[3] = {0.04, 0.02, 0.02};
  forge g = forge_create(path, NC_NETCDF4);
  int dimensions[3];
  for (int d = 0; d < 3; d++) {
    double *values = forge_alloc((size_t)sizes[d]);
    for (int i = 0; i < sizes[d]; i++) values[i] = first_km[d] + step_km[d] * i;
    dimensions[d] = forge_dimension(&g, names[d], (size_t)sizes[d]);
    forge_variable(&g, names[d], NC_FLOAT, 1, &dimensions[d], "km", values);
  }
  double *water = forge_alloc(RICO_X * RICO_Y * RICO_Z), *radius = forge_alloc(RICO_X * RICO_Y * RICO_Z);
  for (int i = 0; i < RICO_X * RICO_Y * RICO_Z; i++) water[i] = 1e3 * content_kg_m3[i], radius[i] = 1e6 * radius_m[i];
  forge_variable(&g, "lwc", NC_FLOAT, 3, dimensions, "g m-3", water);
  const int size = forge_variable(&g, "reff", NC_FLOAT, 3, dimensions, "um", radius);
  forge_text(&g, size, "standard_name", "effective_radius_of_cloud_liquid_water_particles");
  forge_close(&g);
}

static void a_cloud_of_rico_keeps_its_depth(void **state) {
  test_fixture *f = *state;
  static double content_kg_m3[RICO_X * RICO_Y * RICO_Z], radius_m[RICO_X * RICO_Y * RICO_Z];
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  np_sparse_grid grid;
  double expected_water = 0.0, expected_depth = 0.0;
  read_rico(content_kg_m3, radius_m);
  write_rico(f->path, content_kg_m3, radius_m);
  for (int i = 0; i < RICO_X * RICO_Y * RICO_Z; i++) {
    expected_water += 1000.0 * content_kg_m3[i];
    if (radius_m[i] > 0.0) expected_depth += 1.5 * content_kg_m3[i] / (1000.0 * radius_m[i]);
  }
  assert_true(expected_water > 0.0);
  desc.model.variable = "lwc";
  for (int k = 0; k < 2; k++) {
    double sum = 0.0;
    desc.grid = k ? "liquid_water" : "density";
    assert_int_equal(load_grid(f, &desc, &grid), NEPH_OK);
    for (size_t n = 0; n < grid.leaf_count; n++)
      for (int v = 0; v < NP_LEAF_SIZE; v++) sum += (double)grid.leaves[n].values[v];
    assert_near_relative(grid.index_to_world.m[2][2], 40.0, 1e-4);
    assert_near_relative(sum, k ? expected_water : expected_depth, 1e-3);
    np_sparse_grid_clear(&grid);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(columns_keep_their_water, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(steps_are_those_of_the_file, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_constant_radius_holds_everywhere, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_number_of_droplets_gives_their_radius, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(the_file_gives_radius_and_number, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(radii_that_cannot_be_are_reported, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(named_variables_win, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(spacing_keeps_columns, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(memory_reads_as_the_file, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_small_field_takes_little_memory, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(failed_allocations_are_survived, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_cloud_of_rico_keeps_its_depth, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

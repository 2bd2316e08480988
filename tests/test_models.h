/* SPDX-License-Identifier: Apache-2.0 */
/* NetCDF files of a small analytic field of water, in the convention of each model, for the tests of models. */
#ifndef NP_TEST_MODELS_H
#define NP_TEST_MODELS_H

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include <netcdf.h>

#include "test_support.h"

/* ---- Files ---- */

enum { FORGE_VALUES_MAX = 32 };

/* A file that is being defined; values are written when it is closed. */
typedef struct forge {
  int id, count;
  struct {
    int variable;
    double *values; /* owned */
  } pending[FORGE_VALUES_MAX];
} forge;

#define forge_check(status) assert_string_equal(nc_strerror(status), nc_strerror(NC_NOERR))

static inline forge forge_create(const char *path, int mode) {
  forge f = {.count = 0};
  forge_check(nc_create(path, NC_CLOBBER | mode, &f.id));
  return f;
}

static inline int forge_dimension(const forge *f, const char *name, size_t size) {
  int dimension;
  forge_check(nc_def_dim(f->id, name, size, &dimension));
  return dimension;
}

static inline void forge_text(const forge *f, int variable, const char *name, const char *text) {
  if (text) forge_check(nc_put_att_text(f->id, variable, name, strlen(text), text));
}

static inline void forge_number(const forge *f, int variable, const char *name, double number) {
  forge_check(nc_put_att_double(f->id, variable, name, NC_DOUBLE, 1, &number));
}

/* `values` becomes the forge's; `unit` may be NULL. */
static inline int forge_variable(forge *f, const char *name, nc_type type, int rank, const int *dimensions,
                                 const char *unit, double *values) {
  int variable;
  forge_check(nc_def_var(f->id, name, type, rank, dimensions, &variable));
  forge_text(f, variable, "units", unit);
  assert_true(f->count < FORGE_VALUES_MAX);
  f->pending[f->count].variable = variable;
  f->pending[f->count++].values = values;
  return variable;
}

static inline void forge_close(forge *f) {
  const int status = nc_enddef(f->id);
  if (status != NC_ENOTINDEFINE) forge_check(status);
  for (int i = 0; i < f->count; i++) {
    forge_check(nc_put_var_double(f->id, f->pending[i].variable, f->pending[i].values));
    free(f->pending[i].values);
  }
  forge_check(nc_close(f->id));
}

/* ---- The field ---- */

enum { MODEL_X = 20, MODEL_Y = 12, MODEL_Z = 16, MODEL_CELLS = MODEL_X * MODEL_Y * MODEL_Z };

static const double model_dx_m = 100.0, model_dy_m = 80.0, model_low_m = 500.0, model_dz_m = 40.0;

/* Heights of levels: even; uneven, thicker upwards; or uneven above a hill. Faces are halfway between levels. */
typedef enum model_levels { LEVELS_EVEN, LEVELS_UNEVEN, LEVELS_HILL } model_levels;

static inline double model_height(model_levels levels, int x, int y, int k) {
  const double middle = k + 0.5, even = model_dz_m * middle, uneven = 22.0 * middle + 1.1 * middle * middle;
  const double hill = 180.0 * exp(-0.02 * ((x - 9) * (x - 9) + (y - 5) * (y - 5)));
  if (levels == LEVELS_EVEN) return model_low_m + even;
  return model_low_m + (levels == LEVELS_HILL ? hill + uneven * (1.0 - hill / 1000.0) : uneven);
}

static inline double model_inner_face(model_levels levels, int x, int y, int k) {
  return 0.5 * (model_height(levels, x, y, k - 1) + model_height(levels, x, y, k));
}

static inline double model_face(model_levels levels, int x, int y, int k) {
  if (k == 0) return 2.0 * model_height(levels, x, y, 0) - model_inner_face(levels, x, y, 1);
  if (k < MODEL_Z) return model_inner_face(levels, x, y, k);
  return 2.0 * model_height(levels, x, y, k - 1) - model_inner_face(levels, x, y, k - 1);
}

/* Content in kg/m³ at a step, from 0: a ball that drifts towards x. */
static inline double model_content(int x, int y, int k, int step, double peak_kg_m3) {
  const double dx = (x - 8.0 - 2.0 * step) / 6.0, dy = (y - 5.5) / 5.0, dz = (k - 8.0) / 5.5;
  return peak_kg_m3 * fmax(0.0, 1.0 - dx * dx - dy * dy - dz * dz);
}

static inline double model_liquid(int x, int y, int k, int step) { return model_content(x, y, k, step, 6e-4); }
static inline double model_ice(int x, int y, int k, int step) { return model_content(x, y, k - 4, step, 1e-4); }

/* Air: pressure, temperature and specific humidity (or vapour mixing ratio) by height. */
static inline double model_pressure(double z_m) { return 101000.0 * exp(-z_m / 8200.0); }
static inline double model_temperature(double z_m) { return 291.0 - 0.0068 * z_m; }
static const double model_vapour = 0.008;

/* Density of moist air, or of the dry air in it. */
static inline double model_air(double z_m, bool is_dry, bool has_vapour) {
  const double dry = model_pressure(z_m) / (287.05 * model_temperature(z_m));
  return dry / (1.0 + (is_dry ? 1.6078 : 0.6078) * (has_vapour ? model_vapour : 0.0));
}

/* ---- Conventions ---- */

typedef enum model_temperature_kind { NO_TEMPERATURE, TEMPERATURE, POTENTIAL_TEMPERATURE } model_temperature_kind;

typedef struct model_case {
  const char *model;
  int mode;                            /* mode of nc_create */
  const char *dimensions[4], *axes[3]; /* time, z, y, x; axes NULL: no variable */
  const char *axis_unit;
  double axis_unit_m;
  const char *liquid, *ice, *water_unit;
  double water_per_kg_kg; /* values in the unit for 1 kg/kg */
  bool is_dry, is_content;
  const char *density; /* profile, or NULL */
  const char *pressure, *pressure_unit;
  double pressure_unit_pa;
  bool is_pressure_profile;
  model_temperature_kind temperature_kind;
  const char *temperature, *vapour;
  double temperature_offset_k; /* subtracted in the file */
  const char *heights, *faces; /* fields of heights, above a hill */
  bool has_standard_names;
} model_case;

/* Choices of a file. */
typedef struct model_file {
  model_levels levels;
  int step_count;
  bool is_packed; /* water as shorts */
  bool has_fill;  /* a corner column of the water is fill values */
  bool has_ice;
  bool is_descending; /* levels and rows */
} model_file;

static const model_case model_cases[] = {
    {.model = "MicroHH",
     .mode = NC_NETCDF4,
     .dimensions = {"time", "z", "y", "x"},
     .axes = {"z", "y", "x"},
     .axis_unit = "m",
     .axis_unit_m = 1.0,
     .liquid = "ql",
     .ice = "qi",
     .water_unit = "kg kg-1",
     .water_per_kg_kg = 1.0,
     .density = "rhoref"},
    {.model = "DALES",
     .mode = 0,
     .dimensions = {"time", "zt", "yt", "xt"},
     .axes = {"zt", "yt", "xt"},
     .axis_unit = "m",
     .axis_unit_m = 1.0,
     .liquid = "ql",
     .ice = "qi",
     .water_unit = "1e-5kg/kg",
     .water_per_kg_kg = 1e5,
     .density = "rhobf"},
    {.model = "PALM",
     .mode = NC_64BIT_OFFSET,
     .dimensions = {"time", "zu_3d", "y", "x"},
     .axes = {"zu_3d", "y", "x"},
     .axis_unit = "m",
     .axis_unit_m = 1.0,
     .liquid = "ql",
     .ice = "qi",
     .water_unit = "kg/kg",
     .water_per_kg_kg = 1.0,
     .pressure = "hyp",
     .pressure_unit = "Pa",
     .pressure_unit_pa = 1.0,
     .is_pressure_profile = true,
     .temperature_kind = POTENTIAL_TEMPERATURE,
     .temperature = "theta"},
    {.model = "Meso-NH",
     .mode = NC_NETCDF4,
     .dimensions = {"time", "vertical_levels", "S_N_direction", "W_E_direction"},
     .axes = {"vertical_levels", "S_N_direction", "W_E_direction"},
     .axis_unit = "m",
     .axis_unit_m = 1.0,
     .liquid = "RCT",
     .ice = "RIT",
     .water_unit = "kg/kg",
     .water_per_kg_kg = 1.0,
     .is_dry = true,
     .pressure = "PABST",
     .pressure_unit = "Pa",
     .pressure_unit_pa = 1.0,
     .temperature_kind = POTENTIAL_TEMPERATURE,
     .temperature = "THT",
     .vapour = "RVT",
     .heights = "VLEV"},
    {.model = "CM1",
     .mode = NC_64BIT_OFFSET,
     .dimensions = {"time", "nk", "nj", "ni"},
     .axes = {"z", "yh", "xh"},
     .axis_unit = "km",
     .axis_unit_m = 1000.0,
     .liquid = "qc",
     .ice = "qi",
     .water_unit = "kg/kg",
     .water_per_kg_kg = 1.0,
     .is_dry = true,
     .pressure = "prs",
     .pressure_unit = "Pa",
     .pressure_unit_pa = 1.0,
     .temperature_kind = POTENTIAL_TEMPERATURE,
     .temperature = "th",
     .vapour = "qv",
     .heights = "zhval"},
    {.model = "WRF",
     .mode = NC_NETCDF4,
     .dimensions = {"Time", "bottom_top", "south_north", "west_east"},
     .liquid = "QCLOUD",
     .ice = "QICE",
     .water_unit = "kg kg-1",
     .water_per_kg_kg = 1.0,
     .is_dry = true,
     .pressure = "P",
     .pressure_unit = "Pa",
     .pressure_unit_pa = 1.0,
     .temperature_kind = POTENTIAL_TEMPERATURE,
     .temperature = "T",
     .temperature_offset_k = 300.0,
     .vapour = "QVAPOR",
     .faces = "PH"},
    {.model = "SAM",
     .mode = 0,
     .dimensions = {"time", "z", "y", "x"},
     .axes = {"z", "y", "x"},
     .axis_unit = "m",
     .axis_unit_m = 1.0,
     .liquid = "QC",
     .ice = "QI",
     .water_unit = "g/kg",
     .water_per_kg_kg = 1e3,
     .pressure = "p",
     .pressure_unit = "mb",
     .pressure_unit_pa = 100.0,
     .is_pressure_profile = true,
     .temperature_kind = TEMPERATURE,
     .temperature = "TABS",
     .vapour = "QV"},
    {.model = "CF",
     .mode = NC_NETCDF4,
     .dimensions = {"t", "level", "northing", "easting"},
     .axes = {"altitude_of_level", "northing", "easting"},
     .axis_unit = "m",
     .axis_unit_m = 1.0,
     .liquid = "clw",
     .ice = "cli",
     .water_unit = "g m-3",
     .water_per_kg_kg = 1e3,
     .is_content = true,
     .heights = "altitude",
     .has_standard_names = true},
};

enum { MODEL_CASES = sizeof model_cases / sizeof *model_cases };

static inline const model_case *model_get_case(const char *model) {
  int i = 0;
  while (i + 1 < MODEL_CASES && strcmp(model_cases[i].model, model) != 0) i++;
  assert_string_equal(model_cases[i].model, model);
  return &model_cases[i];
}

static inline double *forge_alloc(size_t count) {
  double *values = calloc(count, sizeof *values);
  assert_non_null(values);
  return values;
}

/* Value of a quantity at a cell. */
typedef double (*model_value)(const model_case *c, const model_file *file, int x, int y, int k, int step);

static inline double model_ratio(const model_case *c, double content, double height_m) {
  return c->water_per_kg_kg * (c->is_content ? content : content / model_air(height_m, c->is_dry, c->vapour));
}

static inline double value_liquid(const model_case *c, const model_file *file, int x, int y, int k, int step) {
  return model_ratio(c, model_liquid(x, y, k, step), model_height(file->levels, x, y, k));
}

static inline double value_ice(const model_case *c, const model_file *file, int x, int y, int k, int step) {
  return model_ratio(c, model_ice(x, y, k, step), model_height(file->levels, x, y, k));
}

static inline double value_pressure(const model_case *c, const model_file *file, int x, int y, int k, int step) {
  (void)step;
  return model_pressure(model_height(file->levels, x, y, k)) / c->pressure_unit_pa;
}

static inline double value_temperature(const model_case *c, const model_file *file, int x, int y, int k, int step) {
  const double z_m = model_height(file->levels, x, y, k), temperature = model_temperature(z_m);
  (void)step;
  if (c->temperature_kind == TEMPERATURE) return temperature;
  return temperature * pow(1e5 / model_pressure(z_m), 0.2857) - c->temperature_offset_k;
}

static inline double value_vapour(const model_case *c, const model_file *file, int x, int y, int k, int step) {
  (void)file, (void)x, (void)y, (void)k, (void)step;
  return model_vapour * c->water_per_kg_kg;
}

static inline double value_height(const model_case *c, const model_file *file, int x, int y, int k, int step) {
  (void)step, (void)c;
  return model_height(file->levels, x, y, k);
}

/* All values of a field of four dimensions. */
static inline double *make_field(const model_case *c, const model_file *file, model_value value, int level_count) {
  double *values = forge_alloc((size_t)file->step_count * (size_t)level_count * MODEL_Y * MODEL_X), *at = values;
  for (int t = 0; t < file->step_count; t++)
    for (int k = 0; k < level_count; k++)
      for (int y = 0; y < MODEL_Y; y++)
        for (int x = 0; x < MODEL_X; x++)
          *at++ = value(c, file, x, file->is_descending ? MODEL_Y - 1 - y : y,
                        file->is_descending ? level_count - 1 - k : k, t);
  return values;
}

static inline double value_geopotential(const model_case *c, const model_file *file, int x, int y, int k, int step) {
  (void)c, (void)step;
  return 9.81 * model_face(file->levels, x, y, k);
}

static inline void add_axis(forge *f, const model_case *c, const model_file *file, int axis, int dimension,
                            const char *standard_name) {
  static const int sizes[3] = {MODEL_Z, MODEL_Y, MODEL_X};
  double *values = forge_alloc((size_t)sizes[axis]);
  for (int i = 0; i < sizes[axis]; i++) {
    const int n = file->is_descending && axis < 2 ? sizes[axis] - 1 - i : i;
    const double m = axis == 0   ? model_height(file->levels == LEVELS_HILL ? LEVELS_UNEVEN : file->levels, 0, 0, n)
                     : axis == 1 ? model_dy_m * (n + 0.5)
                                 : model_dx_m * (n + 0.5);
    values[i] = m / c->axis_unit_m;
  }
  const int variable = forge_variable(f, c->axes[axis], NC_DOUBLE, 1, &dimension, c->axis_unit, values);
  if (c->has_standard_names) forge_text(f, variable, "standard_name", standard_name);
}

/* Water, as floats or packed to shorts with an offset; the column at x = y = 0 may be fill values. */
static inline void add_water(forge *f, const model_case *c, const model_file *file, const int dimensions[4],
                             const char *name, model_value value, const char *standard_name) {
  double *values = make_field(c, file, value, MODEL_Z);
  const double scale = 2.5e-8 * c->water_per_kg_kg, offset = 7e-4 * c->water_per_kg_kg,
               fill = file->is_packed ? -32767.0 : -999.0;
  const size_t count = (size_t)file->step_count * MODEL_CELLS;
  for (size_t i = 0; i < count; i++) {
    if (file->is_packed) values[i] = nearbyint((values[i] - offset) / scale);
    if (file->has_fill && i % (MODEL_X * MODEL_Y) == 0) values[i] = fill;
  }
  const nc_type type = file->is_packed ? NC_SHORT : NC_FLOAT;
  const int variable = forge_variable(f, name, type, 4, dimensions, c->water_unit, values);
  const short short_fill = -32767;
  const float float_fill = -999.0f;
  if (file->is_packed) {
    forge_number(f, variable, "scale_factor", scale);
    forge_number(f, variable, "add_offset", offset);
  }
  if (file->has_fill && file->is_packed)
    forge_check(nc_put_att_short(f->id, variable, "_FillValue", NC_SHORT, 1, &short_fill));
  else if (file->has_fill)
    forge_check(nc_put_att_float(f->id, variable, "_FillValue", NC_FLOAT, 1, &float_fill));
  if (c->has_standard_names) forge_text(f, variable, "standard_name", standard_name);
}

static inline void add_air(forge *f, const model_case *c, const model_file *file, const int dimensions[4]) {
  if (c->density) {
    double *values = forge_alloc(MODEL_Z);
    for (int k = 0; k < MODEL_Z; k++)
      values[k] =
          model_air(model_height(file->levels, 0, 0, file->is_descending ? MODEL_Z - 1 - k : k), c->is_dry, c->vapour);
    forge_variable(f, c->density, NC_FLOAT, 1, &dimensions[1], "kg m-3", values);
  }
  if (c->pressure && c->is_pressure_profile) {
    double *values = forge_alloc(MODEL_Z);
    for (int k = 0; k < MODEL_Z; k++)
      values[k] = value_pressure(c, file, 0, 0, file->is_descending ? MODEL_Z - 1 - k : k, 0);
    forge_variable(f, c->pressure, NC_FLOAT, 1, &dimensions[1], c->pressure_unit, values);
  } else if (c->pressure)
    forge_variable(f, c->pressure, NC_FLOAT, 4, dimensions, c->pressure_unit,
                   make_field(c, file, value_pressure, MODEL_Z));
  if (c->temperature)
    forge_variable(f, c->temperature, NC_FLOAT, 4, dimensions, "K", make_field(c, file, value_temperature, MODEL_Z));
  if (c->vapour)
    forge_variable(f, c->vapour, NC_FLOAT, 4, dimensions, c->water_unit, make_field(c, file, value_vapour, MODEL_Z));
}

/* Heights of WRF: the geopotential of faces, as a perturbation of a base state of half of it. */
static inline void add_wrf(forge *f, const model_case *c, const model_file *file, const int dimensions[4]) {
  const int staggered[4] = {dimensions[0], forge_dimension(f, "bottom_top_stag", MODEL_Z + 1), dimensions[2],
                            dimensions[3]};
  const size_t count = (size_t)file->step_count * (MODEL_Z + 1) * MODEL_Y * MODEL_X;
  double *whole = make_field(c, file, value_geopotential, MODEL_Z + 1), *half = forge_alloc(count);
  for (size_t i = 0; i < count; i++) {
    half[i] = 0.5 * whole[i];
    whole[i] -= half[i];
  }
  forge_variable(f, "PH", NC_FLOAT, 4, staggered, "m2 s-2", whole);
  forge_variable(f, "PHB", NC_FLOAT, 4, staggered, "m2 s-2", half);
  forge_variable(f, "PB", NC_FLOAT, 4, dimensions, "Pa", forge_alloc((size_t)file->step_count * MODEL_CELLS));
  forge_number(f, NC_GLOBAL, "DX", model_dx_m);
  forge_number(f, NC_GLOBAL, "DY", model_dy_m);
}

static inline void model_write(const char *path, const model_case *c, const model_file *file) {
  static const char *const names[3] = {NULL, "projection_y_coordinate", "projection_x_coordinate"};
  const size_t sizes[4] = {(size_t)file->step_count, MODEL_Z, MODEL_Y, MODEL_X};
  forge f = forge_create(path, c->mode);
  int dimensions[4];
  for (int d = 0; d < 4; d++) dimensions[d] = forge_dimension(&f, c->dimensions[d], sizes[d]);
  double *times = forge_alloc(sizes[0]);
  for (size_t t = 0; t < sizes[0]; t++) times[t] = 60.0 * (double)t;
  forge_variable(&f, c->dimensions[0], NC_DOUBLE, 1, dimensions, "seconds since 2000-01-01 00:00:00", times);
  for (int axis = 0; axis < 3; axis++)
    if (c->axes[axis]) add_axis(&f, c, file, axis, dimensions[axis + 1], axis ? names[axis] : "altitude");
  add_water(&f, c, file, dimensions, c->liquid, value_liquid, "mass_concentration_of_cloud_liquid_water_in_air");
  if (file->has_ice) add_water(&f, c, file, dimensions, c->ice, value_ice, "mass_concentration_of_cloud_ice_in_air");
  add_air(&f, c, file, dimensions);
  if (c->faces) add_wrf(&f, c, file, dimensions);
  if (c->heights && file->levels == LEVELS_HILL) {
    const int height =
        forge_variable(&f, c->heights, NC_DOUBLE, 4, dimensions, "m", make_field(c, file, value_height, MODEL_Z));
    if (c->has_standard_names) forge_text(&f, height, "standard_name", "altitude");
  }
  forge_close(&f);
}

#endif

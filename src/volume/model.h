/* SPDX-License-Identifier: Apache-2.0 */
/* A field of an atmospheric model in a NetCDF file: its variables, axes, levels and time step. Inside the volume module
 * only.
 *
 * Positions in arrays of a box are (y, x, z), z fastest: columns are contiguous. Levels count upwards, whatever their
 * order in the file, and so do rows and columns towards north and east.
 */
#ifndef NP_VOLUME_MODEL_H
#define NP_VOLUME_MODEL_H

#include <nephos/volume.h>

#include "core/parallel.h"
#include "volume/model_convention.h"
#include "volume/model_unit.h"
#include "volume/netcdf_table.h"

enum { NP_MODEL_FILLS_MAX = 3, NP_MODEL_PARTS_MAX = 2, NP_MODEL_UNIT_BYTES = 64, NP_MODEL_STEP_NAME_BYTES = 24 };

/* A variable, whose value in SI is factor·stored + offset. */
typedef struct np_model_variable {
  np_netcdf_variable info;
  int index;                        /* number in the file */
  char unit[NP_MODEL_UNIT_BYTES];   /* unit in the file; "": none */
  double factor, offset;            /* those of packing and unit */
  double fills[NP_MODEL_FILLS_MAX]; /* stored numbers that stand for no value */
  int fill_count;
  int axes[NP_NETCDF_RANK_MAX]; /* np_model_axis of each dimension; -1: one of length 1 that has none */
} np_model_variable;

/* A quantity: a variable, or the sum of two; count 0: the file has none. Fill values read as NaN, and any other NaN as
 * negative infinity. */
typedef struct np_model_field {
  np_model_variable parts[NP_MODEL_PARTS_MAX];
  int count;
  int unit; /* row of np_model_role_row.units that it is in */
} np_model_field;

/* Positions along x or y: first and spacing, in metres, of the samples in ascending order. */
typedef struct np_model_line {
  double first_m, spacing_m;
  bool is_reversed; /* the file's order descends */
} np_model_line;

typedef struct np_model {
  neph_context *context; /* borrowed, as the path, the module and the names of the settings */
  const char *path;
  const np_netcdf_module *module;
  np_netcdf_file *file; /* owned */
  uint64_t file_bytes;
  neph_volume_model settings;
  neph_import_policy policy;
  bool is_quiet; /* the header alone is read: its reading logs failures, and nothing else */
  const np_model_convention *convention;
  np_model_field fields[NP_MODEL_ROLES];
  np_model_role water; /* the first of liquid and ice that is there: its dimensions are those of the model */

  int dimensions[NP_MODEL_AXES]; /* numbers in the file; -1: none */
  size_t sizes[NP_MODEL_AXES];   /* 1 where there is no dimension */
  size_t step;                   /* chosen time step, from 0 */
  bool is_empty;                 /* the step is beyond the last, and stands for no cloud */
  np_model_line lines[2];        /* along y and x */

  np_model_variable level_variable; /* heights of levels along z alone; index -1: a field has them */
  bool is_level_pressure;           /* they are pressures */
  bool are_levels_reversed;         /* the file's order descends */
  double *column_faces_m;           /* sizes[z] + 1 heights common to all columns; owned; NULL: they differ */
  bool is_even;                     /* voxels are the model's own levels */
  double bottom_m, step_m;          /* lattice of voxels: bottom of the lowest, height of each */
  size_t level_count;
} np_model;

/* ---- model_variable.c ---- */

/* Logs a message, unless the header alone is read. */
void np_model_note(const np_model *model, neph_log_level level, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Searches a variable; -1: none. */
int np_model_search_variable(const np_model *model, const char *name);
neph_result np_model_describe_variable(const np_model *model, int index, np_model_variable *out);

/* Searches a dimension by its name among those of a variable; -1: none. */
int np_model_search_dimension(const np_model *model, const np_model_variable *variable, const char *name);
neph_result np_model_name_dimension(const np_model *model, int dimension, char out_name[NP_NETCDF_NAME_BYTES]);

/* Reads all numbers of a variable of one dimension, in SI. */
neph_result np_model_read_line(const np_model *model, const np_model_variable *variable, double *out_values);

/* Rows of a box. */
typedef struct np_model_rows {
  size_t begin, count;
} np_model_rows;

/* Reads a field in SI at the chosen step: rows.count × sizes[x] × level_count values. What does
 * not depend on an axis repeats along it. `level_count` is sizes[z], or one more for faces. */
neph_result np_model_read_field(const np_model *model, np_model_role role, np_model_rows rows, size_t level_count,
                                double *out_values);

/* ---- model_field.c ---- */

/* Chooses the convention and the variables of each role, and checks their units. */
neph_result np_model_choose_fields(np_model *model);

/* Applies the unit of a variable, or, where it states none, `otherwise`, which may be NULL: its values are then in SI.
 * False: the unit is unknown, or there is none. */
bool np_model_apply_unit(np_model_variable *variable, const char *otherwise, np_model_unit *out_unit);

/* ---- model_axis.c ---- */

/* Finds the axis of each dimension of the water, the positions along x and y, and the time step. */
neph_result np_model_place_axes(np_model *model);

/* ---- model_level.c ---- */

/* Rows that are read at a time, a multiple of 8. */
size_t np_model_get_slab(const np_model *model);

/* Finds the heights of levels, and the lattice of voxels that holds them. */
neph_result np_model_place_levels(np_model *model, np_monitor *monitor);
void np_model_clear_levels(np_model *model);

/* Faces of the levels of the columns of some rows: rows.count × sizes[x] × (sizes[z] + 1) heights, ascending. */
neph_result np_model_read_faces(const np_model *model, np_model_rows rows, double *out_faces_m);

/* ---- model_water.c ---- */

/* Grids of a model. */
typedef enum np_model_grid {
  NP_MODEL_EXTINCTION,
  NP_MODEL_LIQUID_WATER,
  NP_MODEL_ICE_WATER,
  NP_MODEL_RADIUS, /* radii of droplets and ice, weighted by extinction */
  NP_MODEL_GRIDS
} np_model_grid;

/* Counts of stored values of water, and sums of those above and below 0. */
typedef struct np_water_tally {
  uint64_t count, fill_count, negative_count, airless_count; /* airless: with water, without a valid density of air */
  double sum, negative_sum, sizeless_sum, limited_sum;       /* sizeless: without a radius above 0; limited: with one
                                                                that is brought to the limits */
} np_water_tally;

/* Values in 1/m, g/m³ or, of radii, um/m, as radius times extinction, of the levels of some rows: rows.count × sizes[x]
 * × sizes[z]. `faces_m` are those of np_model_read_faces. Adds to the tally. */
neph_result np_model_read_water(const np_model *model, np_model_grid grid, np_model_rows rows, const double *faces_m,
                                double *out_values, np_water_tally *tally);

/* Reports fill values, negative water, invalid densities of air and radii; fails if there are fill values alone. */
neph_result np_water_tally_report(const np_water_tally *tally, const np_model *model);

/* Whether droplets or ice have other radii than droplets' usual one, so that the file has a grid of them. */
bool np_model_has_radii(const np_model *model);

/* Says where the density of air and the size of droplets come from. */
void np_model_describe_air(const np_model *model, char *out, size_t size);
void np_model_describe_radius(const np_model *model, np_model_role water, char *out, size_t size);

/* ---- model_column.c ---- */

/* Means of a column over voxels of one height: what the column holds between its faces is kept. The values within a
 * level are linear, limited so that they stay between those of its neighbours. */
void np_model_resample_column(size_t level_count, const double *faces_m, const double *values, double bottom_m,
                              double step_m, size_t voxel_count, double *out_values);

/* ---- model_air.c ---- */

/* The standard atmosphere of 1976 up to 20 km, isothermal above. */
double np_standard_temperature(double altitude_m);
double np_standard_pressure(double altitude_m);
double np_standard_altitude(double pressure_pa);

/* Density in kg/m³ of air of that temperature in K. */
double np_air_density(double pressure_pa, double temperature_k);

#endif

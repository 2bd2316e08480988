/* SPDX-License-Identifier: Apache-2.0 */
/* Names of variables and axes in the files of large-eddy and weather models, a row a model. */
#ifndef NP_VOLUME_MODEL_CONVENTION_H
#define NP_VOLUME_MODEL_CONVENTION_H

#include <stdbool.h>
#include <stddef.h>

/* Quantities of a model that a cloud follows from. */
typedef enum np_model_role {
  NP_MODEL_LIQUID,
  NP_MODEL_ICE,
  NP_MODEL_VAPOUR,
  NP_MODEL_DENSITY, /* density of air */
  NP_MODEL_PRESSURE,
  NP_MODEL_TEMPERATURE,
  NP_MODEL_POTENTIAL_TEMPERATURE,
  NP_MODEL_NUMBER,        /* number of droplets */
  NP_MODEL_LIQUID_RADIUS, /* effective radius of droplets */
  NP_MODEL_ICE_RADIUS,
  NP_MODEL_HEIGHT, /* heights of the levels where they differ from column to column */
  NP_MODEL_FACE,   /* heights of the faces between levels */
  NP_MODEL_ROLES
} np_model_role;

typedef enum np_model_axis { NP_MODEL_Z, NP_MODEL_Y, NP_MODEL_X, NP_MODEL_T, NP_MODEL_AXES } np_model_axis;

/* A unit that values of a role may have. */
typedef struct np_model_role_unit {
  const char *text, *meaning; /* "kg m-3", "content (kg m-3, g m-3)" */
} np_model_role_unit;

enum { NP_MODEL_UNITS_MAX = 2 };

typedef struct np_model_role_row {
  const char *meaning; /* "liquid water" */
  np_model_role_unit units[NP_MODEL_UNITS_MAX];
  const char *standard_names; /* names of the CF conventions, between spaces */
} np_model_role_row;

extern const np_model_role_row np_model_role_rows[NP_MODEL_ROLES];

/* Names stand between spaces, the preferred one first; "P+PB" is the sum of two variables. */
typedef struct np_model_convention {
  const char *model; /* "MicroHH" */
  const char *names[NP_MODEL_ROLES];
  const char *units[NP_MODEL_ROLES];     /* unit where the variable states none; NULL: it must state one */
  const char *axes[NP_MODEL_AXES];       /* variables of positions, or dimensions */
  const char *spacings[2];               /* attributes of the file: spacing along y and x in metres; NULL: none */
  const char *length_unit;               /* unit of an axis that states none */
  double potential_temperature_offset_k; /* added to the potential temperature */
  double gravity_m_s2;                   /* turns geopotential into height */
  bool is_dry;                           /* mixing ratios are those to dry air, not to moist air */
} np_model_convention;

/* Rows of models, the most specific first; the last row is that of the CF conventions, which names nothing. */
extern const np_model_convention np_model_conventions[];
extern const size_t np_model_convention_count;

/* Copies the next name of a list to `out`; false: there is none. `*at` starts at the list. */
bool np_model_names_next(const char **at, char *out, size_t capacity);

#endif

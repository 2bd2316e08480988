/* SPDX-License-Identifier: Apache-2.0 */
/* Methods of the march for multiple scattering in clouds, one row each. Their functions are rows of
 * integrate/approximation.c. */
#ifndef NP_OPTICS_MULTIPLE_SCATTERING_H
#define NP_OPTICS_MULTIPLE_SCATTERING_H

#include <nephos/render.h>

#include "core/spectrum.h"
#include "optics/phase.h"

/* ROW(ID, name, needs): NEPH_MULTIPLE_SCATTERING_ID in the API, `name` in scene files and pictures; `needs` is the
 * solution of the multiple scattering, or an approximation in its place. */
#define NP_MULTIPLE_SCATTERING_ROWS(ROW)                                                                               \
  ROW(ORDINATES, "ordinates", SOLUTION)                                                                                \
  ROW(OCTAVES, "octaves", APPROXIMATION)                                                                               \
  ROW(SOFTENED_BEER, "softened_beer", APPROXIMATION)                                                                   \
  ROW(POWDER, "powder", APPROXIMATION)                                                                                 \
  ROW(DERIVATIVE, "derivative", APPROXIMATION)                                                                         \
  ROW(NONE, "none", NOTHING)

typedef enum np_multiple_scattering_needs {
  NP_MULTIPLE_SCATTERING_NEEDS_NOTHING,
  NP_MULTIPLE_SCATTERING_NEEDS_SOLUTION,
  NP_MULTIPLE_SCATTERING_NEEDS_APPROXIMATION
} np_multiple_scattering_needs;

typedef struct np_multiple_scattering_row {
  neph_multiple_scattering value;
  const char *name;
  np_multiple_scattering_needs needs;
} np_multiple_scattering_row;

enum { NP_MULTIPLE_SCATTERING_COUNT = NEPH_MULTIPLE_SCATTERING_DERIVATIVE + 1 };

/* The row of a method; NULL where there is none. */
const np_multiple_scattering_row *np_multiple_scattering_get_row(neph_multiple_scattering method);

/* Parameters of the approximations. */
typedef struct np_approximation {
  double gain;                          /* factor on all terms, for clouds without a gain of their own */
  unsigned octave_count;                /* 1 to NP_APPROXIMATION_TERMS_MAX */
  double octave_factors[3];             /* factors on light, optical depth and asymmetry, from one octave to the next */
  double softened_share, softened_rate; /* a and b of max(e^{−τ}, a·e^{−bτ}); the powder uses them too */
  double powder_strength;               /* 0: softened Beer alone; 1: full powder */
  double derivative_distance_m;         /* distance of the look-up towards the sun */
} np_approximation;

enum { NP_APPROXIMATION_TERMS_MAX = 16, NP_GAIN_ANGLES = 7 };

/* Calibrated gain of a method in one cloud, by the angle θ between light and view: nodes are even in sin(θ/2), and the
 * first looks into the light. */
typedef struct np_cloud_gain {
  float depth;    /* effective optical depth of the cloud */
  np_phase phase; /* Henyey-Greenstein of the cloud's asymmetry, for which gains are calibrated */
  np_spectrum sun[NP_GAIN_ANGLES];
  np_spectrum surroundings[NP_GAIN_ANGLES];
} np_cloud_gain;

#endif

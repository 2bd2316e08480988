/* SPDX-License-Identifier: Apache-2.0 */
/* Star catalogues. */
#ifndef NP_ATMOSPHERE_STARS_H
#define NP_ATMOSPHERE_STARS_H

#include "core/context_private.h"
#include "core/math.h"

typedef struct np_star {
  float ascension_deg, declination_deg; /* J2000 */
  float v_magnitude, b_minus_v;
} np_star;

typedef struct np_star_catalogue {
  neph_context *context;
  size_t count;
  np_star *own; /* read from a file; NULL: the built-in stars */
  const np_star *stars;
} np_star_catalogue;

/* The built-in catalogue of the brightest stars. */
np_star_catalogue np_star_catalogue_bright(void);

/* Reads comma-separated values with columns for right ascension and declination in degrees, V magnitude and optionally
 * B − V; a missing colour is the sun's. Stars fainter than `faintest` are left out. On failure nothing is left. */
neph_result np_star_catalogue_load(neph_context *context, const char *path, double faintest,
                                   np_star_catalogue *out_catalogue);
void np_star_catalogue_clear(np_star_catalogue *catalogue);

/* Unit vector, x towards right ascension 0, z towards the pole. */
np_dvec3 np_star_direction(const np_star *star);

/* Scintillation of one star: a factor of mean 1 on its irradiance. Its relative standard deviation is `spread` at the
 * zenith and grows with the 1.75th power of the air mass (Young 1967, "Photometric Error Analysis VI", AJ 72), to at
 * most 1. `gaussian` is a standard normal deviate. */
float np_star_twinkle(float spread, float zenith_cosine, float gaussian);

#endif

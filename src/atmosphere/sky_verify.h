/* SPDX-License-Identifier: Apache-2.0 */
/* Errors of the tables of one sky, by comparison of look-ups with the reference. */
#ifndef NP_ATMOSPHERE_SKY_VERIFY_H
#define NP_ATMOSPHERE_SKY_VERIFY_H

#include "atmosphere/sky_query.h"

/* Relative errors of one comparison in each band, where the reference is not 0. */
typedef struct np_sky_error {
  double rms[NP_REFERENCE_BANDS]; /* without the noise of the reference */
  double worst[NP_REFERENCE_BANDS];
  double noise[NP_REFERENCE_BANDS]; /* rms of the reference's relative standard errors */
  unsigned count;
} np_sky_error;

typedef struct np_sky_errors {
  np_sky_error depths; /* depths to the top, against quadrature */
  np_sky_error view;   /* error against a march with the same moment tables */
  np_sky_error aerial; /* error against that march at distances of 1 to 128 km */
  np_sky_error all;    /* radiances as in pictures, against the path tracer */
} np_sky_errors;

/* Compares 64 directions of the observer, and traces 24 of them with `paths` paths each. */
neph_result np_sky_verify(neph_sky *sky, unsigned paths, uint64_t seed, np_monitor *monitor, np_sky_errors *out_errors);

#endif

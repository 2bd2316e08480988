/* SPDX-License-Identifier: Apache-2.0 */
/* Error of the tables of one sky, by comparing look-ups with the reference. */
#ifndef NP_ATMOSPHERE_SKY_VERIFY_H
#define NP_ATMOSPHERE_SKY_VERIFY_H

#include "atmosphere/sky_query.h"

/* Relative errors of one comparison in each band; only where the reference is not nothing. */
typedef struct np_sky_error {
  double rms[NP_REFERENCE_BANDS]; /* the reference's noise taken off */
  double worst[NP_REFERENCE_BANDS];
  double noise[NP_REFERENCE_BANDS]; /* of the reference: rms of its relative standard errors */
  unsigned count;
} np_sky_error;

typedef struct np_sky_errors {
  np_sky_error depths; /* to the top, against integrals */
  np_sky_error view;   /* against a march over the same sources */
  np_sky_error aerial; /* against the same march, to 1 to 128 km */
  np_sky_error all;    /* radiances as pictures have them, against the tracer */
} np_sky_errors;

/* Looks at 64 directions of the observer's, and traces 24 of them with `paths` paths each. */
neph_result np_sky_verify(neph_sky *sky, unsigned paths, uint64_t seed, np_monitor *monitor, np_sky_errors *out_errors);

#endif

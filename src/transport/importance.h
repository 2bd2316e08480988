/* SPDX-License-Identifier: Apache-2.0 */
/* What paths are guided by, from the solution of the multiple scattering: integrate/guide.h says how. */
#ifndef NP_TRANSPORT_IMPORTANCE_H
#define NP_TRANSPORT_IMPORTANCE_H

#include "transport/transport_level.h"

/* About what comes to a cell, in the mean of the bands that are kept: what paths are guided by (integrate/guide.h). */
typedef struct np_importance {
  float mean;         /* radiance, averaged over directions, but for sunlight that went straight on */
  float linear[3];    /* its part that is linear in the direction of flight Ω is linear·Ω */
  float quadratic[5]; /* the part of degree 2 is Σ quadratic[i]·h_i(Ω), h_i = xy, yz, 3z² − 1, xz, x² − y² */
  float lit;          /* irradiance of sunlight that went straight on, here or, the less the farther off, nearby */
} np_importance;

/* Adds one band, of the share `share` in the mean, of a solution whose sharpened moments are [active][harmonic];
 * `whole` is the sun's irradiance, of which no cell gets more. */
void np_importance_add(const np_transport_level *finest, const float *moments, float share, float whole,
                       np_importance *importance);

/* Lets sunlight be known of where paths may come to it from. */
void np_importance_spread(const np_transport_grid *grid, np_importance *importance);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Importance of cells, which guides paths, from the solution of the multiple scattering: integrate/guide.h says how. */
#ifndef NP_TRANSPORT_IMPORTANCE_H
#define NP_TRANSPORT_IMPORTANCE_H

#include "transport/scattering_field.h"
#include "transport/transport_level.h"

/* Adds one band, of the share `share` in the mean, of a solution whose sharpened moments are [active][harmonic];
 * `whole` is the sun's irradiance, of which no cell gets more. */
void np_importance_add(const np_transport_level *finest, const float *moments, float share, float whole,
                       np_importance *importance);

/* Lets sunlight be known of where paths may come to it from. */
void np_importance_spread(const np_transport_grid *grid, np_importance *importance);

#endif

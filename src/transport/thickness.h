/* SPDX-License-Identifier: Apache-2.0 */
/* Thickness of clouds from top to bottom. Light changes most along the vertical, and cells must resolve it: in fog of
 * two or three cells sunlight alone is 14 % too dark. */
#ifndef NP_TRANSPORT_THICKNESS_H
#define NP_TRANSPORT_THICKNESS_H

#include "transport/scattering_field.h"

/* Typical vertical thickness of clouds in metres: mean height of the cloud layer around a point, over the clouds'
 * volume, sampled in 32 × 32 columns. Infinite without clouds. A field whose samples are unknown counts as one
 * layer. */
double np_thickness_measure(const np_world *world, const np_transport_desc *desc);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Thickness of clouds from top to bottom. Light changes most along the vertical, and cells must resolve it: in fog of
 * two or three cells sunlight alone is 14 % too dark. */
#ifndef NP_TRANSPORT_THICKNESS_H
#define NP_TRANSPORT_THICKNESS_H

#include "transport/scattering_field.h"

/* Typical vertical thickness in metres, layer by layer: the mean over the clouds' volume of the height of the layer
 * that a point is in, of 32 × 32 columns. Infinite where there is none. A field whose samples are
 * not there yet counts as one layer. */
double np_thickness_measure(const np_world *world, const np_transport_desc *desc);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Light that comes to clouds from outside, the sun's disk excluded: sky above, ground below. */
#ifndef NP_TRANSPORT_BOUNDARY_RADIANCE_H
#define NP_TRANSPORT_BOUNDARY_RADIANCE_H

#include "transport/scattering_field.h"

/* Radiance at a place among the clouds from the direction `towards`, which looks out. */
np_spectrum np_boundary_radiance_compute(const np_world *world, const np_sun_optical_depth_source *depths,
                                         np_dvec3 position, np_vec3 towards);

/* The same along the ordinates, averaged over the solid angle around each. */
typedef float np_boundary_radiance[NP_BAND_COUNT][NP_OCTANT_COUNT][NP_ORDINATE_BLOCKS_MAX][NP_ORDINATE_LANES];
void np_boundary_radiance_fill(const np_world *world, const np_sun_optical_depth_source *depths,
                               const np_transport_desc *cells, const np_ordinates *ordinates, np_boundary_radiance out);

#endif

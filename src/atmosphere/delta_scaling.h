/* SPDX-License-Identifier: Apache-2.0 */
/* Moments of air whose aerosol scatters much of its light nearly straight on. */
#ifndef NP_ATMOSPHERE_DELTA_SCALING_H
#define NP_ATMOSPHERE_DELTA_SCALING_H

#include "atmosphere/scattering_moments.h"
#include "atmosphere/scattering_moments.h"

/* np_moment_table_build of all orders, by way of scaled air. */
neph_result np_delta_moments_build(neph_context *context, const np_depth_table *depths, const np_table_sizes *sizes,
                                   bool has_point_sun, np_monitor *monitor, np_moment_table *out_table);

#endif

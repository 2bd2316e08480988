/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NP_ATMOSPHERE_MIE_GATHER_BUILD_H
#define NP_ATMOSPHERE_MIE_GATHER_BUILD_H

#include "atmosphere/sky_trace.h"

/* Gathers for suns evenly spread over zenith angles `sun_zenith_rad` ± `spread_rad`: in passes, so that each
 * sees the aerosol's light as the one before found it. `dome_moments` are those of the sky that is gathered: `moments`
 * themselves or, where orders are limited, one order less, NULL for none. `disk` is the sun's. */
neph_result np_gather_table_build(neph_context *context, const np_depth_table *depths, const np_moment_table *moments,
                                  const np_moment_table *dome_moments, const np_gather_kernel *kernel,
                                  double sun_zenith_rad, double spread_rad, np_sun_disk disk, np_monitor *monitor,
                                  np_gather_table *out_table);

#endif

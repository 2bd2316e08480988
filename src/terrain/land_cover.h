/* SPDX-License-Identifier: Apache-2.0 */
/* Land cover by climate: classes of vegetation, fields, sand, rock and snow, each a row with the elevations, slopes and
 * patches where it lies over the rows before it. Its albedo varies by noise over octaves of 1 m to 1 km, as far as the
 * footprint of a pixel resolves them. */
#ifndef NP_TERRAIN_LAND_COVER_H
#define NP_TERRAIN_LAND_COVER_H

#include <nephos/terrain.h>

#include "noise/noise.h"
#include "terrain/cover_place.h"

void np_land_cover_eval(neph_ground_cover climate, const np_noise_table *noise, const np_cover_place *place,
                        float out_albedo[3]);

/* Roughness of the surface (world/ground_brdf.h); 0 without a climate. */
float np_land_cover_get_roughness(neph_ground_cover climate);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Light that the ground at the ends of a dome's rays sends back, into the aerosol's gather (mie_gather.h).
 *
 * Land is Lambertian. Water sends the sun's beam back as glint, within some 20° of the mirrored direction, where even
 * ground of the same albedo sends it everywhere: forward scattering in haze keeps that difference in the sky. The glint
 * is averaged over the part of the hemisphere that a ray of the dome stands for, since the rule does not resolve it.
 *
 * Skylight is split in two. What a direction has in excess of the one at the same height on the other side of the
 * zenith is the haze's own forward scattering, and is reflected as part of the beam; the rest comes from all azimuths
 * alike, most of it from low angles at which water reflects more, and is reflected evenly. */
#ifndef NP_ATMOSPHERE_GATHER_GROUND_H
#define NP_ATMOSPHERE_GATHER_GROUND_H

#include "atmosphere/gather_kernel.h"
#include "atmosphere/sky_trace.h"
#include "optics/water.h"

/* Skylight on water, of a sky under one sun. */
typedef struct np_water_skylight {
  np_bands beam; /* share of its irradiance that comes with the sun's beam */
  np_bands gain; /* what water reflects of the rest, over what it reflects of an even sky */
} np_water_skylight;

/* Splits the skylight of a dome at the lowest altitude, `dome` in rows × azimuths. */
np_water_skylight np_gather_ground_split(const np_gather_kernel *kernel, const np_water *water,
                                         const np_scattered *dome, const np_bands *phase);

/* Adds to each ray of a fan the sunlight and skylight that the ground reflects along it, where row `row` of the dome at
 * an altitude hits the ground. `water` NULL: the ground is land, and `skylight` is not read. */
void np_gather_ground_add(const np_gather_kernel *kernel, const np_sky_light *light, const np_water *water,
                          const np_water_skylight *skylight, int altitude, int row, const np_fan *fan,
                          np_scattered *sums);

#endif

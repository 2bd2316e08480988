/* SPDX-License-Identifier: Apache-2.0 */
/* Light that the ground at the ends of a dome's rays sends back, into the aerosol's gather (mie_gather.h).
 *
 * Land is Lambertian. Water, on a share of the ground, sends the sun's beam back as glint, within some 20° of the
 * mirrored direction, where even ground of the same albedo sends it everywhere: forward scattering in haze keeps that
 * difference in the sky. The glint is averaged over the part of the hemisphere that a ray of the dome stands for, since
 * the rule does not resolve it.
 *
 * Skylight is reflected direction by direction: waves send a mean of the dome's light around the mirrored direction
 * towards each view. It is a quotient of sums over the dome's rule, in which the rule's error cancels. */
#ifndef NP_ATMOSPHERE_GATHER_GROUND_H
#define NP_ATMOSPHERE_GATHER_GROUND_H

#include "atmosphere/gather_kernel.h"
#include "atmosphere/sea.h"
#include "atmosphere/sky_trace.h"

enum {
  NP_GATHER_VIEWS = 8, /* cosines of views of the water, even in their root */
  NP_GATHER_TURNS_MAX = 16
};

/* Shares of the dome's directions in what water reflects towards a view. */
typedef struct np_water_mirror {
  neph_context *context; /* borrowed */
  float *weight;         /* [view][turn][row of the upper dome × azimuths], owned; a view's sum is its reflectance */
} np_water_mirror;

/* Skylight that water reflects, of a sky under one sun: radiance over the irradiance of the sky, 1/sr. */
typedef struct np_water_skylight {
  np_bands reflected[NP_GATHER_VIEWS][NP_GATHER_TURNS_MAX];
} np_water_skylight;

/* Computes the shares for domes at the lowest altitude. */
neph_result np_water_mirror_init(neph_context *context, const np_gather_kernel *kernel, const np_water *water,
                                 np_water_mirror *out);
void np_water_mirror_clear(np_water_mirror *mirror);

/* Reflects the light of a dome at the lowest altitude, in rows × azimuths. */
void np_water_mirror_reflect(const np_water_mirror *mirror, const np_gather_kernel *kernel, const np_scattered *dome,
                             const np_bands *phase, np_water_skylight *out);

/* Adds to each ray of a fan the sunlight and skylight that the ground reflects along it, where row `row` of the dome at
 * an altitude hits the ground. `sea` NULL: the ground is land, and `skylight` is not read. */
void np_gather_ground_add(const np_gather_kernel *kernel, const np_sky_light *light, const np_sea *sea,
                          const np_water_skylight *skylight, int altitude, int row, const np_fan *fan,
                          np_scattered *sums);

#endif

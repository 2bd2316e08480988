/* SPDX-License-Identifier: Apache-2.0 */
/* In-scatter and transmittance of a single ray from any position, for rays that do not start at a sky's observer. */
#ifndef NP_ATMOSPHERE_SKY_ALONG_H
#define NP_ATMOSPHERE_SKY_ALONG_H

#include "atmosphere/atmosphere_private.h"

/* In-scatter and transmittance from a point up to a distance, which may be infinite. They are integrated from the
 * sources behind the sky's tables, with as many points as a row of its view, or fewer up to a near end; takes a
 * microsecond or some. */
np_aerial_perspective np_sky_trace_air(const neph_sky *sky, np_dvec3 origin, np_vec3 direction, double distance_m);

/* Optical depth of what aerosols scatter nearly straight on beyond which that has spread too far to go on as if it were
 * not scattered: it counts as this. */
#define NP_STRAIGHT_DEPTH_MAX 2.5f

/* Light of the air along a ray. */
typedef struct np_air_parts {
  np_spectrum transmittance;
  np_spectrum all, first;   /* in-scatter of all orders, and of the first, W m⁻² sr⁻¹ nm⁻¹ */
  np_spectrum upper, lower; /* radiance that the air scatters per actinic flux of light from one hemisphere, equal in
                               all its directions, 1/sr: ∫ T·σ·share/2π dt */
  np_spectrum straight;     /* optical depth of what aerosols scatter nearly straight on, up to NP_STRAIGHT_DEPTH_MAX */
  np_spectrum turned_upper, turned_lower; /* the same as upper and lower, but that light counts as not scattered */
} np_air_parts;

/* The parts of the light up to each of `count` ascending distances. */
void np_sky_trace_parts(const neph_sky *sky, np_dvec3 origin, np_vec3 direction, const double *distances_m, int count,
                        const np_hemisphere_shares *shares, np_air_parts *out);

/* Share of light that passes a length of the air at its middle, with what aerosols scatter nearly straight on. */
np_spectrum np_air_cell_get_passed(const neph_atmosphere *atmosphere, np_dvec3 middle, double length_m);

/* Radiance that a cell of the air scatters per actinic flux of light, 1/sr: of light from one hemisphere, equal in all
 * its directions, but what aerosols scatter nearly straight on, and of a beam. That share of the aerosols' scattering
 * is χ₂, as in the delta-Eddington approximation (Joseph, Wiscombe and Weinman 1976). */
typedef struct np_air_cell {
  np_spectrum upper, lower, beam;
  np_spectrum forward; /* optical depth of what is scattered nearly straight on */
} np_air_cell;

/* A beam: versine of the angle by which it is scattered, and mean cosine of its directions to their middle, 1 where
 * they are one, 0 where they are spread all around. */
typedef struct np_air_beam {
  float versine, mean_cosine;
} np_air_beam;

/* Optical depth of what aerosols scatter nearly straight on from a height to space, in a direction; below 1° over the
 * horizon that of 1°. */
np_spectrum np_atmosphere_get_forward_depth(const neph_atmosphere *atmosphere, double height_m, np_vec3 direction);

/* A cell as long as `length_m` of the air at its middle, of a ray that rises by `rise` a length. `*transmittance`: of
 * the air before it, and then behind it. */
np_air_cell np_air_cell_cross(const neph_atmosphere *atmosphere, np_dvec3 middle, double length_m,
                              const np_hemisphere_shares *shares, float rise, const np_air_beam *beam,
                              np_spectrum *transmittance);

#endif

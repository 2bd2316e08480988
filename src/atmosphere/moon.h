/* SPDX-License-Identifier: Apache-2.0 */
/* Photometry of the moon: irradiance, and radiance over its disk. */
#ifndef NP_ATMOSPHERE_MOON_H
#define NP_ATMOSPHERE_MOON_H

#include "atmosphere/disk.h"

/* Brightness at a phase angle relative to full moon, in visible light. */
double np_moon_phase_factor(double phase_angle_rad);

/* Irradiance above the atmosphere from the moon's sunlit part, on a plane that faces it, relative to the sun's. */
double np_moon_irradiance_ratio(const np_moon_place *moon, double wavelength_nm);

/* Disk of the moon under a sun of `sun_irradiance`, which integrates to `out_irradiance`. `map` NULL: uniform; else its
 * texels, divided by their mean, multiply the albedo; borrowed. */
np_disk np_moon_make_disk(const np_moon_place *moon, np_spectrum sun_irradiance,
                          const double wavelength_nm[NP_BAND_COUNT], bool has_earthshine, const np_sphere_map *map,
                          np_spectrum *out_irradiance);

/* A moon at mean distance in a given direction, lit by a sun in another, with its north pole up. */
np_moon_place np_moon_place_between(np_dvec3 direction, np_dvec3 to_sun);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Brightness of the moon, as a whole and from point to point. */
#ifndef NP_ATMOSPHERE_MOON_H
#define NP_ATMOSPHERE_MOON_H

#include "atmosphere/disk.h"

/* Brightness at a phase angle over that of the full moon, in the visible. */
double np_moon_phase_factor(double phase_angle_rad);

/* Irradiance above the atmosphere, on a plane facing the moon, of its sunlit part, over that of the sun. */
double np_moon_irradiance_ratio(const np_moon_place *moon, double wavelength_nm);

/* The moon under a sun of `sun_irradiance`: its disk, which integrates to `out_irradiance`. `map` NULL: plain; else its
 * texels over their mean take the place of an even albedo; borrowed. */
np_disk np_moon_make_disk(const np_moon_place *moon, np_spectrum sun_irradiance,
                          const double wavelength_nm[NP_BAND_COUNT], bool has_earthshine, const np_sphere_map *map,
                          np_spectrum *out_irradiance);

/* A moon at mean distance that stands in a direction while the sun stands in another, its north pole upwards. */
np_moon_place np_moon_place_between(np_dvec3 direction, np_dvec3 to_sun);

#endif

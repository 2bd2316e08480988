/* SPDX-License-Identifier: Apache-2.0 */
/* The disk of a light as it is seen: even, the sun's, which darkens towards its limb, or the moon's, lit from one side.
 *
 * However it is shaded, the disk's radiance times cosine integrates to its irradiance.
 */
#ifndef NP_ATMOSPHERE_DISK_H
#define NP_ATMOSPHERE_DISK_H

#include "atmosphere/celestial.h"
#include "atmosphere/sphere_map.h"
#include "core/spectrum.h"

enum { NP_LIMB_TERMS = 6 };

typedef enum np_disk_kind { NP_DISK_EVEN, NP_DISK_SUN, NP_DISK_MOON } np_disk_kind;

typedef struct np_disk {
  np_disk_kind kind;
  np_vec3 direction;    /* towards its centre */
  float versine;        /* 1 − cos of its angular radius; 0: a point, which no ray can meet */
  np_spectrum radiance; /* its mean; of the moon, that of a point which sun and observer are at equal angles to */
  float limb[NP_BAND_COUNT][NP_LIMB_TERMS]; /* of the sun: coefficients of powers of the cosine, mean 1 */
  np_spectrum earthshine;                   /* of the moon: all over it */
  np_vec3 to_sun;                           /* from the moon */
  np_vec3 axes[3];                          /* of the moon */
  const np_sphere_map *map;                 /* of the moon's albedo, NULL: plain; borrowed */
} np_disk;

/* Irradiance is that on a plane facing the disk. */
np_disk np_disk_make(np_vec3 direction, double angular_radius_rad, np_spectrum irradiance);

/* The same for the sun, each band at its wavelength, 300 to 1100 nm. */
np_disk np_disk_make_sun(np_vec3 direction, double angular_radius_rad, np_spectrum irradiance,
                         const double wavelength_nm[NP_BAND_COUNT]);

bool np_disk_covers(const np_disk *disk, np_vec3 direction);

/* Radiance along a direction above the atmosphere, zero beside the disk. */
np_spectrum np_disk_radiance(const np_disk *disk, np_vec3 direction);

/* Coefficients of the sun's darkening at one wavelength, as powers of the cosine between sight and normal; 1 at the
 * centre of the disk. */
void np_limb_darkening(double wavelength_nm, double out_coefficient[NP_LIMB_TERMS]);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* The visible disk of a light: uniform, the sun with limb darkening, or the moon with its phase.
 *
 * With any shading, the disk's radiance times cosine integrates to its irradiance. */
#ifndef NP_ATMOSPHERE_DISK_H
#define NP_ATMOSPHERE_DISK_H

#include "atmosphere/celestial.h"
#include "atmosphere/sphere_map.h"
#include "core/spectrum.h"

enum { NP_LIMB_TERMS = 6 };

typedef enum np_disk_kind { NP_DISK_EVEN, NP_DISK_SUN, NP_DISK_MOON } np_disk_kind;

typedef struct np_disk {
  np_disk_kind kind;
  np_vec3 direction;    /* unit vector towards its centre */
  float versine;        /* 1 − cos of the angular radius; 0: a point, which no ray hits */
  np_spectrum radiance; /* mean radiance; for the moon, at a point with equal angles to sun and observer */
  float limb[NP_BAND_COUNT]
            [NP_LIMB_TERMS]; /* limb darkening of the sun: coefficients of powers of the cosine, with mean 1 */
  np_spectrum earthshine;    /* uniform radiance of earthshine on the moon */
  np_vec3 to_sun;            /* unit vector towards the sun at the moon */
  np_vec3 axes[3];           /* axes of the moon */
  const np_sphere_map *map;  /* map of the moon's albedo, NULL: uniform; borrowed */
} np_disk;

/* Creates a uniform disk. `irradiance` is on a plane that faces it. */
np_disk np_disk_make(np_vec3 direction, double angular_radius_rad, np_spectrum irradiance);

/* Creates the sun's disk, with limb darkening at the wavelength of each band, 300 to 1100 nm. */
np_disk np_disk_make_sun(np_vec3 direction, double angular_radius_rad, np_spectrum irradiance,
                         const double wavelength_nm[NP_BAND_COUNT]);

bool np_disk_covers(const np_disk *disk, np_vec3 direction);

/* Radiance along a direction above the atmosphere; zero outside of the disk. */
np_spectrum np_disk_radiance(const np_disk *disk, np_vec3 direction);

/* Coefficients of the sun's limb darkening at one wavelength, for powers of the cosine between view direction and
 * normal; the sum at the disk's centre is 1. */
void np_limb_darkening(double wavelength_nm, double out_coefficient[NP_LIMB_TERMS]);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Map from the coordinate system of a raster of heights to the world, by which a file in the same system is placed on
 * the ground. */
#ifndef NP_TERRAIN_RASTER_LATTICE_H
#define NP_TERRAIN_RASTER_LATTICE_H

#include "terrain/heightfield.h"

typedef struct np_raster_lattice {
  bool is_projected; /* false: the system is geographic or unknown, and the other members are unset */
  char crs[120];
  np_heightfield field; /* field without samples: it owns nothing */
  np_globe globe;
  double to_position[2][3]; /* column and row from x, y and 1 */
} np_raster_lattice;

/* Loads the lattice from the headers of a raster. */
neph_result np_raster_lattice_load(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                   np_raster_lattice *out);

/* Position among the samples for coordinates in the raster's system. */
np_field_position np_raster_lattice_locate(const np_raster_lattice *lattice, double x, double y);

/* World position for coordinates in the raster's system, `z_m` above the sphere. */
np_dvec3 np_raster_lattice_place(const np_raster_lattice *lattice, double x, double y, double z_m);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Coordinates of the system that a raster of heights is in, as places of the world: by them a file of the same system
 * stands on the ground that the raster is. */
#ifndef NP_TERRAIN_RASTER_LATTICE_H
#define NP_TERRAIN_RASTER_LATTICE_H

#include "terrain/heightfield.h"

typedef struct np_raster_lattice {
  bool is_projected; /* else it is geographic, or has no place, and the rest is not set */
  char crs[120];
  np_heightfield field; /* without samples: nothing is owned */
  np_globe globe;
  double to_position[2][3]; /* column and row of x, y and 1 */
} np_raster_lattice;

/* Reads the headers of a raster alone. */
neph_result np_raster_lattice_load(neph_context *context, const char *path, const neph_terrain_desc *desc,
                                   np_raster_lattice *out);

/* Position among the samples of a place by its coordinates in the raster's system. */
np_field_position np_raster_lattice_locate(const np_raster_lattice *lattice, double x, double y);

/* World position of such a place, `z_m` above the sphere. */
np_dvec3 np_raster_lattice_place(const np_raster_lattice *lattice, double x, double y, double z_m);

#endif

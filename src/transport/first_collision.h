/* SPDX-License-Identifier: Apache-2.0 */
/* The rays by which sunlight is followed to where it first collides. */
#ifndef NP_TRANSPORT_FIRST_COLLISION_H
#define NP_TRANSPORT_FIRST_COLLISION_H

#include "transport/transport_grid.h"

/* Sunlight that a cell scatters first, in whole units of 2⁻³²: sums of integers come out the same in any order,
 * whatever thread adds them. The moments are about the cell's middle, over its widths. */
typedef struct np_first_loss {
  int64_t sum, moment[3];
} np_first_loss;

/* One scaled medium that the rays cross. */
typedef struct np_first_medium {
  float scale[NP_INSTANCES_MAX]; /* scaled extinction of each cloud over its extinction */
  np_first_loss *losses;         /* losses in each active cell by one face's rays */
  float *power;                  /* power that each active cell takes from sunlight of unit irradiance, m² */
  float *moment; /* [active][axis]: first moment of that power about the cell's middle, over the cell's width */
} np_first_medium;

enum { NP_FIRST_MEDIA = 2 };

/* Excess of the second medium's transmittance over the first's in an active cell, integrated over the lit length of
 * rays, and that length, in units of a loss times the longest step; the sums over all faces' rays in m³. */
typedef struct np_first_surplus {
  int64_t sum, length;
  double volume, of_volume;
} np_first_surplus;

/* Parallel rays start on every face that the sun shines on, at the points of a lattice, each for an equal area. */
typedef struct np_first_rays {
  const np_world *world;
  const np_sun_optical_depth_source *depths; /* depths before active cells; NULL: rays start in full sunlight */
  np_monitor *monitor;
  np_transport_grid *grid;
  np_first_medium media[NP_FIRST_MEDIA];
  unsigned media_count;
  np_first_surplus *surpluses; /* surplus of each active cell; NULL: there is one medium */
  double direction[3];         /* direction of flight */
  double step_m;               /* the longest */
  bool has_even_steps;         /* none is shorter but a ray's last */
  int face_axis;
  size_t rows, columns; /* rows and columns of the rays that start on the face */
} np_first_rays;

#endif

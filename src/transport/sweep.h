/* SPDX-License-Identifier: Apache-2.0 */
/* One pass of the discrete ordinates through the cells: from sources to moments of the radiance. */
#ifndef NP_TRANSPORT_SWEEP_H
#define NP_TRANSPORT_SWEEP_H

#include "core/parallel.h"
#include "transport/border.h"
#include "transport/cell_air.h"

enum {
  NP_SWEEP_TILE_Y = 4, /* rows along y, and along z, that are swept in one go */
  NP_SWEEP_TILE_Z = 2
};

/* Faces between rows, across y [k][i]; across z [j][i]; and, of wrapped axes, across x [k][j]: eight lanes each. */
typedef struct np_sweep_faces {
  float *x, *y, *z; /* each begins with [octant of the pair][block] */
} np_sweep_faces;

/* Rows that are swept in one go, for a pair of octants. Tiles are numbered in the order of the light's direction. */
typedef struct np_sweep_tile {
  uint8_t pair;
  bool is_first; /* no other pair has come to these rows before */
  int32_t y, z;
} np_sweep_tile;

typedef struct np_sweep {
  neph_context *context;
  np_monitor *monitor;
  const np_transport_grid *grid;
  const np_ordinates *ordinates;
  int32_t *reach[NP_OCTANT_COUNT]; /* number of cells of each row [k][j], from the side where light enters to the last
                                      cell from which it can reach a cloud */
  size_t tile_count;
  np_sweep_tile *tiles; /* in an order in which each follows the tiles that it waits for */
  np_waits *waits;      /* indices of these, of each tile */
  float *inverse_m[3];  /* 1/width of the cells along each axis; 0 where a cell's width does not matter to light */
  np_sweep_faces faces[NP_OCTANT_PAIRS];
  float *rows;                   /* scratch of each thread: of the cells along x, two octants' lanes */
  float *out;                    /* moments, [active][harmonic], in the ordinates' order */
  const float *source;           /* [active][harmonic]: moments of emitted and scattered light, per metre */
  const np_border_faces *border; /* radiance from outside */
  const np_column_light *ground; /* light from ground in or below a column [j][i]; NULL: none is near */
  np_cell_air air;               /* light of the air in void cells; `source` has that of others */
} np_sweep;

/* Prepares a sweep; the caller sets `source`, `border`, `ground` and `out`, and keeps `air`. On failure nothing needs
 * to be freed. */
neph_result np_sweep_init(neph_context *context, np_monitor *monitor, const np_transport_grid *grid,
                          const np_ordinates *ordinates, const np_cell_air *air, np_sweep *out);
void np_sweep_clear(np_sweep *sweep);

/* Sweeps all directions. What leaves through a wrapped side comes in through the other in the next sweep. */
neph_result np_sweep_run(np_sweep *sweep);

/* Irradiance that left the cells in the last sweep, down through their bottom or on ground within them, and up through
 * their top: means over the squares of the plan. Light that can come to no more cloud is taken to go straight on. */
void np_sweep_measure_outflow(const np_sweep *sweep, np_outflow *out);

#endif

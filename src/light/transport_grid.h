/* SPDX-License-Identifier: Apache-2.0 */
/* The coarse cells on which scattered light is solved for, and what the clouds put into them. */
#ifndef NP_LIGHT_TRANSPORT_GRID_H
#define NP_LIGHT_TRANSPORT_GRID_H

#include "core/parallel.h"
#include "light/scaled_phase.h"
#include "light/scene_view.h"

enum { NP_TRANSPORT_CELL_NONE = -1 };

/* World-aligned cells, x fastest. Only live ones, which hold cloud or touch a cell that does, keep anything. */
typedef struct np_transport_grid {
  neph_context *context; /* borrowed */
  int32_t size[3];
  double origin_m[3], cell_m[3];
  bool is_wrapped[3]; /* periodic along this axis */
  int32_t *live;      /* of each cell: its number among the live ones, or NP_TRANSPORT_CELL_NONE */
  int32_t *cell;      /* of each live cell: where it is */
  size_t live_count;
  float *extinction;                   /* scaled, 1/m, the mean of the interpolated field */
  float (*ratio)[NP_HARMONIC_DEGREES]; /* scattering moment over extinction, both scaled */
  float *deposit; /* first collisions of sunlight per volume, 1/m, for a unit irradiance; NULL in coarse grids */
} np_transport_grid;

typedef struct np_transport_desc {
  np_dvec3 bounds_min, bounds_max; /* of the clouds, in the world */
  size_t cell_count_max;
  size_t cell_count_cheap; /* cells of one voxel where so many are enough */
  double cell_depth_max;   /* of a cell, (1−g)·σ·edge, where the memory allows */
} np_transport_desc;

/* Chooses cells; fills `size`, `origin_m`, `cell_m` and `is_wrapped`. */
void np_transport_grid_place(const np_scene_view *view, const np_transport_desc *desc, np_transport_grid *grid);

/* Averages the clouds' extinction and scattering over the cells, for the albedo of one band. Cells that glow are live
 * too. */
neph_result np_transport_grid_fill(const np_scene_view *view, const np_scaled_phase *phases, unsigned band,
                                   np_monitor *monitor, np_transport_grid *grid);

/* The mean j of what glows in a cell. */
float np_transport_grid_average_emission(const np_transport_grid *grid, const struct np_emission *emission,
                                         const int32_t cell[3], unsigned band);

/* Follows the sun's rays and puts where they first collide into `deposit`. */
neph_result np_transport_grid_light(const np_scene_view *view, const np_scaled_phase *phases, unsigned band,
                                    np_monitor *monitor, np_transport_grid *grid);

/* Cells of twice the edge. False where a side is odd: then there is none, and `out` is untouched. */
neph_result np_transport_grid_coarsen(const np_transport_grid *fine, np_transport_grid *out);
bool np_transport_grid_can_coarsen(const np_transport_grid *grid);

/* Means over the eight finer cells of what is kept by live cell, `width` floats each. */
void np_transport_grid_restrict(const np_transport_grid *fine, const float *values, unsigned width,
                                const np_transport_grid *coarse, float *out);

void np_transport_grid_clear(np_transport_grid *grid);

static inline np_dvec3 np_transport_grid_centre(const np_transport_grid *grid, int32_t cell) {
  const int32_t i = cell % grid->size[0], j = cell / grid->size[0] % grid->size[1],
                k = cell / grid->size[0] / grid->size[1];
  return np_dvec3_make(grid->origin_m[0] + (i + 0.5) * grid->cell_m[0], grid->origin_m[1] + (j + 0.5) * grid->cell_m[1],
                       grid->origin_m[2] + (k + 0.5) * grid->cell_m[2]);
}

/* The live cells around a position and their trilinear weights, which add up to 1; returns how many, 0 to 8. */
static inline unsigned np_transport_grid_find(const np_transport_grid *grid, np_dvec3 position, int32_t out_live[8],
                                              float out_weight[8]) {
  const double p[3] = {position.x, position.y, position.z};
  int32_t index[3][2];
  float weight[3][2], total = 0.0f;
  for (int a = 0; a < 3; a++) {
    const double u = (p[a] - grid->origin_m[a]) / grid->cell_m[a] - 0.5;
    const double lower = floor(np_clamp(u, -1e9, 1e9));
    weight[a][1] = (float)(u - lower);
    weight[a][0] = 1.0f - weight[a][1];
    for (int e = 0; e < 2; e++) {
      int32_t i = (int32_t)lower + e;
      if (grid->is_wrapped[a]) {
        i %= grid->size[a];
        i += i < 0 ? grid->size[a] : 0;
      }
      index[a][e] = i < 0 ? 0 : i < grid->size[a] ? i : grid->size[a] - 1;
    }
  }
  unsigned count = 0;
  for (unsigned corner = 0; corner < 8; corner++) {
    const unsigned x = corner & 1u, y = corner >> 1 & 1u, z = corner >> 2;
    const float w = weight[0][x] * weight[1][y] * weight[2][z];
    const int32_t live = grid->live[(index[2][z] * grid->size[1] + index[1][y]) * grid->size[0] + index[0][x]];
    if (live < 0 || !(w > 0.0f)) continue;
    out_live[count] = live;
    out_weight[count++] = w;
    total += w;
  }
  for (unsigned i = 0; i < count; i++) out_weight[i] /= total;
  return count;
}

#endif

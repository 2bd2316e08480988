/* SPDX-License-Identifier: Apache-2.0 */
/* The coarse cells on which scattered light is solved for, and what the clouds put into them. */
#ifndef NP_TRANSPORT_TRANSPORT_GRID_H
#define NP_TRANSPORT_TRANSPORT_GRID_H

#include "transport/scaled_phase.h"
#include "transport/scattering_field.h"
#include "volume/instance_period.h"

enum {
  NP_TRANSPORT_CELL_NONE = -1, /* void */
  NP_TRANSPORT_CELL_SOLID = -2 /* ground */
};

/* World-aligned cells between planes, x fastest. Only active ones, which hold cloud or touch a cell that does, keep
 * anything. */
typedef struct np_transport_grid {
  neph_context *context; /* borrowed */
  int32_t size[3];
  double *edge_m[3];  /* size + 1 ascending planes of each axis */
  double even_m[3];   /* distance of the planes; 0 where they are not even */
  int32_t used[3];    /* cells that clouds may lie in; the others pad the count, and are thin where planes are even */
  bool is_wrapped[3]; /* periodic along this axis */
  double repeat_m[3]; /* length of the end of a wrapped axis that stands for all beyond; 0: all of it */
  bool has_ground;    /* some cells may be ground, or ground is close below them; all cells below ground are ground */
  bool is_fine;       /* light is iterated on cells twice as wide */
  bool is_flat;       /* the clouds are an eighth as thick as their box is wide, or less */
  np_transport_fold fold; /* tiles of which the cells hold one; a period of 0: none */
  unsigned degree;        /* N: of the harmonics that light is resolved into */
  int32_t *active;        /* index of each cell among the active ones; negative for empty cells and ground */
  int32_t *cell;          /* place of each active cell */
  size_t active_count;
  float *extinction;             /* scaled, 1/m, the mean of the interpolated field */
  float *transport_depth;        /* transport mean free paths across each active cell, none limited; NULL: unknown */
  float *ratio;                  /* [active][l], l ≤ N: scattering moment over extinction, both scaled */
  float scale[NP_INSTANCES_MAX]; /* scaled extinction of each cloud over its extinction */
  float *first_collision_source; /* first collisions of sunlight per volume, 1/m, for a unit irradiance; NULL in coarse
                                    grids */
  float *low_order_source;       /* first_collision_source in a medium of a lower degree; NULL: there is none */
  float *delta_m_residual; /* sunlight scattered narrowly, its mean over the cell for a unit irradiance: what a medium
                    of a lower degree lets through beyond this one; NULL: there is none */
} np_transport_grid;

/* Chooses cells: fills `size`, the planes and `is_wrapped`. */
neph_result np_transport_grid_place(neph_context *context, const np_world *world, const np_transport_desc *desc,
                                    np_transport_grid *out);

/* Whether clouds do not change along an axis: they repeat with every voxel. It has one cell then. */
bool np_transport_is_single(const np_world *world, int axis);

/* (1−g)·σ at the densest point, 1/m. */
double np_transport_compute_extinction(const np_world *world);

/* Share of the longest edge of a voxel by which its depth counts: 1, less where voxels are stretched. */
double np_transport_get_stretch(const np_world *world);

/* (1−g)·σ·edge of the smallest and of the largest cells, at the densest point. */
void np_transport_grid_compute_depths(const np_world *world, const np_transport_grid *grid, double *out_least,
                                      double *out_most);

/* Relative error of a picture by cells of this optical depth, fitted to clouds on coarsened grids
 * (docs/transport.md). */
double np_transport_expect_error(double cell_depth);

/* Mean of `transport_depth` over the cells, by the sunlight that collides first in each; infinite without sunlight. */
double np_transport_grid_compute_lit_depth(const np_transport_grid *grid);

/* Relative error as np_transport_expect_error computes it. For cells deeper than measured ones it depends on the depth
 * of cells at the sunlit surface, and is larger for decks (np_transport_grid's `is_flat`). */
double np_transport_expect_deep_error(double cell_depth, double lit_depth, bool is_flat);

/* Bytes that a cell with cloud takes at most where light of a degree is iterated, coarser cells included, and where it
 * is but swept. */
double np_transport_count_iterated_bytes(unsigned degree);
double np_transport_count_swept_bytes(unsigned degree);

/* Averages the clouds' extinction and scattering over the cells, for the albedo of one band. `phases` have the degree
 * of the grid. Cells that emit are active too. */
neph_result np_transport_grid_fill(const np_world *world, const np_scaled_phase *phases, unsigned band,
                                   np_monitor *monitor, np_transport_grid *grid);

/* The mean j of the emission in a cell. */
float np_transport_grid_average_emission(const np_transport_grid *grid, const struct np_emission *emission,
                                         const int32_t at[3], unsigned band);

/* Copies a grid with light resolved into a lower degree, for which more of the scattering counts as unscattered. The
 * values of active cells equal those of np_transport_grid_fill() with phase functions of that degree. */
neph_result np_transport_grid_reduce_degree(const np_world *world, unsigned band, unsigned degree,
                                            const np_transport_grid *fine, np_transport_grid *out);

/* Traces the sun's rays and fills `first_collision_source`; if `broad_degree` is lower than the grid's, also
 * `low_order_source` of a medium of that degree, and `delta_m_residual`. `depths` is that of the clouds beyond the
 * cells of one tile. */
neph_result np_transport_grid_light(const np_world *world, const np_sun_optical_depth_source *depths,
                                    np_monitor *monitor, unsigned band, unsigned broad_degree, np_transport_grid *grid);

/* Cells of two of the old along each axis. False where a side is odd: then there is none, and `out` is untouched. */
neph_result np_transport_grid_coarsen(const np_transport_grid *fine, np_transport_grid *out);
bool np_transport_grid_can_coarsen(const np_transport_grid *grid);

/* Means of a quantity of active cells over the cells of a coarser grid. */
void np_transport_grid_restrict(const np_transport_grid *fine, const float *values, const np_transport_grid *coarse,
                                float *out);

void np_transport_grid_clear(np_transport_grid *grid);

/* Smallest sample spacing along a world axis, among samples that matter for multiple scattering. */
double np_transport_get_voxel(const np_world *world, int axis);

/* Scaled extinction over extinction, in one cloud, where a share `forward` of scattering goes straight on. */
static inline float np_transport_scale(const np_instance *volume, float forward, unsigned band) {
  return 1.0f - volume->albedo.band[band] * forward;
}

static inline size_t np_transport_grid_count(const np_transport_grid *grid) {
  return (size_t)grid->size[0] * (size_t)grid->size[1] * (size_t)grid->size[2];
}

static inline double np_transport_grid_width(const np_transport_grid *grid, int axis, int32_t index) {
  return grid->edge_m[axis][index + 1] - grid->edge_m[axis][index];
}

/* Coordinate at which the cells that clouds may lie in end. */
static inline double np_transport_grid_get_end(const np_transport_grid *grid, int axis) {
  return grid->edge_m[axis][grid->used[axis]];
}

/* Extent of all cells along an axis. */
static inline double np_transport_grid_length(const np_transport_grid *grid, int axis) {
  return grid->edge_m[axis][grid->size[axis]] - grid->edge_m[axis][0];
}

static inline double np_transport_grid_middle(const np_transport_grid *grid, int axis, int32_t index) {
  return 0.5 * (grid->edge_m[axis][index] + grid->edge_m[axis][index + 1]);
}

static inline void np_transport_grid_split(const np_transport_grid *grid, int32_t cell, int32_t out_at[3]) {
  out_at[0] = cell % grid->size[0];
  out_at[1] = cell / grid->size[0] % grid->size[1];
  out_at[2] = cell / grid->size[0] / grid->size[1];
}

static inline size_t np_transport_grid_join(const np_transport_grid *grid, const int32_t at[3]) {
  return ((size_t)at[2] * (size_t)grid->size[1] + (size_t)at[1]) * (size_t)grid->size[0] + (size_t)at[0];
}

/* Active neighbour along an axis; negative: none. */
static inline int32_t np_transport_grid_neighbour(const np_transport_grid *grid, const int32_t at[3], int axis,
                                                  int step) {
  int32_t next[3] = {at[0], at[1], at[2]};
  next[axis] += step;
  if (grid->is_wrapped[axis]) next[axis] = (next[axis] + grid->size[axis]) % grid->size[axis];
  const bool is_inside = next[axis] >= 0 && next[axis] < grid->size[axis];
  return is_inside ? grid->active[np_transport_grid_join(grid, next)] : NP_TRANSPORT_CELL_NONE;
}

static inline np_dvec3 np_transport_grid_centre(const np_transport_grid *grid, int32_t cell) {
  int32_t at[3];
  np_transport_grid_split(grid, cell, at);
  return np_dvec3_make(np_transport_grid_middle(grid, 0, at[0]), np_transport_grid_middle(grid, 1, at[1]),
                       np_transport_grid_middle(grid, 2, at[2]));
}

/* Brings a coordinate into the period of a wrapped axis. */
static inline double np_transport_grid_wrap(const np_transport_grid *grid, int axis, double x) {
  if (!grid->is_wrapped[axis]) return x;
  const double low = grid->edge_m[axis][0], period = np_transport_grid_length(grid, axis);
  return x - floor((x - low) / period) * period;
}

/* The cell of a coordinate along an axis: −1 or `size` outside. */
static inline int32_t np_transport_grid_locate(const np_transport_grid *grid, int axis, double x) {
  const double *edge = grid->edge_m[axis];
  const int32_t size = grid->size[axis];
  x = np_transport_grid_wrap(grid, axis, x);
  if (grid->even_m[axis] > 0.0) return (int32_t)np_clamp(floor((x - edge[0]) / grid->even_m[axis]), -1.0, (double)size);
  if (!(x >= edge[0])) return -1;
  if (x >= edge[size]) return size;
  int32_t low = 0, high = size;
  while (high - low > 1) {
    const int32_t middle = (low + high) / 2;
    x < edge[middle] ? (high = middle) : (low = middle);
  }
  return low;
}

/* The two cells whose middles a coordinate lies between, and the second one's share. */
static inline float np_transport_grid_bracket(const np_transport_grid *grid, int axis, double x, int32_t out[2]) {
  const int32_t size = grid->size[axis];
  double share;
  if (grid->repeat_m[axis] > 0.0)
    x = np_light_period_match((np_light_period){.low_m = grid->edge_m[axis][0],
                                                .length_m = np_transport_grid_length(grid, axis),
                                                .repeat_m = grid->repeat_m[axis]},
                              x);
  if (grid->even_m[axis] > 0.0) {
    const double u = np_clamp((x - grid->edge_m[axis][0]) / grid->even_m[axis] - 0.5, -1e9, 1e9), lower = floor(u);
    out[0] = (int32_t)lower;
    share = u - lower;
  } else {
    const int32_t cell = np_transport_grid_locate(grid, axis, x), inside = cell < 0 ? 0 : cell < size ? cell : size - 1;
    const double middle = np_transport_grid_middle(grid, axis, inside);
    out[0] = x < middle ? inside - 1 : inside;
    const int32_t low = out[0] < 0 ? 0 : out[0], high = out[0] + 1 < size ? out[0] + 1 : size - 1;
    const double begin = np_transport_grid_middle(grid, axis, low), end = np_transport_grid_middle(grid, axis, high);
    share = end > begin ? np_clamp((x - begin) / (end - begin), 0.0, 1.0) : 0.0;
  }
  out[1] = out[0] + 1;
  for (int e = 0; e < 2; e++) {
    if (grid->is_wrapped[axis]) {
      out[e] %= size;
      out[e] += out[e] < 0 ? size : 0;
    }
    out[e] = out[e] < 0 ? 0 : out[e] < size ? out[e] : size - 1;
  }
  return (float)share;
}

/* The active cells around a position and their trilinear weights, which add up to 1; returns how many, 0 to 8. */
static inline unsigned np_transport_grid_get_corners(const np_transport_grid *grid, np_dvec3 position,
                                                     int32_t out_live[8], float out_weight[8]) {
  const double p[3] = {position.x, position.y, position.z};
  int32_t index[3][2];
  float weight[3][2], total = 0.0f;
  for (int a = 0; a < 3; a++) {
    weight[a][1] = np_transport_grid_bracket(grid, a, p[a], index[a]);
    weight[a][0] = 1.0f - weight[a][1];
  }
  unsigned count = 0;
  for (unsigned corner = 0; corner < 8; corner++) {
    const unsigned x = corner & 1u, y = corner >> 1 & 1u, z = corner >> 2;
    const float w = weight[0][x] * weight[1][y] * weight[2][z];
    const int32_t active = grid->active[(index[2][z] * grid->size[1] + index[1][y]) * grid->size[0] + index[0][x]];
    if (active < 0 || !(w > 0.0f)) continue;
    out_live[count] = active;
    out_weight[count++] = w;
    total += w;
  }
  for (unsigned i = 0; i < count; i++) out_weight[i] /= total;
  return count;
}

#endif

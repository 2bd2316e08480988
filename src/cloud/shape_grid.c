/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/shape_grid.h"

#include "core/alloc.h"
#include "core/math.h"

enum { BLOCK = 4, NODES_MAX = 1 << 21 };

static size_t compute_node(const np_shape_grid *grid, int32_t i, int32_t j, int32_t k) {
  return ((size_t)i * (size_t)grid->size[1] + (size_t)j) * (size_t)grid->size[2] + (size_t)k;
}

static size_t count_all(const int32_t size[3]) { return (size_t)size[0] * (size_t)size[1] * (size_t)size[2]; }

neph_result np_shape_grid_init(neph_context *context, const float low_m[3], const float high_m[3], float step_min_m,
                               np_shape_grid *out_grid) {
  np_shape_grid grid = {.context = context, .step_m = step_min_m};
  double nodes;
  do {
    nodes = 1;
    for (int a = 0; a < 3; a++) {
      grid.origin_m[a] = low_m[a];
      nodes *= ceil((double)(high_m[a] - low_m[a]) / (double)grid.step_m) + 1;
    }
    if (nodes > NODES_MAX) grid.step_m *= 1.05f;
  } while (nodes > NODES_MAX);
  for (int a = 0; a < 3; a++) {
    grid.size[a] = (int32_t)ceil((double)(high_m[a] - low_m[a]) / (double)grid.step_m) + 1;
    if (grid.size[a] < 2) grid.size[a] = 2;
    grid.blocks[a] = (grid.size[a] - 2) / BLOCK + 1;
  }
  grid.distance_m = np_alloc(context, count_all(grid.size), sizeof *grid.distance_m);
  grid.lowest_m = np_alloc(context, count_all(grid.blocks), sizeof *grid.lowest_m);
  *out_grid = grid;
  if (grid.distance_m && grid.lowest_m) return NEPH_OK;
  np_shape_grid_clear(out_grid);
  return NEPH_ERROR_OUT_OF_MEMORY;
}

void np_shape_grid_clear(np_shape_grid *grid) {
  if (grid->context) {
    np_alloc_free(grid->context, grid->distance_m);
    np_alloc_free(grid->context, grid->lowest_m);
  }
  *grid = (np_shape_grid){0};
}

double np_shape_grid_count_bytes(const np_shape_grid *grid) {
  return (double)(count_all(grid->size) + count_all(grid->blocks)) * sizeof(float);
}

/* ---- Bounds ---- */

static float compute_lowest(const np_shape_grid *grid, const int32_t block[3]) {
  float lowest_m = INFINITY;
  int32_t first[3], last[3];
  for (int a = 0; a < 3; a++) {
    first[a] = block[a] * BLOCK;
    last[a] = first[a] + BLOCK < grid->size[a] ? first[a] + BLOCK : grid->size[a] - 1;
  }
  for (int32_t i = first[0]; i <= last[0]; i++)
    for (int32_t j = first[1]; j <= last[1]; j++)
      for (int32_t k = first[2]; k <= last[2]; k++)
        lowest_m = np_minf(lowest_m, grid->distance_m[compute_node(grid, i, j, k)]);
  return lowest_m;
}

void np_shape_grid_bound(np_shape_grid *grid) {
  size_t n = 0;
  for (int32_t i = 0; i < grid->blocks[0]; i++)
    for (int32_t j = 0; j < grid->blocks[1]; j++)
      for (int32_t k = 0; k < grid->blocks[2]; k++)
        grid->lowest_m[n++] = compute_lowest(grid, (const int32_t[3]){i, j, k});
}

/* Position along an axis in nodes, clamped to the grid. */
static float compute_place(const np_shape_grid *grid, int axis, float position_m) {
  const float scaled = (position_m - grid->origin_m[axis]) / grid->step_m;
  return np_clampf(scaled, 0.0f, (float)(grid->size[axis] - 1));
}

bool np_shape_grid_is_near(const np_shape_grid *grid, const float min_m[3], const float max_m[3], float reach_m) {
  int32_t low[3], high[3];
  for (int a = 0; a < 3; a++) {
    low[a] = (int32_t)compute_place(grid, a, min_m[a]) / BLOCK;
    high[a] = (int32_t)compute_place(grid, a, max_m[a]) / BLOCK;
    if (low[a] > grid->blocks[a] - 1) low[a] = grid->blocks[a] - 1;
    if (high[a] > grid->blocks[a] - 1) high[a] = grid->blocks[a] - 1;
  }
  for (int32_t i = low[0]; i <= high[0]; i++)
    for (int32_t j = low[1]; j <= high[1]; j++)
      for (int32_t k = low[2]; k <= high[2]; k++)
        if (grid->lowest_m[((size_t)i * (size_t)grid->blocks[1] + (size_t)j) * (size_t)grid->blocks[2] + (size_t)k] *
                    1.0001f -
                1e-3f <
            reach_m)
          return true;
  return false;
}

/* ---- Values ---- */

/* The eight nodes around a position, x slowest, and the fractional position between them. */
static void gather(const np_shape_grid *grid, const float at_m[3], float out_nodes[8], float out_place[3]) {
  int32_t at[3];
  for (int a = 0; a < 3; a++) {
    const float place = compute_place(grid, a, at_m[a]);
    at[a] = (int32_t)place;
    if (at[a] > grid->size[a] - 2) at[a] = grid->size[a] - 2;
    out_place[a] = place - (float)at[a];
  }
  for (int n = 0; n < 8; n++)
    out_nodes[n] = grid->distance_m[compute_node(grid, at[0] + (n >> 2), at[1] + (n >> 1 & 1), at[2] + (n & 1))];
}

float np_shape_grid_sample(const np_shape_grid *grid, const float at_m[3], float out_normal[3]) {
  float n[8], t[3];
  gather(grid, at_m, n, t);
  float along[4], across[2];
  for (int i = 0; i < 4; i++) along[i] = np_mixf(n[2 * i], n[2 * i + 1], t[2]);
  for (int i = 0; i < 2; i++) across[i] = np_mixf(along[2 * i], along[2 * i + 1], t[1]);
  if (out_normal) {
    const float g[3] = {
        across[1] - across[0], np_mixf(along[1] - along[0], along[3] - along[2], t[0]),
        np_mixf(np_mixf(n[1] - n[0], n[3] - n[2], t[1]), np_mixf(n[5] - n[4], n[7] - n[6], t[1]), t[0])};
    const float length = sqrtf(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]), scale = length > 0.0f ? 1.0f / length : 0.0f;
    for (int a = 0; a < 3; a++) out_normal[a] = g[a] * scale;
  }
  return np_mixf(across[0], across[1], t[0]);
}

float np_shape_grid_compute_radius(const np_shape_grid *grid, const float at_m[3], float distance_m,
                                   const float normal[3]) {
  float radius_m = 0.0f;
  for (float depth_m = grid->radius_max_m; depth_m > 0.05f * grid->radius_max_m; depth_m *= 0.5f) {
    float inside_m[3];
    for (int a = 0; a < 3; a++) inside_m[a] = at_m[a] - (distance_m + depth_m) * normal[a];
    radius_m = np_maxf(radius_m, -np_shape_grid_sample(grid, inside_m, NULL));
  }
  return np_minf(radius_m, grid->radius_max_m);
}

float np_shape_compute_age(float age, float height_m, float thickness_m) {
  const float fresh = np_smoothstepf((height_m / thickness_m - 0.25f) / 0.5f) * (1.0f - age);
  return age * (1.0f - 0.8f * fresh);
}

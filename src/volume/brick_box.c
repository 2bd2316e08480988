/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/brick_box.h"

/* Range of a brick's samples in a box of its lattice. */
static np_brick_range measure_brick(const np_bricks *bricks, uint32_t brick, const int low[3], const int high[3]) {
  np_brick_range range = {INFINITY, -INFINITY};
  for (int x = low[0]; x <= high[0]; x++)
    for (int y = low[1]; y <= high[1]; y++)
      for (int z = low[2]; z <= high[2]; z++) {
        const size_t n = (size_t)brick * NP_BRICK_STRIDE + (size_t)(x * NP_BRICK_STRIDE_X + y * NP_BRICK_SAMPLES + z);
        const float value = bricks->scale * (bricks->halves ? np_half_to_float(bricks->halves[n]) : bricks->floats[n]);
        range = np_brick_range_unite(range, (np_brick_range){value, value});
      }
  return range;
}

/* Range of one cell in a box of index positions. */
static np_brick_range measure_cell(const np_bricks *rest, const int32_t cell[3], const double low[3],
                                   const double high[3]) {
  int32_t inside[3];
  int from[3], to[3];
  bool is_whole = true;
  for (int a = 0; a < 3; a++) {
    inside[a] = cell[a] - rest->origin[a];
    if (inside[a] < 0 || inside[a] >= rest->size[a]) return (np_brick_range){rest->background, rest->background};
    from[a] = (int)fmax(floor(low[a]) - (double)cell[a] * NP_BRICK_EDGE, 0.0);
    to[a] = (int)fmin(ceil(high[a]) - (double)cell[a] * NP_BRICK_EDGE, NP_BRICK_EDGE);
    is_whole = is_whole && from[a] == 0 && to[a] == NP_BRICK_EDGE;
  }
  const np_brick_place at = np_bricks_get_place(rest, inside);
  const uint32_t brick = np_bricks_get_brick(rest, &at);
  const np_brick_range range = np_bricks_get_range(rest, &at, 0);
  if (is_whole || brick == NP_BRICK_NONE || rest->is_indirect) return range;
  const np_brick_range part = measure_brick(rest, brick, from, to);
  const float margin = 0x1p-20f * fmaxf(fabsf(part.min), fabsf(part.max));
  return (np_brick_range){fmaxf(part.min - margin, range.min), fminf(part.max + margin, range.max)};
}

np_brick_range np_bricks_measure_box(const np_bricks *rest, const double low[3], const double high[3]) {
  np_brick_range range = {INFINITY, -INFINITY};
  int32_t first[3], last[3], cell[3];
  for (int a = 0; a < 3; a++) {
    first[a] = (int32_t)floor(low[a] / NP_BRICK_EDGE);
    last[a] = (int32_t)floor(high[a] / NP_BRICK_EDGE);
  }
  for (cell[0] = first[0]; cell[0] <= last[0]; cell[0]++)
    for (cell[1] = first[1]; cell[1] <= last[1]; cell[1]++)
      for (cell[2] = first[2]; cell[2] <= last[2]; cell[2]++)
        range = np_brick_range_unite(range, measure_cell(rest, cell, low, high));
  return range;
}

/* Whether a cell, counted from the first, may be above 0. */
static bool may_hold(const np_bricks *bricks, const int32_t cell[3]) {
  for (int a = 0; a < 3; a++)
    if (cell[a] < 0 || cell[a] >= bricks->size[a]) return bricks->background > 0.0f;
  const np_brick_place at = np_bricks_get_place(bricks, cell);
  return np_bricks_get_range(bricks, &at, 0).max > 0.0f;
}

bool np_bricks_are_empty(const np_bricks *bricks, const double low[3], const double high[3]) {
  enum { CELLS_MAX = 8 };
  int32_t first[3], last[3], cell[3];
  if (bricks->is_indirect || bricks->is_periodic[0] || bricks->is_periodic[1]) return false;
  for (int a = 0; a < 3; a++) {
    if (high[a] - low[a] > NP_BRICK_EDGE * CELLS_MAX) return false;
    first[a] = (int32_t)floor(low[a] / NP_BRICK_EDGE) - bricks->origin[a];
    last[a] = (int32_t)floor(high[a] / NP_BRICK_EDGE) - bricks->origin[a];
  }
  for (cell[0] = first[0]; cell[0] <= last[0]; cell[0]++)
    for (cell[1] = first[1]; cell[1] <= last[1]; cell[1]++)
      for (cell[2] = first[2]; cell[2] <= last[2]; cell[2]++)
        if (may_hold(bricks, cell)) return false;
  return true;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Bounds of the interpolant on coarser levels: the least minimum and the greatest maximum of the cells below. */
#include "volume/bricks.h"

static np_brick_range unite(np_brick_range a, np_brick_range b) {
  return (np_brick_range){a.min < b.min ? a.min : b.min, a.max > b.max ? a.max : b.max};
}

/* Range of a cell of `level`, from those of its cells of the level below that exist. */
static np_brick_range compute_range(const np_bricks *bricks, int level, const int32_t cell[3]) {
  int32_t low[3], high[3];
  for (int a = 0; a < 3; a++) {
    low[a] = cell[a] << NP_BRICK_LEVEL_SHIFT;
    high[a] = low[a] + (1 << NP_BRICK_LEVEL_SHIFT);
    if (high[a] > bricks->size[level - 1][a]) high[a] = bricks->size[level - 1][a];
  }
  np_brick_range range = bricks->ranges[level - 1][np_bricks_get_offset(bricks, level - 1, low)];
  int32_t at[3];
  for (at[0] = low[0]; at[0] < high[0]; at[0]++)
    for (at[1] = low[1]; at[1] < high[1]; at[1]++)
      for (at[2] = low[2]; at[2] < high[2]; at[2]++)
        range = unite(range, bricks->ranges[level - 1][np_bricks_get_offset(bricks, level - 1, at)]);
  return range;
}

void np_bricks_build_coarse_ranges(np_bricks *bricks) {
  for (int level = 1; level < NP_BRICK_LEVELS; level++) {
    int32_t cell[3];
    np_brick_range *range = bricks->ranges[level];
    for (cell[0] = 0; cell[0] < bricks->size[level][0]; cell[0]++)
      for (cell[1] = 0; cell[1] < bricks->size[level][1]; cell[1]++)
        for (cell[2] = 0; cell[2] < bricks->size[level][2]; cell[2]++) *range++ = compute_range(bricks, level, cell);
  }
  np_brick_range all = {bricks->background, bricks->background};
  size_t count = np_bricks_count_cells(bricks, NP_BRICK_LEVELS - 1);
  for (size_t i = 0; i < count; i++) all = unite(all, bricks->ranges[NP_BRICK_LEVELS - 1][i]);
  bricks->value_max = all.max;
}

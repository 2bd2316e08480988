/* SPDX-License-Identifier: Apache-2.0 */
#include "parts/part_grid.h"

#include "frame/frame_state.h"

static unsigned min(unsigned a, unsigned b) { return a < b ? a : b; }

np_part_grid np_part_grid_make(const np_part_header *header) {
  np_part_grid grid = {(unsigned)(header->max[0] - header->min[0]), (unsigned)(header->max[1] - header->min[1]), 0, 0};
  grid.across = (grid.width + NP_TILE_EDGE - 1) / NP_TILE_EDGE;
  grid.down = (grid.height + NP_TILE_EDGE - 1) / NP_TILE_EDGE;
  return grid;
}

size_t np_part_grid_get_first(const np_part_grid *grid, size_t tile, size_t *out_count) {
  const unsigned x = (unsigned)(tile % grid->across) * NP_TILE_EDGE;
  const unsigned y = (unsigned)(tile / grid->across) * NP_TILE_EDGE;
  const unsigned rows = min(NP_TILE_EDGE, grid->height - y);
  *out_count = (size_t)min(NP_TILE_EDGE, grid->width - x) * rows;
  return (size_t)y * grid->width + (size_t)x * rows;
}

size_t np_part_grid_get_index(const np_part_grid *grid, unsigned x, unsigned y) {
  size_t count;
  const size_t first =
      np_part_grid_get_first(grid, (size_t)(y / NP_TILE_EDGE) * grid->across + x / NP_TILE_EDGE, &count);
  const unsigned across = min(NP_TILE_EDGE, grid->width - x / NP_TILE_EDGE * NP_TILE_EDGE);
  return first + (size_t)(y % NP_TILE_EDGE) * across + x % NP_TILE_EDGE;
}

/* Cuts rows like plan.c. */
int np_part_get_tile_row(const np_part_header *h, unsigned tile, unsigned tile_count) {
  if (tile == 0) return h->whole_min[1];
  if (tile == tile_count) return h->whole_max[1];
  const int begin = h->whole_min[1] > h->display_min[1] ? h->whole_min[1] : h->display_min[1];
  return begin + (int)(np_part_count_rows(h) * tile / tile_count);
}

int64_t np_part_count_rows(const np_part_header *h) {
  const int64_t begin = h->whole_min[1] > h->display_min[1] ? h->whole_min[1] : h->display_min[1];
  return (h->whole_max[1] < h->display_max[1] ? h->whole_max[1] : h->display_max[1]) - begin;
}

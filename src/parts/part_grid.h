/* SPDX-License-Identifier: Apache-2.0 */
/* Places in a part: its squares of pixels, whose records follow each other, and the rows that a tile of a picture has.
 */
#ifndef NP_PARTS_PART_GRID_H
#define NP_PARTS_PART_GRID_H

#include "parts/part_header.h"

/* Tiles of a part: squares of pixels from its upper left corner on. */
typedef struct np_part_grid {
  unsigned width, height, across, down;
} np_part_grid;

np_part_grid np_part_grid_make(const np_part_header *header);

static inline size_t np_part_grid_count(const np_part_grid *grid) { return (size_t)grid->across * grid->down; }

/* Number of a tile's first record, where records follow tile by tile, and how many it has. */
size_t np_part_grid_get_first(const np_part_grid *grid, size_t tile, size_t *out_count);

/* Number of a pixel's record; its place in the part, not in the picture. */
size_t np_part_grid_get_index(const np_part_grid *grid, unsigned x, unsigned y);

/* Rows of the whole picture without its overscan, which its tiles divide. */
int64_t np_part_count_rows(const np_part_header *header);

/* First row of a tile of the whole picture; `tile_count`: one past the last row. The first and the last tile have the
 * overscan. */
int np_part_get_tile_row(const np_part_header *header, unsigned tile, unsigned tile_count);

#endif

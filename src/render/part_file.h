/* SPDX-License-Identifier: Apache-2.0 */
/* Files of parts: "nephpart", version, header with its checksum, a byte for each tile, and the records of those tiles
 * that are there, each tile with its checksum. Numbers are of x86-64. */
#ifndef NP_RENDER_PART_FILE_H
#define NP_RENDER_PART_FILE_H

#include <stdatomic.h>

#include "render/part_header.h"

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

/* Writes a part, atomically. Only tiles of `done` are read from `records`; others may change under the call. */
neph_result np_part_file_write(neph_context *context, const char *path, const np_part_header *header,
                               const atomic_bool *done, const double *records);

typedef struct np_part_file np_part_file;

/* Opens a part and checks all but its records. NEPH_ERROR_BAD_FILE, with a message, where it is damaged, cut short, or
 * of another version. */
neph_result np_part_file_open(neph_context *context, const char *path, np_part_file **out_file);
void np_part_file_close(np_part_file *file); /* NULL is allowed */

const char *np_part_file_get_path(const np_part_file *file);
const np_part_header *np_part_file_get_header(const np_part_file *file);
bool np_part_file_has_tile(const np_part_file *file, size_t tile);
size_t np_part_file_count_tiles(const np_part_file *file); /* that are there */

/* The records of a tile that is there; NEPH_ERROR_BAD_FILE, with a message, where they are damaged. */
neph_result np_part_file_read_tile(np_part_file *file, size_t tile, double *out_records);

#endif

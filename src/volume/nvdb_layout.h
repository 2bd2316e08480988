/* SPDX-License-Identifier: Apache-2.0 */
/* The structure of a .nvdb file: segments of grids, or grids alone, and the head of each grid, checked when the file is
 * opened. Inside the volume module only.
 *
 * No byte of a file is trusted: each read is checked against the end of the grid, each child against the number of
 * nodes that the grid states, which must fit into it. So a tree costs no more than the file's size times a small
 * number.
 */
#ifndef NP_VOLUME_NVDB_LAYOUT_H
#define NP_VOLUME_NVDB_LAYOUT_H

#include "core/parallel.h"
#include "volume/nvdb_types.h"
#include "volume/vdb_bytes.h"
#include "volume/vdb_table.h"

enum { NP_NVDB_GRID_BYTES = 672, NP_NVDB_TREE_BYTES = 64, NP_NVDB_LEVELS = 3 };

/* Compression of a segment, by the numbers in files. */
typedef enum np_nvdb_codec { NP_NVDB_NONE, NP_NVDB_ZIP, NP_NVDB_BLOSC, NP_NVDB_CODECS } np_nvdb_codec;

typedef struct np_nvdb_grid {
  char *name;               /* owned */
  const np_nvdb_type *type; /* NULL: not known */
  np_nvdb_node_layout layout;
  uint32_t type_number, grid_class;
  np_nvdb_codec codec;
  int64_t begin; /* position in the file */
  uint64_t stored_bytes, bytes;
  uint64_t voxel_count; /* active, as the file states it */
  int32_t active_min[3], active_max[3];
  bool is_affine;
  double index_to_world[3][4];
  uint64_t root; /* position in the grid */
  uint32_t node_counts[NP_NVDB_LEVELS];
  int64_t blind_begin; /* position in the grid of the descriptions of its blind data */
  uint32_t blind_count;
} np_nvdb_grid;

typedef struct np_nvdb_layout {
  neph_context *context; /* borrowed */
  np_vdb_bytes *bytes;   /* borrowed */
  size_t count, capacity;
  np_nvdb_grid *grids;
  /* The grid that was unpacked last. */
  size_t unpacked_index;
  unsigned char *unpacked; /* owned; NULL: none */
  np_vdb_bytes *unpacked_bytes;
} np_nvdb_layout;

/* Whether a file begins with it. */
bool np_nvdb_has_magic(uint64_t magic);

/* Reads the heads of all grids. `bytes` must live as long as the layout. The caller closes it, whatever the outcome. */
neph_result np_nvdb_layout_open(np_vdb_bytes *bytes, np_nvdb_layout *out_layout);
void np_nvdb_layout_close(np_nvdb_layout *layout);

/* The bytes of a grid, unpacked where they are compressed, and the position at which it begins in them. NULL, reported,
 * where that fails. They stay until the next call. */
np_vdb_bytes *np_nvdb_layout_get_bytes(np_nvdb_layout *layout, size_t index, int64_t *out_begin);

#endif

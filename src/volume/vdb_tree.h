/* SPDX-License-Identifier: Apache-2.0 */
/* The layout of a tree in a .vdb file: its topology (nodes, masks, tiles), then its buffers (the values of leaves).
 * Inside the volume module only. */
#ifndef NP_VOLUME_VDB_TREE_H
#define NP_VOLUME_VDB_TREE_H

#include "core/parallel.h"
#include "volume/vdb_bytes.h"
#include "volume/vdb_table.h"

/* Contents of a leaf after its masks. */
typedef enum np_vdb_leaf {
  NP_VDB_LEAF_VALUES,
  NP_VDB_LEAF_BOOL,
  NP_VDB_LEAF_MASK,
  NP_VDB_LEAF_POINTS /* unknown layout: such buffers are never read */
} np_vdb_leaf;

typedef struct np_vdb_tree_type {
  const char *name;                 /* spelling in grid descriptors */
  uint32_t value_bytes, half_bytes; /* bytes of one value as stored; half_bytes 0: never stored as halves */
  np_vdb_leaf leaf;
} np_vdb_tree_type;

/* NULL if OpenVDB cannot read the type. */
const np_vdb_tree_type *np_vdb_tree_type_get(const char *name);

/* Storage format of a grid's values. */
typedef struct np_vdb_storage {
  const np_vdb_tree_type *type;
  uint32_t compression;
  bool is_half;
} np_vdb_storage;

enum { NP_VDB_ZIP = 1, NP_VDB_ACTIVE_MASK = 2, NP_VDB_BLOSC = 4 };

/* Positions of the parts of a tree in the file. */
typedef struct np_vdb_tree_place {
  int64_t buffers;
  size_t leaf_count;
  int64_t *leaves; /* values of each leaf, in the order of the buffers, and the end of the last; NULL: leaves without
                      values. The caller frees it by np_alloc_free. */
} np_vdb_tree_place;

/* Checks a tree from the current position, and moves to its end (for points, to the end of the topology). A failure is
 * in bytes->result; `out_place` is then empty. */
void np_vdb_tree_check(np_vdb_bytes *bytes, const np_vdb_module *module, np_monitor *monitor, np_vdb_storage storage,
                       np_vdb_tree_place *out_place);

/* Checks the header of a Blosc block that must hold `count` bytes, and skips the block. */
void np_vdb_blosc_check(np_vdb_bytes *bytes, uint64_t block_bytes, uint64_t count);

#endif

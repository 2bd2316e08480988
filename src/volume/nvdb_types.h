/* SPDX-License-Identifier: Apache-2.0 */
/* Types of NanoVDB's grids: the layout of their nodes, and their values as floats. Inside the volume module only. */
#ifndef NP_VOLUME_NVDB_TYPES_H
#define NP_VOLUME_NVDB_TYPES_H

#include <stdbool.h>
#include <stdint.h>

typedef enum np_nvdb_kind {
  NP_NVDB_OTHER,  /* neither a scalar nor a vector */
  NP_NVDB_SCALAR, /* floats, halves, doubles, quantised floats */
  NP_NVDB_COUNT,  /* whole numbers and marks */
  NP_NVDB_VECTOR  /* three floats or doubles */
} np_nvdb_kind;

/* Sizes of the nodes of a tree and positions in them, in bytes. */
typedef struct np_nvdb_node_layout {
  uint32_t root, root_background, root_tile, root_tile_value;
  uint32_t upper, upper_table, lower, lower_table, table_stride;
  uint32_t leaf; /* without the values of quantised leaves whose number of bits differs */
} np_nvdb_node_layout;

enum {
  NP_NVDB_LEAF_BYTES_MAX = 12448,
  NP_NVDB_VALUE_BYTES_MAX = 24,
  NP_NVDB_LEAF_FLAGS = 15, /* position of the flags of a leaf, whose mask follows */
  NP_NVDB_LEAF_MASK = 16
};

typedef struct np_nvdb_type {
  const char *name;
  np_nvdb_kind kind;
  uint32_t value_bytes; /* size of the background and of a tile */

  /* One component of a value, as a float. */
  float (*get_value)(const unsigned char *value, int component);

  /* One component of the 512 values of a leaf, as floats. `leaf` has all its bytes. */
  void (*get_values)(const unsigned char *leaf, int component, float *out_values);

  /* Bytes behind a leaf of its quantised values, from its flags; false where these are wrong. NULL: none. */
  bool (*get_tail)(uint8_t flags, uint32_t *out_bytes);
} np_nvdb_type;

/* The type of a number in a file, and its layout; NULL where it is none that is known. */
const np_nvdb_type *np_nvdb_type_get(uint32_t number, np_nvdb_node_layout *out_layout);

#endif

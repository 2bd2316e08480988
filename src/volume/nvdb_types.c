/* SPDX-License-Identifier: Apache-2.0 */
/* Method: NanoVDB 32.4, NanoVDB.h: LeafData of each type; its layouts are those of PNanoVDB.h. */
#include "volume/nvdb_types.h"

#include <string.h>

#include "volume/nvdb_header.h"
#include "volume/sparse_grid.h"

#include "core/half.h"

/* ---- Plain values ---- */

#define LEAF_TABLE(type) pnanovdb_grid_type_constants[PNANOVDB_GRID_TYPE_##type].leaf_off_table

static float get_float(const unsigned char *value, int component) {
  float out;
  memcpy(&out, value + 4 * component, sizeof out);
  return out;
}

static float get_double(const unsigned char *value, int component) {
  double out;
  memcpy(&out, value + 8 * component, sizeof out);
  return (float)out;
}

static float get_half(const unsigned char *value, int component) {
  uint16_t out;
  memcpy(&out, value + 2 * component, sizeof out);
  return np_half_to_float(out);
}

static float get_int16(const unsigned char *value, int component) {
  int16_t out;
  memcpy(&out, value + 2 * component, sizeof out);
  return (float)out;
}

static float get_int32(const unsigned char *value, int component) {
  int32_t out;
  memcpy(&out, value + 4 * component, sizeof out);
  return (float)out;
}

static float get_int64(const unsigned char *value, int component) {
  int64_t out;
  memcpy(&out, value + 8 * component, sizeof out);
  return (float)out;
}

static float get_uint32(const unsigned char *value, int component) {
  uint32_t out;
  memcpy(&out, value + 4 * component, sizeof out);
  return (float)out;
}

static float get_bool(const unsigned char *value, int component) { return value[component] ? 1.0f : 0.0f; }

static void get_floats(const unsigned char *leaf, int component, float *out) {
  (void)component;
  memcpy(out, leaf + LEAF_TABLE(FLOAT), NP_LEAF_SIZE * sizeof *out);
}

static void get_doubles(const unsigned char *leaf, int component, float *out) {
  (void)component;
  for (int n = 0; n < NP_LEAF_SIZE; n++) out[n] = get_double(leaf + LEAF_TABLE(DOUBLE), n);
}

static void get_halves(const unsigned char *leaf, int component, float *out) {
  (void)component;
  for (int n = 0; n < NP_LEAF_SIZE; n++) out[n] = get_half(leaf + LEAF_TABLE(HALF), n);
}

static void get_int16s(const unsigned char *leaf, int component, float *out) {
  (void)component;
  for (int n = 0; n < NP_LEAF_SIZE; n++) out[n] = get_int16(leaf + LEAF_TABLE(INT16), n);
}

static void get_int32s(const unsigned char *leaf, int component, float *out) {
  (void)component;
  for (int n = 0; n < NP_LEAF_SIZE; n++) out[n] = get_int32(leaf + LEAF_TABLE(INT32), n);
}

static void get_int64s(const unsigned char *leaf, int component, float *out) {
  (void)component;
  for (int n = 0; n < NP_LEAF_SIZE; n++) out[n] = get_int64(leaf + LEAF_TABLE(INT64), n);
}

static void get_uint32s(const unsigned char *leaf, int component, float *out) {
  (void)component;
  for (int n = 0; n < NP_LEAF_SIZE; n++) out[n] = get_uint32(leaf + LEAF_TABLE(UINT32), n);
}

static void get_float_vectors(const unsigned char *leaf, int component, float *out) {
  for (int n = 0; n < NP_LEAF_SIZE; n++) out[n] = get_float(leaf + LEAF_TABLE(VEC3F), 3 * n + component);
}

static void get_double_vectors(const unsigned char *leaf, int component, float *out) {
  for (int n = 0; n < NP_LEAF_SIZE; n++) out[n] = get_double(leaf + LEAF_TABLE(VEC3D), 3 * n + component);
}

/* ---- Marks ---- */

static void get_bits(const unsigned char *bits, float *out) {
  for (int n = 0; n < NP_LEAF_SIZE; n++) out[n] = bits[n >> 3] >> (n & 7) & 1 ? 1.0f : 0.0f;
}

static void get_bools(const unsigned char *leaf, int component, float *out) {
  (void)component;
  get_bits(leaf + NP_NVDB_LEAF_MASK + NP_LEAF_SIZE / 8, out); /* behind the mask; PNanoVDB.h has another place */
}

static void get_marks(const unsigned char *leaf, int component, float *out) {
  (void)component;
  get_bits(leaf + NP_NVDB_LEAF_MASK, out);
}

/* ---- Quantised values ---- */

enum { QUANTISED_MINIMUM = 80, QUANTISED_QUANTUM = 84, QUANTISED_CODES = 96, CODE_BITS_LOG2_MAX = 4 };

static void get_codes(const unsigned char *leaf, unsigned bits_log2, float *out) {
  const float minimum = get_float(leaf + QUANTISED_MINIMUM, 0), quantum = get_float(leaf + QUANTISED_QUANTUM, 0);
  const unsigned char *codes = leaf + QUANTISED_CODES;
  const unsigned bits = 1u << bits_log2, mask = (1u << bits) - 1u;
  for (unsigned n = 0; n < NP_LEAF_SIZE; n++) {
    const unsigned at = n * bits, low = codes[at >> 3], high = bits > 8 ? codes[(at >> 3) + 1] : 0u;
    out[n] = (float)((low | high << 8) >> (at & 7u) & mask) * quantum + minimum;
  }
}

static void get_fp4(const unsigned char *leaf, int component, float *out) {
  (void)component;
  get_codes(leaf, 2, out);
}

static void get_fp8(const unsigned char *leaf, int component, float *out) {
  (void)component;
  get_codes(leaf, 3, out);
}

static void get_fp16(const unsigned char *leaf, int component, float *out) {
  (void)component;
  get_codes(leaf, 4, out);
}

static void get_fpn(const unsigned char *leaf, int component, float *out) {
  (void)component;
  get_codes(leaf, leaf[NP_NVDB_LEAF_FLAGS] >> 5, out);
}

static bool get_fpn_tail(uint8_t flags, uint32_t *out_bytes) {
  *out_bytes = (NP_LEAF_SIZE / 8) << (flags >> 5);
  return flags >> 5 <= CODE_BITS_LOG2_MAX;
}

/* ---- Types ---- */

static const np_nvdb_type types[PNANOVDB_GRID_TYPE_END] = {
    [PNANOVDB_GRID_TYPE_FLOAT] = {"float", NP_NVDB_SCALAR, 4, get_float, get_floats, NULL},
    [PNANOVDB_GRID_TYPE_DOUBLE] = {"double", NP_NVDB_SCALAR, 8, get_double, get_doubles, NULL},
    [PNANOVDB_GRID_TYPE_INT16] = {"int16", NP_NVDB_COUNT, 2, get_int16, get_int16s, NULL},
    [PNANOVDB_GRID_TYPE_INT32] = {"int32", NP_NVDB_COUNT, 4, get_int32, get_int32s, NULL},
    [PNANOVDB_GRID_TYPE_INT64] = {"int64", NP_NVDB_COUNT, 8, get_int64, get_int64s, NULL},
    [PNANOVDB_GRID_TYPE_VEC3F] = {"vec3s", NP_NVDB_VECTOR, 12, get_float, get_float_vectors, NULL},
    [PNANOVDB_GRID_TYPE_VEC3D] = {"vec3d", NP_NVDB_VECTOR, 24, get_double, get_double_vectors, NULL},
    [PNANOVDB_GRID_TYPE_MASK] = {"mask", NP_NVDB_COUNT, 1, get_bool, get_marks, NULL},
    [PNANOVDB_GRID_TYPE_HALF] = {"half", NP_NVDB_SCALAR, 2, get_half, get_halves, NULL},
    [PNANOVDB_GRID_TYPE_UINT32] = {"uint32", NP_NVDB_COUNT, 4, get_uint32, get_uint32s, NULL},
    [PNANOVDB_GRID_TYPE_BOOLEAN] = {"bool", NP_NVDB_COUNT, 1, get_bool, get_bools, NULL},
    [PNANOVDB_GRID_TYPE_RGBA8] = {"rgba8", NP_NVDB_OTHER, 4, NULL, NULL, NULL},
    [PNANOVDB_GRID_TYPE_FP4] = {"fp4", NP_NVDB_SCALAR, 4, get_float, get_fp4, NULL},
    [PNANOVDB_GRID_TYPE_FP8] = {"fp8", NP_NVDB_SCALAR, 4, get_float, get_fp8, NULL},
    [PNANOVDB_GRID_TYPE_FP16] = {"fp16", NP_NVDB_SCALAR, 4, get_float, get_fp16, NULL},
    [PNANOVDB_GRID_TYPE_FPN] = {"fpN", NP_NVDB_SCALAR, 4, get_float, get_fpn, get_fpn_tail},
    [PNANOVDB_GRID_TYPE_VEC4F] = {"vec4s", NP_NVDB_OTHER, 16, NULL, NULL, NULL},
    [PNANOVDB_GRID_TYPE_VEC4D] = {"vec4d", NP_NVDB_OTHER, 32, NULL, NULL, NULL},
    [PNANOVDB_GRID_TYPE_INDEX] = {"index", NP_NVDB_OTHER, 8, NULL, NULL, NULL},
};

const np_nvdb_type *np_nvdb_type_get(uint32_t number, np_nvdb_node_layout *out_layout) {
  if (number >= PNANOVDB_GRID_TYPE_END || !types[number].name) return NULL;
  const pnanovdb_grid_type_constants_t *c = &pnanovdb_grid_type_constants[number];
  *out_layout = (np_nvdb_node_layout){
      .root = c->root_size,
      .root_background = c->root_off_background,
      .root_tile = c->root_tile_size,
      .root_tile_value = c->root_tile_off_value,
      .upper = c->upper_size,
      .upper_table = c->upper_off_table,
      .lower = c->lower_size,
      .lower_table = c->lower_off_table,
      .table_stride = c->table_stride,
      .leaf = c->leaf_size,
  };
  return &types[number];
}

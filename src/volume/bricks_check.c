/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/bricks_check.h"

#include <math.h>

/* Largest distance of cells from index 0, and extent along an axis (bricks_table.c). */
static const int32_t extent_max = 1 << 27;

/* Most nodes of a table (bricks_table.c). */
static const uint64_t table_count_max = UINT64_C(1) << 24;

/* ---- Shape ---- */

static bool check_axis(const np_bricks *b, int a) {
  const int32_t far = (int32_t)(NP_BRICK_FAR / NP_BRICK_EDGE);
  const bool is_periodic = a < 2 && b->is_periodic[a];
  if (b->origin[a] < -extent_max || b->origin[a] > extent_max || b->size[a] < 1 || b->size[a] > extent_max)
    return false;
  if (b->lead[a] != (b->origin[a] & (NP_BRICK_NODE_EDGE - 1))) return false;
  if (b->table_size[a] != (b->lead[a] + b->size[a] + NP_BRICK_NODE_EDGE - 1) >> NP_BRICK_NODE_SHIFT) return false;
  if (!is_periodic) return b->reach_low[a] == b->origin[a] && b->reach_high[a] == b->origin[a] + b->size[a];
  return b->origin[a] == 0 && b->period[a] == NP_BRICK_EDGE * b->size[a] && b->reach_low[a] == -b->reach_high[a] &&
         b->reach_high[a] >= b->size[a] && b->reach_high[a] <= far;
}

bool np_bricks_check_shape(const np_bricks *b) {
  uint64_t count = 1;
  for (int a = 0; a < 3; a++) {
    if (!check_axis(b, a)) return false;
    count *= (uint64_t)b->table_size[a];
    if (count > table_count_max) return false;
  }
  return b->node_count <= count && b->brick_count <= b->node_count * NP_BRICK_NODE_CELLS && isfinite(b->scale) &&
         b->scale > 0.0f && isfinite(b->background) && isfinite(b->value_max);
}

/* ---- Content ---- */

/* Whether a range is ordered and within ±most; NaN is in no range. */
static bool is_range(np_brick_range range, float most) {
  return range.min <= range.max && range.min >= -most && range.max <= most;
}

static bool check_node(const np_bricks *b, const np_brick_node *node) {
  const float most = fabsf(b->value_max);
  bool is_sound = is_range(node->whole_range, most);
  for (size_t i = 0; i < NP_BRICK_NODE_CELLS; i++)
    is_sound = is_sound && is_range(node->range[i], most) &&
               (node->brick[i] == NP_BRICK_NONE || node->brick[i] < b->brick_count);
  for (size_t i = 0; i < NP_BRICK_NODE_GROUPS; i++) is_sound = is_sound && is_range(node->group_range[i], most);
  return is_sound;
}

bool np_bricks_check_content(const np_bricks *b) {
  const size_t count = np_bricks_count_table(b);
  const float most = fabsf(b->value_max);
  for (size_t i = 0; i < count; i++) {
    if (b->table[i] == NP_BRICK_NONE ? !is_range(b->table_ranges[i], most) : b->table[i] >= b->node_count) return false;
  }
  for (size_t i = 0; i < b->node_count; i++)
    if (!check_node(b, &b->nodes[i])) return false;
  return true;
}

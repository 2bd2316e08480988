/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/bricks.h"

#include "core/alloc.h"

void np_bricks_clear(np_bricks *bricks) {
  if (!bricks->context) return;
  np_alloc_free(bricks->context, bricks->table);
  np_alloc_free(bricks->context, bricks->table_ranges);
  np_alloc_free(bricks->context, bricks->nodes);
  np_alloc_free(bricks->context, bricks->halves);
  np_alloc_free(bricks->context, bricks->floats);
  *bricks = (np_bricks){0};
}

size_t np_bricks_count_table(const np_bricks *bricks) {
  return (size_t)bricks->table_size[0] * (size_t)bricks->table_size[1] * (size_t)bricks->table_size[2];
}

size_t np_bricks_get_bytes(const np_bricks *bricks) {
  const size_t sample_bytes = bricks->halves ? sizeof *bricks->halves : sizeof *bricks->floats;
  return np_bricks_count_table(bricks) * (sizeof *bricks->table + sizeof *bricks->table_ranges) +
         bricks->node_count * sizeof *bricks->nodes + bricks->brick_count * NP_BRICK_STRIDE * sample_bytes;
}

double np_bricks_count_joined(const np_bricks *bricks) {
  enum { ACROSS_MAX = 512, CELLS_PER_BRICK = 64 };
  double across = 0.0, cells = 1.0, joined = 1.0;
  if (bricks->is_periodic[0] || bricks->is_periodic[1]) return joined;
  for (int a = 0; a < 3; a++) {
    across = fmax(across, (double)NP_BRICK_EDGE * bricks->size[a]);
    cells *= bricks->size[a];
  }
  const double enough = (double)CELLS_PER_BRICK * (double)bricks->brick_count;
  while (across > ACROSS_MAX * joined && cells > enough * joined * joined * joined) joined *= 2.0;
  return joined;
}

/* ---- Cells ---- */

typedef struct cell_list {
  const np_bricks *bricks;
  int32_t (*out)[3];
  size_t count;
} cell_list;

static void add_cell(cell_list *list, const int32_t node[3], const int32_t at[3]) {
  const np_bricks *bricks = list->bricks;
  int32_t inside[3];
  for (int a = 0; a < 3; a++) {
    inside[a] = node[a] * NP_BRICK_NODE_EDGE + at[a] - bricks->lead[a];
    if (inside[a] < 0 || inside[a] >= bricks->size[a]) return;
  }
  const np_brick_place place = np_bricks_get_place(bricks, inside);
  if (np_brick_range_is_zero(np_bricks_get_range(bricks, &place, 0))) return;
  for (int a = 0; a < 3 && list->out; a++) list->out[list->count][a] = bricks->origin[a] + inside[a];
  list->count++;
}

static void add_cells(cell_list *list, const int32_t node[3]) {
  int32_t at[3];
  for (at[0] = 0; at[0] < NP_BRICK_NODE_EDGE; at[0]++)
    for (at[1] = 0; at[1] < NP_BRICK_NODE_EDGE; at[1]++)
      for (at[2] = 0; at[2] < NP_BRICK_NODE_EDGE; at[2]++) add_cell(list, node, at);
}

size_t np_bricks_list_cells(const np_bricks *bricks, int32_t (*out)[3]) {
  cell_list list = {.bricks = bricks, .out = out};
  int32_t node[3];
  size_t entry = 0;
  for (node[0] = 0; node[0] < bricks->table_size[0]; node[0]++)
    for (node[1] = 0; node[1] < bricks->table_size[1]; node[1]++)
      for (node[2] = 0; node[2] < bricks->table_size[2]; node[2]++, entry++) {
        const bool is_constant = bricks->table[entry] == NP_BRICK_NONE;
        if (!is_constant || !np_brick_range_is_zero(bricks->table_ranges[entry])) add_cells(&list, node);
      }
  return list.count;
}

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

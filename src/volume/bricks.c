/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/bricks.h"

#include "core/alloc.h"

void np_bricks_clear(np_bricks *bricks) {
  if (!bricks->context) return;
  np_alloc_free(bricks->context, bricks->table);
  for (int level = 0; level < NP_BRICK_LEVELS; level++) np_alloc_free(bricks->context, bricks->ranges[level]);
  np_alloc_free(bricks->context, bricks->halves);
  np_alloc_free(bricks->context, bricks->floats);
  *bricks = (np_bricks){0};
}

size_t np_bricks_count_cells(const np_bricks *bricks, int level) {
  const int32_t *size = bricks->size[level];
  return (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
}

size_t np_bricks_get_bytes(const np_bricks *bricks) {
  size_t bytes = np_bricks_count_cells(bricks, 0) * sizeof *bricks->table;
  for (int level = 0; level < NP_BRICK_LEVELS; level++)
    bytes += np_bricks_count_cells(bricks, level) * sizeof *bricks->ranges[level];
  return bytes +
         bricks->brick_count * NP_BRICK_STRIDE * (bricks->halves ? sizeof *bricks->halves : sizeof *bricks->floats);
}

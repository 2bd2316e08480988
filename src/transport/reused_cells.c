/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/reused_cells.h"

#include <string.h>

#include "core/alloc.h"
#include "transport/scattering_field_private.h"

np_reused_cells *np_scattering_field_take_cells(np_scattering_field *field, bool is_lit) {
  if (!field->has_whole_grid) return NULL;
  np_reused_cells *cells = np_alloc(field->context, 1, sizeof *cells);
  if (!cells) return NULL;
  *cells = (np_reused_cells){.grid = field->grid, .is_lit = is_lit};
  field->grid = (np_transport_grid){.context = field->context};
  field->has_whole_grid = false;
  return cells;
}

static void clear_first_collisions(np_transport_grid *grid) {
  np_alloc_free(grid->context, grid->first_collision_source);
  np_alloc_free(grid->context, grid->low_order_source);
  np_alloc_free(grid->context, grid->delta_m_residual);
  grid->first_collision_source = grid->low_order_source = grid->delta_m_residual = NULL;
}

/* Whether the planes of two grids are the same. */
static bool are_alike(const np_transport_grid *a, const np_transport_grid *b) {
  bool are = a->degree == b->degree && a->is_fine == b->is_fine;
  for (int i = 0; i < 3; i++)
    are = are && a->size[i] == b->size[i] && a->is_wrapped[i] == b->is_wrapped[i] &&
          !memcmp(a->edge_m[i], b->edge_m[i], ((size_t)a->size[i] + 1) * sizeof *a->edge_m[i]);
  return are;
}

bool np_reused_cells_move(np_reused_cells *cells, np_transport_grid *grid, bool *out_is_lit) {
  *out_is_lit = false;
  if (!cells || !cells->grid.active) return false;
  if (!are_alike(&cells->grid, grid)) return false;
  np_transport_grid_clear(grid);
  *grid = cells->grid;
  cells->grid = (np_transport_grid){.context = grid->context};
  *out_is_lit = cells->is_lit;
  np_log(grid->context, NEPH_LOG_DEBUG, "multiple scattering: cells%s of the solution before it are reused",
         cells->is_lit ? " and first collisions" : "");
  if (!cells->is_lit) clear_first_collisions(grid);
  return true;
}

void np_reused_cells_destroy(np_reused_cells *cells) {
  if (!cells) return;
  neph_context *context = cells->grid.context;
  np_transport_grid_clear(&cells->grid);
  np_alloc_free(context, cells);
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/solved_clouds.h"

#include "core/alloc.h"
#include "transport/scattering_field_private.h"

static bool is_left_out(const np_instance *cloud, uint64_t left_out) { return left_out >> cloud->number & 1u; }

neph_result np_solved_clouds_list(neph_context *context, const np_world *world, uint64_t left_out,
                                  np_solved_clouds *out) {
  const np_instances *all = &world->clouds;
  *out = (np_solved_clouds){.context = context, .world = *world};
  unsigned count = 0;
  for (unsigned v = 0; v < all->count; v++)
    if (!is_left_out(&all->at[v], left_out)) out->number[count++] = v;
  if (count == all->count || (all->places && count > 0)) {
    for (unsigned v = 0; v < all->count; v++) out->number[v] = v;
    return NEPH_OK;
  }
  out->at = np_alloc(context, count, sizeof *out->at);
  if (!out->at) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned v = 0; v < count; v++) out->at[v] = all->at[out->number[v]];
  out->world.clouds = (np_instances){.count = count, .at = out->at};
  return NEPH_OK;
}

void np_solved_clouds_clear(np_solved_clouds *solved) {
  np_alloc_free(solved->context, solved->at);
  solved->at = NULL;
}

/* Builds a field of one empty cell and the phase functions, without multiple scattering. */
static neph_result build_dark(const np_world *world, const np_transport_desc *cells, np_scattering_field *out) {
  const double low[3] = {cells->bounds_min.x, cells->bounds_min.y, cells->bounds_min.z},
               high[3] = {cells->bounds_max.x, cells->bounds_max.y, cells->bounds_max.z};
  np_transport_grid *g = &out->grid;
  *g = (np_transport_grid){.context = out->context, .degree = NP_DEGREE_MIN};
  g->active = np_alloc(out->context, 1, sizeof *g->active);
  bool is_whole = g->active;
  if (is_whole) *g->active = NP_TRANSPORT_CELL_NONE;
  for (int a = 0; a < 3; a++) {
    g->size[a] = 1;
    g->even_m[a] = fmax(high[a] - low[a], 1.0);
    g->edge_m[a] = np_alloc(out->context, 2, sizeof *g->edge_m[a]);
    is_whole = is_whole && g->edge_m[a];
    for (int end = 0; end < 2 && g->edge_m[a]; end++) g->edge_m[a][end] = low[a] + end * g->even_m[a];
  }
  out->medium.band_count = 1;
  out->medium.colour = np_spectrum_grey(1.0f);
  return is_whole ? np_scattering_field_build_phases(world, NP_DEGREE_MIN, out) : NEPH_ERROR_OUT_OF_MEMORY;
}

neph_result np_scattering_field_make_dark(neph_context *context, const np_world *world, const np_transport_desc *cells,
                                          np_scattering_field **out_field) {
  np_scattering_field *field = np_scattering_field_create(context);
  const neph_result result = field ? build_dark(world, cells, field) : NEPH_ERROR_OUT_OF_MEMORY;
  if (result)
    np_scattering_field_destroy(field);
  else
    *out_field = field;
  return result;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Solutions kept on disk: cells and moments. Phase tables are computed anew, of the same clouds. */
#include "core/alloc.h"
#include "core/disk_cache.h"
#include "transport/scattering_field_private.h"

/* Cells of any solution: each takes hundreds of bytes while it is solved for. */
static const size_t cells_max = (size_t)1 << 28;

/* All but the blocks. */
typedef struct field_header {
  int32_t size[3];
  uint32_t degree, band_count, sweeps;
  uint64_t active_count;
  double even_m[3], repeat_m[3], residual, error;
  np_transport_fold fold;
  np_fold_light fold_light;
  np_kept_moments kept;
  float colour[NP_BAND_COUNT], scale[NP_BAND_COUNT], beyond_scale[NP_BAND_COUNT], first_ratio[NP_BAND_COUNT];
  uint8_t is_wrapped[3], is_fine, has_delta_m_residual, has_importance, has_beyond, padding[1];
} field_header;

static size_t count_moments(const np_scattering_field *field) {
  return field->grid.active_count * np_scattering_field_get_offset(field, field->medium.band_count);
}

static field_header fill_header(const np_scattering_field *field) {
  const np_transport_grid *g = &field->grid;
  field_header h = {.degree = g->degree,
                    .band_count = field->medium.band_count,
                    .sweeps = field->sweeps,
                    .active_count = g->active_count,
                    .fold = g->fold,
                    .kept = field->kept,
                    .fold_light = field->fold_light,
                    .residual = field->quality.residual,
                    .error = field->quality.error,
                    .is_fine = g->is_fine,
                    .has_delta_m_residual = field->delta_m_residual != NULL,
                    .has_importance = field->importance != NULL,
                    .has_beyond = field->beyond != NULL};
  for (int a = 0; a < 3; a++) {
    h.size[a] = g->size[a];
    h.even_m[a] = g->even_m[a];
    h.is_wrapped[a] = g->is_wrapped[a];
    h.repeat_m[a] = g->repeat_m[a];
  }
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    h.colour[b] = field->medium.colour.band[b];
    h.scale[b] = field->scale[b];
    h.beyond_scale[b] = field->beyond_scale[b];
    h.first_ratio[b] = field->first_ratio[b];
  }
  return h;
}

void np_scattering_field_save(const np_scattering_field *field, np_cache_entry *entry) {
  const np_transport_grid *g = &field->grid;
  const field_header h = fill_header(field);
  NP_CACHE_WRITE(entry, h);
  for (int a = 0; a < 3; a++) np_cache_write(entry, g->edge_m[a], ((size_t)g->size[a] + 1) * sizeof *g->edge_m[a]);
  np_cache_write(entry, g->cell, g->active_count * sizeof *g->cell);
  np_cache_write(entry, field->moments, count_moments(field) * sizeof *field->moments);
  if (h.has_beyond) np_cache_write(entry, field->beyond, count_moments(field) * sizeof *field->beyond);
  if (h.has_delta_m_residual)
    np_cache_write(entry, field->delta_m_residual,
                   g->active_count * field->medium.band_count * sizeof *field->delta_m_residual);
  if (h.has_importance) np_cache_write(entry, field->importance, g->active_count * sizeof *field->importance);
}

static void take_header(const field_header *h, np_scattering_field *field) {
  np_transport_grid *g = &field->grid;
  *g = (np_transport_grid){.context = field->context,
                           .degree = h->degree,
                           .active_count = (size_t)h->active_count,
                           .is_fine = h->is_fine,
                           .fold = h->fold};
  field->fold_light = h->fold_light;
  field->kept = h->kept;
  for (int a = 0; a < 3; a++) {
    g->size[a] = h->size[a];
    g->even_m[a] = h->even_m[a];
    g->is_wrapped[a] = h->is_wrapped[a];
    g->repeat_m[a] = h->repeat_m[a];
  }
  field->medium.band_count = h->band_count;
  field->medium.has_delta_m_residual = h->has_delta_m_residual;
  field->sweeps = h->sweeps;
  field->quality = (np_scattering_quality){.residual = h->residual, .error = h->error};
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    field->medium.colour.band[b] = h->colour[b];
    field->scale[b] = h->scale[b];
    field->beyond_scale[b] = h->beyond_scale[b];
    field->first_ratio[b] = h->first_ratio[b];
  }
}

static bool is_kept(const np_kept_moments *kept, unsigned degree) {
  return kept->first == np_harmonics_count(degree) &&
         (kept->further == kept->first || (kept->further == NP_HARMONIC_COUNT_MIN && kept->further < kept->first));
}

/* Checks a header: ascending planes, a number of cells that fits into memory, valid harmonics and bands. */
static bool is_sound(const field_header *h) {
  const size_t count = np_cache_count_cells(h->size);
  if (count == 0 || count > cells_max || h->active_count > count) return false;
  return h->degree >= 1 && h->degree <= NP_DEGREE_MAX && (h->band_count == 1 || h->band_count == NP_BAND_COUNT) &&
         is_kept(&h->kept, h->degree) && np_cache_are_doubles_finite(h->even_m, 3) &&
         np_cache_are_doubles_finite(h->repeat_m, 3) &&
         fmin(fmin(h->repeat_m[0], h->repeat_m[1]), h->repeat_m[2]) >= 0.0 && h->even_m[0] >= 0.0 &&
         h->even_m[1] >= 0.0 && h->even_m[2] >= 0.0 &&
         np_cache_are_doubles_finite(&h->fold.period_m, sizeof h->fold / sizeof h->fold.period_m) &&
         np_cache_are_finite(h->colour, NP_BAND_COUNT) && np_cache_are_finite(h->scale, NP_BAND_COUNT) &&
         np_cache_are_finite(h->beyond_scale, NP_BAND_COUNT) && np_cache_are_finite(h->first_ratio, NP_BAND_COUNT);
}

static bool are_ascending(const double *edge_m, int32_t cells) {
  bool are = true;
  for (int32_t i = 0; i < cells; i++) are = are && edge_m[i + 1] > edge_m[i];
  return are && np_cache_are_doubles_finite(edge_m, (size_t)cells + 1);
}

/* Numbers of the active cells, by the cells that they are. */
static bool number_cells(np_transport_grid *g) {
  const size_t count = np_transport_grid_count(g);
  g->active = np_alloc(g->context, count, sizeof *g->active);
  if (!g->active) return false;
  for (size_t i = 0; i < count; i++) g->active[i] = NP_TRANSPORT_CELL_NONE;
  for (size_t active = 0; active < g->active_count; active++) {
    if (g->cell[active] < 0 || (size_t)g->cell[active] >= count) return false;
    g->active[g->cell[active]] = (int32_t)active;
  }
  return true;
}

static bool load_blocks(const field_header *h, np_cache_entry *entry, np_scattering_field *field) {
  np_transport_grid *g = &field->grid;
  const size_t cells = g->active_count, bands = field->medium.band_count;
  for (int a = 0; a < 3; a++) {
    g->edge_m[a] = np_cache_read_block(entry, (size_t)g->size[a] + 1, sizeof *g->edge_m[a]);
    if (!g->edge_m[a] || !np_cache_read_check(entry, are_ascending(g->edge_m[a], g->size[a]))) return false;
  }
  g->cell = np_cache_read_block(entry, cells, sizeof *g->cell);
  if (!g->cell || !np_cache_read_check(entry, number_cells(g))) return false;
  field->moments = np_cache_read_halves(entry, count_moments(field));
  if (h->has_beyond) field->beyond = np_cache_read_halves(entry, count_moments(field));
  if (h->has_delta_m_residual) field->delta_m_residual = np_cache_read_floats(entry, cells * bands);
  if (h->has_importance) field->importance = np_cache_read_block(entry, cells, sizeof *field->importance);
  return field->moments && (field->beyond || !h->has_beyond) && (field->delta_m_residual || !h->has_delta_m_residual) &&
         (field->importance || !h->has_importance);
}

neph_result np_scattering_field_load(neph_context *context, const np_world *world, np_cache_entry *entry,
                                     np_scattering_field **out_field) {
  field_header h;
  *out_field = NULL;
  if (!NP_CACHE_READ(entry, h) || !np_cache_read_check(entry, is_sound(&h))) return NEPH_OK;
  np_scattering_field *field = np_scattering_field_create(context);
  if (!field) return NEPH_ERROR_OUT_OF_MEMORY;
  take_header(&h, field);
  neph_result result = np_scattering_field_build_phases(world, h.degree, field);
  if (!result && load_blocks(&h, entry, field))
    *out_field = field;
  else
    np_scattering_field_destroy(field);
  return result;
}

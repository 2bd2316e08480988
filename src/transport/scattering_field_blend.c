/* SPDX-License-Identifier: Apache-2.0 */
/* Sums of two solutions of the same clouds, under lights that differ: light adds up, and so do its moments. */
#include <string.h>

#include "core/alloc.h"
#include "core/half.h"
#include "transport/scattering_field_private.h"

enum { CHUNK = 1024 };

static bool has_same_cells(const np_transport_grid *a, const np_transport_grid *b) {
  bool is_same = a->degree == b->degree && a->active_count == b->active_count && a->is_fine == b->is_fine;
  for (int k = 0; k < 3; k++)
    is_same = is_same && a->size[k] == b->size[k] &&
              !memcmp(a->edge_m[k], b->edge_m[k], ((size_t)a->size[k] + 1) * sizeof *a->edge_m[k]);
  return is_same && !memcmp(a->cell, b->cell, a->active_count * sizeof *a->cell);
}

bool np_scattering_field_can_blend(const np_scattering_field *a, const np_scattering_field *b) {
  return has_same_cells(&a->grid, &b->grid) && !a->delta_m_residual == !b->delta_m_residual && !a->beyond && !b->beyond;
}

static void *copy_block(neph_context *context, const void *from, size_t count, size_t size) {
  void *to = np_alloc(context, count, size);
  return to ? memcpy(to, from, count * size) : NULL;
}

static neph_result copy_grid(const np_transport_grid *from, np_transport_grid *to) {
  neph_context *context = to->context;
  bool is_whole = true;
  for (int k = 0; k < 3; k++) {
    to->size[k] = from->size[k];
    to->even_m[k] = from->even_m[k];
    to->is_wrapped[k] = from->is_wrapped[k];
    to->repeat_m[k] = from->repeat_m[k];
    to->edge_m[k] = copy_block(context, from->edge_m[k], (size_t)from->size[k] + 1, sizeof *to->edge_m[k]);
    is_whole = is_whole && to->edge_m[k];
  }
  const size_t cells = (size_t)from->size[0] * from->size[1] * from->size[2];
  to->is_fine = from->is_fine;
  to->fold = from->fold;
  to->degree = from->degree;
  to->active_count = from->active_count;
  to->cell = copy_block(context, from->cell, from->active_count, sizeof *to->cell);
  to->active = copy_block(context, from->active, cells, sizeof *to->active);
  return is_whole && to->cell && to->active ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* One of the two fields, with its weights in each band. */
typedef struct blend_part {
  const np_scattering_field *field;
  double weight[NP_BAND_COUNT];
} blend_part;

static unsigned get_band(const np_scattering_field *field, unsigned band) {
  return field->medium.band_count == 1 ? 0 : band;
}

static float get_factor(const blend_part *p, unsigned band) {
  const double colour = p->field->medium.band_count == 1 ? (double)p->field->medium.colour.band[band] : 1.0;
  return (float)(p->weight[band] * colour);
}

typedef struct blending {
  blend_part parts[2];
  const np_transport_grid *grid; /* cells of the sum */
  uint16_t *moments;             /* [active][band][harmonic], times `scale` */
  float *scale;
} blending;

/* A part may have no such cell. */
static void add_part(const blending *b, unsigned part, int32_t cell, unsigned band, float sum[NP_HARMONIC_COUNT_MAX]) {
  const np_scattering_field *from = b->parts[part].field;
  const int32_t active = from->grid.active[cell];
  const float factor = get_factor(&b->parts[part], band);
  const unsigned own = from->kept.first, most = np_harmonics_count(b->grid->degree);
  float moments[NP_HARMONIC_COUNT_MAX];
  if (active < 0) return;
  np_scattering_field_read_band(from, (size_t)active, get_band(from, band), moments);
  for (unsigned i = 0; i < own && i < most; i++) sum[i] += factor * moments[i];
}

static neph_result blend_cells(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const blending *b = user;
  const unsigned count = np_harmonics_count(b->grid->degree);
  for (size_t active = begin; active < end; active++)
    for (unsigned band = 0; band < NP_BAND_COUNT; band++) {
      float sum[NP_HARMONIC_COUNT_MAX] = {0.0f};
      uint16_t *out = b->moments + (active * NP_BAND_COUNT + band) * count;
      for (unsigned part = 0; part < 2; part++) add_part(b, part, b->grid->cell[active], band, sum);
      for (unsigned i = 0; i < count; i++) out[i] = np_half_from_float(sum[i] / b->scale[band]);
    }
  return NEPH_OK;
}

/* Powers of two that leave room for the sum of both. */
static void choose_scales(const blending *b) {
  for (unsigned band = 0; band < NP_BAND_COUNT; band++) {
    double room = 0.0;
    for (int k = 0; k < 2; k++) {
      const np_scattering_field *from = b->parts[k].field;
      const unsigned own = get_band(from, band);
      const float scale = from->scale[own] + from->first_ratio[own] * from->scale[0];
      room += (double)(get_factor(&b->parts[k], band) * scale);
    }
    b->scale[band] = room > 0.0 ? (float)exp2(ceil(log2(room))) : 1.0f;
  }
}

static neph_result blend_moments(blending *b, neph_context *context, np_monitor *monitor) {
  choose_scales(b);
  return np_parallel_for(context, monitor, b->grid->active_count, CHUNK, blend_cells, b);
}

/* It is for a unit irradiance: the mean by the weights themselves. The second field: NULL where it counts for nothing.
 */
static void blend_residual(const np_scattering_field *const fields[2], double share, np_scattering_field *out) {
  for (size_t cell = 0; out->delta_m_residual && cell < out->grid.active_count; cell++)
    for (unsigned band = 0; band < NP_BAND_COUNT; band++) {
      double sum = 0.0;
      for (int k = 0; k < 2 && fields[k]; k++) {
        const size_t at = cell * fields[k]->medium.band_count + get_band(fields[k], band);
        sum += (k ? share : 1.0 - share) * (double)fields[k]->delta_m_residual[at];
      }
      out->delta_m_residual[cell * NP_BAND_COUNT + band] = (float)sum;
    }
}

static uint16_t *allocate_moments(const np_scattering_field *field) {
  const size_t cells = field->grid.active_count * NP_BAND_COUNT;
  return np_alloc(field->context, cells * np_harmonics_count(field->grid.degree), sizeof *field->moments);
}

static neph_result allocate(np_scattering_field *out, bool has_residual) {
  const unsigned count = np_harmonics_count(out->grid.degree);
  out->kept = (np_kept_moments){count, count};
  out->medium.band_count = NP_BAND_COUNT;
  out->medium.colour = np_spectrum_grey(1.0f);
  out->medium.has_delta_m_residual = has_residual;
  out->moments = allocate_moments(out);
  if (has_residual)
    out->delta_m_residual =
        np_alloc(out->context, out->grid.active_count * NP_BAND_COUNT, sizeof *out->delta_m_residual);
  return out->moments && (out->delta_m_residual || !has_residual) ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static np_scattering_quality get_worst(const np_scattering_field *a, const np_scattering_field *b) {
  return (np_scattering_quality){.residual = fmax(a->quality.residual, b->quality.residual),
                                 .error = fmax(a->quality.error, b->quality.error),
                                 .is_cut = a->quality.is_cut || b->quality.is_cut,
                                 .cut_width = a->quality.cut_width > b->quality.cut_width ? a->quality.cut_width
                                                                                          : b->quality.cut_width};
}

/* A field without light, with the cells of the first and the worse quality of both; NULL on failure. */
static neph_result create_on_cells(const np_scattering_field *first, const np_scattering_field *second,
                                   const np_world *world, np_scattering_field **out_field) {
  np_scattering_field *out = *out_field = np_scattering_field_create(first->context);
  if (!out) return NEPH_ERROR_OUT_OF_MEMORY;
  out->grid.context = out->context;
  out->quality = get_worst(first, second);
  neph_result result = np_scattering_field_build_phases(world, first->grid.degree, out);
  if (!result) result = copy_grid(&first->grid, &out->grid);
  if (!result && out->grid.fold.period_m > 0.0) np_fold_light_fill(world, &out->grid.fold, &out->fold_light);
  if (!result) result = allocate(out, first->delta_m_residual != NULL);
  return result;
}

/* Keeps a field, or on failure destroys it. */
static neph_result finish(neph_result result, np_scattering_field **field) {
  if (!result) return NEPH_OK;
  np_scattering_field_destroy(*field);
  *field = NULL;
  return result;
}

neph_result np_scattering_field_blend(const np_scattering_blend *desc, const np_world *world, np_monitor *monitor,
                                      np_scattering_field **out_field) {
  neph_result result = create_on_cells(desc->fields[0], desc->fields[1], world, out_field);
  if (result) return finish(result, out_field);
  np_scattering_field *out = *out_field;
  blending b = {.grid = &out->grid, .moments = out->moments, .scale = out->scale};
  for (int k = 0; k < 2; k++) {
    b.parts[k].field = desc->fields[k];
    for (int band = 0; band < NP_BAND_COUNT; band++)
      b.parts[k].weight[band] = (k ? desc->share : 1.0 - desc->share) * desc->gain[band];
  }
  blend_residual(desc->fields, desc->share, out);
  return finish(blend_moments(&b, out->context, monitor), out_field);
}

/* ---- Fires ---- */

/* Light that guides paths to the sun is that of the others; mean radiance, and where from, adds up. */
static neph_result add_importance(const np_scattering_field *others, const np_scattering_field *fires,
                                  np_scattering_field *out) {
  if (!others->importance) return NEPH_OK;
  const size_t count = out->grid.active_count;
  out->importance = copy_block(out->context, others->importance, count, sizeof *out->importance);
  for (size_t active = 0; out->importance && active < count; active++) {
    const int32_t own = fires->grid.active[out->grid.cell[active]];
    const np_importance *from = own < 0 || !fires->importance ? NULL : &fires->importance[own];
    np_importance *to = &out->importance[active];
    if (!from) continue;
    to->mean += from->mean;
    for (int a = 0; a < 3; a++) to->linear[a] += from->linear[a];
    for (int i = 0; i < 5; i++) to->quadratic[i] += from->quadratic[i];
  }
  return out->importance ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result add_fires(const np_scattering_field *others, const np_scattering_field *fires, np_monitor *monitor,
                             np_scattering_field *out) {
  const np_scattering_field *fields[2] = {others, NULL};
  blending b = {.grid = &out->grid,
                .moments = out->beyond = allocate_moments(out),
                .scale = out->beyond_scale,
                .parts = {{others, {1.0, 1.0, 1.0}}, {fires, {0.0, 0.0, 0.0}}}};
  if (!out->beyond) return NEPH_ERROR_OUT_OF_MEMORY;
  out->sweeps = others->sweeps + fires->sweeps;
  blend_residual(fields, 0.0, out);
  neph_result result = blend_moments(&b, out->context, monitor);
  b.moments = out->moments;
  b.scale = out->scale;
  for (int band = 0; band < NP_BAND_COUNT; band++) b.parts[1].weight[band] = 1.0;
  if (!result) result = blend_moments(&b, out->context, monitor);
  return result ? result : add_importance(others, fires, out);
}

neph_result np_scattering_field_add_fires(const np_scattering_field *others, const np_scattering_field *fires,
                                          const np_world *world, np_monitor *monitor, np_scattering_field **out_field) {
  neph_result result = create_on_cells(others, fires, world, out_field);
  if (!result) result = add_fires(others, fires, monitor, *out_field);
  return finish(result, out_field);
}

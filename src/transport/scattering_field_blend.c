/* SPDX-License-Identifier: Apache-2.0 */
/* A solution between two of the same clouds, under lights that differ: light adds up, and so do its moments. */
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
  return has_same_cells(&a->grid, &b->grid) && !a->delta_m_residual == !b->delta_m_residual;
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
  np_scattering_field *out;
} blending;

static float sum_moment(const blending *b, size_t cell, unsigned band, unsigned index, unsigned count) {
  float sum = 0.0f;
  for (int k = 0; k < 2; k++) {
    const np_scattering_field *from = b->parts[k].field;
    const unsigned own = get_band(from, band);
    const uint16_t half = from->moments[(cell * from->medium.band_count + own) * count + index];
    sum += get_factor(&b->parts[k], band) * from->scale[own] * np_half_to_float(half);
  }
  return sum;
}

static neph_result blend_cells(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const blending *b = user;
  np_scattering_field *out = b->out;
  const unsigned count = np_harmonics_count(out->grid.degree);
  for (size_t cell = begin; cell < end; cell++)
    for (unsigned band = 0; band < NP_BAND_COUNT; band++)
      for (unsigned i = 0; i < count; i++)
        out->moments[(cell * NP_BAND_COUNT + band) * count + i] =
            np_half_from_float(sum_moment(b, cell, band, i, count) / out->scale[band]);
  return NEPH_OK;
}

/* It is for a unit irradiance: the mean by the weights themselves. */
static void blend_residual(const blending *b, double share) {
  for (size_t cell = 0; b->out->delta_m_residual && cell < b->out->grid.active_count; cell++)
    for (unsigned band = 0; band < NP_BAND_COUNT; band++) {
      double sum = 0.0;
      for (int k = 0; k < 2; k++) {
        const np_scattering_field *from = b->parts[k].field;
        const size_t at = cell * from->medium.band_count + get_band(from, band);
        sum += (k ? share : 1.0 - share) * (double)from->delta_m_residual[at];
      }
      b->out->delta_m_residual[cell * NP_BAND_COUNT + band] = (float)sum;
    }
}

/* Powers of two that leave room for the sum of both. */
static void choose_scales(const blending *b) {
  for (unsigned band = 0; band < NP_BAND_COUNT; band++) {
    double room = 0.0;
    for (int k = 0; k < 2; k++) {
      const np_scattering_field *from = b->parts[k].field;
      room += (double)(get_factor(&b->parts[k], band) * from->scale[get_band(from, band)]);
    }
    b->out->scale[band] = room > 0.0 ? (float)exp2(ceil(log2(room))) : 1.0f;
  }
}

static neph_result allocate(np_scattering_field *out, bool has_residual) {
  neph_context *context = out->context;
  const size_t cells = out->grid.active_count * NP_BAND_COUNT;
  out->medium.band_count = NP_BAND_COUNT;
  out->medium.colour = np_spectrum_grey(1.0f);
  out->medium.has_delta_m_residual = has_residual;
  out->moments = np_alloc(context, cells * np_harmonics_count(out->grid.degree), sizeof *out->moments);
  if (has_residual) out->delta_m_residual = np_alloc(context, cells, sizeof *out->delta_m_residual);
  return out->moments && (out->delta_m_residual || !has_residual) ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static np_scattering_quality get_worst(const np_scattering_field *a, const np_scattering_field *b) {
  return (np_scattering_quality){.residual = fmax(a->quality.residual, b->quality.residual),
                                 .error = fmax(a->quality.error, b->quality.error)};
}

neph_result np_scattering_field_blend(const np_scattering_blend *desc, const np_world *world, np_monitor *monitor,
                                      np_scattering_field **out_field) {
  const np_scattering_field *first = desc->fields[0];
  np_scattering_field *out = *out_field = np_scattering_field_create(first->context);
  if (!out) return NEPH_ERROR_OUT_OF_MEMORY;
  blending b = {.out = out};
  for (int k = 0; k < 2; k++) {
    b.parts[k].field = desc->fields[k];
    for (int band = 0; band < NP_BAND_COUNT; band++)
      b.parts[k].weight[band] = (k ? desc->share : 1.0 - desc->share) * desc->gain[band];
  }
  out->grid.context = out->context;
  out->quality = get_worst(first, desc->fields[1]);
  neph_result result = np_scattering_field_build_phases(world, first->grid.degree, out);
  if (!result) result = copy_grid(&first->grid, &out->grid);
  if (!result && out->grid.fold.period_m > 0.0) np_fold_light_fill(world, &out->grid.fold, &out->fold_light);
  if (!result) result = allocate(out, first->delta_m_residual != NULL);
  if (!result) {
    choose_scales(&b);
    blend_residual(&b, desc->share);
    result = np_parallel_for(out->context, monitor, out->grid.active_count, CHUNK, blend_cells, &b);
  }
  if (!result) return NEPH_OK;
  np_scattering_field_destroy(out);
  *out_field = NULL;
  return result;
}

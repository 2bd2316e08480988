/* SPDX-License-Identifier: Apache-2.0 */
/* Look-ups in a solution of the multiple scattering: trilinear means over the cells around a point. Compiled once per
 * instruction-set level. */
#include <float.h>

#include "core/isa.h"
#include "transport/scattering_field_private.h"
#include "volume/bricks.h"

extern const np_scattering_lookup NP_KERNEL(np_scattering_lookup);

enum { LANES = 16 }; /* numbers of harmonics are multiples of it */

/* sum += weight·moments */
static void add_moments(const uint16_t moments[LANES], float weight, float sum[LANES]) {
#if defined(__F16C__)
  for (int k = 0; k < LANES; k += 8) {
    const __m256 values = _mm256_cvtph_ps(_mm_loadu_si128((const void *)(moments + k)));
    const __m256 added = _mm256_mul_ps(_mm256_set1_ps(weight), values);
    _mm256_storeu_ps(sum + k, _mm256_add_ps(_mm256_loadu_ps(sum + k), added));
  }
#else
  for (int k = 0; k < LANES; k += 4) {
    const __m128i halves = _mm_loadl_epi64((const void *)(moments + k));
    const __m128 values = np_brick_decode_halves(_mm_unpacklo_epi16(halves, _mm_setzero_si128()));
    _mm_storeu_ps(sum + k, _mm_add_ps(_mm_loadu_ps(sum + k), _mm_mul_ps(_mm_set1_ps(weight), values)));
  }
#endif
}

static void average_residual(const np_scattering_field *f, const int32_t active[8], const float weight[8],
                             unsigned count, float out[NP_BAND_COUNT]) {
  for (unsigned b = 0; b < f->medium.band_count && f->delta_m_residual; b++) {
    out[b] = 0.0f;
    for (unsigned c = 0; c < count; c++)
      out[b] += weight[c] * f->delta_m_residual[(size_t)active[c] * f->medium.band_count + b];
  }
}

/* The place whose light a place has. */
static np_dvec3 match(const np_scattering_field *f, np_dvec3 position) {
  return f->grid.fold.period_m > 0.0 ? np_transport_fold_match(&f->grid.fold, position) : position;
}

/* Completes the moments of bands that keep fewer than the first: out->value is [band][harmonic]. */
static inline void add_first(const np_scattering_field *f, np_light_moments *out) {
  const unsigned count = f->kept.first, own = f->kept.further;
  for (unsigned b = 1; b < f->medium.band_count && own < count; b++) {
    float *value = out->value + b * count;
    const float ratio = f->first_ratio[b];
    for (unsigned i = 0; i < own; i++) value[i] += ratio * out->value[i];
    for (unsigned i = own; i < count; i++) value[i] = ratio * out->value[i];
  }
}

/* Multiplies the moments by the light of a fold's other tiles. */
static void add_fold_light(const np_scattering_field *f, np_dvec3 position, np_light_moments *out) {
  float gain[NP_BAND_COUNT];
  np_fold_light_get(&f->fold_light, &f->grid.fold, position, gain);
  for (unsigned i = 0; i < f->medium.band_count * f->kept.first; i++) out->value[i] *= gain[i / f->kept.first];
}

static inline void add_cells(const np_scattering_field *f, np_dvec3 position, unsigned bands, np_kept_moments kept,
                             np_light_moments *out) {
  int32_t active[8];
  float weight[8];
  const unsigned count = np_transport_grid_get_corners(&f->grid, match(f, position), active, weight);
  const bool is_beyond = f->beyond && !np_scattering_field_holds(f, position);
  const uint16_t *moments = is_beyond ? f->beyond : f->moments;
  const float *scale = is_beyond ? f->beyond_scale : f->scale;
  const size_t width = kept.first + (bands - 1) * kept.further;
  for (unsigned b = 0, begin = 0; b < bands; b++) {
    const unsigned own = b == 0 ? kept.first : kept.further;
    for (unsigned first = 0; first < own; first += LANES, begin += LANES) {
      float lanes[LANES] = {0.0f};
      for (unsigned c = 0; c < count; c++) add_moments(moments + (size_t)active[c] * width + begin, weight[c], lanes);
      for (unsigned k = 0; k < LANES; k++) out->value[b * kept.first + first + k] = scale[b] * lanes[k];
    }
  }
  add_first(f, out);
  if (f->grid.fold.period_m > 0.0) add_fold_light(f, position, out);
  average_residual(f, active, weight, count, out->delta_m_residual);
}

/* The least numbers, which the largest clouds have, are known to the compiler. */
static void gather(const np_scattering_field *f, np_dvec3 position, np_light_moments *out) {
  const unsigned bands = f->medium.band_count;
  if (bands == 1 && f->kept.first == NP_HARMONIC_COUNT_MIN)
    add_cells(f, position, 1, (np_kept_moments){NP_HARMONIC_COUNT_MIN, NP_HARMONIC_COUNT_MIN}, out);
  else
    add_cells(f, position, bands, f->kept, out);
}

static void gather_cells(const np_scattering_field *f, np_dvec3 position, np_scattering_cells *out) {
  out->count = np_transport_grid_get_corners(&f->grid, position, out->cell, out->weight);
  average_residual(f, out->cell, out->weight, out->count, out->delta_m_residual);
}

static float sum_moments(const float *moments, const float *outgoing, unsigned count) {
  float lanes[LANES] = {0.0f};
  for (unsigned first = 0; first < count; first += LANES)
    for (unsigned k = 0; k < LANES; k++) lanes[k] += outgoing[first + k] * moments[first + k];
  for (unsigned k = 0; k < 8; k++) lanes[k] += lanes[k + 8];
  for (unsigned k = 0; k < 4; k++) lanes[k] += lanes[k + 4];
  return lanes[0] + lanes[2] + (lanes[1] + lanes[3]);
}

static np_spectrum get_outgoing(const np_scattering_field *f, const np_light_moments *moments, const float *outgoing) {
  const unsigned count = np_harmonics_count(f->grid.degree);
  const float first = sum_moments(moments->value, outgoing, count);
  if (f->medium.band_count == 1) return np_spectrum_scale(f->medium.colour, np_maxf(first, 0.0f));
  const float second = sum_moments(moments->value + count, outgoing, count);
  const float third = sum_moments(moments->value + 2 * count, outgoing, count);
  return np_spectrum_make(np_maxf(first, 0.0f), np_maxf(second, 0.0f), np_maxf(third, 0.0f));
}

static void unpack(const np_scattering_field *f, size_t active, np_light_moments *out) {
  const unsigned bands = f->medium.band_count, count = f->kept.first;
  const uint16_t *moments = f->moments + active * np_scattering_field_get_offset(f, bands);
  for (unsigned i = 0; i < bands * count; i++) out->value[i] = 0.0f;
  for (unsigned b = 0; b < bands; b++)
    for (unsigned i = 0; i < (b == 0 ? count : f->kept.further); i += LANES, moments += LANES)
      add_moments(moments, f->scale[b], out->value + b * count + i);
  add_first(f, out);
}

static void fill_cell(const np_scattering_field *f, size_t cell, np_vec3 direction, float *out) {
  const unsigned count = np_harmonics_count(f->grid.degree);
  float harmonics[NP_HARMONIC_COUNT_MAX], outgoing[NP_HARMONIC_COUNT_MAX];
  np_light_moments moments;
  np_scattering_field_fill_harmonics(f, direction, harmonics);
  unpack(f, cell, &moments);
  for (unsigned v = 0, known = 0; v < f->medium.cloud_count; v++) {
    if (f->medium.clouds[v].phase_kind < known) continue;
    known++;
    np_scattering_field_fill_outgoing(f, v, harmonics, outgoing);
    for (unsigned b = 0; b < f->medium.band_count; b++)
      *out++ = sum_moments(moments.value + b * count, outgoing, count);
  }
}

static bool get_importance(const np_scattering_field *f, np_dvec3 position, np_importance *out) {
  int32_t active[8];
  float weight[8];
  const unsigned count = np_transport_grid_get_corners(&f->grid, match(f, position), active, weight);
  *out = (np_importance){0};
  for (unsigned c = 0; c < count; c++) {
    const np_importance *cell = &f->importance[active[c]];
    out->mean += weight[c] * cell->mean;
    for (int a = 0; a < 3; a++) out->linear[a] += weight[c] * cell->linear[a];
    for (int i = 0; i < 5; i++) out->quadratic[i] += weight[c] * cell->quadratic[i];
    out->lit += weight[c] * cell->lit;
  }
  return out->mean >= FLT_MIN;
}

const np_scattering_lookup NP_KERNEL(np_scattering_lookup) = {gather, gather_cells, get_outgoing, fill_cell,
                                                              get_importance};

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

/* Moments of the light at a place, and their factors in each band. */
static const uint16_t *get_moments(const np_scattering_field *f, np_dvec3 position, float out_scale[NP_BAND_COUNT]) {
  const bool is_beyond = f->beyond && !np_scattering_field_holds(f, position);
  const float *scale = is_beyond ? f->beyond_scale : f->scale;
  float gain[NP_BAND_COUNT] = {1.0f, 1.0f, 1.0f};
  if (f->grid.fold.period_m > 0.0) np_fold_light_get(&f->fold_light, &f->grid.fold, position, gain);
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) out_scale[b] = scale[b] * gain[b];
  return is_beyond ? f->beyond : f->moments;
}

static inline void add_cells(const np_scattering_field *f, np_dvec3 position, unsigned width, np_light_moments *out) {
  int32_t active[8];
  float weight[8], scale[NP_BAND_COUNT];
  const unsigned count = np_transport_grid_get_corners(&f->grid, match(f, position), active, weight);
  const uint16_t *moments = get_moments(f, position, scale);
  const unsigned harmonics = width / f->medium.band_count;
  for (unsigned first = 0; first < width; first += LANES) {
    float lanes[LANES] = {0.0f};
    for (unsigned c = 0; c < count; c++) add_moments(moments + (size_t)active[c] * width + first, weight[c], lanes);
    for (unsigned k = 0; k < LANES; k++) out->value[first + k] = scale[first / harmonics] * lanes[k];
  }
  average_residual(f, active, weight, count, out->delta_m_residual);
}

/* The least number of harmonics, which the largest clouds have, is known to the compiler. */
static void gather(const np_scattering_field *f, np_dvec3 position, np_light_moments *out) {
  const unsigned width = f->medium.band_count * np_harmonics_count(f->grid.degree);
  if (width == NP_HARMONIC_COUNT_MIN) {
    add_cells(f, position, NP_HARMONIC_COUNT_MIN, out);
  } else {
    add_cells(f, position, width, out);
  }
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
  const unsigned count = np_harmonics_count(f->grid.degree), width = f->medium.band_count * count;
  for (unsigned i = 0; i < width; i++) out->value[i] = 0.0f;
  for (unsigned i = 0; i < width; i += LANES)
    add_moments(f->moments + active * width + i, f->scale[i / count], out->value + i);
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

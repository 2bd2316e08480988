/* SPDX-License-Identifier: Apache-2.0 */
/* Light scattered more than once in clouds, solved for once for all views of a scene under its lights. */
#ifndef NP_TRANSPORT_SCATTERING_FIELD_H
#define NP_TRANSPORT_SCATTERING_FIELD_H

#include "transport/importance.h"
#include "transport/transport_grid.h"
#include "volume/bricks.h"

typedef struct np_scattering_desc {
  np_transport_desc cells;
  double work_max; /* cells × directions × harmonics of a sweep, up to which angles are resolved beyond the least */
  double tolerance;
  double seconds_max;  /* after which sweeps end, whatever the residual; infinite: no limit */
  bool has_importance; /* what paths are guided by is kept beside the moments */
} np_scattering_desc;

/* (1−g)·σ·edge of 0.35; a million and a half cells, of some 1.5 kB each in cloud while it is solved. */
#define NP_SCATTERING_DESC_DEFAULT                                                                                     \
  {                                                                                                                    \
    .cells = {.cell_count_max = 1500000, .cell_count_cheap = 60000, .cell_depth_max = 0.35}, .work_max = 3e7,          \
    .tolerance = 3e-4, .seconds_max = HUGE_VAL                                                                         \
  }

typedef struct np_scattering_field {
  neph_context *context; /* borrowed */
  unsigned volume_count;
  np_scaled_phase *phases; /* of each cloud; equal ones share their table */
  np_transport_grid grid;
  unsigned band_count; /* that are kept: 1 where they differ by a factor, `colour`, which else is 1 */
  np_spectrum colour;
  uint16_t
      *moments; /* [active][band][harmonic], halves, times `scale`: radiance but for sunlight which went straight on */
  float scale[NP_BAND_COUNT]; /* powers of two */
  float *delta_m_residual;    /* [active][band]: of the moments, those of sunlight that was scattered narrowly, over its
                       irradiance and    harmonics (transport_grid.h); NULL: there is none */
  np_importance
      *importance;    /* [active], in floats, since it may fall by thirty decades; NULL where it was not asked for */
  double residual;    /* relative, the worst band's */
  bool is_cut;        /* the description's time ended before the last sweep */
  unsigned cut_width; /* edge of the finest cells that were swept till then, in edges of the finest that are iterated */
  unsigned sweeps;    /* of the finest grid, all bands together */
  double error;       /* expected from the size of the largest cells, as a share of the light */
} np_scattering_field;

/* Allows as many fine cells as a picture of so many rays is worth, within the memory of `cells.cell_count_max`. */
void np_scattering_desc_set_rays(np_scattering_desc *desc, double rays);

/* Solves for the view's sun, sky and ground. On failure nothing is left. */
neph_result np_scattering_field_build(neph_context *context, const np_world *world, const np_sun_depth_source *depths,
                                      const np_scattering_desc *desc, np_monitor *monitor, np_scattering_field *out);
void np_scattering_field_clear(np_scattering_field *scatter);

/* Radiance that comes from outside, the sun's disk excluded, to a place among the clouds; `towards` looks out. */
np_spectrum np_boundary_radiance_compute(const np_world *world, const np_sun_depth_source *depths, np_dvec3 position,
                                         np_vec3 towards);

/* The same along the ordinates, averaged over the solid angle around each. */
typedef float np_boundary_radiance[NP_BAND_COUNT][NP_OCTANT_COUNT][NP_ORDINATE_BLOCKS_MAX][NP_ORDINATE_LANES];
void np_boundary_radiance_fill(const np_world *world, const np_sun_depth_source *depths, const np_transport_desc *cells,
                               const np_ordinates *ordinates, np_boundary_radiance out);

/* Moments of the radiance at one point, [band][harmonic], of the bands that are kept. */
typedef struct np_light_moments {
  float value[NP_BAND_COUNT * NP_HARMONIC_COUNT_MAX];
  float delta_m_residual[NP_BAND_COUNT];
} np_light_moments;

enum { NP_MOMENT_LANES = 16 }; /* numbers of harmonics are multiples of it */

/* sum += weight·moments */
static inline void np_moments_add(const uint16_t moments[NP_MOMENT_LANES], float weight, float sum[NP_MOMENT_LANES]) {
#if defined(__F16C__)
  for (int k = 0; k < NP_MOMENT_LANES; k += 8) {
    const __m256 values = _mm256_cvtph_ps(_mm_loadu_si128((const void *)(moments + k)));
    const __m256 added = _mm256_mul_ps(_mm256_set1_ps(weight), values);
    _mm256_storeu_ps(sum + k, _mm256_add_ps(_mm256_loadu_ps(sum + k), added));
  }
#else
  for (int k = 0; k < NP_MOMENT_LANES; k += 4) {
    const __m128i halves = _mm_loadl_epi64((const void *)(moments + k));
    const __m128 values = np_brick_decode_halves(_mm_unpacklo_epi16(halves, _mm_setzero_si128()));
    _mm_storeu_ps(sum + k, _mm_add_ps(_mm_loadu_ps(sum + k), _mm_mul_ps(_mm_set1_ps(weight), values)));
  }
#endif
}

static inline void np_scattering_field_average_narrow(const np_scattering_field *scatter, const int32_t active[8],
                                                      const float weight[8], unsigned count, float out[NP_BAND_COUNT]) {
  for (unsigned b = 0; b < scatter->band_count && scatter->delta_m_residual; b++) {
    out[b] = 0.0f;
    for (unsigned c = 0; c < count; c++)
      out[b] += weight[c] * scatter->delta_m_residual[(size_t)active[c] * scatter->band_count + b];
  }
}

static inline void np_scattering_field_add_cells(const np_scattering_field *scatter, np_dvec3 position, unsigned width,
                                                 np_light_moments *out) {
  int32_t active[8];
  float weight[8];
  const unsigned count = np_transport_grid_get_corners(&scatter->grid, position, active, weight);
  const unsigned harmonics = width / scatter->band_count;
  for (unsigned first = 0; first < width; first += NP_MOMENT_LANES) {
    float lanes[NP_MOMENT_LANES] = {0.0f};
    for (unsigned c = 0; c < count; c++)
      np_moments_add(scatter->moments + (size_t)active[c] * width + first, weight[c], lanes);
    for (unsigned k = 0; k < NP_MOMENT_LANES; k++) out->value[first + k] = scatter->scale[first / harmonics] * lanes[k];
  }
  np_scattering_field_average_narrow(scatter, active, weight, count, out->delta_m_residual);
}

/* The least number of harmonics, which the largest clouds have, is known to the compiler. */
static inline void np_scattering_field_gather(const np_scattering_field *scatter, np_dvec3 position,
                                              np_light_moments *out) {
  const unsigned width = scatter->band_count * np_harmonics_count(scatter->grid.degree);
  if (width == NP_HARMONIC_COUNT_MIN) {
    np_scattering_field_add_cells(scatter, position, NP_HARMONIC_COUNT_MIN, out);
  } else {
    np_scattering_field_add_cells(scatter, position, width, out);
  }
}

/* What a cloud of a phase function throws of each moment to where `harmonics` are those of; what counts as going
 * straight on is left out. */
static inline void np_scattering_field_fill_outgoing(const np_scaled_phase *phase,
                                                     const float harmonics[NP_HARMONIC_COUNT_MAX],
                                                     float out[NP_HARMONIC_COUNT_MAX]) {
  for (unsigned l = 0, i = 0; l <= phase->degree; l++)
    for (; i < (l + 1) * (l + 1); i++) out[i] = phase->moments[l] * harmonics[i];
}

static inline float np_scattering_field_sum(const float *moments, const float *outgoing, unsigned count) {
  float lanes[NP_MOMENT_LANES] = {0.0f};
  for (unsigned first = 0; first < count; first += NP_MOMENT_LANES)
    for (unsigned k = 0; k < NP_MOMENT_LANES; k++) lanes[k] += outgoing[first + k] * moments[first + k];
  for (unsigned k = 0; k < 8; k++) lanes[k] += lanes[k + 8];
  for (unsigned k = 0; k < 4; k++) lanes[k] += lanes[k + 4];
  return lanes[0] + lanes[2] + (lanes[1] + lanes[3]);
}

/* Radiance times phase function, over all directions, that a cloud throws. */
static inline np_spectrum np_scattering_field_outgoing(const np_scattering_field *scatter,
                                                       const np_light_moments *moments,
                                                       const float outgoing[NP_HARMONIC_COUNT_MAX]) {
  const unsigned count = np_harmonics_count(scatter->grid.degree);
  const float first = np_scattering_field_sum(moments->value, outgoing, count);
  if (scatter->band_count == 1) return np_spectrum_scale(scatter->colour, np_maxf(first, 0.0f));
  const float second = np_scattering_field_sum(moments->value + count, outgoing, count);
  const float third = np_scattering_field_sum(moments->value + 2 * count, outgoing, count);
  return np_spectrum_make(np_maxf(first, 0.0f), np_maxf(second, 0.0f), np_maxf(third, 0.0f));
}

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Light scattered more than once in clouds, solved for once for all views of a scene under its lights. */
#ifndef NP_LIGHT_MULTI_SCATTER_H
#define NP_LIGHT_MULTI_SCATTER_H

#include "light/transport_grid.h"

typedef struct np_multi_scatter_desc {
  np_transport_desc cells;
  unsigned order; /* of the ordinates, 4 or 6; periodic clouds take the product set */
  double tolerance;
} np_multi_scatter_desc;

/* (1−g)·σ·edge of 0.35; a million and a half cells, of some 1.2 kB each in cloud while it is solved; S6. */
#define NP_MULTI_SCATTER_DESC_DEFAULT                                                                                  \
  {                                                                                                                    \
    .cells = {.cell_count_max = 1500000, .cell_count_cheap = 60000, .cell_depth_max = 0.35}, .order = 6,               \
    .tolerance = 3e-4                                                                                                  \
  }

/* Moments of the radiance at one point. */
typedef struct np_light_moments {
  float band[NP_BAND_COUNT][NP_HARMONIC_COUNT];
} np_light_moments;

typedef struct np_multi_scatter {
  neph_context *context; /* borrowed */
  unsigned volume_count;
  np_scaled_phase *phases; /* of each cloud; equal ones share their table */
  np_transport_grid grid;
  np_light_moments *moments; /* of each live cell: radiance that is not sunlight which went straight on */
  double residual;           /* relative, the worst band's */
  unsigned sweeps;           /* of the finest grid, all bands together */
} np_multi_scatter;

/* Solves for the view's sun, sky and ground. On failure nothing is left. */
neph_result np_multi_scatter_build(neph_context *context, const np_scene_view *view, const np_multi_scatter_desc *desc,
                                   np_monitor *monitor, np_multi_scatter *out);
void np_multi_scatter_clear(np_multi_scatter *scatter);

/* Radiance that comes from outside to the clouds along the ordinates, averaged over the solid angle around each. */
typedef float np_inflow[NP_BAND_COUNT][NP_OCTANT_COUNT][NP_ORDINATE_BLOCKS_MAX][NP_ORDINATE_LANES];
void np_inflow_fill(const np_scene_view *view, const np_transport_desc *cells, const np_ordinates *ordinates,
                    np_inflow out);

static inline void np_multi_scatter_gather(const np_multi_scatter *scatter, np_dvec3 position, np_light_moments *out) {
  int32_t live[8];
  float weight[8];
  const unsigned count = np_transport_grid_find(&scatter->grid, position, live, weight);
  float *sum = &out->band[0][0];
  for (int i = 0; i < NP_BAND_COUNT * NP_HARMONIC_COUNT; i++) sum[i] = 0.0f;
  for (unsigned c = 0; c < count; c++) {
    const float *moments = &scatter->moments[live[c]].band[0][0], w = weight[c];
    for (int i = 0; i < NP_BAND_COUNT * NP_HARMONIC_COUNT; i++) sum[i] += w * moments[i];
  }
}

/* Radiance times phase function, over all directions, that a cloud of this phase function throws to `harmonics`; what
 * counts as going straight on is left out. */
static inline np_spectrum np_multi_scatter_towards(const np_light_moments *moments, const np_scaled_phase *phase,
                                                   const float harmonics[NP_HARMONIC_COUNT]) {
  np_spectrum out;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    float sum = 0.0f;
    for (int i = 0; i < NP_HARMONIC_COUNT; i++)
      sum += phase->moments[np_harmonic_degree[i]] * harmonics[i] * moments->band[b][i];
    out.band[b] = fmaxf(0.0f, sum);
  }
  return out;
}

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Light that the clouds throw towards one viewer, of the solution of the multiple scattering: what the march asks for
 * at every step of every ray from there.
 *
 * A cell is seen from one direction, nearly: so its moments φ are summed up towards the viewer once, and rays
 * interpolate sums Σ φ·Y instead of moments. Midway between two cells such a sum is off by ¼·Δφ·ΔY, their differences
 * from cell to cell: where a cell is a thirty-second as wide as it is far away ΔY is some l/32 of a harmonic of degree
 * l, and light that changes by a third from cell to cell is wrong by a quarter of a per cent in degree 1, half in
 * degree 2 and so on. Nearer cells are not asked for: there a ray gathers the moments themselves.
 */
#ifndef NP_LIGHT_VIEWER_LIGHT_H
#define NP_LIGHT_VIEWER_LIGHT_H

#include "light/multi_scatter.h"

typedef struct np_viewer_light {
  neph_context *context; /* borrowed */
  np_dvec3 viewer;
  double distance_min;                     /* m: from there on cells are far enough away */
  unsigned kind_count;                     /* of phase functions */
  unsigned char kind[NP_VIEW_VOLUMES_MAX]; /* of each cloud */
  float *thrown;                           /* [live][kind][band], of the bands that the solution keeps */
} np_viewer_light;

/* On failure nothing is left. The solution is asked again with what was built from it. */
neph_result np_viewer_light_build(neph_context *context, const np_multi_scatter *scatter, np_dvec3 viewer,
                                  np_monitor *monitor, np_viewer_light *out);
void np_viewer_light_clear(np_viewer_light *light);

/* Cells around a place. */
typedef struct np_viewer_place {
  unsigned count;
  int32_t live[8];
  float weight[8];
  float narrow[NP_BAND_COUNT]; /* as in np_light_moments */
} np_viewer_place;

static inline void np_viewer_place_find(const np_multi_scatter *scatter, np_dvec3 position, np_viewer_place *out) {
  out->count = np_transport_grid_find(&scatter->grid, position, out->live, out->weight);
  np_multi_scatter_average_narrow(scatter, out->live, out->weight, out->count, out->narrow);
}

/* np_multi_scatter_throw() towards the viewer. */
static inline np_spectrum np_viewer_light_throw(const np_viewer_light *light, const np_multi_scatter *scatter,
                                                const np_viewer_place *place, unsigned cloud) {
  const unsigned bands = scatter->band_count;
  const float *thrown = light->thrown + light->kind[cloud] * bands;
  float sum[NP_BAND_COUNT] = {0.0f};
  for (unsigned c = 0; c < place->count; c++)
    for (unsigned b = 0; b < bands; b++)
      sum[b] += place->weight[c] * thrown[(size_t)place->live[c] * light->kind_count * bands + b];
  if (bands == 1) return np_spectrum_scale(scatter->colour, np_maxf(sum[0], 0.0f));
  return np_spectrum_make(np_maxf(sum[0], 0.0f), np_maxf(sum[1], 0.0f), np_maxf(sum[2], 0.0f));
}

#endif

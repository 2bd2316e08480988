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
#ifndef NP_CACHES_VIEWER_LIGHT_H
#define NP_CACHES_VIEWER_LIGHT_H

#include "transport/scattering_field.h"

typedef struct np_viewer_light {
  neph_context *context; /* borrowed */
  np_dvec3 viewer;
  double distance_min;                  /* m: from there on cells are far enough away */
  unsigned kind_count;                  /* of phase functions */
  unsigned char kind[NP_INSTANCES_MAX]; /* of each cloud */
  float *outgoing;                      /* [active][kind][band], of the bands that the solution keeps */
} np_viewer_light;

/* On failure nothing is left. The solution is asked again with what was built from it. */
neph_result np_viewer_light_build(neph_context *context, const np_scattering_field *scatter, np_dvec3 viewer,
                                  np_monitor *monitor, np_viewer_light *out);
void np_viewer_light_clear(np_viewer_light *light);

/* Cells around a place. */
typedef struct np_viewer_place {
  unsigned count;
  int32_t active[8];
  float weight[8];
  float delta_m_residual[NP_BAND_COUNT]; /* as in np_light_moments */
} np_viewer_place;

static inline void np_viewer_place_get(const np_scattering_field *scatter, np_dvec3 position, np_viewer_place *out) {
  out->count = np_transport_grid_get_corners(&scatter->grid, position, out->active, out->weight);
  np_scattering_field_average_narrow(scatter, out->active, out->weight, out->count, out->delta_m_residual);
}

/* np_scattering_field_outgoing() towards the viewer. */
static inline np_spectrum np_viewer_light_outgoing(const np_viewer_light *light, const np_scattering_field *scatter,
                                                   const np_viewer_place *place, unsigned cloud) {
  const unsigned bands = scatter->band_count;
  const float *outgoing = light->outgoing + light->kind[cloud] * bands;
  float sum[NP_BAND_COUNT] = {0.0f};
  for (unsigned c = 0; c < place->count; c++)
    for (unsigned b = 0; b < bands; b++)
      sum[b] += place->weight[c] * outgoing[(size_t)place->active[c] * light->kind_count * bands + b];
  if (bands == 1) return np_spectrum_scale(scatter->colour, np_maxf(sum[0], 0.0f));
  return np_spectrum_make(np_maxf(sum[0], 0.0f), np_maxf(sum[1], 0.0f), np_maxf(sum[2], 0.0f));
}

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Light that clouds scatter out towards one viewer, from the solution of the multiple scattering: the march looks it up
 * at every step of every ray from there.
 *
 * A cell is seen from one direction, nearly: so its moments φ are summed up towards the viewer once, and rays
 * interpolate sums Σ φ·Y instead of moments. Midway between two cells such a sum is off by ¼·Δφ·ΔY, their differences
 * from cell to cell: where a cell is a thirty-second as wide as it is far away ΔY is some l/32 of a harmonic of degree
 * l, and light that changes by a third from cell to cell is wrong by a quarter of a per cent in degree 1, half in
 * degree 2 and so on. Nearer cells are not used: there a ray sums the moments themselves.
 */
#ifndef NP_CACHES_VIEWER_LIGHT_H
#define NP_CACHES_VIEWER_LIGHT_H

#include "transport/scattering_field.h"

typedef struct np_viewer_light {
  neph_context *context; /* borrowed */
  np_dvec3 viewer;
  double distance_min; /* m: distance from which on the cells are far enough away */
  unsigned phase_count, band_count;
  np_spectrum colour; /* colour factor, as in np_scattering_medium */
  float *outgoing;    /* [cell][phase_kind][band] */
} np_viewer_light;

/* Computes the light. On failure `*out` is empty. Queries need the same solution again. */
neph_result np_viewer_light_build(neph_context *context, const np_scattering_field *field, np_dvec3 viewer,
                                  np_monitor *monitor, np_viewer_light *out);
void np_viewer_light_clear(np_viewer_light *light);

/* Save it on disk, and load it for the same solution and viewer. False: the entry is too short. */
void np_viewer_light_save(const np_viewer_light *light, const np_scattering_field *field, np_cache_entry *entry);
bool np_viewer_light_load(neph_context *context, const np_scattering_field *field, np_dvec3 viewer,
                          np_cache_entry *entry, np_viewer_light *out);

/* Whether the light applies to an eye: at the viewer, or so close, within an aperture, that directions are equal. */
static inline bool np_viewer_light_serves(const np_viewer_light *light, np_dvec3 eye) {
  if (np_dvec3_is_equal(light->viewer, eye)) return true;
  return np_dvec3_length(np_dvec3_subtract(light->viewer, eye)) < 1e-3 * light->distance_min;
}

/* Light that clouds of a phase function scatter out to the viewer, from the cells around a point. */
static inline np_spectrum np_viewer_light_outgoing(const np_viewer_light *light, const np_scattering_cells *cells,
                                                   unsigned phase_kind) {
  const unsigned bands = light->band_count;
  const float *outgoing = light->outgoing + phase_kind * bands;
  float sum[NP_BAND_COUNT] = {0.0f};
  for (unsigned c = 0; c < cells->count; c++)
    for (unsigned b = 0; b < bands; b++)
      sum[b] += cells->weight[c] * outgoing[(size_t)cells->cell[c] * light->phase_count * bands + b];
  if (bands == 1) return np_spectrum_scale(light->colour, np_maxf(sum[0], 0.0f));
  return np_spectrum_make(np_maxf(sum[0], 0.0f), np_maxf(sum[1], 0.0f), np_maxf(sum[2], 0.0f));
}

#endif

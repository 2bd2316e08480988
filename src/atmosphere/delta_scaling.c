/* SPDX-License-Identifier: Apache-2.0 */
/* Delta-M scaling (Wiscombe 1977, "The Delta-M Method: Rapid Yet Accurate Radiative Flux Calculations for Strongly
 * Asymmetric Phase Functions", eqs. 6 to 12), with three moments.
 *
 * A share f = χ_3 of the aerosol's scattering counts as unscattered: it is removed from scattering and extinction, and
 * the rest scatters by the moments (χ_l − f)/(1 − f). Their sum to degree 2 is practically positive, unlike the sum of
 * the χ_l: with more aerosol than molecules, moments of the light could become negative.
 *
 * The forward share is still scattered light: the difference of sunlight through the scaled and through the true air,
 * from the sun's direction. It is added to the final moments. */

#include <assert.h>
#include <string.h>

#include "atmosphere/moment_builder.h"
#include "core/alloc.h"

static float compute_part(const np_aerosol *aerosol) { return np_clampf(aerosol->moment[3], 0.0f, 0.999f); }

static void scale_aerosol(np_aerosol *aerosol, float part) {
  assert(part >= 0.0f && part < 1.0f);
  for (int l = 1; l < 3; l++) aerosol->moment[l] = (aerosol->moment[l] - part) / (1.0f - part);
  aerosol->phase = np_phase_henyey_greenstein(np_clampf(aerosol->moment[1], -0.99f, 0.99f));
}

static void scale_layer(np_layer *layer, const float *part) {
  for (int k = 0; k < layer->part_count; k++) {
    np_layer_part *p = &layer->part[k];
    layer->extinction -= part[p->aerosol] * p->scattering;
    p->scattering *= 1.0f - part[p->aerosol];
  }
}

/* Scales the air. The result shares kinks and tables with the original, and owns its list of layers. */
static neph_result scale_medium(neph_context *context, const np_medium *medium, np_medium *out) {
  float part[NP_AEROSOLS_MAX];
  *out = *medium;
  out->layers = np_alloc(context, (size_t)medium->layer_count, sizeof *out->layers);
  if (!out->layers) return NEPH_ERROR_OUT_OF_MEMORY;
  memcpy(out->layers, medium->layers, (size_t)medium->layer_count * sizeof *out->layers);
  for (int i = 0; i < medium->aerosol_count; i++) {
    part[i] = compute_part(&medium->aerosol[i]);
    scale_aerosol(&out->aerosol[i], part[i]);
  }
  for (int i = 0; i < medium->layer_count; i++) scale_layer(&out->layers[i], part);
  return NEPH_OK;
}

static neph_result build_scaled(neph_context *context, const np_depth_table *depths, const np_medium *scaled,
                                const np_table_sizes *sizes, bool has_point_sun, np_monitor *monitor,
                                np_moment_table *out_table) {
  np_depth_table scaled_depths;
  neph_result result = np_depth_table_build(context, scaled, &sizes->depth, monitor, &scaled_depths);
  if (!result)
    result = np_moment_table_build(context, &scaled_depths, &sizes->moments, NP_ORDERS_ALL, has_point_sun, monitor,
                                   out_table);
  if (!result) np_moment_table_add_beam(out_table, &scaled_depths, depths, has_point_sun);
  np_depth_table_free(context, &scaled_depths);
  return result;
}

neph_result np_delta_moments_build(neph_context *context, const np_depth_table *depths, const np_table_sizes *sizes,
                                   bool has_point_sun, np_monitor *monitor, np_moment_table *out_table) {
  np_medium scaled;
  neph_result result = scale_medium(context, depths->medium, &scaled);
  if (!result) result = build_scaled(context, depths, &scaled, sizes, has_point_sun, monitor, out_table);
  out_table->medium = depths->medium;
  np_alloc_free(context, scaled.layers);
  return result;
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/sky_trace.h"

static void add_first_order(const np_sky_light *light, const np_fan *fan, const np_path_node *at, np_bands weight,
                            const np_fan_point *point, np_scattered *sums, np_bands *molecules) {
  const np_depth_row row = np_depth_table_row(light->depths, (double)at->altitude_m);
  const np_bands rayleigh = weight * at->air.rayleigh;
  np_bands sunlight[NP_FAN_MAX];
  light->kernels->compute_sunlight(&row, light->disk, point, sunlight);
  for (int i = 0; i < fan->count; i++) {
    const float c = fan->angle_cosine[i];
    const np_bands scattered = np_phase_rayleigh_eval(c) * sunlight[i] * rayleigh;
    sums[i].smooth += scattered;
    if (molecules) molecules[i] += scattered;
    sums[i].peak += weight * sunlight[i] * np_aerosol_peak(light->medium, &at->air, 1.0f - c);
  }
}

static void add_gathered(const np_sky_light *light, const np_fan *fan, const np_path_node *at, np_bands weight,
                         const np_fan_point *point, const np_bands *totals, np_scattered *sums) {
  const np_bands aerosol = weight * np_aerosol_sum(light->medium, &at->air, 0);
  const float inverse_sine = 1.0f / sqrtf(np_maxf(1.0f - at->cosine * at->cosine, 1e-6f));
  np_gather_row row;
  np_gather_table_row(light->gather, (double)at->altitude_m, at->cosine, &row);
  for (int i = 0; i < fan->count; i++)
    sums[i].smooth += aerosol * totals[i] *
                      np_gather_row_lookup(light->gather, &row, point->x[i] * inverse_sine, point->sun_cosine[i],
                                           fan->angle_cosine[i]);
}

static void add_later_orders(const np_sky_light *light, const np_fan *fan, const np_path_node *at, np_bands weight,
                             np_fan_point *point, np_scattered *sums) {
  const np_fan_source source = np_fan_source_make(light->moments, at, weight, !light->gather);
  np_bands later[NP_FAN_MAX], totals[NP_FAN_MAX];
  light->kernels->compute_columns(&light->moments->sun, fan, at->cosine, point);
  memset(later, 0, (size_t)point->count * sizeof *later);
  light->kernels->add_source(&source, point, later, light->gather ? totals : NULL);
  for (int i = 0; i < fan->count; i++) sums[i].smooth += later[i];
  if (light->gather) add_gathered(light, fan, at, weight, point, totals, sums);
}

void np_sky_add_scattered(const np_sky_light *light, const np_fan *fan, const np_path_node *at, np_bands weight,
                          np_scattered *sums, np_bands *molecules) {
  np_fan_point point;
  light->kernels->compute_sun_cosines(fan, (float)at->t, at->r, &point);
  add_first_order(light, fan, at, weight, &point, sums, molecules);
  if (light->moments) add_later_orders(light, fan, at, weight, &point, sums);
}

void np_sky_add_orders(const np_sky_light *light, const np_fan *fan, const np_path *path, np_scattered *first,
                       np_scattered *later) {
  for (int i = 0; i < path->count; i++) {
    const np_path_node *node = &path->node[i];
    const np_bands weight = node->weight_m * node->transmittance;
    np_fan_point point;
    light->kernels->compute_sun_cosines(fan, (float)node->t, node->r, &point);
    add_first_order(light, fan, node, weight, &point, first, NULL);
    if (light->moments) add_later_orders(light, fan, node, weight, &point, later);
  }
}

void np_sky_trace(const np_sky_light *light, const np_fan *fan, const np_path *path, np_scattered *out) {
  memset(out, 0, (size_t)fan->count * sizeof *out);
  for (int i = 0; i < path->count; i++) {
    const np_path_node *node = &path->node[i];
    np_sky_add_scattered(light, fan, node, node->weight_m * node->transmittance, out, NULL);
  }
  /* The aerosol's source cut after degree 2 may be negative where the sky is darkest. */
  for (int i = 0; i < fan->count; i++) out[i].smooth = np_bands_max(out[i].smooth, np_bands_grey(0.0f));
}

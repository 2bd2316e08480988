/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/sky_trace.h"

void np_sky_node_resolve(const np_sky_light *light, const np_path_node *at, np_sky_node *out_node) {
  out_node->air.rayleigh = at->air.rayleigh;
  for (int i = 0; i < light->medium->aerosol_count; i++) out_node->air.aerosol[i] = at->air.aerosol[i];
  for (int k = 0; k < 3; k++) out_node->aerosol[k] = np_aerosol_sum(light->medium, &at->air, k);
  out_node->t = at->t;
  out_node->r = at->r;
  out_node->cosine = at->cosine;
  out_node->inverse_sine = 1.0f / sqrtf(np_maxf(1.0f - at->cosine * at->cosine, 1e-6f));
  out_node->depth = np_depth_table_row(light->depths, (double)at->altitude_m);
  if (!light->moments) return;
  const int row = np_moment_table_row(light->moments, (double)at->altitude_m, &out_node->moments_upper);
  out_node->moments = np_moment_table_at_row(light->moments, row);
  if (light->gather) np_gather_table_row(light->gather, (double)at->altitude_m, at->cosine, &out_node->gather);
}

/* Radiance that the ground at the end of a ray sends back along it. */
static np_bands trace_ground(const np_sky_light *light, const np_ray *ray, float sun_cosine, float angle_cosine) {
  const float radius = (float)light->medium->planet_radius_m;
  const float sun = np_clampf(((float)ray->r * sun_cosine + (float)ray->length_m * angle_cosine) / radius, -1.0f, 1.0f);
  const np_depth_row row = np_depth_table_row(light->depths, 0.0);
  np_bands irradiance = np_maxf(sun, 0.0f) * np_depth_row_sun(&row, sun, light->disk);
  if (light->moments) irradiance += np_moment_table_irradiance(light->moments, sun);
  return (float)(1.0 / NP_PI) * light->medium->ground_albedo * irradiance;
}

np_scattered np_sky_trace(const np_sky_light *light, const np_ray *ray, const np_path *path, const np_sky_node *nodes,
                          float sun_cosine, float angle_cosine, bool has_ground) {
  np_scattered sum = {np_bands_grey(0.0f), np_bands_grey(0.0f)};
  for (int i = 0; i < path->count; i++) {
    const np_scattered source = np_sky_node_source(light, &nodes[i], (float)ray->r, sun_cosine, angle_cosine);
    const np_bands weight = path->node[i].weight_m * path->node[i].transmittance;
    sum.smooth += weight * source.smooth;
    sum.peak += weight * source.peak;
  }
  if (has_ground && ray->hits_ground)
    sum.smooth += path->end_transmittance * trace_ground(light, ray, sun_cosine, angle_cosine);
  /* The degree-2 cut of the aerosol's source may dip below nothing where the sky is darkest. */
  sum.smooth = np_bands_max(sum.smooth, np_bands_grey(0.0f));
  return sum;
}

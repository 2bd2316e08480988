/* SPDX-License-Identifier: Apache-2.0 */
#include "caches/cloud_gather.h"

#include <assert.h>

#include "core/units.h"
#include "world/emission.h"

void np_cloud_gather_init(np_cloud_gather *g) {
  const np_scattering_medium *medium = np_scattering_field_get_medium(g->scattering);
  for (unsigned v = 0; v < g->world->clouds.count; v++)
    g->fade[v] = np_scaled_cloud_get_scale(&medium->clouds[v], g->world->clouds.at[v].albedo);
}

void np_cloud_gather_aim(const np_cloud_gather *g, np_vec3 towards, np_cloud_direction *out) {
  out->towards = towards;
  if (!g->scattering) return;
  np_scattering_field_fill_harmonics(g->scattering, np_vec3_scale(towards, -1.0f), out->harmonics);
  for (unsigned v = 0; v < g->world->clouds.count; v++) {
    np_peak_column column;
    np_scattering_field_fill_column(g->scattering, v, np_vec3_versine(towards, g->world->to_sun), &column);
    out->broad[v] = fmaxf(0.0f, column.broad);
  }
}

bool np_cloud_gather_clip(const np_cloud_gather *g, np_dvec3 origin, np_vec3 direction, double *out_begin,
                          double *out_end) {
  const double o[3] = {origin.x, origin.y, origin.z}, d[3] = {direction.x, direction.y, direction.z};
  const double low[3] = {g->bounds_min.x, g->bounds_min.y, g->bounds_min.z},
               high[3] = {g->bounds_max.x, g->bounds_max.y, g->bounds_max.z};
  *out_begin = 0.0;
  *out_end = g->fold.period_m > 0.0 ? g->fold.range_m : HUGE_VAL;
  for (int a = 0; a < 3; a++) {
    if (a < 2 && (g->period[a].length_m > 0.0 || g->fold.period_m > 0.0)) continue;
    if (fabs(d[a]) < 1e-12) {
      if (o[a] < low[a] || o[a] > high[a]) return false;
      continue;
    }
    const double t[2] = {(low[a] - o[a]) / d[a], (high[a] - o[a]) / d[a]};
    *out_begin = fmax(*out_begin, fmin(t[0], t[1]));
    *out_end = fmin(*out_end, fmax(t[0], t[1]));
  }
  return *out_begin < *out_end;
}

float np_cloud_gather_extinction(const np_cloud_gather *g, np_dvec3 position, float extinction[NP_INSTANCES_MAX]) {
  const np_world *world = g->world;
  float scaled = 0.0f;
  for (unsigned v = 0; v < world->clouds.count; v++)
    extinction[v] = world->clouds.places ? 0.0f : np_instance_extinction(&world->clouds.at[v], position);
  if (world->clouds.places) np_places_add_extinction(world->clouds.places, position, 1.0f, extinction);
  for (unsigned v = 0; v < world->clouds.count; v++) scaled += g->fade[v] * extinction[v];
  return scaled;
}

/* Radiance per metre that the clouds at a place scatter along a direction; returns their scaled extinction. */
static float compute_source(const np_cloud_gather *g, const np_cloud_direction *d, np_dvec3 position,
                            np_spectrum *out_source) {
  const np_world *world = g->world;
  float extinction[NP_INSTANCES_MAX];
  const float scaled = np_cloud_gather_extinction(g, position, extinction);
  if (!(scaled > 0.0f)) return 0.0f;
  np_light_moments moments;
  np_scattering_field_gather(g->scattering, position, &moments);
  const float depth = np_sun_optical_depths_get_scaled(g->depths, position, world->to_sun, g->fade, 16.0f);
  const np_spectrum sun = np_spectrum_scale(np_world_sunlight(world, position, world->to_sun), np_transmittance(depth));
  *out_source = np_spectrum_grey(0.0f);
  for (unsigned v = 0; v < world->clouds.count; v++) {
    float outgoing[NP_HARMONIC_COUNT_MAX];
    np_scattering_field_fill_outgoing(g->scattering, v, d->harmonics, outgoing);
    np_spectrum light = np_scattering_field_get_outgoing(g->scattering, &moments, outgoing);
    light = np_spectrum_multiply(np_spectrum_add_scaled(light, d->broad[v], sun), world->clouds.at[v].albedo);
    *out_source = np_spectrum_add_scaled(*out_source, extinction[v], light);
  }
  return scaled;
}

/* Mean transmittance over a length of an optical depth. */
static float compute_mean(float depth) { return depth > 1e-3f ? np_opacity(depth) / depth : 1.0f - 0.5f * depth; }

np_cloud_view np_cloud_gather_follow(const np_cloud_gather *g, const np_cloud_direction *d, np_dvec3 origin,
                                     const np_cloud_steps *steps) {
  const np_emission *emission = g->world->emission;
  np_cloud_view out = {.transmittance = 1.0f};
  double begin, end, distances = 0.0;
  if (!np_cloud_gather_clip(g, origin, d->towards, &begin, &end)) return out;
  end = fmin(end, steps->end_m);
  if (!(begin < end)) return out;
  const int count = (int)np_clamp(ceil((end - begin) / steps->length_m), 1.0, steps->count_max);
  const double length = (end - begin) / count;
  assert(length > 0.0 && steps->offset >= 0.0 && steps->offset <= 1.0);
  for (int k = 0; k < count && out.transmittance > 1e-3f; k++) {
    np_spectrum source;
    const double at = begin + (k + steps->offset) * length;
    const np_dvec3 place = np_dvec3_along(origin, d->towards, at);
    const float scaled = compute_source(g, d, place, &source);
    if (emission)
      out.emitted =
          np_spectrum_add_scaled(out.emitted, out.transmittance * compute_mean(scaled * (float)length) * (float)length,
                                 np_emission_eval(emission, place));
    if (!(scaled > 0.0f)) continue;
    const float passed = np_transmittance(scaled * (float)length), stopped = out.transmittance * (1.0f - passed);
    assert(passed >= 0.0f && passed <= 1.0f);
    out.light = np_spectrum_add_scaled(out.light, stopped / scaled, source);
    distances += at * (double)stopped;
    out.transmittance *= passed;
  }
  if (out.transmittance < 1.0f) out.middle_m = (float)(distances / (1.0 - (double)out.transmittance));
  return out;
}

double np_cloud_gather_find_ground(const np_cloud_gather *g, np_dvec3 origin, np_vec3 direction, np_ground_hit *hit) {
  return np_world_intersect_ground(g->world, origin, direction, hit) ? hit->distance_m : (double)INFINITY;
}

np_spectrum np_cloud_gather_light_hill(const np_cloud_gather *g, const np_ground_hit *hill) {
  const np_world *world = g->world;
  const float cosine = np_vec3_dot(hill->normal, world->to_sun);
  np_spectrum light = np_spectrum_scale(np_world_level_irradiance(world, hill), np_world_get_sky_share(world, hill));
  const np_spectrum sun = np_world_sunlight(world, hill->position, world->to_sun);
  if (cosine > 0.0f && !np_spectrum_is_zero(sun)) {
    const float depth = np_sun_optical_depths_get_scaled(g->depths, hill->position, world->to_sun, g->fade, 16.0f);
    light = np_spectrum_add_scaled(light, cosine * np_transmittance(depth), sun);
  }
  return np_spectrum_scale(np_spectrum_multiply(light, hill->albedo), 1.0f / NP_PI_F);
}

double np_cloud_gather_compute_voxel(const np_world *world) {
  double finest = INFINITY;
  const np_instance *places = np_instances_get_places(&world->clouds);
  for (unsigned v = 0; v < np_instances_count_places(&world->clouds); v++)
    for (int a = 0; a < 3; a++) {
      const double *row = places[v].world_to_index.m[a];
      finest = fmin(finest, 1.0 / np_dvec3_length(np_dvec3_make(row[0], row[1], row[2])));
    }
  return finest;
}

np_dvec3 np_cloud_gather_ground(const np_cloud_gather *g, double x, double y) {
  np_dvec3 position = np_dvec3_make(x, y, 0.0);
  (void)np_world_find_ground(g->world, np_dvec3_make(x, y, g->bounds_max.z + 1e4), np_vec3_make(0, 0, -1), &position);
  return position;
}

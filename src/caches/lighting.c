/* SPDX-License-Identifier: Apache-2.0 */
#include "caches/lighting.h"

#include "core/stable.h"

/* Half widths of the range about 1 over which shares that are lost become 1: clouds let some of the light around them
 * through, ground does not. */
static const float ground_round = 0.05f, open_round = 0.3f;

/* The lesser of a share and 1, without an edge where they meet. */
static float limit_share(float share, float round) {
  const float over = np_clampf(share - (1.0f - round), 0.0f, 2.0f * round);
  return np_minf(share, 1.0f + round) - over * over / (4.0f * round);
}

/* Changes in-scatter up to a distance by what clouds and hills take and give; `first` is its first order. */
static np_spectrum shade(const np_air_change *change, np_ray_end end, np_spectrum light, np_spectrum first) {
  const float round = end == NP_RAY_END_GROUND ? ground_round : open_round;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float higher = fmaxf(light.band[b] - first.band[b], 0.0f);
    const float lost =
        limit_share(change->higher_share.band[b], round) * higher + change->lost_share.band[b] * first.band[b];
    light.band[b] = fmaxf(light.band[b] - lost + change->other.band[b], 0.0f);
  }
  return light;
}

enum { SHADE_PLACES = 3 };

/* Share of the sun that ground and clouds hide, in the mean over places along a ray. */
static float compute_shade(const np_lighting *lighting, const np_world *world, const np_view_ray *view,
                           double distance_m) {
  float shade = 0.0f;
  for (int i = 0; i < SHADE_PLACES; i++) {
    const np_dvec3 place = np_dvec3_along(view->eye, view->direction, distance_m * (i + 0.5) / SHADE_PLACES);
    const bool is_hidden = np_world_is_sun_hidden(world, place, world->to_sun);
    const float depth =
        is_hidden ? 0.0f : np_sun_optical_depths_get(&lighting->sun_optical_depths, place, world->to_sun, 16.0f);
    shade += (is_hidden ? 1.0f : 1.0f - np_transmittance(depth)) / SHADE_PLACES;
  }
  return shade;
}

static np_aerial_perspective get_air_by_places(const np_lighting *lighting, const np_world *world,
                                               const np_view_ray *view, const np_sky_ray *ray, double distance_m) {
  np_spectrum first;
  np_aerial_perspective air = np_sky_ray_get_air(ray, distance_m, &first);
  const float shade = compute_shade(lighting, world, view, distance_m);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float higher = fmaxf(air.inscatter.band[b] - first.band[b], 0.0f);
    air.inscatter.band[b] = fmaxf(air.inscatter.band[b] - shade * (first.band[b] + np_higher_lost * higher), 0.0f);
  }
  return air;
}

np_spectrum np_lighting_camera_sky(const np_lighting *lighting, const np_world *world, const np_view_ray *view) {
  if (!lighting->air_shadow || !world->camera_sky)
    return np_world_sky_radiance(world, world->camera_sky, view->eye, view->direction);
  np_spectrum first;
  const np_sky_ray ray = np_sky_ray_start(world->camera_sky, view->direction);
  (void)np_sky_ray_get_air(&ray, INFINITY, &first);
  const np_air_change change = np_air_shadow_get(lighting->air_shadow, view, INFINITY, NP_RAY_END_NONE);
  const np_spectrum clear = np_sky_radiance(world->camera_sky, view->direction);
  return np_world_add_beyond(world, view->eye, view->direction, shade(&change, NP_RAY_END_NONE, clear, first));
}

np_spectrum np_lighting_background(const np_lighting *lighting, const np_world *world, const np_view_ray *view) {
  const np_spectrum sky = np_lighting_camera_sky(lighting, world, view);
  const np_spectrum disk = np_world_disk_radiance(world, view->direction);
  if (np_spectrum_is_zero(disk)) return sky;
  if (!world->atmosphere) return np_spectrum_add(sky, disk);
  return np_spectrum_add(sky, np_spectrum_multiply(disk, np_atmosphere_transmittance_to_space(
                                                             world->atmosphere, view->eye, view->direction)));
}

np_aerial_perspective np_lighting_camera_air(const np_lighting *lighting, const np_world *world,
                                             const np_view_ray *view, double distance_m, np_ray_end end) {
  const neph_sky *sky = world->camera_sky;
  const bool is_by_places = lighting->has_shade_by_places && isfinite(distance_m);
  if (!sky || (!lighting->air_shadow && !is_by_places && !view->sky_ray))
    return np_world_air(world, sky, view->eye, view->direction, distance_m);
  np_sky_ray own;
  if (!view->sky_ray) own = np_sky_ray_start(sky, view->direction);
  const np_sky_ray *ray = view->sky_ray ? view->sky_ray : &own;
  if (is_by_places) return get_air_by_places(lighting, world, view, ray, distance_m);
  if (!lighting->air_shadow) return np_sky_ray_get_air(ray, distance_m, NULL);
  np_spectrum first;
  np_aerial_perspective air = np_sky_ray_get_air(ray, distance_m, &first);
  const np_air_change change = np_air_shadow_get(lighting->air_shadow, view, distance_m, end);
  air.inscatter = shade(&change, end, air.inscatter, first);
  for (int b = 0; b < NP_BAND_COUNT; b++) air.transmittance.band[b] *= 1.0f + change.passed.band[b];
  return air;
}

np_spectrum np_lighting_ground_irradiance(const np_lighting *lighting, const np_world *world,
                                          const np_ground_hit *hit) {
  if (lighting->relief_light) return np_relief_light_get(lighting->relief_light, hit);
  return np_relief_light_get_bare(world, lighting->ground_light, hit);
}

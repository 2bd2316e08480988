/* SPDX-License-Identifier: Apache-2.0 */
#include "caches/lighting.h"

/* The lesser of a loss and what there is, without an edge where they meet. */
static float limit_loss(float loss, float there) {
  if (!(loss > 0.0f) || !(there > 0.0f)) return loss > 0.0f ? 0.0f : loss;
  const float ratio = fminf(loss / there, 1e3f), square = ratio * ratio, fourth = square * square;
  return loss / sqrtf(sqrtf(sqrtf(1.0f + fourth * fourth)));
}

/* Changes in-scatter up to a distance by what clouds and hills take and give; `first` is its first order. No more is
 * lost than there is: tables of the whole and of the first order are interpolated separately. */
static np_spectrum shade(const np_air_change *change, np_spectrum light, np_spectrum first) {
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float higher = fmaxf(light.band[b] - first.band[b], 0.0f);
    const float lost =
        limit_loss(change->higher_share.band[b] * light.band[b], higher) + change->lost_share.band[b] * first.band[b];
    light.band[b] = fmaxf(light.band[b] - lost + change->other.band[b], 0.0f);
  }
  return light;
}

np_spectrum np_lighting_camera_sky(const np_lighting *lighting, const np_world *world, const np_view_ray *view) {
  if (!lighting->air_shadow || !world->camera_sky)
    return np_world_sky_radiance(world, world->camera_sky, view->eye, view->direction);
  np_spectrum first;
  const np_sky_ray ray = np_sky_ray_start(world->camera_sky, view->direction);
  (void)np_sky_ray_get_air(&ray, INFINITY, &first);
  const np_air_change change = np_air_shadow_get(lighting->air_shadow, view, INFINITY, NP_RAY_END_NONE);
  const np_spectrum clear = np_sky_radiance(world->camera_sky, view->direction);
  return np_world_add_beyond(world, view->eye, view->direction, shade(&change, clear, first));
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
  if (!sky || (!lighting->air_shadow && !view->sky_ray))
    return np_world_air(world, sky, view->eye, view->direction, distance_m);
  np_sky_ray own;
  if (!view->sky_ray) own = np_sky_ray_start(sky, view->direction);
  const np_sky_ray *ray = view->sky_ray ? view->sky_ray : &own;
  if (!lighting->air_shadow) return np_sky_ray_get_air(ray, distance_m, NULL);
  np_spectrum first;
  np_aerial_perspective air = np_sky_ray_get_air(ray, distance_m, &first);
  const np_air_change change = np_air_shadow_get(lighting->air_shadow, view, distance_m, end);
  air.inscatter = shade(&change, air.inscatter, first);
  for (int b = 0; b < NP_BAND_COUNT; b++) air.transmittance.band[b] *= 1.0f + change.passed.band[b];
  return air;
}

np_spectrum np_lighting_ground_irradiance(const np_lighting *lighting, const np_world *world,
                                          const np_ground_hit *hit) {
  if (lighting->relief_light) return np_relief_light_get(lighting->relief_light, hit);
  return np_relief_light_get_bare(world, lighting->ground_light, hit);
}

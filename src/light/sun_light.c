/* SPDX-License-Identifier: Apache-2.0 */
/* The sun at a point, clouds not counted: its disk, the air's transmittance, the shadow of planet and terrain. */
#include "core/stable.h"
#include "core/units.h"
#include "light/scene_view.h"

/* 1 − cos of the disk's angular radius, exact for a small one. */
static float disk_versine(const np_scene_view *view) {
  const float s = sinf(0.5f * view->sun_angular_radius_rad);
  return 2.0f * s * s;
}

float np_light_sun_solid_angle(const np_scene_view *view) { return 2.0f * NP_PI_F * disk_versine(view); }

bool np_light_sun_covers(const np_scene_view *view, np_vec3 direction) {
  const np_vec3 s = view->to_sun;
  return np_versine(s.x, s.y, s.z, direction.x, direction.y, direction.z) < disk_versine(view);
}

np_vec3 np_light_sample_sun(const np_scene_view *view, float u, float v) {
  const float versine = disk_versine(view) * u;
  const float sine = sqrtf(fmaxf(0.0f, versine * (2.0f - versine))), azimuth = 2.0f * NP_PI_F * v;
  np_vec3 tangent, bitangent;
  np_frame_around(view->to_sun, &tangent, &bitangent);
  np_vec3 direction = np_vec3_scale(view->to_sun, 1.0f - versine);
  direction = np_vec3_add(direction, np_vec3_scale(tangent, sine * cosf(azimuth)));
  direction = np_vec3_add(direction, np_vec3_scale(bitangent, sine * sinf(azimuth)));
  return np_vec3_normalize(direction);
}

/* Terrain can only stand in the way of what is below its summits or looks down. */
bool np_light_is_behind_terrain(const np_scene_view *view, np_dvec3 position, np_vec3 to_sun) {
  if (!view->terrain) return false;
  if (position.z > view->terrain_max.z && to_sun.z >= 0.0f) return false;
  return np_terrain_is_occluded(view->terrain, position, to_sun, INFINITY);
}

/* Whether the bare sphere hides a direction: only asked where no air softens its edge. */
static bool is_behind_planet(const np_scene_view *view, np_dvec3 position, np_vec3 direction) {
  const double radius = view->planet_radius_m, altitude = fmax(np_altitude(position, radius), 0.0);
  const double cosine = np_vec3_dot(np_zenith(position, radius), direction);
  return cosine < -sqrt(altitude * (2.0 * radius + altitude)) / (radius + altitude);
}

/* What is left of sunlight that `transmittance` of it comes through the air, where there is any. */
static np_spectrum pass_ground(const np_scene_view *view, np_dvec3 position, np_vec3 to_sun,
                               np_spectrum transmittance) {
  const np_spectrum irradiance = np_spectrum_multiply(view->sun_irradiance, transmittance), none = {{0}};
  if (np_spectrum_is_zero(irradiance)) return none;
  if (!view->atmosphere && view->has_planet && is_behind_planet(view, position, to_sun)) return none;
  return np_light_is_behind_terrain(view, position, to_sun) ? none : irradiance;
}

np_spectrum np_light_sun(const np_scene_view *view, np_dvec3 position, np_vec3 to_sun) {
  if (np_spectrum_is_zero(view->sun_irradiance)) return view->sun_irradiance;
  np_spectrum transmittance = np_spectrum_grey(1.0f);
  if (view->atmosphere)
    transmittance =
        np_atmosphere_transmittance_to_sun(view->atmosphere, position, to_sun, view->sun_angular_radius_rad);
  return pass_ground(view, position, to_sun, transmittance);
}

np_spectrum np_light_sun_ray(const np_scene_view *view, np_dvec3 position, np_vec3 to_sun) {
  if (np_spectrum_is_zero(view->sun_irradiance)) return view->sun_irradiance;
  np_spectrum transmittance = np_spectrum_grey(1.0f);
  if (view->atmosphere) transmittance = np_atmosphere_integrate_to_space(view->atmosphere, position, to_sun);
  return pass_ground(view, position, to_sun, transmittance);
}

np_spectrum np_light_disks(const np_scene_view *view, np_vec3 direction) {
  if (view->night && np_disk_covers(&view->night->moon, direction))
    return np_disk_radiance(&view->night->moon, direction);
  return np_disk_radiance(&view->disk, direction);
}

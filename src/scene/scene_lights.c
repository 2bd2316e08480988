/* SPDX-License-Identifier: Apache-2.0 */
/* Selection of the lights of the sky that matter.
 *
 * Illuminance of the ground by sun and clear sky as a function of the sun's elevation: Seidelmann 1992, "Explanatory
 * Supplement to the Astronomical Almanac", section 9.3, down to 18° below the horizon. The moon's is the sun's above
 * the atmosphere times the moon's ratio; the airglow's is a uniform sky of 22 magnitudes per square arc second, 1.7e-4
 * cd/m²; a star of magnitude 0 gives 2.54e-6 lx. */
#include "scene/scene_lights.h"

#include "atmosphere/celestial.h"
#include "atmosphere/moon.h"
#include "core/units.h"
#include "scene/scene_private.h"
#include "scene/scene_time.h"

static const double sun_lux_outside_air = 128000.0, airglow_lux = 5e-4, star_lux = 2.54e-6, brightest_star = -1.46;
static const double negligible = 1e-3, air_height_m = 8000.0;

/* Sun elevation at which its sky is dark; it fades out over the last degree. */
static const double sun_dark_deg = -19.0;

/* Moon elevation below which its light is negligible: 3e-5 of 0.3 lx for a full moon, 1/1000 of the airglow. */
static const double moon_dark_deg = -6.0;

static np_dvec3 make_direction(double elevation_rad, double azimuth_rad) {
  return np_dvec3_make(cos(elevation_rad) * sin(azimuth_rad), cos(elevation_rad) * cos(azimuth_rad),
                       sin(elevation_rad));
}

static np_dvec3 get_up(const neph_scene *scene) {
  const double *p = scene->camera.position_m;
  return np_dvec3_zenith(np_dvec3_make(p[0], p[1], p[2]), scene->atmosphere.planet_radius_m);
}

/* Elevation above the sphere's horizon, which lies lower for a higher camera. */
static double compute_height_deg(const neph_scene *scene, np_dvec3 direction) {
  const double radius = scene->atmosphere.planet_radius_m, *p = scene->camera.position_m;
  const double altitude = fmax(np_altitude(np_dvec3_make(p[0], p[1], p[2]), radius), 0.0);
  const double elevation = asin(np_clamp(np_dvec3_dot(get_up(scene), direction), -1.0, 1.0));
  return (elevation + atan2(sqrt(altitude * (2.0 * radius + altitude)), radius)) / NP_DEGREE;
}

static bool has_air(const neph_scene *scene) { return scene->has_atmosphere && scene->environment.has_planet; }

static double compute_sun_factor(const neph_scene *scene, np_dvec3 to_sun) {
  if (!has_air(scene)) return 1.0;
  const double t = np_clamp(compute_height_deg(scene, to_sun) - sun_dark_deg, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

np_scene_lights np_scene_lights_compute(const neph_scene *scene, double latitude_rad, double longitude_rad) {
  const double unix_s = np_scene_get_time(scene).unix_s;
  np_scene_lights l = {.to_sun = np_scene_get_sun_direction(scene, latitude_rad, longitude_rad)};
  l.sun_factor = compute_sun_factor(scene, l.to_sun);
  if (scene->moon.is_enabled) {
    l.moon = scene->moon.has_angles
                 ? np_moon_place_between(make_direction(scene->moon.elevation_rad, scene->moon.azimuth_rad), l.to_sun)
                 : np_celestial_moon(unix_s, latitude_rad, longitude_rad, false);
    l.moon_ratio = np_moon_irradiance_ratio(&l.moon, 550.0) * scene->moon.brightness;
  }
  if (scene->stars.is_enabled)
    l.turn = scene->stars.has_sidereal ? np_celestial_turn_by_angle(scene->stars.sidereal_rad, latitude_rad)
                                       : np_celestial_turn_by_time(unix_s, latitude_rad, longitude_rad);
  return l;
}

static double compute_sun_lux(double elevation_deg) {
  static const double degrees[] = {-18, -15, -12, -10, -8, -6, -4, -2, -0.8, 0, 5, 10, 15, 20, 30, 40, 60, 90};
  static const double lux[] = {6.5e-4, 1.3e-3, 8.3e-3, 4.6e-2, 0.45,  3.4,   28,    140,    450,
                               730,    4800,   10900,  18700,  27300, 47000, 66700, 102000, 124000};
  enum { COUNT = sizeof lux / sizeof *lux };
  if (elevation_deg <= degrees[0]) return elevation_deg < sun_dark_deg ? 0.0 : lux[0];
  int i = 0;
  while (i + 2 < COUNT && elevation_deg > degrees[i + 1]) i++;
  const double t = fmin((elevation_deg - degrees[i]) / (degrees[i + 1] - degrees[i]), 1.0);
  return lux[i] * pow(lux[i + 1] / lux[i], t);
}

/* Illuminance of the ground by sun and sky; 0 without air. */
static double compute_lux(const neph_scene *scene, double sun_height_deg) {
  const double *e = scene->sun.irradiance_w_m2_nm, default_at_550 = 1.8504;
  if (!has_air(scene)) return 0.0;
  return compute_sun_lux(sun_height_deg) * e[1] / default_at_550;
}

/* Luminance of the sky; it decreases with the air mass above the camera. */
static double compute_sky_luminance(const neph_scene *scene, double lux) {
  const double altitude = fmax(scene->camera.position_m[2], 0.0);
  return lux / NP_PI * exp(-altitude / air_height_m);
}

np_scene_light_levels np_scene_light_levels_compute(const neph_scene *scene, const np_scene_lights *lights,
                                                    double pixel_sr) {
  np_scene_light_levels g = {.sun_height_deg = compute_height_deg(scene, lights->to_sun)};
  g.is_sun_dark = has_air(scene) && lights->sun_factor <= 0.0;
  g.sun_lux = g.is_sun_dark ? 0.0 : compute_lux(scene, g.sun_height_deg);
  if (lights->moon_ratio > 0.0) {
    const double *e = scene->sun.irradiance_w_m2_nm, default_at_550 = 1.8504;
    g.moon_height_deg = compute_height_deg(scene, lights->moon.direction);
    g.moon_lux = sun_lux_outside_air * lights->moon_ratio * e[1] / default_at_550;
  }
  const bool is_set = g.moon_height_deg < (has_air(scene) ? moon_dark_deg : -0.3);
  const double sky = compute_sky_luminance(scene, g.sun_lux);
  g.is_moon_outshone = is_set || g.moon_lux <= negligible * g.sun_lux;
  g.is_airglow_outshone = airglow_lux * pow(10.0, -0.4 * (scene->airglow.magnitude - 22.0)) < negligible * sky * NP_PI;
  g.are_stars_outshone = star_lux * pow(10.0, -0.4 * brightest_star) < negligible * sky * pixel_sr;
  return g;
}

np_dvec3 np_scene_get_sun_direction(const neph_scene *scene, double latitude_rad, double longitude_rad) {
  np_sun_angles angles = {scene->sun.elevation_rad, scene->sun.azimuth_rad};
  if (scene->sun.time.is_given) angles = np_celestial_sun(np_scene_get_time(scene).unix_s, latitude_rad, longitude_rad);
  return make_direction(angles.elevation_rad, angles.azimuth_rad);
}

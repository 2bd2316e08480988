/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/light_warnings.h"

#include <stdio.h>

#include "core/text.h"
#include "core/units.h"
#include "scene/animation.h"
#include "scene/scene_fail.h"
#include "scene/scene_time.h"
#include "scene/sequence.h"
#include "stages/stores.h"

enum { SUN_SIZE = 120 };

static double get_elevation_deg(const np_scene_lights *lights) {
  return asin(np_clamp(lights->to_sun.z, -1.0, 1.0)) / NP_DEGREE;
}

static double get_azimuth_deg(const np_scene_lights *lights) {
  const double azimuth = atan2(lights->to_sun.x, lights->to_sun.y) / NP_DEGREE;
  return azimuth < 0.0 ? azimuth + 360.0 : azimuth;
}

/* "the sun is 17.5° below the horizon at azimuth 26.4°" */
static void describe_sun(const neph_scene *scene, const np_scene_lights *lights, char out[SUN_SIZE]) {
  const double elevation = get_elevation_deg(lights);
  char frame[32] = "";
  if (np_scene_is_sequence(scene)) np_print(frame, sizeof frame, "in frame %.6g ", scene->frame);
  np_print(out, SUN_SIZE, "%sthe sun is %.1f° %s the horizon at azimuth %.1f°", frame, fabs(elevation),
           elevation < 0.0 ? "below" : "above", get_azimuth_deg(lights));
}

/* ---- Times without a zone ---- */

/* The key of a time that was taken as UTC: sun.time, or its track. NULL: none was. */
static const np_node *search_time(const neph_scene *scene, bool has_zone) {
  const np_node *source = np_scene_get_source(scene), *animate = np_node_search(source, "animate");
  for (unsigned i = 0; animate && scene->animation && i < scene->animation->count; i++)
    if (scene->animation->tracks[i].lacks_zone) return np_node_search(animate, scene->animation->tracks[i].path);
  const np_node *sun = np_node_search(source, "sun");
  return scene->sun.time.is_given && !has_zone && sun ? np_node_search(sun, "time") : NULL;
}

/* Minutes of a day. */
static int compute_mean_solar_minute(double unix_s, double longitude_rad) {
  const double minutes = (unix_s + 86400.0 * longitude_rad / (2.0 * NP_PI)) / 60.0;
  return (int)(round(minutes) - 1440.0 * floor(round(minutes) / 1440.0));
}

static void warn_of_time(const neph_scene *scene, const np_node *node, const np_scene_lights *lights, double unix_s,
                         double longitude_rad) {
  char sun[SUN_SIZE];
  const double longitude = longitude_rad / NP_DEGREE, hours = round(longitude / 15.0);
  const int minute = compute_mean_solar_minute(unix_s, longitude_rad);
  const bool is_one = node->kind == NP_NODE_SCALAR;
  describe_sun(scene, lights, sun);
  np_scene_warn_key(scene, node,
                    "sun.time%s%s has no zone and is taken as UTC: %s, at %02d:%02d local mean solar time at %.1f° %c; "
                    "write Z behind it, an offset such as %+03.0f:00, or a space and the name of a time zone such as "
                    "America/New_York",
                    is_one ? " " : "", is_one ? node->text : "", sun, minute / 60, minute % 60, fabs(longitude),
                    longitude < 0.0 ? 'W' : 'E', hours);
}

/* ---- Nights ---- */

/* Below it the sky is darker than a lamp-lit room: civil twilight ends. */
static const double twilight_end_deg = -6.0;

static bool is_unlit_night(const neph_scene *scene, const np_plan *plan, const np_scene_lights *lights) {
  const double *sun = scene->sun.irradiance_w_m2_nm, *even = scene->environment.radiance_w_m2_sr_nm;
  bool has_light = scene->moon.is_enabled || scene->stars.is_enabled || scene->airglow.is_enabled ||
                   !scene->environment.has_planet || even[0] + even[1] + even[2] > 0.0;
  for (unsigned i = 0; i < scene->cloud_count; i++) has_light = has_light || scene->clouds[i].emission.is_enabled;
  const bool is_dark = get_elevation_deg(lights) < twilight_end_deg;
  return plan->request.has_beauty && !has_light && sun[0] + sun[1] + sun[2] > 0.0 && is_dark;
}

static void warn_of_night(const neph_scene *scene, const np_scene_lights *lights) {
  char sun[SUN_SIZE];
  describe_sun(scene, lights, sun);
  np_log(scene->context, NEPH_LOG_WARNING,
         "%s, and the scene has neither moon, stars nor airglow: only what is left of twilight lights it; add moon, "
         "stars or airglow, or set another sun.time, place or sun.elevation",
         sun);
}

/* ---- Once for a scene ---- */

enum { SLOT_TIME, SLOT_NIGHT };

static const char stage_of_warnings;

static void destroy_nothing(void *result) { (void)result; }

/* A logged warning leaves a result of this file among the results of the stages. */
static bool is_logged(const np_stores *stores, unsigned slot) {
  return np_stores_search(stores, &stage_of_warnings, slot);
}

static neph_result set_logged(neph_context *context, np_stores *stores, unsigned slot) {
  return np_stores_add(
      context, stores,
      (np_stored_result){.stage = &stage_of_warnings, .slot = slot, .result = stores, .destroy = destroy_nothing});
}

static neph_result log_time(const neph_scene *scene, np_stores *stores, const np_scene_lights *lights,
                            double longitude_rad) {
  const np_time time = np_scene_get_time(scene);
  const np_node *node = search_time(scene, time.has_zone);
  if (!node || is_logged(stores, SLOT_TIME)) return NEPH_OK;
  warn_of_time(scene, node, lights, time.unix_s, longitude_rad);
  return set_logged(scene->context, stores, SLOT_TIME);
}

static neph_result log_night(const neph_scene *scene, const np_plan *plan, np_stores *stores,
                             const np_scene_lights *lights) {
  if (is_logged(stores, SLOT_NIGHT) || !is_unlit_night(scene, plan, lights)) return NEPH_OK;
  warn_of_night(scene, lights);
  return set_logged(scene->context, stores, SLOT_NIGHT);
}

neph_result np_light_warnings_log(const neph_scene *scene, const np_plan *plan, np_stores *stores,
                                  const np_scene_lights *lights, double longitude_rad) {
  if (!lights) return NEPH_OK;
  neph_result result = log_time(scene, stores, lights, longitude_rad);
  return result ? result : log_night(scene, plan, stores, lights);
}

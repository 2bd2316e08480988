/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/sheets.h"

#include <math.h>

#include "cloud/cloud_kinds.h"
#include "cloud/presets.h"
#include "cloud/repeat_check.h"
#include "scene/cloud_places.h"
#include "scene/scene_node.h"

/* Limits of the range: a sheet at 10 km, 390 km away, is 1.5° below the horizon of the ground, and 2000 tiles are
 * listed in milliseconds. */
static const double range_max_m = 400e3, extents_max = 25.0;

/* Width of a tile in heights of its base, and in extents of its preset. */
static const double heights = 5.0, tiles_max = 4.0;

bool np_sheet_is_automatic(const np_scene_cloud *cloud) {
  return cloud->is_baked && cloud->bake_repeat == NP_BAKE_REPEAT_AUTO && cloud->preset &&
         np_cloud_preset_is_sheet(cloud->preset);
}

static const np_node *search_bake(const neph_scene *scene, const np_scene_cloud *cloud) {
  const np_node *list = np_node_search(scene->document, "clouds");
  return np_node_search(np_node_get(list, (size_t)(cloud - scene->clouds)), "bake");
}

/* Wind that moves a cloud while the shutter is open, or in motion vectors: copies stand still. */
static bool has_motion(const neph_scene *scene, const np_scene_cloud *cloud) {
  const double *wind = cloud->bake.wind_m_s;
  const bool is_shown = scene->motion_blur.is_enabled || scene->output.aovs & NP_AOV_MOTION;
  return is_shown && cloud->frame_time_s != 0.0 && (wind[0] != 0.0 || wind[1] != 0.0);
}

const char *np_sheet_search_obstacle(const neph_scene *scene, const np_scene_cloud *cloud) {
  if (!np_sheet_is_automatic(cloud)) return NULL;
  if (!scene->environment.has_planet) return "environment.planet is none";
  if (np_node_search(search_bake(scene, cloud), "extent")) return "bake.extent is given";
  if (cloud->vdb) return "vdb names a file of the field";
  if (cloud->level_count > 1) return "bake.levels are given";
  if (np_scene_cloud_search_move(cloud)) return "a key moves or copies it";
  if (has_motion(scene, cloud)) return "its motion is shown, and copies stand still";
  const char *obstacle = np_cloud_kind_get(cloud->bake.model)->repeat_obstacle;
  return obstacle ? "its model follows the ground, or stands once" : np_repeat_search_obstacle(&cloud->bake);
}

/* Distance along the sphere of the horizon of a height. */
static double get_horizon(const neph_scene *scene, double height_m) {
  return sqrt(2.0 * scene->atmosphere.planet_radius_m * fmax(height_m, 0.0));
}

/* A layer above the camera is seen over the ground's horizon to where it sinks below it, one below the camera to its
 * own horizon. Of a camera that climbs the highest place counts, so that light and tiles do not change from frame to
 * frame.
 */
static double get_range(const neph_scene *scene, const neph_cloud_desc *bake) {
  const double camera_m = scene->reach.camera_max_m[2], base_m = bake->base_altitude_m;
  const double own_m = camera_m < base_m ? get_horizon(scene, base_m) : 0.0;
  return fmin(fmin(own_m + get_horizon(scene, camera_m), range_max_m), extents_max * bake->extent_m[0]);
}

/* Whole number of the preset's extents that is nearest to five heights of the base, at most four of them: copies line
 * up below 11° above the horizon, where they are crowded, and not overhead. */
static double get_tile(const np_scene_cloud *cloud) {
  const double extent_m = np_cloud_preset_get_extent(cloud->preset);
  return extent_m * fmin(fmax(floor(heights * cloud->bake.base_altitude_m / extent_m + 0.5), 1.0), tiles_max);
}

static void set_extent(neph_cloud_desc *desc, double extent_m) {
  for (int a = 0; a < 2; a++) desc->extent_m[a] = extent_m;
}

static void derive(const neph_scene *scene, np_scene_cloud *cloud) {
  const bool has_extent = np_node_search(search_bake(scene, cloud), "extent");
  cloud->bake.repeat_m = 0.0;
  if (!np_sheet_is_automatic(cloud)) return;
  if (!has_extent) set_extent(&cloud->bake, np_cloud_preset_get_extent(cloud->preset));
  if (np_sheet_search_obstacle(scene, cloud)) return;
  set_extent(&cloud->bake, get_tile(cloud));
  cloud->bake.repeat_m = get_range(scene, &cloud->bake);
}

void np_sheets_derive(neph_scene *scene) {
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    np_scene_cloud *cloud = &scene->clouds[i];
    if (cloud->is_baked && cloud->bake_repeat != NP_BAKE_REPEAT_GIVEN) derive(scene, cloud);
  }
}

void np_sheet_set_alone(const np_scene_cloud *cloud, neph_cloud_desc *desc) {
  if (!np_sheet_is_automatic(cloud) || !(desc->repeat_m > 0.0)) return;
  set_extent(desc, np_cloud_preset_get_extent(cloud->preset));
  desc->repeat_m = 0.0;
}

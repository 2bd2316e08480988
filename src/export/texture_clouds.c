/* SPDX-License-Identifier: Apache-2.0 */
/* The baked clouds of a scene, one after another. */
#include "cloud/cloud_desc.h"
#include "core/alloc.h"
#include "export/texture_cloud.h"
#include "export/texture_makers.h"

static neph_result add_on_lattice(np_texture_cloud *cloud) {
  np_texture_set *set = cloud->set;
  neph_result result = NEPH_OK;
  if (!set->desc->is_dry_run && !(cloud->lattice.greatest > 0.0f)) return NEPH_OK;
  np_monitor_set_stage(set->monitor, "distance textures");
  result = np_texture_depth_add(cloud);
  return result ? result : np_texture_distance_add(cloud);
}

/* Adds all textures of a cloud. The lattice comes first, since the others are placed on it. */
static neph_result add_all(np_texture_cloud *cloud, np_monitor_part part) {
  np_texture_set *set = cloud->set;
  neph_result result = NEPH_OK;
  np_monitor_set_part(set->monitor, part, 0.0, 0.2);
  if (!set->desc->is_dry_run) result = np_texture_lattice_make(cloud);
  np_monitor_set_part(set->monitor, part, 0.2, 0.3);
  if (!result) result = add_on_lattice(cloud);
  np_monitor_set_part(set->monitor, part, 0.3, 0.8);
  np_monitor_set_stage(set->monitor, "weather map");
  if (!result) result = np_texture_weather_add(cloud);
  np_monitor_set_part(set->monitor, part, 0.8, 1.0);
  np_monitor_set_stage(set->monitor, "profile");
  return result ? result : np_texture_profile_add(cloud);
}

static neph_result add_cloud(np_texture_set *set, const np_texture_scene *of, unsigned index, np_monitor_part part) {
  np_texture_cloud cloud = {.set = set,
                            .scene = of->scene,
                            .cloud = &of->scene->clouds[index],
                            .bake_to_world = np_affine_identity(),
                            .extinction_factor = 1.0};
  neph_cloud_desc checked;
  neph_result result = np_cloud_in_frame_make(of->scene, index, of->frame, &cloud.in_frame);
  if (!result) result = np_cloud_desc_read(set->context, &cloud.in_frame.desc, &checked);
  if (!result) result = add_all(&cloud, part);
  np_alloc_free(set->context, cloud.lattice.extinction);
  np_cloud_in_frame_clear(&cloud.in_frame);
  return result;
}

/* Warns of textures that a cloud cannot have, unless the run is dry. */
static void warn(const np_texture_set *set, const np_scene_cloud *cloud) {
  if (set->desc->is_dry_run) return;
  if (cloud)
    np_log(set->context, NEPH_LOG_WARNING,
           "export: cloud %s is not baked: it has no weather map, profile, distances and optical depths", cloud->name);
  else
    np_log(set->context, NEPH_LOG_WARNING,
           "export: the scene has no cloud: no weather map, profile, distances and optical depths are written");
}

neph_result np_texture_clouds_add(np_texture_set *set, const np_texture_scene *of) {
  const neph_scene *scene = of->scene;
  const np_monitor_part whole = np_monitor_get_part(set->monitor);
  neph_result result = NEPH_OK;
  for (unsigned i = 0; i < scene->cloud_count && !result; i++) {
    const double share = (whole.end - whole.begin) / scene->cloud_count;
    if (scene->clouds[i].is_baked)
      result = add_cloud(set, of, i, (np_monitor_part){whole.begin + i * share, whole.begin + (i + 1) * share});
    else
      warn(set, &scene->clouds[i]);
  }
  if (!result && !scene->cloud_count) warn(set, NULL);
  return result;
}

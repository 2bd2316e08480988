/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_pose.h"

#include <string.h>

#include "core/alloc.h"
#include "scene/animation.h"
#include "scene/scene_eval.h"

np_cloud_pose np_cloud_pose_get(const np_scene_cloud *cloud) {
  np_cloud_pose pose = {
      .has_position = cloud->has_position, .rotation_rad = cloud->rotation_rad, .voxel_m = cloud->voxel_m};
  memcpy(pose.position_m, cloud->position_m, sizeof pose.position_m);
  memcpy(pose.tilt_rad, cloud->tilt_rad, sizeof pose.tilt_rad);
  memcpy(pose.scale, cloud->scale, sizeof pose.scale);
  memcpy(pose.pivot_point, cloud->pivot_point, sizeof pose.pivot_point);
  return pose;
}

static neph_result fill_pose(const neph_scene *scene, np_scene_pose *out) {
  *out = (np_scene_pose){.camera = scene->camera};
  out->clouds = np_alloc(scene->context, scene->cloud_count, sizeof *out->clouds);
  if (!out->clouds) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; i < scene->cloud_count; i++) out->clouds[i] = np_cloud_pose_get(&scene->clouds[i]);
  return NEPH_OK;
}

neph_result np_scene_pose_eval(const neph_scene *scene, double offset, np_scene_pose *out_pose) {
  if (!scene->animation || offset == 0.0) return fill_pose(scene, out_pose);
  *out_pose = (np_scene_pose){.clouds = NULL};
  neph_scene moved;
  neph_result result = np_scene_eval_exposure(scene, scene->frame + offset, scene->frame, &moved);
  if (!result) result = fill_pose(&moved, out_pose);
  np_scene_eval_clear(&moved);
  return result;
}

void np_scene_pose_clear(neph_context *context, np_scene_pose *pose) {
  np_alloc_free(context, pose->clouds);
  pose->clouds = NULL;
}

void np_scene_get_exposure(const neph_scene *scene, double *out_open, double *out_close) {
  const np_scene_motion_blur *blur = &scene->motion_blur;
  double shutter = blur->is_enabled ? blur->shutter : 0.0;
  if (isinf(shutter))
    shutter = scene->camera.has_shutter && scene->frame_rate > 0.0 ? scene->camera.shutter_s * scene->frame_rate : 0.5;
  const double middle = blur->is_enabled ? blur->offset : 0.0;
  *out_open = middle - 0.5 * shutter;
  *out_close = middle + 0.5 * shutter;
}

double np_scene_get_frame_s(const neph_scene *scene) {
  return 1.0 / (scene->frame_rate > 0.0 ? scene->frame_rate : 24.0);
}

static bool has_tracks(const neph_scene *scene, const char *const *paths, unsigned count) {
  for (unsigned i = 0; scene->animation && i < scene->animation->count; i++) {
    const np_track *track = &scene->animation->tracks[i];
    for (unsigned k = 0; k < count; k++)
      if (track->interpolation != NP_INTERPOLATION_STEP && !strcmp(track->key->path, paths[k])) return true;
  }
  return false;
}

bool np_scene_has_camera_tracks(const neph_scene *scene) {
  for (unsigned i = 0; scene->animation && i < scene->animation->count; i++) {
    const np_track *track = &scene->animation->tracks[i];
    if (track->interpolation != NP_INTERPOLATION_STEP && np_track_is_in(track, "camera.")) return true;
  }
  return false;
}

bool np_scene_has_cloud_tracks(const neph_scene *scene) {
  static const char *const paths[] = {"clouds[].position", "clouds[].rotation", "clouds[].tilt",
                                      "clouds[].scale",    "clouds[].voxel",    "clouds[].pivot"};
  return has_tracks(scene, paths, sizeof paths / sizeof *paths);
}

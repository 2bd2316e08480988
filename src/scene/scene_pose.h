/* SPDX-License-Identifier: Apache-2.0 */
/* Camera and cloud placements at a fractional frame, for the exposure of one frame. */
#ifndef NP_SCENE_SCENE_POSE_H
#define NP_SCENE_SCENE_POSE_H

#include "scene/scene_private.h"

typedef struct np_cloud_pose {
  bool has_position;
  double position_m[3], rotation_rad, tilt_rad[2], scale[3], voxel_m, pivot_point[3];
} np_cloud_pose;

typedef struct np_scene_pose {
  np_scene_camera camera;
  np_cloud_pose *clouds; /* one for each cloud of the scene, allocated */
} np_scene_pose;

np_cloud_pose np_cloud_pose_get(const np_scene_cloud *cloud);

/* Evaluates the pose at an offset in frames from the scene's frame. Step tracks keep the values of that frame. */
neph_result np_scene_pose_eval(const neph_scene *scene, double offset, np_scene_pose *out_pose);
void np_scene_pose_clear(neph_context *context, np_scene_pose *pose);

/* Begin and end of the exposure in frames, relative to the frame; both 0 without motion blur. */
void np_scene_get_exposure(const neph_scene *scene, double *out_open, double *out_close);

/* Duration of a frame: 1/24 s if the scene has no frame_rate. */
double np_scene_get_frame_s(const neph_scene *scene);

/* Whether tracks move the camera, or clouds. */
bool np_scene_has_camera_tracks(const neph_scene *scene);
bool np_scene_has_cloud_tracks(const neph_scene *scene);

#endif

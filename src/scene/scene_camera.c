/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_camera.h"

#include "core/math.h"
#include "core/units.h"

double np_scene_camera_get_target_m(const np_scene_camera *camera) {
  const double *p = camera->position_m, *q = camera->look_at_m;
  return np_dvec3_length(np_dvec3_make(p[0] - q[0], p[1] - q[1], p[2] - q[2]));
}

double np_scene_camera_get_fov_rad(const np_scene_camera *camera) {
  if (camera->has_focal_length) return 2.0 * atan(0.5 * camera->sensor_m / camera->focal_length_m);
  return camera->fov_rad;
}

double np_scene_camera_get_focal_length_m(const np_scene_camera *camera) {
  if (camera->has_focal_length) return camera->focal_length_m;
  return 0.5 * camera->sensor_m / tan(0.5 * camera->fov_rad);
}

double np_scene_camera_get_pixel_rad(const np_scene_camera *camera, unsigned width, unsigned height) {
  switch (camera->kind) {
  case NEPH_CAMERA_ORTHOGRAPHIC:
    return camera->orthographic_width_m / width / np_scene_camera_get_target_m(camera);
  case NEPH_CAMERA_EQUIRECTANGULAR:
    return 2.0 * NP_PI / width;
  case NEPH_CAMERA_FISHEYE:
    return camera->fisheye_fov_rad / (width < height ? width : height);
  case NEPH_CAMERA_PERSPECTIVE:
    break;
  }
  return 2.0 * tan(0.5 * np_scene_camera_get_fov_rad(camera)) / width;
}

bool np_scene_camera_get_ev100(const np_scene_camera *camera, double *out_ev) {
  if (!camera->has_lens || !camera->has_shutter || !camera->has_iso) return false;
  *out_ev = log2(camera->f_stop * camera->f_stop / camera->shutter_s * 100.0 / camera->iso);
  return true;
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_check_camera.h"

#include "core/units.h"

/* Node of a camera key; the camera's node if the key is not set, or NULL. */
static const np_node *locate(const neph_scene *scene, const char *key) {
  const np_node *camera = np_node_search(scene->document, "camera");
  const np_node *node = camera ? np_node_search(camera, key) : NULL;
  return node ? node : camera;
}

neph_result np_scene_check_view(const neph_scene *scene, np_scene_problems *problems) {
  const np_scene_camera *camera = &scene->camera;
  double distance = 0;
  for (int i = 0; i < 3; i++) distance = fmax(distance, fabs(camera->look_at_m[i] - camera->position_m[i]));
  if (distance >= 1e-3) return NEPH_OK;
  return np_scene_fail_at(problems, locate(scene, "look_at"),
                          "camera.look_at is camera.position, must be at least 1 mm away");
}

static neph_result check_angle(const neph_scene *scene, np_scene_problems *problems) {
  const np_scene_camera *camera = &scene->camera;
  const double fov_deg = np_scene_camera_get_fov_rad(camera) / NP_DEGREE;
  if (camera->kind != NEPH_CAMERA_PERSPECTIVE || fov_deg <= 170.0 + 1e-9) return NEPH_OK;
  return np_scene_fail_at(problems, locate(scene, "focal_length"),
                          "camera.focal_length is %.3g mm, must be at least %.3g mm on a sensor of %.3g mm, which is "
                          "170 deg: for more set camera.kind to fisheye",
                          1e3 * camera->focal_length_m, 1e3 * 0.5 * camera->sensor_m / tan(85.0 * NP_DEGREE),
                          1e3 * camera->sensor_m);
}

static neph_result check_clipping(const neph_scene *scene, np_scene_problems *problems) {
  const np_scene_camera *camera = &scene->camera;
  if (camera->near_m < camera->far_m) return NEPH_OK;
  return np_scene_fail_at(problems, locate(scene, "far"), "camera.far is %g m, must be above camera.near, %g m",
                          camera->far_m, camera->near_m);
}

/* Checks that the focus distance exceeds the focal length, as for any lens. */
static neph_result check_focus(const neph_scene *scene, np_scene_problems *problems) {
  const np_scene_camera *camera = &scene->camera;
  if (!camera->has_lens || camera->kind != NEPH_CAMERA_PERSPECTIVE) return NEPH_OK;
  const double focal_length = np_scene_camera_get_focal_length_m(camera);
  const bool is_auto = isinf(camera->focus_distance_m);
  const double focus = is_auto ? np_scene_camera_get_target_m(camera) : camera->focus_distance_m;
  if (focus > focal_length) return NEPH_OK;
  return np_scene_fail_at(problems, locate(scene, is_auto ? "look_at" : "focus_distance"),
                          "camera.%s is %.3g m away, must be farther than the focal length, %.3g m, to be in focus",
                          is_auto ? "look_at" : "focus_distance", focus, focal_length);
}

static neph_result check_stereo(const neph_scene *scene, np_scene_problems *problems) {
  if (!scene->camera.is_stereo || scene->camera.kind == NEPH_CAMERA_PERSPECTIVE) return NEPH_OK;
  return np_scene_fail_at(problems, locate(scene, "stereo"),
                          "camera.stereo goes with camera.kind perspective alone: leave one of them out");
}

neph_result np_scene_check_exposure(const neph_scene *scene, np_scene_problems *problems) {
  double ev100;
  if (scene->output.exposure != NEPH_EXPOSURE_CAMERA || np_scene_camera_get_ev100(&scene->camera, &ev100))
    return NEPH_OK;
  return np_scene_fail_at(problems, np_node_search(scene->document, "output"),
                          "output.exposure is camera, must come with camera.f_stop, shutter and iso");
}

neph_result np_scene_check_motion_blur(const neph_scene *scene, np_scene_problems *problems) {
  if (!scene->motion_blur.is_enabled || !scene->output.deep) return NEPH_OK;
  return np_scene_fail_at(problems, locate(scene, "motion_blur"),
                          "camera.motion_blur goes without output.deep, whose stretches of depth are of one moment: "
                          "leave one of them out, or blur by output.aovs: [motion]");
}

neph_result np_scene_check_camera(const neph_scene *scene, np_scene_problems *problems) {
  neph_result result = check_angle(scene, problems);
  if (np_scene_goes_on(problems, check_clipping(scene, problems), &result) &&
      np_scene_goes_on(problems, check_focus(scene, problems), &result))
    (void)np_scene_goes_on(problems, check_stereo(scene, problems), &result);
  return result;
}

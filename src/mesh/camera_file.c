/* SPDX-License-Identifier: Apache-2.0 */
#include "mesh/camera_file.h"

#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "mesh/assimp_module.h"

enum { FRAMES_MAX = 1000000, LIST_BYTES = 256 };

typedef struct camera_load {
  neph_context *context;
  const char *path, *name;
  double frame_rate;
  const np_assimp_module *module;
  np_assimp_scene *scene;
  size_t index; /* of the camera */
  np_assimp_camera camera;
} camera_load;

/* ---- Choice ---- */

static void list_names(const camera_load *l, char out[LIST_BYTES]) {
  out[0] = '\0';
  for (size_t i = 0; i < l->module->count_cameras(l->scene); i++) {
    np_assimp_camera camera;
    l->module->describe_camera(l->scene, i, &camera);
    const size_t used = strlen(out);
    (void)snprintf(out + used, LIST_BYTES - used, "%s%s", i ? ", " : "", camera.name);
  }
}

static neph_result choose_camera(camera_load *l) {
  const size_t count = l->module->count_cameras(l->scene);
  char names[LIST_BYTES];
  if (count == 0)
    return np_fail(l->context, NEPH_ERROR_BAD_FILE, "%s: no camera is in it, must have at least one", l->path);
  list_names(l, names);
  if (!l->name && count > 1)
    return np_fail(l->context, NEPH_ERROR_BAD_FILE, "%s: %zu cameras are in it: choose one by camera.motion.camera: %s",
                   l->path, count, names);
  for (l->index = 0; l->index < count; l->index++) {
    l->module->describe_camera(l->scene, l->index, &l->camera);
    if (!l->name || !strcmp(l->camera.name, l->name)) return NEPH_OK;
  }
  return np_fail(l->context, NEPH_ERROR_BAD_FILE, "%s: no camera %s is in it, must be one of %s", l->path, l->name,
                 names);
}

/* ---- Poses ---- */

static np_dvec3 take(const double v[3]) { return np_dvec3_make(v[0], v[1], v[2]); }

static bool is_finite(const np_camera_pose *p) {
  return isfinite(np_dvec3_length(p->at)) && isfinite(np_dvec3_length(p->forward)) && isfinite(np_dvec3_length(p->up));
}

static neph_result fill_pose(const camera_load *l, double frame, double seconds, np_camera_pose *out) {
  np_assimp_pose pose;
  const bool has_axes = l->module->get_pose(l->scene, l->index, seconds, &pose);
  if (has_axes) *out = (np_camera_pose){frame, take(pose.at), take(pose.forward), take(pose.up)};
  if (has_axes && is_finite(out)) return NEPH_OK;
  return np_fail(l->context, NEPH_ERROR_BAD_FILE,
                 "%s: camera %s has no direction at %.6g s: its scale is 0, or not finite", l->path, l->camera.name,
                 seconds);
}

static neph_result fill_poses(const camera_load *l, np_camera_file *out) {
  const bool is_moving = l->camera.end_s > l->camera.begin_s;
  if (is_moving && !(l->frame_rate > 0.0))
    return np_fail(l->context, NEPH_ERROR_BAD_SCENE,
                   "%s: camera %s moves by seconds: set frame_rate, so that frames are known", l->path, l->camera.name);
  const double rate = is_moving ? l->frame_rate : 1.0;
  /* A key that stands at a frame stays there: seconds are floats in a file. */
  const double first = is_moving ? floor(l->camera.begin_s * rate + 1e-3) : 0.0,
               last = is_moving ? ceil(l->camera.end_s * rate - 1e-3) : 0.0;
  if (!(last - first < FRAMES_MAX) || !(fabs(first) < FRAMES_MAX))
    return np_fail(l->context, NEPH_ERROR_BAD_FILE,
                   "%s: camera %s has keys from frame %.6g to %.6g, may have %d frames", l->path, l->camera.name, first,
                   last, (int)FRAMES_MAX);
  out->count = (size_t)(last - first) + 1;
  out->poses = np_alloc(l->context, out->count, sizeof *out->poses);
  if (!out->poses) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = NEPH_OK;
  for (size_t i = 0; i < out->count && !result; i++)
    result = fill_pose(l, first + (double)i, (first + (double)i) / rate, &out->poses[i]);
  return result;
}

static neph_result load_camera(camera_load *l, np_camera_file *out) {
  neph_result result = choose_camera(l);
  if (result) return result;
  out->vertical_fov_rad = l->camera.vertical_fov_rad;
  result = fill_poses(l, out);
  if (result) np_camera_file_clear(out);
  return result;
}

neph_result np_camera_file_load(neph_context *context, const char *path, const char *name, double frame_rate,
                                np_camera_file *out_file) {
  *out_file = (np_camera_file){.context = context};
  camera_load l = {.context = context, .path = path, .name = name, .frame_rate = frame_rate};
  neph_result result = np_assimp_module_open(context, path, &l.module, &l.scene);
  if (result) return result;
  result = load_camera(&l, out_file);
  l.module->close(l.scene);
  return result;
}

void np_camera_file_clear(np_camera_file *file) {
  np_alloc_free(file->context, file->poses);
  *file = (np_camera_file){.context = file->context};
}

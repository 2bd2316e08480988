/* SPDX-License-Identifier: Apache-2.0 */
#include "mesh/camera_file.h"

#include <inttypes.h>
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"
#include "mesh/assimp_process.h"

enum { FRAMES_MAX = 1000000 };

typedef struct camera_load {
  neph_context *context;
  const char *path, *name;
  double frame_rate;
  size_t index; /* index of the camera */
  np_assimp_camera camera;
} camera_load;

/* ---- Choice ---- */

typedef struct camera_list {
  uint64_t count;
  bool is_found; /* whether the requested camera is found */
  np_text names;
} camera_list;

static void list_camera(camera_load *l, size_t index, const np_assimp_camera *camera, camera_list *list) {
  np_text_add(&list->names, "%s%.*s", index ? ", " : "", (int)NP_ASSIMP_NAME_BYTES - 1, camera->name);
  if (list->is_found || (l->name && strcmp(camera->name, l->name))) return;
  list->is_found = true;
  l->index = index;
  l->camera = *camera;
}

static neph_result read_cameras(camera_load *l, camera_list *list) {
  np_assimp_process process;
  neph_result result = np_assimp_begin(l->context, l->path, (const char *[]){"cameras", NULL}, NULL, &process);
  if (result) return result;
  result = np_assimp_read(&process, &list->count, sizeof list->count);
  for (uint64_t i = 0; !result && i < list->count; i++) {
    np_assimp_camera camera;
    result = np_assimp_read(&process, &camera, sizeof camera);
    camera.name[NP_ASSIMP_NAME_BYTES - 1] = '\0';
    if (!result) list_camera(l, i, &camera, list);
  }
  np_assimp_end(&process);
  return result;
}

static neph_result check_choice(const camera_load *l, const camera_list *list) {
  if (list->count == 0)
    return np_fail(l->context, NEPH_ERROR_BAD_FILE, "%s: it has no camera, must have at least one", l->path);
  if (!l->name && list->count > 1)
    return np_fail(l->context, NEPH_ERROR_BAD_FILE,
                   "%s: %" PRIu64 " cameras are in it: choose one by camera.motion.camera: %s", l->path, list->count,
                   np_text_get(&list->names));
  if (list->is_found) return NEPH_OK;
  return np_fail(l->context, NEPH_ERROR_BAD_FILE, "%s: it has no camera %s, must be one of %s", l->path, l->name,
                 np_text_get(&list->names));
}

static neph_result choose_camera(camera_load *l) {
  camera_list list = {.names = {.context = l->context}};
  neph_result result = read_cameras(l, &list);
  if (!result && !list.names.has_failed) result = check_choice(l, &list);
  return np_text_end(&list.names, result);
}

/* ---- Poses ---- */

static np_dvec3 take(const double v[3]) { return np_dvec3_make(v[0], v[1], v[2]); }

static bool is_finite(const np_camera_pose *p) {
  return isfinite(np_dvec3_length(p->at)) && isfinite(np_dvec3_length(p->forward)) && isfinite(np_dvec3_length(p->up));
}

static neph_result read_pose(const camera_load *l, np_assimp_process *process, double frame, double seconds,
                             np_camera_pose *out) {
  np_assimp_pose pose;
  const neph_result result = np_assimp_read(process, &pose, sizeof pose);
  if (result) return result;
  *out = (np_camera_pose){frame, take(pose.at), take(pose.forward), take(pose.up)};
  if (is_finite(out) && np_dvec3_length(out->forward) > 0.0) return NEPH_OK;
  return np_fail(l->context, NEPH_ERROR_BAD_FILE,
                 "%s: camera %s has no direction at %.6g s: its scale is 0, or not finite", l->path, l->camera.name,
                 seconds);
}

static neph_result read_poses(const camera_load *l, double first, double rate, np_camera_file *out) {
  char words[4][32];
  np_assimp_process process;
  np_print(words[0], sizeof *words, "%zu", l->index);
  np_print(words[1], sizeof *words, "%.0f", first);
  np_print(words[2], sizeof *words, "%zu", out->count);
  np_print(words[3], sizeof *words, "%a", rate);
  const char *const request[] = {"poses", words[0], words[1], words[2], words[3], NULL};
  neph_result result = np_assimp_begin(l->context, l->path, request, NULL, &process);
  if (result) return result;
  for (size_t i = 0; i < out->count && !result; i++)
    result = read_pose(l, &process, first + (double)i, (first + (double)i) / rate, &out->poses[i]);
  np_assimp_end(&process);
  return result;
}

static neph_result fill_poses(const camera_load *l, np_camera_file *out) {
  const bool is_moving = l->camera.end_s > l->camera.begin_s;
  if (is_moving && !(l->frame_rate > 0.0))
    return np_fail(l->context, NEPH_ERROR_BAD_SCENE,
                   "%s: camera %s moves by seconds: set frame_rate, so that frames are known", l->path, l->camera.name);
  const double rate = is_moving ? l->frame_rate : 1.0;
  /* A key exactly at a frame stays there: seconds are floats in a file. */
  const double first = is_moving ? floor(l->camera.begin_s * rate + 1e-3) : 0.0,
               last = is_moving ? ceil(l->camera.end_s * rate - 1e-3) : 0.0;
  if (!(last - first < FRAMES_MAX) || !(fabs(first) < FRAMES_MAX))
    return np_fail(l->context, NEPH_ERROR_BAD_FILE,
                   "%s: camera %s has keys from frame %.6g to %.6g, may have %d frames", l->path, l->camera.name, first,
                   last, (int)FRAMES_MAX);
  out->count = (size_t)(last - first) + 1;
  out->poses = np_alloc(l->context, out->count, sizeof *out->poses);
  if (!out->poses) return NEPH_ERROR_OUT_OF_MEMORY;
  return read_poses(l, first, rate, out);
}

neph_result np_camera_file_load(neph_context *context, const char *path, const char *name, double frame_rate,
                                np_camera_file *out_file) {
  *out_file = (np_camera_file){.context = context};
  camera_load l = {.context = context, .path = path, .name = name, .frame_rate = frame_rate};
  neph_result result = choose_camera(&l);
  if (result) return result;
  out_file->vertical_fov_rad = l.camera.vertical_fov_rad;
  result = fill_poses(&l, out_file);
  if (result) np_camera_file_clear(out_file);
  return result;
}

void np_camera_file_clear(np_camera_file *file) {
  np_alloc_free(file->context, file->poses);
  *file = (np_camera_file){.context = file->context};
}

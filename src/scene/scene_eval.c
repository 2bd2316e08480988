/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_eval.h"

#include <string.h>

#include "cloud/cloud_desc.h"
#include "core/alloc.h"
#include "scene/cloud_map.h"
#include "scene/scene_derive.h"
#include "scene/scene_tracks.h"

/* ---- Copies ---- */

/* Copies a list; NULL if it is empty. */
static neph_result copy_list(neph_context *context, const void *list, size_t count, size_t size, void *out_pointer) {
  void *copy = count ? np_alloc(context, count, size) : NULL;
  if (count && !copy) return NEPH_ERROR_OUT_OF_MEMORY;
  if (count) memcpy(copy, list, count * size);
  memcpy(out_pointer, &copy, sizeof copy);
  return NEPH_OK;
}

/* Copies the lists that may differ between frames. On failure the lists that are not copied are empty. */
static neph_result copy_lists(const neph_scene *scene, neph_scene *out) {
  neph_context *context = scene->context;
  out->clouds = NULL;
  out->air.layers = NULL;
  out->layers = NULL;
  neph_result result = copy_list(context, scene->clouds, scene->cloud_count, sizeof *scene->clouds, &out->clouds);
  if (result) out->cloud_count = 0;
  for (unsigned i = 0; i < out->cloud_count; i++) {
    out->clouds[i].bake.map_file = NULL;
    out->clouds[i].bake.measurement = NULL;
  }
  if (!result)
    result = copy_list(context, scene->air.layers, scene->air.layer_count, sizeof *scene->air.layers, &out->air.layers);
  return result;
}

void np_scene_eval_clear(neph_scene *evaluated) {
  neph_context *context = evaluated->context;
  if (!context) return;
  for (unsigned i = 0; i < evaluated->cloud_count; i++) {
    np_scene_cloud *cloud = &evaluated->clouds[i];
    np_alloc_free(context, (void *)(uintptr_t)cloud->bake.map_file);
    np_cloud_map_source_clear(context, cloud);
    if (cloud->place != evaluated->base->clouds[i].place) np_alloc_free(context, cloud->place);
  }
  np_alloc_free(context, evaluated->clouds);
  np_alloc_free(context, evaluated->air.layers);
  np_alloc_free(context, evaluated->layers);
  *evaluated = (neph_scene){.context = NULL};
}

/* ---- Frames ---- */

/* Checks the range of a frame number: arithmetic on frames must not overflow an int. */
static neph_result check_frame(const neph_scene *scene, double frame) {
  static const double frame_max = 1e9;
  if (frame >= -frame_max && frame <= frame_max) return NEPH_OK;
  return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT, "frame is %.10g, must be in [%.0f, %.0f]", frame,
                 -frame_max, frame_max);
}

/* Fails if the camera file, which is read with the scene, is missing. The message names all missing files. */
static neph_result check_motion(const neph_scene *scene) {
  if (!scene->motion.file || scene->motion.is_read) return NEPH_OK;
  const neph_result result = neph_scene_check_files(scene);
  return result ? result
                : np_fail(scene->context, NEPH_ERROR_NOT_FOUND,
                          "camera.motion.file is %s, which was missing when the scene was read: read the scene again",
                          scene->motion.file);
}

neph_result np_scene_eval_exposure(const neph_scene *scene, double frame, double step_frame, neph_scene *out_scene) {
  *out_scene = (neph_scene){.context = NULL};
  neph_result result = check_frame(scene, frame);
  if (!result) result = check_motion(scene);
  if (result) return result;
  *out_scene = *scene;
  out_scene->base = scene;
  out_scene->frame = frame;
  result = copy_lists(scene, out_scene);
  if (!result) np_scene_write_tracks(out_scene, frame, step_frame);
  if (!result) result = np_scene_derive(out_scene);
  if (result) np_scene_eval_clear(out_scene);
  return result;
}

neph_result np_scene_eval(const neph_scene *scene, double frame, neph_scene *out_scene) {
  return np_scene_eval_exposure(scene, frame, frame, out_scene);
}

/* ---- Bakes ---- */

static neph_result check_bakes(const neph_scene *evaluated) {
  neph_result result = NEPH_OK;
  for (unsigned i = 0; i < evaluated->cloud_count && !result; i++) {
    neph_cloud_desc checked;
    if (evaluated->clouds[i].is_baked)
      result = np_cloud_desc_read(evaluated->context, &evaluated->clouds[i].bake, &checked);
  }
  return result == NEPH_ERROR_INVALID_ARGUMENT ? NEPH_ERROR_BAD_SCENE : result;
}

neph_result np_scene_eval_bakes(const neph_scene *scene, double frame, neph_scene *out_scene) {
  neph_result result = np_scene_eval(scene, frame, out_scene);
  if (!result) result = check_bakes(out_scene);
  if (result) np_scene_eval_clear(out_scene);
  return result;
}

/* ---- The scene itself ---- */

neph_result neph_scene_set_frame(neph_scene *scene, int frame) {
  if (!scene) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_scene evaluated;
  const neph_result result = np_scene_eval(scene, frame, &evaluated);
  if (result) return result;
  neph_scene before = *scene;
  *scene = evaluated;
  scene->base = NULL;
  before.base = scene;
  np_scene_eval_clear(&before);
  return NEPH_OK;
}

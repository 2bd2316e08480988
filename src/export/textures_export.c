/* SPDX-License-Identifier: Apache-2.0 */
/* The textures of a scene: a table of makers, called in order. */
#include <nephos/textures.h>

#include "core/given.h"
#include "export/texture_makers.h"
#include "scene/scene_eval.h"

/* A maker, and the end of its share of the call's progress. */
typedef struct maker {
  neph_result (*add)(np_texture_set *set, const np_texture_scene *of);
  double end;
} maker;

static const maker makers[] = {{np_texture_noise_add, 0.1}, {np_texture_sky_add, 0.3}, {np_texture_clouds_add, 1.0}};

static void describe_scene(np_texture_set *set, const np_texture_scene *of) {
  np_json *json = set->json;
  np_json_put_integer(json, "version", 1);
  np_json_put_text(json, "writer", "nephos");
  np_json_put_integer(json, "frame", of->frame);
  np_json_put_text(json, "file_format", set->desc->format == NEPH_TEXTURE_RAW ? "raw" : "ktx2");
  np_json_put_text(json, "layout",
                   "x fastest, then y, then z; channels interleaved; little-endian; quantity = value * scale; "
                   "ranges are of quantities; world: metres, z up");
  np_json_begin_array(json, "textures");
}

static neph_result add_all(np_texture_set *set, const np_texture_scene *of) {
  double begin = 0.0;
  neph_result result = np_texture_set_begin(set);
  if (!result) describe_scene(set, of);
  for (size_t i = 0; i < sizeof makers / sizeof *makers && !result; i++) {
    np_monitor_set_part(set->monitor, np_monitor_whole, begin, makers[i].end);
    result = makers[i].add(set, of);
    begin = makers[i].end;
  }
  if (result) return result;
  np_json_end(set->json);
  return np_texture_set_commit(set);
}

static neph_result check(neph_context *context, const neph_textures_desc *desc) {
  if (desc->size < NEPH_TEXTURE_SIZE_MIN || desc->size > NEPH_TEXTURE_SIZE_MAX)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "export: size is %u, must be in [%d, %d]", desc->size,
                   NEPH_TEXTURE_SIZE_MIN, NEPH_TEXTURE_SIZE_MAX);
  if (desc->format != NEPH_TEXTURE_KTX2 && desc->format != NEPH_TEXTURE_RAW)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "export: format is %d, must be KTX2 (0) or raw (1)",
                   (int)desc->format);
  return NEPH_OK;
}

neph_result neph_scene_export_textures(const neph_scene *scene, int frame, const neph_textures_desc *desc,
                                       const char *folder) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), folder)) return NEPH_ERROR_INVALID_ARGUMENT;
  static const neph_textures_desc defaults = NEPH_TEXTURES_DESC_DEFAULT;
  neph_textures_desc d;
  neph_scene at;
  np_monitor monitor;
  neph_result result = np_desc_read(scene->context, "neph_textures_desc", &defaults, sizeof d, desc, &d);
  if (!result) result = check(scene->context, &d);
  if (!result) result = np_scene_check(scene);
  if (!result) result = np_scene_eval_bakes(scene, frame, &at);
  if (result) return result;
  const unsigned mode = np_float_mode_enter();
  np_monitor_start(&monitor, scene->context, d.progress, d.progress_user);
  np_texture_set set = {.context = scene->context, .folder = folder, .desc = &d, .monitor = &monitor};
  result = add_all(&set, &(np_texture_scene){&at, frame});
  np_texture_set_end(&set);
  np_float_mode_leave(mode);
  np_scene_eval_clear(&at);
  return result;
}

/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "cloud/shape_desc.h"
#include "core/alloc.h"
#include "core/file.h"
#include "core/frame_name.h"
#include "core/given.h"
#include "scene/scene_apply.h"
#include "scene/scene_node.h"

/* Creates a scene that has only its document, of which it takes ownership. */
static neph_result create_bare(neph_context *context, const char *file, np_node *document, neph_scene **out_scene) {
  neph_scene *scene = document ? np_alloc(context, 1, sizeof *scene) : NULL;
  if (!scene) {
    np_node_destroy(context, document);
    return NEPH_ERROR_OUT_OF_MEMORY;
  }
  np_context_retain(context);
  scene->context = context;
  scene->document = document;
  scene->frame = 1.0;
  *out_scene = scene;
  if (!file) return NEPH_OK;
  scene->file = np_alloc_text(context, file);
  return scene->file ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* Completeness of a document. */
typedef enum document_kind {
  EMPTY, /* all keys are still to come */
  OPEN,  /* more keys may come: combinations of keys are checked only if a single key is wrong */
  WHOLE  /* complete */
} document_kind;

/* Fills a scene from its document; all errors of a file are logged together. */
static neph_result read_document(neph_scene *scene, document_kind kind) {
  np_scene_problems problems = {.context = scene->context, .file = scene->file};
  const neph_result result = np_scene_apply(scene, &problems);
  const bool is_checked = kind == WHOLE ? !result || result == NEPH_ERROR_BAD_SCENE : result == NEPH_ERROR_BAD_SCENE;
  if (kind != EMPTY && is_checked && scene->document->kind == NP_NODE_MAPPING) np_scene_check_all(scene, &problems);
  return np_scene_report(&problems, result);
}

static neph_result create_scene(neph_context *context, const char *file, np_node *document, document_kind kind,
                                neph_scene **out_scene) {
  *out_scene = NULL;
  neph_result result = create_bare(context, file, document, out_scene);
  if (!result) result = read_document(*out_scene, kind);
  if (!result) return NEPH_OK;
  neph_scene_destroy(*out_scene);
  *out_scene = NULL;
  return result;
}

static neph_result copy_text(neph_scene *scene, const char *text, size_t size) {
  scene->text = np_alloc(scene->context, size + 1, 1);
  if (!scene->text) return NEPH_ERROR_OUT_OF_MEMORY;
  memcpy(scene->text, text, size);
  scene->text_size = size;
  return NEPH_OK;
}

static neph_result load_bytes(neph_context *context, const char *text, size_t size, const char *name,
                              document_kind kind, neph_scene **out_scene) {
  np_node *document;
  neph_result result = np_scene_parse(context, text, size, name, false, &document);
  if (!result) result = create_scene(context, name, document, kind, out_scene);
  if (!result) result = copy_text(*out_scene, text, size);
  if (!result) return NEPH_OK;
  neph_scene_destroy(*out_scene);
  *out_scene = NULL;
  return result;
}

neph_result neph_scene_create(neph_context *context, neph_scene **out_scene) {
  if (NP_LACKS_OUT(context, out_scene)) return NEPH_ERROR_INVALID_ARGUMENT;
  np_node *document = np_node_create(context, NP_NODE_MAPPING, NULL, NULL);
  return create_scene(context, NULL, document, EMPTY, out_scene);
}

static neph_result load_file(neph_context *context, const char *path, document_kind kind, neph_scene **out_scene) {
  bool is_standard_input = !strcmp(path, "-");
  void *text;
  size_t size;
  *out_scene = NULL;
  neph_result result = np_file_read_any(context, is_standard_input ? "/dev/stdin" : path, &text, &size);
  if (result) return result;
  result = load_bytes(context, text, size, is_standard_input ? "standard input" : path, kind, out_scene);
  np_alloc_free(context, text);
  return result;
}

neph_result neph_scene_load(neph_context *context, const char *path, neph_scene **out_scene) {
  if (NP_LACKS_OUT(context, out_scene, path)) return NEPH_ERROR_INVALID_ARGUMENT;
  return load_file(context, path, WHOLE, out_scene);
}

neph_result neph_scene_open(neph_context *context, const char *path, neph_scene **out_scene) {
  if (NP_LACKS_OUT(context, out_scene, path)) return NEPH_ERROR_INVALID_ARGUMENT;
  return load_file(context, path, OPEN, out_scene);
}

neph_result neph_scene_load_text(neph_context *context, const char *text, const char *name, neph_scene **out_scene) {
  if (NP_LACKS_OUT(context, out_scene, text)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_scene = NULL;
  return load_bytes(context, text, strlen(text), name ? name : "scene", WHOLE, out_scene);
}

neph_result neph_scene_clone(const neph_scene *scene, neph_scene **out_scene) {
  if (NP_LACKS_OUT(NP_CONTEXT_OF(scene), out_scene)) return NEPH_ERROR_INVALID_ARGUMENT;
  np_scene_problems problems = {.context = scene->context, .file = scene->file, .is_first_only = true};
  np_node *document = np_node_copy(scene->context, np_scene_get_source(scene));
  *out_scene = NULL;
  neph_result result = create_bare(scene->context, scene->file, document, out_scene);
  if (!result) (*out_scene)->frame = scene->frame;
  if (!result && scene->text) result = copy_text(*out_scene, scene->text, scene->text_size);
  if (!result) result = np_scene_report(&problems, np_scene_apply(*out_scene, &problems));
  if (!result) return NEPH_OK;
  neph_scene_destroy(*out_scene);
  *out_scene = NULL;
  return result;
}

void np_scene_destroy_documents(neph_scene *scene) {
  np_node_destroy(scene->context, scene->document);
  np_node_destroy(scene->context, scene->source);
  np_animation_destroy(scene->context, scene->animation);
}

void neph_scene_destroy(neph_scene *scene) {
  if (!scene) return;
  neph_context *context = scene->context;
  np_scene_clear(scene);
  np_scene_destroy_documents(scene);
  np_alloc_free(context, scene->file);
  np_alloc_free(context, scene->text);
  np_alloc_free(context, scene);
  np_context_release(context);
}

bool neph_scene_is_animated(const neph_scene *scene) {
  return scene && ((scene->animation && scene->animation->count > 0) || scene->motion.file);
}

/* Size of the preview description in an older caller's struct. */
static size_t get_preview_size(const neph_output *output) {
  const size_t offset = offsetof(neph_output, preview_desc), size = sizeof output->preview_desc;
  return output->struct_size > offset && output->struct_size < offset + size ? output->struct_size - offset : size;
}

neph_result neph_scene_get_output(const neph_scene *scene, neph_output *out_output) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), out_output)) return NEPH_ERROR_INVALID_ARGUMENT;
  const np_scene_output *output = &scene->output;
  const neph_preview_desc preview = NEPH_PREVIEW_DESC_DEFAULT;
  neph_output wanted = {
      .struct_size = sizeof wanted,
      .image = output->image,
      .preview = output->preview,
      .deep = output->deep,
      .pixel_type = output->pixel_type,
      .has_beauty = output->has_beauty,
      .preview_desc = preview,
  };
  np_scene_get_white(scene, wanted.preview_desc.white);
  wanted.preview_desc.struct_size = get_preview_size(out_output);
  wanted.preview_desc.exposure_ev = output->exposure_ev;
  wanted.preview_desc.exposure = output->exposure;
  wanted.preview_desc.view = output->view;
  wanted.preview_desc.ocio_config = output->ocio_config;
  wanted.preview_desc.ocio_display = output->ocio_display;
  wanted.preview_desc.ocio_view = output->ocio_view;
  wanted.preview_desc.ocio_input = output->ocio_input;
  wanted.preview_desc.glare = output->glare;
  wanted.preview_desc.bits = output->preview_bits;
  wanted.preview_desc.pixel_type = output->pixel_type;
  return np_desc_write(scene->context, "neph_output", &wanted, sizeof wanted, out_output);
}

bool neph_scene_is_stereo(const neph_scene *scene) {
  return scene && scene->camera.is_stereo && scene->camera.eye == NEPH_EYE_CENTRE;
}

static neph_eye get_eye(const np_scene_camera *camera) {
  if (!camera->is_stereo) return NEPH_EYE_CENTRE;
  return camera->eye == NEPH_EYE_RIGHT ? NEPH_EYE_RIGHT : NEPH_EYE_LEFT;
}

neph_result neph_scene_get_render_desc(const neph_scene *scene, neph_render_desc *out_desc) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), out_desc)) return NEPH_ERROR_INVALID_ARGUMENT;
  const unsigned *resolution = scene->camera.resolution;
  const neph_render_desc desc = {
      .struct_size = sizeof desc,
      .integrator = scene->render.integrator,
      .width = resolution[0],
      .height = resolution[1],
      .crop_max = {resolution[0], resolution[1]},
      .sample_count = scene->render.sample_count,
      .sample_count_max = scene->render.sample_count_max,
      .target_error = scene->render.target_error,
      .time_limit_s = scene->render.time_limit_s,
      .seed = scene->render.seed,
      .frame = 1,
      .multiple_scattering = scene->render.multiple_scattering,
      .atmosphere = scene->render.atmosphere,
      .path_guiding = scene->render.path_guiding,
      .scattering_max = scene->render.scattering_max,
      .eye = get_eye(&scene->camera),
      .memory_max_bytes = NEPH_MEMORY_UNLIMITED,
      .tile_count = 1,
      .sample_end = NEPH_SAMPLES_ALL,
      .checkpoint_interval_s = NEPH_UNLIMITED,
  };
  return np_desc_write(scene->context, "neph_render_desc", &desc, sizeof desc, out_desc);
}

unsigned neph_scene_get_cloud_count(const neph_scene *scene) { return scene ? scene->cloud_count : 0; }

const char *neph_scene_get_cloud_name(const neph_scene *scene, unsigned index) {
  return scene && index < scene->cloud_count ? scene->clouds[index].name : NULL;
}

bool neph_scene_is_cloud_baked(const neph_scene *scene, unsigned index) {
  return scene && index < scene->cloud_count && scene->clouds[index].is_baked;
}

const char *neph_scene_get_cloud_file(const neph_scene *scene, unsigned index) {
  return scene && index < scene->cloud_count ? scene->clouds[index].vdb : NULL;
}

const char *neph_scene_get_cloud_map(const neph_scene *scene, unsigned index) {
  if (!neph_scene_is_cloud_baked(scene, index) || np_cloud_desc_has_shape(&scene->clouds[index].bake)) return NULL;
  return scene->clouds[index].map_image;
}

double np_scene_cloud_get_scale(const np_scene_cloud *cloud) {
  return fmax(fmax(fabs(cloud->scale[0]), fabs(cloud->scale[1])), fabs(cloud->scale[2]));
}

neph_cloud_desc np_scene_cloud_get_frame(const np_scene_cloud *cloud, int frame) {
  neph_cloud_desc desc = cloud->bake;
  desc.time_s += cloud->frame_time_s * (frame - 1.0);
  return desc;
}

bool neph_frame_is_numbered(const char *pattern) { return pattern && np_frame_name_is_pattern(pattern); }

neph_result neph_frame_get_path(neph_context *context, const char *pattern, int frame, char **out_path) {
  if (NP_LACKS_OUT(context, out_path, pattern)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_path = np_frame_name_make(context, pattern, frame);
  return *out_path ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Detection of finished frames: whether an existing file is the picture that a render would write. */
#include <string.h>

#include <nephos/parts.h>

#include "core/file.h"
#include "core/given.h"
#include "core/text.h"
#include "frame/render_header.h"
#include "image/image_private.h"
#include "parts/part_file.h"
#include "plan/plan.h"
#include "plan/scene_hash.h"
#include "scene/scene_eval.h"

static bool is_attribute(const neph_image *image, const char *name, const char *value) {
  const char *own = neph_image_get_attribute(image, name);
  return !strcmp(own ? own : "", value);
}

/* A picture that a time limit cut is finished as well: another run would do no better. */
static neph_result check_picture(const np_plan *plan, const char *path, bool *out_is_done) {
  const neph_render_desc *d = &plan->request.desc;
  np_image_exr_info info;
  neph_image *image = NULL;
  char tile[32] = "";
  neph_result result = np_image_read_exr_header(plan->request.context, path, &info, &image);
  if (result) return NEPH_OK; /* after a message; it is replaced */
  if (d->tile_count > 1) np_print(tile, sizeof tile, "%u/%u", d->tile_index + 1, d->tile_count);
  *out_is_done = is_attribute(image, NP_SCENE_HASH, plan->hash) && is_attribute(image, NP_HEADER_TILE, tile) &&
                 is_attribute(image, NP_HEADER_RANGE, "");
  neph_image_destroy(image);
  return NEPH_OK;
}

/* A file that is no part is replaced. */
static neph_result refuse_part(np_part_fault *fault, const char *path) {
  if (fault->result != NEPH_ERROR_OUT_OF_MEMORY)
    np_log(fault->context, NEPH_LOG_WARNING, "%s: %s: it is rendered again", path, np_part_fault_get_reason(fault));
  np_part_fault_clear(fault);
  return NEPH_OK;
}

static neph_result check_part(const np_plan *plan, const char *path, bool *out_is_done) {
  np_part_file *file;
  np_part_fault fault = {.context = plan->request.context};
  if (!np_part_file_open(plan->request.context, path, &fault, &file)) return refuse_part(&fault, path);
  const np_part_header *h = np_part_file_get_header(file);
  const np_part_grid grid = np_part_grid_make(h);
  *out_is_done = !strcmp(h->hash, plan->hash) && !memcmp(h->min, plan->request.window_min, sizeof h->min) &&
                 !memcmp(h->max, plan->request.window_max, sizeof h->max) &&
                 h->sample_begin == plan->request.desc.sample_begin && h->sample_end == plan->request.desc.sample_end &&
                 np_part_file_count_tiles(file) == np_part_grid_count(&grid);
  np_part_file_close(file);
  return NEPH_OK;
}

static neph_result check_file(const neph_scene *scene, np_plan *plan, np_input_store *store, const char *path,
                              bool *out_is_done) {
  neph_result result = np_plan_fit_memory(scene, plan, store);
  if (!result) result = np_plan_compute_hash(scene, plan);
  if (result || !*plan->hash) return result;
  return plan->request.desc.part_path ? check_part(plan, path, out_is_done) : check_picture(plan, path, out_is_done);
}

neph_result neph_render_is_done(const neph_scene *scene, const neph_render_desc *desc, const char *path,
                                bool *out_is_done) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), path, out_is_done)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_is_done = false;
  neph_scene at;
  np_plan plan;
  np_input_store store = {.references = NULL};
  neph_result result = np_plan_make_frame(scene, desc, &at, &plan);
  if (!result && np_file_exists(path)) result = check_file(&at, &plan, &store, path, out_is_done);
  np_input_store_clear(scene->context, &store);
  np_plan_clear(&plan);
  np_scene_eval_clear(&at);
  return result;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* The plan as text, and as JSON. */
#include "core/json.h"
#include "render/plan.h"
#include "render/stages.h"
#include "scene/scene_values.h"
#include "scene/text_builder.h"

static void add_references(np_text *text, const np_plan *plan) {
  if (plan->reference_count) np_text_add(text, "%-20s ", "reference frames");
  for (unsigned i = 0; i < plan->reference_count; i++) {
    const np_plan_reference *reference = &plan->references[i];
    np_text_add(text, "%s%s ", i ? ", " : "", reference->cloud);
    if (reference->is_known)
      np_text_add(text, "%d", reference->frame);
    else
      np_text_add(text, "none yet: no frame asked for holds anything");
  }
  if (plan->reference_count) np_text_add(text, "\n");
}

/* " 0.3 s, 12 MB"; of little memory nothing. */
static void add_cost(np_text *text, const np_stage_cost *cost) {
  np_text_add(text, cost->seconds < 10.0 ? " %.2g s" : " %.0f s", cost->seconds);
  if (cost->bytes >= 1e9)
    np_text_add(text, ", %.1f GB", cost->bytes * 1e-9);
  else if (cost->bytes >= 1e6)
    np_text_add(text, ", %.0f MB", cost->bytes * 1e-6);
}

static neph_result describe_plain(const np_plan *plan, char **out_text) {
  const neph_render_desc *desc = &plan->desc;
  const int *min = plan->window_min, *max = plan->window_max;
  np_text text = {.context = plan->context};
  np_text_add(&text, "%-20s %u x %u pixels, %d,%d to %d,%d of them, %u samples each, frame %d\n", "picture",
              desc->width, desc->height, min[0], min[1], max[0], max[1], desc->sample_count, desc->frame);
  np_text_add(&text, "%-20s %llu camera rays, film of %.3g MB", "work", (unsigned long long)plan->ray_count,
              (double)plan->film_bytes * 1e-6);
  if (plan->bake_voxel_count > 0) np_text_add(&text, ", at most %.3g voxels to bake", plan->bake_voxel_count);
  np_text_add(&text, "\n");
  add_references(&text, plan);
  const np_stage_cost all = np_stages_count_cost(plan);
  np_text_add(&text, "%-20s", "prediction");
  add_cost(&text, &all);
  np_text_add(&text, "; on two cores, within a factor of three\n");
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    const np_plan_stage *stage = &plan->stages[i];
    np_text_add(&text, "%-20s %-3s  %s", np_stage_get_row((np_stage)i)->name, stage->is_needed ? "yes" : "no",
                stage->reason);
    if (stage->cost.seconds >= 0.01) {
      np_text_add(&text, ";");
      add_cost(&text, &stage->cost);
    }
    np_text_add(&text, "\n");
  }
  return np_text_finish(&text, out_text);
}

static void put_picture(np_json *json, const np_plan *plan) {
  const neph_render_desc *desc = &plan->desc;
  np_json_begin_object(json, "picture");
  np_json_put_integer(json, "width", desc->width);
  np_json_put_integer(json, "height", desc->height);
  np_json_begin_array(json, "crop");
  for (int i = 0; i < 4; i++) np_json_put_integer(json, NULL, i < 2 ? plan->window_min[i] : plan->window_max[i - 2]);
  np_json_end(json);
  np_json_put_integer(json, "samples", desc->sample_count);
  np_json_put_integer(json, "frame", desc->frame);
  np_json_end(json);
}

static void put_references(np_json *json, const np_plan *plan) {
  np_json_begin_array(json, "reference_frames");
  for (unsigned i = 0; i < plan->reference_count; i++) {
    np_json_begin_object(json, NULL);
    np_json_put_text(json, "cloud", plan->references[i].cloud);
    if (plan->references[i].is_known) np_json_put_integer(json, "frame", plan->references[i].frame);
    np_json_end(json);
  }
  np_json_end(json);
}

/* Stages predicted to take next to nothing have no numbers. */
static void put_stage(np_json *json, const np_plan_stage *stage, const np_stage_row *row) {
  np_json_put_text(json, "stage", row->name);
  np_json_put_bool(json, "needed", stage->is_needed);
  np_json_put_text(json, "reason", stage->reason);
  if (stage->cost.seconds > 0.0) np_json_put_real(json, "seconds", stage->cost.seconds);
  if (stage->cost.bytes > 0.0) np_json_put_real(json, "bytes", stage->cost.bytes);
  if (stage->is_needed && row->reuse) np_json_put_text(json, "reused_while", row->reuse->reused_while);
}

static neph_result describe_json(const np_plan *plan, char **out_text) {
  np_json *json = np_json_create(plan->context);
  if (!json) return NEPH_ERROR_OUT_OF_MEMORY;
  put_picture(json, plan);
  np_json_put_integer(json, "wavelength_count", plan->wavelength_count);
  np_json_put_integer(json, "packet_count", plan->packet_count);
  np_json_put_text(json, "color_space", np_color_space_get_name(plan->color_space));
  np_json_put_integer(json, "ray_count", (int64_t)plan->ray_count);
  np_json_put_integer(json, "film_bytes", (int64_t)plan->film_bytes);
  np_json_put_real(json, "bake_voxel_count", plan->bake_voxel_count);
  if (plan->reference_count) put_references(json, plan);
  np_json_begin_array(json, "stages");
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    np_json_begin_object(json, NULL);
    put_stage(json, &plan->stages[i], np_stage_get_row((np_stage)i));
    np_json_end(json);
  }
  np_json_end(json);
  return np_json_finish(json, out_text);
}

neph_result np_plan_describe(const np_plan *plan, neph_text_format format, char **out_text) {
  *out_text = NULL;
  locale_t saved = np_values_enter();
  neph_result result = format == NEPH_TEXT_JSON ? describe_json(plan, out_text) : describe_plain(plan, out_text);
  np_values_leave(saved);
  return result;
}

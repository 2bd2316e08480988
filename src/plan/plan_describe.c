/* SPDX-License-Identifier: Apache-2.0 */
/* The plan as text, and as JSON. */
#include <math.h>
#include <string.h>

#include "core/json.h"
#include "core/text.h"
#include "plan/plan.h"
#include "plan/stage_rules.h"
#include "scene/scene_values.h"

static void add_references(np_text *text, const np_plan *plan) {
  if (plan->reference_count) np_text_add(text, "%-20s ", "reference frames");
  for (unsigned i = 0; i < plan->reference_count; i++) {
    const np_plan_reference *reference = &plan->references[i];
    np_text_add(text, "%s%s ", i ? ", " : "", reference->cloud);
    if (reference->is_known && isinf(reference->number))
      np_text_add(text, "all files");
    else if (reference->is_known)
      np_text_add(text, "%.10g", reference->number);
    else
      np_text_add(text, "none yet: no frame asked for holds anything");
  }
  if (plan->reference_count) np_text_add(text, "\n");
}

/* " 0.3 s, 12 MB, error 1.2 %"; of little memory and of no error nothing. */
static void add_cost(np_text *text, const np_stage_cost *cost, double error) {
  np_text_add(text, cost->seconds < 10.0 ? " %.2g s" : " %.0f s", cost->seconds);
  if (cost->bytes >= 1e9)
    np_text_add(text, ", %.1f GB", cost->bytes * 1e-9);
  else if (cost->bytes >= 1e6)
    np_text_add(text, ", %.0f MB", cost->bytes * 1e-6);
  if (error > 0.0) np_text_add(text, ", error %.2g %%", 100.0 * error);
}

/* Values of the numbers that trade error for time: those of the scene, of its quality, or of a choice of effort. */
typedef struct setting {
  const char *name;
  double value;
} setting;

enum { SETTINGS = 7 };

static void get_settings(const neph_scene *scene, setting out[SETTINGS]) {
  const np_scene_render *render = &scene->render;
  const setting settings[SETTINGS] = {{"tolerance", render->tolerance},
                                      {"detail", render->detail_px},
                                      {"light_detail", render->light_detail_px},
                                      {"light_depth", render->light_depth},
                                      {"light_degree", render->light_degree},
                                      {"light_residual", render->light_residual},
                                      {"table_tolerance", scene->atmosphere.tolerance}};
  memcpy(out, settings, sizeof settings);
}

static const char *get_quality(const neph_scene *scene) {
  static const char *const names[NP_QUALITY_COUNT] = {[NP_QUALITY_DRAFT] = "draft",
                                                      [NP_QUALITY_PREVIEW] = "preview",
                                                      [NP_QUALITY_FINAL] = "final",
                                                      [NP_QUALITY_REFERENCE] = "reference"};
  return names[scene->render.quality];
}

static const char *get_integrator(const np_plan *plan) {
  return plan->desc.integrator == NEPH_INTEGRATOR_PATH ? "path" : "march";
}

static void add_settings(np_text *text, const neph_scene *scene, const np_plan *plan) {
  setting settings[SETTINGS];
  get_settings(scene, settings);
  np_text_add(text, "%-20s quality %s, %s, %.3g samples", "settings", get_quality(scene), get_integrator(plan),
              plan->sample_mean);
  for (int i = 0; i < SETTINGS; i++) np_text_add(text, ", %s %.3g", settings[i].name, settings[i].value);
  np_text_add(text, "\n");
}

/* The whole picture: seconds of its threads, and of one core. */
static void add_prediction(np_text *text, const np_plan *plan, double peak_bytes) {
  const unsigned threads = neph_context_get_thread_count(plan->context);
  const np_stage_cost all = {np_stages_count_cost(plan).seconds, peak_bytes};
  np_text_add(text, "%-20s", "prediction");
  add_cost(text, &all, hypot(plan->bias, plan->noise));
  np_text_add(text, " (noise %.2g, bias %.2g); %.2g s on %u thread%s\n", 100.0 * plan->noise, 100.0 * plan->bias,
              np_plan_get_core_s(plan) * all.seconds, threads, threads == 1 ? "" : "s");
}

static neph_result add_reason(np_text *text, const neph_scene *scene, const np_plan *plan, np_stage stage) {
  const np_stage_rule *rule = np_stage_get_rule(stage);
  if (rule->describe && plan->stages[stage].is_needed) return rule->describe(plan, scene, text);
  np_text_add(text, "%s", plan->stages[stage].reason);
  return NEPH_OK;
}

static neph_result describe_plain(const neph_scene *scene, const np_plan *plan, double peak_bytes, char **out_text) {
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
  add_settings(&text, scene, plan);
  add_prediction(&text, plan, peak_bytes);
  neph_result result = NEPH_OK;
  for (int i = 0; i < NP_STAGE_COUNT && !result; i++) {
    const np_plan_stage *stage = &plan->stages[i];
    np_text_add(&text, "%-20s %-3s  ", np_stage_get_rule((np_stage)i)->name, stage->is_needed ? "yes" : "no");
    result = add_reason(&text, scene, plan, (np_stage)i);
    if (stage->cost.seconds >= 0.01 || stage->error > 0.0) {
      np_text_add(&text, ";");
      add_cost(&text, &stage->cost, stage->error);
    }
    np_text_add(&text, "\n");
  }
  return result ? np_text_end(&text, result) : np_text_finish(&text, out_text);
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

static void put_settings(np_json *json, const neph_scene *scene, const np_plan *plan) {
  setting settings[SETTINGS];
  get_settings(scene, settings);
  np_json_begin_object(json, "settings");
  np_json_put_text(json, "quality", get_quality(scene));
  np_json_put_text(json, "integrator", get_integrator(plan));
  np_json_put_real(json, "samples", plan->sample_mean);
  for (int i = 0; i < SETTINGS; i++) np_json_put_real(json, settings[i].name, settings[i].value);
  np_json_end(json);
}

/* Seconds are those of one core. */
static void put_prediction(np_json *json, const np_plan *plan, double peak_bytes) {
  np_json_begin_object(json, "prediction");
  np_json_put_real(json, "seconds", np_stages_count_cost(plan).seconds);
  np_json_put_real(json, "bytes", peak_bytes);
  np_json_put_real(json, "error", hypot(plan->bias, plan->noise));
  np_json_put_real(json, "noise", plan->noise);
  np_json_put_real(json, "bias", plan->bias);
  np_json_end(json);
}

/* The number of a file is whole, but between two frames. */
static void put_number(np_json *json, const char *key, double number) {
  if (number == floor(number))
    np_json_put_integer(json, key, (int64_t)number);
  else
    np_json_put_real(json, key, number);
}

static void put_references(np_json *json, const np_plan *plan) {
  np_json_begin_array(json, "reference_frames");
  for (unsigned i = 0; i < plan->reference_count; i++) {
    np_json_begin_object(json, NULL);
    np_json_put_text(json, "cloud", plan->references[i].cloud);
    if (plan->references[i].is_known && isinf(plan->references[i].number))
      np_json_put_text(json, "frame", "all");
    else if (plan->references[i].is_known)
      put_number(json, "frame", plan->references[i].number);
    np_json_end(json);
  }
  np_json_end(json);
}

/* Stages predicted to take next to nothing have no numbers. */
static void put_stage(np_json *json, const np_plan_stage *stage, const np_stage_rule *rule, const char *reason) {
  np_json_put_text(json, "stage", rule->name);
  np_json_put_bool(json, "needed", stage->is_needed);
  np_json_put_text(json, "reason", reason);
  if (stage->cost.seconds > 0.0) np_json_put_real(json, "seconds", stage->cost.seconds);
  if (stage->cost.bytes > 0.0) np_json_put_real(json, "bytes", stage->cost.bytes);
  if (stage->error > 0.0) np_json_put_real(json, "error", stage->error);
  if (stage->is_needed && rule->reused_while) np_json_put_text(json, "reused_while", rule->reused_while);
}

static neph_result put_stages(np_json *json, const neph_scene *scene, const np_plan *plan) {
  neph_result result = NEPH_OK;
  np_json_begin_array(json, "stages");
  for (int i = 0; i < NP_STAGE_COUNT && !result; i++) {
    np_text reason = {.context = plan->context};
    result = add_reason(&reason, scene, plan, (np_stage)i);
    np_json_begin_object(json, NULL);
    put_stage(json, &plan->stages[i], np_stage_get_rule((np_stage)i), np_text_get(&reason));
    np_json_end(json);
    result = np_text_end(&reason, result);
  }
  np_json_end(json);
  return result;
}

static neph_result describe_json(const neph_scene *scene, const np_plan *plan, double peak_bytes, char **out_text) {
  np_json *json = np_json_create(plan->context);
  if (!json) return NEPH_ERROR_OUT_OF_MEMORY;
  put_picture(json, plan);
  np_json_put_integer(json, "wavelength_count", plan->wavelength_count);
  np_json_put_integer(json, "packet_count", plan->packet_count);
  np_json_put_text(json, "color_space", np_color_space_get_name(plan->color_space));
  np_json_put_integer(json, "ray_count", (int64_t)plan->ray_count);
  np_json_put_integer(json, "film_bytes", (int64_t)plan->film_bytes);
  np_json_put_real(json, "bake_voxel_count", plan->bake_voxel_count);
  put_settings(json, scene, plan);
  put_prediction(json, plan, peak_bytes);
  if (plan->reference_count) put_references(json, plan);
  const neph_result result = put_stages(json, scene, plan);
  if (!result) return np_json_finish(json, out_text);
  np_json_destroy(json);
  return result;
}

neph_result np_plan_describe(const neph_scene *scene, const np_plan *plan, neph_text_format format, char **out_text) {
  double peak_bytes;
  *out_text = NULL;
  neph_result result = np_plan_predict_memory(scene, plan, &peak_bytes);
  if (result) return result;
  locale_t saved = np_values_enter();
  result = (format == NEPH_TEXT_JSON ? describe_json : describe_plain)(scene, plan, peak_bytes, out_text);
  np_values_leave(saved);
  return result;
}

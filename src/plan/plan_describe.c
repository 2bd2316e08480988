/* SPDX-License-Identifier: Apache-2.0 */
/* The plan as text, and as JSON. */
#include <math.h>
#include <string.h>

#include "core/json.h"
#include "core/text.h"
#include "plan/plan.h"
#include "plan/stage_rules.h"
#include "scene/scene_values.h"

/* A plan, and further facts for its text. */
typedef struct description {
  const neph_scene *scene;
  const np_plan *plan;
  const np_input_store *store;
  double peak_bytes;
} description;

/* ---- Reference frames ---- */

/* The reference frame of a sequence. */
typedef struct reference_frame {
  const char *cloud; /* borrowed from the scene */
  bool is_known;     /* false: all frames so far are empty */
  double number;     /* infinite: all files of the sequence */
} reference_frame;

typedef struct reference_list {
  unsigned count;
  reference_frame at[NP_INSTANCES_MAX];
} reference_list;

static neph_result list_references(const description *d, reference_list *out) {
  neph_result result = NEPH_OK;
  out->count = 0;
  for (unsigned i = 0; i < d->scene->cloud_count && !result; i++) {
    const np_scene_cloud *cloud = &d->scene->clouds[i];
    const np_reference *reference;
    result = np_references_search(d->store, d->scene, i, &reference);
    if (result || !reference) continue;
    reference_frame *frame = &out->at[out->count++];
    frame->cloud = cloud->name;
    frame->is_known = np_reference_get_number(cloud, reference, &frame->number);
  }
  return result;
}

static neph_result add_references(np_text *text, const description *d) {
  reference_list list;
  const neph_result result = list_references(d, &list);
  if (list.count) np_text_add(text, "%-20s ", "reference frames");
  for (unsigned i = 0; i < list.count; i++) {
    const reference_frame *frame = &list.at[i];
    np_text_add(text, "%s%s ", i ? ", " : "", frame->cloud);
    if (frame->is_known && isinf(frame->number))
      np_text_add(text, "all files");
    else if (frame->is_known)
      np_text_add(text, "%.10g", frame->number);
    else
      np_text_add(text, "none yet: no frame asked for holds anything");
  }
  if (list.count) np_text_add(text, "\n");
  return result;
}

/* ---- Parts of the text ---- */

/* Adds " 0.3 s, 12 MB, error 1.2 %", without a negligible memory or error. */
static void add_cost(np_text *text, const np_stage_cost *cost, double error) {
  np_text_add(text, cost->seconds < 10.0 ? " %.2g s" : " %.0f s", cost->seconds);
  if (cost->bytes >= 1e9)
    np_text_add(text, ", %.1f GB", cost->bytes * 1e-9);
  else if (cost->bytes >= 1e6)
    np_text_add(text, ", %.0f MB", cost->bytes * 1e-6);
  if (error > 0.0) np_text_add(text, ", error %.2g %%", 100.0 * error);
}

/* Settings that trade error for time, by the scene, its quality, or a choice of effort. */
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

static const char *get_integrator(const np_plan *plan) { return np_request_is_path(&plan->request) ? "path" : "march"; }

static void add_settings(np_text *text, const neph_scene *scene, const np_plan *plan) {
  setting settings[SETTINGS];
  get_settings(scene, settings);
  np_text_add(text, "%-20s quality %s, %s, %.3g samples", "settings", get_quality(scene), get_integrator(plan),
              plan->forecast.sample_mean);
  for (int i = 0; i < SETTINGS; i++) np_text_add(text, ", %s %.3g", settings[i].name, settings[i].value);
  np_text_add(text, "\n");
}

/* The whole picture: seconds of its threads, and of one core. */
static void add_prediction(np_text *text, const np_plan *plan, double peak_bytes) {
  const unsigned threads = neph_context_get_thread_count(plan->request.context);
  const np_stage_cost all = {np_forecast_sum(&plan->forecast).seconds, peak_bytes};
  np_text_add(text, "%-20s", "prediction");
  add_cost(text, &all, hypot(plan->forecast.bias, plan->forecast.noise));
  np_text_add(text, " (noise %.2g, bias %.2g); %.2g s on %u thread%s\n", 100.0 * plan->forecast.noise,
              100.0 * plan->forecast.bias, np_plan_get_core_s(plan) * all.seconds, threads, threads == 1 ? "" : "s");
}

static neph_result add_reason(np_text *text, const neph_scene *scene, const np_plan *plan, np_stage stage) {
  const np_stage_rule *rule = np_stage_get_rule(stage);
  if (rule->describe && np_plan_needs(plan, stage)) return rule->describe(plan, scene, text);
  np_text_add(text, "%s", plan->decisions.stages[stage].reason);
  return NEPH_OK;
}

static neph_result add_stage(np_text *text, const description *d, np_stage stage) {
  const np_stage_forecast *forecast = &d->plan->forecast.stages[stage];
  np_text_add(text, "%-20s %-3s  ", np_stage_get_rule(stage)->name, np_plan_needs(d->plan, stage) ? "yes" : "no");
  const neph_result result = add_reason(text, d->scene, d->plan, stage);
  if (forecast->cost.seconds >= 0.01 || forecast->error > 0.0) {
    np_text_add(text, ";");
    add_cost(text, &forecast->cost, forecast->error);
  }
  np_text_add(text, "\n");
  return result;
}

static neph_result describe_plain(const description *d, char **out_text) {
  const np_request *r = &d->plan->request;
  const neph_render_desc *desc = &r->desc;
  const int *min = r->window_min, *max = r->window_max;
  np_text text = {.context = r->context};
  np_text_add(&text, "%-20s %u x %u pixels, %d,%d to %d,%d of them, %u samples each, frame %d\n", "picture",
              desc->width, desc->height, min[0], min[1], max[0], max[1], desc->sample_count, desc->frame);
  np_text_add(&text, "%-20s %llu camera rays, film of %.3g MB", "work", (unsigned long long)r->ray_count,
              (double)r->film_bytes * 1e-6);
  const double baked = d->plan->inputs.voxels.baked_box;
  if (baked > 0) np_text_add(&text, ", at most %.3g voxels to bake", baked);
  np_text_add(&text, "\n");
  neph_result result = add_references(&text, d);
  add_settings(&text, d->scene, d->plan);
  add_prediction(&text, d->plan, d->peak_bytes);
  for (int i = 0; i < NP_STAGE_COUNT && !result; i++) result = add_stage(&text, d, (np_stage)i);
  return result ? np_text_end(&text, result) : np_text_finish(&text, out_text);
}

static void put_picture(np_json *json, const np_request *request) {
  const neph_render_desc *desc = &request->desc;
  np_json_begin_object(json, "picture");
  np_json_put_integer(json, "width", desc->width);
  np_json_put_integer(json, "height", desc->height);
  np_json_begin_array(json, "crop");
  for (int i = 0; i < 4; i++)
    np_json_put_integer(json, NULL, i < 2 ? request->window_min[i] : request->window_max[i - 2]);
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
  np_json_put_real(json, "samples", plan->forecast.sample_mean);
  for (int i = 0; i < SETTINGS; i++) np_json_put_real(json, settings[i].name, settings[i].value);
  np_json_end(json);
}

/* Seconds are times of one core. */
static void put_prediction(np_json *json, const np_plan *plan, double peak_bytes) {
  np_json_begin_object(json, "prediction");
  np_json_put_real(json, "seconds", np_forecast_sum(&plan->forecast).seconds);
  np_json_put_real(json, "bytes", peak_bytes);
  np_json_put_real(json, "error", hypot(plan->forecast.bias, plan->forecast.noise));
  np_json_put_real(json, "noise", plan->forecast.noise);
  np_json_put_real(json, "bias", plan->forecast.bias);
  np_json_end(json);
}

/* The number of a file is whole, but between two frames. */
static void put_number(np_json *json, const char *key, double number) {
  if (number == floor(number))
    np_json_put_integer(json, key, (int64_t)number);
  else
    np_json_put_real(json, key, number);
}

static neph_result put_references(np_json *json, const description *d) {
  reference_list list;
  const neph_result result = list_references(d, &list);
  if (list.count) np_json_begin_array(json, "reference_frames");
  for (unsigned i = 0; i < list.count; i++) {
    np_json_begin_object(json, NULL);
    np_json_put_text(json, "cloud", list.at[i].cloud);
    if (list.at[i].is_known && isinf(list.at[i].number))
      np_json_put_text(json, "frame", "all");
    else if (list.at[i].is_known)
      put_number(json, "frame", list.at[i].number);
    np_json_end(json);
  }
  if (list.count) np_json_end(json);
  return result;
}

/* Writes the units of work whose count is not 0, by name. */
static void put_units(np_json *json, const np_cost_counts *counts) {
  bool has_any = false;
  for (int u = 0; u < NP_UNIT_COUNT; u++) has_any = has_any || counts->of[u] > 0.0;
  if (!has_any) return;
  np_json_begin_object(json, "units");
  for (int u = 0; u < NP_UNIT_COUNT; u++)
    if (counts->of[u] > 0.0) np_json_put_real(json, np_cost_unit_get_name((np_cost_unit)u), counts->of[u]);
  np_json_end(json);
}

/* Writes a stage; without numbers if its predicted cost is negligible. */
static neph_result put_stage(np_json *json, const description *d, np_stage stage) {
  const np_stage_rule *rule = np_stage_get_rule(stage);
  const np_stage_forecast *forecast = &d->plan->forecast.stages[stage];
  const bool is_needed = np_plan_needs(d->plan, stage);
  np_text reason = {.context = d->plan->request.context};
  const neph_result result = add_reason(&reason, d->scene, d->plan, stage);
  np_json_begin_object(json, NULL);
  np_json_put_text(json, "stage", rule->name);
  np_json_put_bool(json, "needed", is_needed);
  np_json_put_text(json, "reason", np_text_get(&reason));
  if (forecast->cost.seconds > 0.0) np_json_put_real(json, "seconds", forecast->cost.seconds);
  if (forecast->cost.bytes > 0.0) np_json_put_real(json, "bytes", forecast->cost.bytes);
  if (forecast->error > 0.0) np_json_put_real(json, "error", forecast->error);
  put_units(json, &forecast->counts);
  if (is_needed && rule->reused_while) np_json_put_text(json, "reused_while", rule->reused_while);
  np_json_end(json);
  return np_text_end(&reason, result);
}

static neph_result put_stages(np_json *json, const description *d) {
  neph_result result = NEPH_OK;
  np_json_begin_array(json, "stages");
  for (int i = 0; i < NP_STAGE_COUNT && !result; i++) result = put_stage(json, d, (np_stage)i);
  np_json_end(json);
  return result;
}

static neph_result describe_json(const description *d, char **out_text) {
  const np_plan *plan = d->plan;
  np_json *json = np_json_create(plan->request.context);
  if (!json) return NEPH_ERROR_OUT_OF_MEMORY;
  put_picture(json, &plan->request);
  np_json_put_integer(json, "wavelength_count", plan->decisions.wavelength_count);
  np_json_put_integer(json, "packet_count", plan->decisions.packet_count);
  np_json_put_text(json, "color_space", np_color_space_get_name(plan->decisions.color_space));
  np_json_put_integer(json, "ray_count", (int64_t)plan->request.ray_count);
  np_json_put_integer(json, "film_bytes", (int64_t)plan->request.film_bytes);
  np_json_put_real(json, "bake_voxel_count", plan->inputs.voxels.baked_box);
  put_settings(json, d->scene, plan);
  put_prediction(json, plan, d->peak_bytes);
  put_units(json, &plan->forecast.program);
  neph_result result = put_references(json, d);
  if (!result) result = put_stages(json, d);
  if (!result) return np_json_finish(json, out_text);
  np_json_destroy(json);
  return result;
}

neph_result np_plan_describe(const neph_scene *scene, const np_plan *plan, const np_input_store *store,
                             neph_text_format format, char **out_text) {
  description d = {.scene = scene, .plan = plan, .store = store, .peak_bytes = np_plan_predict_memory(plan)};
  *out_text = NULL;
  locale_t saved = np_values_enter();
  const neph_result result = (format == NEPH_TEXT_JSON ? describe_json : describe_plain)(&d, out_text);
  np_values_leave(saved);
  return result;
}

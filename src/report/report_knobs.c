/* SPDX-License-Identifier: Apache-2.0 */
#include "report/report_knobs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/text.h"
#include "plan/stage_decisions.h"

/* ---- The scene's own values ---- */

/* The coarsest of the bakes. */
static double get_bake_voxel_m(const neph_scene *scene) {
  double voxel_m = 0.0;
  for (unsigned i = 0; i < scene->cloud_count; i++)
    if (scene->clouds[i].is_baked) voxel_m = fmax(voxel_m, scene->clouds[i].bake.voxel_m);
  return voxel_m;
}

/* Whether some cloud has float precision; one precision for all clouds is compared. */
static bool has_float(const neph_scene *scene) {
  for (unsigned i = 0; i < scene->cloud_count; i++)
    if (scene->clouds[i].precision == NEPH_PRECISION_FLOAT) return true;
  return false;
}

static double get_samples(const neph_scene *scene, const np_plan *plan) {
  return (void)plan, scene->render.sample_count;
}
static double get_tolerance(const neph_scene *scene, const np_plan *plan) {
  return (void)plan, scene->render.tolerance;
}
static double get_light_depth(const neph_scene *scene, const np_plan *plan) {
  return (void)plan, scene->render.light_depth;
}
static double get_light_residual(const neph_scene *scene, const np_plan *plan) {
  return (void)plan, scene->render.light_residual;
}
static const char *get_light_degree(const neph_scene *scene, const np_plan *plan) {
  return (void)plan, scene->render.light_degree == 3 ? "3" : scene->render.light_degree == 7 ? "7" : "11";
}
static const char *get_detail(const neph_scene *scene, const np_plan *plan) {
  static const char *const words[] = {"0", "1", "2", "4"};
  (void)plan;
  for (size_t i = 0; i < sizeof words / sizeof *words; i++)
    if (scene->render.detail_px == strtod(words[i], NULL)) return words[i];
  return "the scene's";
}
static const char *get_quality(const neph_scene *scene, const np_plan *plan) {
  static const char *const names[] = {[NP_QUALITY_DRAFT] = "draft",
                                      [NP_QUALITY_PREVIEW] = "preview",
                                      [NP_QUALITY_FINAL] = "final",
                                      [NP_QUALITY_REFERENCE] = "reference"};
  return (void)plan, names[scene->render.quality];
}
static double get_table_tolerance(const neph_scene *scene, const np_plan *plan) {
  return (void)plan, scene->atmosphere.tolerance;
}
static double get_voxel(const neph_scene *scene, const np_plan *plan) { return (void)plan, get_bake_voxel_m(scene); }
static const char *get_method(const neph_scene *scene, const np_plan *plan) {
  return (void)scene, np_multiple_scattering_get_row(plan->request.desc.multiple_scattering)->name;
}
static const char *get_sun_optical_depth(const neph_scene *scene, const np_plan *plan) {
  return (void)scene, np_plan_needs(plan, NP_STAGE_SUN_OPTICAL_DEPTH) ? "volume" : "march";
}
static const char *get_precision(const neph_scene *scene, const np_plan *plan) {
  return (void)plan, has_float(scene) ? "float" : "half";
}
static const char *get_air_shadows(const neph_scene *scene, const np_plan *plan) {
  return (void)scene, np_plan_needs(plan, NP_STAGE_AIR_SHADOWS) ? "true" : "false";
}
static const char *get_guiding(const neph_scene *scene, const np_plan *plan) {
  return (void)scene, plan->request.desc.path_guiding == NEPH_PATH_GUIDING_ADJOINT ? "adjoint" : "none";
}
static bool has_bake(const neph_scene *scene, const np_plan *plan) { return (void)plan, get_bake_voxel_m(scene) > 0.0; }
static bool has_sun(const neph_scene *scene, const np_plan *plan) {
  return (void)scene, plan->decisions.has_sun || np_plan_needs(plan, NP_STAGE_MOON);
}
/* ---- The table ---- */

#define STAGE(name) (1u << NP_STAGE_##name)

/* The order is the order of measurement: knobs that do not change the solution of multiple scattering come first. */
/* clang-format off */
static const np_knob knobs[] = {
    {.name = "samples", .key = "render.samples", .few = "1 4 16", .more = "2 8 32 64", .order = -0.5,
     .theory = "independent samples", .of = NP_KNOB_OF_MARCH, .get_number = get_samples},
    {.name = "step tolerance", .key = "render.tolerance", .few = "0.2 0.05 0.005", .more = "0.1 0.02 0.01",
     .order = 1.0, .theory = "steps of second order, as long as the cube root of the tolerance", .of = NP_KNOB_OF_MARCH,
     .stages = STAGE(VOLUMES), .get_number = get_tolerance},
    {.name = "sun optical depth", .key = "render.sun_optical_depth", .few = "volume march", .is_word = true,
     .of = NP_KNOB_OF_MARCH, .stages = STAGE(VOLUMES), .is_applicable = has_sun, .get_word = get_sun_optical_depth},
    {.name = "shadows in air", .key = "render.air_shadows", .few = "false true", .is_word = true,
     .of = NP_KNOB_OF_MARCH, .stages = STAGE(AIR_SHADOWS), .get_word = get_air_shadows},
    {.name = "method", .key = "render.multiple_scattering", .few = "octaves none",
     .more = "softened_beer powder derivative ordinates", .is_word = true, .of = NP_KNOB_OF_MARCH,
     .stages = STAGE(VOLUMES), .get_word = get_method},
    {.name = "quality", .key = "render.quality", .few = "draft preview", .more = "final", .is_word = true,
     .is_whole = true, .of = NP_KNOB_OF_MARCH, .get_word = get_quality},
    {.name = "path samples", .key = "render.samples", .few = "1 4", .more = "16 64", .order = -0.5,
     .theory = "independent samples", .of = NP_KNOB_OF_PATH, .get_number = get_samples},
    {.name = "path guiding", .key = "render.path_guiding", .few = "none adjoint", .is_word = true,
     .of = NP_KNOB_OF_PATH, .stages = STAGE(VOLUMES), .get_word = get_guiding},
    {.name = "cells", .key = "render.light_depth", .few = "1.4 0.7", .more = "2.8 0.175", .order = 2.0,
     .theory = "diamond difference, second order in the cell's edge", .of = NP_KNOB_OF_MARCH,
     .stages = STAGE(ORDINATES), .get_number = get_light_depth},
    {.name = "degree", .key = "render.light_degree", .few = "3 7", .more = "11", .is_word = true,
     .of = NP_KNOB_OF_MARCH, .stages = STAGE(ORDINATES), .get_word = get_light_degree},
    {.name = "residual", .key = "render.light_residual", .few = "0.1 0.01", .more = "0.03 0.003 0.00003", .order = 1.0,
     .theory = "iterations that contract by a factor each", .of = NP_KNOB_OF_MARCH, .stages = STAGE(ORDINATES),
     .get_number = get_light_residual},
    {.name = "detail", .key = "render.detail", .few = "2", .more = "1 4 0", .is_word = true, .of = NP_KNOB_OF_MARCH,
     .stages = STAGE(VOLUMES) | STAGE(TERRAIN), .get_word = get_detail},
    {.name = "bake voxel", .key = "clouds[].bake.voxel", .unit = " m", .few = "2 4", .more = "1.41 2.83",
     .is_factor = true, .order = 2.0, .theory = "trilinear interpolation of a smooth field", .of = NP_KNOB_OF_MARCH,
     .stages = STAGE(VOLUMES), .is_applicable = has_bake, .get_number = get_voxel},
    {.name = "table tolerance", .key = "atmosphere.tolerance", .few = "0.1 0.03", .more = "0.05 0.015 0.0035",
     .order = 1.0, .theory = "tables sized for it", .of = NP_KNOB_OF_MARCH, .stages = STAGE(ATMOSPHERE),
     .get_number = get_table_tolerance},
    {.name = "precision", .key = "clouds[].precision", .few = "half float", .is_word = true, .of = NP_KNOB_OF_MARCH,
     .stages = STAGE(VOLUMES), .get_word = get_precision},
};
/* clang-format on */

unsigned np_knob_count(void) { return sizeof knobs / sizeof *knobs; }

const np_knob *np_knob_at(unsigned index) { return &knobs[index]; }

bool np_knob_is_of_samples(const np_knob *knob) { return !strcmp(knob->key, "render.samples"); }

bool np_knob_applies(const np_knob *knob, const neph_scene *scene, const np_plan *plan) {
  bool is_needed = !knob->stages;
  for (int i = 0; i < NP_STAGE_COUNT; i++)
    is_needed = is_needed || (knob->stages & 1u << i && np_plan_needs(plan, (np_stage)i));
  return is_needed && (!knob->is_applicable || knob->is_applicable(scene, plan));
}

/* ---- Values ---- */

/* The `index`-th of the words of `list`; its length, 0 where there is none. `*count` becomes their number. */
static size_t get_word_at(const char *list, unsigned index, const char **out_word, unsigned *count) {
  size_t length = 0;
  *count = 0;
  for (const char *at = list ? list : ""; *at; at += strspn(at, " ")) {
    const size_t word = strcspn(at, " ");
    if ((*count)++ == index) *out_word = at, length = word;
    at += word;
  }
  return length;
}

static np_knob_value make_value(const np_knob *knob, double number) {
  np_knob_value value = {.number = number};
  np_print(value.text, sizeof value.text, "%.6g%s", number, knob->unit ? knob->unit : "");
  return value;
}

bool np_knob_get_value(const np_knob *knob, const neph_scene *scene, const np_plan *plan, unsigned index,
                       np_knob_value *out_value) {
  const char *word = NULL;
  unsigned few, more;
  size_t length = get_word_at(knob->few, index, &word, &few);
  const bool is_quick = length > 0;
  if (!is_quick) length = get_word_at(knob->more, index - few, &word, &more);
  if (!length) return false;
  np_knob_value value = {.number = (double)NAN};
  np_print(value.text, sizeof value.text, "%.*s", (int)length, word);
  if (!knob->is_word)
    value = make_value(knob, strtod(word, NULL) * (knob->is_factor ? knob->get_number(scene, plan) : 1.0));
  value.is_quick = is_quick;
  *out_value = value;
  return true;
}

np_knob_value np_knob_get_own(const np_knob *knob, const neph_scene *scene, const np_plan *plan) {
  if (!knob->is_word) return make_value(knob, knob->get_number(scene, plan));
  np_knob_value value = {.number = (double)NAN};
  np_print(value.text, sizeof value.text, "%s", knob->get_word(scene, plan));
  return value;
}

/* ---- Setting ---- */

/* Baked clouds alone have a bake's keys. */
static neph_result set_cloud(const np_knob *knob, neph_scene *scene, unsigned index, const char *value) {
  static const char mark[] = "clouds[].";
  char key[64];
  np_print(key, sizeof key, "clouds[%u].%s", index, knob->key + sizeof mark - 1);
  if (strstr(key, ".bake.") && !scene->clouds[index].is_baked) return NEPH_OK;
  if (!knob->is_factor) return neph_scene_set(scene, key, value);
  char own[NP_KNOB_VALUE_SIZE]; /* each in proportion to the coarsest */
  const double share = scene->clouds[index].bake.voxel_m / get_bake_voxel_m(scene);
  np_print(own, sizeof own, "%.9g%s", strtod(value, NULL) * share, knob->unit);
  return neph_scene_set(scene, key, own);
}

neph_result np_knob_set(const np_knob *knob, neph_scene *scene, const char *value) {
  if (!strstr(knob->key, "[]")) return neph_scene_set(scene, knob->key, value);
  neph_result result = NEPH_OK;
  for (unsigned i = 0; !result && i < scene->cloud_count; i++) result = set_cloud(knob, scene, i, value);
  return result;
}

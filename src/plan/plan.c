/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/plan.h"

#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/parallel.h"
#include "core/text.h"
#include "image/film.h"
#include "plan/part_check.h"
#include "plan/plan_history.h"
#include "plan/stage_rules.h"
#include "scene/cloud_places.h"
#include "scene/scene_eval.h"

enum { SIZE_LIMIT = 65536 };

/* ---- The description ---- */

#define NAME(id, name, needs) " " name
#define NAMES NP_MULTIPLE_SCATTERING_ROWS(NAME)

static neph_result check_eye(const neph_scene *scene, const neph_render_desc *desc) {
  if (desc->eye == NEPH_EYE_CENTRE || (scene->camera.is_stereo && (unsigned)desc->eye <= NEPH_EYE_RIGHT))
    return NEPH_OK;
  return np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "eye is %d, must be centre (0), or, of a scene with camera.stereo, left (1) or right (2)",
                 (int)desc->eye);
}

static neph_result check_desc(neph_context *context, const neph_render_desc *desc) {
  const neph_result bad = NEPH_ERROR_INVALID_ARGUMENT;
  if (desc->width < 1 || desc->height < 1 || desc->width > SIZE_LIMIT || desc->height > SIZE_LIMIT)
    return np_fail(context, bad, "the picture is %u x %u pixels, must be 1 to %d each way", desc->width, desc->height,
                   (int)SIZE_LIMIT);
  const unsigned *min = desc->crop_min, *max = desc->crop_max;
  if (min[0] >= max[0] || min[1] >= max[1] || max[0] > desc->width || max[1] > desc->height)
    return np_fail(context, bad, "the crop is %u,%u to %u,%u, must not be empty and lie within %u x %u pixels", min[0],
                   min[1], max[0], max[1], desc->width, desc->height);
  if (desc->tile_index >= desc->tile_count || desc->tile_count > max[1] - min[1])
    return np_fail(context, bad, "tile %u of %u is asked for, must be one of 1 to %u, the rows of the crop",
                   desc->tile_index + 1, desc->tile_count, max[1] - min[1]);
  if (desc->sample_count < 1 || desc->sample_count > NP_FILM_SAMPLES_MAX)
    return np_fail(context, bad, "samples is %u, must be 1 to %d", desc->sample_count, (int)NP_FILM_SAMPLES_MAX);
  if (!(desc->target_error > 0.0))
    return np_fail(context, bad, "target_error is %g, must be above 0", desc->target_error);
  if (!(desc->time_limit_s >= 0.0))
    return np_fail(context, bad, "time_limit_s is %g, must be at least 0", desc->time_limit_s);
  if (desc->sample_count_max < 16 || desc->sample_count_max > NP_FILM_SAMPLES_MAX)
    return np_fail(context, bad, "sample_count_max is %u, must be 16 to %d", desc->sample_count_max,
                   (int)NP_FILM_SAMPLES_MAX);
  if (!np_multiple_scattering_get_row(desc->multiple_scattering))
    return np_fail(context, bad, "multiple_scattering is %d, must be a neph_multiple_scattering, of:" NAMES,
                   (int)desc->multiple_scattering);
  if ((unsigned)desc->atmosphere > NEPH_RENDER_ATMOSPHERE_TABLES)
    return np_fail(context, bad, "atmosphere is %d, must be traced (0) or tables (1)", (int)desc->atmosphere);
  if ((unsigned)desc->path_guiding > NEPH_PATH_GUIDING_ADJOINT)
    return np_fail(context, bad, "path_guiding is %d, must be none (0) or adjoint (1)", (int)desc->path_guiding);
  if (desc->integrator != NEPH_INTEGRATOR_MARCH && desc->integrator != NEPH_INTEGRATOR_PATH)
    return np_fail(context, bad, "integrator is %d, must be march (0) or path (1)", (int)desc->integrator);
  return NEPH_OK;
}

static neph_result read_desc(const neph_scene *scene, const neph_render_desc *desc, neph_render_desc *out_desc) {
  neph_render_desc own = NEPH_RENDER_DESC_DEFAULT;
  neph_result result = neph_scene_get_render_desc(scene, &own);
  if (!result) result = np_desc_read(scene->context, "neph_render_desc", &own, sizeof own, desc, out_desc);
  if (!result) result = check_eye(scene, out_desc);
  if (out_desc->sample_end == NEPH_SAMPLES_ALL) out_desc->sample_end = out_desc->sample_count;
  return result ? result : check_desc(scene->context, out_desc);
}

/* ---- Facts about the scene ---- */

static bool is_positive(const double spectrum[3]) { return spectrum[0] > 0 || spectrum[1] > 0 || spectrum[2] > 0; }

static void compute_sun_facts(const neph_scene *scene, bool are_known, const np_scene_light_levels *levels,
                              np_scene_facts *f) {
  f->has_sun = is_positive(scene->sun.irradiance_w_m2_nm) && !(are_known && levels->is_sun_dark);
  if (!is_positive(scene->sun.irradiance_w_m2_nm))
    np_print(f->no_sun, sizeof f->no_sun, "sun.irradiance is 0");
  else
    np_print(f->no_sun, sizeof f->no_sun, "the sun is %.1f deg below the horizon seen, and from 19 on its sky is dark",
             -levels->sun_height_deg);
}

static void compute_moon_facts(const neph_scene *scene, bool are_known, const np_scene_light_levels *levels,
                               np_scene_facts *f) {
  const bool shines =
      scene->moon.is_enabled && scene->moon.brightness > 0 && is_positive(scene->sun.irradiance_w_m2_nm);
  f->has_moon = shines && !(are_known && levels->is_moon_outshone);
  if (!scene->moon.is_enabled)
    np_print(f->no_moon, sizeof f->no_moon, "the scene has no moon");
  else if (!shines)
    np_print(f->no_moon, sizeof f->no_moon, "moon.brightness or sun.irradiance is 0");
  else if (levels->moon_lux > 1e-3 * levels->sun_lux)
    np_print(f->no_moon, sizeof f->no_moon, "set: %.1f deg below the horizon seen, and from 6 on it is dark",
             -levels->moon_height_deg);
  else
    np_print(f->no_moon, sizeof f->no_moon,
             "outshone: %.2g lx against the sun's %.2g, of which it is less than a thousandth; its disk is seen",
             levels->moon_lux, levels->sun_lux);
}

static void compute_night_facts(const neph_scene *scene, bool are_known, const np_scene_light_levels *levels,
                                np_scene_facts *f) {
  const bool has_airglow = scene->airglow.is_enabled || (scene->stars.is_enabled && scene->stars.map);
  f->has_airglow = has_airglow && !(are_known && levels->is_airglow_outshone);
  f->has_stars = scene->stars.is_enabled && !(are_known && levels->are_stars_outshone);
  static const char outshone[] = "outshone: less than a thousandth of the sky's light at %.1f deg of sun";
  np_print(f->no_airglow, sizeof f->no_airglow,
           has_airglow ? outshone : "the scene has no airglow and no map of the stars", levels->sun_height_deg);
  np_print(f->no_stars, sizeof f->no_stars, scene->stars.is_enabled ? outshone : "the scene has no stars",
           levels->sun_height_deg);
}

/* Solid angle of a pixel in the middle of the picture. */
static double compute_pixel_sr(const neph_scene *scene, unsigned width, unsigned height) {
  const double edge = np_scene_camera_get_pixel_rad(&scene->camera, width, height);
  return edge * edge;
}

static const char *describe_darkness(const neph_scene *scene, const np_scene_facts *f) {
  if (!f->wants_light) return "no light is wanted: no output shows any";
  if (f->has_sun || f->has_environment || f->has_moon || f->has_airglow || f->has_stars || f->has_emission) return NULL;
  return is_positive(scene->sun.irradiance_w_m2_nm) ? "nothing shines: the sun is below the horizon by more than 19 deg"
                                                    : "nothing shines: sun and environment are 0";
}

static bool has_emission(const neph_scene *scene) {
  bool has_any = false;
  for (unsigned i = 0; i < scene->cloud_count; i++) has_any = has_any || scene->clouds[i].emission.is_enabled;
  return has_any;
}

static np_scene_facts compute_facts(const neph_scene *scene, const np_plan *plan) {
  np_scene_facts facts = {
      .wants_light = scene->output.has_beauty || scene->output.deep || np_aovs_need_light(scene->output.aovs),
      .has_environment = is_positive(scene->environment.radiance_w_m2_sr_nm),
      .has_air = scene->has_atmosphere && scene->environment.has_planet,
      .has_clouds = scene->cloud_count > 0,
      .has_emission = has_emission(scene),
      .has_terrain = scene->terrain.kind != NP_TERRAIN_NONE,
      .has_planet = scene->environment.has_planet,
  };
  np_scene_light_levels levels = {0};
  if (plan->are_lights_known)
    levels = np_scene_light_levels_compute(scene, &plan->lights,
                                           compute_pixel_sr(scene, plan->desc.width, plan->desc.height));
  facts.is_dusk = facts.has_air && plan->are_lights_known && levels.sun_height_deg < 0.0;
  compute_sun_facts(scene, plan->are_lights_known, &levels, &facts);
  compute_moon_facts(scene, plan->are_lights_known, &levels, &facts);
  compute_night_facts(scene, plan->are_lights_known, &levels, &facts);
  facts.dark = describe_darkness(scene, &facts);
  return facts;
}

/* ---- Resources ---- */

/* An edge of the crop that is one of the picture's goes out by the overscan, and so do the first and the last tile. */
static void set_windows(np_plan *plan, const neph_scene *scene) {
  const neph_render_desc *desc = &plan->desc;
  const uint64_t rows = desc->crop_max[1] - desc->crop_min[1];
  const unsigned size[2] = {desc->width, desc->height};
  const int overscan = (int)scene->camera.overscan;
  for (int k = 0; k < 2; k++) {
    plan->view_min[k] = -overscan;
    plan->view_max[k] = (int)size[k] + overscan;
    plan->whole_min[k] = plan->window_min[k] = desc->crop_min[k] == 0 ? plan->view_min[k] : (int)desc->crop_min[k];
    plan->whole_max[k] = plan->window_max[k] =
        desc->crop_max[k] == size[k] ? plan->view_max[k] : (int)desc->crop_max[k];
  }
  if (desc->tile_index > 0) plan->window_min[1] = (int)(desc->crop_min[1] + rows * desc->tile_index / desc->tile_count);
  if (desc->tile_index + 1 < desc->tile_count)
    plan->window_max[1] = (int)(desc->crop_min[1] + rows * (desc->tile_index + 1) / desc->tile_count);
}

/* A deep pixel has 16 samples, where all the picture is cloud. */
static const uint64_t deep_bytes = 16 * 24;

static void count_work(np_plan *plan, const neph_scene *scene) {
  const uint64_t pixels = np_plan_count_pixels(plan);
  plan->ray_count = pixels * (plan->desc.sample_end - plan->desc.sample_begin);
  if (np_plan_is_reconstructed(scene))
    plan->ray_count = (uint64_t)ceil(np_plan_get_rendered_share(scene) * (double)plan->ray_count);
  const unsigned own = plan->has_beauty ? 5 : 2;
  plan->film_bytes = pixels * (own + np_aovs_count_channels(plan->aovs, scene->cloud_count)) * sizeof(float);
  if (plan->desc.part_path || plan->desc.checkpoint_path) plan->film_bytes += 3 * plan->film_bytes;
  if (scene->output.deep) plan->film_bytes += pixels * deep_bytes;
}

/* One sample says nothing about its error: with a target error pixels get as many as the channels need, else fewer are
 * refused. */
static neph_result require_samples(np_plan *plan) {
  unsigned *samples = &plan->desc.sample_count;
  for (const np_aov_row *aov; (aov = np_aovs_search_short(plan->aovs, *samples)); *samples = aov->samples_min)
    if (!isfinite(plan->desc.target_error))
      return np_fail(plan->context, NEPH_ERROR_BAD_SCENE,
                     "render.samples is %u, must be at least %u for the %s of output.aovs", *samples, aov->samples_min,
                     aov->name);
  return NEPH_OK;
}

/* Directions of sun and moon, unless only the height field, not read yet, has the place. */
static void compute_lights(np_plan *plan, const neph_scene *scene) {
  plan->are_lights_known = scene->has_place || (!scene->sun.time.is_given && !scene->stars.is_enabled);
  if (plan->are_lights_known) plan->lights = np_scene_lights_compute(scene, scene->latitude_rad, scene->longitude_rad);
}

static unsigned count_emission(const neph_scene *scene) {
  unsigned count = 0;
  for (unsigned i = 0; i < scene->cloud_count; i++) count += scene->clouds[i].emission.is_enabled;
  return count;
}

/* Decides what is not decided yet. */
static neph_result decide_stages(np_plan *plan, const neph_scene *scene, const np_scene_facts *facts) {
  plan->has_sun = facts->has_sun;
  plan->has_light_groups = plan->aovs & NP_AOV_LIGHTS;
  plan->emission_count = count_emission(scene);
  neph_result result = np_stages_decide(plan, scene, facts);
  if (!result) np_stages_predict(plan, scene);
  return result;
}

/* Start of every plan. */
static neph_result begin(const neph_scene *scene, const neph_render_desc *desc, np_plan *plan) {
  plan->context = scene->context;
  neph_result result = np_scene_check(scene);
  if (!result) result = np_cloud_places_check(scene);
  if (!result) result = read_desc(scene, desc, &plan->desc);
  if (result) return result;
  plan->light_checkpoints = (np_light_checkpoints){.path = plan->desc.checkpoint_path,
                                                   .interval_s = plan->desc.checkpoint_interval_s,
                                                   .is_resumed = plan->desc.is_resumed};
  const double asked = scene->render.light_memory_bytes;
  plan->filled_share = 0.4;
  const neph_machine constants = NEPH_MACHINE_DEFAULT, *machine = plan->desc.machine;
  memcpy(plan->work_factor, (machine ? machine : &constants)->factor, sizeof plan->work_factor);
  plan->light_bytes_wanted = isfinite(asked) ? asked : 0.25 * (double)np_memory_size();
  plan->light_bytes_max = plan->light_bytes_wanted;
  set_windows(plan, scene);
  return NEPH_OK;
}

neph_result np_plan_make(const neph_scene *scene, const neph_render_desc *desc, np_plan *out_plan) {
  memset(out_plan, 0, sizeof *out_plan);
  out_plan->has_beauty = scene->output.has_beauty;
  out_plan->aovs = scene->output.aovs;
  neph_result result = begin(scene, desc, out_plan);
  if (!result) result = require_samples(out_plan);
  if (!result) result = np_part_check(scene, out_plan);
  if (!result) result = np_plan_check_history(scene, out_plan);
  if (result) return result;
  compute_lights(out_plan, scene);
  count_work(out_plan, scene);
  const np_scene_facts facts = compute_facts(scene, out_plan);
  return decide_stages(out_plan, scene, &facts);
}

neph_result np_plan_create_frame(const neph_scene *scene, const neph_render_desc *desc, neph_scene *out_scene,
                                 np_plan **out_plan) {
  neph_render_desc wanted = NEPH_RENDER_DESC_DEFAULT;
  *out_scene = (neph_scene){.context = NULL};
  *out_plan = np_plan_allocate(scene->context);
  neph_result result = *out_plan ? read_desc(scene, desc, &wanted) : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = np_scene_eval(scene, wanted.frame, out_scene);
  return result ? result : np_plan_make(out_scene, desc, *out_plan);
}

np_plan *np_plan_allocate(neph_context *context) { return np_alloc(context, 1, sizeof(np_plan)); }

void np_plan_destroy(neph_context *context, np_plan *plan) { np_alloc_free(context, plan); }

neph_result np_plan_revise(const neph_scene *scene, np_plan *plan) {
  const np_scene_facts facts = compute_facts(scene, plan);
  memset(plan->stages, 0, sizeof plan->stages);
  plan->bake_voxel_count = plan->cloud_voxel_count = plan->billow_voxel_count = plan->detail_voxel_count =
      plan->light_cell_count = 0.0;
  return decide_stages(plan, scene, &facts);
}

neph_result np_plan_leave_out_clouds(const neph_scene *scene, np_plan *plan) {
  np_scene_facts facts = compute_facts(scene, plan);
  facts.has_clouds = false;
  memset(plan->stages, 0, sizeof plan->stages);
  np_print(plan->stages[NP_STAGE_VOLUMES].reason, sizeof plan->stages->reason, "no cloud holds anything in this frame");
  return decide_stages(plan, scene, &facts);
}

neph_result np_plan_make_sky(const neph_scene *scene, bool is_of_bands, np_plan *out_plan) {
  memset(out_plan, 0, sizeof *out_plan);
  out_plan->has_beauty = out_plan->is_sky_alone = true;
  out_plan->is_of_bands = is_of_bands;
  neph_result result = begin(scene, NULL, out_plan);
  if (result) return result;
  compute_lights(out_plan, scene);
  out_plan->desc.atmosphere = NEPH_RENDER_ATMOSPHERE_TABLES; /* whatever integrator the scene's pictures take */
  np_scene_facts facts = compute_facts(scene, out_plan);
  facts.wants_light = true;
  facts.dark = describe_darkness(scene, &facts);
  facts.has_clouds = facts.has_terrain = false;
  return decide_stages(out_plan, scene, &facts);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Facts about the scene, and the walk over the rows that decides by them. */
#include "plan/decisions.h"

#include "core/alloc.h"
#include "core/text.h"
#include "plan/plan.h"
#include "plan/stage_rules.h"

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
  if (!f->has_light_outputs) return "no light is wanted: no output shows any";
  if (f->has_sun || f->has_environment || f->has_moon || f->has_airglow || f->has_stars || f->has_emission) return NULL;
  return is_positive(scene->sun.irradiance_w_m2_nm) ? "nothing shines: the sun is below the horizon by more than 19 deg"
                                                    : "nothing shines: sun and environment are 0";
}

static unsigned count_emission(const neph_scene *scene) {
  unsigned count = 0;
  for (unsigned i = 0; i < scene->cloud_count; i++) count += scene->clouds[i].emission.is_enabled;
  return count;
}

static np_scene_facts compute_facts(const neph_scene *scene, const np_request *r, const np_decisions *decisions,
                                    bool are_clouds_empty) {
  const bool is_known = decisions->are_lights_known;
  np_scene_facts facts = {
      .has_light_outputs =
          r->is_sky_alone || scene->output.has_beauty || scene->output.deep || np_aovs_need_light(scene->output.aovs),
      .has_environment = is_positive(scene->environment.radiance_w_m2_sr_nm),
      .has_air = scene->has_atmosphere && scene->environment.has_planet,
      .has_clouds = scene->cloud_count > 0 && !are_clouds_empty && !r->is_sky_alone,
      .has_emission = decisions->emission_count > 0,
      .has_terrain = scene->terrain.kind != NP_TERRAIN_NONE && !r->is_sky_alone,
      .has_planet = scene->environment.has_planet,
      .no_clouds = are_clouds_empty ? "no cloud holds anything in this frame" : "the scene has no clouds",
  };
  np_scene_light_levels levels = {0};
  if (is_known)
    levels = np_scene_light_levels_compute(scene, &decisions->lights,
                                           compute_pixel_sr(scene, r->desc.width, r->desc.height));
  facts.is_dusk = facts.has_air && is_known && levels.sun_height_deg < 0.0;
  compute_sun_facts(scene, is_known, &levels, &facts);
  compute_moon_facts(scene, is_known, &levels, &facts);
  compute_night_facts(scene, is_known, &levels, &facts);
  facts.dark = describe_darkness(scene, &facts);
  return facts;
}

/* ---- The walk ---- */

static const np_stage_decision *get(np_decision *d, np_stage stage) {
  np_stage_decision *out = &d->made->stages[stage];
  const np_stage_rule *rule = np_stage_get_rule(stage);
  if (out->reason || d->result) return out;
  if (!d->plan->request.is_sky_alone || rule->is_of_sky)
    rule->decide(d, out);
  else
    np_stage_decide(d, out, false, "only the sky is requested");
  return out;
}

/* Directions of sun and moon, unless only the height field, not read yet, has the place. */
static void compute_lights(const neph_scene *scene, np_decisions *out) {
  out->are_lights_known = scene->has_place || (!scene->sun.time.is_given && !scene->stars.is_enabled);
  if (out->are_lights_known) out->lights = np_scene_lights_compute(scene, scene->latitude_rad, scene->longitude_rad);
}

neph_result np_decisions_make(const neph_scene *scene, bool are_clouds_empty, np_plan *plan) {
  np_decisions *made = &plan->decisions;
  np_decisions_clear(scene->context, made);
  compute_lights(scene, made);
  made->emission_count = count_emission(scene);
  const np_scene_facts facts = compute_facts(scene, &plan->request, made, are_clouds_empty);
  made->has_sun = facts.has_sun;
  np_decision d = {.plan = plan, .scene = scene, .facts = &facts, .made = made, .get = get};
  for (int i = 0; i < NP_STAGE_COUNT && !d.result; i++) (void)get(&d, (np_stage)i);
  return d.result;
}

void np_decisions_clear(neph_context *context, np_decisions *decisions) {
  for (int i = 0; i < NP_STAGE_COUNT; i++) np_alloc_free(context, decisions->stages[i].reason);
  *decisions = (np_decisions){.emission_count = 0};
}

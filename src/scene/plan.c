/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/plan.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cloud/cloud_private.h"
#include "core/alloc.h"
#include "core/file.h"
#include "scene/plan_cells.h"

enum { SIZE_LIMIT = 65536 };

/* ---- The description ---- */

#define NAME(id, name, needs) " " name
#define NAMES NP_MULTIPLE_SCATTERING_ROWS(NAME)

static neph_result check_desc(neph_context *context, const neph_render_desc *desc) {
  const neph_result bad = NEPH_ERROR_INVALID_ARGUMENT;
  if (desc->width < 1 || desc->height < 1 || desc->width > SIZE_LIMIT || desc->height > SIZE_LIMIT)
    return np_fail(context, bad, "the picture is %u x %u pixels, must be 1 to %d each way", desc->width, desc->height,
                   (int)SIZE_LIMIT);
  const unsigned *min = desc->crop_min, *max = desc->crop_max;
  if (min[0] >= max[0] || min[1] >= max[1] || max[0] > desc->width || max[1] > desc->height)
    return np_fail(context, bad, "the crop is %u,%u to %u,%u, must not be empty and lie within %u x %u pixels", min[0],
                   min[1], max[0], max[1], desc->width, desc->height);
  if (desc->sample_count < 1) return np_fail(context, bad, "samples is 0, must be at least 1");
  if (!(desc->target_error > 0.0))
    return np_fail(context, bad, "target_error is %g, must be above 0", desc->target_error);
  if (!(desc->time_limit_s >= 0.0))
    return np_fail(context, bad, "time_limit_s is %g, must be at least 0", desc->time_limit_s);
  if (desc->sample_count_max < 16)
    return np_fail(context, bad, "sample_count_max is %u, must be at least 16", desc->sample_count_max);
  if (!np_multiple_scattering_get_row(desc->multiple_scattering))
    return np_fail(context, bad, "multiple_scattering is %d, must be a neph_multiple_scattering, of:" NAMES,
                   (int)desc->multiple_scattering);
  if ((unsigned)desc->atmosphere > NEPH_RENDER_ATMOSPHERE_TABLES)
    return np_fail(context, bad, "atmosphere is %d, must be traced (0) or tables (1)", (int)desc->atmosphere);
  if ((unsigned)desc->splitting > NEPH_SPLITTING_ADJOINT)
    return np_fail(context, bad, "splitting is %d, must be none (0) or adjoint (1)", (int)desc->splitting);
  if (desc->integrator != NEPH_INTEGRATOR_MARCH && desc->integrator != NEPH_INTEGRATOR_PATH)
    return np_fail(context, bad, "integrator is %d, must be march (0) or path (1)", (int)desc->integrator);
  return NEPH_OK;
}

static neph_result read_desc(const neph_scene *scene, const neph_render_desc *desc, neph_render_desc *out_desc) {
  neph_render_desc own = NEPH_RENDER_DESC_DEFAULT;
  neph_result result = neph_scene_get_render_desc(scene, &own);
  if (!result) result = np_desc_read(scene->context, "neph_render_desc", &own, sizeof own, desc, out_desc);
  return result ? result : check_desc(scene->context, out_desc);
}

/* ---- Facts about the scene ---- */

typedef struct scene_facts {
  bool wants_light; /* the outputs hold radiance */
  bool has_sun, has_environment, has_air, has_clouds, has_terrain, has_planet;
  bool has_emission;
  bool is_dusk;                                                /* the sun is down, and its light is the sky's */
  bool has_moon, has_glow, has_stars;                          /* of the moon, its light; its disk costs nothing */
  char no_sun[120], no_moon[160], no_glow[120], no_stars[120]; /* why not */
  const char *dark;                                            /* why there is no light to compute; NULL: there is */
} scene_facts;

static bool is_positive(const double spectrum[3]) { return spectrum[0] > 0 || spectrum[1] > 0 || spectrum[2] > 0; }

static void find_sun_facts(const neph_scene *scene, bool are_known, const np_scene_glow *glow, scene_facts *f) {
  f->has_sun = is_positive(scene->sun.irradiance_w_m2_nm) && !(are_known && glow->is_sun_dark);
  if (!is_positive(scene->sun.irradiance_w_m2_nm))
    snprintf(f->no_sun, sizeof f->no_sun, "sun.irradiance is 0");
  else
    snprintf(f->no_sun, sizeof f->no_sun, "the sun is %.1f deg below the horizon seen, and from 19 on its sky is dark",
             -glow->sun_height_deg);
}

static void find_moon_facts(const neph_scene *scene, bool are_known, const np_scene_glow *glow, scene_facts *f) {
  const bool shines = scene->moon.is_there && scene->moon.brightness > 0 && is_positive(scene->sun.irradiance_w_m2_nm);
  f->has_moon = shines && !(are_known && glow->is_moon_outshone);
  if (!scene->moon.is_there)
    snprintf(f->no_moon, sizeof f->no_moon, "the scene has no moon");
  else if (!shines)
    snprintf(f->no_moon, sizeof f->no_moon, "moon.brightness or sun.irradiance is 0");
  else if (glow->moon_lux > 1e-3 * glow->sun_lux)
    snprintf(f->no_moon, sizeof f->no_moon, "set: %.1f deg below the horizon seen, and from 6 on it is dark",
             -glow->moon_height_deg);
  else
    snprintf(f->no_moon, sizeof f->no_moon,
             "outshone: %.2g lx against the sun's %.2g, of which it is less than a thousandth; its disk is seen",
             glow->moon_lux, glow->sun_lux);
}

static void find_night_facts(const neph_scene *scene, bool are_known, const np_scene_glow *glow, scene_facts *f) {
  const bool has_glow = scene->airglow.is_there || (scene->stars.is_there && scene->stars.map);
  f->has_glow = has_glow && !(are_known && glow->is_airglow_outshone);
  f->has_stars = scene->stars.is_there && !(are_known && glow->are_stars_outshone);
  static const char outshone[] = "outshone: less than a thousandth of the sky's light at %.1f deg of sun";
  snprintf(f->no_glow, sizeof f->no_glow, has_glow ? outshone : "the scene has no airglow and no map of the stars",
           glow->sun_height_deg);
  snprintf(f->no_stars, sizeof f->no_stars, scene->stars.is_there ? outshone : "the scene has no stars",
           glow->sun_height_deg);
}

/* Solid angle of a pixel in the middle of the picture. */
static double find_pixel_sr(const neph_scene *scene, unsigned width) {
  const double edge = 2.0 * tan(0.5 * scene->camera.fov_rad) / width;
  return edge * edge;
}

static const char *find_darkness(const neph_scene *scene, const scene_facts *f) {
  if (!f->wants_light) return "no light is wanted: no output shows any";
  if (f->has_sun || f->has_environment || f->has_moon || f->has_glow || f->has_stars || f->has_emission) return NULL;
  return is_positive(scene->sun.irradiance_w_m2_nm) ? "nothing shines: the sun is below the horizon by more than 19 deg"
                                                    : "nothing shines: sun and environment are 0";
}

static bool has_emission(const neph_scene *scene) {
  bool is_there = false;
  for (unsigned i = 0; i < scene->cloud_count; i++) is_there = is_there || scene->clouds[i].emission.is_there;
  return is_there;
}

static scene_facts find_facts(const neph_scene *scene, const np_plan *plan) {
  scene_facts facts = {
      .wants_light = scene->output.has_beauty || np_aovs_need_light(scene->output.aovs),
      .has_environment = is_positive(scene->environment.radiance_w_m2_sr_nm),
      .has_air = scene->has_atmosphere && scene->environment.has_planet,
      .has_clouds = scene->cloud_count > 0,
      .has_emission = has_emission(scene),
      .has_terrain = scene->terrain.kind != NP_TERRAIN_NONE,
      .has_planet = scene->environment.has_planet,
  };
  np_scene_glow glow = {0};
  if (plan->are_lights_known) glow = np_scene_glow_find(scene, &plan->lights, find_pixel_sr(scene, plan->desc.width));
  facts.is_dusk = facts.has_air && plan->are_lights_known && glow.sun_height_deg < 0.0;
  find_sun_facts(scene, plan->are_lights_known, &glow, &facts);
  find_moon_facts(scene, plan->are_lights_known, &glow, &facts);
  find_night_facts(scene, plan->are_lights_known, &glow, &facts);
  facts.dark = find_darkness(scene, &facts);
  return facts;
}

/* ---- Stages ---- */

static void decide(np_plan *plan, np_stage stage, bool is_needed, const char *reason) {
  plan->stages[stage].is_needed = is_needed;
  snprintf(plan->stages[stage].reason, sizeof plan->stages[stage].reason, "%s", reason);
}

/* Not needed because of the first of these that is not NULL, else needed. */
static void decide_unless(np_plan *plan, np_stage stage, const char *against, const char *against_too,
                          const char *why) {
  const char *reason = against ? against : against_too;
  decide(plan, stage, !reason, reason ? reason : why);
}

static double count_voxels(const neph_cloud_desc *bake) {
  return bake->extent_m[0] * bake->extent_m[1] * bake->thickness_m / (bake->voxel_m * bake->voxel_m * bake->voxel_m);
}

/* A cloud with a file and parameters is baked to that file unless it is there and holds this very cloud. */
neph_result np_plan_find_source(const neph_scene *scene, const np_scene_cloud *cloud, const char *file, int frame,
                                np_cloud_source *out_source) {
  *out_source = file ? NP_CLOUD_SOURCE_FILE : NP_CLOUD_SOURCE_BAKE;
  if (!file || !cloud->is_baked) return NEPH_OK;
  if (!np_file_exists(file)) return *out_source = NP_CLOUD_SOURCE_BAKE, NEPH_OK;
  const neph_cloud_desc at_frame = np_scene_cloud_get_frame(cloud, frame);
  bool is_current;
  neph_result result =
      np_cloud_file_is_current(scene->context, file, &at_frame, scene->atmosphere.planet_radius_m, &is_current);
  if (!result && !is_current) *out_source = NP_CLOUD_SOURCE_REBAKE;
  return result;
}

/* Voxels in bricks: those of a bake take 0.9 to 1.1 bytes on disk, other files' 1.4 to 3; bricks fill some two fifths
 * of the box of a bake. */
static void count_cloud(np_plan *plan, const np_scene_cloud *cloud, np_cloud_source source, const char *file) {
  if (source == NP_CLOUD_SOURCE_FILE) {
    plan->cloud_voxel_count += (cloud->is_baked ? 1.0 : 0.5) * (double)np_file_get_size(file);
  } else {
    plan->bake_voxel_count += count_voxels(&cloud->bake);
    plan->cloud_voxel_count += 0.4 * count_voxels(&cloud->bake);
  }
}

static neph_result decide_cloud(np_plan *plan, const neph_scene *scene, const np_scene_cloud *cloud, char *out,
                                size_t size) {
  static const char *const deeds[] = {[NP_CLOUD_SOURCE_FILE] = "read from",
                                      [NP_CLOUD_SOURCE_BAKE] = "baked to",
                                      [NP_CLOUD_SOURCE_REBAKE] = "baked anew, for its parameters have changed, to"};
  char *file = cloud->vdb ? np_file_frame_name(plan->context, cloud->vdb, plan->desc.frame) : NULL;
  if (cloud->vdb && !file) return NEPH_ERROR_OUT_OF_MEMORY;
  np_cloud_source source;
  neph_result result = np_plan_find_source(scene, cloud, file, plan->desc.frame, &source);
  if (!result) count_cloud(plan, cloud, source, file);
  if (!result)
    snprintf(out, size, "%s is %s%s%s", cloud->name, file ? deeds[source] : "baked", file ? " " : "", file ? file : "");
  np_alloc_free(plan->context, file);
  return result;
}

static neph_result decide_volumes(np_plan *plan, const neph_scene *scene) {
  decide(plan, NP_STAGE_VOLUMES, scene->cloud_count > 0, scene->cloud_count ? "" : "the scene has no clouds");
  np_plan_stage *stage = &plan->stages[NP_STAGE_VOLUMES];
  neph_result result = NEPH_OK;
  for (unsigned i = 0; !result && i < scene->cloud_count; i++) {
    size_t length = strlen(stage->reason);
    char text[160] = "";
    result = decide_cloud(plan, scene, &scene->clouds[i], text, sizeof text);
    snprintf(stage->reason + length, sizeof stage->reason - length, "%s%s", i ? "; " : "", text);
  }
  return result;
}

static void decide_terrain(np_plan *plan, const neph_scene *scene) {
  const np_terrain_row *row = &np_terrain_rows[scene->terrain.kind];
  char reason[sizeof plan->stages->reason];
  snprintf(reason, sizeof reason, "%s%s", row->description, row->check ? scene->terrain.heightfield : "");
  decide(plan, NP_STAGE_TERRAIN, scene->terrain.kind != NP_TERRAIN_NONE, reason);
}

bool np_plan_traces_air(const np_plan *plan) {
  return plan->desc.integrator == NEPH_INTEGRATOR_PATH && plan->desc.atmosphere == NEPH_RENDER_ATMOSPHERE_TRACED;
}

bool np_plan_has_air_light(const np_plan *plan) {
  return !np_plan_traces_air(plan) || plan->stages[NP_STAGE_CLOUD_SKY].is_needed ||
         plan->stages[NP_STAGE_ORDINATES].is_needed;
}

/* After multiple scattering: what that is solved for under, it asks of the tables, whoever traces the air. */
static void decide_sky(np_plan *plan, const scene_facts *facts) {
  const char *no_air = facts->has_air      ? NULL
                       : facts->has_planet ? "atmosphere.preset is none"
                                           : "environment.planet is none";
  const char *no_sky = no_air ? no_air : facts->has_sun || facts->has_moon ? NULL : facts->no_sun;
  const char *seen = "the sky shines on the clouds";
  const char *no_cloud_sky = no_sky;
  if (!no_sky && np_plan_traces_air(plan)) {
    const bool is_solved = plan->stages[NP_STAGE_ORDINATES].is_needed;
    no_sky = "render.atmosphere is traced: paths go through the air";
    no_cloud_sky = is_solved || facts->is_dusk ? NULL : no_sky;
    seen = is_solved ? "multiple scattering is solved for under it"
                     : "the sun is down: paths aim at where the sky is bright";
  }
  const char *no_clouds = facts->has_clouds ? NULL : "the scene has no clouds";
  decide_unless(plan, NP_STAGE_CAMERA_SKY, facts->dark, no_sky, "sky behind, and air before, what the camera sees");
  decide_unless(plan, NP_STAGE_CLOUD_SKY, facts->dark, no_cloud_sky ? no_cloud_sky : no_clouds, seen);
  const char *why = np_plan_has_air_light(plan)
                        ? "light passes through air"
                        : "paths fly through air; what light is in it is traced, and left out here";
  decide_unless(plan, NP_STAGE_ATMOSPHERE, facts->dark, no_air, why);
}

static void decide_light(np_plan *plan, const scene_facts *facts) {
  const bool has_target = facts->has_clouds || facts->has_terrain || facts->has_planet;
  const char *no_target = has_target ? NULL : "there is nothing to shine on";
  const char *no_sun = facts->has_sun ? no_target : facts->no_sun;
  const bool has_sky =
      facts->has_environment || facts->has_glow || (facts->has_air && (facts->has_sun || facts->has_moon));
  const char *no_sky = has_sky ? no_target : "neither air nor environment shines";
  const char *no_clouds = facts->has_clouds ? NULL : "the scene has no clouds";
  const char *no_ground = facts->has_planet || facts->has_terrain ? no_clouds : "there is no ground";
  decide_unless(plan, NP_STAGE_SUN_LIGHT, facts->dark, no_sun, "the sun shines on clouds and ground");
  decide_unless(plan, NP_STAGE_SKY_LIGHT, facts->dark, no_sky, "the sky shines on clouds and ground");
  decide_unless(plan, NP_STAGE_GROUND_LIGHT, facts->dark, no_ground, "the ground throws light back at the clouds");
}

static void decide_sun_depth(np_plan *plan, const neph_scene *scene, const scene_facts *facts) {
  const char *against = facts->dark;
  if (!against && !facts->has_clouds) against = "the scene has no clouds";
  if (!against && plan->desc.integrator == NEPH_INTEGRATOR_PATH && plan->air_ray_spacing == 0)
    against = "the tracer asks the clouds themselves";
  if (!against && !facts->has_sun && !facts->has_moon) against = facts->no_sun;
  char reason[sizeof plan->stages->reason] = "";
  const bool is_cheaper = !against && np_plan_choose_sun_volume(plan, scene, reason, sizeof reason);
  decide(plan, NP_STAGE_SUN_DEPTH, is_cheaper, against ? against : reason);
}

/* Before the volume of depths towards the sun, which they ask. */
static void decide_air_shadows(np_plan *plan, const neph_scene *scene, const scene_facts *facts) {
  const np_plan_stage *sky = &plan->stages[NP_STAGE_CAMERA_SKY];
  const char *against = sky->is_needed ? NULL : sky->reason;
  if (!against && !facts->has_clouds && !facts->has_terrain) against = "there are neither clouds nor hills";
  char reason[sizeof plan->stages->reason] = "";
  const bool is_wanted = !against && np_plan_choose_air_shadows(plan, scene, reason, sizeof reason);
  decide(plan, NP_STAGE_AIR_SHADOWS, is_wanted, against ? against : reason);
  plan->air_ray_spacing = is_wanted ? np_plan_choose_air_spacing(plan, scene) : 0;
}

static void decide_night(np_plan *plan, const scene_facts *facts) {
  decide_unless(plan, NP_STAGE_MOON, facts->dark, facts->has_moon ? NULL : facts->no_moon,
                "the moon shines on air, clouds and ground");
  decide_unless(plan, NP_STAGE_STARS, facts->dark, facts->has_stars ? NULL : facts->no_stars,
                "points of light, dimmed by the air");
  decide_unless(plan, NP_STAGE_AIRGLOW, facts->dark, facts->has_glow ? NULL : facts->no_glow,
                "the floor of the night sky");
  decide_unless(plan, NP_STAGE_EMISSION, facts->dark, facts->has_emission ? NULL : "no cloud has emission",
                "black bodies in the clouds, of their grids' temperatures");
}

/* Of cells and memory, as far as they can be told before a file is read. */
static neph_result describe_ordinates(const np_plan *plan, const neph_scene *scene, char *out, size_t size) {
  bool are_known;
  double errors[2];
  neph_result result = np_plan_expect_light_errors(plan, scene, &are_known, errors);
  const char *what = "solved for once while clouds and lights stay, within render.light_memory";
  if (!result && are_known)
    snprintf(out, size, "%s; expected error %.2g %% near the camera, %.2g %% in the largest cells", what,
             100.0 * errors[0], 100.0 * errors[1]);
  else
    snprintf(out, size, "%s; expected error 2 to 4 %%, more where that is little", what);
  return result;
}

/* Whether light scattered more than once is solved for, for the march or to split paths by. */
static neph_result decide_ordinates(np_plan *plan, const neph_scene *scene, const char *against, const char *chosen) {
  char solving[sizeof plan->stages->reason] = "", reason[sizeof plan->stages->reason];
  neph_result result = against || chosen ? NEPH_OK : describe_ordinates(plan, scene, solving, sizeof solving);
  const bool is_split = plan->desc.integrator == NEPH_INTEGRATOR_PATH;
  snprintf(reason, sizeof reason, "%s%s", is_split ? "paths are guided by it; " : "", solving);
  decide_unless(plan, NP_STAGE_ORDINATES, against, chosen, reason);
  return result;
}

static neph_result decide_scattering(np_plan *plan, const neph_scene *scene, const scene_facts *facts) {
  const neph_render_desc *desc = &plan->desc;
  const char *against = facts->dark;
  if (!against && !facts->has_clouds) against = "the scene has no clouds";
  const bool is_path = desc->integrator == NEPH_INTEGRATOR_PATH;
  const char *not_looked = is_path ? "paths scatter as often as it takes" : NULL;
  const char *not_solved = desc->splitting == NEPH_SPLITTING_ADJOINT ? NULL : not_looked;
  if (!against && desc->scattering_max < 2) against = "render.max_scatterings is below 2";
  const np_multiple_scattering_row *row = np_multiple_scattering_get_row(desc->multiple_scattering);
  char chosen[64];
  (void)snprintf(chosen, sizeof chosen, "render.multiple_scattering is %s", row->name);
  const char *not_asked = is_path || row->needs == NP_MULTIPLE_SCATTERING_NEEDS_SOLUTION ? NULL : chosen;
  neph_result result = decide_ordinates(plan, scene, against ? against : not_solved, not_asked);
  const bool is_solved = !is_path && plan->stages[NP_STAGE_ORDINATES].is_needed;
  decide_unless(plan, NP_STAGE_GROUND_CLOUDS, is_solved ? NULL : "multiple scattering is not solved for",
                facts->has_planet || facts->has_terrain ? NULL : "there is no ground",
                "the clouds hide sky from the ground, and shine on it");
  decide_unless(plan, NP_STAGE_LOOK, against ? against : not_looked,
                row->needs == NP_MULTIPLE_SCATTERING_NEEDS_APPROXIMATION ? NULL : chosen, chosen);
  const char *path = np_plan_traces_air(plan) ? "path: unbiased in clouds and air and to the ground"
                                              : "path: unbiased in the clouds, air and ground from tables";
  decide(plan, NP_STAGE_INTEGRATOR, true, desc->integrator == NEPH_INTEGRATOR_PATH ? path : "march: fast and biased");
  return result;
}

/* Without light there is nothing that depends on wavelength. */
static void decide_colors(np_plan *plan, const neph_scene *scene, const scene_facts *facts) {
  plan->color_space = np_scene_get_color_space(scene);
  plan->wavelength_count = facts->dark ? 3 : scene->render.wavelength_count;
  plan->packet_count = plan->wavelength_count / 3;
  char reason[sizeof plan->stages->reason] = "the three bands are the picture's channels";
  if (plan->packet_count > 1)
    snprintf(reason, sizeof reason,
             "%u wavelengths, in %u packets of three, each with its own air and light, summed to %s",
             plan->wavelength_count, plan->packet_count, np_color_space_get_name(plan->color_space));
  decide_unless(plan, NP_STAGE_COLOR, facts->dark, NULL, reason);
  plan->stages[NP_STAGE_COLOR].is_needed = plan->packet_count > 1;
}

/* ---- Resources ---- */

static void count_work(np_plan *plan) {
  const neph_render_desc *desc = &plan->desc;
  const uint64_t pixels = (uint64_t)(desc->crop_max[0] - desc->crop_min[0]) * (desc->crop_max[1] - desc->crop_min[1]);
  plan->ray_count = pixels * desc->sample_count;
  plan->film_bytes = pixels * (2 + (plan->has_beauty ? 3 : 0) + np_aovs_count_channels(plan->aovs)) * sizeof(float);
}

/* One sample says nothing about its error. */
static neph_result check_samples(const np_plan *plan) {
  const unsigned samples = plan->desc.sample_count;
  const np_aov_row *aov = np_aovs_search_short(plan->aovs, samples);
  if (aov)
    return np_fail(plan->context, NEPH_ERROR_BAD_SCENE,
                   "render.samples is %u, must be at least %u for the %s of output.aovs", samples, aov->samples_min,
                   aov->name);
  if (samples >= 2 || !isfinite(plan->desc.target_error)) return NEPH_OK;
  return np_fail(plan->context, NEPH_ERROR_BAD_SCENE,
                 "render.samples is 1, must be at least 2 for render.target_error");
}

/* Where sun and moon stand, unless only the height field, not read yet, knows the place. */
static neph_result find_lights(np_plan *plan, const neph_scene *scene) {
  plan->are_lights_known = scene->has_place || (!scene->sun.time && !scene->stars.is_there);
  if (!plan->are_lights_known) return NEPH_OK;
  return np_scene_lights_find(scene, scene->latitude_rad, scene->longitude_rad, &plan->lights);
}

static neph_result decide_stages(np_plan *plan, const neph_scene *scene, const scene_facts *facts) {
  plan->has_sun = facts->has_sun;
  decide_terrain(plan, scene);
  decide_light(plan, facts);
  decide_night(plan, facts);
  neph_result result = decide_scattering(plan, scene, facts);
  decide_sky(plan, facts);
  decide_colors(plan, scene, facts);
  count_work(plan);
  decide_air_shadows(plan, scene, facts);
  decide_sun_depth(plan, scene, facts);
  return result;
}

neph_result np_plan_make(const neph_scene *scene, const neph_render_desc *desc, np_plan *out_plan) {
  *out_plan = (np_plan){.context = scene->context, .has_beauty = scene->output.has_beauty, .aovs = scene->output.aovs};
  neph_result result = np_scene_check(scene);
  if (!result) result = read_desc(scene, desc, &out_plan->desc);
  if (!result) result = check_samples(out_plan);
  if (!result) result = find_lights(out_plan, scene);
  if (!result) result = decide_volumes(out_plan, scene);
  if (result) return result;
  const scene_facts facts = find_facts(scene, out_plan);
  return decide_stages(out_plan, scene, &facts);
}

neph_result np_plan_leave_out_clouds(const neph_scene *scene, np_plan *plan) {
  scene_facts facts = find_facts(scene, plan);
  facts.has_clouds = false;
  decide(plan, NP_STAGE_VOLUMES, false, "no cloud holds anything in this frame");
  return decide_stages(plan, scene, &facts);
}

neph_result np_plan_make_sky(const neph_scene *scene, np_plan *out_plan) {
  *out_plan = (np_plan){.context = scene->context, .has_beauty = true};
  neph_result result = np_scene_check(scene);
  if (!result) result = read_desc(scene, NULL, &out_plan->desc);
  if (!result) result = find_lights(out_plan, scene);
  if (result) return result;
  out_plan->desc.atmosphere = NEPH_RENDER_ATMOSPHERE_TABLES; /* whatever integrator the scene's pictures take */
  scene_facts facts = find_facts(scene, out_plan);
  facts.wants_light = true;
  facts.dark = find_darkness(scene, &facts);
  facts.has_clouds = facts.has_terrain = false;
  out_plan->has_sun = facts.has_sun;
  decide_sky(out_plan, &facts);
  decide_colors(out_plan, scene, &facts);
  decide_night(out_plan, &facts);
  for (int i = 0; i < NP_STAGE_COUNT; i++)
    if (!out_plan->stages[i].reason[0]) decide(out_plan, (np_stage)i, false, "only the sky is wanted");
  return NEPH_OK;
}

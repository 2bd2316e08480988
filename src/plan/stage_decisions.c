/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/stage_decisions.h"

#include <math.h>
#include <string.h>

#include "cloud/bake_file.h"
#include "core/alloc.h"
#include "core/file.h"
#include "core/text.h"
#include "core/units.h"
#include "plan/plan_choices.h"
#include "plan/plan_detail.h"
#include "scene/cloud_file.h"
#include "scene/cloud_ground.h"
#include "volume/volume_levels.h"
#include "volume/volume_private.h"

static void decide(np_plan_stage *out, bool is_needed, const char *reason) {
  out->is_needed = is_needed;
  np_print(out->reason, sizeof out->reason, "%s", reason);
}

/* Not needed because of the first of these that is not NULL, else needed. */
static void decide_unless(np_plan_stage *out, const char *against, const char *against_too, const char *why) {
  const char *reason = against ? against : against_too;
  decide(out, !reason, reason ? reason : why);
}

/* Why a stage that another depends on is not needed; NULL: it is. */
static const char *get_against(np_decision *d, np_stage stage) {
  const np_plan_stage *other = d->get(d, stage);
  return other->is_needed ? NULL : other->reason;
}

static bool is_path(const np_decision *d) { return d->plan->desc.integrator == NEPH_INTEGRATOR_PATH; }

static const char *get_cloudless(const np_decision *d) {
  return d->facts->has_clouds ? NULL : "the scene has no clouds";
}

static bool has_ground(const np_decision *d) { return d->facts->has_planet || d->facts->has_terrain; }

/* ---- Matter ---- */

/* Without light there is nothing that depends on wavelength. */
void np_stage_decide_color(np_decision *d, np_plan_stage *out) {
  np_plan *plan = d->plan;
  plan->color_space = plan->is_of_bands ? NP_COLOR_BANDS : d->scene->output.color_space;
  plan->wavelength_count = d->facts->dark || plan->is_of_bands ? 3 : d->scene->render.wavelength_count;
  plan->packet_count = plan->wavelength_count / 3;
  decide(out, true, "the bands at 680, 550 and 440 nm are the picture's channels");
  if (plan->color_space != NP_COLOR_BANDS)
    np_print(out->reason, sizeof out->reason, "bands at 612, 538 and 448 nm, from which %s follows by a matrix",
             np_color_space_get_name(plan->color_space));
  if (plan->packet_count > 1)
    np_print(out->reason, sizeof out->reason,
             "%u wavelengths, in %u packets of three, each with its own air and light, summed to %s",
             plan->wavelength_count, plan->packet_count, np_color_space_get_name(plan->color_space));
}

void np_stage_decide_color_fit(np_decision *d, np_plan_stage *out) {
  d->get(d, NP_STAGE_COLOR);
  const char *against = d->facts->dark;
  if (!against && d->plan->color_space == NP_COLOR_BANDS) against = "output.color_space is bands";
  decide_unless(out, against, d->plan->packet_count > 1 ? "enough wavelengths add up to colours" : NULL,
                "fitted to sun and sky at the camera, in a dozen probes of six wavelengths");
}

void np_stage_decide_terrain(np_decision *d, np_plan_stage *out) {
  const np_scene_terrain *terrain = &d->scene->terrain;
  const np_terrain_row *row = &np_terrain_rows[terrain->kind];
  out->is_needed = terrain->kind != NP_TERRAIN_NONE;
  np_print(out->reason, sizeof out->reason, "%s", *row->description ? row->description : "mesh");
}

/* A cloud with a file and parameters is baked to that file unless it is there and holds this very cloud. */
neph_result np_plan_choose_source(const neph_scene *scene, const np_scene_cloud *cloud, const char *file, int frame,
                                  np_cloud_source *out_source) {
  *out_source = file ? NP_CLOUD_SOURCE_FILE : cloud->volume ? NP_CLOUD_SOURCE_GIVEN : NP_CLOUD_SOURCE_BAKE;
  if (!file || !cloud->is_baked) return NEPH_OK;
  if (!np_file_exists(file)) return *out_source = NP_CLOUD_SOURCE_BAKE, NEPH_OK;
  neph_cloud_desc at_frame = np_scene_cloud_get_frame(cloud, frame);
  np_cloud_ground ground;
  bool is_current = true;
  neph_result result = np_cloud_ground_name(scene, &at_frame, &ground);
  neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  np_plan_describe_file_bake(scene, cloud, &bake);
  if (!result) result = np_cloud_file_is_current(scene->context, file, &at_frame, &bake, &is_current);
  if (!result && !is_current) *out_source = NP_CLOUD_SOURCE_REBAKE;
  return result;
}

/* Leaves of voxels twice as long for each that there was: an eighth inside, a quarter along surfaces. */
static const double coarse_share = 0.2;

unsigned np_plan_count_levels(const np_plan *plan, const neph_scene *scene, const np_scene_cloud *cloud) {
  const size_t index = (size_t)(cloud - scene->clouds);
  if (cloud->is_baked) return cloud->bake.repeat_m > 0.0 ? 1 : cloud->level_count;
  return index < NP_INSTANCES_MAX ? plan->files[index].level_count : 1;
}

/* Voxels in bricks: those of a bake take 0.9 to 1.1 bytes on disk, other files' 1.4 to 3; bricks fill some two fifths
 * of the box of a bake. Within a limit on memory the finest of several levels goes into the next. */
static neph_result count_files(np_plan *plan, bool is_baked, unsigned levels, const char *file) {
  const double voxels_per_byte = is_baked || levels > 1 ? 1.0 : 0.5;
  for (unsigned k = 0; k == 0 || k < levels; k++) {
    char *path = np_volume_name_level(plan->context, file, k);
    if (!path) return NEPH_ERROR_OUT_OF_MEMORY;
    const double voxels = voxels_per_byte * (double)np_file_get_size(path);
    plan->cloud_voxel_count += plan->are_coarse && k == 0 ? coarse_share * voxels : voxels;
    np_alloc_free(plan->context, path);
  }
  return NEPH_OK;
}

static neph_result count_cloud(np_plan *plan, const neph_scene *scene, const np_scene_cloud *cloud,
                               np_cloud_source source, const char *file) {
  if (source == NP_CLOUD_SOURCE_GIVEN) { /* 8³ voxels a brick */
    plan->cloud_voxel_count += 512.0 * (double)cloud->volume->bricks.brick_count;
  } else if (source == NP_CLOUD_SOURCE_FILE) {
    return count_files(plan, cloud->is_baked, np_plan_count_levels(plan, scene, cloud), file);
  } else {
    const np_bake_voxels voxels = np_plan_count_bake_voxels(plan, scene, cloud);
    plan->bake_voxel_count += voxels.box;
    plan->cloud_voxel_count += plan->filled_share * voxels.box;
    plan->billow_voxel_count += plan->filled_share * voxels.along_billows;
  }
  return NEPH_OK;
}

neph_result np_plan_choose_cloud_file(const np_plan *plan, const neph_scene *scene, const np_scene_cloud *cloud,
                                      np_plan_cloud_file *out) {
  const char *vdb = np_plan_is_coarsened(plan, scene, cloud) ? NULL : cloud->vdb; /* a coarse bake stays in memory */
  np_cloud_file of_frame = {.path = NULL};
  neph_result result = vdb ? np_cloud_file_get(plan->context, cloud, plan->desc.frame, &of_frame) : NEPH_OK;
  *out = (np_plan_cloud_file){.path = of_frame.path};
  out->is_missing = !result && !out->path && np_scene_cloud_is_sequence(cloud);
  if (!result && !out->is_missing)
    result = np_plan_choose_source(scene, cloud, out->path, plan->desc.frame, &out->source);
  if (!result) return NEPH_OK;
  np_alloc_free(plan->context, out->path);
  out->path = NULL;
  return result;
}

static neph_result decide_cloud(np_plan *plan, const neph_scene *scene, const np_scene_cloud *cloud) {
  np_plan_cloud_file file;
  neph_result result = np_plan_choose_cloud_file(plan, scene, cloud, &file);
  const double before = plan->cloud_voxel_count;
  if (!result && !file.is_missing) result = count_cloud(plan, scene, cloud, file.source, file.path);
  if (cloud->detail.is_enabled && cloud->detail.strength > 0.0)
    plan->detail_voxel_count += plan->cloud_voxel_count - before;
  np_alloc_free(plan->context, file.path);
  return result;
}

/* np_stage_describe_volumes names each. */
void np_stage_decide_volumes(np_decision *d, np_plan_stage *out) {
  const neph_scene *scene = d->scene;
  decide(out, scene->cloud_count > 0, scene->cloud_count ? "the scene has clouds" : "the scene has no clouds");
  for (unsigned i = 0; !d->result && i < scene->cloud_count; i++)
    d->result = decide_cloud(d->plan, scene, &scene->clouds[i]);
}

void np_stage_decide_emission(np_decision *d, np_plan_stage *out) {
  decide_unless(out, d->facts->dark, d->facts->has_emission ? NULL : "no cloud has emission",
                "black bodies in the clouds, of their grids' temperatures");
}

void np_stage_decide_world(np_decision *d, np_plan_stage *out) {
  (void)d;
  decide(out, true, "geometry, media and lights in their places");
}

/* ---- Air ---- */

static const char *get_airless(const np_decision *d) {
  if (d->facts->has_air) return NULL;
  return d->facts->has_planet ? "atmosphere.preset is none" : "environment.planet is none";
}

/* Why no sky shines; NULL: one does. */
static const char *get_skyless(const np_decision *d) {
  const char *airless = get_airless(d);
  return airless || d->facts->has_sun || d->facts->has_moon ? airless : d->facts->no_sun;
}

static const char traced[] = "render.atmosphere is traced: paths go through the air";

void np_stage_decide_atmosphere(np_decision *d, np_plan_stage *out) {
  d->get(d, NP_STAGE_CLOUD_SKY);
  d->get(d, NP_STAGE_ORDINATES);
  const char *why = np_plan_has_air_light(d->plan)
                        ? "light passes through air"
                        : "paths fly through air; what light is in it is traced, and left out here";
  decide_unless(out, d->facts->dark, get_airless(d), why);
}

void np_stage_decide_camera_sky(np_decision *d, np_plan_stage *out) {
  const char *skyless = get_skyless(d);
  decide_unless(out, d->facts->dark, !skyless && np_plan_traces_air(d->plan) ? traced : skyless,
                "sky behind, and air before, what the camera sees");
}

/* The solution of multiple scattering takes its light from the tables, even where paths trace the air. */
void np_stage_decide_cloud_sky(np_decision *d, np_plan_stage *out) {
  const char *against = get_skyless(d), *why = "the sky shines on the clouds";
  if (!against && np_plan_traces_air(d->plan)) {
    const bool is_solved = !get_against(d, NP_STAGE_ORDINATES);
    against = is_solved || d->facts->is_dusk ? NULL : traced;
    why = is_solved ? "multiple scattering is solved for under it"
                    : "the sun is down: paths aim at where the sky is bright";
  }
  decide_unless(out, d->facts->dark, against ? against : get_cloudless(d), why);
}

void np_stage_decide_water_sky(np_decision *d, np_plan_stage *out) {
  const char *against = np_scene_has_water(d->scene) ? get_skyless(d) : "the scene has no water";
  if (!against && d->plan->is_sky_alone) against = "only the sky is wanted";
  if (!against && np_plan_traces_air(d->plan)) against = traced;
  decide_unless(out, d->facts->dark, against, "sky behind, and air before, what the water reflects");
}

void np_stage_decide_sky_guide(np_decision *d, np_plan_stage *out) {
  decide_unless(out, is_path(d) ? NULL : "the march aims at nothing", get_against(d, NP_STAGE_CLOUD_SKY),
                "paths aim at where sky and ground are bright");
}

/* ---- Lights ---- */

void np_stage_decide_lights(np_decision *d, np_plan_stage *out) {
  const np_dvec3 to_sun = d->plan->lights.to_sun;
  decide(out, true, "where sun, moon and stars stand goes by the place of the height field");
  if (d->plan->are_lights_known)
    np_print(out->reason, sizeof out->reason, "the sun's elevation is %.3g deg, its azimuth %.3g deg",
             asin(np_clamp(to_sun.z, -1.0, 1.0)) / NP_DEGREE,
             fmod(atan2(to_sun.x, to_sun.y) / NP_DEGREE + 360.0, 360.0));
  const size_t length = strlen(out->reason);
  if (d->plan->has_light_groups)
    np_print(out->reason + length, sizeof out->reason - length,
             "; %u groups of lights, each solved for and traced apart", np_plan_count_lights(d->plan));
}

void np_stage_decide_moon(np_decision *d, np_plan_stage *out) {
  decide_unless(out, d->facts->dark, d->facts->has_moon ? NULL : d->facts->no_moon,
                "the moon shines on air, clouds and ground");
}

void np_stage_decide_stars(np_decision *d, np_plan_stage *out) {
  decide_unless(out, d->facts->dark, d->facts->has_stars ? NULL : d->facts->no_stars,
                "points of light, dimmed by the air");
}

void np_stage_decide_airglow(np_decision *d, np_plan_stage *out) {
  decide_unless(out, d->facts->dark, d->facts->has_airglow ? NULL : d->facts->no_airglow, "the floor of the night sky");
}

static const char *get_targetless(const np_decision *d) {
  return d->facts->has_clouds || has_ground(d) ? NULL : "there is nothing to shine on";
}

void np_stage_decide_sun_light(np_decision *d, np_plan_stage *out) {
  decide_unless(out, d->facts->dark, d->facts->has_sun ? get_targetless(d) : d->facts->no_sun,
                "the sun shines on clouds and ground");
}

void np_stage_decide_sky_light(np_decision *d, np_plan_stage *out) {
  const np_scene_facts *f = d->facts;
  const bool has_sky = f->has_environment || f->has_airglow || (f->has_air && (f->has_sun || f->has_moon));
  decide_unless(out, f->dark, has_sky ? get_targetless(d) : "neither air nor environment shines",
                "the sky shines on clouds and ground");
}

void np_stage_decide_ground_light(np_decision *d, np_plan_stage *out) {
  decide_unless(out, d->facts->dark, has_ground(d) ? get_cloudless(d) : "there is no ground",
                "the ground reflects light to the clouds");
}

/* ---- Caches of light ---- */

void np_stage_decide_sun_optical_depth(np_decision *d, np_plan_stage *out) {
  const np_plan *plan = d->plan;
  d->get(d, NP_STAGE_VOLUMES);
  d->get(d, NP_STAGE_AIR_SHADOWS);
  const char *against = d->facts->dark ? d->facts->dark : get_cloudless(d);
  if (!against && is_path(d) && plan->air_ray_spacing == 0) against = "the tracer asks the clouds themselves";
  if (!against && !d->facts->has_sun && !d->facts->has_moon) against = d->facts->no_sun;
  if (against)
    decide(out, false, against);
  else
    out->is_needed = np_plan_choose_sun_volume(plan, d->scene, out->reason, sizeof out->reason);
}

static const char parallel[] = "camera.kind is orthographic: its rays have no common eye";

void np_stage_decide_air_shadows(np_decision *d, np_plan_stage *out) {
  const char *against = get_against(d, NP_STAGE_CAMERA_SKY);
  if (!against && !d->facts->has_clouds && !d->facts->has_terrain) against = "there are neither clouds nor hills";
  if (!against && d->scene->camera.kind == NEPH_CAMERA_ORTHOGRAPHIC) against = parallel;
  if (against)
    decide(out, false, against);
  else
    out->is_needed = np_plan_choose_air_shadows(d->plan, d->scene, out->reason, sizeof out->reason);
  d->plan->air_ray_spacing = out->is_needed ? np_plan_choose_air_spacing(d->plan, d->scene) : 0;
}

/* The middle of those of clouds from files, whose density is not known yet. */
static const double error_of_files = 0.02,
                    files_exponent = 0.25; /* their voxels set a least cell, whatever its depth */

/* Errors that are known before a file is read. */
static void describe_ordinates(np_decision *d, char *out, size_t size) {
  np_cells_forecast f;
  d->result = np_plan_forecast_cells(d->plan, d->scene, &f);
  d->plan->light_cell_count = f.cells.cell_count;
  d->plan->light_share = f.share;
  d->plan->light_error = f.are_errors_known
                             ? f.cells.errors[1]
                             : error_of_files * pow(fmax(d->scene->render.light_depth / 0.35, 1.0), files_exponent);
  const char *what = "solved for once while clouds and lights stay, within render.light_memory";
  if (f.are_errors_known)
    np_print(out, size, "%s; expected error %.2g %% near the camera, %.2g %% in the largest cells", what,
             100.0 * f.cells.errors[0], 100.0 * f.cells.errors[1]);
  else
    np_print(out, size, "%s; expected error 2 to 4 %%, more where that is little", what);
}

static const char endless[] = "paths scatter as often as it takes";

/* Why no light is to be scattered more than once. */
static const char *get_scatterless(const np_decision *d) {
  const char *against = d->facts->dark ? d->facts->dark : get_cloudless(d);
  return !against && d->plan->desc.scattering_max < 2 ? "render.max_scatterings is below 2" : against;
}

/* "render.multiple_scattering is none", …: a literal of each row. */
static const char *get_chosen(const np_decision *d) {
#define CHOSEN(id, name, needs) [NEPH_MULTIPLE_SCATTERING_##id] = "render.multiple_scattering is " name,
  static const char *const chosen[] = {NP_MULTIPLE_SCATTERING_ROWS(CHOSEN)};
#undef CHOSEN
  return chosen[d->plan->desc.multiple_scattering];
}

static bool needs_of_method(const np_decision *d, np_multiple_scattering_needs needs) {
  return np_multiple_scattering_get_row(d->plan->desc.multiple_scattering)->needs == needs;
}

/* For the march, or to guide paths by. */
void np_stage_decide_ordinates(np_decision *d, np_plan_stage *out) {
  const neph_render_desc *desc = &d->plan->desc;
  const char *against = get_scatterless(d);
  if (!against && is_path(d) && desc->path_guiding != NEPH_PATH_GUIDING_ADJOINT) against = endless;
  if (!against && !is_path(d) && !needs_of_method(d, NP_MULTIPLE_SCATTERING_NEEDS_SOLUTION)) against = get_chosen(d);
  char solved[sizeof out->reason] = "", why[sizeof out->reason];
  if (!against) describe_ordinates(d, solved, sizeof solved);
  np_print(why, sizeof why, "%s%s", is_path(d) ? "paths are guided by it; " : "", solved);
  decide_unless(out, against, NULL, why);
}

void np_stage_decide_viewer_light(np_decision *d, np_plan_stage *out) {
  const char *against = is_path(d) ? "paths ask for light in all directions" : NULL;
  if (!against && d->scene->camera.kind == NEPH_CAMERA_ORTHOGRAPHIC) against = parallel;
  decide_unless(out, against, get_against(d, NP_STAGE_ORDINATES), "the march asks for light towards the camera alone");
}

void np_stage_decide_ground_clouds(np_decision *d, np_plan_stage *out) {
  const bool is_solved = !is_path(d) && !get_against(d, NP_STAGE_ORDINATES);
  decide_unless(out, is_solved ? NULL : "multiple scattering is not solved for",
                has_ground(d) ? NULL : "there is no ground", "the clouds hide sky from the ground, and shine on it");
}

void np_stage_decide_approximation(np_decision *d, np_plan_stage *out) {
  const bool is_approximated = needs_of_method(d, NP_MULTIPLE_SCATTERING_NEEDS_APPROXIMATION);
  const char *against = get_scatterless(d), *chosen = get_chosen(d);
  if (!against && is_path(d)) against = endless;
  decide_unless(out, against, is_approximated ? NULL : chosen, chosen);
}

void np_stage_decide_lighting(np_decision *d, np_plan_stage *out) {
  (void)d;
  decide(out, true, "the integrator asks those of these caches that there are");
}

void np_stage_decide_integrator(np_decision *d, np_plan_stage *out) {
  static const char march[] = "march: fast and biased";
  const char *path = np_plan_traces_air(d->plan) ? "path: unbiased in clouds and air and to the ground"
                                                 : "path: unbiased in the clouds, air and ground from tables";
  const unsigned edge = d->scene->render.upsample, length = (unsigned)strlen(is_path(d) ? path : march);
  decide(out, true, is_path(d) ? path : march);
  if (edge > 1 && !d->plan->is_sky_alone)
    np_print(out->reason + length, sizeof out->reason - length, "; one pixel of %u x %u, the others by their depth",
             edge, edge);
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/stage_decisions.h"

#include <math.h>
#include <string.h>

#include "core/text.h"
#include "core/units.h"
#include "plan/plan_choices.h"

/* A stage is needed unless one of these reasons against it is not NULL; the first is reported. */
static void decide_unless(np_decision *d, np_stage_decision *out, const char *against, const char *against_too,
                          const char *why) {
  const char *reason = against ? against : against_too;
  np_stage_decide(d, out, !reason, "%s", reason ? reason : why);
}

/* Why a stage that another depends on is not needed; NULL: it is. */
static const char *get_against(np_decision *d, np_stage stage) {
  const np_stage_decision *other = d->get(d, stage);
  return other->is_needed ? NULL : other->reason ? other->reason : ""; /* "": there is no memory */
}

static bool is_path(const np_decision *d) { return np_request_is_path(&d->plan->request); }

static const char *get_cloudless(const np_decision *d) { return d->facts->has_clouds ? NULL : d->facts->no_clouds; }

static bool has_ground(const np_decision *d) { return d->facts->has_planet || d->facts->has_terrain; }

/* ---- Matter ---- */

/* Colour: without light nothing depends on wavelength. */
void np_stage_decide_color(np_decision *d, np_stage_decision *out) {
  const bool is_of_bands = d->plan->request.sky.is_of_bands;
  np_decisions *made = d->made;
  made->color_space = is_of_bands ? NP_COLOR_BANDS : d->scene->output.color_space;
  made->wavelength_count = d->facts->dark || is_of_bands ? 3 : d->scene->render.wavelength_count;
  made->packet_count = made->wavelength_count / 3;
  const char *space = np_color_space_get_name(made->color_space);
  if (made->packet_count > 1)
    np_stage_decide(d, out, true,
                    "%u wavelengths, in %u packets of three, each with its own air and light, summed to %s",
                    made->wavelength_count, made->packet_count, space);
  else if (made->color_space != NP_COLOR_BANDS)
    np_stage_decide(d, out, true, "bands at 612, 538 and 448 nm, from which %s follows by a matrix", space);
  else
    np_stage_decide(d, out, true, "the bands at 680, 550 and 440 nm are the picture's channels");
}

void np_stage_decide_color_fit(np_decision *d, np_stage_decision *out) {
  d->get(d, NP_STAGE_COLOR);
  const char *against = d->facts->dark;
  if (!against && d->made->color_space == NP_COLOR_BANDS) against = "output.color_space is bands";
  decide_unless(d, out, against, d->made->packet_count > 1 ? "enough wavelengths add up to colours" : NULL,
                "fitted to sun and sky at the camera, in a dozen probes of six wavelengths");
}

void np_stage_decide_terrain(np_decision *d, np_stage_decision *out) {
  const np_scene_terrain *terrain = &d->scene->terrain;
  const np_terrain_row *row = &np_terrain_rows[terrain->kind];
  np_stage_decide(d, out, terrain->kind != NP_TERRAIN_NONE, "%s", *row->description ? row->description : "mesh");
}

/* np_stage_describe_volumes names each. */
void np_stage_decide_volumes(np_decision *d, np_stage_decision *out) {
  decide_unless(d, out, get_cloudless(d), NULL, "the scene has clouds");
}

void np_stage_decide_emission(np_decision *d, np_stage_decision *out) {
  decide_unless(d, out, d->facts->dark, d->facts->has_emission ? NULL : "no cloud has emission",
                "black bodies in the clouds, of their grids' temperatures");
}

void np_stage_decide_world(np_decision *d, np_stage_decision *out) {
  np_stage_decide(d, out, true, "geometry, media and lights in their places");
}

/* ---- Air ---- */

static const char *get_airless(const np_decision *d) {
  if (d->facts->has_air) return NULL;
  return d->facts->has_planet ? "atmosphere.preset is none" : "environment.planet is none";
}

/* Why no air shines; NULL: it does. The march has the light of fires in the air from tables, even where those of the
 * sun are dark. */
static const char *get_skyless(const np_decision *d) {
  const char *airless = get_airless(d);
  const bool is_lit_by_fire = d->facts->has_emission && !is_path(d);
  return airless || d->facts->has_sun || d->facts->has_moon || is_lit_by_fire ? airless : d->facts->no_sun;
}

static const char traced[] = "render.atmosphere is traced: paths go through the air";

void np_stage_decide_atmosphere(np_decision *d, np_stage_decision *out) {
  d->get(d, NP_STAGE_CLOUD_SKY);
  d->get(d, NP_STAGE_ORDINATES);
  const char *why = np_plan_has_air_light(d->plan)
                        ? "light passes through air"
                        : "paths fly through air; what light is in it is traced, and left out here";
  decide_unless(d, out, d->facts->dark, get_airless(d), why);
}

void np_stage_decide_camera_sky(np_decision *d, np_stage_decision *out) {
  const char *skyless = get_skyless(d);
  decide_unless(d, out, d->facts->dark, !skyless && np_request_traces_air(&d->plan->request) ? traced : skyless,
                "sky behind, and air before, what the camera sees");
}

/* The solution of multiple scattering takes its light from the tables, even where paths trace the air. */
void np_stage_decide_cloud_sky(np_decision *d, np_stage_decision *out) {
  const char *against = get_skyless(d), *why = "the sky shines on the clouds";
  if (!against && np_request_traces_air(&d->plan->request)) {
    const bool is_solved = !get_against(d, NP_STAGE_ORDINATES);
    against = is_solved || d->facts->is_dusk ? NULL : traced;
    why = is_solved ? "multiple scattering is solved for under it"
                    : "the sun is down: paths sample directions where the sky is bright";
  }
  decide_unless(d, out, d->facts->dark, against ? against : get_cloudless(d), why);
}

void np_stage_decide_water_sky(np_decision *d, np_stage_decision *out) {
  const char *against = np_scene_has_water(d->scene) ? get_skyless(d) : "the scene has no water";
  if (!against && d->plan->request.is_sky_alone) against = "only the sky is requested";
  if (!against && np_request_traces_air(&d->plan->request)) against = traced;
  decide_unless(d, out, d->facts->dark, against, "sky behind, and air before, what the water reflects");
}

void np_stage_decide_sky_guide(np_decision *d, np_stage_decision *out) {
  decide_unless(d, out, is_path(d) ? NULL : "only paths sample the sky", get_against(d, NP_STAGE_CLOUD_SKY),
                "paths sample directions where sky and ground are bright");
}

/* ---- Lights ---- */

void np_stage_decide_lights(np_decision *d, np_stage_decision *out) {
  const np_dvec3 to_sun = d->made->lights.to_sun;
  const double elevation = asin(np_clamp(to_sun.z, -1.0, 1.0)), azimuth = atan2(to_sun.x, to_sun.y);
  char groups[80] = "";
  if (d->plan->request.has_light_groups)
    np_print(groups, sizeof groups, "; %u groups of lights, each solved for and traced apart",
             np_plan_count_lights(d->plan));
  if (d->made->are_lights_known)
    np_stage_decide(d, out, true, "the sun's elevation is %.3g deg, its azimuth %.3g deg%s", elevation / NP_DEGREE,
                    fmod(azimuth / NP_DEGREE + 360.0, 360.0), groups);
  else
    np_stage_decide(d, out, true, "sun, moon and stars stand as seen from the place of the height field%s", groups);
}

void np_stage_decide_moon(np_decision *d, np_stage_decision *out) {
  decide_unless(d, out, d->facts->dark, d->facts->has_moon ? NULL : d->facts->no_moon,
                "the moon shines on air, clouds and ground");
}

void np_stage_decide_stars(np_decision *d, np_stage_decision *out) {
  decide_unless(d, out, d->facts->dark, d->facts->has_stars ? NULL : d->facts->no_stars,
                "points of light, dimmed by the air");
}

void np_stage_decide_airglow(np_decision *d, np_stage_decision *out) {
  decide_unless(d, out, d->facts->dark, d->facts->has_airglow ? NULL : d->facts->no_airglow,
                "the floor of the night sky");
}

static const char *get_targetless(const np_decision *d) {
  return d->facts->has_clouds || has_ground(d) ? NULL : "there is nothing to shine on";
}

void np_stage_decide_sun_light(np_decision *d, np_stage_decision *out) {
  decide_unless(d, out, d->facts->dark, d->facts->has_sun ? get_targetless(d) : d->facts->no_sun,
                "the sun shines on clouds and ground");
}

void np_stage_decide_sky_light(np_decision *d, np_stage_decision *out) {
  const np_scene_facts *f = d->facts;
  const bool has_sky = f->has_environment || f->has_airglow || (f->has_air && (f->has_sun || f->has_moon));
  decide_unless(d, out, f->dark, has_sky ? get_targetless(d) : "neither air nor environment shines",
                "the sky shines on clouds and ground");
}

void np_stage_decide_ground_light(np_decision *d, np_stage_decision *out) {
  decide_unless(d, out, d->facts->dark, has_ground(d) ? get_cloudless(d) : "there is no ground",
                "the ground reflects light to the clouds");
}

/* ---- Caches of light ---- */

void np_stage_decide_sun_optical_depth(np_decision *d, np_stage_decision *out) {
  d->get(d, NP_STAGE_AIR_SHADOWS);
  const char *against = d->facts->dark ? d->facts->dark : get_cloudless(d);
  if (!against && !d->facts->has_sun && !d->facts->has_moon) against = d->facts->no_sun;
  if (against)
    np_stage_decide(d, out, false, "%s", against);
  else
    np_stage_choose_sun_volume(d, out);
}

static const char parallel[] = "camera.kind is orthographic: its rays have no common eye";

void np_stage_decide_air_shadows(np_decision *d, np_stage_decision *out) {
  const char *against = get_against(d, NP_STAGE_CAMERA_SKY);
  if (!against && !d->facts->has_clouds && !d->facts->has_terrain) against = "there are neither clouds nor hills";
  if (!against && d->scene->camera.kind == NEPH_CAMERA_ORTHOGRAPHIC) against = parallel;
  if (against)
    np_stage_decide(d, out, false, "%s", against);
  else
    np_stage_choose_air_shadows(d, out);
  d->made->air_ray_spacing = out->is_needed ? np_plan_choose_air_spacing(&d->plan->request, d->scene) : 0;
}

/* Median error of clouds from files, whose density is not known yet. */
static const double error_of_files = 0.02,
                    files_exponent = 0.25; /* their voxels set a least cell, whatever its depth */

/* Reason why no cloud is solved for although the stage runs: the ground needs the clouds' opacity. */
static void describe_left_out(const np_left_out *left_out, char *out, size_t size) {
  if (left_out->are_black)
    np_print(out, size, "nothing is solved for: the clouds' albedo is 0, and they scatter no light");
  else
    np_print(out, size,
             "nothing is solved for: the clouds are out of view, and their light changes the picture by less than "
             "%.2g %%",
             100.0 * left_out->share);
}

/* Errors that are known before a file is read. */
static void describe_ordinates(np_decision *d, char *out, size_t size) {
  np_cells_forecast f;
  const np_left_out *left_out = &d->made->left_out;
  char rest[120] = "";
  d->made->left_out = np_plan_choose_left_out(d->plan, d->scene);
  if (left_out->is_all) {
    d->made->cells = (np_expected_cells){0};
    describe_left_out(left_out, out, size);
    return;
  }
  if (left_out->count > 0)
    np_print(rest, sizeof rest, "; not for %u of %u clouds, out of view, which change the picture by less than %.2g %%",
             left_out->count, d->scene->cloud_count, 100.0 * left_out->share);
  d->result = np_plan_forecast_cells(d->plan, d->scene, &f);
  d->made->cells = (np_expected_cells){
      f.cells.counts, f.are_errors_known
                          ? f.cells.errors[1]
                          : error_of_files * pow(fmax(d->scene->render.light_depth / 0.35, 1.0), files_exponent)};
  const char *what = "solved for once while clouds and lights stay, within render.light_memory";
  if (f.are_errors_known)
    np_print(out, size, "%s; expected error %.2g %% near the camera, %.2g %% in the largest cells%s", what,
             100.0 * f.cells.errors[0], 100.0 * f.cells.errors[1], rest);
  else
    np_print(out, size, "%s; expected error 2 to 4 %%, more where that is little%s", what, rest);
}

static const char endless[] = "paths scatter as often as it takes";

/* Reason why multiple scattering is not needed; NULL: it is. */
static const char *get_scatterless(const np_decision *d) {
  const char *against = d->facts->dark ? d->facts->dark : get_cloudless(d);
  return !against && d->plan->request.desc.scattering_max < 2 ? "render.max_scatterings is below 2" : against;
}

/* "render.multiple_scattering is none", …: a literal of each row. */
static const char *get_chosen(const np_decision *d) {
#define CHOSEN(id, name, needs) [NEPH_MULTIPLE_SCATTERING_##id] = "render.multiple_scattering is " name,
  static const char *const chosen[] = {NP_MULTIPLE_SCATTERING_ROWS(CHOSEN)};
#undef CHOSEN
  return chosen[d->plan->request.desc.multiple_scattering];
}

static bool needs_of_method(const np_decision *d, np_multiple_scattering_needs needs) {
  return np_multiple_scattering_get_row(d->plan->request.desc.multiple_scattering)->needs == needs;
}

/* Multiple scattering is solved for the march, or to guide paths. */
void np_stage_decide_ordinates(np_decision *d, np_stage_decision *out) {
  const neph_render_desc *desc = &d->plan->request.desc;
  const char *against = get_scatterless(d);
  if (!against && is_path(d) && desc->path_guiding != NEPH_PATH_GUIDING_ADJOINT) against = endless;
  if (!against && !is_path(d) && !needs_of_method(d, NP_MULTIPLE_SCATTERING_NEEDS_SOLUTION)) against = get_chosen(d);
  char solved[400] = "";
  if (!against) describe_ordinates(d, solved, sizeof solved);
  np_stage_decide(d, out, !against, "%s%s",
                  against      ? ""
                  : is_path(d) ? "paths are guided by it; "
                               : "",
                  against ? against : solved);
}

void np_stage_decide_viewer_light(np_decision *d, np_stage_decision *out) {
  const char *against = is_path(d) ? "paths need light in all directions" : NULL;
  if (!against && d->scene->camera.kind == NEPH_CAMERA_ORTHOGRAPHIC) against = parallel;
  if (!against && d->made->left_out.is_all) against = "multiple scattering is solved for no cloud";
  decide_unless(d, out, against, get_against(d, NP_STAGE_ORDINATES), "the march needs light towards the camera alone");
}

void np_stage_decide_ground_clouds(np_decision *d, np_stage_decision *out) {
  const bool is_solved = !is_path(d) && !get_against(d, NP_STAGE_ORDINATES);
  decide_unless(d, out, is_solved ? NULL : "multiple scattering is not solved for",
                has_ground(d) ? NULL : "there is no ground", "the clouds hide sky from the ground, and shine on it");
}

void np_stage_decide_relief_light(np_decision *d, np_stage_decision *out) {
  const bool is_traced = np_request_traces_air(&d->plan->request);
  decide_unless(d, out,
                d->facts->dark ? d->facts->dark
                : is_traced    ? traced
                               : NULL,
                d->facts->has_terrain ? NULL : "there are no hills", "hills hide sky from slopes, and shine on them");
}

void np_stage_decide_approximation(np_decision *d, np_stage_decision *out) {
  const bool is_approximated = needs_of_method(d, NP_MULTIPLE_SCATTERING_NEEDS_APPROXIMATION);
  const char *against = get_scatterless(d), *chosen = get_chosen(d);
  if (!against && is_path(d)) against = endless;
  decide_unless(d, out, against, is_approximated ? NULL : chosen, chosen);
}

void np_stage_decide_lighting(np_decision *d, np_stage_decision *out) {
  np_stage_decide(d, out, true, "it holds the light caches for the integrator");
}

void np_stage_decide_integrator(np_decision *d, np_stage_decision *out) {
  const char *path = np_request_traces_air(&d->plan->request)
                         ? "path: unbiased in clouds and air and to the ground"
                         : "path: unbiased in the clouds, air and ground from tables";
  const unsigned edge = d->scene->render.upsample;
  char pixels[96] = "";
  if (edge > 1 && !d->plan->request.is_sky_alone)
    np_print(pixels, sizeof pixels, "; one pixel of %u x %u, the others by their depth", edge, edge);
  np_stage_decide(d, out, true, "%s%s", is_path(d) ? path : "march: fast and biased", pixels);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Worlds, and the caches of light that are built of them. */
#include <stdio.h>

#include "caches/light_key.h"
#include "core/alloc.h"
#include "core/units.h"
#include "integrate/approximation.h"
#include "integrate/approximation_gain.h"
#include "plan/integrator_choice.h"
#include "stages/copies.h"
#include "stages/stage_part.h"
#include "volume/places.h"

/* ---- World ---- */

static np_disk make_sun_disk(const np_world_inputs *in) {
  const np_scene_sun *sun = &in->scene->sun;
  const np_vec3 direction = np_dvec3_to_float(in->lights->places.to_sun);
  const np_spectrum irradiance = np_bands_convert(in->bands, NP_BAND_SUN, sun->irradiance_w_m2_nm);
  if (!sun->has_limb_darkening) return np_disk_make(direction, sun->angular_radius_rad, irradiance);
  return np_disk_make_sun(direction, sun->angular_radius_rad, irradiance, in->bands->nm);
}

/* Light beyond the air, and what of it is uniform. */
static void add_surroundings(const np_world_inputs *in, np_world *world) {
  const np_scene_environment *environment = &in->scene->environment;
  world->night = in->night;
  world->environment_radiance = np_bands_convert(in->bands, NP_BAND_LINEAR, environment->radiance_w_m2_sr_nm);
  world->is_environment_upper_only = environment->is_upper_only;
}

static const np_emission *get_emission(const np_emission *emission) {
  return emission->emitter_count > 0 ? emission : NULL;
}

/* Adds disk, emission and surroundings to the world of the first light: they must count once. */
static void add_common(const np_world_inputs *in, np_world *world) {
  world->disk = make_sun_disk(in);
  world->has_no_disks = !in->scene->output.has_disks && !in->plan->request.is_sky_alone;
  world->emission = get_emission(&in->emission->all);
  add_surroundings(in, world);
}

/* Adds the lights that belong to a group, where each group has a world. */
static void add_group(const np_world_inputs *in, np_world *world) {
  const unsigned group = in->beam->group;
  if (in->beam->index == 0) world->disk = make_sun_disk(in);
  world->has_no_disks = !in->scene->output.has_disks;
  if (group == NP_LIGHT_GROUP_SUN) world->sun_scope = NP_SUN_BEAM;
  if (group == NP_LIGHT_GROUP_SKY) {
    world->sun_scope = NP_SUN_SKY;
    add_surroundings(in, world);
  }
  if (group >= NP_LIGHT_GROUP_EMISSION && in->emission->groups)
    world->emission = get_emission(&in->emission->groups[group - NP_LIGHT_GROUP_EMISSION]);
}

/* The clouds that are not empty, with the albedo of a packet. */
static neph_result build_instances(const np_world_inputs *in, np_placed_clouds *out) {
  const np_frame_clouds *clouds = in->clouds;
  np_instance *at = out->at = np_alloc(in->context, clouds->volume_count, sizeof *at);
  if (!at) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; i < clouds->count; i++)
    if (clouds->at[i].volume)
      at += np_cloud_parts_place(&clouds->at[i], &in->scene->clouds[i], i, in->color, in->bands, at);
  return np_copies_build_places(in->context, clouds, out);
}

NP_STAGE_BUILD(instances, world, task->packet->placed)

void np_stage_clear_instances(const np_stage_task *task) {
  np_placed_clouds *placed = &task->packet->placed;
  np_places_clear(task->in.part.context, &placed->places);
  np_alloc_free(task->in.part.context, placed->at);
}

/* Rounds to a thousandth, to which albedos are rounded too; grey still stays grey. */
static void round_basis(np_spectrum basis[NP_BAND_COUNT]) {
  for (int i = 0; i < NP_BAND_COUNT; i++) {
    basis[i].band[i] = 1.0f;
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      if (b == i) continue;
      basis[b].band[i] = nearbyintf(1024.0f * basis[b].band[i]) / 1024.0f;
      basis[i].band[i] -= basis[b].band[i];
    }
  }
}

/* Albedos in a packet are linear in the albedos of a scene, up to their limits, and grey stays grey: so a little of
 * each reference band is added to a grey that is far from them. */
static void set_basis(const np_world_inputs *in, np_spectrum out_basis[NP_BAND_COUNT]) {
  static const double grey = 0.5, little = 0.25;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    double tinted[NP_BAND_COUNT] = {grey, grey, grey};
    tinted[b] += little;
    const np_spectrum own = np_picture_color_fit_albedo(in->color, in->bands, tinted);
    out_basis[b] = np_spectrum_scale(np_spectrum_subtract(own, np_spectrum_grey((float)grey)), (float)(1.0 / little));
  }
  if (in->color->is_fitted) round_basis(out_basis);
}

/* Planet, terrain and water, the same under each light. */
static void add_ground(const np_world_inputs *in, np_water *out_water, np_world *world) {
  const neph_scene *scene = in->scene;
  double albedo[NP_BAND_COUNT];
  np_stage_get_ground_albedo(&in->part, in->terrain, in->lights, albedo);
  world->ground_albedo = np_picture_color_convert_albedo(in->color, in->bands, albedo);
  world->terrain = in->terrain;
  if (world->terrain) {
    np_terrain_get_bounds(world->terrain, &world->terrain_min, &world->terrain_max);
    world->terrain_albedo =
        np_picture_color_convert_albedo(in->color, in->bands, np_terrain_get_mean_albedo(world->terrain));
  }
  set_basis(in, world->terrain_basis);
  if (!np_scene_has_water(scene)) return;
  *out_water = np_water_make(scene->water.level_m, scene->water.wind_m_s,
                             np_picture_color_convert_albedo(in->color, in->bands, scene->water.albedo));
  world->water = out_water;
}

/* The world of a light, and the water of that world. */
static neph_result build_world(const np_world_inputs *in, np_water *out_water, np_world *out) {
  const neph_scene *scene = in->scene;
  const np_light_beam *beam = in->beam;
  *out = (np_world){
      .clouds.count = in->clouds->volume_count,
      .clouds.at = in->placed->at,
      .clouds.places = in->placed->places.count > 0 ? &in->placed->places : NULL,
      .to_sun = np_dvec3_to_float(beam->direction),
      .sun_angular_radius_rad = (float)beam->angular_radius_rad,
      .sun_irradiance = beam->irradiance,
      .atmosphere = in->atmosphere,
      .camera_sky = in->camera_sky,
      .has_parallel_view = !np_camera_has_centre(in->camera),
      .cloud_sky = in->cloud_sky ? in->cloud_sky : in->water_sky,
      .has_planet = scene->environment.has_planet,
      .planet_radius_m = scene->atmosphere.planet_radius_m,
  };
  add_ground(in, out_water, out);
  if (in->lights->has_groups)
    add_group(in, out);
  else if (beam->index == 0)
    add_common(in, out);
  return NEPH_OK;
}

neph_result np_stage_build_world(const np_stage_task *task) {
  return build_world(&task->in.world, &task->light->water, &task->light->world);
}

/* ---- Sky guide ---- */

/* True if the light around the clouds is known: with traced air at dusk, and where paths are guided. */
static neph_result build_sky_guide(const np_sky_guide_inputs *in, np_sky_guide *out) {
  if (!in->cloud_sky) return NEPH_OK;
  const float cost = np_request_traces_air(&in->plan->request) ? np_sky_guide_traced_cost : 1.0f;
  const np_sun_optical_depths depths = {.clouds = &in->world->clouds};
  const np_sun_optical_depth_source source = np_sun_optical_depths_get_source(&depths);
  np_sky_guide_build(in->world, &source, np_frame_clouds_get_middle(in->clouds), cost, out);
  return NEPH_OK;
}

NP_STAGE_BUILD(sky_guide, sky_guide, task->light->sky_guide)

/* ---- Sun optical depth ---- */

/* The least rate at which depths count: in the scaled medium, or in the slowest octave. */
static float compute_sun_rate(const np_sun_optical_depth_inputs *in) {
  const np_instances *clouds = &in->world->clouds;
  float rate = 1.0f;
  if (np_plan_needs(in->plan, NP_STAGE_APPROXIMATION)) {
    np_integrator_settings settings;
    np_integrator_choice_make(&in->scene->render, in->plan->request.desc.multiple_scattering, &settings);
    return np_approximation_rows_v1[settings.multiple_scattering].get_fade(&settings.approximation);
  }
  if (!np_plan_needs(in->plan, NP_STAGE_ORDINATES)) return rate;
  for (unsigned v = 0; v < clouds->count; v++)
    rate = fminf(rate, np_scattering_compute_least_scale(&clouds->at[v].phase, np_spectrum_grey(1.0f)));
  return fmaxf(rate, 0.05f);
}

/* Tolerance where only paths use the cache, whose mean no error of it changes. */
static const float traced_tolerance = 0.003f;

/* The world of a light in the first packet serves all: no part of the cache depends on wavelength. */
static neph_result get_sun_optical_depth_key(const np_sun_optical_depth_inputs *in, void **out_key) {
  np_depth_key *key = *out_key = np_alloc(in->context, 1, sizeof *key);
  if (!key) return NEPH_ERROR_OUT_OF_MEMORY;
  np_sun_optical_depth_desc desc = NP_SUN_OPTICAL_DEPTH_DESC_DEFAULT;
  desc.rate = compute_sun_rate(in);
  /* A small tolerance: nodes are cheap, and an error in a node affects all rays near it. */
  const bool is_traced = np_request_traces_air(&in->plan->request);
  desc.tolerance = is_traced ? traced_tolerance : (float)(0.2 * in->scene->render.tolerance);
  return np_depth_key_make(in->context, in->world, &desc, key);
}

static neph_result adapt_depth(const np_sun_optical_depth_inputs *in, void *cached, const void *cached_key,
                               char *out_reason) {
  (void)cached;
  np_depth_key_compare(cached_key, in->key, out_reason, NP_REASON_SIZE);
  return NEPH_OK;
}

static neph_result make_sun_optical_depth(const np_sun_optical_depth_inputs *in, np_sun_optical_depth **out) {
  const np_depth_key *key = in->key;
  if (np_spectrum_is_zero(in->world->sun_irradiance)) return NEPH_OK; /* a group without it */
  np_sun_optical_depth *cache = np_alloc(in->context, 1, sizeof *cache);
  if (!cache) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_sun_optical_depth_build(in->context, in->world, &key->desc, in->monitor, cache);
  if (result) np_alloc_free(in->context, cache);
  if (!result) cache->error = NP_SUN_STEEP_TOLERANCES * key->desc.tolerance;
  *out = result ? NULL : cache;
  return result;
}

static void destroy_depth(void *result) {
  np_sun_optical_depth *cache = result;
  if (!cache) return;
  neph_context *context = cache->context;
  np_sun_optical_depth_clear(cache);
  np_alloc_free(context, cache);
}

static bool add_depth_key(const np_sun_optical_depth_inputs *in, np_hash *key) {
  const np_depth_key *own = in->key;
  np_hash_add_text(key, own->clouds);
  NP_HASH_ADD(key, own->to_sun);
  NP_HASH_ADD(key, own->desc.rate);
  NP_HASH_ADD(key, own->desc.tolerance);
  NP_HASH_ADD(key, own->desc.bytes_max);
  return !np_spectrum_is_zero(in->world->sun_irradiance);
}

static void save_depth(const np_sun_optical_depth_inputs *in, const np_sun_optical_depth *cache,
                       np_cache_entry *entry) {
  (void)in;
  np_sun_optical_depth_save(cache, entry);
}

static neph_result load_depth(const np_sun_optical_depth_inputs *in, np_cache_entry *entry,
                              np_sun_optical_depth **out) {
  np_sun_optical_depth *cache = np_alloc(in->context, 1, sizeof *cache);
  if (!cache) return NEPH_ERROR_OUT_OF_MEMORY;
  const np_depth_key *key = in->key;
  const bool is_loaded = np_sun_optical_depth_load(in->context, in->world, entry, cache);
  if (is_loaded) cache->error = NP_SUN_STEEP_TOLERANCES * key->desc.tolerance;
  if (!is_loaded) np_alloc_free(in->context, cache);
  *out = is_loaded ? cache : NULL;
  return NEPH_OK;
}

NP_STAGE_DISK(sun_optical_depth, task->caches->sun_optical_depth, "depth", true, add_depth_key, save_depth, load_depth,
              NULL);

NP_STAGE_REUSE(sun_optical_depth, task->caches->sun_optical_depth, NP_PER_LIGHT, false, adapt_depth, destroy_depth,
               &sun_optical_depth_disk);

/* ---- Shadows in the air ---- */

/* Direction of a film position; outside of the picture its angles are extrapolated. */
static np_vec3 get_film_direction(const void *camera, float x, float y) {
  np_vec3 direction;
  (void)np_camera_get_direction(camera, x, y, &direction);
  return direction;
}

/* Rays through every so many pixels of the picture; those about the crop, and two more, of which neighbours and
 * pixels' filters take part. */
static np_air_rays make_air_rays(const np_camera *c, const np_plan *plan) {
  const double spacing = plan->decisions.air_ray_spacing;
  const float step = 2.0f * c->tan_half_width * (float)spacing / (float)c->width;
  np_air_rays rays = {.origin = c->origin,
                      .forward = np_vec3_scale(c->back, -1.0f),
                      .right = np_vec3_scale(c->right, step),
                      .down = np_vec3_scale(c->up, -step)};
  if (c->kind != NEPH_CAMERA_PERSPECTIVE)
    rays.film = (np_air_film){.camera = c, .get_direction = get_film_direction, .spacing = (float)spacing};
  const unsigned whole[2] = {c->width, c->height};
  const float aside[2] = {c->shift[0], -c->shift[1]};
  for (int k = 0; k < 2; k++) {
    rays.middle[k] = 0.5f * (float)whole[k] / (float)spacing;
    if (aside[k] != 0.0f) rays.middle[k] -= aside[k] / step;
    rays.begin[k] = (int32_t)floor((double)plan->request.window_min[k] / spacing) - 2;
    rays.end[k] = (int32_t)floor((double)plan->request.window_max[k] / spacing) + 4;
    rays.whole_end[k] = (int32_t)(whole[k] / spacing) + 1;
  }
  return rays;
}

/* Extends a box to the horizon of clouds that repeat without end. */
static void extend(np_dvec3 *low, np_dvec3 *high) {
  static const double horizon_m = 3e5;
  low->x = low->y = -horizon_m;
  high->x = high->y = horizon_m;
}

static np_air_casters get_casters(const np_air_shadows_inputs *in) {
  np_air_casters casters = {.count = 0};
  if (in->clouds->volume_count > 0) {
    casters.low[casters.count] = in->clouds->low;
    casters.high[casters.count] = in->clouds->high;
    for (unsigned i = 0; i < in->clouds->count; i++)
      if (np_cloud_parts_are_endless(&in->clouds->at[i]))
        extend(&casters.low[casters.count], &casters.high[casters.count]);
    const bool is_fire = in->plan->decisions.emission_count > 0;
    const double reach_m = np_lit_air_get_reach(in->clouds->high.z, is_fire);
    casters.is_lit_by_fire = is_fire;
    casters.has_lit = in->cloud_light;
    casters.lit_low = np_dvec3_subtract(casters.low[0], np_dvec3_make(reach_m, reach_m, INFINITY));
    casters.lit_high = np_dvec3_add(casters.high[0], np_dvec3_make(reach_m, reach_m, reach_m));
    casters.count++;
  }
  if (in->terrain) {
    np_terrain_get_bounds(in->terrain, &casters.low[casters.count], &casters.high[casters.count]);
    casters.count++;
  }
  return casters;
}

static neph_result build_visibility(const np_air_shadows_inputs *in, np_air_visibility *out) {
  if (!in->camera_sky) return NEPH_OK;
  const np_air_rays rays = make_air_rays(in->camera, in->plan);
  const np_air_casters casters = get_casters(in);
  const np_sun_optical_depths depths = np_stage_get_depths(in->world, in->depth);
  return np_air_visibility_build(in->context, in->world, &depths, &rays, &casters, in->monitor, out);
}

NP_STAGE_BUILD(visibility, air_shadows, task->caches->air_visibility)

void np_stage_clear_visibility(const np_stage_task *task) { np_air_visibility_clear(&task->caches->air_visibility); }

/* Distance from the eye beyond which hills leave the air its light. */
static const double hills_reach_m = 20e3;

static neph_result light_air_among_hills(const np_air_shadows_inputs *in, np_lit_air *out) {
  *out = (np_lit_air){.points = NULL};
  if (!in->terrain || !in->world->atmosphere) return NEPH_OK;
  const np_sun_optical_depths depths = np_stage_get_depths(in->world, in->depth);
  const np_hill_reach reach = {in->camera->origin, hills_reach_m, in->cloud_light, np_stage_has_rough_light(&in->part)};
  return np_lit_air_build_among_hills(in->context, in->world, &depths, &reach, in->monitor, out);
}

static neph_result build_air_shadow(const np_air_shadows_inputs *in, np_air_shadow *out) {
  if (!in->camera_sky || !in->visibility->seen) return NEPH_OK;
  np_lit_air among_hills;
  neph_result result = light_air_among_hills(in, &among_hills);
  if (!result)
    result = np_air_shadow_build(in->visibility, in->world, np_cloud_light_get_air(in->cloud_light),
                                 among_hills.points ? &among_hills : NULL, in->monitor, out);
  if (among_hills.points) np_lit_air_clear(&among_hills);
  return result;
}

NP_STAGE_BUILD(air_shadow, air_shadows, task->light->air_shadow)

void np_stage_clear_air_shadow(const np_stage_task *task) { np_air_shadow_clear(&task->light->air_shadow); }

/* ---- Approximation ---- */

/* Builds the gains. Optical depths do not depend on wavelength: the first packet computes them for all. */
static neph_result build_approximation(const np_approximation_inputs *in, np_cloud_gain **out) {
  const np_frame_clouds *clouds = in->clouds;
  const neph_multiple_scattering method = in->plan->request.desc.multiple_scattering;
  if (!isinf(in->scene->render.approximation.gain) || clouds->volume_count == 0) return NEPH_OK;
  np_cloud_gain *gains = *out = np_alloc(in->context, clouds->volume_count, sizeof *gains);
  if (!gains) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; i < clouds->volume_count; i++) {
    const np_instance *cloud = &in->placed->at[i], *whole = &clouds->at[cloud->number].placed;
    const np_cloud_gain *first = in->first_gains;
    np_cloud_gain_fill(method, cloud, first ? first[i].depth : np_cloud_gain_compute_depth(whole), &gains[i]);
  }
  return NEPH_OK;
}

NP_STAGE_BUILD(approximation, approximation, task->packet->gains)

void np_stage_clear_approximation(const np_stage_task *task) {
  np_alloc_free(task->in.part.context, task->packet->gains);
  task->packet->gains = NULL;
}

/* ---- The integrator's lighting ---- */

static neph_result build_lighting(const np_lighting_inputs *in, np_reflection *out_reflection, np_lighting *out) {
  *out = (np_lighting){
      .sun_optical_depths = np_stage_get_depths(in->world, in->depth),
      .scattering = in->scattering,
      .viewer_light = in->viewer_light,
      .ground_light = np_cloud_light_get_ground(in->cloud_light),
      .relief_light = in->relief_light,
      .air_shadow = in->air_shadow->visible_fraction ? in->air_shadow : NULL,
      .sky_guide = in->sky_guide->rate > 0.0f ? in->sky_guide : NULL,
      .gains = in->gains,
  };
  if (!in->world->water) return NEPH_OK;
  /* Shadows in the air are known along the camera's rays alone. */
  *out_reflection = (np_reflection){*in->world, *out};
  out_reflection->world.camera_sky = in->water_sky;
  out_reflection->world.has_parallel_view = false;
  out_reflection->lighting.air_shadow = NULL;
  out_reflection->lighting.has_shade_by_places = out->air_shadow != NULL;
  out_reflection->lighting.viewer_light = NULL;
  out->reflection = out_reflection;
  return NEPH_OK;
}

neph_result np_stage_build_lighting(const np_stage_task *task) {
  return build_lighting(&task->in.lighting, &task->light->reflection, &task->light->lighting);
}

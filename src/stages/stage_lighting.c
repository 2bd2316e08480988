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

static np_disk make_sun_disk(const np_stage_part *in) {
  const np_scene_sun *sun = &in->scene->sun;
  const np_vec3 direction = np_dvec3_to_float(in->made->places.to_sun);
  const np_spectrum irradiance = np_packet_convert(in->packet, NP_BAND_SUN, sun->irradiance_w_m2_nm);
  if (!sun->has_limb_darkening) return np_disk_make(direction, sun->angular_radius_rad, irradiance);
  return np_disk_make_sun(direction, sun->angular_radius_rad, irradiance, in->packet->bands.nm);
}

/* Light beyond the air, and what of it is uniform. */
static void add_surroundings(const np_stage_part *in, np_world *world) {
  const np_scene_environment *environment = &in->scene->environment;
  world->night = &in->packet->night;
  world->environment_radiance = np_packet_convert(in->packet, NP_BAND_LINEAR, environment->radiance_w_m2_sr_nm);
  world->is_environment_upper_only = environment->is_upper_only;
}

static const np_emission *get_emission(const np_emission *emission) {
  return emission->emitter_count > 0 ? emission : NULL;
}

/* Light of no one light is in the world of the first: it must be added once. */
static void add_common(const np_stage_part *in, np_world *world) {
  world->disk = make_sun_disk(in);
  world->has_no_disks = !in->scene->output.has_disks && !in->plan->request.is_sky_alone;
  world->emission = get_emission(&in->packet->emission);
  add_surroundings(in, world);
}

/* The same where each group has a world. */
static void add_group(const np_stage_part *in, np_world *world) {
  const np_packet_light *light = in->light;
  const np_packet *packet = in->packet;
  if (light->index == 0) world->disk = make_sun_disk(in);
  world->has_no_disks = !in->scene->output.has_disks;
  if (light->group == NP_LIGHT_GROUP_SUN) world->sun_scope = NP_SUN_BEAM;
  if (light->group == NP_LIGHT_GROUP_SKY) {
    world->sun_scope = NP_SUN_SKY;
    add_surroundings(in, world);
  }
  if (light->group >= NP_LIGHT_GROUP_EMISSION && packet->emission_groups)
    world->emission = get_emission(&packet->emission_groups[light->group - NP_LIGHT_GROUP_EMISSION]);
}

/* The clouds that hold anything, with the albedo of a packet. */
neph_result np_stage_build_instances(const np_stage_part *in) {
  const np_assembly *a = in->made;
  np_instance *placed = in->packet->placed = np_alloc(a->context, a->volume_count, sizeof *placed);
  if (!placed) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; i < a->cloud_count; i++)
    if (a->clouds[i].volume) placed += np_packet_place(in->packet, in->scene, a, i, placed);
  return np_copies_build_places(a, in->packet);
}

void np_stage_clear_instances(const np_stage_part *in) {
  np_places_clear(in->made->context, &in->packet->places);
  np_alloc_free(in->made->context, in->packet->placed);
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
static void set_basis(const np_stage_part *in, np_spectrum out_basis[NP_BAND_COUNT]) {
  static const double grey = 0.5, little = 0.25;
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    double tinted[NP_BAND_COUNT] = {grey, grey, grey};
    tinted[b] += little;
    const np_spectrum own = np_packet_fit_albedo(in->packet, in->made, tinted);
    out_basis[b] = np_spectrum_scale(np_spectrum_subtract(own, np_spectrum_grey((float)grey)), (float)(1.0 / little));
  }
  if (in->made->color.is_fitted) round_basis(out_basis);
}

/* Planet, terrain and water, the same under each light. */
static void add_ground(const np_stage_part *in, np_packet_light *out) {
  const np_packet *packet = in->packet;
  const neph_scene *scene = in->scene;
  np_world *world = &out->world;
  double albedo[NP_BAND_COUNT];
  np_stage_get_ground_albedo(in, albedo);
  world->ground_albedo = np_packet_convert_albedo(packet, in->made, albedo);
  world->terrain = in->made->terrain;
  if (world->terrain) {
    np_terrain_get_bounds(world->terrain, &world->terrain_min, &world->terrain_max);
    world->terrain_albedo = np_packet_convert_albedo(packet, in->made, np_terrain_get_mean_albedo(world->terrain));
  }
  set_basis(in, world->terrain_basis);
  if (!np_scene_has_water(scene)) return;
  out->water = np_water_make(scene->water.level_m, scene->water.wind_m_s,
                             np_packet_convert_albedo(packet, in->made, scene->water.albedo));
  world->water = &out->water;
}

neph_result np_stage_build_world(const np_stage_part *in) {
  np_packet_light *out = in->light;
  const np_assembly *a = in->made;
  const np_packet *packet = in->packet;
  const neph_scene *scene = in->scene;
  out->world = (np_world){
      .clouds.count = a->volume_count,
      .clouds.at = packet->placed,
      .clouds.places = packet->places.count > 0 ? &packet->places : NULL,
      .to_sun = np_dvec3_to_float(out->direction),
      .sun_angular_radius_rad = (float)out->angular_radius_rad,
      .sun_irradiance = out->irradiance,
      .atmosphere = packet->atmosphere,
      .camera_sky = out->camera_sky,
      .has_parallel_view = !np_camera_has_centre(&a->camera),
      .cloud_sky = out->cloud_sky ? out->cloud_sky : out->water_sky,
      .has_planet = scene->environment.has_planet,
      .planet_radius_m = scene->atmosphere.planet_radius_m,
  };
  add_ground(in, out);
  if (a->has_light_groups)
    add_group(in, &out->world);
  else if (out->index == 0)
    add_common(in, &out->world);
  return NEPH_OK;
}

/* ---- Sky guide ---- */

/* True if the light around the clouds is known: with traced air at dusk, and where paths are guided. */
neph_result np_stage_build_sky_guide(const np_stage_part *in) {
  np_packet_light *out = in->light;
  if (!out->cloud_sky) return NEPH_OK;
  const float cost = np_request_traces_air(&in->plan->request) ? np_sky_guide_traced_cost : 1.0f;
  const np_sun_optical_depths depths = {.clouds = &out->world.clouds};
  const np_sun_optical_depth_source source = np_sun_optical_depths_get_source(&depths);
  np_sky_guide_build(&out->world, &source, np_assembly_get_clouds_middle(in->made), cost, &out->sky_guide);
  return NEPH_OK;
}

/* ---- Sun optical depth ---- */

/* The world of a light in the first packet: what does not depend on wavelength is the same in all. */
static const np_packet_light *get_first(const np_stage_part *in) {
  return &in->made->packets[0].lights[in->caches - in->made->lights];
}

np_sun_optical_depths np_stage_get_depths(const np_stage_part *in, const np_packet_light *light) {
  return (np_sun_optical_depths){&light->world.clouds, in->made->lights[light->index].sun_optical_depth};
}

/* The least rate at which depths count: in the scaled medium, or in the slowest octave. */
static float compute_sun_rate(const np_stage_part *in, const np_instances *clouds) {
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

static neph_result get_sun_optical_depth_key(const np_stage_part *in, void **out_key) {
  const np_world *world = &get_first(in)->world;
  np_depth_key *key = *out_key = np_alloc(in->made->context, 1, sizeof *key);
  if (!key) return NEPH_ERROR_OUT_OF_MEMORY;
  np_sun_optical_depth_desc desc = NP_SUN_OPTICAL_DEPTH_DESC_DEFAULT;
  desc.rate = compute_sun_rate(in, &world->clouds);
  /* Nodes are cheap, and a depth that is wrong is so for all rays of a neighbourhood, as steps are not. */
  desc.tolerance = (float)(0.2 * in->scene->render.tolerance);
  return np_depth_key_make(in->made->context, world, &desc, key);
}

static neph_result adapt_depth(const np_stage_part *in, void *cached, const void *cached_key, char *out_reason) {
  (void)cached;
  np_depth_key_compare(cached_key, in->key, out_reason, NP_REASON_SIZE);
  return NEPH_OK;
}

static neph_result make_sun_optical_depth(const np_stage_part *in) {
  neph_context *context = in->made->context;
  const np_depth_key *key = in->key;
  if (np_spectrum_is_zero(get_first(in)->irradiance)) return NEPH_OK; /* a group without it */
  np_sun_optical_depth *cache = in->caches->sun_optical_depth = np_alloc(context, 1, sizeof *cache);
  if (!cache) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = np_sun_optical_depth_build(context, &get_first(in)->world, &key->desc, in->monitor, cache);
  if (!result) return NEPH_OK;
  np_alloc_free(context, cache);
  in->caches->sun_optical_depth = NULL;
  return result;
}

static void destroy_depth(void *result) {
  np_sun_optical_depth *cache = result;
  if (!cache) return;
  neph_context *context = cache->context;
  np_sun_optical_depth_clear(cache);
  np_alloc_free(context, cache);
}

static bool add_depth_key(const np_stage_part *in, np_hash *key) {
  const np_depth_key *own = in->key;
  np_hash_add_text(key, own->clouds);
  NP_HASH_ADD(key, own->to_sun);
  NP_HASH_ADD(key, own->desc.rate);
  NP_HASH_ADD(key, own->desc.tolerance);
  NP_HASH_ADD(key, own->desc.bytes_max);
  return !np_spectrum_is_zero(get_first(in)->irradiance);
}

static void save_depth(const np_stage_part *in, np_cache_entry *entry) {
  np_sun_optical_depth_save(in->caches->sun_optical_depth, entry);
}

static neph_result load_depth(const np_stage_part *in, np_cache_entry *entry) {
  neph_context *context = in->made->context;
  np_sun_optical_depth *cache = np_alloc(context, 1, sizeof *cache);
  if (!cache) return NEPH_ERROR_OUT_OF_MEMORY;
  if (np_sun_optical_depth_load(context, &get_first(in)->world, entry, cache))
    in->caches->sun_optical_depth = cache;
  else
    np_alloc_free(context, cache);
  return NEPH_OK;
}

static const np_stage_disk depth_disk = {"depth", true, add_depth_key, save_depth, load_depth, NULL};

NP_STAGE_REUSE(sun_optical_depth, in->caches->sun_optical_depth, NP_PER_LIGHT, false, adapt_depth, destroy_depth,
               &depth_disk);

/* ---- Shadows in the air ---- */

/* Beyond the rim of a picture its angles go on. */
static np_vec3 get_film_direction(const void *camera, float x, float y) {
  np_vec3 direction;
  (void)np_camera_get_direction(camera, x, y, &direction);
  return direction;
}

/* Rays through every so many pixels of the picture; those about the crop, and two more, of which neighbours and
 * pixels' filters take part. */
static np_air_rays make_air_rays(const np_camera *c, const np_plan *plan) {
  const unsigned spacing = plan->decisions.air_ray_spacing;
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

static np_air_casters get_casters(const np_assembly *a) {
  np_air_casters casters = {.count = 0};
  if (a->volume_count > 0) {
    casters.low[casters.count] = a->clouds_min;
    casters.high[casters.count++] = a->clouds_max;
  }
  if (a->terrain) {
    np_terrain_get_bounds(a->terrain, &casters.low[casters.count], &casters.high[casters.count]);
    casters.count++;
  }
  return casters;
}

neph_result np_stage_build_visibility(const np_stage_part *in) {
  np_light_caches *out = in->caches;
  const np_assembly *a = in->made;
  const np_packet_light *first = get_first(in);
  if (!first->camera_sky) return NEPH_OK;
  const np_air_rays rays = make_air_rays(&a->camera, in->plan);
  const np_air_casters casters = get_casters(a);
  const np_sun_optical_depths depths = np_stage_get_depths(in, first);
  return np_air_visibility_build(a->context, &first->world, &depths, &rays, &casters, in->monitor,
                                 &out->air_visibility);
}

void np_stage_clear_visibility(const np_stage_part *in) { np_air_visibility_clear(&in->caches->air_visibility); }

neph_result np_stage_build_air_shadow(const np_stage_part *in) {
  np_packet_light *out = in->light;
  const np_air_visibility *visibility = &in->made->lights[out->index].air_visibility;
  if (!out->camera_sky || !visibility->seen) return NEPH_OK;
  return np_air_shadow_build(visibility, &out->world, out->ground_light, in->monitor, &out->air_shadow);
}

void np_stage_clear_air_shadow(const np_stage_part *in) { np_air_shadow_clear(&in->light->air_shadow); }

/* ---- Light between hills ---- */

neph_result np_stage_build_relief_light(const np_stage_part *in) {
  np_packet_light *out = in->light;
  const np_relief_light_desc desc = {&out->world, np_stage_get_depths(in, out), out->ground_light};
  return np_relief_light_build(in->made->context, &desc, &out->relief_light);
}

void np_stage_clear_relief_light(const np_stage_part *in) { np_relief_light_clear(&in->light->relief_light); }

/* ---- Approximation ---- */

/* The depth of a cloud does not depend on wavelength: the first packet knows it for all. */
neph_result np_stage_build_approximation(const np_stage_part *in) {
  const np_assembly *a = in->made;
  np_packet *out = in->packet;
  const neph_multiple_scattering method = in->plan->request.desc.multiple_scattering;
  if (!isinf(in->scene->render.approximation.gain) || a->volume_count == 0) return NEPH_OK;
  out->gains = np_alloc(a->context, a->volume_count, sizeof *out->gains);
  if (!out->gains) return NEPH_ERROR_OUT_OF_MEMORY;
  const np_cloud_gain *first = out == a->packets ? NULL : a->packets[0].gains;
  for (unsigned i = 0; i < a->volume_count; i++) {
    const np_instance *cloud = &out->placed[i], *whole = &a->clouds[cloud->number].placed;
    np_cloud_gain_fill(method, cloud, first ? first[i].depth : np_cloud_gain_compute_depth(whole), &out->gains[i]);
  }
  return NEPH_OK;
}

void np_stage_clear_approximation(const np_stage_part *in) {
  np_alloc_free(in->made->context, in->packet->gains);
  in->packet->gains = NULL;
}

/* ---- The integrator's lighting ---- */

neph_result np_stage_build_lighting(const np_stage_part *in) {
  np_packet_light *out = in->light;
  out->lighting = (np_lighting){
      .sun_optical_depths = np_stage_get_depths(in, out),
      .scattering = out->scattering,
      .viewer_light = out->viewer_light,
      .ground_light = out->ground_light,
      .relief_light = out->relief_light.points ? &out->relief_light : NULL,
      .air_shadow = out->air_shadow.visible_fraction ? &out->air_shadow : NULL,
      .sky_guide = out->sky_guide.rate > 0.0f ? &out->sky_guide : NULL,
      .gains = in->packet->gains,
  };
  if (!out->world.water) return NEPH_OK;
  /* Shadows in the air are known along the camera's rays alone. */
  out->reflection = (np_reflection){out->world, out->lighting};
  out->reflection.world.camera_sky = out->water_sky;
  out->reflection.world.has_parallel_view = false;
  out->reflection.lighting.air_shadow = NULL;
  out->reflection.lighting.viewer_light = NULL;
  out->lighting.reflection = &out->reflection;
  return NEPH_OK;
}

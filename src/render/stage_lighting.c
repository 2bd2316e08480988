/* SPDX-License-Identifier: Apache-2.0 */
/* Worlds, and the caches of light that are built of them. */
#include "core/units.h"
#include "integrate/approximation.h"
#include "render/integrator_choice.h"
#include "render/plan_cells.h"
#include "render/stage_builders.h"

/* ---- World ---- */

static np_disk make_sun_disk(const np_stage_inputs *in, const np_packet *packet) {
  const np_scene_sun *sun = &in->scene->sun;
  const np_vec3 direction = np_dvec3_to_float(in->made->places.to_sun);
  const np_spectrum irradiance = np_packet_convert(packet, NP_BAND_SUN, sun->irradiance_w_m2_nm);
  if (!sun->has_limb_darkening) return np_disk_make(direction, sun->angular_radius_rad, irradiance);
  return np_disk_make_sun(direction, sun->angular_radius_rad, irradiance, packet->bands.nm);
}

/* What is not of any light is in the world of the first: it must be added once. */
static void add_common(const np_stage_inputs *in, const np_packet *packet, np_world *world) {
  const np_scene_environment *environment = &in->scene->environment;
  world->disk = make_sun_disk(in, packet);
  world->night = &packet->night;
  world->emission = packet->emission.emitter_count > 0 ? &packet->emission : NULL;
  world->environment_radiance = np_packet_convert(packet, NP_BAND_LINEAR, environment->radiance_w_m2_sr_nm);
  world->is_environment_upper_only = environment->is_upper_only;
}

neph_result np_stage_build_world(const np_stage_inputs *in, const np_packet *packet, np_packet_light *out) {
  const np_assembly *a = in->made;
  const neph_scene *scene = in->scene;
  out->world = (np_world){
      .clouds.count = a->volume_count,
      .clouds.at = packet->placed,
      .to_sun = np_dvec3_to_float(out->direction),
      .sun_angular_radius_rad = (float)out->angular_radius_rad,
      .sun_irradiance = out->irradiance,
      .atmosphere = packet->atmosphere,
      .camera_sky = out->camera_sky,
      .cloud_sky = out->cloud_sky,
      .has_planet = scene->environment.has_planet,
      .planet_radius_m = scene->atmosphere.planet_radius_m,
      .terrain = a->terrain,
      .terrain_albedo = np_packet_convert(packet, NP_BAND_LINEAR, scene->terrain.desc.ground_albedo),
      .ground_albedo = np_packet_convert(packet, NP_BAND_LINEAR, np_scene_get_ground_albedo(scene)),
  };
  if (a->terrain) np_terrain_get_bounds(a->terrain, &out->world.terrain_min, &out->world.terrain_max);
  if (out->index == 0) add_common(in, packet, &out->world);
  return NEPH_OK;
}

void np_stage_clear_world(np_assembly *assembly, const np_packet *packet, np_packet_light *light) {
  (void)assembly, (void)packet;
  light->world = (np_world){0};
}

/* ---- Sky guide ---- */

/* Where the light around the clouds is known: that of air which is traced is, at dusk, and where paths are guided. */
neph_result np_stage_build_sky_guide(const np_stage_inputs *in, const np_packet *packet, np_packet_light *out) {
  (void)packet;
  if (!out->cloud_sky) return NEPH_OK;
  const float cost = np_plan_traces_air(in->plan) ? np_sky_guide_traced_cost : 1.0f;
  const np_sun_depths depths = {.clouds = &out->world.clouds};
  const np_sun_optical_depth_source source = np_sun_depths_get_source(&depths);
  np_sky_guide_build(&out->world, &source, np_assembly_get_clouds_middle(in->made), cost, &out->sky_guide);
  return NEPH_OK;
}

void np_stage_clear_sky_guide(np_assembly *assembly, const np_packet *packet, np_packet_light *light) {
  (void)assembly, (void)packet;
  light->sky_guide = (np_sky_guide){0};
}

/* ---- Sun optical depth ---- */

static np_light_role get_light_role(bool is_moon) { return is_moon ? NP_LIGHT_OF_MOON : NP_LIGHT_OF_SUN; }

/* The world of a light in the first packet: what does not depend on wavelength is the same in all. */
static const np_packet_light *get_first(const np_stage_inputs *in, unsigned light) {
  return &in->made->packets[0].lights[light];
}

static np_sun_depths get_depths(const np_stage_inputs *in, const np_packet_light *light) {
  const bool has_cache = np_plan_needs(in->plan, NP_STAGE_SUN_OPTICAL_DEPTH);
  return (np_sun_depths){&light->world.clouds, has_cache ? &in->made->lights[light->index].sun_optical_depth : NULL};
}

/* The least rate at which depths count: in the scaled medium, or in the slowest octave. */
static float compute_sun_rate(const np_stage_inputs *in, const np_instances *clouds) {
  float rate = 1.0f;
  if (np_plan_needs(in->plan, NP_STAGE_APPROXIMATION)) {
    np_integrator_settings settings;
    np_integrator_choice_make(&in->scene->render, in->plan->desc.multiple_scattering, &settings);
    return np_approximation_rows_v1[settings.multiple_scattering].get_fade(&settings.approximation);
  }
  if (!np_plan_needs(in->plan, NP_STAGE_ORDINATES)) return rate;
  for (unsigned v = 0; v < clouds->count; v++)
    rate = fminf(rate, np_scattering_compute_least_scale(&clouds->at[v].phase, np_spectrum_grey(1.0f)));
  return fmaxf(rate, 0.05f);
}

neph_result np_stage_build_sun_optical_depth(const np_stage_inputs *in, unsigned light, np_light_caches *out) {
  const np_world *world = &get_first(in, light)->world;
  np_sun_optical_depth_desc desc = NP_SUN_OPTICAL_DEPTH_DESC_DEFAULT;
  desc.rate = compute_sun_rate(in, &world->clouds);
  /* Nodes are cheap, and a depth that is wrong is so for all rays of a neighbourhood, as steps are not. */
  desc.tolerance = (float)(0.2 * in->scene->render.tolerance);
  return np_light_store_take_depths(in->made->context, &in->stores->lights, get_light_role(out->is_moon), world, &desc,
                                    in->monitor, &out->sun_optical_depth);
}

void np_stage_clear_sun_optical_depth(np_assembly *a, np_light_caches *light) {
  np_light_store_give_depths(&a->stores->lights, get_light_role(light->is_moon), &light->sun_optical_depth);
}

/* ---- Multiple scattering ---- */

/* The camera, on a lattice of an eighth of the clouds' box, so that a solution outlives some steps of it. */
static np_dvec3 get_viewer(const np_assembly *a) {
  const double step = 0.125 * np_dvec3_length(np_dvec3_subtract(a->clouds_max, a->clouds_min));
  const np_dvec3 at = a->camera.origin;
  return step > 0.0 ? np_dvec3_scale(np_dvec3_make(round(at.x / step), round(at.y / step), round(at.z / step)), step)
                    : at;
}

neph_result np_stage_build_ordinates(const np_stage_inputs *in, const np_packet *packet, np_packet_light *out) {
  const np_assembly *a = in->made;
  np_scattering_desc desc;
  np_plan_choose_cells(in->plan, in->scene, &desc);
  desc.cells.bounds_min = a->clouds_min;
  desc.cells.bounds_max = a->clouds_max;
  desc.cells.has_viewer = true;
  desc.cells.viewer = get_viewer(a);
  desc.has_importance = in->plan->desc.integrator == NEPH_INTEGRATOR_PATH;
  desc.seconds_max = np_schedule_take_solve(in->schedule, in->monitor);
  const np_sun_depths depths = get_depths(in, out);
  const np_sun_optical_depth_source source = np_sun_depths_get_source(&depths);
  return np_light_store_take(a->context, &in->stores->lights, np_packet_get_index(a, packet),
                             get_light_role(out->is_moon), &out->world, &source, &desc, in->monitor, &out->scattering);
}

void np_stage_clear_ordinates(np_assembly *a, const np_packet *packet, np_packet_light *light) {
  np_light_store_give(&a->stores->lights, np_packet_get_index(a, packet), get_light_role(light->is_moon),
                      light->scattering);
  light->scattering = NULL;
}

neph_result np_stage_build_viewer_light(const np_stage_inputs *in, const np_packet *packet, np_packet_light *out) {
  (void)packet;
  const np_assembly *a = in->made;
  return np_viewer_light_build(a->context, out->scattering, a->camera.origin, in->monitor, &out->viewer_light);
}

void np_stage_clear_viewer_light(np_assembly *assembly, const np_packet *packet, np_packet_light *light) {
  (void)assembly, (void)packet;
  np_viewer_light_clear(&light->viewer_light);
}

/* ---- Ground ---- */

neph_result np_stage_build_ground_clouds(const np_stage_inputs *in, const np_packet *packet, np_packet_light *out) {
  (void)packet;
  const np_assembly *a = in->made;
  const np_sun_depths depths = get_depths(in, out);
  const np_ground_light_desc desc = {.world = &out->world,
                                     .depths = &depths,
                                     .scattering = out->scattering,
                                     .bounds_min = a->clouds_min,
                                     .bounds_max = a->clouds_max};
  return np_ground_light_build(a->context, &desc, in->monitor, &out->ground_light);
}

void np_stage_clear_ground_clouds(np_assembly *assembly, const np_packet *packet, np_packet_light *light) {
  (void)assembly, (void)packet;
  np_ground_light_clear(&light->ground_light);
}

/* ---- Shadows in the air ---- */

/* Rays through every so many pixels of the picture; those about the crop, and two more, of which neighbours and
 * pixels' filters take part. */
static np_air_rays make_air_rays(const np_camera *c, const np_plan *plan) {
  const neph_render_desc *desc = &plan->desc;
  const unsigned spacing = plan->air_ray_spacing;
  const float step = 2.0f * c->tan_half_width * (float)spacing / (float)c->width;
  np_air_rays rays = {.origin = c->origin,
                      .forward = np_vec3_scale(c->back, -1.0f),
                      .right = np_vec3_scale(c->right, step),
                      .down = np_vec3_scale(c->up, -step)};
  const unsigned whole[2] = {c->width, c->height};
  for (int k = 0; k < 2; k++) {
    rays.middle[k] = 0.5f * (float)whole[k] / (float)spacing;
    rays.begin[k] = (int32_t)(desc->crop_min[k] / spacing) - 2;
    rays.end[k] = (int32_t)(desc->crop_max[k] / spacing) + 4;
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

neph_result np_stage_build_visibility(const np_stage_inputs *in, unsigned light, np_light_caches *out) {
  const np_assembly *a = in->made;
  const np_packet_light *first = get_first(in, light);
  if (!first->camera_sky) return NEPH_OK;
  const np_air_rays rays = make_air_rays(&a->camera, in->plan);
  const np_air_casters casters = get_casters(a);
  const np_sun_depths depths = get_depths(in, first);
  return np_air_visibility_build(a->context, &first->world, &depths, &rays, &casters, in->monitor,
                                 &out->air_visibility);
}

void np_stage_clear_visibility(np_assembly *assembly, np_light_caches *light) {
  (void)assembly;
  np_air_visibility_clear(&light->air_visibility);
}

neph_result np_stage_build_air_shadow(const np_stage_inputs *in, const np_packet *packet, np_packet_light *out) {
  (void)packet;
  const np_air_visibility *visibility = &in->made->lights[out->index].air_visibility;
  if (!out->camera_sky || !visibility->seen) return NEPH_OK;
  const np_ground_light *ground = np_plan_needs(in->plan, NP_STAGE_GROUND_CLOUDS) ? &out->ground_light : NULL;
  return np_air_shadow_build(visibility, &out->world, ground, in->monitor, &out->air_shadow);
}

void np_stage_clear_air_shadow(np_assembly *assembly, const np_packet *packet, np_packet_light *light) {
  (void)assembly, (void)packet;
  np_air_shadow_clear(&light->air_shadow);
}

/* ---- For the integrator ---- */

neph_result np_stage_build_lighting(const np_stage_inputs *in, const np_packet *packet, np_packet_light *out) {
  (void)packet;
  out->lighting = (np_lighting){
      .sun_depths = get_depths(in, out),
      .scattering = out->scattering,
      .viewer_light = np_plan_needs(in->plan, NP_STAGE_VIEWER_LIGHT) ? &out->viewer_light : NULL,
      .ground_light = np_plan_needs(in->plan, NP_STAGE_GROUND_CLOUDS) ? &out->ground_light : NULL,
      .air_shadow = out->air_shadow.kept ? &out->air_shadow : NULL,
      .sky_guide = out->sky_guide.rate > 0.0f ? &out->sky_guide : NULL,
  };
  return NEPH_OK;
}

void np_stage_clear_lighting(np_assembly *assembly, const np_packet *packet, np_packet_light *light) {
  (void)assembly, (void)packet;
  light->lighting = (np_lighting){0};
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "render/packet_lights.h"

#include <string.h>

#include "atmosphere/moon.h"
#include "core/units.h"
#include "integrate/approximation.h"
#include "render/integrator_choice.h"
#include "scene/plan_cells.h"

/* A light above the atmosphere. */
typedef struct light {
  np_dvec3 direction;
  double angular_radius_rad;
  np_spectrum irradiance;
  bool is_moon;
} light;

static bool needs(const np_plan *plan, np_stage stage) { return plan->stages[stage].is_needed; }

const double *np_packet_lights_ground_albedo(const neph_scene *scene) {
  const bool is_terrain = !scene->has_ground_albedo && scene->terrain.kind != NP_TERRAIN_NONE;
  return is_terrain ? scene->terrain.desc.ground_albedo : scene->atmosphere.ground_albedo;
}

np_spectrum np_packet_convert(const np_packet *packet, np_band_rule rule, const double reference[NP_BAND_COUNT]) {
  double values[NP_BAND_COUNT];
  np_band_set_convert(&packet->bands, rule, reference, values);
  return np_spectrum_make((float)values[0], (float)values[1], (float)values[2]);
}

/* The sun's, above the atmosphere. */
static np_spectrum get_sun_irradiance(const np_packet_lights_desc *d, const np_packet *packet) {
  return np_packet_convert(packet, NP_BAND_SUN, d->scene->sun.irradiance_w_m2_nm);
}

/* ---- Night ---- */

static np_disk make_sun(const np_packet_lights_desc *d, const np_packet *packet) {
  const np_scene_sun *sun = &d->scene->sun;
  const np_vec3 direction = np_dvec3_to_float(d->lights->to_sun);
  const np_spectrum irradiance = get_sun_irradiance(d, packet);
  if (!sun->has_limb_darkening) return np_disk_make(direction, sun->angular_radius_rad, irradiance);
  return np_disk_make_sun(direction, sun->angular_radius_rad, irradiance, packet->bands.nm);
}

static np_disk make_moon(const np_packet_lights_desc *d, const np_packet *packet, np_spectrum *out_irradiance) {
  const np_scene_moon *moon = &d->scene->moon;
  const np_spectrum sun = np_spectrum_scale(get_sun_irradiance(d, packet), (float)moon->brightness);
  const np_sphere_map *map = d->assembly->moon_map.texels ? &d->assembly->moon_map : NULL;
  return np_moon_make_disk(&d->lights->moon, sun, packet->bands.nm, moon->has_earthshine, map, out_irradiance);
}

/* Its channels are radiances in a scene's bands; what they are in the packet's is linear in them. */
static void set_map(const np_packet_lights_desc *d, const np_packet *packet, np_night *night) {
  night->map = &d->assembly->star_map;
  for (int c = 0; c < NP_BAND_COUNT; c++) {
    double channel[NP_BAND_COUNT] = {0};
    channel[c] = d->scene->stars.map_radiance;
    const np_spectrum weight = np_packet_convert(packet, NP_BAND_LINEAR, channel);
    for (int b = 0; b < NP_BAND_COUNT; b++) night->map_weight[b][c] = weight.band[b];
  }
}

/* `moon` is lit or not: its light is another matter. */
static void fill_night(const np_packet_lights_desc *d, np_disk moon, np_packet *packet) {
  np_night *night = &packet->night;
  *night = (np_night){.moon = moon, .turn = d->lights->turn};
  if (!needs(d->plan, NP_STAGE_AIRGLOW)) return;
  const np_scene_airglow *glow = &d->scene->airglow;
  night->has_airglow = glow->is_there;
  if (glow->is_there)
    night->airglow =
        np_airglow_make(glow->magnitude, d->scene->atmosphere.planet_radius_m, glow->altitude_m, packet->bands.nm);
  if (d->assembly->star_map.texels) set_map(d, packet, night);
  night->ground_irradiance = np_night_compute_irradiance(night, packet->atmosphere, np_dvec3_make(0, 0, 0));
}

static neph_result build_stars(const np_packet_lights_desc *d, np_packet *packet) {
  const np_plan *plan = d->plan;
  if (!needs(plan, NP_STAGE_STARS)) return NEPH_OK;
  const np_assembly *a = d->assembly;
  const bool is_sphere = plan->sphere_size[0] > 0;
  const np_star_field_desc desc = {.catalogue = &a->stars,
                                   .world = &packet->lights[0].world,
                                   .camera = is_sphere ? NULL : &a->camera,
                                   .width = is_sphere ? plan->sphere_size[0] : a->camera.width,
                                   .height = is_sphere ? plan->sphere_size[1] : a->camera.height,
                                   .origin = a->camera.origin,
                                   .wavelength_nm = packet->bands.nm,
                                   .twinkling = d->scene->stars.twinkling,
                                   .seed = plan->desc.seed,
                                   .frame = plan->desc.frame};
  return np_star_field_build(a->context, &desc, &packet->stars);
}

/* ---- Lights ---- */

static np_sky_role get_role(bool is_moon, bool is_cloud) {
  if (is_moon) return is_cloud ? NP_SKY_OF_CLOUDS_BY_MOON : NP_SKY_OF_CAMERA_BY_MOON;
  return is_cloud ? NP_SKY_OF_CLOUDS : NP_SKY_OF_CAMERA;
}

static void describe_sky(const light *l, np_dvec3 observer, neph_sky_desc *out_desc) {
  *out_desc = (neph_sky_desc)NEPH_SKY_DESC_DEFAULT;
  const double direction[3] = {l->direction.x, l->direction.y, l->direction.z};
  const double place[3] = {observer.x, observer.y, observer.z};
  memcpy(out_desc->sun_direction, direction, sizeof direction);
  memcpy(out_desc->observer_m, place, sizeof place);
  for (int b = 0; b < NP_BAND_COUNT; b++) out_desc->sun_irradiance_w_m2_nm[b] = (double)l->irradiance.band[b];
  out_desc->sun_angular_radius_rad = l->angular_radius_rad;
}

static neph_result build_sky(const np_packet_lights_desc *d, const np_packet *packet, const light *l, np_dvec3 observer,
                             np_sky_role role, neph_sky **out_sky) {
  neph_sky_desc desc;
  describe_sky(l, observer, &desc);
  const unsigned index = (unsigned)(packet - d->assembly->packets);
  return np_sky_store_take_sky(d->scene->skies, index, role, packet->atmosphere, &desc, d->monitor, out_sky);
}

static np_dvec3 find_clouds_middle(const np_assembly *a) {
  return np_dvec3_scale(np_dvec3_add(a->clouds_min, a->clouds_max), 0.5);
}

static neph_result build_skies(const np_packet_lights_desc *d, const np_packet *packet, const light *l,
                               np_packet_light *out) {
  const np_assembly *a = d->assembly;
  neph_result result = NEPH_OK;
  const bool has_camera_sky = needs(d->plan, NP_STAGE_CAMERA_SKY), has_cloud_sky = needs(d->plan, NP_STAGE_CLOUD_SKY);
  if (np_spectrum_is_zero(l->irradiance) || !(has_camera_sky || has_cloud_sky)) return result;
  np_schedule_begin(&d->assembly->schedule, d->monitor, NP_WORK_SKIES);
  const np_monitor_part whole = np_monitor_get_part(d->monitor);
  np_monitor_set_part(d->monitor, whole, 0.0, 0.5);
  np_monitor_set_stage(d->monitor, "building the sky");
  if (has_camera_sky) result = build_sky(d, packet, l, a->camera.origin, get_role(l->is_moon, false), &out->camera_sky);
  np_monitor_set_part(d->monitor, whole, 0.5, 1.0);
  if (!result && has_cloud_sky)
    result = build_sky(d, packet, l, find_clouds_middle(a), get_role(l->is_moon, true), &out->cloud_sky);
  return result;
}

/* What is not of any light is in the view of the first: it must be added once. */
static void fill_view(const np_packet_lights_desc *d, const np_packet *packet, const light *l, bool is_first,
                      np_packet_light *out) {
  const np_assembly *a = d->assembly;
  const neph_scene *scene = d->scene;
  out->world = (np_world){
      .clouds.count = a->volume_count,
      .clouds.at = packet->placed,
      .to_sun = np_dvec3_to_float(l->direction),
      .sun_angular_radius_rad = (float)l->angular_radius_rad,
      .sun_irradiance = l->irradiance,
      .atmosphere = packet->atmosphere,
      .camera_sky = out->camera_sky,
      .cloud_sky = out->cloud_sky,
      .has_planet = scene->environment.has_planet,
      .planet_radius_m = scene->atmosphere.planet_radius_m,
      .terrain = a->terrain,
      .terrain_albedo = np_packet_convert(packet, NP_BAND_LINEAR, scene->terrain.desc.ground_albedo),
      .ground_albedo = np_packet_convert(packet, NP_BAND_LINEAR, np_packet_lights_ground_albedo(scene)),
  };
  out->lighting = (np_lighting){.sun_depths.clouds = &out->world.clouds};
  if (a->terrain) np_terrain_get_bounds(a->terrain, &out->world.terrain_min, &out->world.terrain_max);
  if (!is_first) return;
  out->world.disk = make_sun(d, packet);
  out->world.night = &packet->night;
  out->world.emission = packet->emission.glow_count > 0 ? &packet->emission : NULL;
  out->world.environment_radiance = np_packet_convert(packet, NP_BAND_LINEAR, scene->environment.radiance_w_m2_sr_nm);
  out->world.is_environment_upper_only = scene->environment.is_upper_only;
}

/* The least rate at which depths count: in the scaled medium, or in the slowest octave. */
static float find_sun_rate(const np_packet_lights_desc *d, const np_world *world) {
  float rate = 1.0f;
  if (needs(d->plan, NP_STAGE_LOOK)) {
    np_integrator_settings settings;
    np_integrator_choice_make(&d->scene->render, d->plan->desc.multiple_scattering, &settings);
    return np_approximation_rows_v1[settings.multiple_scattering].get_fade(&settings.approximation);
  }
  if (!needs(d->plan, NP_STAGE_ORDINATES)) return rate;
  for (unsigned v = 0; v < world->clouds.count; v++)
    rate = fminf(rate, np_scattering_compute_least_scale(&world->clouds.at[v].phase, np_spectrum_grey(1.0f)));
  return fmaxf(rate, 0.05f);
}

static np_light_role get_light_role(bool is_moon) { return is_moon ? NP_LIGHT_OF_MOON : NP_LIGHT_OF_SUN; }

/* The same depths serve every packet. */
static neph_result build_sun_optical_depth(const np_packet_lights_desc *d, np_packet_light *out) {
  np_assembly *a = d->assembly;
  const np_light_role role = get_light_role(out->is_moon);
  np_sun_optical_depth *cache = &a->sun_optical_depths[role];
  if (!cache->lattices) {
    np_sun_optical_depth_desc desc = NP_SUN_OPTICAL_DEPTH_DESC_DEFAULT;
    desc.rate = find_sun_rate(d, &out->world);
    /* Nodes are cheap, and a depth that is wrong is so for all rays of a neighbourhood, as steps are not. */
    desc.tolerance = (float)(0.2 * d->scene->render.tolerance);
    np_schedule_begin(&a->schedule, d->monitor, NP_WORK_SUN_DEPTH);
    neph_result result = np_light_store_take_depths(a->context, a->lights, role, &out->world, &desc, d->monitor, cache);
    if (result) return result;
  }
  out->lighting.sun_depths.cache = cache;
  return NEPH_OK;
}

/* The camera, on a lattice of an eighth of the clouds' box, so that a solution outlives some steps of it. */
static np_dvec3 find_viewer(const np_assembly *a) {
  const double step = 0.125 * np_dvec3_length(np_dvec3_subtract(a->clouds_max, a->clouds_min));
  const np_dvec3 at = a->camera.origin;
  return step > 0.0 ? np_dvec3_scale(np_dvec3_make(round(at.x / step), round(at.y / step), round(at.z / step)), step)
                    : at;
}

static neph_result build_scattering(const np_packet_lights_desc *d, const np_packet *packet, np_packet_light *out) {
  np_assembly *a = d->assembly;
  np_scattering_desc desc;
  np_plan_choose_cells(d->plan, d->scene, &desc);
  desc.cells.bounds_min = a->clouds_min;
  desc.cells.bounds_max = a->clouds_max;
  desc.cells.has_viewer = true;
  desc.cells.viewer = find_viewer(a);
  desc.has_importance = d->plan->desc.integrator == NEPH_INTEGRATOR_PATH;
  desc.seconds_max = np_schedule_take_solve(&a->schedule, d->monitor);
  np_schedule_begin(&a->schedule, d->monitor, NP_WORK_ORDINATES);
  const np_sun_depth_source depths = np_sun_depths_get_source(&out->lighting.sun_depths);
  neph_result result =
      np_light_store_take(a->context, a->lights, (unsigned)(packet - a->packets), get_light_role(out->is_moon),
                          &out->world, &depths, &desc, d->monitor, &out->scattering);
  out->lighting.scattering = out->scattering;
  return result;
}

/* The tracer asks for light in all directions; so it has none prepared for the camera's. */
static neph_result build_viewer_light(const np_packet_lights_desc *d, np_packet_light *out) {
  if (d->plan->desc.integrator != NEPH_INTEGRATOR_MARCH) return NEPH_OK;
  const np_assembly *a = d->assembly;
  neph_result result =
      np_viewer_light_build(a->context, out->scattering, a->camera.origin, d->monitor, &out->viewer_light);
  if (!result) out->lighting.viewer_light = &out->viewer_light;
  return result;
}

static neph_result build_ground_light(const np_packet_lights_desc *d, np_packet_light *out) {
  np_assembly *a = d->assembly;
  np_schedule_begin(&a->schedule, d->monitor, NP_WORK_GROUND_CLOUDS);
  const np_ground_light_desc desc = {.world = &out->world,
                                     .depths = &out->lighting.sun_depths,
                                     .scattering = out->scattering,
                                     .bounds_min = a->clouds_min,
                                     .bounds_max = a->clouds_max};
  neph_result result = np_ground_light_build(a->context, &desc, d->monitor, &out->ground_light);
  if (!result) out->lighting.ground_light = &out->ground_light;
  return result;
}

/* Rays through every so many pixels of the picture; those about the crop, and two more, of which neighbours and
 * pixels' filters take part. */
static np_air_rays make_air_rays(const np_assembly *a, const np_plan *plan) {
  const np_camera *c = &a->camera;
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

static np_air_casters find_casters(const np_assembly *a) {
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

/* The visibility serves every packet. */
static neph_result build_air_shadow(const np_packet_lights_desc *d, np_packet_light *out) {
  np_assembly *a = d->assembly;
  np_air_visibility *visibility = &a->air_visibilities[out->is_moon];
  neph_result result = NEPH_OK;
  if (!out->camera_sky) return result;
  np_schedule_begin(&a->schedule, d->monitor, NP_WORK_AIR_SHADOWS);
  if (!visibility->context) {
    const np_air_rays rays = make_air_rays(a, d->plan);
    const np_air_casters casters = find_casters(a);
    result = np_air_visibility_build(a->context, &out->world, &out->lighting.sun_depths, &rays, &casters, d->monitor,
                                     visibility);
  }
  if (result || !visibility->seen) return result;
  result = np_air_shadow_build(visibility, &out->world, out->lighting.ground_light, d->monitor, &out->air_shadow);
  if (!result) out->lighting.air_shadow = &out->air_shadow;
  return result;
}

/* For the tracer, where the light around the clouds is known: that of air which is traced is, at dusk, and where paths
 * are guided. */
static void build_sky_guide(const np_packet_lights_desc *d, np_packet_light *out) {
  const np_assembly *a = d->assembly;
  if (d->plan->desc.integrator != NEPH_INTEGRATOR_PATH || !out->cloud_sky) return;
  const float cost = np_plan_traces_air(d->plan) ? np_sky_guide_traced_cost : 1.0f;
  const np_sun_depth_source depths = np_sun_depths_get_source(&out->lighting.sun_depths);
  np_sky_guide_build(&out->world, &depths, find_clouds_middle(a), cost, &out->sky_guide);
  if (out->sky_guide.rate > 0.0f) out->lighting.sky_guide = &out->sky_guide;
}

static neph_result build_light(const np_packet_lights_desc *d, const light *l, np_packet *packet) {
  const bool is_first = packet->light_count == 0;
  np_packet_light *out = &packet->lights[packet->light_count++];
  out->is_moon = l->is_moon;
  neph_result result = build_skies(d, packet, l, out);
  if (result) return result;
  fill_view(d, packet, l, is_first, out);
  build_sky_guide(d, out);
  if (needs(d->plan, NP_STAGE_SUN_DEPTH)) result = build_sun_optical_depth(d, out);
  if (!result && needs(d->plan, NP_STAGE_ORDINATES)) {
    result = build_scattering(d, packet, out);
    if (!result) result = build_viewer_light(d, out);
  }
  if (!result && needs(d->plan, NP_STAGE_GROUND_CLOUDS)) result = build_ground_light(d, out);
  if (!result && needs(d->plan, NP_STAGE_AIR_SHADOWS)) result = build_air_shadow(d, out);
  return result;
}

/* Sun first; where neither shines, a sun without light. */
neph_result np_packet_lights_build(const np_packet_lights_desc *desc, np_packet *packet) {
  const neph_scene *scene = desc->scene;
  const bool has_moon = needs(desc->plan, NP_STAGE_MOON), has_sun = desc->plan->has_sun || !has_moon;
  np_spectrum moonlight = np_spectrum_grey(0.0f);
  np_disk disk = {0};
  if (scene->moon.is_there) disk = make_moon(desc, packet, &moonlight);
  fill_night(desc, disk, packet);
  const light sun = {desc->lights->to_sun, scene->sun.angular_radius_rad,
                     np_spectrum_scale(get_sun_irradiance(desc, packet), (float)desc->lights->sun_factor), false};
  const light moon = {desc->lights->moon.direction, desc->lights->moon.angular_radius_rad, moonlight, true};
  neph_result result = has_sun ? build_light(desc, &sun, packet) : NEPH_OK;
  if (!result && has_moon) result = build_light(desc, &moon, packet);
  return result ? result : build_stars(desc, packet);
}

void np_packet_lights_clear(const np_assembly *assembly, np_packet *packet, neph_sky *out_skies[NP_SKY_ROLES]) {
  const unsigned index = (unsigned)(packet - assembly->packets);
  memset(out_skies, 0, NP_SKY_ROLES * sizeof(neph_sky *));
  for (unsigned i = 0; i < packet->light_count; i++) {
    np_packet_light *own = &packet->lights[i];
    np_viewer_light_clear(&own->viewer_light);
    np_ground_light_clear(&own->ground_light);
    np_air_shadow_clear(&own->air_shadow);
    np_light_store_give(assembly->lights, index, get_light_role(own->is_moon), own->scattering);
    out_skies[get_role(own->is_moon, false)] = own->camera_sky;
    out_skies[get_role(own->is_moon, true)] = own->cloud_sky;
  }
  packet->light_count = 0;
  np_star_field_clear(&packet->stars);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* The sky: where its lights stand, the air, the skies of sun and moon, and what else shines at night. */
#include "atmosphere/moon.h"
#include "core/alloc.h"
#include "render/stage_builders.h"

/* ---- Sun and moon ---- */

neph_result np_stage_build_lights(const np_stage_inputs *in, np_assembly *out) {
  const neph_scene *scene = in->scene;
  const np_plan *plan = in->plan;
  double latitude = scene->latitude_rad, longitude = scene->longitude_rad;
  neph_result result = NEPH_OK;
  out->places = plan->lights;
  if (!plan->are_lights_known) {
    if (!scene->has_place && in->made->terrain) (void)np_terrain_get_place(in->made->terrain, &latitude, &longitude);
    result = np_scene_lights_compute(scene, latitude, longitude, &out->places);
  }
  if (np_plan_has_sun_world(plan)) out->light_count++;
  if (np_plan_needs(plan, NP_STAGE_MOON)) out->lights[out->light_count++].is_moon = true;
  if (!result && plan->has_beauty && scene->moon.is_enabled && scene->moon.map)
    result = np_sphere_map_load(out->context, "moon.map", scene->moon.map, false, &out->moon_map);
  return result;
}

void np_stage_clear_lights(np_assembly *assembly) {
  np_sphere_map_clear(&assembly->moon_map);
  assembly->light_count = 0;
}

static np_disk make_moon(const np_stage_inputs *in, const np_packet *packet, np_spectrum sun,
                         np_spectrum *out_irradiance) {
  const np_scene_moon *moon = &in->scene->moon;
  const np_sphere_map *map = in->made->moon_map.texels ? &in->made->moon_map : NULL;
  sun = np_spectrum_scale(sun, (float)moon->brightness);
  return np_moon_make_disk(&in->made->places.moon, sun, packet->bands.nm, moon->has_earthshine, map, out_irradiance);
}

neph_result np_stage_build_packet_lights(const np_stage_inputs *in, np_packet *out) {
  const np_assembly *a = in->made;
  const np_scene_lights *places = &a->places;
  const np_spectrum sunlight = np_packet_convert(out, NP_BAND_SUN, in->scene->sun.irradiance_w_m2_nm);
  np_spectrum moonlight = np_spectrum_grey(0.0f);
  out->night = (np_night){.turn = places->turn};
  if (in->scene->moon.is_enabled) out->night.moon = make_moon(in, out, sunlight, &moonlight);
  for (unsigned i = 0; i < a->light_count; i++) {
    np_packet_light *light = &out->lights[out->light_count++];
    *light = (np_packet_light){.index = i,
                               .direction = places->to_sun,
                               .angular_radius_rad = in->scene->sun.angular_radius_rad,
                               .irradiance = np_spectrum_scale(sunlight, (float)places->sun_factor)};
    if (!a->lights[i].is_moon) continue;
    light->is_moon = true;
    light->direction = places->moon.direction;
    light->angular_radius_rad = places->moon.angular_radius_rad;
    light->irradiance = moonlight;
  }
  return NEPH_OK;
}

void np_stage_clear_packet_lights(np_assembly *assembly, np_packet *packet) {
  (void)assembly;
  packet->light_count = 0;
}

/* ---- Air ---- */

neph_result np_stage_build_atmosphere(const np_stage_inputs *in, np_packet *out) {
  const neph_scene *scene = in->scene;
  neph_atmosphere_desc desc = scene->atmosphere;
  np_band_set_convert(&out->bands, NP_BAND_LINEAR, np_scene_get_ground_albedo(scene), desc.ground_albedo);
  neph_atmosphere_layer *layers = np_alloc(scene->context, desc.layer_count, sizeof *layers);
  if (!layers) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; i < desc.layer_count; i++)
    layers[i] = np_band_set_convert_layer(&out->bands, &scene->atmosphere.layers[i]);
  desc.layers = layers;
  np_monitor_set_stage(in->monitor, "building the atmosphere");
  const unsigned index = np_packet_get_index(in->made, out);
  if (scene->air.given && in->plan->packet_count == 1)
    np_sky_store_offer(scene->context, &in->stores->skies, index, scene->air.given);
  neph_result result =
      np_sky_store_take_atmosphere(scene->context, &in->stores->skies, index, &desc,
                                   np_plan_has_air_light(in->plan), in->monitor, &out->atmosphere);
  np_alloc_free(scene->context, layers);
  return result;
}

void np_stage_clear_atmosphere(np_assembly *a, np_packet *packet) {
  np_sky_store_give_atmosphere(a->context, &a->stores->skies, np_packet_get_index(a, packet), packet->atmosphere);
}

static neph_result build_sky(const np_stage_inputs *in, const np_packet *packet, const np_packet_light *light,
                             np_sky_role role, np_dvec3 observer, neph_sky **out_sky) {
  if (np_spectrum_is_zero(light->irradiance)) return NEPH_OK;
  neph_sky_desc desc = NEPH_SKY_DESC_DEFAULT;
  const np_dvec3 to_light = light->direction;
  for (int b = 0; b < NP_BAND_COUNT; b++) desc.sun_irradiance_w_m2_nm[b] = (double)light->irradiance.band[b];
  desc.sun_direction[0] = to_light.x, desc.sun_direction[1] = to_light.y, desc.sun_direction[2] = to_light.z;
  desc.observer_m[0] = observer.x, desc.observer_m[1] = observer.y, desc.observer_m[2] = observer.z;
  desc.sun_angular_radius_rad = light->angular_radius_rad;
  np_monitor_set_stage(in->monitor, "building the sky");
  return np_sky_store_take_sky(&in->stores->skies, np_packet_get_index(in->made, packet), role, packet->atmosphere,
                               &desc, in->monitor, out_sky);
}

static np_sky_role get_camera_role(const np_packet_light *light) {
  return light->is_moon ? NP_SKY_OF_CAMERA_BY_MOON : NP_SKY_OF_CAMERA;
}

static np_sky_role get_cloud_role(const np_packet_light *light) {
  return light->is_moon ? NP_SKY_OF_CLOUDS_BY_MOON : NP_SKY_OF_CLOUDS;
}

neph_result np_stage_build_camera_sky(const np_stage_inputs *in, const np_packet *packet, np_packet_light *out) {
  return build_sky(in, packet, out, get_camera_role(out), in->made->camera.origin, &out->camera_sky);
}

neph_result np_stage_build_cloud_sky(const np_stage_inputs *in, const np_packet *packet, np_packet_light *out) {
  return build_sky(in, packet, out, get_cloud_role(out), np_assembly_get_clouds_middle(in->made), &out->cloud_sky);
}

void np_stage_clear_camera_sky(np_assembly *a, const np_packet *packet, np_packet_light *light) {
  np_sky_store_give_sky(a->context, &a->stores->skies, np_packet_get_index(a, packet), get_camera_role(light),
                        light->camera_sky);
}

void np_stage_clear_cloud_sky(np_assembly *a, const np_packet *packet, np_packet_light *light) {
  np_sky_store_give_sky(a->context, &a->stores->skies, np_packet_get_index(a, packet), get_cloud_role(light),
                        light->cloud_sky);
}

/* ---- Night ---- */

neph_result np_stage_build_star_map(const np_stage_inputs *in, np_assembly *out) {
  const np_scene_stars *stars = &in->scene->stars;
  if (!stars->is_enabled || !stars->map) return NEPH_OK;
  return np_sphere_map_load(out->context, "stars.map", stars->map, true, &out->star_map);
}

void np_stage_clear_star_map(np_assembly *assembly) { np_sphere_map_clear(&assembly->star_map); }

/* Its channels are radiances in a scene's bands; what they are in the packet's is linear in them. */
static void set_map(const np_stage_inputs *in, const np_packet *packet, np_night *night) {
  night->map = &in->made->star_map;
  for (int c = 0; c < NP_BAND_COUNT; c++) {
    double channel[NP_BAND_COUNT] = {0};
    channel[c] = in->scene->stars.map_radiance;
    const np_spectrum weight = np_packet_convert(packet, NP_BAND_LINEAR, channel);
    for (int b = 0; b < NP_BAND_COUNT; b++) night->map_weight[b][c] = weight.band[b];
  }
}

neph_result np_stage_build_airglow(const np_stage_inputs *in, np_packet *out) {
  np_night *night = &out->night;
  const np_scene_airglow *airglow = &in->scene->airglow;
  night->has_airglow = airglow->is_enabled;
  if (airglow->is_enabled)
    night->airglow =
        np_airglow_make(airglow->magnitude, in->scene->atmosphere.planet_radius_m, airglow->altitude_m, out->bands.nm);
  if (in->made->star_map.texels) set_map(in, out, night);
  night->ground_irradiance = np_night_compute_irradiance(night, out->atmosphere, np_dvec3_make(0, 0, 0));
  return NEPH_OK;
}

void np_stage_clear_airglow(np_assembly *assembly, np_packet *packet) {
  (void)assembly;
  packet->night = (np_night){0};
}

neph_result np_stage_build_catalogue(const np_stage_inputs *in, np_assembly *out) {
  const np_scene_stars *stars = &in->scene->stars;
  out->stars = np_star_catalogue_bright();
  if (!stars->catalogue) return NEPH_OK;
  return np_star_catalogue_load(out->context, stars->catalogue, stars->faintest, &out->stars);
}

void np_stage_clear_catalogue(np_assembly *assembly) { np_star_catalogue_clear(&assembly->stars); }

neph_result np_stage_build_stars(const np_stage_inputs *in, np_packet *out) {
  const np_plan *plan = in->plan;
  const np_assembly *a = in->made;
  const bool is_sphere = plan->sphere_size[0] > 0;
  const np_star_field_desc desc = {.catalogue = &a->stars,
                                   .world = &out->lights[0].world,
                                   .camera = is_sphere ? NULL : &a->camera,
                                   .width = is_sphere ? plan->sphere_size[0] : a->camera.width,
                                   .height = is_sphere ? plan->sphere_size[1] : a->camera.height,
                                   .origin = a->camera.origin,
                                   .wavelength_nm = out->bands.nm,
                                   .twinkling = in->scene->stars.twinkling,
                                   .seed = plan->desc.seed,
                                   .frame = plan->desc.frame};
  return np_star_field_build(a->context, &desc, &out->stars);
}

void np_stage_clear_stars(np_assembly *assembly, np_packet *packet) {
  (void)assembly;
  np_star_field_clear(&packet->stars);
}

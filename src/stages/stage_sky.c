/* SPDX-License-Identifier: Apache-2.0 */
/* The sky: where its lights stand, the air, the skies of sun and moon, and what else shines at night. */
#include <assert.h>
#include <string.h>

#include "atmosphere/atmosphere_tables.h"
#include "atmosphere/moon.h"
#include "core/alloc.h"
#include "core/text.h"
#include "scene/sequence.h"
#include "stages/stage_part.h"
#include "terrain/terrain_surroundings.h"

/* ---- Sun and moon ---- */

static void add_light(np_picture_lights *lights, unsigned group) {
  assert(lights->count < NP_LIGHTS_MAX);
  lights->group[lights->count++] = group;
}

/* Sun and moon, or the groups of lights of a picture that has them. */
static void add_lights(const np_lights_inputs *in, np_picture_lights *out) {
  const np_plan *plan = in->plan;
  out->has_groups = plan->request.has_light_groups;
  if (out->has_groups ? plan->decisions.has_sun : np_plan_has_sun_world(plan)) add_light(out, NP_LIGHT_GROUP_SUN);
  if (out->has_groups) add_light(out, NP_LIGHT_GROUP_SKY);
  if (np_plan_needs(plan, NP_STAGE_MOON)) add_light(out, NP_LIGHT_GROUP_MOON);
  for (unsigned i = 0; i < in->scene->cloud_count && out->has_groups; i++)
    if (in->scene->clouds[i].emission.is_enabled) add_light(out, NP_LIGHT_GROUP_EMISSION + i);
}

static neph_result build_lights(const np_lights_inputs *in, np_picture_lights *out) {
  const neph_scene *scene = in->scene;
  const np_plan *plan = in->plan;
  double latitude = scene->latitude_rad, longitude = scene->longitude_rad;
  out->places = plan->decisions.lights;
  if (!plan->decisions.are_lights_known) {
    if (!scene->has_place && in->terrain) (void)np_terrain_get_place(in->terrain, &latitude, &longitude);
    out->places = np_scene_lights_compute(scene, latitude, longitude);
  }
  add_lights(in, out);
  if (!plan->request.has_beauty || !scene->moon.is_enabled || !scene->moon.map) return NEPH_OK;
  return np_sphere_map_load(in->context, "moon.map", scene->moon.map, false, &out->moon_map);
}

NP_STAGE_BUILD(lights, lights, task->picture->lights)

void np_stage_clear_lights(const np_stage_task *task) { np_sphere_map_clear(&task->picture->lights.moon_map); }

static np_disk make_moon(const np_lights_inputs *in, np_spectrum sun, np_spectrum *out_irradiance) {
  const np_scene_moon *moon = &in->scene->moon;
  const np_sphere_map *map = in->lights->moon_map.texels ? &in->lights->moon_map : NULL;
  sun = np_spectrum_scale(sun, (float)moon->brightness);
  return np_moon_make_disk(&in->lights->places.moon, sun, in->bands->nm, moon->has_earthshine, map, out_irradiance);
}

static np_light_beam make_beam(const np_lights_inputs *in, unsigned index, np_spectrum sunlight,
                               np_spectrum moonlight) {
  const np_scene_lights *places = &in->lights->places;
  np_light_beam beam = {.index = index,
                        .group = in->lights->group[index],
                        .direction = places->to_sun,
                        .angular_radius_rad = in->scene->sun.angular_radius_rad,
                        .irradiance = np_spectrum_scale(sunlight, (float)places->sun_factor)};
  if (beam.group >= NP_LIGHT_GROUP_EMISSION) beam.irradiance = np_spectrum_grey(0.0f);
  if (beam.group != NP_LIGHT_GROUP_MOON) return beam;
  beam.direction = places->moon.direction;
  beam.angular_radius_rad = places->moon.angular_radius_rad;
  beam.irradiance = moonlight;
  return beam;
}

neph_result np_stage_build_packet_lights(const np_stage_task *task) {
  const np_lights_inputs *in = &task->in.lights;
  np_packet *out = task->packet;
  const np_spectrum sunlight = np_bands_convert(in->bands, NP_BAND_SUN, in->scene->sun.irradiance_w_m2_nm);
  np_spectrum moonlight = np_spectrum_grey(0.0f);
  out->night = (np_night){.turn = in->lights->places.turn};
  if (in->scene->moon.is_enabled) out->night.moon = make_moon(in, sunlight, &moonlight);
  out->light_count = in->lights->count;
  for (unsigned i = 0; i < out->light_count; i++) out->lights[i].beam = make_beam(in, i, sunlight, moonlight);
  return NEPH_OK;
}

/* ---- Air ---- */

/* Share of the ground below which water is left out of the light that the air has from it. */
static const float sea_least = 0.02f;

/* Share of the ground below the air that is water. */
static float compute_sea_share(const neph_scene *scene, const neph_terrain *terrain) {
  if (scene->has_ground_albedo || !np_scene_has_water(scene) || scene->water.level_m < 0.0) return 0.0f;
  const float share = terrain ? (float)np_terrain_measure_water(terrain, scene->water.level_m) : 1.0f;
  return share < sea_least ? 0.0f : share;
}

static void get_land_albedo(const neph_scene *scene, const neph_terrain *terrain, double out[NP_BAND_COUNT]) {
  const bool is_terrain = !scene->has_ground_albedo && terrain;
  memcpy(out, is_terrain ? np_terrain_get_air_albedo(terrain) : np_scene_get_ground_albedo(scene),
         NP_BAND_COUNT * sizeof *out);
}

static np_vec3 get_light_direction(const np_stage_part *in, const np_picture_lights *lights) {
  const np_scene_lights *places = &lights->places;
  return np_dvec3_to_float(np_plan_has_sun_world(in->plan) ? places->to_sun : places->moon.direction);
}

/* Albedo of the planet, in the scene's reference bands: that of water and of land by their shares. */
void np_stage_get_ground_albedo(const np_stage_part *in, const neph_terrain *terrain, const np_picture_lights *lights,
                                double out[NP_BAND_COUNT]) {
  const neph_scene *scene = in->scene;
  const double share = (double)compute_sea_share(scene, terrain);
  get_land_albedo(scene, terrain, out);
  if (share == 0.0) return;
  const double *albedo = scene->water.albedo;
  const np_water water = np_water_make(scene->water.level_m, scene->water.wind_m_s,
                                       np_spectrum_make((float)albedo[0], (float)albedo[1], (float)albedo[2]));
  const np_spectrum albedo_under_light = np_water_get_air_albedo(&water, get_light_direction(in, lights).z);
  for (int b = 0; b < NP_BAND_COUNT; b++) out[b] = (1.0 - share) * out[b] + share * (double)albedo_under_light.band[b];
}

/* Share of the tolerance: along the long paths of the horizon a coefficient counts ten times. */
static const double medium_share = 0.1;

typedef struct air_key {
  neph_atmosphere_desc desc;
  np_sea sea;                     /* in the packet's bands */
  neph_atmosphere_layer layers[]; /* the layers of `desc` */
} air_key;

static neph_result make_air_key(const np_stage_part *in, const np_band_set *bands, const neph_terrain *terrain,
                                const np_picture_lights *lights, void **out_key) {
  const neph_atmosphere_desc *air = &in->scene->atmosphere;
  air_key *key = *out_key = np_alloc(in->context, 1, sizeof *key + air->layer_count * sizeof *key->layers);
  if (!key) return NEPH_ERROR_OUT_OF_MEMORY;
  key->desc = *air;
  key->desc.layers = key->layers;
  double albedo[NP_BAND_COUNT];
  np_stage_get_ground_albedo(in, terrain, lights, albedo);
  np_band_set_convert(bands, NP_BAND_LINEAR, albedo, key->desc.ground_albedo);
  for (unsigned i = 0; i < air->layer_count; i++) key->layers[i] = np_band_set_convert_layer(bands, &air->layers[i]);
  const np_scene_water *water = &in->scene->water;
  key->sea.share = compute_sea_share(in->scene, terrain);
  if (key->sea.share == 0.0f) return NEPH_OK;
  key->sea.glint =
      terrain ? (float)np_terrain_measure_glint(terrain, water->level_m, get_light_direction(in, lights)) : 1.0f;
  get_land_albedo(in->scene, terrain, albedo);
  key->sea.water =
      np_water_make(water->level_m, water->wind_m_s, np_bands_convert(bands, NP_BAND_LINEAR, water->albedo));
  key->sea.land_albedo = np_bands_from_spectrum(np_bands_convert(bands, NP_BAND_LINEAR, albedo));
  return NEPH_OK;
}

static neph_result get_atmosphere_key(const np_atmosphere_inputs *in, void **out_key) {
  return make_air_key(&in->part, in->bands, in->terrain, in->lights, out_key);
}

/* Paths that trace the light in the air need the first order alone, which has no table. */
static unsigned get_order_max(const np_atmosphere_inputs *in) {
  return np_plan_has_air_light(in->plan) ? NP_ORDERS_ALL : 1;
}

static bool has_equal_sea(const air_key *key, const neph_atmosphere *cached) {
  const np_sea *wanted = &key->sea, *own = &cached->sea;
  if (wanted->share == 0.0f || wanted->share != own->share) return wanted->share == own->share;
  if (wanted->glint != own->glint) return false;
  return wanted->water.roughness == own->water.roughness &&
         !memcmp(&wanted->water.albedo, &own->water.albedo, sizeof own->water.albedo) &&
         !memcmp(&wanted->land_albedo, &own->land_albedo, sizeof own->land_albedo);
}

/* Writes why an atmosphere does not match the request. */
static neph_result compare_air(const np_atmosphere_inputs *in, const neph_atmosphere *cached, char *out_reason) {
  const air_key *key = in->key;
  const neph_atmosphere_desc *desc = &key->desc;
  np_medium wanted;
  neph_result result = np_medium_init(in->context, desc, &wanted);
  if (result) return result;
  const char *what;
  const double change = np_medium_compare(&wanted, &cached->medium, &what);
  np_medium_free(in->context, &wanted);
  if (cached->desc.tolerance != desc->tolerance)
    np_print(out_reason, NP_REASON_SIZE, "its tolerance changed");
  else if (cached->order_max < get_order_max(in))
    np_print(out_reason, NP_REASON_SIZE, "what is asked of it changed");
  else if (!has_equal_sea(key, cached))
    np_print(out_reason, NP_REASON_SIZE, "the water below it changed");
  else if (!isfinite(change))
    np_print(out_reason, NP_REASON_SIZE, "%s changed", what);
  else if (change > (np_stage_is_exact(&in->part) ? 0.0 : medium_share * desc->tolerance))
    np_print(out_reason, NP_REASON_SIZE, "%s changed by %.3g %%", what, 100.0 * change);
  return NEPH_OK;
}

/* The atmosphere that a caller has given, if it fits; NULL: none. */
static neph_result get_given_air(const np_atmosphere_inputs *in, neph_atmosphere **out_atmosphere) {
  char reason[NP_REASON_SIZE] = "";
  neph_atmosphere *given = in->plan->decisions.packet_count == 1 ? in->scene->air.given : NULL;
  neph_result result = given ? compare_air(in, given, reason) : NEPH_OK;
  *out_atmosphere = reason[0] ? NULL : given;
  return result;
}

static neph_result adapt_air(const np_atmosphere_inputs *in, void *cached, const void *cached_key, char *out_reason) {
  (void)cached_key;
  neph_atmosphere *given;
  neph_result result = get_given_air(in, &given);
  if (given && given != cached) np_print(out_reason, NP_REASON_SIZE, "another was given");
  return result || out_reason[0] ? result : compare_air(in, cached, out_reason);
}

/* The atmosphere of a key, over its sea. */
static neph_result create_air(const np_stage_part *in, const air_key *key, unsigned order_max, neph_atmosphere **out) {
  neph_result result = np_atmosphere_create_orders(in->context, &key->desc, order_max, false, in->monitor, out);
  if (!result && key->sea.share > 0.0f) np_atmosphere_set_sea(*out, &key->sea);
  return result;
}

static neph_result make_atmosphere(const np_atmosphere_inputs *in, neph_atmosphere **out) {
  neph_atmosphere *given;
  np_monitor_set_stage(in->monitor, "building the atmosphere");
  neph_result result = get_given_air(in, &given);
  if (result || given) return *out = neph_atmosphere_retain(given), result;
  return create_air(&in->part, in->key, get_order_max(in), out);
}

static void destroy_air(void *atmosphere) { neph_atmosphere_release(atmosphere); }

NP_STAGE_REUSE(atmosphere, task->packet->atmosphere, NP_PER_PACKET, false, adapt_air, destroy_air, NULL);

/* ---- Skies ---- */

static const double water_sky_height_m = 10.0;

/* A frame of a sequence has skies whose tables are those of a place on a lattice, so that they depend on no other
 * frame. */
typedef struct sky_key {
  neph_sky_desc desc, built;
} sky_key;

static bool is_same_place(const neph_sky_desc *a, const neph_sky_desc *b) {
  return !memcmp(a->sun_direction, b->sun_direction, sizeof a->sun_direction) &&
         !memcmp(a->observer_m, b->observer_m, sizeof a->observer_m);
}

static neph_result make_sky_key(const np_stage_part *in, const np_picture_lights *lights, const np_light_beam *beam,
                                np_dvec3 observer, const neph_atmosphere *atmosphere, void **out_key) {
  const bool is_beam = lights->has_groups && beam->group == NP_LIGHT_GROUP_SUN;
  const bool is_of_fire =
      in->plan->decisions.emission_count > 0 && (!lights->has_groups || beam->group >= NP_LIGHT_GROUP_EMISSION);
  if ((np_spectrum_is_zero(beam->irradiance) && !is_of_fire) || is_beam) return NEPH_OK;
  sky_key *key = *out_key = np_alloc(in->context, 1, sizeof *key);
  if (!key) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_sky_desc *desc = &key->desc;
  *desc = (neph_sky_desc)NEPH_SKY_DESC_DEFAULT;
  const np_dvec3 to_light = beam->direction;
  for (int b = 0; b < NP_BAND_COUNT; b++) desc->sun_irradiance_w_m2_nm[b] = (double)beam->irradiance.band[b];
  desc->sun_direction[0] = to_light.x, desc->sun_direction[1] = to_light.y, desc->sun_direction[2] = to_light.z;
  desc->observer_m[0] = observer.x, desc->observer_m[1] = observer.y, desc->observer_m[2] = observer.z;
  desc->sun_angular_radius_rad = beam->angular_radius_rad;
  key->built = *desc;
  if (atmosphere && np_scene_is_sequence(in->scene)) np_sky_snap(atmosphere, desc, &key->built);
  return NEPH_OK;
}

static neph_result get_camera_sky_key(const np_camera_sky_inputs *in, void **out_key) {
  return make_sky_key(&in->part, in->lights, in->beam, in->camera->origin, in->atmosphere, out_key);
}

static neph_result get_cloud_sky_key(const np_cloud_sky_inputs *in, void **out_key) {
  const np_dvec3 middle = np_frame_clouds_get_middle(in->clouds);
  return make_sky_key(&in->part, in->lights, in->beam, middle, in->atmosphere, out_key);
}

/* Key of the sky for the water below the camera. */
static neph_result get_water_sky_key(const np_water_sky_inputs *in, void **out_key) {
  const double radius = in->scene->atmosphere.planet_radius_m, level = in->scene->water.level_m;
  const np_dvec3 camera = in->camera->origin, up = np_dvec3_zenith(camera, radius);
  const double height = np_altitude(camera, radius) - fmax(level, 0.0) - water_sky_height_m;
  const np_dvec3 observer = np_dvec3_subtract(camera, np_dvec3_scale(up, height));
  return make_sky_key(&in->part, in->lights, in->beam, observer, in->atmosphere, out_key);
}

/* Adapts a cached sky to the requested light and observer. */
static neph_result move_sky(const np_stage_part *in, const neph_atmosphere *atmosphere, neph_sky *cached,
                            const sky_key *own, char *out_reason) {
  const sky_key *wanted = in->key;
  if (cached->atmosphere != atmosphere)
    np_print(out_reason, NP_REASON_SIZE, "the atmosphere was rebuilt");
  else if (np_stage_is_exact(in) && !is_same_place(&own->built, &wanted->built))
    np_print(out_reason, NP_REASON_SIZE, "light or observer stand higher or lower");
  else if (np_sky_move(cached, &wanted->desc, out_reason, NP_REASON_SIZE))
    out_reason[0] = '\0';
  return NEPH_OK;
}

static neph_result make_sky(const np_stage_part *in, neph_atmosphere *atmosphere, neph_sky **out_sky) {
  const sky_key *key = in->key;
  char reason[NP_REASON_SIZE];
  if (!key) return NEPH_OK;
  np_monitor_set_stage(in->monitor, "building the sky");
  neph_result result = np_sky_create_monitored(atmosphere, &key->built, in->monitor, out_sky);
  if (result || is_same_place(&key->built, &key->desc)) return result;
  if (np_sky_move(*out_sky, &key->desc, reason, sizeof reason)) return NEPH_OK;
  neph_sky_destroy(*out_sky);
  return np_sky_create_monitored(atmosphere, &key->desc, in->monitor, out_sky);
}

static void destroy_sky(void *sky) { neph_sky_destroy(sky); }

/* Defines the reuse of a sky by get_STAGE_key. */
#define SKY_REUSE(stage)                                                                                               \
  static neph_result move_##stage(const np_##stage##_inputs *in, void *cached, const void *cached_key,                 \
                                  char *out_reason) {                                                                  \
    return move_sky(&in->part, in->atmosphere, cached, cached_key, out_reason);                                        \
  }                                                                                                                    \
  static neph_result make_##stage(const np_##stage##_inputs *in, neph_sky **out) {                                     \
    return make_sky(&in->part, in->atmosphere, out);                                                                   \
  }                                                                                                                    \
  NP_STAGE_REUSE(stage, task->light->stage, NP_PER_PACKET_LIGHT, false, move_##stage, destroy_sky, NULL)

SKY_REUSE(camera_sky);
SKY_REUSE(cloud_sky);
SKY_REUSE(water_sky);

neph_result np_stage_create_sky(const np_color_fit_inputs *in, neph_sky **out_sky) {
  void *air = NULL, *sky = NULL;
  neph_atmosphere *atmosphere = NULL;
  *out_sky = NULL;
  neph_result result = make_sky_key(&in->part, in->lights, in->beam, in->camera->origin, in->atmosphere, &sky);
  if (!result && sky) result = make_air_key(&in->part, in->bands, in->terrain, in->lights, &air);
  if (!result && sky) result = create_air(&in->part, air, NP_ORDERS_ALL, &atmosphere);
  if (!result && sky) result = np_sky_create_monitored(atmosphere, &((const sky_key *)sky)->desc, in->monitor, out_sky);
  neph_atmosphere_release(atmosphere);
  np_alloc_free(in->context, air);
  np_alloc_free(in->context, sky);
  return result;
}

/* ---- Night ---- */

static neph_result build_star_map(const np_airglow_inputs *in, np_sphere_map *out) {
  const np_scene_stars *stars = &in->scene->stars;
  if (!stars->is_enabled || !stars->map) return NEPH_OK;
  return np_sphere_map_load(in->context, "stars.map", stars->map, true, out);
}

NP_STAGE_BUILD(star_map, airglow, task->picture->star_map)

void np_stage_clear_star_map(const np_stage_task *task) { np_sphere_map_clear(&task->picture->star_map); }

/* Its channels are radiances in a scene's bands; radiances in the packet's bands are linear in them. */
static void set_map(const np_airglow_inputs *in, np_night *night) {
  night->map = in->star_map;
  for (int c = 0; c < NP_BAND_COUNT; c++) {
    double channel[NP_BAND_COUNT] = {0};
    channel[c] = in->scene->stars.map_radiance;
    const np_spectrum weight = np_bands_convert(in->bands, NP_BAND_LINEAR, channel);
    for (int b = 0; b < NP_BAND_COUNT; b++) night->map_weight[b][c] = weight.band[b];
  }
}

static neph_result build_airglow(const np_airglow_inputs *in, np_night *night) {
  const np_scene_airglow *airglow = &in->scene->airglow;
  night->has_airglow = airglow->is_enabled;
  if (airglow->is_enabled)
    night->airglow =
        np_airglow_make(airglow->magnitude, in->scene->atmosphere.planet_radius_m, airglow->altitude_m, in->bands->nm);
  if (in->star_map->texels) set_map(in, night);
  night->ground_irradiance = np_night_compute_irradiance(night, in->atmosphere, np_dvec3_make(0, 0, 0));
  return NEPH_OK;
}

NP_STAGE_BUILD(airglow, airglow, task->packet->night)

static neph_result build_catalogue(const np_stars_inputs *in, np_star_catalogue *out) {
  const np_scene_stars *stars = &in->scene->stars;
  *out = np_star_catalogue_bright();
  if (!stars->catalogue) return NEPH_OK;
  return np_star_catalogue_load(in->context, stars->catalogue, stars->faintest, out);
}

NP_STAGE_BUILD(catalogue, stars, task->picture->catalogue)

void np_stage_clear_catalogue(const np_stage_task *task) { np_star_catalogue_clear(&task->picture->catalogue); }

static neph_result build_stars(const np_stars_inputs *in, np_star_field *out) {
  const np_plan *plan = in->plan;
  const np_camera *camera = in->camera;
  const bool is_sphere = plan->request.sky.size[0] > 0;
  const np_star_field_desc desc = {.catalogue = in->catalogue,
                                   .world = in->world,
                                   .camera = is_sphere ? NULL : camera,
                                   .width = is_sphere ? plan->request.sky.size[0] : camera->width,
                                   .height = is_sphere ? plan->request.sky.size[1] : camera->height,
                                   .overscan = is_sphere ? 0 : (int)in->scene->camera.overscan,
                                   .center_rad = plan->request.sky.center_rad,
                                   .origin = camera->origin,
                                   .wavelength_nm = in->bands->nm,
                                   .twinkling = in->scene->stars.twinkling,
                                   .seed = plan->request.desc.seed,
                                   .frame = plan->request.desc.frame};
  return np_star_field_build(in->context, &desc, out);
}

NP_STAGE_BUILD(stars, stars, task->packet->stars)

void np_stage_clear_stars(const np_stage_task *task) { np_star_field_clear(&task->packet->stars); }

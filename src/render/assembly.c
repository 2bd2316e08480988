/* SPDX-License-Identifier: Apache-2.0 */
#include "render/assembly.h"

#include <float.h>
#include <glob.h>
#include <string.h>

#include "cloud/cloud_private.h"
#include "core/alloc.h"
#include "core/file.h"
#include "render/packet_lights.h"

typedef struct build {
  const neph_scene *scene;
  const np_plan *plan;
  np_monitor *monitor;
  np_assembly *assembly;
  np_scene_lights lights;
} build;

static bool needs(const np_plan *plan, np_stage stage) { return plan->stages[stage].is_needed; }

/* Terrain and volumes report, and are stopped, as parts of the picture. */
static neph_result bake(const build *b, const np_scene_cloud *cloud, const char *path, neph_volume **out_volume) {
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  desc.planet_radius_m = b->scene->atmosphere.planet_radius_m;
  desc.precision = cloud->precision;
  desc.progress = np_monitor_relay;
  desc.progress_user = b->monitor;
  neph_context *context = b->scene->context;
  const neph_cloud_desc at_frame = np_scene_cloud_get_frame(cloud, b->plan->desc.frame);
  if (!path) return neph_cloud_bake(context, &at_frame, &desc, out_volume);
  return neph_cloud_bake_file(context, &at_frame, &desc, "density", path);
}

static neph_volume_load_desc describe_load(const build *b, const np_scene_cloud *cloud) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  desc.grid = cloud->grid;
  desc.precision = cloud->precision;
  desc.policy = cloud->policy;
  desc.progress = np_monitor_relay;
  desc.progress_user = b->monitor;
  return desc;
}

static neph_result load(const build *b, const np_scene_cloud *cloud, const char *path, neph_volume **out_volume) {
  const neph_volume_load_desc desc = describe_load(b, cloud);
  return neph_volume_load(b->scene->context, path, &desc, out_volume);
}

/* A cloud of one frame: read when it is on disk, else baked, to disk where the scene names a file. */
static neph_result obtain(const build *b, const np_scene_cloud *cloud, const char *path, neph_volume **out_volume) {
  np_cloud_source source;
  neph_result result = np_plan_find_source(b->scene, cloud, path, b->plan->desc.frame, &source);
  if (result) return result;
  if (!path) return bake(b, cloud, NULL, out_volume);
  if (source == NP_CLOUD_SOURCE_REBAKE)
    np_log(b->scene->context, NEPH_LOG_WARNING, "%s: was baked from other parameters than the scene's, is baked anew",
           path);
  const np_monitor_part whole = np_monitor_get_part(b->monitor);
  np_monitor_set_part(b->monitor, whole, 0.0, 0.8);
  if (source != NP_CLOUD_SOURCE_FILE) result = bake(b, cloud, path, NULL);
  np_monitor_set_part(b->monitor, whole, source != NP_CLOUD_SOURCE_FILE ? 0.8 : 0.0, 1.0);
  return result ? result : load(b, cloud, path, out_volume);
}

/* The first file on disk of a numbered pattern; NULL when there is none or no memory. */
static char *find_first_frame(neph_context *context, const char *pattern) {
  char *wild = np_alloc_text(context, pattern), *first = NULL;
  if (!wild) return NULL;
  char *digits = strrchr(wild, '#');
  for (; digits >= wild && *digits == '#'; digits--) *digits = '?';
  glob_t found = {0};
  if (glob(wild, 0, NULL, &found) == 0) first = np_alloc_text(context, found.gl_pathv[0]);
  globfree(&found);
  np_alloc_free(context, wild);
  return first;
}

/* The volume that an optical depth refers to: the first frame on disk, whatever frame is rendered. */
static neph_result obtain_reference(const build *b, const np_scene_cloud *cloud, const char *path, neph_volume *volume,
                                    neph_volume **out_reference) {
  *out_reference = neph_volume_retain(volume);
  if (cloud->density_unit != NP_DENSITY_OPTICAL_DEPTH || !cloud->vdb || !strchr(cloud->vdb, '#')) return NEPH_OK;
  char *first = find_first_frame(b->scene->context, cloud->vdb);
  neph_result result = NEPH_OK;
  if (first && strcmp(first, path) != 0) {
    neph_volume_release(*out_reference);
    *out_reference = NULL;
    result = load(b, cloud, first, out_reference);
  }
  np_alloc_free(b->scene->context, first);
  return result;
}

static void include_bounds(np_assembly *a, np_dvec3 low, np_dvec3 high) {
  a->clouds_min =
      np_dvec3_make(fmin(a->clouds_min.x, low.x), fmin(a->clouds_min.y, low.y), fmin(a->clouds_min.z, low.z));
  a->clouds_max =
      np_dvec3_make(fmax(a->clouds_max.x, high.x), fmax(a->clouds_max.y, high.y), fmax(a->clouds_max.z, high.z));
}

/* What glows in a cloud just placed. */
static neph_result build_glow(const build *b, unsigned index, const char *path, const np_placement *placement) {
  const np_scene_cloud *cloud = &b->scene->clouds[index];
  np_cloud_glow *glow = &b->assembly->glows[index];
  if (!cloud->emission.is_there || !needs(b->plan, NP_STAGE_EMISSION)) return NEPH_OK;
  const neph_volume_load_desc desc = describe_load(b, cloud);
  neph_result result = np_cloud_glow_load(cloud, path, b->assembly->volumes[index], placement, &desc, glow);
  if (result || !glow->flame) return result;
  np_dvec3 low, high;
  np_placement_find_bounds(&glow->glow.index_to_world, glow->flame, &low, &high);
  include_bounds(b->assembly, low, high);
  return NEPH_OK;
}

static neph_result load_phase(const build *b, unsigned index) {
  const np_scene_phase *source = &b->scene->clouds[index].phase_source;
  if (source->kind != NP_PHASE_TABLE) return NEPH_OK;
  np_phase_table *table = &b->assembly->phase_tables[index];
  neph_result result = np_phase_table_load(b->scene->context, source->table, table);
  if (!result) b->assembly->placed[index].phase = np_phase_tabulated(table);
  return result;
}

static neph_result build_cloud(const build *b, unsigned index) {
  const np_scene_cloud *cloud = &b->scene->clouds[index];
  np_assembly *a = b->assembly;
  char *path = cloud->vdb ? np_file_frame_name(a->context, cloud->vdb, b->plan->desc.frame) : NULL;
  if (cloud->vdb && !path) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_volume *reference = NULL;
  np_placement placement;
  np_schedule_begin(&a->schedule, b->monitor, NP_WORK_CLOUD);
  const np_monitor_part whole = np_monitor_get_part(b->monitor);
  np_monitor_set_part(b->monitor, whole, 0.0, 0.7);
  neph_result result = obtain(b, cloud, path, &a->volumes[index]);
  np_monitor_set_part(b->monitor, whole, 0.7, 0.8);
  if (!result) result = obtain_reference(b, cloud, path, a->volumes[index], &reference);
  np_monitor_set_part(b->monitor, whole, 0.8, 0.9);
  np_monitor_set_stage(b->monitor, "placing clouds");
  if (!result) result = np_placement_make(cloud, a->volumes[index], reference, b->monitor, &placement);
  if (!result) {
    a->placed[index] = placement.view;
    include_bounds(a, placement.bounds_min, placement.bounds_max);
    result = load_phase(b, index);
    np_monitor_set_part(b->monitor, whole, 0.9, 1.0);
    if (!result) result = build_glow(b, index, path, &placement);
  }
  neph_volume_release(reference);
  np_alloc_free(a->context, path);
  return result;
}

static neph_result build_clouds(const build *b) {
  np_assembly *a = b->assembly;
  const unsigned count = b->scene->cloud_count;
  a->clouds_min = np_dvec3_make(DBL_MAX, DBL_MAX, DBL_MAX);
  a->clouds_max = np_dvec3_make(-DBL_MAX, -DBL_MAX, -DBL_MAX);
  if (count > NP_VIEW_VOLUMES_MAX)
    return np_fail(a->context, NEPH_ERROR_BAD_SCENE, "the scene has %u clouds, must be at most %d", count,
                   NP_VIEW_VOLUMES_MAX);
  a->volumes = np_alloc(a->context, count, sizeof *a->volumes);
  a->placed = np_alloc(a->context, count, sizeof *a->placed);
  a->phase_tables = np_alloc(a->context, count, sizeof *a->phase_tables);
  a->glows = np_alloc(a->context, count, sizeof *a->glows);
  if (!a->volumes || !a->placed || !a->phase_tables || !a->glows) return NEPH_ERROR_OUT_OF_MEMORY;
  a->volume_count = count;
  for (unsigned i = 0; i < count; i++) {
    neph_result result = build_cloud(b, i);
    if (result) return result;
  }
  return NEPH_OK;
}

static neph_result build_terrain(const build *b) {
  const np_scene_terrain *terrain = &b->scene->terrain;
  neph_terrain_desc desc = terrain->desc;
  desc.planet_radius_m = b->scene->atmosphere.planet_radius_m;
  desc.has_place = b->scene->has_place;
  desc.latitude_rad = b->scene->latitude_rad;
  desc.longitude_rad = b->scene->longitude_rad;
  np_schedule_begin(&b->assembly->schedule, b->monitor, NP_WORK_TERRAIN);
  desc.progress = np_monitor_relay;
  desc.progress_user = b->monitor;
  neph_terrain **out = &b->assembly->terrain;
  if (terrain->kind == NP_TERRAIN_RIDGES)
    return neph_terrain_create_ridges(b->scene->context, &terrain->ridges, &desc, out);
  return neph_terrain_load(b->scene->context, terrain->heightfield, &desc, out);
}

static neph_result find_lights(build *b) {
  b->lights = b->plan->lights;
  if (b->plan->are_lights_known) return NEPH_OK;
  double latitude = b->scene->latitude_rad, longitude = b->scene->longitude_rad;
  if (!b->scene->has_place && b->assembly->terrain)
    (void)np_terrain_get_place(b->assembly->terrain, &latitude, &longitude);
  return np_scene_lights_find(b->scene, latitude, longitude, &b->lights);
}

static neph_result load_maps(const build *b) {
  const neph_scene *scene = b->scene;
  np_assembly *a = b->assembly;
  neph_result result = NEPH_OK;
  if (needs(b->plan, NP_STAGE_STARS)) {
    a->stars = np_star_catalogue_bright();
    if (scene->stars.catalogue)
      result = np_star_catalogue_load(a->context, scene->stars.catalogue, scene->stars.faintest, &a->stars);
  }
  if (!result && needs(b->plan, NP_STAGE_AIRGLOW) && scene->stars.is_there && scene->stars.map)
    result = np_sphere_map_load(a->context, "stars.map", scene->stars.map, true, &a->star_map);
  if (!result && b->plan->has_beauty && scene->moon.is_there && scene->moon.map)
    result = np_sphere_map_load(a->context, "moon.map", scene->moon.map, false, &a->moon_map);
  return result;
}

/* ---- What depends on wavelength ---- */

typedef struct packet_build {
  const build *b;
  unsigned index;
  np_packet *packet;
} packet_build;

static neph_result build_atmosphere(const packet_build *p) {
  const neph_scene *scene = p->b->scene;
  neph_atmosphere_desc desc = scene->atmosphere;
  np_band_set_convert(&p->packet->bands, NP_BAND_LINEAR, np_packet_lights_ground_albedo(scene), desc.ground_albedo);
  neph_atmosphere_layer *layers = np_alloc(scene->context, desc.layer_count, sizeof *layers);
  if (!layers) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; i < desc.layer_count; i++)
    layers[i] = np_band_set_convert_layer(&p->packet->bands, &scene->atmosphere.layers[i]);
  desc.layers = layers;
  np_schedule_begin(&p->b->assembly->schedule, p->b->monitor, NP_WORK_ATMOSPHERE);
  np_monitor_set_stage(p->b->monitor, "building the atmosphere");
  const bool has_tables = !np_plan_traces_air(p->b->plan) || needs(p->b->plan, NP_STAGE_CLOUD_SKY);
  neph_result result = np_sky_store_take_atmosphere(scene->context, scene->skies, p->index, &desc, has_tables,
                                                    p->b->monitor, &p->packet->atmosphere);
  np_alloc_free(scene->context, layers);
  return result;
}

static neph_result place_clouds(const packet_build *p) {
  const np_assembly *a = p->b->assembly;
  if (!a->volume_count) return NEPH_OK;
  p->packet->placed = np_alloc(a->context, a->volume_count, sizeof *a->placed);
  if (!p->packet->placed) return NEPH_ERROR_OUT_OF_MEMORY;
  memcpy(p->packet->placed, a->placed, a->volume_count * sizeof *a->placed);
  for (unsigned i = 0; i < a->volume_count; i++)
    p->packet->placed[i].albedo = np_packet_convert(p->packet, NP_BAND_LINEAR, p->b->scene->clouds[i].albedo);
  return NEPH_OK;
}

/* All that glows in the clouds, for the packet's wavelengths. */
static neph_result build_emission(const packet_build *p) {
  const np_assembly *a = p->b->assembly;
  np_glow glows[NP_VIEW_VOLUMES_MAX];
  unsigned count = 0;
  for (unsigned i = 0; i < a->volume_count; i++)
    if (a->glows[i].is_there) glows[count++] = np_cloud_glow_get(&a->glows[i], &p->packet->placed[i]);
  if (count == 0) return NEPH_OK;
  np_schedule_begin(&p->b->assembly->schedule, p->b->monitor, NP_WORK_EMISSION);
  np_monitor_set_stage(p->b->monitor, "finding what glows");
  return np_emission_build(a->context, glows, count, p->packet->bands.nm, p->b->monitor, &p->packet->emission);
}

static neph_result build_packet(const packet_build *p) {
  const np_plan *plan = p->b->plan;
  neph_result result = NEPH_OK;
  if (needs(plan, NP_STAGE_ATMOSPHERE)) result = build_atmosphere(p);
  if (!result) result = place_clouds(p);
  if (!result) result = build_emission(p);
  const build *b = p->b;
  const np_packet_lights_desc lights = {b->scene, plan, b->assembly, &b->lights, b->monitor};
  return result ? result : np_packet_lights_build(&lights, p->packet);
}

/* The bands of each packet, and their weights in the picture's colours. */
static void choose_bands(const np_plan *plan, np_packet *packets) {
  if (plan->packet_count == 1) {
    packets->bands = np_band_set_reference();
    for (int c = 0; c < 3; c++) packets->color_weight[c][c] = 1.0f;
    return;
  }
  np_wavelengths wavelengths;
  np_wavelengths_choose(plan->wavelength_count, &wavelengths);
  for (unsigned i = 0; i < plan->packet_count; i++) {
    packets[i].bands = np_band_set_choose(&wavelengths, i);
    for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
      double rgb[3];
      np_color_space_weigh(plan->color_space, wavelengths.xyz_nm[np_band_set_get_index(&wavelengths, i, b)], rgb);
      for (int c = 0; c < 3; c++) packets[i].color_weight[c][b] = (float)rgb[c];
    }
  }
}

static neph_result build_packets(const build *b) {
  np_assembly *a = b->assembly;
  const unsigned count = b->plan->packet_count;
  a->packets = np_alloc(a->context, count, sizeof *a->packets);
  if (!a->packets) return NEPH_ERROR_OUT_OF_MEMORY;
  choose_bands(b->plan, a->packets);
  neph_result result = NEPH_OK;
  for (; !result && a->packet_count < count; a->packet_count++)
    result = build_packet(&(packet_build){b, a->packet_count, &a->packets[a->packet_count]});
  return result;
}

neph_result np_assembly_build(const neph_scene *scene, const np_plan *plan, np_monitor *monitor,
                              np_assembly *out_assembly) {
  *out_assembly = (np_assembly){.context = scene->context, .skies = scene->skies, .lights = scene->lights};
  build b = {.scene = scene, .plan = plan, .monitor = monitor, .assembly = out_assembly};
  np_schedule_make(plan, scene->cloud_count, &out_assembly->schedule);
  neph_result result = np_camera_init(scene, plan->desc.width, plan->desc.height, &out_assembly->camera);
  if (!result && needs(plan, NP_STAGE_TERRAIN)) result = build_terrain(&b);
  if (!result) result = find_lights(&b);
  if (!result) result = load_maps(&b);
  if (!result && needs(plan, NP_STAGE_VOLUMES)) result = build_clouds(&b);
  if (!result) result = build_packets(&b);
  if (result) np_assembly_clear(out_assembly);
  return result;
}

static void clear_packet(np_assembly *assembly, unsigned index) {
  np_packet *packet = &assembly->packets[index];
  neph_sky *skies[NP_SKY_ROLES];
  np_packet_lights_clear(assembly, packet, skies);
  np_emission_clear(&packet->emission);
  np_alloc_free(assembly->context, packet->placed);
  np_sky_store_give(assembly->context, assembly->skies, index, packet->atmosphere, skies);
}

void np_assembly_clear(np_assembly *assembly) {
  for (unsigned i = 0; i < assembly->packet_count; i++) clear_packet(assembly, i);
  np_alloc_free(assembly->context, assembly->packets);
  for (int role = 0; role < NP_LIGHT_ROLES; role++)
    np_light_store_give_depths(assembly->lights, (np_light_role)role, &assembly->sun_caches[role]);
  for (unsigned i = 0; i < NP_LIGHTS_MAX; i++) np_air_visibility_clear(&assembly->air_visibilities[i]);
  for (unsigned i = 0; i < assembly->volume_count; i++) {
    neph_volume_release(assembly->volumes[i]);
    np_phase_table_clear(&assembly->phase_tables[i]);
    np_cloud_glow_clear(&assembly->glows[i]);
  }
  np_alloc_free(assembly->context, assembly->glows);
  np_alloc_free(assembly->context, assembly->phase_tables);
  np_alloc_free(assembly->context, assembly->volumes);
  np_alloc_free(assembly->context, assembly->placed);
  neph_terrain_release(assembly->terrain);
  np_star_catalogue_clear(&assembly->stars);
  np_sphere_map_clear(&assembly->star_map);
  np_sphere_map_clear(&assembly->moon_map);
  *assembly = (np_assembly){0};
}

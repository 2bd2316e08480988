/* SPDX-License-Identifier: Apache-2.0 */
#include "render/assembly.h"

#include <float.h>
#include <string.h>

#include "cloud/cloud_private.h"
#include "core/alloc.h"
#include "core/file.h"
#include "render/packet_lights.h"
#include "render/placement_check.h"
#include "render/reference_frame.h"
#include "volume/volume_private.h"

typedef struct assembly_build {
  const neph_scene *scene;
  np_plan *plan;
  np_monitor *monitor;
  np_assembly *assembly;
  np_scene_lights lights;
} assembly_build;

static bool needs(const np_plan *plan, np_stage stage) { return plan->stages[stage].is_needed; }

/* Terrain and volumes report, and are stopped, as parts of the picture. */
static neph_result bake(const assembly_build *b, const np_scene_cloud *cloud, const char *path,
                        neph_volume **out_volume) {
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

static neph_volume_load_desc describe_load(const assembly_build *b, const np_scene_cloud *cloud) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  desc.grid = cloud->grid;
  desc.precision = cloud->precision;
  desc.policy = cloud->policy;
  desc.progress = np_monitor_relay;
  desc.progress_user = b->monitor;
  return desc;
}

/* Baked to memory. */
static neph_result obtain_baked(const assembly_build *b, const np_scene_cloud *cloud, neph_volume **out_volume) {
  neph_result result = bake(b, cloud, NULL, out_volume);
  if (result || (*out_volume)->value_max > 0.0f) return result;
  np_log(b->scene->context, NEPH_LOG_WARNING, "cloud %s: nothing of it was baked in frame %d: its coverage is %g",
         cloud->name, b->plan->desc.frame, cloud->bake.coverage);
  neph_volume_release(*out_volume);
  *out_volume = NULL;
  return NEPH_OK;
}

/* A cloud of one frame: read when it is on disk, else baked, to disk where the scene names a file. NULL where it holds
 * nothing. */
static neph_result obtain(const assembly_build *b, const np_scene_cloud *cloud, const char *path,
                          neph_volume **out_volume) {
  np_cloud_source source;
  neph_result result = np_plan_find_source(b->scene, cloud, path, b->plan->desc.frame, &source);
  if (result) return result;
  if (!path) return obtain_baked(b, cloud, out_volume);
  if (source == NP_CLOUD_SOURCE_REBAKE)
    np_log(b->scene->context, NEPH_LOG_WARNING, "%s: was baked from other parameters than the scene's, is baked anew",
           path);
  const np_monitor_part whole = np_monitor_get_part(b->monitor);
  np_monitor_set_part(b->monitor, whole, 0.0, 0.8);
  if (source != NP_CLOUD_SOURCE_FILE) result = bake(b, cloud, path, NULL);
  np_monitor_set_part(b->monitor, whole, source != NP_CLOUD_SOURCE_FILE ? 0.8 : 0.0, 1.0);
  const neph_volume_load_desc desc = describe_load(b, cloud);
  return result ? result : np_volume_load_density(b->scene->context, path, &desc, out_volume);
}

/* A cloud being placed. */
typedef struct cloud_build {
  const assembly_build *b;
  const np_scene_cloud *cloud;
  unsigned index;
  const char *path; /* NULL: none */
  np_anchor anchor;
  bool is_anchored;
  np_dvec3 low, high; /* world box of what it holds */
} cloud_build;

static void include_box(np_dvec3 *low, np_dvec3 *high, np_dvec3 box_low, np_dvec3 box_high) {
  *low = np_dvec3_make(fmin(low->x, box_low.x), fmin(low->y, box_low.y), fmin(low->z, box_low.z));
  *high = np_dvec3_make(fmax(high->x, box_high.x), fmax(high->y, box_high.y), fmax(high->z, box_high.z));
}

static neph_result load_phase(const cloud_build *c) {
  if (c->cloud->phase_source.kind != NP_PHASE_TABLE) return NEPH_OK;
  np_assembly *a = c->b->assembly;
  np_phase_table *table = &a->phase_tables[c->index];
  neph_result result = np_phase_table_load(a->context, c->cloud->phase_table, table);
  if (!result) a->placed[c->index].phase = np_phase_tabulated(table);
  return result;
}

static neph_result place_volume(cloud_build *c) {
  np_assembly *a = c->b->assembly;
  np_placement placement;
  neph_result result = np_placement_make(c->cloud, &c->anchor, a->volumes[c->index], c->b->monitor, &placement);
  if (result) return result;
  a->placed[c->index] = placement.world;
  a->volume_count++;
  include_box(&c->low, &c->high, placement.bounds_min, placement.bounds_max);
  return load_phase(c);
}

static bool has_emission(const cloud_build *c) {
  return c->cloud->emission.is_there && needs(c->b->plan, NP_STAGE_EMISSION);
}

/* What glows in a cloud's file. */
static neph_result build_glow(cloud_build *c) {
  np_assembly *a = c->b->assembly;
  np_cloud_glow *glow = &a->glows[c->index];
  if (!c->is_anchored) {
    np_log(a->context, NEPH_LOG_WARNING,
           "cloud %s: its emission is left out of frame %d: position, voxel and optical_depth go by its density, which "
           "is empty",
           c->cloud->name, c->b->plan->desc.frame);
    return NEPH_OK;
  }
  const neph_volume_load_desc load = describe_load(c->b, c->cloud);
  const np_cloud_glow_source source = {a->context,           c->cloud, c->path, &c->anchor.file_to_world,
                                       a->volumes[c->index], &load};
  neph_result result = np_cloud_glow_load(&source, glow);
  if (result || !glow->flame) return result;
  np_dvec3 low, high;
  np_placement_find_bounds(&glow->glow.index_to_world, glow->flame, &low, &high);
  include_box(&c->low, &c->high, low, high);
  return NEPH_OK;
}

/* Nothing goes by the anchor of a cloud that holds nothing and does not glow. */
static neph_result find_anchor(cloud_build *c) {
  neph_volume *volume = c->b->assembly->volumes[c->index];
  if (!volume && !has_emission(c)) return NEPH_OK;
  const neph_volume_load_desc load = describe_load(c->b, c->cloud);
  const np_frame_cloud of = {c->b->scene, c->index, c->b->plan->desc.frame, volume, &load, c->b->monitor};
  return np_reference_frame_get_anchor(&of, &c->anchor, &c->is_anchored);
}

static neph_result build_cloud_at(cloud_build *c) {
  np_assembly *a = c->b->assembly;
  np_monitor *monitor = c->b->monitor;
  np_schedule_begin(&a->schedule, monitor, NP_WORK_CLOUD);
  const np_monitor_part whole = np_monitor_get_part(monitor);
  np_monitor_set_part(monitor, whole, 0.0, 0.7);
  neph_result result = obtain(c->b, c->cloud, c->path, &a->volumes[c->index]);
  np_monitor_set_part(monitor, whole, 0.7, 0.9);
  np_monitor_set_stage(monitor, "placing clouds");
  if (!result) result = find_anchor(c);
  if (!result && a->volumes[c->index]) result = place_volume(c);
  np_monitor_set_part(monitor, whole, 0.9, 1.0);
  if (!result && has_emission(c)) result = build_glow(c);
  if (result || c->low.x > c->high.x) return result;
  include_box(&a->clouds_min, &a->clouds_max, c->low, c->high);
  np_placement_check(a->context, c->cloud, &a->camera, c->low, c->high);
  return NEPH_OK;
}

static const np_dvec3 nowhere_low = {DBL_MAX, DBL_MAX, DBL_MAX}, nowhere_high = {-DBL_MAX, -DBL_MAX, -DBL_MAX};

static neph_result build_cloud(const assembly_build *b, unsigned index) {
  const np_scene_cloud *cloud = &b->scene->clouds[index];
  neph_context *context = b->scene->context;
  char *path = cloud->vdb ? np_file_frame_name(context, cloud->vdb, b->plan->desc.frame) : NULL;
  if (cloud->vdb && !path) return NEPH_ERROR_OUT_OF_MEMORY;
  cloud_build c = {.b = b, .cloud = cloud, .index = index, .path = path, .low = nowhere_low, .high = nowhere_high};
  neph_result result = build_cloud_at(&c);
  np_alloc_free(context, path);
  return result;
}

static neph_result build_clouds(const assembly_build *b) {
  np_assembly *a = b->assembly;
  const unsigned count = b->scene->cloud_count;
  a->clouds_min = nowhere_low;
  a->clouds_max = nowhere_high;
  if (count > NP_INSTANCES_MAX)
    return np_fail(a->context, NEPH_ERROR_BAD_SCENE, "the scene has %u clouds, must be at most %d", count,
                   NP_INSTANCES_MAX);
  a->volumes = np_alloc(a->context, count, sizeof *a->volumes);
  a->placed = np_alloc(a->context, count, sizeof *a->placed);
  a->phase_tables = np_alloc(a->context, count, sizeof *a->phase_tables);
  a->glows = np_alloc(a->context, count, sizeof *a->glows);
  if (!a->volumes || !a->placed || !a->phase_tables || !a->glows) return NEPH_ERROR_OUT_OF_MEMORY;
  a->cloud_count = count;
  for (unsigned i = 0; i < count; i++) {
    neph_result result = build_cloud(b, i);
    if (result) return result;
  }
  return a->volume_count > 0 ? NEPH_OK : np_plan_leave_out_clouds(b->scene, b->plan);
}

static neph_result build_terrain(const assembly_build *b) {
  const np_scene_terrain *terrain = &b->scene->terrain;
  neph_terrain_desc desc = terrain->desc;
  desc.planet_radius_m = b->scene->atmosphere.planet_radius_m;
  desc.has_place = b->scene->has_place;
  desc.latitude_rad = b->scene->latitude_rad;
  desc.longitude_rad = b->scene->longitude_rad;
  np_schedule_begin(&b->assembly->schedule, b->monitor, NP_WORK_TERRAIN);
  desc.progress = np_monitor_relay;
  desc.progress_user = b->monitor;
  const np_terrain_source source = np_scene_terrain_get_source(terrain);
  return np_terrain_create(b->scene->context, &source, &desc, &b->assembly->terrain);
}

static neph_result find_lights(assembly_build *b) {
  b->lights = b->plan->lights;
  if (b->plan->are_lights_known) return NEPH_OK;
  double latitude = b->scene->latitude_rad, longitude = b->scene->longitude_rad;
  if (!b->scene->has_place && b->assembly->terrain)
    (void)np_terrain_get_place(b->assembly->terrain, &latitude, &longitude);
  return np_scene_lights_find(b->scene, latitude, longitude, &b->lights);
}

static neph_result load_maps(const assembly_build *b) {
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
  const assembly_build *b;
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
  neph_result result =
      np_sky_store_take_atmosphere(scene->context, scene->skies, p->index, &desc, np_plan_has_air_light(p->b->plan),
                                   p->b->monitor, &p->packet->atmosphere);
  np_alloc_free(scene->context, layers);
  return result;
}

static neph_result place_clouds(const packet_build *p) {
  const np_assembly *a = p->b->assembly;
  if (!a->volume_count) return NEPH_OK;
  p->packet->placed = np_alloc(a->context, a->volume_count, sizeof *a->placed);
  if (!p->packet->placed) return NEPH_ERROR_OUT_OF_MEMORY;
  np_instance *placed = p->packet->placed;
  for (unsigned i = 0; i < a->cloud_count; i++) {
    if (!a->volumes[i]) continue;
    *placed = a->placed[i];
    placed++->albedo = np_packet_convert(p->packet, NP_BAND_LINEAR, p->b->scene->clouds[i].albedo);
  }
  return NEPH_OK;
}

/* All that glows in the clouds, for the packet's wavelengths. */
static neph_result build_emission(const packet_build *p) {
  const np_assembly *a = p->b->assembly;
  np_glow glows[NP_INSTANCES_MAX];
  unsigned count = 0;
  const np_instance *placed = p->packet->placed;
  for (unsigned i = 0; i < a->cloud_count; i++) {
    const np_instance *cloud = a->volumes[i] ? placed++ : NULL;
    if (a->glows[i].is_there) glows[count++] = np_cloud_glow_get(&a->glows[i], cloud);
  }
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
  const assembly_build *b = p->b;
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

static neph_result build_packets(const assembly_build *b) {
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

neph_result np_assembly_build(const neph_scene *scene, np_plan *plan, np_monitor *monitor, np_assembly *out_assembly) {
  *out_assembly = (np_assembly){.context = scene->context, .skies = scene->skies, .lights = scene->lights};
  assembly_build b = {.scene = scene, .plan = plan, .monitor = monitor, .assembly = out_assembly};
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
    np_light_store_give_depths(assembly->lights, (np_light_role)role, &assembly->sun_optical_depths[role]);
  for (unsigned i = 0; i < NP_LIGHTS_MAX; i++) np_air_visibility_clear(&assembly->air_visibilities[i]);
  for (unsigned i = 0; i < assembly->cloud_count; i++) {
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

/* SPDX-License-Identifier: Apache-2.0 */
/* Terrain and clouds: read or made, put in their places, and their emission. */
#include <float.h>

#include "cloud/cloud_private.h"
#include "core/alloc.h"
#include "core/file.h"
#include "render/placement_check.h"
#include "render/plan.h"
#include "render/reference_frame.h"
#include "render/stage_builders.h"
#include "render/stage_decisions.h"
#include "volume/volume_private.h"

static neph_result make_terrain(const np_stage_inputs *in, neph_terrain **out) {
  const np_scene_terrain *terrain = &in->scene->terrain;
  neph_terrain_desc desc = terrain->desc;
  desc.progress = np_monitor_relay;
  desc.progress_user = in->monitor;
  const np_terrain_source source = np_scene_terrain_get_source(terrain);
  return np_terrain_create(in->scene->context, &source, &desc, out);
}

/* Given, reused from the picture before, or built. */
neph_result np_stage_build_terrain(const np_stage_inputs *in, np_assembly *out) {
  np_asset_store *store = &in->stores->assets;
  neph_terrain *given = in->scene->terrain.given;
  if (given) return out->terrain = neph_terrain_retain(given), NEPH_OK;
  neph_result result = np_asset_store_take_terrain(store, in->scene, &out->terrain);
  if (result) return result;
  np_log(out->context, NEPH_LOG_DEBUG, "terrain: %s", out->terrain ? "reused" : "built");
  if (out->terrain) return NEPH_OK;
  result = make_terrain(in, &out->terrain);
  if (!result) np_asset_store_put_terrain(store, out->terrain);
  return result;
}

void np_stage_clear_terrain(np_assembly *assembly) { neph_terrain_release(assembly->terrain); }

/* A bake reports, and is stopped, as a part of the picture. */
static neph_result bake(const np_stage_inputs *in, const np_scene_cloud *cloud, const char *path,
                        neph_volume **out_volume) {
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  desc.planet_radius_m = in->scene->atmosphere.planet_radius_m;
  desc.precision = cloud->precision;
  desc.progress = np_monitor_relay;
  desc.progress_user = in->monitor;
  neph_context *context = in->scene->context;
  const neph_cloud_desc at_frame = np_scene_cloud_get_frame(cloud, in->plan->desc.frame);
  if (!path) return neph_cloud_bake(context, &at_frame, &desc, out_volume);
  return neph_cloud_bake_file(context, &at_frame, &desc, "density", path);
}

static neph_volume_load_desc describe_load(const np_stage_inputs *in, const np_scene_cloud *cloud) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  desc.grid = cloud->grid;
  desc.precision = cloud->precision;
  desc.policy = cloud->policy;
  desc.progress = np_monitor_relay;
  desc.progress_user = in->monitor;
  return desc;
}

/* Baked to memory. */
static neph_result obtain_baked(const np_stage_inputs *in, const np_scene_cloud *cloud, neph_volume **out_volume) {
  neph_result result = bake(in, cloud, NULL, out_volume);
  if (result || (*out_volume)->value_max > 0.0f) return result;
  np_log(in->scene->context, NEPH_LOG_WARNING, "cloud %s: nothing of it was baked in frame %d: its coverage is %g",
         cloud->name, in->plan->desc.frame, cloud->bake.coverage);
  neph_volume_release(*out_volume);
  *out_volume = NULL;
  return NEPH_OK;
}

/* A cloud of one frame: read when it is on disk, else baked, to disk where the scene names a file. NULL where it holds
 * nothing. */
static neph_result load_or_bake(const np_stage_inputs *in, const np_scene_cloud *cloud, const char *path,
                                np_cloud_source source, neph_volume **out_volume) {
  neph_result result = NEPH_OK;
  if (!path) return obtain_baked(in, cloud, out_volume);
  if (source == NP_CLOUD_SOURCE_REBAKE)
    np_log(in->scene->context, NEPH_LOG_WARNING, "%s: rebaked: it was baked from other parameters than the scene's",
           path);
  const np_monitor_part whole = np_monitor_get_part(in->monitor);
  np_monitor_set_part(in->monitor, whole, 0.0, 0.8);
  if (source != NP_CLOUD_SOURCE_FILE) result = bake(in, cloud, path, NULL);
  np_monitor_set_part(in->monitor, whole, source != NP_CLOUD_SOURCE_FILE ? 0.8 : 0.0, 1.0);
  const neph_volume_load_desc desc = describe_load(in, cloud);
  return result ? result : np_volume_load_density(in->scene->context, path, &desc, out_volume);
}

/* The volume of a cloud: given, reused from the picture before, or built. */
static neph_result obtain(const np_stage_inputs *in, unsigned index, const char *path, neph_volume **out_volume) {
  const np_scene_cloud *cloud = &in->scene->clouds[index];
  np_asset_store *store = &in->stores->assets;
  const int frame = in->plan->desc.frame;
  if (cloud->volume) return *out_volume = neph_volume_retain(cloud->volume), NEPH_OK;
  np_cloud_source source;
  neph_result result = np_plan_choose_source(in->scene, cloud, path, frame, &source);
  if (result) return result;
  if (!path || source == NP_CLOUD_SOURCE_FILE) *out_volume = np_asset_store_take_volume(store, index);
  np_log(in->scene->context, NEPH_LOG_DEBUG, "cloud %s: %s", cloud->name, *out_volume ? "reused" : "built");
  if (*out_volume) return NEPH_OK;
  result = load_or_bake(in, cloud, path, source, out_volume);
  return result ? result : np_asset_store_put_volume(store, in->scene, index, frame, *out_volume);
}

/* A cloud being placed. */
typedef struct cloud_build {
  const np_stage_inputs *in;
  np_assembly *out;
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
  np_assembly *a = c->out;
  np_phase_table *table = &a->phase_tables[c->index];
  neph_result result = np_phase_table_load(a->context, c->cloud->phase_table, table);
  if (!result) a->placed[c->index].phase = np_phase_tabulated(table);
  return result;
}

static neph_result place_volume(cloud_build *c) {
  np_assembly *a = c->out;
  np_placement placement;
  neph_result result = np_placement_make(c->cloud, &c->anchor, a->volumes[c->index], c->in->monitor, &placement);
  if (result) return result;
  a->placed[c->index] = placement.world;
  a->volume_count++;
  include_box(&c->low, &c->high, placement.bounds_min, placement.bounds_max);
  return load_phase(c);
}

static bool has_emission(const cloud_build *c) {
  return c->cloud->emission.is_enabled && np_plan_needs(c->in->plan, NP_STAGE_EMISSION);
}

/* Emission of a cloud's file. */
static neph_result build_emission(cloud_build *c) {
  np_assembly *a = c->out;
  np_cloud_emission *emission = &a->emissions[c->index];
  if (!c->is_anchored) {
    np_log(a->context, NEPH_LOG_WARNING,
           "cloud %s: its emission is left out of frame %d: position, voxel and optical_depth go by its density, which "
           "is empty",
           c->cloud->name, c->in->plan->desc.frame);
    return NEPH_OK;
  }
  const neph_volume_load_desc load = describe_load(c->in, c->cloud);
  const np_cloud_emission_source source = {a->context,           c->cloud, c->path, &c->anchor.file_to_world,
                                       a->volumes[c->index], &load};
  neph_result result = np_cloud_emission_load(&source, emission);
  if (result || !emission->flame) return result;
  np_dvec3 low, high;
  np_placement_compute_bounds(&emission->emitter.index_to_world, emission->flame, &low, &high);
  include_box(&c->low, &c->high, low, high);
  return NEPH_OK;
}

/* Nothing goes by the anchor of a cloud that holds nothing and does not emit. */
static neph_result get_anchor(cloud_build *c) {
  neph_volume *volume = c->out->volumes[c->index];
  if (!volume && !has_emission(c)) return NEPH_OK;
  const neph_volume_load_desc load = describe_load(c->in, c->cloud);
  const np_stage_inputs *in = c->in;
  const np_frame_cloud of = {&in->stores->references, in->scene, c->index, in->plan->desc.frame, volume, &load,
                             in->monitor};
  return np_reference_frame_get_anchor(&of, &c->anchor, &c->is_anchored);
}

static neph_result build_cloud_at(cloud_build *c) {
  np_assembly *a = c->out;
  np_monitor *monitor = c->in->monitor;
  const np_monitor_part whole = np_monitor_get_part(monitor);
  np_monitor_set_part(monitor, whole, 0.0, 0.7);
  neph_result result = obtain(c->in, c->index, c->path, &a->volumes[c->index]);
  np_monitor_set_part(monitor, whole, 0.7, 0.9);
  np_monitor_set_stage(monitor, "placing clouds");
  if (!result) result = get_anchor(c);
  if (!result && a->volumes[c->index]) result = place_volume(c);
  np_monitor_set_part(monitor, whole, 0.9, 1.0);
  if (!result && has_emission(c)) result = build_emission(c);
  if (result || c->low.x > c->high.x) return result;
  include_box(&a->clouds_min, &a->clouds_max, c->low, c->high);
  np_placement_check(a->context, c->cloud, &a->camera, c->low, c->high);
  return NEPH_OK;
}

static const np_dvec3 nowhere_low = {DBL_MAX, DBL_MAX, DBL_MAX}, nowhere_high = {-DBL_MAX, -DBL_MAX, -DBL_MAX};

static neph_result build_cloud(const np_stage_inputs *in, unsigned index, np_assembly *out) {
  const np_scene_cloud *cloud = &in->scene->clouds[index];
  char *path = cloud->vdb ? np_file_frame_name(out->context, cloud->vdb, in->plan->desc.frame) : NULL;
  if (cloud->vdb && !path) return NEPH_ERROR_OUT_OF_MEMORY;
  cloud_build c = {in, out, cloud, index, path, .low = nowhere_low, .high = nowhere_high};
  neph_result result = build_cloud_at(&c);
  np_alloc_free(out->context, path);
  return result;
}

static neph_result allocate_clouds(const np_stage_inputs *in, np_assembly *a) {
  const unsigned count = in->scene->cloud_count;
  if (count > NP_INSTANCES_MAX)
    return np_fail(a->context, NEPH_ERROR_BAD_SCENE, "the scene has %u clouds, must be at most %d", count,
                   NP_INSTANCES_MAX);
  a->clouds_min = nowhere_low;
  a->clouds_max = nowhere_high;
  a->volumes = np_alloc(a->context, count, sizeof *a->volumes);
  a->placed = np_alloc(a->context, count, sizeof *a->placed);
  a->phase_tables = np_alloc(a->context, count, sizeof *a->phase_tables);
  a->emissions = np_alloc(a->context, count, sizeof *a->emissions);
  if (!a->volumes || !a->placed || !a->phase_tables || !a->emissions) return NEPH_ERROR_OUT_OF_MEMORY;
  a->cloud_count = count;
  return NEPH_OK;
}

/* Those that hold anything, with the albedo of a packet. */
static neph_result place_in_packet(const np_assembly *a, const neph_scene *scene, np_packet *packet) {
  np_instance *placed = packet->placed = np_alloc(a->context, a->volume_count, sizeof *placed);
  if (!placed) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; i < a->cloud_count; i++) {
    if (!a->volumes[i]) continue;
    *placed = a->placed[i];
    placed++->albedo = np_packet_convert(packet, NP_BAND_LINEAR, scene->clouds[i].albedo);
  }
  return NEPH_OK;
}

neph_result np_stage_build_volumes(const np_stage_inputs *in, np_assembly *out) {
  neph_result result = allocate_clouds(in, out);
  if (!result) result = np_asset_store_select(&in->stores->assets, in->scene, in->plan->desc.frame);
  const np_monitor_part whole = np_monitor_get_part(in->monitor);
  for (unsigned i = 0; !result && i < out->cloud_count; i++) {
    np_monitor_set_part(in->monitor, whole, (double)i / out->cloud_count, (i + 1.0) / out->cloud_count);
    result = build_cloud(in, i, out);
  }
  for (unsigned p = 0; !result && out->volume_count > 0 && p < out->packet_count; p++)
    result = place_in_packet(out, in->scene, &out->packets[p]);
  return result;
}

void np_stage_clear_volumes(np_assembly *a) {
  for (unsigned p = 0; p < a->packet_count; p++) np_alloc_free(a->context, a->packets[p].placed);
  for (unsigned i = 0; i < a->cloud_count; i++) {
    neph_volume_release(a->volumes[i]);
    np_phase_table_clear(&a->phase_tables[i]);
    np_cloud_emission_clear(&a->emissions[i]);
  }
  np_alloc_free(a->context, a->emissions);
  np_alloc_free(a->context, a->phase_tables);
  np_alloc_free(a->context, a->volumes);
  np_alloc_free(a->context, a->placed);
}

neph_result np_stage_revise_volumes(const np_assembly *made, const neph_scene *scene, np_plan *plan) {
  return made->volume_count > 0 ? NEPH_OK : np_plan_leave_out_clouds(scene, plan);
}

/* All emitters of the clouds, for the packet's wavelengths. */
neph_result np_stage_build_emission(const np_stage_inputs *in, np_packet *out) {
  const np_assembly *a = in->made;
  np_emitter emitters[NP_INSTANCES_MAX];
  unsigned count = 0;
  const np_instance *placed = out->placed;
  for (unsigned i = 0; i < a->cloud_count; i++) {
    const np_instance *cloud = a->volumes[i] ? placed++ : NULL;
    if (a->emissions[i].is_enabled) emitters[count++] = np_cloud_emission_get(&a->emissions[i], cloud);
  }
  if (count == 0) return NEPH_OK;
  np_monitor_set_stage(in->monitor, "listing emitters");
  return np_emission_build(a->context, emitters, count, out->bands.nm, in->monitor, &out->emission);
}

void np_stage_clear_emission(np_assembly *assembly, np_packet *packet) {
  (void)assembly;
  np_emission_clear(&packet->emission);
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/copies.h"

#include "core/alloc.h"
#include "scene/cloud_places.h"
#include "volume/places.h"

/* ---- Placing ---- */

static neph_result make_copy(neph_context *context, const np_scene_cloud *cloud, const np_placement *origin,
                             const np_cloud_place *place, np_instance *out) {
  const np_affine way = np_cloud_place_get_affine(place);
  np_affine back;
  *out = origin->world;
  if (!np_affine_invert(&way, &back))
    return np_fail(context, NEPH_ERROR_BAD_SCENE, "cloud %s: the transform of one of its places cannot be inverted",
                   cloud->name);
  out->world_to_index = np_affine_compose(&origin->world.world_to_index, &back);
  out->bottom_m = way.m[2][3] + way.m[2][2] * origin->world.bottom_m;
  out->top_m = way.m[2][3] + way.m[2][2] * origin->world.top_m;
  return NEPH_OK;
}

static void include(np_dvec3 box_low, np_dvec3 box_high, np_dvec3 *low, np_dvec3 *high) {
  *low = np_dvec3_min(*low, box_low);
  *high = np_dvec3_max(*high, box_high);
}

neph_result np_copies_make(neph_context *context, const np_scene_cloud *cloud, const np_placement *origin,
                           const np_lod_viewers *viewers, np_cloud_parts *out, np_dvec3 *low, np_dvec3 *high) {
  const np_bricks *bricks = origin->world.bricks;
  if (bricks->is_periodic[0] || bricks->is_periodic[1])
    return np_fail(context, NEPH_ERROR_BAD_SCENE,
                   "cloud %s: its volume repeats without end, and cannot stand in several places: leave out places",
                   cloud->name);
  out->copies = np_alloc(context, cloud->place_count, sizeof *out->copies);
  if (!out->copies) return NEPH_ERROR_OUT_OF_MEMORY;
  out->copy_count = cloud->place_count;
  const double voxel_m = np_placement_get_voxel_edge(&origin->index_to_world);
  const unsigned level_count =
      np_volume_has_parts(out->volume, NP_PARTS_OF_COPIES) ? np_volume_count_parts(out->volume) : 1;
  neph_result result = NEPH_OK;
  for (unsigned i = 0; i < cloud->place_count && !result; i++) {
    np_dvec3 box_low, box_high;
    result = make_copy(context, cloud, origin, &cloud->place[i], &out->copies[i]);
    np_cloud_place_move_box(&cloud->place[i], origin->bounds_min, origin->bounds_max, &box_low, &box_high);
    const double from[3] = {box_low.x, box_low.y, box_low.z}, to[3] = {box_high.x, box_high.y, box_high.z};
    out->copies[i].part = np_lod_choose(viewers, level_count, voxel_m, from, to);
    include(box_low, box_high, low, high);
  }
  out->placed = out->copies[0];
  return result;
}

void np_copies_clear(neph_context *context, np_cloud_parts *parts) {
  np_alloc_free(context, parts->copies);
  parts->copies = NULL;
  parts->copy_count = 0;
}

/* ---- The hierarchy ---- */

/* All places of the parts of clouds that are not empty; 0: each has one. */
static size_t count_places(const np_frame_clouds *clouds) {
  size_t count = 0, copies = 0;
  for (unsigned i = 0; i < clouds->count; i++) {
    const np_cloud_parts *parts = &clouds->at[i];
    if (!parts->volume) continue;
    const unsigned each =
        np_volume_has_parts(parts->volume, NP_PARTS_OF_COPIES) ? 1 : np_volume_count_parts(parts->volume);
    count += each * (size_t)(parts->copies ? parts->copy_count : 1);
    copies += parts->copy_count;
  }
  return copies > 0 ? count : 0;
}

/* Each part of a cloud as the packet has it, in each of the places where it stands; returns the end of what it fills.
 */
static np_instance *fill_part(const np_cloud_parts *parts, const np_instance *placed, unsigned index,
                              np_instance *out) {
  const bool is_one_of_levels = np_volume_has_parts(parts->volume, NP_PARTS_OF_COPIES);
  if (!parts->copies) {
    *out = *placed;
    out->index = index;
    return out + 1;
  }
  for (unsigned k = 0; k < parts->copy_count; k++) {
    const np_instance *at = &parts->copies[k];
    if (is_one_of_levels && at->part != placed->part) continue;
    *out = *placed;
    out->index = index;
    out->world_to_index = np_cloud_parts_get_world_to_index(parts, placed->part, &at->world_to_index);
    out->bottom_m = at->bottom_m;
    out->top_m = at->top_m;
    out++;
  }
  return out;
}

static void fill_places(const np_frame_clouds *clouds, const np_instance *placed, np_instance *out) {
  for (unsigned i = 0, index = 0; i < clouds->count; i++) {
    const np_cloud_parts *parts = &clouds->at[i];
    const unsigned count = parts->volume ? np_volume_count_parts(parts->volume) : 0;
    for (unsigned k = 0; k < count; k++, index++) out = fill_part(parts, &placed[index], index, out);
  }
}

static neph_result check_crowd(neph_context *context, const np_places *places) {
  bool is_crowded = false;
  np_dvec3 point;
  neph_result result = np_places_search_crowd(context, places, NP_PLACES_OVERLAP_MAX, &is_crowded, &point);
  if (result || !is_crowded) return result;
  return np_fail(
      context, NEPH_ERROR_BAD_SCENE,
      "clouds: the boxes of more than %d places lie over each other at (%.4g, %.4g, %.4g) m, must be at most "
      "%d: move places apart, or make them smaller",
      (int)NP_PLACES_OVERLAP_MAX, point.x, point.y, point.z, (int)NP_PLACES_OVERLAP_MAX);
}

neph_result np_copies_build_places(neph_context *context, const np_frame_clouds *clouds, np_placed_clouds *placed) {
  const size_t count = count_places(clouds);
  if (count == 0) return NEPH_OK;
  if (count > NP_PLACES_MAX)
    return np_fail(context, NEPH_ERROR_BAD_SCENE, "clouds: have %zu places in all, must have at most %d", count,
                   (int)NP_PLACES_MAX);
  np_instance *all = np_alloc(context, count, sizeof *all);
  if (!all) return NEPH_ERROR_OUT_OF_MEMORY;
  fill_places(clouds, placed->at, all);
  const neph_result result = np_places_build(context, all, (uint32_t)count, &placed->places);
  return result ? result : check_crowd(context, &placed->places);
}

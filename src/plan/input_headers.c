/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/input_headers.h"

#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "plan/georeference.h"
#include "plan/placement.h"
#include "scene/cloud_file.h"
#include "volume/volume_private.h"

const np_input_file *np_inputs_get_file(const np_inputs *inputs, unsigned cloud) {
  static const np_input_file unknown = {.is_known = false};
  return cloud < inputs->file_count ? &inputs->files[cloud] : &unknown;
}

/* A file's box is as its writer had it: of any numbers. */
static int32_t count_between(int32_t first, int32_t last) {
  const int64_t count = (int64_t)last - first + 1;
  return count < 0 ? 0 : count > INT32_MAX ? INT32_MAX : (int32_t)count;
}

/* World box of a file's grid, placed by the grid's own box whatever frame the scene refers to. */
static neph_result place_box(const neph_scene *scene, const np_scene_cloud *cloud, const np_grid_header *header,
                             np_input_file *out) {
  neph_volume outline = {.index_to_world = header->index_to_world};
  memcpy(outline.active_min, header->active_min, sizeof outline.active_min);
  memcpy(outline.active_max, header->active_max, sizeof outline.active_max);
  np_scene_cloud hollow = *cloud;
  hollow.density_unit = NP_DENSITY_EXTINCTION; /* whatever its optical depth */
  np_anchor anchor;
  np_georeference georeference;
  neph_result result = np_placement_anchor(&hollow, &outline, NULL, &anchor);
  if (!result) result = np_georeference_apply(scene, cloud, &outline, &anchor.file_to_world, &georeference);
  out->index_to_world = np_affine_compose(&anchor.file_to_world, &outline.index_to_world);
  np_placement_compute_bounds(&out->index_to_world, &outline, &out->low, &out->high);
  for (int a = 0; a < 3; a++) out->size[a] = count_between(header->active_min[a], header->active_max[a]);
  out->voxel_count = header->voxel_count;
  out->extinction_per_value = header->extinction_per_value;
  out->level_count = header->level_count;
  out->is_known = !result && header->voxel_count > 0.0;
  return result;
}

neph_result np_input_file_read(const neph_scene *scene, const np_request *request, const np_scene_cloud *cloud,
                               np_input_file *out) {
  const neph_volume_load_desc load = np_cloud_file_describe_load(cloud);
  np_cloud_file file;
  np_grid_header header = {.has_box = false};
  bool has_colors = false;
  *out = (np_input_file){.is_known = false};
  neph_result result = np_cloud_file_get(scene->context, cloud, request->desc.frame, &file);
  const bool is_present = file.path && np_file_exists(file.path); /* opening reports a missing file */
  if (!result && is_present)
    result = np_volume_read_header(scene->context, file.path, &load, np_cloud_file_get_sequence(cloud), &header);
  if (!result && is_present && !np_scene_is_none(cloud->color))
    result = np_volume_search_vector(scene->context, file.path, NP_VECTOR_COLOR, cloud->color, &has_colors);
  np_alloc_free(scene->context, file.path);
  if (result || !header.has_box || header.state != NP_GRID_FILLED) return result;
  out->has_colors = has_colors;
  return place_box(scene, cloud, &header, out);
}

double np_input_file_get_share(const np_input_file *file) {
  return fmin(file->voxel_count / ((double)file->size[0] * file->size[1] * file->size[2]), 1.0);
}

/* Upper limit of the optical depth assumed for clouds whose density is not read yet: the value of a cumulus. */
static const double depth_unread = 40.0;

/* Guesses the extinction of an unread file: the densest column has the mean fill of the box; the largest value counts
 * as 1 where that gives no denser cloud. */
double np_input_file_get_period_m(const np_scene_cloud *cloud, const np_input_file *file, int axis) {
  if (cloud->repeat != NP_REPEAT_FILE) return cloud->repeat == NP_REPEAT_LENGTHS ? cloud->repeat_m[axis] : 0.0;
  const double(*m)[4] = file->index_to_world.m;
  return file->size[axis] * np_dvec3_length(np_dvec3_make(m[0][axis], m[1][axis], m[2][axis]));
}

double np_input_file_guess_extinction(const np_scene_cloud *cloud, const np_input_file *file) {
  const bool is_scaled = cloud->density_unit == NP_DENSITY_OPTICAL_DEPTH;
  const double depth = is_scaled ? cloud->density_value : depth_unread;
  const double of_depth = depth / ((file->high.z - file->low.z) * fmax(np_input_file_get_share(file), 0.25));
  return is_scaled ? of_depth : fmin(of_depth, np_placement_get_extinction(cloud, file->extinction_per_value));
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/cloud_file.h"

#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/frame_name.h"
#include "volume/volume_sizes.h"

static double compute_number(const np_scene_cloud *cloud, int frame) {
  return np_scene_cloud_is_sequence(cloud) ? np_scene_cloud_get_number(cloud, frame) : frame;
}

/* Last number not above the requested one, or the first number; the request may wrap around before. */
static double choose_number(const np_frame_numbers *there, np_missing missing, double wanted) {
  const double first = there->numbers[0], period = there->numbers[there->count - 1] - first + 1.0;
  if (missing == NP_MISSING_LOOP) wanted -= floor((wanted - first) / period) * period;
  size_t i = 0;
  while (i + 1 < there->count && there->numbers[i + 1] <= wanted) i++;
  return there->numbers[i];
}

static neph_result set_number(neph_context *context, const np_scene_cloud *cloud, double number, np_cloud_file *file) {
  np_alloc_free(context, file->path);
  file->number = np_frame_name_round(cloud->vdb, number);
  file->path = np_frame_name_make(context, cloud->vdb, number);
  return file->path ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result replace_missing(neph_context *context, const np_scene_cloud *cloud, np_cloud_file *file) {
  np_frame_numbers there;
  neph_result result = np_frame_name_list(context, cloud->vdb, &there);
  if (!result && there.count && cloud->missing == NP_MISSING_EMPTY) {
    np_alloc_free(context, file->path);
    file->path = NULL;
  } else if (!result && there.count)
    result = set_number(context, cloud, choose_number(&there, cloud->missing, file->number), file);
  np_alloc_free(context, there.numbers);
  return result;
}

neph_result np_cloud_file_get(neph_context *context, const np_scene_cloud *cloud, int frame, np_cloud_file *out_file) {
  *out_file = (np_cloud_file){.path = NULL};
  neph_result result = set_number(context, cloud, compute_number(cloud, frame), out_file);
  const bool is_final = !np_scene_cloud_is_sequence(cloud) || cloud->missing == NP_MISSING_ERROR;
  if (!result && !is_final && !np_file_exists(out_file->path)) result = replace_missing(context, cloud, out_file);
  return result;
}

neph_volume_load_desc np_cloud_file_describe_load(const np_scene_cloud *cloud) {
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  desc.grid = cloud->grid;
  desc.precision = cloud->precision;
  desc.policy = cloud->policy;
  desc.level_set_voxels = cloud->level_set_voxels;
  desc.ramp = cloud->ramp;
  desc.interpolation = cloud->interpolation;
  desc.repeat_voxel_m = cloud->voxel_m;
  for (int a = 0; a < 2 && cloud->repeat != NP_REPEAT_NONE; a++) {
    desc.repeat_m[a] = cloud->repeat == NP_REPEAT_FILE ? NEPH_REPEAT_FILE : cloud->repeat_m[a] / fabs(cloud->scale[a]);
    desc.repeat_reach_m[a] = cloud->repeat_reach_m / fabs(cloud->scale[a]);
  }
  desc.model = cloud->model;
  return desc;
}

const char *np_cloud_file_get_sequence(const np_scene_cloud *cloud) {
  return np_scene_cloud_is_sequence(cloud) ? cloud->vdb : NULL;
}

static void add_vector(np_file_use *use, np_vector_role role, const char *name) {
  if (np_scene_is_none(name)) return;
  use->vectors[use->vector_count++] = (np_vector_request){role, name, use->load.policy};
}

static const char *get_field(const char *name, const char *usual) {
  return np_scene_is_none(name) ? NULL : name ? name : usual;
}

np_file_use np_cloud_file_describe_use(const neph_scene *scene, const np_scene_cloud *cloud) {
  const np_scene_emission *emission = &cloud->emission;
  np_file_use use = {.load = np_cloud_file_describe_load(cloud),
                     .sequence = np_cloud_file_get_sequence(cloud),
                     .has_up = cloud->has_up};
  add_vector(&use, NP_VECTOR_COLOR, cloud->color);
  if (scene->motion_blur.is_enabled || scene->output.aovs & NP_AOV_MOTION)
    add_vector(&use, NP_VECTOR_VELOCITY, cloud->velocity);
  if (np_scene_cloud_has_sizes(cloud)) use.fields[2] = get_field(cloud->sizes, NP_SIZES_USUAL_NAME);
  if (!emission->is_enabled) return use;
  add_vector(&use, NP_VECTOR_EMISSION, emission->color);
  use.fields[0] = get_field(emission->temperature, "temperature");
  use.fields[1] = get_field(emission->flame, "flame");
  return use;
}

void np_cloud_file_add_model_to_hash(np_hash *hash, const np_scene_cloud *cloud) {
  const neph_volume_model *model = &cloud->model;
  np_hash_add_text(hash, model->variable);
  np_hash_add_text(hash, model->ice);
  np_hash_add_text(hash, model->radius);
  np_hash_add_text(hash, model->number);
  NP_HASH_ADD(hash, model->r_eff_m);
  NP_HASH_ADD(hash, model->ice_r_eff_m);
  NP_HASH_ADD(hash, model->number_per_m3);
  NP_HASH_ADD(hash, model->dispersion);
  NP_HASH_ADD(hash, model->spacing_m);
  NP_HASH_ADD(hash, model->step);
  NP_HASH_ADD(hash, model->beyond);
}

void np_cloud_file_add_to_hash(np_hash *hash, const np_scene_cloud *cloud) {
  NP_HASH_ADD(hash, cloud->policy);
  NP_HASH_ADD(hash, cloud->level_set_voxels);
  NP_HASH_ADD(hash, cloud->ramp);
  np_cloud_file_add_model_to_hash(hash, cloud);
  NP_HASH_ADD(hash, cloud->precision);
  NP_HASH_ADD(hash, cloud->interpolation);
  NP_HASH_ADD(hash, cloud->repeat);
  NP_HASH_ADD(hash, cloud->repeat_m);
  NP_HASH_ADD(hash, cloud->scale);
  NP_HASH_ADD(hash, cloud->up);
  NP_HASH_ADD(hash, cloud->tilt_rad);
  NP_HASH_ADD(hash, cloud->rotation_rad);
}

void np_cloud_file_add_placement_to_hash(np_hash *hash, const np_scene_cloud *cloud) {
  np_cloud_file_add_to_hash(hash, cloud);
  NP_HASH_ADD(hash, cloud->voxel_m);
  NP_HASH_ADD(hash, cloud->has_position);
  NP_HASH_ADD(hash, cloud->position_m);
  NP_HASH_ADD(hash, cloud->pivot);
  NP_HASH_ADD(hash, cloud->pivot_point);
  NP_HASH_ADD(hash, cloud->density_unit);
  NP_HASH_ADD(hash, cloud->density_value);
}

void np_cloud_file_warn(neph_context *context, const np_scene_cloud *cloud, int frame, const np_cloud_file *file) {
  const char *slash = strrchr(cloud->vdb, '/');
  np_log(context, NEPH_LOG_WARNING,
         "cloud %s: frame %d is empty: %s has no file of number %g (missing: hold or loop shows another)", cloud->name,
         frame, slash ? slash + 1 : cloud->vdb, file->number);
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/cloud_load.h"

#include "cloud/bake_volume.h"
#include "plan/plan.h"
#include "plan/plan_detail.h"
#include "scene/cloud_file.h"
#include "scene/cloud_ground.h"
#include "volume/volume_private.h"
#include "volume/volume_sizes.h"

neph_bake_desc np_cloud_load_describe_bake(const np_plan *plan, const neph_scene *scene, const np_scene_cloud *cloud) {
  neph_bake_desc desc = np_plan_get_bake_desc(&plan->request, scene, cloud);
  desc.precision = np_plan_get_precision(plan, cloud);
  return desc;
}

/* A bake reports, and is stopped, as a part of the picture. */
static neph_result bake(const np_volumes_inputs *in, const np_scene_cloud *cloud, const char *path,
                        neph_volume **out_volume) {
  neph_bake_desc desc = np_cloud_load_describe_bake(in->plan, in->scene, cloud);
  desc.memory_max_bytes = in->plan->request.desc.memory_max_bytes;
  desc.progress = np_monitor_relay;
  desc.progress_user = in->monitor;
  if (path) np_plan_describe_file_bake(in->scene, cloud, &desc);
  neph_context *context = in->scene->context;
  neph_cloud_desc at_frame = np_plan_get_bake(&in->plan->request, in->scene, cloud);
  np_cloud_ground ground;
  neph_result result = np_cloud_ground_give(in->scene, in->terrain, &at_frame, &ground);
  if (result) return result;
  const bool is_sketch = np_request_has_sketches(&in->plan->request);
  if (!path && is_sketch) return np_cloud_bake_sketch(context, &at_frame, &desc, out_volume);
  if (!path) return neph_cloud_bake(context, &at_frame, &desc, out_volume);
  return neph_cloud_bake_file(context, &at_frame, &desc, "density", path);
}

neph_volume_load_desc np_cloud_load_describe(const np_volumes_inputs *in, const np_scene_cloud *cloud) {
  neph_volume_load_desc desc = np_cloud_file_describe_load(cloud);
  desc.precision = np_plan_get_precision(in->plan, cloud);
  desc.is_halved = in->plan->savings.are_coarse;
  desc.progress = np_monitor_relay;
  desc.progress_user = in->monitor;
  return desc;
}

/* Baked to memory. */
static neph_result obtain_baked(const np_volumes_inputs *in, const np_scene_cloud *cloud, neph_volume **out_volume) {
  neph_result result = bake(in, cloud, NULL, out_volume);
  if (result || (*out_volume)->value_max > 0.0f) return result;
  np_log(in->scene->context, NEPH_LOG_WARNING, "cloud %s: nothing of it was baked in frame %d: its coverage is %g",
         cloud->name, in->plan->request.desc.frame, cloud->bake.coverage);
  neph_volume_release(*out_volume);
  *out_volume = NULL;
  return NEPH_OK;
}

/* Levels of detail have one colour, and so have the levels of a frustum, and clouds that repeat without end. */
static neph_result warn_of_colors(const np_volumes_inputs *in, const np_scene_cloud *cloud, const char *path) {
  bool is_found = false;
  const neph_result result =
      np_volume_search_vector(in->scene->context, path, NP_VECTOR_COLOR, cloud->color, &is_found);
  if (is_found)
    np_log(in->scene->context, NEPH_LOG_WARNING,
           "cloud %s: the colours of %s are left out: a cloud in levels of detail, or that repeats, is of one colour; "
           "clouds[].color: none says so",
           cloud->name, path);
  return result;
}

/* Gives a cloud from a file the colours that it has there. */
static neph_result add_colors(const np_volumes_inputs *in, const np_scene_cloud *cloud, const char *path,
                              neph_volume *volume) {
  if (cloud->is_baked || !volume || np_scene_is_none(cloud->color)) return NEPH_OK;
  if (volume->tint || cloud->repeat != NP_REPEAT_NONE) return warn_of_colors(in, cloud, path);
  const neph_volume_load_desc load = np_cloud_load_describe(in, cloud);
  const np_tint_source source = {path, cloud->color, &load, volume};
  return np_tint_create(in->scene->context, &source, in->monitor, &volume->tint);
}

/* A cloud has colours or levels of detail, or sizes of droplets. */
static neph_result warn_of_sizes(const np_volumes_inputs *in, const np_scene_cloud *cloud, const char *path) {
  const char *name = cloud->sizes ? cloud->sizes : NP_SIZES_USUAL_NAME;
  np_grid_header header;
  const neph_result result = np_volume_read_field_header(in->scene->context, path, name, NULL, &header);
  if (!result && header.state == NP_GRID_FILLED)
    np_log(in->scene->context, NEPH_LOG_WARNING,
           "cloud %s: the sizes of droplets of %s are left out: a cloud with colours or in levels of detail has one "
           "size; clouds[].phase.droplets.sizes: none says so",
           cloud->name, path);
  return result;
}

/* Gives a cloud from a file the sizes of droplets that it has there. */
static neph_result add_sizes(const np_volumes_inputs *in, const np_scene_cloud *cloud, const char *path,
                             neph_volume *volume) {
  if (!volume || !np_scene_cloud_has_sizes(cloud)) return NEPH_OK;
  if (volume->tint) return warn_of_sizes(in, cloud, path);
  const neph_volume_load_desc load = np_cloud_load_describe(in, cloud);
  const np_sizes_source source = {path, cloud->sizes, &load, volume, cloud->phase_source.diameter_m};
  return np_tint_create_sizes(in->scene->context, &source, in->monitor, &volume->tint);
}

neph_result np_cloud_load(const np_volumes_inputs *in, const np_scene_cloud *cloud, const char *path,
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
  const neph_volume_load_desc desc = np_cloud_load_describe(in, cloud);
  const char *sequence = np_cloud_file_get_sequence(cloud);
  if (!result) result = np_volume_load_density(in->scene->context, path, &desc, sequence, out_volume);
  if (!result && *out_volume)
    result = np_scene_check_cloud_unit(in->scene, in->cloud, path, (*out_volume)->extinction_per_value);
  if (!result) result = add_colors(in, cloud, path, *out_volume);
  if (!result) result = add_sizes(in, cloud, path, *out_volume);
  if (!result || !*out_volume) return result;
  neph_volume_release(*out_volume);
  *out_volume = NULL;
  return result;
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "render/placement_check.h"

static const double smallest_m = 10.0, largest_m = 1e6;

static void warn_of_view(neph_context *context, const np_scene_cloud *cloud, np_dvec3 low, np_dvec3 high) {
  np_log(context, NEPH_LOG_WARNING,
         "cloud %s: lies wholly outside the view, from (%.3g, %.3g, %.3g) to (%.3g, %.3g, %.3g) km: check %s, and "
         "camera.look_at",
         cloud->name, 1e-3 * low.x, 1e-3 * low.y, 1e-3 * low.z, 1e-3 * high.x, 1e-3 * high.y, 1e-3 * high.z,
         cloud->is_baked ? "bake.center and bake.base" : "position, voxel and up");
}

static void warn_of_size(neph_context *context, const np_scene_cloud *cloud, double size_m) {
  const char *keys = cloud->is_baked ? "bake.extent and scale" : "voxel and scale";
  if (size_m < smallest_m)
    np_log(context, NEPH_LOG_WARNING, "cloud %s: is %.3g m across, less than %g m: check %s", cloud->name, size_m,
           smallest_m, keys);
  else
    np_log(context, NEPH_LOG_WARNING, "cloud %s: is %.4g km across, more than %g km: check %s", cloud->name,
           1e-3 * size_m, 1e-3 * largest_m, keys);
}

void np_placement_check(neph_context *context, const np_scene_cloud *cloud, const np_camera *camera, np_dvec3 low,
                        np_dvec3 high) {
  const np_dvec3 size = np_dvec3_subtract(high, low);
  const double size_m = fmax(fmax(size.x, size.y), size.z);
  if (size_m < smallest_m || size_m > largest_m) warn_of_size(context, cloud, size_m);
  if (!np_camera_sees_box(camera, low, high)) warn_of_view(context, cloud, low, high);
}

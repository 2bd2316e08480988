/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/level_samples.h"

#include <math.h>

#include "core/math.h"

double np_level_samples_compute_lowest(const np_cloud_model *model, double x_m, double y_m) {
  const neph_cloud_desc *desc = &model->desc;
  const np_dvec3 place = {desc->center_m[0] + x_m, desc->center_m[1] + y_m, desc->base_altitude_m};
  const double fall_m = np_altitude(place, model->planet_radius_m) - desc->base_altitude_m;
  const double grains = fall_m / desc->voxel_m + 0.5;
  return grains - floor(grains);
}

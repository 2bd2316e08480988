/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/waterline.h"

#include <math.h>

#include "cloud/census.h"
#include "cloud/cloud_kinds.h"

void np_waterline_set(np_cloud_model *model, float waterline) {
  const float range = model->map.highest - waterline;
  model->waterline = waterline;
  model->depth_scale = 1.0f / range;
  model->depth_offset = -waterline / range;
  model->slope_per_m = 2.0f / (model->map.radius_m * sqrtf(range));
  if (model->kind->set_edges) model->kind->set_edges(model);
}

void np_waterline_update_best(np_cloud_model *model, double fraction, np_waterline *best) {
  const double miss = fabs(fraction - model->map.coverage);
  if (!(miss < best->miss)) return;
  *best = (np_waterline){model->waterline, miss};
  model->covered = fraction;
}

bool np_waterline_is_best(const np_cloud_model *model) { return model->sample_count > 1 || model->map.levels; }

/* Bisection: the covered share falls as the waterline rises. The census includes billows and creases at outlines, which
 * have no formula. */
neph_result np_waterline_search(np_cloud_model *model, np_monitor *monitor) {
  const float spread = model->map.highest - model->map.lowest;
  float low = model->map.lowest - 0.5f * spread, high = model->map.highest - 0.01f * spread;
  np_waterline best = {.miss = INFINITY};
  const int steps = np_waterline_count_steps(model);
  for (int step = 0; step < steps; step++) {
    double fraction = 0;
    const float middle = 0.5f * (low + high);
    np_waterline_set(model, middle);
    neph_result result = np_census_count(model, monitor, &fraction);
    if (result) return result;
    np_waterline_update_best(model, fraction, &best);
    *(fraction > model->map.coverage ? &low : &high) = middle;
  }
  np_waterline_set(model, np_waterline_is_best(model) ? best.value : 0.5f * (low + high));
  return NEPH_OK;
}

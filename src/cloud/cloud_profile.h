/* SPDX-License-Identifier: Apache-2.0 */
/* Height profiles of columns. */
#ifndef NP_CLOUD_CLOUD_PROFILE_H
#define NP_CLOUD_CLOUD_PROFILE_H

#include "cloud/cloud_model.h"
#include "core/math.h"

/* The description's profile at s, clamped to [0, 1]. */
static inline float np_cloud_profile_eval_curve(const neph_cloud_desc *desc, float s) {
  float scaled = np_clampf(s, 0.0f, 1.0f) * (NEPH_CLOUD_PROFILE_POINTS - 1);
  int i = (int)scaled;
  if (i > NEPH_CLOUD_PROFILE_POINTS - 2) i = NEPH_CLOUD_PROFILE_POINTS - 2;
  return np_mixf((float)desc->profile[i], (float)desc->profile[i + 1], scaled - (float)i);
}

/* Height profile of a tower for s ≥ 0. It never falls, and is 1 + gain at the top, which noise can just reach. A higher
 * type raises it: taller clouds for strong cells, lower ones for the others. */
static inline float np_cloud_profile_eval_tower(const np_cloud_model *model, float s, float type) {
  const float s2 = s * s, flat = s2 * s2, tall = s2;
  const float shape =
      model->desc.has_profile ? np_cloud_profile_eval_curve(&model->desc, s) : np_mixf(flat, tall, type);
  return shape * (1.0f + model->base_gain_max + model->detail_gain_max);
}

#endif

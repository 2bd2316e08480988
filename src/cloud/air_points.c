/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud/air_points.h"

#include <math.h>

#include "cloud/cloud_streams.h"
#include "cloud/repeat.h"

static const float edge_size = 0.03f; /* width of the crisp edge, in largest billows */
static const float soft_edge = 0.9f;  /* width of the softest edge, in depth */

void np_air_points_set_curl(np_cloud_model *model, float size, float reach) {
  const float billow_m = (float)model->desc.billow_m, size_m = size * billow_m;
  model->curl = np_cloud_make_lattice(&model->desc, NP_CLOUD_STREAM_CURL);
  model->curl_frequency_per_m = 1.0f / np_repeat_fit(&model->desc, size_m);
  np_repeat_set_period(&model->desc, size_m, 1.0f, &model->curl);
  model->curl_distance_m = reach * billow_m * (float)model->desc.turbulence;
}

void np_air_points_set_edge(np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  model->edge = model->slope_per_m * fmaxf(edge_size * (float)desc->billow_m, 0.75f * (float)desc->voxel_m) +
                soft_edge * (float)(desc->softness * desc->softness);
}

void np_air_points_displace(const np_cloud_model *model, np_air_points *w) {
  float dx[NP_CLOUD_BLOCK], dy[NP_CLOUD_BLOCK], dz[NP_CLOUD_BLOCK];
  if (!(model->curl_distance_m > 0.0f)) return;
  const np_noise_points points = np_air_points_scale(w, model->curl_frequency_per_m, 0.5f * model->turnover);
  model->noise->curl(&model->curl, &points, dx, dy, dz);
  for (size_t i = 0; i < w->count; i++) {
    const float distance = model->curl_distance_m * (1.0f - 0.6f * w->state[i].share);
    w->x_m[i] += distance * dx[i];
    w->y_m[i] += distance * dy[i];
    w->height_m[i] += distance * dz[i];
  }
}

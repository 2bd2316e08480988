/* SPDX-License-Identifier: Apache-2.0 */
/* Anvils of ice on towers of thermals: a sheet below the top that flares down to the tower, striated along the shear,
 * with pouches, mammatus, on its lower face. */
#include <math.h>

#include "cloud/cloud_kinds.h"
#include "core/math.h"

static const float striation_size = 0.5f, striation_stretch = 8.0f, striation_reach = 0.62f; /* sizes in billows */
static const float pouch_size = 0.26f, pouch_reach = 0.26f; /* reaches in depth of the anvil's column */
static const float edge = 0.32f;                            /* in such depth too */
static const float thinness = 0.13f;                        /* of ice against water */
static const float extinction_floor = 0.002f;

/* The most that noise adds to the depth. */
float np_anvil_get_gain(void) { return 0.5f * striation_reach + 0.3f * pouch_reach; }

static void add_noise(const np_cloud_model *model, np_kind_points *p, float *depth) {
  const neph_cloud_desc *desc = &model->desc;
  const float size_m = striation_size * (float)desc->billow_m, pouch_m = pouch_size * (float)desc->billow_m;
  const np_noise_octaves octaves = {.count = np_kind_count_octaves(desc, size_m), .gain = 0.55f};
  np_noise_lattice of_striations = np_kind_make_lattice(desc, NP_CLOUD_STREAM_SHEET);
  np_noise_lattice of_pouches = np_kind_make_lattice(desc, NP_CLOUD_STREAM_BASE);
  of_striations = np_kind_wrap(model, &of_striations, size_m, striation_stretch);
  of_pouches = np_kind_wrap(model, &of_pouches, pouch_m, 1.0f);
  np_noise_points points = np_kind_scale(model, p, size_m, striation_stretch);
  model->noise->value_fbm(&of_striations, &octaves, &points, p->noise);
  for (size_t i = 0; i < p->count; i++)
    depth[i] += striation_reach * np_clampf(1.8f * (p->noise[i] - 0.5f), -0.5f, 0.5f);
  points = np_kind_scale(model, p, pouch_m, 1.0f);
  for (size_t i = 0; i < p->count; i++) p->sz[i] *= 0.5f;
  model->noise->worley(&of_pouches, &points, p->noise);
  for (size_t i = 0; i < p->count; i++) /* `ground_m`: share of the lower face */
    depth[i] += pouch_reach * p->ground_m[i] * (0.3f - p->noise[i]);
}

void np_anvil_eval(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  const neph_cloud_desc *desc = &model->desc;
  np_kind_points p = {.count = 0};
  float depth[NP_CLOUD_BLOCK];
  for (size_t i = 0; i < points->count; i++) {
    const np_cloud_column column = np_cloud_column_compute(model, points->x_m[i], points->y_m[i], points->height_m[i]);
    const float above = np_cloud_column_eval_anvil(&column, points->height_m[i]);
    if (!(above + np_anvil_get_gain() > 0.0f)) continue;
    const size_t n = p.count++;
    const float share = (points->height_m[i] - column.base_m) / column.thickness_m;
    p.index[n] = (uint16_t)i;
    p.x_m[n] = column.x_m - model->drift_m[0];
    p.y_m[n] = column.y_m - model->drift_m[1];
    p.height_m[n] = points->height_m[i];
    p.ground_m[n] = 1.0f - np_smoothstepf((share - 0.74f) / 0.1f);
    depth[n] = above;
  }
  if (p.count == 0) return;
  add_noise(model, &p, depth);
  for (size_t i = 0; i < p.count; i++) {
    float *out = &out_extinction_per_m[p.index[i]];
    const float body = np_smoothstepf(depth[i] / edge) * thinness;
    if (body > extinction_floor) *out = np_maxf(*out, (float)desc->extinction_per_m * body);
  }
}

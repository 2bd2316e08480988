/* SPDX-License-Identifier: Apache-2.0 */
/* Fog, and stratus in valleys: everything below its top, down to the ground.
 *
 * The top is a swell with rolls of billows, lower where the weather map is weak. Extinction depends on the depth below
 * it, in metres: fine noise frays the uppermost part, and extinction grows over a soft edge. Where the ground comes
 * near the top the fog thins out, as cold air drains off slopes. A base above the ground is ragged. */
#include <math.h>

#include "cloud/cloud_kinds.h"
#include "cloud/kind_points.h"
#include "cloud/waterline.h"
#include "core/math.h"

static const float swell_size = 4.1f;    /* in billows */
static const float top_share_max = 0.4f; /* limit of swell and billows together, relative to the thickness */
static const float swell_reach = 0.35f, roll_reach = 0.65f; /* shares of that relief */
static const float fray_size = 0.55f;                       /* size of the fine noise, in billows */
static const float fray_share_max = 0.5f;  /* limit of the fine noise at erosion 1, relative to the thickness */
static const float patch_strength = 0.12f; /* strength of the map at which patches have their full height */
static const float patch_sink = 0.6f, shore_sink = 0.16f; /* relative to the thickness */
static const float shore_share =
    0.35f; /* range of ground height over which fog deepens off a slope, relative to the thickness */
static const float feather_share =
    0.15f; /* width over which fog thins out towards the border, relative to the shorter side of the field */
static const float feather_sink =
    0.2f; /* lowering of the top at the border, relative to the thickness; more would uncover the rim */
static const float feather_fray = 0.5f;   /* displacement of that rim by fine noise, relative to its width */
static const float feather_wander = 1.0f; /* displacement of that rim by the swell, relative to its width */
static const float extinction_floor = 0.004f;
static const float base_edge_m = 90.0f;
static const float texel_rise = 1.0f; /* slope of the ground that texels may miss */

static float get_relief_m(const neph_cloud_desc *desc) {
  return np_minf((float)(desc->billowiness * desc->billow_m), top_share_max * (float)desc->thickness_m);
}

static void prepare_fog(np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  np_kind_noises *k = &model->noises;
  k->coarse = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_SHEET);
  k->medium = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_BASE);
  k->fine = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_DETAIL);
  k->fine_m = np_maxf(fray_size * (float)desc->billow_m, 3.0f * (float)desc->voxel_m);
  k->fine_octaves = np_kind_count_octaves(desc, k->fine_m);
  k->edge_m = np_maxf((0.06f + 1.2f * (float)(desc->softness * desc->softness)) * (float)desc->billow_m,
                      1.5f * (float)desc->voxel_m);
}

/* Value noise stretched to [0, 1]. */
static float spread(float noise) { return np_clampf(2.2f * (noise - 0.5f) + 0.5f, 0.0f, 1.0f); }

/* Depth below the top before fine noise, and the noise of the swell. */
static void compute_depths(const np_cloud_model *model, np_kind_points *p, float *out_depth_m, float *out_swell) {
  static const np_noise_octaves octaves = {.count = 2, .gain = 0.45f};
  const neph_cloud_desc *desc = &model->desc;
  const np_kind_noises *k = &model->noises;
  const float top_m = (float)desc->thickness_m, relief_m = get_relief_m(desc), billow_m = (float)desc->billow_m;
  np_noise_points points = np_kind_scale(model, p, swell_size * billow_m, 1.0f);
  for (size_t i = 0; i < p->count; i++) p->sz[i] = 0.43f - 0.4f * model->turnover;
  model->noise->value_fbm(&k->coarse, &octaves, &points, out_swell);
  for (size_t i = 0; i < p->count; i++)
    out_depth_m[i] = top_m - p->height_m[i] - swell_reach * relief_m * (1.0f - out_swell[i]);
  points = np_kind_scale(model, p, billow_m, (float)desc->stretch);
  model->noise->worley_fbm(&k->medium, &octaves, &points, p->noise);
  for (size_t i = 0; i < p->count; i++) out_depth_m[i] -= roll_reach * relief_m * (1.0f - p->noise[i]);
}

/* Fine noise and noise of the swell at a point, in [0, 1]. */
typedef struct point_noise {
  float fine, swell;
} point_noise;

/* Fade-out at the border of the field, so that fog ends neither as a wall nor along a line. */
static float compute_feather(const neph_cloud_desc *desc, const np_kind_points *p, size_t i, point_noise noise) {
  if (desc->repeat_m > 0) return 1.0f;
  const float inverse = 1.0f / (feather_share * (float)fmin(desc->extent_m[0], desc->extent_m[1]));
  const float dx = (0.5f * (float)desc->extent_m[0] - fabsf(p->field_x_m[i])) * inverse;
  const float dy = (0.5f * (float)desc->extent_m[1] - fabsf(p->field_y_m[i])) * inverse;
  const float stretch = 1.0f + feather_fray * (noise.fine - 0.5f) + feather_wander * (noise.swell - 0.5f);
  return np_smoothstepf(dx * stretch) * np_smoothstepf(dy * stretch);
}

/* Factor on the depth at a point, by the map, the border and the ground. */
static float compute_fullness(const np_cloud_model *model, const np_kind_points *p, size_t i, point_noise noise,
                              float *out_sunk_m) {
  const float top_m = (float)model->desc.thickness_m;
  const float patch = np_smoothstepf(p->strength[i] / patch_strength);
  const float feather = compute_feather(&model->desc, p, i, noise);
  const float column_m = top_m - np_maxf(p->ground_m[i], 0.0f);
  const float shore = np_smoothstepf(column_m / (shore_share * top_m));
  *out_sunk_m = top_m * (patch_sink * (1.0f - patch) + shore_sink * (1.0f - shore) + feather_sink * (1.0f - feather));
  return patch * feather * np_mixf(0.3f, 1.0f, shore);
}

static void eval_fog(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  np_kind_points p;
  if (!np_kind_points_collect(model, points, &p)) return;
  const neph_cloud_desc *desc = &model->desc;
  const np_kind_noises *k = &model->noises;
  const np_noise_octaves octaves = {.count = k->fine_octaves, .gain = 0.55f};
  const float margin_m = texel_rise * model->map.step_m + 2.0f * (float)desc->voxel_m;
  const float fray_m = (float)desc->erosion * np_minf(2.2f * k->fine_m, fray_share_max * (float)desc->thickness_m);
  float depth_m[NP_CLOUD_BLOCK], swell[NP_CLOUD_BLOCK];
  compute_depths(model, &p, depth_m, swell);
  const np_noise_points at = np_kind_scale(model, &p, k->fine_m, 1.4f);
  model->noise->value_fbm(&k->fine, &octaves, &at, p.noise);
  for (size_t i = 0; i < p.count; i++) {
    float sunk_m;
    const float noise = spread(p.noise[i]);
    const float fullness = compute_fullness(model, &p, i, (point_noise){noise, spread(swell[i])}, &sunk_m);
    if (p.height_m[i] < p.ground_m[i] - margin_m) continue;
    const float body = np_smoothstepf((depth_m[i] - sunk_m - fray_m * noise) / k->edge_m);
    const float base =
        p.ground_m[i] > 0.0f ? 1.0f : np_smoothstepf((p.height_m[i] - base_edge_m * (1.0f - noise)) / base_edge_m);
    const float share = body * base * fullness * np_mixf(0.75f, 1.1f, p.height_m[i] / (float)desc->thickness_m);
    if (share > extinction_floor) out_extinction_per_m[p.index[i]] = (float)desc->extinction_per_m * share;
  }
}

static bool is_fog_empty(const np_cloud_model *model, const np_cloud_box *box) {
  np_kind_box bounded;
  if (!np_kind_box_make(model, box, &bounded)) return true;
  const float margin_m = texel_rise * model->map.step_m + 2.0f * (float)model->desc.voxel_m;
  if (bounded.box.max_m[2] < bounded.ground_m.low - margin_m - 0.01f) return true;
  /* A patch sinks at least as much as its strongest column. */
  const float weak = 1.0f - np_smoothstepf((bounded.strength.high + 1e-4f) / patch_strength);
  return bounded.box.min_m[2] - bounded.base_m.high >
         (float)model->desc.thickness_m * (1.0f - patch_sink * weak) + 0.01f;
}

const np_cloud_kind np_fog_kind = {
    .name = "fog",
    .landscape = {.form = NP_LANDSCAPE_SHEET, .swirl_size = 1.3f, .has_ground = true},
    .more_cover = NP_EDGES_STAY_CLEAR,
    .less_cover = NP_CLOUDS_COVER_NO_LESS,
    .repeat_obstacle = "which follows the ground",
    .is_thin_at_border = true,
    .billow_grains = 7,
    .census_passes = 4,
    .prepare = prepare_fog,
    .search_waterline = np_waterline_search,
    .eval = eval_fog,
    .is_empty = is_fog_empty,
};

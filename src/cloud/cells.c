/* SPDX-License-Identifier: Apache-2.0 */
/* Cells of noise: cumulus and similar clouds, after Schneider and Vos 2015, "The Real-time Volumetric Cloudscapes of
 * Horizon: Zero Dawn", and Schneider 2023, "Nubis Cubed".
 *
 * The sum of all terms is *depth*, which is positive inside the cloud:
 *
 * depth = m(x, y) − v(s) + base billows − detail, s = (h − base)/thickness
 *
 * m is the weather map above its waterline, 1 in the centre of the largest cell. v is the height profile, from 0 at the
 * flat base to 1 at the top: with v = s² a cell is a dome with its top at √m. An anvil is a second, wider column, whose
 * profile is a sheet below the top that flares down to the tower.
 *
 * Noise displaces the surface: Perlin-Worley billows for the base shape, then octaves of Worley noise that carve
 * creases between ever smaller billows, with amplitudes proportional to size. Near the base the sign of the detail is
 * inverted: billows become holes and creases become wisps. Positions of the detail are displaced by divergence-free
 * noise. Extinction rises from 0 to the core's within a thin edge of depth: a cumulus is crisp.
 *
 * Depth changes by slope_per_m over a metre across the outline, which converts lengths to depth. Only + − × ÷ √ and
 * comparisons enter a value, so that it is the same on every machine. */
#include <math.h>

#include "cloud/air_points.h"
#include "cloud/cloud_column.h"
#include "cloud/cloud_kinds.h"
#include "cloud/cloud_profile.h"
#include "cloud/cloud_streams.h"
#include "cloud/repeat.h"
#include "cloud/waterline.h"
#include "core/math.h"

/* Means of the noises, from noise.h. */
static const float base_mean = 0.85f, erosion_mean = 0.30f;

static const float base_reach = 3.2f;     /* amplitude of the base billows at billowiness 1, in units of their size */
static const float detail_reach = 1.35f;  /* amplitude of an octave of detail at erosion 1, in units of its size */
static const float detail_boost = 1.2f;   /* growth of amplitude over size per octave */
static const float detail_size = 0.46f;   /* size of the first octave of detail, in largest billows */
static const float octave_ratio = 0.47f;  /* size ratio of octaves: not ½, or lattices would align */
static const float base_ramp_size = 0.1f; /* height over which the base thickens, in largest billows */
static const float curl_size = 0.55f;     /* size of the eddies, in largest billows */
static const float curl_reach = 0.12f;    /* displacement at turbulence 1, in largest billows */
static const float wisp_height = 0.18f;   /* height over which wisps turn into billows, relative to the thickness */
static const float extinction_floor = 0.002f; /* relative to the core's extinction: less counts as 0 */
static const float bound_margin = 1e-4f;      /* margin of depth for rounding */

/* Profile of anvils: strongest near this height; a wedge above it, and a flare below it that ends here for a column of
 * 1. */
static const float anvil_center = 0.85f, anvil_above = 0.07f, anvil_flare = 0.40f;
static const float anvil_relief = 0.4f; /* factor on the noise: ice is smooth */
static const float anvil_edge = 14.0f;  /* width relative to the tower's edge */
static const float anvil_thinness = 0.8f;

/* ---- Noises ---- */

static void set_billows(np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  const float billow_m = (float)desc->billow_m;
  model->base.amplitude = base_reach * (float)desc->billowiness * billow_m * model->slope_per_m;
  model->base_gain_max = model->base.amplitude * (1.0f - base_mean);
  float amplitude = detail_reach * (float)desc->erosion * detail_size * billow_m * model->slope_per_m;
  for (unsigned k = 0; k < model->detail_count; k++, amplitude *= octave_ratio * detail_boost)
    model->detail[k].amplitude = amplitude;
  const float turned = 2.0f * (float)desc->wispiness - 1.0f; /* sign of the detail at the base, minus 1; negative */
  float sum = 0.0f;
  for (unsigned k = model->detail_count; k-- > 0;) {
    sum += model->detail[k].amplitude;
    model->detail[k].gain_max = sum * fmaxf(erosion_mean, turned * (1.0f - erosion_mean));
    model->detail[k].loss_max = sum * fmaxf(1.0f - erosion_mean, turned * erosion_mean);
  }
  model->detail_gain_max = model->detail_count ? model->detail[0].gain_max : 0.0f;
  model->detail_loss_max = model->detail_count ? model->detail[0].loss_max : 0.0f;
  model->base_ramp_inverse = (float)desc->thickness_m / (base_ramp_size * billow_m);
}

/* Chooses octaves of detail, as long as a billow covers two voxels. */
static void choose_detail(np_cloud_model *model, float size_m) {
  for (unsigned k = 0; k < NP_CLOUD_OCTAVES_MAX && size_m >= 2.0f * (float)model->desc.voxel_m; k++) {
    model->detail[k].lattice = np_cloud_make_lattice(&model->desc, NP_CLOUD_STREAM_DETAIL + k);
    model->detail[k].frequency_per_m = 1.0f / np_repeat_fit(&model->desc, size_m);
    np_repeat_set_period(&model->desc, size_m, 1.0f, &model->detail[k].lattice);
    model->detail[k].mean = erosion_mean;
    model->detail_count = k + 1;
    size_m *= octave_ratio;
  }
}

static void prepare_cells(np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  const float billow_m = (float)desc->billow_m;
  model->base.lattice = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_BASE);
  model->base.frequency_per_m = 1.0f / np_repeat_fit(desc, billow_m);
  np_repeat_set_period(desc, billow_m, 1.0f, &model->base.lattice);
  model->base.mean = base_mean;
  np_air_points_set_curl(model, curl_size, curl_reach);
  choose_detail(model, detail_size * billow_m);
}

static void set_cell_edges(np_cloud_model *model) {
  np_air_points_set_edge(model);
  set_billows(model);
}

/* ---- Columns ---- */

/* Profile of an anvil: the lower face of a column a is anvil_flare·a² below the centre, like a trumpet. */
static float eval_anvil(float s) {
  const float above = (s - anvil_center) / anvil_above;
  return above > 0.0f ? above : sqrtf((anvil_center - s) / anvil_flare);
}

static float bound_anvil(float low, float high) {
  return low > anvil_center ? eval_anvil(low) : high < anvil_center ? eval_anvil(high) : 0.0f;
}

/* Factor on the noise's amplitude in a column: less towards the outline, to avoid crumbs around clouds. */
static float compute_relief(float strength) { return 0.55f + 0.45f * np_smoothstepf(strength * 3.5f); }

static np_air_state eval_column(const np_cloud_model *model, const np_cloud_column *column, float height_m) {
  np_air_state s = {.depth = -INFINITY, .relief = 1.0f};
  const float above_m = height_m - column->base_m;
  if (!(above_m > 0.0f && above_m < column->thickness_m)) return s;
  s.share = above_m / column->thickness_m;
  s.depth = column->strength - np_cloud_profile_eval_tower(model, s.share, column->type);
  s.relief = compute_relief(column->strength);
  if (!model->map.anvils) return s;
  const float anvil = column->anvil - eval_anvil(s.share);
  s.ice = np_smoothstepf((anvil - s.depth) * 2.5f + 0.5f);
  s.depth = np_maxf(anvil, s.depth);
  s.relief = np_mixf(s.relief, anvil_relief, s.ice);
  return s;
}

static void start_points(const np_cloud_model *model, const np_cloud_points *points, np_air_points *w) {
  const float top_m = (float)model->desc.thickness_m, gain = model->base_gain_max + model->detail_gain_max;
  np_cloud_column column = {0};
  w->count = 0;
  for (size_t i = 0; i < points->count; i++) {
    const float height_m = points->height_m[i];
    if (!np_air_is_same_column(model, points, i))
      column = np_cloud_column_compute(model, points->x_m[i], points->y_m[i], height_m);
    if (!(height_m > 0.0f && height_m < top_m)) continue;
    const np_air_state state = eval_column(model, &column, height_m);
    if (!(state.depth + gain > 0.0f)) continue;
    const size_t n = w->count++;
    float carried_m[2] = {0, 0};
    if (model->wind.has_winds) np_cloud_wind_carry(&model->wind, height_m, carried_m);
    w->index[n] = (uint16_t)i;
    w->x_m[n] = points->x_m[i] - carried_m[0] - model->drift_m[0];
    w->y_m[n] = points->y_m[i] - carried_m[1] - model->drift_m[1];
    w->height_m[n] = height_m;
    w->state[n] = state;
  }
}

/* ---- Depth ---- */

/* Extinction for a depth: a crisp edge, a base that thickens quickly, and a core that gets denser with height, like
 * liquid water in a rising parcel; ice is thin and fades gently. */
static float compute_extinction(const np_cloud_model *model, const np_air_state *s) {
  const float core_per_m = (float)model->desc.extinction_per_m;
  float body = np_smoothstepf(s->depth / (model->edge * np_mixf(1.0f, anvil_edge, s->ice)));
  body *= 1.0f - anvil_thinness * s->ice;
  body *= np_smoothstepf(s->share * model->base_ramp_inverse);
  return body > extinction_floor ? core_per_m * body * (0.8f + 0.4f * s->share) : 0.0f;
}

/* Decides points whose result cannot change: drops points that no further gain of depth can bring into the cloud, and
 * writes the extinction of points so deep that no loss can bring them to its edge. */
static void decide_points(const np_cloud_model *model, np_air_points *w, float gain, float loss,
                          float *out_extinction_per_m) {
  size_t kept = 0;
  for (size_t i = 0; i < w->count; i++) {
    const np_air_state *s = &w->state[i];
    if (!(s->depth + gain > 0.0f)) continue;
    if (s->depth - loss > model->edge * np_mixf(1.0f, anvil_edge, s->ice) * 1.001f) {
      out_extinction_per_m[w->index[i]] = compute_extinction(model, s);
      continue;
    }
    w->index[kept] = w->index[i];
    w->x_m[kept] = w->x_m[i];
    w->y_m[kept] = w->y_m[i];
    w->height_m[kept] = w->height_m[i];
    w->state[kept] = *s;
    kept++;
  }
  w->count = kept;
}

static void add_base(const np_cloud_model *model, np_air_points *w) {
  static const np_noise_octaves octaves = {.count = 2, .gain = 0.4f};
  const np_noise_points points = np_air_points_scale(w, model->base.frequency_per_m, model->turnover);
  model->noise->perlin_worley(&model->base.lattice, &octaves, &points, w->noise);
  for (size_t i = 0; i < w->count; i++)
    w->state[i].depth += w->state[i].relief * model->base.amplitude * (w->noise[i] - model->base.mean);
}

/* Sign of the detail: 1 carves creases between billows, −1 leaves wisps in place of creases. */
static float compute_sign(const np_cloud_model *model, const np_air_state *s) {
  return 1.0f - 2.0f * (float)model->desc.wispiness * (1.0f - np_smoothstepf(s->share / wisp_height));
}

static void subtract_detail(const np_cloud_model *model, np_air_points *w, float *out_extinction_per_m) {
  for (unsigned k = 0; k < model->detail_count; k++) {
    const np_cloud_octave *octave = &model->detail[k];
    decide_points(model, w, octave->gain_max, octave->loss_max, out_extinction_per_m);
    const np_noise_points points = np_air_points_scale(w, octave->frequency_per_m, 2.0f * model->turnover);
    model->noise->worley(&octave->lattice, &points, w->noise);
    for (size_t i = 0; i < w->count; i++) {
      np_air_state *s = &w->state[i];
      s->depth -= octave->amplitude * s->relief * compute_sign(model, s) * (w->noise[i] - octave->mean);
    }
  }
}

static void eval_cells(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  np_air_points w;
  start_points(model, points, &w);
  if (w.count == 0) return;
  add_base(model, &w);
  decide_points(model, &w, model->detail_gain_max, model->detail_loss_max, out_extinction_per_m);
  np_air_points_displace(model, &w);
  subtract_detail(model, &w, out_extinction_per_m);
  for (size_t i = 0; i < w.count; i++) out_extinction_per_m[w.index[i]] = compute_extinction(model, &w.state[i]);
}

/* Whether a box is empty: depth is bounded by the best map value, the most favourable height and the point farthest
 * from the border, plus the largest gain by noise. */
static bool is_cells_empty(const np_cloud_model *model, const np_cloud_box *box) {
  const float top_m = (float)model->desc.thickness_m, gain = model->base_gain_max + model->detail_gain_max;
  if (box->max_m[2] <= 0.0f || box->min_m[2] >= top_m) return true;
  const float low_m = fmaxf(box->min_m[2], 0.0f), high_m = fminf(box->max_m[2], top_m);
  const np_cloud_columns c = np_cloud_columns_make(model, box, low_m, high_m);
  np_interval shares;
  if (!np_cloud_columns_bound_shares(model, &c, low_m, high_m, &shares)) return true;
  const float type = (float)model->desc.type * np_cloud_columns_bound_plane(model, &c, NEPH_CLOUD_MAP_TYPE, 1.0f).low;
  float depth = np_cloud_columns_bound_strength(model, &c) - np_cloud_profile_eval_tower(model, shares.low, type);
  if (model->map.anvils)
    depth = fmaxf(depth, np_cloud_columns_bound_anvil(model, &c) - bound_anvil(shares.low, shares.high));
  return depth + gain < -bound_margin;
}

const np_cloud_kind np_cells_kind = {
    .name = "cells",
    .landscape = {.form = NP_LANDSCAPE_CELLS,
                  .swirl_size = 1.3f,
                  .group_height = 0.78f, /* factor on Perlin noise of standard deviation 0.17 */
                  .group_gain = 0.5f,
                  .group_octaves = 2,
                  .has_anvils = true,
                  .has_patterns = true},
    .more_cover = NP_GAPS_STAY_CLEAR,
    .less_cover = NP_CLOUDS_COVER_NO_LESS,
    .billow_grains = 7,
    .census_passes = 4,
    .prepare = prepare_cells,
    .set_edges = set_cell_edges,
    .search_waterline = np_waterline_search,
    .eval = eval_cells,
    .is_empty = is_cells_empty,
};

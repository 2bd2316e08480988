/* SPDX-License-Identifier: Apache-2.0 */
/* Slabs: stratus and similar clouds. The fBm of value noise, sheared, is added to the depth of columns whose profile is
 * soft at both faces of each sublayer. Noise erodes the lower part of a sublayer (scud). Stretched along the wind, the
 * slab consists of ice fibres. */
#include <math.h>

#include "cloud/air_points.h"
#include "cloud/cloud_column.h"
#include "cloud/cloud_kinds.h"
#include "cloud/cloud_profile.h"
#include "cloud/cloud_streams.h"
#include "cloud/repeat.h"
#include "cloud/waterline.h"
#include "core/math.h"

static const float sheet_mean = 0.5f;                                 /* mean of the noise, from noise.h */
static const float sheet_relief_min = 0.15f, sheet_relief_max = 1.1f; /* amplitude of the noise, by erosion, in depth */
static const float curl_size = 2.2f,
                   curl_reach = 0.9f; /* size of the eddies, and displacement at turbulence 1, in largest billows */
static const float extinction_floor = 0.002f; /* relative to the core's extinction: less counts as 0 */
static const float bound_margin = 1e-4f;      /* margin of depth for rounding */

/* Scud: finer noise that erodes the lower part of each sublayer. */
static const float scud_size = 0.35f, scud_depth = 0.5f; /* in billows, and of a sublayer */
static const float scud_reach = 0.7f;                    /* in depth */

/* Ice fibres of slabs stretched along the wind. */
static const float fibre_size = 0.28f, fibre_draw = 3.5f; /* in billows; times `stretch` along the wind */
static const float fibre_from = 2.0f, fibre_full = 6.0f;  /* range of `stretch` */
static const float fibre_least = 0.22f;                   /* relative extinction between fibres */

/* Contrast of value noise in octaves, which seldom fills its range: for scud, and for relief, which saturates smoothly,
 * because plateaus would be visible as patches from above. */
static const float slab_contrast = 2.2f, slab_swing = 1.5f;

/* ---- Noises ---- */

static unsigned count_sheet_octaves(const np_cloud_model *model) {
  unsigned count = 1;
  for (double size_m = 0.5 * model->desc.billow_m; size_m >= 2 * model->desc.voxel_m && count < NP_CLOUD_OCTAVES_MAX;
       size_m *= 0.5)
    count++;
  return count;
}

static void prepare_slab(np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  const float billow_m = (float)desc->billow_m;
  model->base.lattice = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_SHEET);
  model->base.frequency_per_m = 1.0f / np_repeat_fit(desc, billow_m);
  np_repeat_set_period(desc, billow_m, (float)desc->stretch, &model->base.lattice);
  model->base.mean = sheet_mean;
  np_air_points_set_curl(model, curl_size, curl_reach);
  model->sheet_octave_count = count_sheet_octaves(model);
  model->rain.shafts = model->base.lattice;
}

static void set_slab_edges(np_cloud_model *model) {
  const float erosion = (float)model->desc.erosion;
  np_air_points_set_edge(model);
  model->base.amplitude = sheet_relief_min + erosion * (sheet_relief_max - sheet_relief_min);
  model->base_gain_max = model->base.amplitude;
}

/* ---- Columns ---- */

/* Softness of the faces of a slab's sublayers, in sublayers. */
static float get_face(const np_cloud_model *model) { return 0.12f + 0.38f * (float)model->desc.softness; }

/* Relative position of a height in its sublayer. */
static float compute_place_in_sublayer(const np_cloud_model *model, float s) {
  const float scaled = s * (float)model->desc.sublayers;
  return scaled - (float)(int)scaled;
}

/* Profile of a slab: 0 in the middle of each sublayer; at the faces larger than any gain by noise. */
static float eval_slab(const np_cloud_model *model, float s) {
  const float in = compute_place_in_sublayer(model, s), face = get_face(model);
  float open = 1.0f - np_smoothstepf(in / face) * np_smoothstepf((1.0f - in) / face);
  if (model->desc.has_profile) open = fmaxf(open, np_cloud_profile_eval_curve(&model->desc, in));
  return open * (1.0f + model->base_gain_max);
}

/* Lower bound of the profile between two heights. */
static float bound_slab(const np_cloud_model *model, float low, float high) {
  const float count = (float)model->desc.sublayers, face = get_face(model);
  if ((int)(low * count) != (int)(high * count)) return 0.0f;
  const float from = compute_place_in_sublayer(model, low), to = compute_place_in_sublayer(model, high);
  return (1.0f - np_smoothstepf(to / face) * np_smoothstepf((1.0f - from) / face)) * (1.0f + model->base_gain_max);
}

static np_air_state eval_column(const np_cloud_model *model, const np_cloud_column *column, float height_m) {
  np_air_state s = {.depth = -INFINITY, .relief = 1.0f};
  const float above_m = height_m - column->base_m;
  if (!(above_m > 0.0f && above_m < column->thickness_m)) return s;
  s.share = above_m / column->thickness_m;
  s.depth = column->strength - eval_slab(model, s.share);
  return s;
}

static void start_points(const np_cloud_model *model, const np_cloud_points *points, np_air_points *w) {
  const float top_m = (float)model->desc.thickness_m, gain = model->base_gain_max;
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
    w->index[n] = (uint16_t)i;
    w->x_m[n] = column.x_m - model->drift_m[0];
    w->y_m[n] = column.y_m - model->drift_m[1];
    w->height_m[n] = height_m;
    w->state[n] = state;
  }
}

/* ---- Depth ---- */

/* Adds the relief. Cells are `stretch` times as long along the heading, and each sublayer has its own pattern. */
static void add_sheet(const np_cloud_model *model, np_air_points *w) {
  const np_noise_octaves octaves = {.count = model->sheet_octave_count, .gain = 0.5f};
  const np_noise_points points = np_air_points_scale(w, model->base.frequency_per_m, model->turnover);
  const float billow_m = (float)model->desc.billow_m, stretch = (float)model->desc.stretch;
  const float *heading = model->heading;
  const float shrink = np_repeat_get_ratio(&model->desc, billow_m, billow_m * stretch, 1.0f / stretch);
  const float sublayers = (float)model->desc.sublayers;
  for (size_t i = 0; i < w->count; i++) {
    float along = w->sx[i] * heading[0] + w->sy[i] * heading[1];
    w->sy[i] = w->sy[i] * heading[0] - w->sx[i] * heading[1];
    w->sx[i] = along * shrink;
    w->sz[i] += 17.3f * (float)(int)(w->state[i].share * sublayers);
  }
  model->noise->value_fbm(&model->base.lattice, &octaves, &points, w->noise);
  for (size_t i = 0; i < w->count; i++) {
    const float filled = np_smoothstepf(0.5f + slab_swing * (w->noise[i] - model->base.mean));
    w->state[i].depth += 2.0f * model->base.amplitude * (filled - 0.5f);
  }
}

/* Share of ice fibres in a slab, by its stretch; a veil has no scud. */
static float compute_fibrous_share(const np_cloud_model *model) {
  return np_smoothstepf(((float)model->desc.stretch - fibre_from) / (fibre_full - fibre_from));
}

/* Erodes the base; it only reduces depth, so that bounds hold. */
static void fray_base(const np_cloud_model *model, np_air_points *w) {
  const np_noise_octaves octaves = {.count = model->sheet_octave_count, .gain = 0.6f};
  const float sublayers = (float)model->desc.sublayers, water = 1.0f - compute_fibrous_share(model);
  const float reach = water * scud_reach * (0.6f + (float)model->desc.erosion);
  if (!(reach > 0.0f)) return;
  const float size_m = np_repeat_fit(&model->desc, scud_size / model->base.frequency_per_m);
  np_noise_lattice lattice = model->rain.streaks;
  np_repeat_set_period(&model->desc, size_m, 1.0f, &lattice);
  const np_noise_points points = np_air_points_scale(w, 1.0f / size_m, model->turnover);
  model->noise->value_fbm(&lattice, &octaves, &points, w->noise);
  for (size_t i = 0; i < w->count; i++) {
    const float scaled = w->state[i].share * sublayers, place = scaled - (float)(int)scaled;
    const float low = 1.0f - np_smoothstepf(place / scud_depth);
    w->state[i].depth -= reach * low * np_clampf(0.5f + slab_contrast * (w->noise[i] - 0.5f), 0.0f, 1.0f);
  }
}

/* Writes factors on the extinction to `noise`: fibres are continuous over the height, so that they do not average out.
 */
static void compute_fibres(const np_cloud_model *model, np_air_points *w) {
  const np_noise_octaves octaves = {.count = model->sheet_octave_count, .gain = 0.6f};
  const float stretch = fibre_draw * (float)model->desc.stretch, *heading = model->heading;
  const float size_m = np_repeat_fit(&model->desc, fibre_size / model->base.frequency_per_m);
  const float shrink = np_repeat_get_ratio(&model->desc, size_m, size_m * stretch, 1.0f / stretch);
  const float strength = (1.0f - fibre_least) * compute_fibrous_share(model);
  for (size_t i = 0; i < w->count; i++) w->noise[i] = 1.0f;
  if (!(strength > 0.0f)) return;
  np_noise_lattice lattice = model->rain.streaks;
  np_repeat_set_period(&model->desc, size_m, stretch, &lattice);
  const np_noise_points points = np_air_points_scale(w, 1.0f / size_m, model->turnover);
  for (size_t i = 0; i < w->count; i++) {
    const float along = w->sx[i] * heading[0] + w->sy[i] * heading[1];
    w->sy[i] = w->sy[i] * heading[0] - w->sx[i] * heading[1];
    w->sx[i] = along * shrink;
    w->sz[i] *= 0.12f;
  }
  model->noise->value_fbm(&lattice, &octaves, &points, w->noise);
  for (size_t i = 0; i < w->count; i++)
    w->noise[i] = 1.0f - strength * np_smoothstepf(0.5f + 2.4f * (w->noise[i] - 0.5f));
}

static float compute_extinction(const np_cloud_model *model, float depth) {
  const float body = np_smoothstepf(depth / model->edge);
  return body > extinction_floor ? (float)model->desc.extinction_per_m * body : 0.0f;
}

static void eval_slab_points(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  np_air_points w;
  start_points(model, points, &w);
  if (w.count == 0) return;
  np_air_points_displace(model, &w);
  add_sheet(model, &w);
  fray_base(model, &w);
  compute_fibres(model, &w);
  for (size_t i = 0; i < w.count; i++)
    out_extinction_per_m[w.index[i]] = w.noise[i] * compute_extinction(model, w.state[i].depth);
}

/* Whether a box is empty: depth is bounded by the best map value, the most favourable height and the point farthest
 * from the border, plus the largest gain by noise. */
static bool is_slab_empty(const np_cloud_model *model, const np_cloud_box *box) {
  const float top_m = (float)model->desc.thickness_m;
  if (box->max_m[2] <= 0.0f || box->min_m[2] >= top_m) return true;
  const float low_m = fmaxf(box->min_m[2], 0.0f), high_m = fminf(box->max_m[2], top_m);
  const np_cloud_columns c = np_cloud_columns_make(model, box, low_m, high_m);
  np_interval shares;
  if (!np_cloud_columns_bound_shares(model, &c, low_m, high_m, &shares)) return true;
  const float depth = np_cloud_columns_bound_strength(model, &c) - bound_slab(model, shares.low, shares.high);
  return depth + model->base_gain_max < -bound_margin;
}

const np_cloud_kind np_slab_kind = {
    .name = "slab",
    .landscape = {.form = NP_LANDSCAPE_SHEET, .swirl_size = 2.6f, .has_patterns = true},
    .more_cover = NP_EDGES_STAY_CLEAR,
    .less_cover = NP_CLOUDS_COVER_NO_LESS,
    .skew = NP_CLOUD_SKEW_TRAILING,
    .has_pannus = true,
    .billow_grains = 7,
    .census_passes = 4,
    .prepare = prepare_slab,
    .set_edges = set_slab_edges,
    .search_waterline = np_waterline_search,
    .eval = eval_slab_points,
    .is_empty = is_slab_empty,
};

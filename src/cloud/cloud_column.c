/* SPDX-License-Identifier: Apache-2.0 */
/* Columns: what the weather map and the height profile make of a place before any noise, and bounds of that over boxes.
 *
 *   depth before noise = m(x, y) − v(s),   s = (h − base)/thickness
 *
 * m is the weather map above its waterline, 1 in the heart of the largest cell, and v the height profile, which grows
 * from 0 at the flat base to 1 at the top: with v = s² a cell is a dome, its top at √m. An anvil is a second column,
 * wider, with a profile that is a sheet below the top and flares down to the tower. A slab's profile is soft at both
 * faces. Each function that gives a value stands beside the one that bounds it, for a box is left out of a bake on
 * their word alone.
 */
#include <math.h>

#include "cloud/cloud_kinds.h"
#include "cloud/thermals.h"
#include "core/math.h"

/* Anvils: strongest about this height; above it a wedge, below it a flare that ends here where the column is 1, all of
 * the thickness; of columns at least this strong. */
static const float anvil_center = 0.85f, anvil_above = 0.07f, anvil_flare = 0.40f, anvil_cut = 0.55f;
static const float anvil_relief = 0.4f; /* share of the noise: ice is smooth */
static const float anvil_border = 0.3f; /* of the depth that the border allows a tower: anvils thin out to it */
static const float anvil_corner = 0.4f; /* radius of the border's corners for anvils, in shorter sides of the field */

static const float rain_column = 0.12f, rain_column_width = 0.35f; /* the columns that heavy rain falls from */

/* Rounding is covered by a margin far above it. */
static const float bound_margin = 1e-4f;

static bool is_slab(const np_cloud_model *model) { return model->desc.model == NEPH_CLOUD_MODEL_SLAB; }

/* ---- Profiles ---- */

static float eval_curve(const neph_cloud_desc *desc, float s) {
  float scaled = np_clampf(s, 0.0f, 1.0f) * (NEPH_CLOUD_PROFILE_POINTS - 1);
  int i = (int)scaled;
  if (i > NEPH_CLOUD_PROFILE_POINTS - 2) i = NEPH_CLOUD_PROFILE_POINTS - 2;
  return np_mixf((float)desc->profile[i], (float)desc->profile[i + 1], scaled - (float)i);
}

/* The height profile of a tower, for s ≥ 0: never falling, 1 + gain at the top, which noise can then just reach. More
 * type makes it larger: taller clouds for strong cells, lower ones for the others. */
static float eval_tower(const np_cloud_model *model, float s, float type) {
  const float s2 = s * s, flat = s2 * s2, tall = s2;
  const float shape = model->desc.has_profile ? eval_curve(&model->desc, s) : np_mixf(flat, tall, type);
  return shape * (1.0f + model->base_gain_max + model->detail_gain_max);
}

/* Softness of the faces of a slab's sublayers, in sublayers. */
static float get_face(const np_cloud_model *model) { return 0.12f + 0.38f * (float)model->desc.softness; }

/* Place of a height in its sublayer. */
static float compute_place_in_sublayer(const np_cloud_model *model, float s) {
  const float scaled = s * (float)model->desc.sublayers;
  return scaled - (float)(int)scaled;
}

/* The profile of a slab: 0 in the middle of each sublayer, at the faces more than noise can make up for. */
static float eval_slab(const np_cloud_model *model, float s) {
  const float in = compute_place_in_sublayer(model, s), face = get_face(model);
  float open = 1.0f - np_smoothstepf(in / face) * np_smoothstepf((1.0f - in) / face);
  if (model->desc.has_profile) open = fmaxf(open, eval_curve(&model->desc, in));
  return open * (1.0f + model->base_gain_max);
}

static float eval_profile(const np_cloud_model *model, float s, float type) {
  return is_slab(model) ? eval_slab(model, s) : eval_tower(model, s, type);
}

/* Below no value of the profile between two heights, for this type or more. */
static float bound_profile(const np_cloud_model *model, float low, float high, float type) {
  if (!is_slab(model)) return eval_tower(model, low, type);
  const float count = (float)model->desc.sublayers, face = get_face(model);
  if ((int)(low * count) != (int)(high * count)) return 0.0f;
  const float from = compute_place_in_sublayer(model, low), to = compute_place_in_sublayer(model, high);
  return (1.0f - np_smoothstepf(to / face) * np_smoothstepf((1.0f - from) / face)) * (1.0f + model->base_gain_max);
}

/* The lower face of a column a lies anvil_flare·a² below the centre: a trumpet. */
static float eval_anvil(float s) {
  const float above = (s - anvil_center) / anvil_above;
  return above > 0.0f ? above : sqrtf((anvil_center - s) / anvil_flare);
}

static float bound_anvil(float low, float high) {
  return low > anvil_center ? eval_anvil(low) : high < anvil_center ? eval_anvil(high) : 0.0f;
}

/* ---- Columns ---- */

/* Distance inside the field's border, whose corners are rounded by a radius; grows with either distance to a side. */
static float compute_inset_m(const neph_cloud_desc *desc, float x_m, float y_m, float corner_m) {
  const float dx = 0.5f * (float)desc->extent_m[0] - fabsf(x_m), dy = 0.5f * (float)desc->extent_m[1] - fabsf(y_m);
  if (!(dx < corner_m && dy < corner_m)) return np_minf(dx, dy);
  return corner_m - sqrtf((corner_m - dx) * (corner_m - dx) + (corner_m - dy) * (corner_m - dy));
}

/* Depth allowed by the border of the field, so that no cloud is cut by a wall. */
static float eval_border(const np_cloud_model *model, float x_m, float y_m, float corner_m) {
  const neph_cloud_desc *desc = &model->desc;
  if (desc->repeat_m > 0) return INFINITY;
  return compute_inset_m(desc, x_m, y_m, corner_m) * model->slope_per_m -
         model->base_gain_max * (1.0f - (float)np_cloud_desc_get_coverage(desc));
}

/* The same of anvils, which reach farther than their towers and show the border: a rectangle would give them corners.
 */
static float eval_anvil_border(const np_cloud_model *model, float x_m, float y_m) {
  const float shorter_m = (float)fmin(model->desc.extent_m[0], model->desc.extent_m[1]);
  return anvil_border * eval_border(model, x_m, y_m, anvil_corner * shorter_m);
}

/* Growth since time 0 stays below the top. */
static float scale_strength(const np_cloud_model *model, float value) {
  return np_minf(value * model->depth_scale + model->depth_offset, 1.0f);
}

/* Strength of the air that a column carries, at a place of the picture. */
static float sample_strength(const np_cloud_model *model, const float *values, const np_cloud_column *c, float x_m,
                             float y_m) {
  const float height = np_weather_map_sample(&model->map, values, c->x_m, c->y_m), *levels = model->map.levels;
  return scale_strength(model, levels ? height - np_weather_map_sample(&model->map, levels, x_m, y_m) : height);
}

static float scale_anvil(float strength) { return (strength - anvil_cut) / (1.0f - anvil_cut); }

static float sample_plane(const np_cloud_model *model, neph_cloud_map_quantity quantity, float x_m, float y_m,
                          float fallback) {
  const float *plane = model->map.planes[quantity];
  return plane ? np_weather_map_sample(&model->map, plane, x_m, y_m) : fallback;
}

np_cloud_column np_cloud_column_compute(const np_cloud_model *model, float x_m, float y_m, float height_m) {
  const neph_cloud_desc *desc = &model->desc;
  const float top_m = (float)desc->thickness_m;
  const float border = eval_border(model, x_m, y_m, 0.0f);
  float shift_m[2];
  np_cloud_wind_shift(model, height_m, shift_m);
  np_cloud_column c = {.x_m = x_m - shift_m[0], .y_m = y_m - shift_m[1]};
  c.strength = np_minf(sample_strength(model, model->map.values, &c, x_m, y_m), border);
  if (model->map.anvils)
    c.anvil = scale_anvil(
        np_minf(sample_strength(model, model->map.anvils, &c, x_m, y_m), eval_anvil_border(model, x_m, y_m)));
  c.base_m = top_m * sample_plane(model, NEPH_CLOUD_MAP_BASE, c.x_m, c.y_m, 0.0f);
  c.thickness_m = np_minf(top_m * sample_plane(model, NEPH_CLOUD_MAP_THICKNESS, c.x_m, c.y_m, 1.0f), top_m - c.base_m);
  c.type = (float)desc->type * sample_plane(model, NEPH_CLOUD_MAP_TYPE, c.x_m, c.y_m, 1.0f);
  c.age = (float)desc->age * sample_plane(model, NEPH_CLOUD_MAP_AGE, c.x_m, c.y_m, 1.0f);
  c.rain = sample_plane(model, NEPH_CLOUD_MAP_PRECIPITATION, c.x_m, c.y_m, 1.0f);
  return c;
}

enum { TOP_STEPS = 12 };

/* Found by halving, for the profile never falls. */
float np_cloud_column_compute_top(const np_cloud_model *model, const np_cloud_column *column) {
  float low = 0.0f, high = 1.0f;
  for (int step = 0; step < TOP_STEPS; step++) {
    const float middle = 0.5f * (low + high);
    *(eval_tower(model, middle, column->type) < column->strength ? &low : &high) = middle;
  }
  return 0.5f * (low + high);
}

/* Share of the noise's amplitude over a column: less towards the outline, or crumbs would fly around every cloud. */
static float compute_relief(float strength) { return 0.55f + 0.45f * np_smoothstepf(strength * 3.5f); }

np_cloud_state np_cloud_column_eval(const np_cloud_model *model, const np_cloud_column *column, float height_m) {
  np_cloud_state s = {.depth = -INFINITY, .relief = 1.0f};
  const float above_m = height_m - column->base_m;
  if (!(above_m > 0.0f && above_m < column->thickness_m)) return s;
  s.share = above_m / column->thickness_m;
  s.depth = column->strength - eval_profile(model, s.share, column->type);
  if (!is_slab(model)) s.relief = compute_relief(column->strength);
  if (!model->map.anvils) return s;
  const float anvil = column->anvil - eval_anvil(s.share);
  s.ice = np_smoothstepf((anvil - s.depth) * 2.5f + 0.5f);
  s.depth = np_maxf(anvil, s.depth);
  s.relief = np_mixf(s.relief, anvil_relief, s.ice);
  return s;
}

/* It thins as it evaporates, unless it reaches the sea. */
float np_cloud_column_eval_rain(const np_cloud_model *model, const np_cloud_column *column, float height_m) {
  const float fallen = (column->base_m - height_m) / (column->base_m + model->rain_depth_m);
  const float excess = column->strength - rain_column, left = fallen * fallen * (2.0f - fallen * fallen);
  if (!(fallen >= 0.0f && fallen < 1.0f && excess > 0.0f)) return 0.0f;
  const float strength = column->rain * (float)model->desc.precipitation;
  return strength * np_smoothstepf(excess / rain_column_width) * (1.0f - left * (1.01f - strength));
}

/* ---- Bounds ---- */

/* The columns that a box may hold between two of its heights, freed from the skew. */
typedef struct columns {
  float min_m[2], max_m[2];
} columns;

static columns compute_columns(const np_cloud_model *model, const np_cloud_box *box, float low_m, float high_m) {
  np_interval shift_m[2];
  np_cloud_wind_bound(model, low_m, high_m, shift_m);
  columns c;
  for (int i = 0; i < 2; i++) {
    c.min_m[i] = box->min_m[i] - shift_m[i].high;
    c.max_m[i] = box->max_m[i] - shift_m[i].low;
  }
  return c;
}

static float bound_strength(const np_cloud_model *model, const float *values, const columns *c,
                            const np_cloud_box *box) {
  const float highest = np_weather_map_get_range(&model->map, values, c->min_m, c->max_m).high;
  const float *levels = model->map.levels;
  const float lowest = levels ? np_weather_map_get_range(&model->map, levels, box->min_m, box->max_m).low : 0.0f;
  return scale_strength(model, highest - lowest);
}

static np_interval bound_plane(const np_cloud_model *model, neph_cloud_map_quantity quantity, const columns *c,
                               float fallback) {
  const float *plane = model->map.planes[quantity];
  if (!plane) return (np_interval){fallback, fallback};
  const np_interval range = np_weather_map_get_range(&model->map, plane, c->min_m, c->max_m);
  return (np_interval){range.low - 1e-6f, range.high + 1e-6f}; /* the blend of equal texels may round */
}

/* The most that the border allows anywhere in the box, a tower or an anvil: at its point nearest to the middle. */
static float bound_border(const np_cloud_model *model, const np_cloud_box *box, bool is_anvil) {
  float nearest[2];
  for (int i = 0; i < 2; i++)
    nearest[i] = box->min_m[i] > 0.0f ? box->min_m[i] : box->max_m[i] < 0.0f ? box->max_m[i] : 0.0f;
  return is_anvil ? eval_anvil_border(model, nearest[0], nearest[1]) : eval_border(model, nearest[0], nearest[1], 0.0f);
}

/* Heights above the columns' bases over their thicknesses, held to [0, 1]. False: no height of the box is inside. */
static bool bound_shares(const np_cloud_model *model, const columns *c, float low_m, float high_m,
                         np_interval *out_shares) {
  const float top_m = (float)model->desc.thickness_m;
  const np_interval base = bound_plane(model, NEPH_CLOUD_MAP_BASE, c, 0.0f);
  const np_interval thickness = bound_plane(model, NEPH_CLOUD_MAP_THICKNESS, c, 1.0f);
  const float thinnest = top_m * np_minf(thickness.low, 1.0f - base.high);
  const float thickest = top_m * np_minf(thickness.high, 1.0f - base.low);
  const float above_low = low_m - top_m * base.high, above_high = high_m - top_m * base.low;
  if (above_high <= 0.0f || !(thickest > 0.0f)) return false;
  out_shares->low = above_low > 0.0f ? above_low / thickest : 0.0f;
  out_shares->high = above_high < thinnest ? above_high / thinnest : 1.0f;
  return out_shares->low < 1.0f + bound_margin;
}

static bool is_dry(const np_cloud_model *model, const np_cloud_box *box) {
  if (!(model->rain_depth_m > 0.0f) || box->max_m[2] < -model->rain_depth_m) return true;
  const float low_m = fmaxf(box->min_m[2], -model->rain_depth_m);
  const float high_m = fminf(box->max_m[2], (float)model->desc.thickness_m);
  const columns c = compute_columns(model, box, low_m, high_m);
  const float base_m = (float)model->desc.thickness_m * bound_plane(model, NEPH_CLOUD_MAP_BASE, &c, 0.0f).high;
  if (box->min_m[2] > base_m) return true;
  const float strength = fminf(bound_strength(model, model->map.values, &c, box), bound_border(model, box, false));
  return strength - rain_column < -bound_margin;
}

bool np_cloud_column_bound(const np_cloud_model *model, const np_cloud_box *box, np_kind_box *out_box) {
  const float top_m = (float)model->desc.thickness_m;
  const columns c = compute_columns(model, box, fmaxf(box->min_m[2], 0.0f), fminf(box->max_m[2], top_m));
  const np_interval base = bound_plane(model, NEPH_CLOUD_MAP_BASE, &c, 0.0f);
  *out_box = (np_kind_box){.box = *box, .base_m = {top_m * base.low, top_m * base.high}};
  for (int a = 0; a < 2; a++) {
    out_box->field_min_m[a] = c.min_m[a];
    out_box->field_max_m[a] = c.max_m[a];
  }
  out_box->strength.high = fminf(bound_strength(model, model->map.values, &c, box), bound_border(model, box, false));
  out_box->ground_m = (np_interval){-INFINITY, -INFINITY};
  if (model->map.ground_m)
    out_box->ground_m = np_weather_map_get_range(&model->map, model->map.ground_m, c.min_m, c.max_m);
  return box->max_m[2] > out_box->base_m.low;
}

/* Anvils on thermals. */
static bool has_no_anvil(const np_cloud_model *model, const np_cloud_box *box) {
  const float top_m = (float)model->desc.thickness_m;
  if (!model->map.anvils || box->max_m[2] <= 0.0f || box->min_m[2] >= top_m) return true;
  const float low_m = fmaxf(box->min_m[2], 0.0f), high_m = fminf(box->max_m[2], top_m);
  const columns c = compute_columns(model, box, low_m, high_m);
  np_interval shares;
  if (!bound_shares(model, &c, low_m, high_m, &shares)) return true;
  const float border = bound_border(model, box, false), tower = bound_strength(model, model->map.values, &c, box);
  const float anvil =
      scale_anvil(fminf(bound_strength(model, model->map.anvils, &c, box), bound_border(model, box, true)));
  shares.low -= bound_margin;
  shares.high += bound_margin;
  return !np_anvil_is_possible(anvil + bound_margin, fminf(tower, border) + bound_margin, &shares);
}

/* Depth is at most that of the best map value, of the most favourable height and of the point farthest from the border,
 * with all that noise can add. */
static bool has_no_points(const np_cloud_model *model, const np_cloud_box *box) {
  const float top_m = (float)model->desc.thickness_m;
  if (model->is_empty) return true;
  if (!is_dry(model, box)) return false;
  const np_cloud_kind *kind = np_cloud_kind_get(model->desc.model);
  if (kind) return np_kind_is_empty(kind, model, box);
  if (np_cloud_model_has_thermals(model)) return np_thermals_is_empty(model, box) && has_no_anvil(model, box);
  if (box->max_m[2] <= 0.0f || box->min_m[2] >= top_m) return true;
  const float low_m = fmaxf(box->min_m[2], 0.0f), high_m = fminf(box->max_m[2], top_m);
  const columns c = compute_columns(model, box, low_m, high_m);
  const float border = bound_border(model, box, false), gain = model->base_gain_max + model->detail_gain_max;
  np_interval shares;
  if (!bound_shares(model, &c, low_m, high_m, &shares)) return true;
  const float type = (float)model->desc.type * bound_plane(model, NEPH_CLOUD_MAP_TYPE, &c, 1.0f).low;
  float depth = fminf(bound_strength(model, model->map.values, &c, box), border) -
                bound_profile(model, shares.low, shares.high, type);
  if (model->map.anvils)
    depth = fmaxf(
        depth, scale_anvil(fminf(bound_strength(model, model->map.anvils, &c, box), bound_border(model, box, true))) -
                   bound_anvil(shares.low, shares.high));
  return depth + gain < -bound_margin;
}

/* Values are means over the height of a voxel. */
bool np_cloud_model_is_empty(const np_cloud_model *model, const np_cloud_box *box) {
  const float beyond_m = 0.5f * (float)(model->sample_count - 1) * (float)model->desc.voxel_m;
  np_cloud_box raised = *box;
  raised.min_m[2] -= beyond_m;
  raised.max_m[2] += beyond_m;
  return has_no_points(model, &raised);
}

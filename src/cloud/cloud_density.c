/* SPDX-License-Identifier: Apache-2.0 */
/* The density of a cumulus field, after Schneider and Vos 2015, "The Real-time Volumetric Cloudscapes of Horizon: Zero
 * Dawn", and Schneider 2023, "Nubis Cubed".
 *
 * All is a balance of *depth*, a number that is positive inside the cloud:
 *
 *   depth = m(x, y) − v(h/T)  +  base billows  −  detail
 *
 * m is the weather map above its waterline, 1 in the heart of the largest cell, and v the height profile, which grows
 * from 0 at the flat base to 1 at the top T: with v = t² a cell is a dome, its top T·√m. Noise moves the surface in and
 * out: Perlin-Worley billows of the base shape, then octaves of Worley noise that carve the creases between ever
 * smaller billows, amplitude in proportion to size. Near the base the sign of the detail turns, so that what was a
 * billow becomes a hole and what was a crease a wisp. Positions of the detail are displaced by divergence-free noise.
 * Extinction rises from nothing to the core's within a thin edge of depth: a cumulus is crisp.
 *
 * An anvil is a second column, wider, with a profile that is a wedge below the top. A slab has a profile that is soft
 * at both faces, and the fBm of value noise, sheared, in place of billows and detail; it costs a fifth. Rain falls from
 * strong columns, in streaks.
 *
 * Depth changes by slope_per_m over a metre across the outline, which turns lengths into depth. Only + − × ÷ and
 * comparisons decide a value, so that it is the same on every machine.
 */
#include <math.h>
#include <string.h>

#include "cloud/cloud_private.h"

static const float wisp_height = 0.18f;       /* of the thickness, over which wisps give way to billows */
static const float base_ramp_size = 0.035f;   /* of the thickness, over which the base thickens */
static const float extinction_floor = 0.002f; /* of the core's: less is nothing */

/* Anvils: a wedge all round about this height, of this half thickness where its column is 1, both of the whole
 * thickness. */
static const float anvil_center = 0.88f, anvil_half = 0.12f;
static const float anvil_relief = 0.28f; /* share of the noise: ice is smooth */
static const float anvil_edge = 14.0f;   /* times the edge of the tower */
static const float anvil_thinness = 0.8f;

/* Heavy rain, of the order of 50 mm an hour, and the columns it falls from. */
static const float rain_extinction_per_m = 4e-3f, rain_column = 0.12f, rain_column_width = 0.35f;
static const float rain_streak_m = 260.0f, rain_streak_stretch = 14.0f;

static const float slab_contrast = 2.2f; /* of value noise in octaves, whose range is seldom filled */

static float clip01(float x) { return x < 0.0f ? 0.0f : x > 1.0f ? 1.0f : x; }

/* Smooth from 0 at t = 0 to 1 at t = 1. */
static float smooth(float t) {
  t = clip01(t);
  return t * t * (3.0f - 2.0f * t);
}

static float eval_curve(const neph_cloud_desc *desc, float t) {
  float scaled = clip01(t) * (NEPH_CLOUD_PROFILE_POINTS - 1);
  int i = (int)scaled;
  if (i > NEPH_CLOUD_PROFILE_POINTS - 2) i = NEPH_CLOUD_PROFILE_POINTS - 2;
  float low = (float)desc->profile[i], high = (float)desc->profile[i + 1];
  return low + (scaled - (float)i) * (high - low);
}

/* The height profile of a tower, for t = h/T ≥ 0: never falling, 1 + gain at the top, which noise can then just reach.
 */
static float eval_tower(const np_cloud_model *model, float t) {
  float type = (float)model->desc.type, t2 = t * t, low = t2 * t2, tall = t2;
  float shape = model->desc.has_profile ? eval_curve(&model->desc, t) : low + type * (tall - low);
  return shape * (1.0f + model->base_gain_max + model->detail_gain_max);
}

/* How far the faces of a slab's sublayers are soft, in sublayers. */
static float get_face(const np_cloud_model *model) { return 0.12f + 0.38f * (float)model->desc.softness; }

/* Where in its sublayer a height is. */
static float find_in_sublayer(const np_cloud_model *model, float t) {
  float scaled = t * (float)model->desc.sublayers;
  return scaled - (float)(int)scaled;
}

/* The profile of a slab: 0 in the middle of each sublayer, at the faces more than noise can make up for. */
static float eval_slab(const np_cloud_model *model, float t) {
  const float in = find_in_sublayer(model, t), face = get_face(model);
  float open = 1.0f - smooth(in / face) * smooth((1.0f - in) / face);
  if (model->desc.has_profile) open = fmaxf(open, eval_curve(&model->desc, in));
  return open * (1.0f + model->base_gain_max);
}

static bool is_slab(const np_cloud_model *model) { return model->desc.model == NEPH_CLOUD_MODEL_SLAB; }

static float eval_profile(const np_cloud_model *model, float t) {
  return is_slab(model) ? eval_slab(model, t) : eval_tower(model, t);
}

/* Below no value of the profile between two heights. */
static float bound_profile(const np_cloud_model *model, float low, float high) {
  if (!is_slab(model)) return eval_tower(model, low);
  const float count = (float)model->desc.sublayers, face = get_face(model);
  if ((int)(low * count) != (int)(high * count)) return 0.0f;
  const float from = find_in_sublayer(model, low), to = find_in_sublayer(model, high);
  return (1.0f - smooth(to / face) * smooth((1.0f - from) / face)) * (1.0f + model->base_gain_max);
}

static float eval_anvil(float t) { return fabsf(t - anvil_center) / anvil_half; }

static float bound_anvil(float low, float high) {
  return low > anvil_center ? eval_anvil(low) : high < anvil_center ? eval_anvil(high) : 0.0f;
}

/* Depth allowed by the border of the field, so that no cloud is cut by a wall; but a field covered all over has one. */
static float eval_border(const np_cloud_model *model, float x_m, float y_m) {
  const neph_cloud_desc *desc = &model->desc;
  float dx = 0.5f * (float)desc->extent_m[0] - fabsf(x_m), dy = 0.5f * (float)desc->extent_m[1] - fabsf(y_m);
  return (dx < dy ? dx : dy) * model->slope_per_m - model->base_gain_max * (1.0f - (float)desc->coverage);
}

/* Share of the skew at a height: streaks that fall from a slab trail ever more, towers lean evenly. */
static float find_lean(const np_cloud_model *model, float t) { return is_slab(model) ? t * fabsf(t) : t; }

/* Strength of the column at a position already freed from the skew. */
static float eval_column(const np_cloud_model *model, const float *values, float x_m, float y_m) {
  float column = np_weather_map_sample(&model->map, values, x_m, y_m) * model->depth_scale + model->depth_offset;
  return column < 1.0f ? column : 1.0f; /* what has grown since time 0 stays below the top */
}

/* Share of the noise's amplitude over a column: less towards the outline, or crumbs would fly around every cloud. */
static float find_relief(float column) { return 0.55f + 0.45f * smooth(column * 3.5f); }

/* Points still in question, packed together after each test, so that noise is paid for only where it decides.
 * Positions are in the air, which drifts, turns over, and in a slab is sheared. */
typedef struct work {
  size_t count;
  uint16_t index[NP_CLOUD_BLOCK];
  float x_m[NP_CLOUD_BLOCK], y_m[NP_CLOUD_BLOCK], height_m[NP_CLOUD_BLOCK];
  float depth[NP_CLOUD_BLOCK], relief[NP_CLOUD_BLOCK], ice[NP_CLOUD_BLOCK]; /* `ice`: share of the anvil */
  float sx[NP_CLOUD_BLOCK], sy[NP_CLOUD_BLOCK], sz[NP_CLOUD_BLOCK], noise[NP_CLOUD_BLOCK]; /* scratch */
} work;

typedef struct column_state {
  float depth, relief, ice;
} column_state;

/* Before any noise: the tower, or the anvil where that is deeper. */
static column_state find_state(const np_cloud_model *model, float x, float y, float t, float border) {
  float column = fminf(eval_column(model, model->map.values, x, y), border);
  column_state s = {column - eval_profile(model, t), is_slab(model) ? 1.0f : find_relief(column), 0.0f};
  if (!model->map.anvils) return s;
  float anvil = fminf(eval_column(model, model->map.anvils, x, y), border) - eval_anvil(t);
  s.ice = smooth((anvil - s.depth) * 2.5f + 0.5f);
  s.depth = anvil > s.depth ? anvil : s.depth;
  s.relief += s.ice * (anvil_relief - s.relief);
  return s;
}

static void start_work(const np_cloud_model *model, const np_cloud_points *points, work *w) {
  const float top = (float)model->desc.thickness_m, gain = model->base_gain_max + model->detail_gain_max;
  w->count = 0;
  for (size_t i = 0; i < points->count; i++) {
    float h = points->height_m[i];
    if (!(h > 0.0f && h < top)) continue;
    float t = h / top, lean = find_lean(model, t);
    float x = points->x_m[i] - (float)model->desc.skew_m[0] * lean;
    float y = points->y_m[i] - (float)model->desc.skew_m[1] * lean;
    column_state s = find_state(model, x, y, t, eval_border(model, points->x_m[i], points->y_m[i]));
    if (!(s.depth + gain > 0.0f)) continue;
    size_t n = w->count++;
    w->index[n] = (uint16_t)i;
    w->x_m[n] = (is_slab(model) ? x : points->x_m[i]) - model->drift_m[0];
    w->y_m[n] = (is_slab(model) ? y : points->y_m[i]) - model->drift_m[1];
    w->height_m[n] = h;
    w->depth[n] = s.depth;
    w->relief[n] = s.relief;
    w->ice[n] = s.ice;
  }
}

/* Drops the points that no further gain of depth can bring into the cloud. */
static void drop_clear(work *w, float gain) {
  size_t kept = 0;
  for (size_t i = 0; i < w->count; i++) {
    if (!(w->depth[i] + gain > 0.0f)) continue;
    w->index[kept] = w->index[i];
    w->x_m[kept] = w->x_m[i];
    w->y_m[kept] = w->y_m[i];
    w->height_m[kept] = w->height_m[i];
    w->depth[kept] = w->depth[i];
    w->relief[kept] = w->relief[i];
    w->ice[kept] = w->ice[i];
    kept++;
  }
  w->count = kept;
}

/* In cells of a lattice, which rises by `turnover` of them: billows roll up, and new ones take their place. */
static np_noise_points scale_positions(work *w, float frequency_per_m, float turnover) {
  for (size_t i = 0; i < w->count; i++) {
    w->sx[i] = w->x_m[i] * frequency_per_m;
    w->sy[i] = w->y_m[i] * frequency_per_m;
    w->sz[i] = w->height_m[i] * frequency_per_m - turnover;
  }
  return (np_noise_points){w->count, w->sx, w->sy, w->sz};
}

static void add_base(const np_cloud_model *model, work *w) {
  static const np_noise_octaves octaves = {.count = 2, .gain = 0.4f};
  const np_noise_points points = scale_positions(w, model->base.frequency_per_m, model->turnover);
  model->noise->perlin_worley(&model->base.lattice, &octaves, &points, w->noise);
  for (size_t i = 0; i < w->count; i++)
    w->depth[i] += w->relief[i] * model->base.amplitude * (w->noise[i] - model->base.mean);
}

/* Along the heading cells are `stretch` times as long. Each sublayer has a pattern of its own. */
static void add_sheet(const np_cloud_model *model, work *w) {
  const np_noise_octaves octaves = {.count = model->sheet_octave_count, .gain = 0.5f};
  const np_noise_points points = scale_positions(w, model->base.frequency_per_m, model->turnover);
  const float *heading = model->heading, shrink = 1.0f / (float)model->desc.stretch;
  const float sublayers_per_m = (float)model->desc.sublayers / (float)model->desc.thickness_m;
  for (size_t i = 0; i < w->count; i++) {
    float along = w->sx[i] * heading[0] + w->sy[i] * heading[1];
    w->sy[i] = w->sy[i] * heading[0] - w->sx[i] * heading[1];
    w->sx[i] = along * shrink;
    w->sz[i] += 17.3f * (float)(int)(w->height_m[i] * sublayers_per_m);
  }
  model->noise->value_fbm(&model->base.lattice, &octaves, &points, w->noise);
  for (size_t i = 0; i < w->count; i++) {
    float centred = clip01((w->noise[i] - model->base.mean) * slab_contrast + 0.5f) - 0.5f;
    w->depth[i] += 2.0f * model->base.amplitude * centred;
  }
}

/* More at the base, where the air turns over, than in the firm tops. */
static void displace(const np_cloud_model *model, work *w) {
  float dx[NP_CLOUD_BLOCK], dy[NP_CLOUD_BLOCK], dz[NP_CLOUD_BLOCK];
  if (!(model->curl_distance_m > 0.0f)) return;
  const np_noise_points points = scale_positions(w, model->curl_frequency_per_m, 0.5f * model->turnover);
  model->noise->curl(&model->curl, &points, dx, dy, dz);
  const float per_top = 1.0f / (float)model->desc.thickness_m;
  for (size_t i = 0; i < w->count; i++) {
    float distance = model->curl_distance_m * (1.0f - 0.6f * w->height_m[i] * per_top);
    w->x_m[i] += distance * dx[i];
    w->y_m[i] += distance * dy[i];
    w->height_m[i] += distance * dz[i];
  }
}

/* The sign of the detail: 1 carves creases between billows, −1 leaves wisps where the creases were. */
static void find_signs(const np_cloud_model *model, const work *w, float *out_signs) {
  const float per_height = 1.0f / (wisp_height * (float)model->desc.thickness_m), wisps = (float)model->desc.wispiness;
  for (size_t i = 0; i < w->count; i++)
    out_signs[i] = 1.0f - 2.0f * wisps * (1.0f - smooth(w->height_m[i] * per_height));
}

static void subtract_detail(const np_cloud_model *model, work *w) {
  float signs[NP_CLOUD_BLOCK];
  find_signs(model, w, signs);
  for (unsigned k = 0; k < model->detail_count; k++) {
    const np_cloud_octave *octave = &model->detail[k];
    const np_noise_points points = scale_positions(w, octave->frequency_per_m, 2.0f * model->turnover);
    model->noise->worley(&octave->lattice, &points, w->noise);
    for (size_t i = 0; i < w->count; i++)
      w->depth[i] -= octave->amplitude * w->relief[i] * signs[i] * (w->noise[i] - octave->mean);
  }
}

/* From depth to extinction: a crisp edge, a base that thickens quickly, a core somewhat denser with height, as liquid
 * water in a rising parcel is; ice is thin and fades gently. */
static float find_extinction(const np_cloud_model *model, float depth, float ice, float height_m) {
  const float top = (float)model->desc.thickness_m, t = height_m / top;
  float body = smooth(depth / (model->edge * (1.0f + ice * (anvil_edge - 1.0f)))) * (1.0f - anvil_thinness * ice);
  if (is_slab(model)) return body > extinction_floor ? (float)model->desc.extinction_per_m * body : 0.0f;
  body *= smooth(height_m / (base_ramp_size * top));
  return body > extinction_floor ? (float)model->desc.extinction_per_m * body * (0.8f + 0.4f * t) : 0.0f;
}

/* Rain below the base, from columns strong enough, in streaks, thinning as it evaporates unless it reaches the sea. */
static void add_rain(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  static const np_noise_octaves octaves = {.count = 3, .gain = 0.5f};
  const float top = (float)model->desc.thickness_m, strength = (float)model->desc.precipitation;
  float rain[NP_CLOUD_BLOCK];
  work w = {.count = 0};
  for (size_t i = 0; i < points->count; i++) {
    float h = points->height_m[i], fallen = -h / model->rain_depth_m;
    if (!(fallen >= 0.0f && fallen < 1.0f)) continue;
    float lean = find_lean(model, h / top);
    float x = points->x_m[i] - (float)model->desc.skew_m[0] * lean;
    float y = points->y_m[i] - (float)model->desc.skew_m[1] * lean;
    float border = eval_border(model, points->x_m[i], points->y_m[i]);
    float column = fminf(eval_column(model, model->map.values, x, y), border) - rain_column;
    if (!(column > 0.0f)) continue;
    size_t n = w.count++;
    w.index[n] = (uint16_t)i;
    w.x_m[n] = x - model->drift_m[0];
    w.y_m[n] = y - model->drift_m[1];
    w.height_m[n] = h / rain_streak_stretch;
    rain[n] =
        smooth(column / rain_column_width) * (1.0f - fallen * fallen * (2.0f - fallen * fallen) * (1.01f - strength));
  }
  if (w.count == 0) return;
  const np_noise_points positions = scale_positions(&w, 1.0f / rain_streak_m, -2.0f * model->turnover);
  model->noise->value_fbm(&model->rain, &octaves, &positions, w.noise);
  for (size_t i = 0; i < w.count; i++) {
    float streak = 0.15f + 1.7f * smooth((w.noise[i] - 0.3f) * 2.5f);
    float extinction = rain_extinction_per_m * strength * rain[i] * streak;
    out_extinction_per_m[w.index[i]] = extinction > 1e-5f ? extinction : 0.0f;
  }
}

static void add_cells(const np_cloud_model *model, work *w) {
  add_base(model, w);
  drop_clear(w, model->detail_gain_max);
  displace(model, w);
  subtract_detail(model, w);
}

void np_cloud_model_eval(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  work w;
  memset(out_extinction_per_m, 0, points->count * sizeof *out_extinction_per_m);
  if (model->is_empty) return;
  if (model->rain_depth_m > 0.0f) add_rain(model, points, out_extinction_per_m);
  start_work(model, points, &w);
  if (w.count == 0) return;
  if (is_slab(model)) {
    displace(model, &w);
    add_sheet(model, &w);
  } else {
    add_cells(model, &w);
  }
  for (size_t i = 0; i < w.count; i++)
    out_extinction_per_m[w.index[i]] = find_extinction(model, w.depth[i], w.ice[i], points->height_m[w.index[i]]);
}

/* The columns that a box may hold at heights between two shares of the thickness, freed from the skew. */
static void find_columns(const np_cloud_model *model, const np_cloud_box *box, float low, float high,
                         float out_min_m[2], float out_max_m[2]) {
  const float lean_low = find_lean(model, low), lean_high = find_lean(model, high);
  for (int i = 0; i < 2; i++) {
    float skew_low = (float)model->desc.skew_m[i] * lean_low, skew_high = (float)model->desc.skew_m[i] * lean_high;
    out_min_m[i] = box->min_m[i] - fmaxf(skew_low, skew_high);
    out_max_m[i] = box->max_m[i] - fminf(skew_low, skew_high);
  }
}

static float bound_columns(const np_cloud_model *model, const float *values, const float min_m[2],
                           const float max_m[2]) {
  return fminf(np_weather_map_get_max(&model->map, values, min_m, max_m) * model->depth_scale + model->depth_offset,
               1.0f);
}

/* The most that the border allows anywhere in the box. */
static float bound_border(const np_cloud_model *model, const np_cloud_box *box) {
  float nearest[2];
  for (int i = 0; i < 2; i++)
    nearest[i] = box->min_m[i] > 0.0f ? box->min_m[i] : box->max_m[i] < 0.0f ? box->max_m[i] : 0.0f;
  return eval_border(model, nearest[0], nearest[1]);
}

/* Rounding is covered by a margin far above it. */
static const float bound_margin = 1e-4f;

static bool is_dry(const np_cloud_model *model, const np_cloud_box *box) {
  const float top = (float)model->desc.thickness_m;
  if (!(model->rain_depth_m > 0.0f) || box->min_m[2] > 0.0f || box->max_m[2] < -model->rain_depth_m) return true;
  float min_m[2], max_m[2];
  find_columns(model, box, fmaxf(box->min_m[2], -model->rain_depth_m) / top, fminf(box->max_m[2], 0.0f) / top, min_m,
               max_m);
  float column = fminf(bound_columns(model, model->map.values, min_m, max_m), bound_border(model, box));
  return column - rain_column < -bound_margin;
}

/* Depth is at most that of the best map value, of the most favourable height and of the point farthest from the border,
 * with all that noise can add. */
bool np_cloud_model_is_empty(const np_cloud_model *model, const np_cloud_box *box) {
  const float top = (float)model->desc.thickness_m;
  if (model->is_empty) return true;
  if (!is_dry(model, box)) return false;
  if (box->max_m[2] <= 0.0f || box->min_m[2] >= top) return true;
  const float low = fmaxf(box->min_m[2], 0.0f) / top, high = fminf(box->max_m[2] / top, 1.0f);
  const float border = bound_border(model, box), gain = model->base_gain_max + model->detail_gain_max;
  float min_m[2], max_m[2];
  find_columns(model, box, low, high, min_m, max_m);
  float depth = fminf(bound_columns(model, model->map.values, min_m, max_m), border) - bound_profile(model, low, high);
  if (model->map.anvils)
    depth = fmaxf(depth, fminf(bound_columns(model, model->map.anvils, min_m, max_m), border) - bound_anvil(low, high));
  return depth + gain < -bound_margin;
}

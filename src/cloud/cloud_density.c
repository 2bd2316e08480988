/* SPDX-License-Identifier: Apache-2.0 */
/* The density of a cloud, after Schneider and Vos 2015, "The Real-time Volumetric Cloudscapes of Horizon: Zero Dawn",
 * and Schneider 2023, "Nubis Cubed".
 *
 * All is a balance of *depth*, a number that is positive inside the cloud:
 *
 *   depth = column (cloud_column.c)  +  base billows  −  detail
 *
 * Noise moves the surface in and out: Perlin-Worley billows of the base shape, then octaves of Worley noise that carve
 * the creases between ever smaller billows, amplitude in proportion to size. Near the base the sign of the detail
 * turns, so that what was a billow becomes a hole and what was a crease a wisp. Positions of the detail are displaced
 * by divergence-free noise. Extinction rises from nothing to the core's within a thin edge of depth: a cumulus is
 * crisp. A slab has the fBm of value noise, sheared, in place of billows and detail; it costs a fifth. Rain falls from
 * strong columns, in streaks.
 *
 * Depth changes by slope_per_m over a metre across the outline, which turns lengths into depth. Only + − × ÷ √ and
 * comparisons decide a value, so that it is the same on every machine.
 */
#include <math.h>
#include <string.h>

#include "cloud/cloud_kinds.h"
#include "cloud/repeat.h"
#include "cloud/thermals.h"
#include "core/math.h"

static const float wisp_height = 0.18f;       /* of the thickness, over which wisps give way to billows */
static const float extinction_floor = 0.002f; /* of the core's: less is nothing */

static const float black_share = 0.002f; /* coverage of a picture below which clouds fade */

static const float anvil_edge = 14.0f; /* times the edge of the tower */
static const float anvil_thinness = 0.8f;

/* Heavy rain, of the order of 50 mm an hour, and what a cloudburst from thermals, of the order of 110, has more. */
static const float rain_extinction_per_m = 4e-3f, cloudburst_gain = 0.75f;
static const float snow_gain = 3.0f, snow_from_m = 2000.0f,
                   snow_full_m = 3500.0f; /* against rain; altitudes of bases */
static const float rain_streak_m = 260.0f, rain_streak_stretch = 14.0f;
static const float shaft_max_m = 2600.0f; /* shafts of rain, and dry air between them */
static const float shaft_size = 1.5f;     /* the same in cells, where they are small: each has its own trail */

/* Scraps below the base of a slab that rains: pannus. */
static const float scrap_m = 520.0f, scrap_depth_m = 560.0f, scrap_share = 0.6f;

/* Scud under a slab: finer noise that eats into the lower part of each sublayer. */
static const float scud_size = 0.35f, scud_depth = 0.5f; /* in billows, and of a sublayer */
static const float scud_reach = 0.7f;                    /* in depth */

/* Fibres of a slab: of ice, where it is drawn out along the wind. */
static const float fibre_size = 0.28f, fibre_draw = 3.5f; /* in billows; times `stretch` along the wind */
static const float fibre_from = 2.0f, fibre_full = 6.0f;  /* in `stretch` */
static const float fibre_least = 0.22f;                   /* of the extinction, between fibres */

/* Gains of value noise in octaves, whose range is seldom filled: of scud, and of relief, which ends smoothly at both
 * ends, or its plateaus would show as patches from above. */
static const float slab_contrast = 2.2f, slab_swing = 1.5f;

static bool is_slab(const np_cloud_model *model) { return model->desc.model == NEPH_CLOUD_MODEL_SLAB; }

/* Points still in question, packed together after each test, so that noise is paid for only where it decides.
 * Positions are in the air, which drifts, turns over, and in a slab is sheared. */
typedef struct work {
  size_t count;
  uint16_t index[NP_CLOUD_BLOCK];
  float x_m[NP_CLOUD_BLOCK], y_m[NP_CLOUD_BLOCK], height_m[NP_CLOUD_BLOCK];
  np_cloud_state state[NP_CLOUD_BLOCK];
  float sx[NP_CLOUD_BLOCK], sy[NP_CLOUD_BLOCK], sz[NP_CLOUD_BLOCK], noise[NP_CLOUD_BLOCK]; /* scratch */
} work;

/* Without skew or a profile of the wind, points over each other share their column. */
static bool is_same_column(const np_cloud_model *model, const np_cloud_points *points, size_t i) {
  return i > 0 && !model->wind.has_shift && points->x_m[i] == points->x_m[i - 1] &&
         points->y_m[i] == points->y_m[i - 1];
}

static void start_work(const np_cloud_model *model, const np_cloud_points *points, work *w) {
  const float top_m = (float)model->desc.thickness_m, gain = model->base_gain_max + model->detail_gain_max;
  np_cloud_column column = {0};
  w->count = 0;
  for (size_t i = 0; i < points->count; i++) {
    const float height_m = points->height_m[i];
    if (!is_same_column(model, points, i))
      column = np_cloud_column_compute(model, points->x_m[i], points->y_m[i], height_m);
    if (!(height_m > 0.0f && height_m < top_m)) continue;
    const np_cloud_state state = np_cloud_column_eval(model, &column, height_m);
    if (!(state.depth + gain > 0.0f)) continue;
    const size_t n = w->count++;
    float carried_m[2] = {0, 0};
    if (!is_slab(model) && model->desc.has_winds) np_cloud_wind_carry(model, height_m, carried_m);
    w->index[n] = (uint16_t)i;
    w->x_m[n] = (is_slab(model) ? column.x_m : points->x_m[i] - carried_m[0]) - model->drift_m[0];
    w->y_m[n] = (is_slab(model) ? column.y_m : points->y_m[i] - carried_m[1]) - model->drift_m[1];
    w->height_m[n] = height_m;
    w->state[n] = state;
  }
}

/* From depth to extinction: a crisp edge, a base that thickens quickly, a core somewhat denser with height, as liquid
 * water in a rising parcel is; ice is thin and fades gently. */
static float compute_extinction(const np_cloud_model *model, const np_cloud_state *s) {
  const float core_per_m = (float)model->desc.extinction_per_m;
  float body = np_smoothstepf(s->depth / (model->edge * np_mixf(1.0f, anvil_edge, s->ice)));
  body *= 1.0f - anvil_thinness * s->ice;
  if (is_slab(model)) return body > extinction_floor ? core_per_m * body : 0.0f;
  body *= np_smoothstepf(s->share * model->base_ramp_inverse);
  return body > extinction_floor ? core_per_m * body * (0.8f + 0.4f * s->share) : 0.0f;
}

/* Drops the points that no further gain of depth can bring into the cloud, and those so deep that no loss can bring
 * them to its edge: these are settled. */
static void settle(const np_cloud_model *model, work *w, float gain, float loss, float *out_extinction_per_m) {
  size_t kept = 0;
  for (size_t i = 0; i < w->count; i++) {
    const np_cloud_state *s = &w->state[i];
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
    w->state[i].depth += w->state[i].relief * model->base.amplitude * (w->noise[i] - model->base.mean);
}

/* Along the heading cells are `stretch` times as long. Each sublayer has a pattern of its own. */
static void add_sheet(const np_cloud_model *model, work *w) {
  const np_noise_octaves octaves = {.count = model->sheet_octave_count, .gain = 0.5f};
  const np_noise_points points = scale_positions(w, model->base.frequency_per_m, model->turnover);
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

/* Share of ice in a slab, whose fibres the wind draws out; a veil has no scud. */
static float compute_fibrous_share(const np_cloud_model *model) {
  return np_smoothstepf(((float)model->desc.stretch - fibre_from) / (fibre_full - fibre_from));
}

/* Carves alone, so that bounds hold. */
static void fray_base(const np_cloud_model *model, work *w) {
  const np_noise_octaves octaves = {.count = model->sheet_octave_count, .gain = 0.6f};
  const float sublayers = (float)model->desc.sublayers, water = 1.0f - compute_fibrous_share(model);
  const float reach = water * scud_reach * (0.6f + (float)model->desc.erosion);
  if (!(reach > 0.0f)) return;
  const float size_m = np_repeat_fit(&model->desc, scud_size / model->base.frequency_per_m);
  np_noise_lattice lattice = model->rain;
  np_repeat_set_period(&model->desc, size_m, 1.0f, &lattice);
  const np_noise_points points = scale_positions(w, 1.0f / size_m, model->turnover);
  model->noise->value_fbm(&lattice, &octaves, &points, w->noise);
  for (size_t i = 0; i < w->count; i++) {
    const float scaled = w->state[i].share * sublayers, place = scaled - (float)(int)scaled;
    const float low = 1.0f - np_smoothstepf(place / scud_depth);
    w->state[i].depth -= reach * low * np_clampf(0.5f + slab_contrast * (w->noise[i] - 0.5f), 0.0f, 1.0f);
  }
}

/* Shares of the extinction in `noise`: fibres hang together over the height, so that they do not average out. */
static void compute_fibres(const np_cloud_model *model, work *w) {
  const np_noise_octaves octaves = {.count = model->sheet_octave_count, .gain = 0.6f};
  const float stretch = fibre_draw * (float)model->desc.stretch, *heading = model->heading;
  const float size_m = np_repeat_fit(&model->desc, fibre_size / model->base.frequency_per_m);
  const float shrink = np_repeat_get_ratio(&model->desc, size_m, size_m * stretch, 1.0f / stretch);
  const float strength = (1.0f - fibre_least) * compute_fibrous_share(model);
  for (size_t i = 0; i < w->count; i++) w->noise[i] = 1.0f;
  if (!(strength > 0.0f)) return;
  np_noise_lattice lattice = model->rain;
  np_repeat_set_period(&model->desc, size_m, stretch, &lattice);
  const np_noise_points points = scale_positions(w, 1.0f / size_m, model->turnover);
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

/* More at the base, where the air turns over, than in the firm tops. */
static void displace(const np_cloud_model *model, work *w) {
  float dx[NP_CLOUD_BLOCK], dy[NP_CLOUD_BLOCK], dz[NP_CLOUD_BLOCK];
  if (!(model->curl_distance_m > 0.0f)) return;
  const np_noise_points points = scale_positions(w, model->curl_frequency_per_m, 0.5f * model->turnover);
  model->noise->curl(&model->curl, &points, dx, dy, dz);
  for (size_t i = 0; i < w->count; i++) {
    const float distance = model->curl_distance_m * (1.0f - 0.6f * w->state[i].share);
    w->x_m[i] += distance * dx[i];
    w->y_m[i] += distance * dy[i];
    w->height_m[i] += distance * dz[i];
  }
}

/* The sign of the detail: 1 carves creases between billows, −1 leaves wisps where the creases were. */
static float compute_sign(const np_cloud_model *model, const np_cloud_state *s) {
  return 1.0f - 2.0f * (float)model->desc.wispiness * (1.0f - np_smoothstepf(s->share / wisp_height));
}

static void subtract_detail(const np_cloud_model *model, work *w, float *out_extinction_per_m) {
  for (unsigned k = 0; k < model->detail_count; k++) {
    const np_cloud_octave *octave = &model->detail[k];
    settle(model, w, octave->gain_max, octave->loss_max, out_extinction_per_m);
    const np_noise_points points = scale_positions(w, octave->frequency_per_m, 2.0f * model->turnover);
    model->noise->worley(&octave->lattice, &points, w->noise);
    for (size_t i = 0; i < w->count; i++) {
      np_cloud_state *s = &w->state[i];
      s->depth -= octave->amplitude * s->relief * compute_sign(model, s) * (w->noise[i] - octave->mean);
    }
  }
}

/* Strength of the shafts in which rain falls; the rain's positions are stretched already. */
static void eval_shafts(const np_cloud_model *model, work *w, float *out_shaft) {
  static const np_noise_octaves octaves = {.count = 3, .gain = 0.5f};
  const float shaft_m = np_minf(shaft_max_m, shaft_size * (float)model->desc.cell_m);
  const np_noise_points positions = scale_positions(w, 1.0f / shaft_m, 0.3f * model->turnover);
  model->noise->value_fbm(&model->base.lattice, &octaves, &positions, out_shaft);
  const float least = np_mixf(0.35f, 0.05f, np_smoothstepf(((float)model->desc.cell_m - shaft_max_m) / shaft_max_m));
  for (size_t i = 0; i < w->count; i++)
    out_shaft[i] = least + (1.0f - least) * np_smoothstepf((out_shaft[i] - 0.38f) * 4.0f);
}

/* Ragged clouds in the rain, close below the base. */
static void add_scraps(const np_cloud_model *model, const np_cloud_points *points, work *w,
                       float *out_extinction_per_m) {
  const np_noise_octaves octaves = {.count = model->sheet_octave_count + 1, .gain = 0.6f};
  size_t kept = 0;
  for (size_t i = 0; i < w->count; i++) {
    const float height_m = points->height_m[w->index[i]];
    if (height_m < -scrap_depth_m) continue;
    w->index[kept] = w->index[i];
    w->x_m[kept] = w->x_m[i];
    w->y_m[kept] = w->y_m[i];
    w->height_m[kept++] = height_m;
  }
  w->count = kept;
  const np_noise_points positions = scale_positions(w, 1.0f / scrap_m, model->turnover);
  for (size_t i = 0; i < w->count; i++) w->sz[i] *= 2.0f; /* flat */
  model->noise->value_fbm(&model->rain, &octaves, &positions, w->noise);
  for (size_t i = 0; i < w->count; i++) {
    const float deep = -w->height_m[i] / scrap_depth_m, threshold = 0.47f + 0.2f * fabsf(2.0f * deep - 0.6f);
    const float body = scrap_share * np_smoothstepf((w->noise[i] - threshold) * 10.0f);
    float *out = &out_extinction_per_m[w->index[i]];
    *out = np_maxf(*out, (float)model->desc.extinction_per_m * body);
  }
}

/* Rain below the base, in streaks and shafts. */
static void add_rain(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  static const np_noise_octaves octaves = {.count = 3, .gain = 0.5f};
  float rain[NP_CLOUD_BLOCK];
  work w = {.count = 0};
  np_cloud_column column = {0};
  for (size_t i = 0; i < points->count; i++) {
    const float height_m = points->height_m[i];
    if (!is_same_column(model, points, i))
      column = np_cloud_column_compute(model, points->x_m[i], points->y_m[i], height_m);
    const float strength = np_cloud_column_eval_rain(model, &column, height_m);
    if (!(strength > 0.0f)) continue;
    const size_t n = w.count++;
    w.index[n] = (uint16_t)i;
    w.x_m[n] = column.x_m - model->drift_m[0];
    w.y_m[n] = column.y_m - model->drift_m[1];
    w.height_m[n] = height_m / rain_streak_stretch;
    rain[n] = strength;
  }
  if (w.count == 0) return;
  const np_noise_points positions = scale_positions(&w, 1.0f / rain_streak_m, -2.0f * model->turnover);
  float shaft[NP_CLOUD_BLOCK];
  const float high = ((float)model->desc.base_altitude_m - snow_from_m) / (snow_full_m - snow_from_m);
  const float precipitation = np_cloud_model_has_thermals(model) ? (float)model->desc.precipitation : 0.0f;
  const float heaviest_per_m = rain_extinction_per_m * (1.0f + cloudburst_gain * precipitation * precipitation) *
                               np_mixf(1.0f, snow_gain, np_smoothstepf(high));
  model->noise->value_fbm(&model->rain, &octaves, &positions, w.noise);
  eval_shafts(model, &w, shaft);
  for (size_t i = 0; i < w.count; i++) {
    const float streak = 0.45f + 1.1f * np_smoothstepf((w.noise[i] - 0.3f) * 2.5f);
    const float extinction = heaviest_per_m * rain[i] * streak * shaft[i];
    out_extinction_per_m[w.index[i]] = extinction > 1e-5f ? extinction : 0.0f;
  }
  if (is_slab(model)) add_scraps(model, points, &w, out_extinction_per_m);
}

static void add_cells(const np_cloud_model *model, work *w, float *out_extinction_per_m) {
  add_base(model, w);
  settle(model, w, model->detail_gain_max, model->detail_loss_max, out_extinction_per_m);
  displace(model, w);
  subtract_detail(model, w, out_extinction_per_m);
}

static void add_slab(const np_cloud_model *model, work *w, float *out_extinction_per_m) {
  displace(model, w);
  add_sheet(model, w);
  fray_base(model, w);
  compute_fibres(model, w);
  for (size_t i = 0; i < w->count; i++)
    out_extinction_per_m[w->index[i]] = w->noise[i] * compute_extinction(model, &w->state[i]);
}

static void eval_points(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  work w;
  if (model->rain_depth_m > 0.0f) add_rain(model, points, out_extinction_per_m);
  const np_cloud_kind *kind = np_cloud_kind_get(model->desc.model);
  if (kind) {
    np_kind_eval(kind, model, points, out_extinction_per_m);
    return;
  }
  if (np_cloud_model_has_thermals(model)) {
    np_thermals_eval(model, points, out_extinction_per_m);
    if (model->map.anvils) np_anvil_eval(model, points, out_extinction_per_m);
    return;
  }
  start_work(model, points, &w);
  if (w.count == 0) return;
  if (is_slab(model)) {
    add_slab(model, &w, out_extinction_per_m);
    return;
  }
  add_cells(model, &w, out_extinction_per_m);
  for (size_t i = 0; i < w.count; i++) out_extinction_per_m[w.index[i]] = compute_extinction(model, &w.state[i]);
}

/* Clears the sky where a picture is black, whatever noise, wind or a neighbour's billows bring there. */
static void keep_to_picture(const np_cloud_model *model, const np_cloud_points *points, float *extinction_per_m) {
  const float *shares = model->map.planes[NEPH_CLOUD_MAP_COVERAGE];
  for (size_t i = 0; shares && i < points->count; i++) {
    if (!(extinction_per_m[i] > 0.0f)) continue;
    const float share = np_weather_map_sample(&model->map, shares, points->x_m[i], points->y_m[i]);
    extinction_per_m[i] *= np_smoothstepf(share / black_share);
  }
}

void np_cloud_model_eval_points(const np_cloud_model *model, const np_cloud_points *points,
                                float *out_extinction_per_m) {
  memset(out_extinction_per_m, 0, points->count * sizeof *out_extinction_per_m);
  if (model->is_empty) return;
  eval_points(model, points, out_extinction_per_m);
  keep_to_picture(model, points, out_extinction_per_m);
}

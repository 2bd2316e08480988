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
 * Depth changes by slope_per_m over a metre across the outline, which turns lengths into depth. Only + − × ÷ and
 * comparisons decide a value, so that it is the same on every machine.
 */
#include <math.h>
#include <string.h>

#include "cloud/cloud_private.h"

/* Mean and largest of the noises, from noise.h. */
static const float base_mean = 0.85f, erosion_mean = 0.30f;

static const float base_reach = 1.6f;         /* amplitude of the base billows, in their own size */
static const float detail_reach = 1.35f;      /* of an octave of detail at erosion 1, in its own size */
static const float detail_boost = 1.2f;       /* of an octave's amplitude over its size, from one octave to the next */
static const float detail_size = 0.46f;       /* of the first octave of detail, in largest billows */
static const float octave_ratio = 0.47f;      /* from one octave to the next: not ½, or lattices would line up */
static const float edge_size = 0.03f;         /* of the crisp edge, in largest billows */
static const float wisp_height = 0.18f;       /* of the thickness, over which wisps give way to billows */
static const float base_ramp_size = 0.035f;   /* of the thickness, over which the base thickens */
static const float curl_size = 0.55f;         /* of the eddies, in largest billows */
static const float curl_reach = 0.12f;        /* of the displacement at turbulence 1, in largest billows */
static const float extinction_floor = 0.002f; /* of the core's: less is nothing */

static float clip01(float x) { return x < 0.0f ? 0.0f : x > 1.0f ? 1.0f : x; }

/* Smooth from 0 at t = 0 to 1 at t = 1. */
static float smooth(float t) {
  t = clip01(t);
  return t * t * (3.0f - 2.0f * t);
}

/* The height profile, for t = h/T ≥ 0: growing, 1 + base_gain_max at the top, which noise can then just reach. */
static float eval_profile(const np_cloud_model *model, float t) {
  float type = (float)model->desc.type, t2 = t * t, low = t2 * t2, tall = t2;
  return (low + type * (tall - low)) * (1.0f + model->base_gain_max + model->detail_gain_max);
}

/* Depth allowed by the border of the field, so that no cloud is cut by a wall; but a field covered all over has one. */
static float eval_border(const np_cloud_model *model, float x_m, float y_m) {
  const neph_cloud_desc *desc = &model->desc;
  float dx = 0.5f * (float)desc->extent_m[0] - fabsf(x_m), dy = 0.5f * (float)desc->extent_m[1] - fabsf(y_m);
  return (dx < dy ? dx : dy) * model->slope_per_m - model->base_gain_max * (1.0f - (float)desc->coverage);
}

/* Where in the map the cloud at a height stands: the top is displaced by the skew against the base. */
static float eval_map_depth(const np_cloud_model *model, float x_m, float y_m, float t) {
  float x = x_m - (float)model->desc.skew_m[0] * t, y = y_m - (float)model->desc.skew_m[1] * t;
  return np_weather_map_sample(&model->map, x, y) * model->depth_scale + model->depth_offset;
}

/* Share of the noise's amplitude over a column: less towards the outline, or crumbs would fly around every cloud. */
static float find_relief(float column) { return 0.55f + 0.45f * smooth(column * 3.5f); }

/* Points still in question, packed together after each test, so that noise is paid for only where it decides. */
typedef struct work {
  size_t count;
  uint16_t index[NP_CLOUD_BLOCK];
  float x_m[NP_CLOUD_BLOCK], y_m[NP_CLOUD_BLOCK], height_m[NP_CLOUD_BLOCK];
  float depth[NP_CLOUD_BLOCK], relief[NP_CLOUD_BLOCK];
  float sx[NP_CLOUD_BLOCK], sy[NP_CLOUD_BLOCK], sz[NP_CLOUD_BLOCK], noise[NP_CLOUD_BLOCK]; /* scratch */
} work;

static void start_work(const np_cloud_model *model, const np_cloud_points *points, work *w) {
  const float top = (float)model->desc.thickness_m, gain = model->base_gain_max + model->detail_gain_max;
  w->count = 0;
  for (size_t i = 0; i < points->count; i++) {
    float x = points->x_m[i], y = points->y_m[i], h = points->height_m[i];
    if (!(h > 0.0f && h < top)) continue;
    float t = h / top, column = eval_map_depth(model, x, y, t), border = eval_border(model, x, y);
    column = column < border ? column : border;
    float depth = column - eval_profile(model, t);
    if (!(depth + gain > 0.0f)) continue;
    size_t n = w->count++;
    w->index[n] = (uint16_t)i;
    w->x_m[n] = x;
    w->y_m[n] = y;
    w->height_m[n] = h;
    w->depth[n] = depth;
    w->relief[n] = find_relief(column);
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
    kept++;
  }
  w->count = kept;
}

static np_noise_points scale_positions(work *w, float frequency_per_m) {
  for (size_t i = 0; i < w->count; i++) {
    w->sx[i] = w->x_m[i] * frequency_per_m;
    w->sy[i] = w->y_m[i] * frequency_per_m;
    w->sz[i] = w->height_m[i] * frequency_per_m;
  }
  return (np_noise_points){w->count, w->sx, w->sy, w->sz};
}

static void add_base(const np_cloud_model *model, work *w) {
  static const np_noise_octaves octaves = {.count = 2, .gain = 0.4f};
  const np_noise_points points = scale_positions(w, model->base.frequency_per_m);
  model->noise->perlin_worley(&model->base.lattice, &octaves, &points, w->noise);
  for (size_t i = 0; i < w->count; i++) w->depth[i] += w->relief[i] * model->base.amplitude * (w->noise[i] - base_mean);
}

/* More at the base, where the air turns over, than in the firm tops. */
static void displace(const np_cloud_model *model, work *w) {
  float dx[NP_CLOUD_BLOCK], dy[NP_CLOUD_BLOCK], dz[NP_CLOUD_BLOCK];
  if (!(model->curl_distance_m > 0.0f)) return;
  const np_noise_points points = scale_positions(w, model->curl_frequency_per_m);
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
    const np_noise_points points = scale_positions(w, octave->frequency_per_m);
    model->noise->worley(&octave->lattice, &points, w->noise);
    for (size_t i = 0; i < w->count; i++)
      w->depth[i] -= octave->amplitude * w->relief[i] * signs[i] * (w->noise[i] - erosion_mean);
  }
}

/* From depth to extinction: a crisp edge, a base that thickens quickly, a core somewhat denser with height, as liquid
 * water in a rising parcel is. */
static float find_extinction(const np_cloud_model *model, float depth, float height_m) {
  const float top = (float)model->desc.thickness_m, t = height_m / top;
  float body = smooth(depth / model->edge) * smooth(height_m / (base_ramp_size * top));
  return body > extinction_floor ? (float)model->desc.extinction_per_m * body * (0.8f + 0.4f * t) : 0.0f;
}

void np_cloud_model_eval(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  work w;
  memset(out_extinction_per_m, 0, points->count * sizeof *out_extinction_per_m);
  if (model->is_empty) return;
  start_work(model, points, &w);
  if (w.count == 0) return;
  add_base(model, &w);
  drop_clear(&w, model->detail_gain_max);
  displace(model, &w);
  subtract_detail(model, &w);
  for (size_t i = 0; i < w.count; i++)
    out_extinction_per_m[w.index[i]] = find_extinction(model, w.depth[i], points->height_m[w.index[i]]);
}

/* Depth is at most that of the best map value, of the lowest height and of the point farthest from the border, with all
 * that noise can add; rounding is covered by a margin far above it. */
bool np_cloud_model_is_empty(const np_cloud_model *model, const np_cloud_box *box) {
  const float top = (float)model->desc.thickness_m;
  if (model->is_empty || box->max_m[2] <= 0.0f || box->min_m[2] >= top) return true;
  const float low = fmaxf(box->min_m[2], 0.0f) / top, high = fminf(box->max_m[2] / top, 1.0f);
  float min_m[2], max_m[2], nearest[2];
  for (int i = 0; i < 2; i++) {
    float skew_low = (float)model->desc.skew_m[i] * low, skew_high = (float)model->desc.skew_m[i] * high;
    min_m[i] = box->min_m[i] - fmaxf(skew_low, skew_high);
    max_m[i] = box->max_m[i] - fminf(skew_low, skew_high);
    nearest[i] = box->min_m[i] > 0.0f ? box->min_m[i] : box->max_m[i] < 0.0f ? box->max_m[i] : 0.0f;
  }
  float depth = np_weather_map_get_max(&model->map, min_m, max_m) * model->depth_scale + model->depth_offset;
  depth = fminf(depth, eval_border(model, nearest[0], nearest[1])) - eval_profile(model, low);
  return depth + model->base_gain_max + model->detail_gain_max < -1e-4f;
}

/* Sets the waterline and what follows from it. */
static void set_waterline(np_cloud_model *model, float waterline) {
  const neph_cloud_desc *desc = &model->desc;
  const float range = model->map.highest - waterline, billow_m = (float)desc->billow_m;
  model->depth_scale = 1.0f / range;
  model->depth_offset = -waterline / range;
  model->slope_per_m = 2.0f / (model->map.radius_m * sqrtf(range));
  model->edge = model->slope_per_m * fmaxf(edge_size * billow_m, 0.75f * (float)desc->voxel_m);
  model->base.amplitude = base_reach * billow_m * model->slope_per_m;
  model->base_gain_max = model->base.amplitude * (1.0f - base_mean);
  float sum = 0.0f, amplitude = detail_reach * (float)desc->erosion * detail_size * billow_m * model->slope_per_m;
  for (unsigned k = 0; k < model->detail_count; k++, amplitude *= octave_ratio * detail_boost) {
    model->detail[k].amplitude = amplitude;
    sum += amplitude;
  }
  model->detail_gain_max = sum * fmaxf(erosion_mean, (2.0f * (float)desc->wispiness - 1.0f) * (1.0f - erosion_mean));
}

static np_noise_lattice make_lattice(const np_cloud_model *model, unsigned stream) {
  return (np_noise_lattice){np_noise_derive_seed(model->desc.seed, stream),
                            {NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX}};
}

/* Octaves of detail as long as a billow covers two voxels. */
static void choose_noises(np_cloud_model *model) {
  const float billow_m = (float)model->desc.billow_m;
  model->base.lattice = make_lattice(model, NP_CLOUD_STREAM_BASE);
  model->base.frequency_per_m = 1.0f / billow_m;
  model->curl = make_lattice(model, NP_CLOUD_STREAM_CURL);
  model->curl_frequency_per_m = 1.0f / (curl_size * billow_m);
  model->curl_distance_m = curl_reach * billow_m * (float)model->desc.turbulence;
  float size_m = detail_size * billow_m;
  for (unsigned k = 0; k < NP_CLOUD_OCTAVES_MAX && size_m >= 2.0f * (float)model->desc.voxel_m; k++) {
    model->detail[k].lattice = make_lattice(model, NP_CLOUD_STREAM_DETAIL + k);
    model->detail[k].frequency_per_m = 1.0f / size_m;
    model->detail_count = k + 1;
    size_m *= octave_ratio;
  }
}

enum { CENSUS_COLUMNS = 64, CENSUS_HEIGHTS = 14, CENSUS_STEPS = 14 };

typedef struct census {
  const np_cloud_model *model;
  atomic_size_t covered;
} census;

/* Counts the columns of one row of the field in which there is any cloud. */
static size_t count_covered(const np_cloud_model *model, size_t row) {
  float x[CENSUS_COLUMNS], y[CENSUS_COLUMNS], height[CENSUS_COLUMNS], extinction[CENSUS_COLUMNS];
  float deepest[CENSUS_COLUMNS] = {0};
  const float cell[2] = {(float)model->desc.extent_m[0] / CENSUS_COLUMNS,
                         (float)model->desc.extent_m[1] / CENSUS_COLUMNS};
  const np_cloud_points points = {CENSUS_COLUMNS, x, y, height};
  for (int level = 0; level < CENSUS_HEIGHTS; level++) {
    for (int i = 0; i < CENSUS_COLUMNS; i++) {
      x[i] = ((float)i + 0.5f - 0.5f * CENSUS_COLUMNS) * cell[0];
      y[i] = ((float)row + 0.5f - 0.5f * CENSUS_COLUMNS) * cell[1];
      height[i] = ((float)level + 0.5f) * (0.7f / CENSUS_HEIGHTS) * (float)model->desc.thickness_m;
    }
    np_cloud_model_eval(model, &points, extinction);
    for (int i = 0; i < CENSUS_COLUMNS; i++) deepest[i] = fmaxf(deepest[i], extinction[i]);
  }
  size_t covered = 0;
  for (int i = 0; i < CENSUS_COLUMNS; i++) covered += deepest[i] > 0.0f;
  return covered;
}

static neph_result count_rows(void *user, size_t begin, size_t end, unsigned thread) {
  census *c = user;
  (void)thread;
  for (size_t row = begin; row < end; row++) atomic_fetch_add(&c->covered, count_covered(c->model, row));
  return NEPH_OK;
}

/* The covered fraction falls as the waterline rises: found by halving. What billows add at an outline and creases take
 * from it is in the count, so that no formula for it is needed. */
static neph_result find_waterline(neph_context *context, np_monitor *monitor, np_cloud_model *model) {
  const float spread = model->map.highest - model->map.lowest;
  float low = model->map.lowest - 0.5f * spread, high = model->map.highest - 0.01f * spread;
  for (int step = 0; step < CENSUS_STEPS; step++) {
    census c = {.model = model};
    atomic_init(&c.covered, 0);
    const float middle = 0.5f * (low + high);
    set_waterline(model, middle);
    neph_result result = np_parallel_for(context, monitor, CENSUS_COLUMNS, 1, count_rows, &c);
    if (result) return result;
    double fraction = (double)atomic_load(&c.covered) / (CENSUS_COLUMNS * CENSUS_COLUMNS);
    *(fraction > model->desc.coverage ? &low : &high) = middle;
  }
  set_waterline(model, 0.5f * (low + high));
  return NEPH_OK;
}

neph_result np_cloud_model_build(neph_context *context, const neph_cloud_desc *desc, np_monitor *monitor,
                                 np_cloud_model *out_model) {
  np_cloud_model model = {.desc = *desc, .noise = np_noise_get_table(context->isa), .is_empty = !(desc->coverage > 0)};
  neph_result result = np_weather_map_build(context, desc, monitor, &model.map);
  if (result) return result;
  choose_noises(&model);
  result = find_waterline(context, monitor, &model);
  if (result) {
    np_cloud_model_clear(&model);
    return result;
  }
  *out_model = model;
  return NEPH_OK;
}

void np_cloud_model_clear(np_cloud_model *model) {
  np_weather_map_clear(&model->map);
  *model = (np_cloud_model){0};
}

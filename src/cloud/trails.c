/* SPDX-License-Identifier: Apache-2.0 */
/* Contrails: lines that begin as the vortex pair of an aircraft's wake, break up by mutual instability (Crow 1970),
 * sink, and spread to bands of ice with fall streaks.
 *
 * Age decreases along a trail towards the aircraft. Eddies of the air bend it, more with age. With age a pair of tubes
 * that oscillate around their axes becomes one elliptic band, wider than high, that thins as it widens, with a tail
 * below. Skew and wind profile shear it like columns; where the weather map is weak there is no trail. */
#include <math.h>

#include "cloud/cloud_kinds.h"
#include "cloud/kind_points.h"
#include "cloud/waterline.h"
#include "core/math.h"
#include "core/random.h"

static const float fresh_width_m = 45.0f,
                   fresh_height_m = 26.0f; /* half width and half height of the band of a fresh trail */
static const float tube_apart_m = 26.0f, tube_radius_m = 20.0f;
static const float swing_m = 420.0f;       /* wavelength of the oscillating tubes */
static const float height_share = 0.16f;   /* half height of an old band, relative to the thickness */
static const float sink_share = 0.16f;     /* sinking at age 1, relative to the thickness */
static const float tail_share = 0.42f;     /* length of the tail, relative to the thickness */
static const float younger = 0.45f;        /* relative decrease of age along the trail */
static const float level = 0.95f;          /* level of the highest tops, in thicknesses */
static const float patch_strength = 0.12f; /* strength of the map at which trails are complete */
static const float fibre_stretch = 9.0f;
static const float reach = 1.7f; /* amplitude of noise, relative to the widths */
static const float bend_size_m = 2600.0f,
                   bend_share = 0.55f; /* eddies, and their displacement of a trail at age 1, relative to `billow` */
static const float extinction_floor = 0.004f;

/* Random number of a trail, in [0, 1]. */
static float draw(const neph_cloud_desc *desc, unsigned trail, unsigned item) {
  const uint64_t seed = np_random_absorb(desc->seed, NP_CLOUD_STREAM_CELLS);
  return (float)(np_random_absorb(np_random_absorb(seed, trail), item) >> 40) * 0x1p-24f;
}

static np_trail make_trail(const neph_cloud_desc *desc, unsigned index) {
  double along[2]; /* sine and cosine of the azimuth: x and y */
  np_cloud_compute_direction(desc->trail_direction_rad, along);
  const float turn = index ? 0.9f * (draw(desc, index, 0) - 0.5f) : 0.0f, norm = 1.0f / sqrtf(1.0f + turn * turn);
  const float x = (float)along[0], y = (float)along[1],
              half_m = 0.5f * (float)fmin(desc->extent_m[0], desc->extent_m[1]);
  np_trail t = {.along = {(x - turn * y) * norm, (y + turn * x) * norm}};
  t.age = (float)desc->age * (index ? np_mixf(0.35f, 1.0f, draw(desc, index, 1)) : 1.0f);
  t.offset_m = index ? 1.5f * half_m * (draw(desc, index, 2) - 0.5f) : 0.0f;
  t.half_m = half_m;
  t.width_max_m = fresh_width_m + t.age * t.age * (float)desc->billow_m;
  t.drop = index ? 0.08f * draw(desc, index, 3) : 0.0f;
  return t;
}

static void prepare_trails(np_cloud_model *model) {
  const neph_cloud_desc *desc = &model->desc;
  np_kind_noises *k = &model->noises;
  k->coarse = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_BASE);
  k->medium = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_DETAIL);
  k->fine = np_cloud_make_lattice(desc, NP_CLOUD_STREAM_WISPS);
  k->fine_m = np_maxf(110.0f, 2.5f * (float)desc->voxel_m);
  k->fine_octaves = np_kind_count_octaves(desc, k->fine_m);
  k->edge_m = 1.3f * (float)desc->voxel_m;
  for (unsigned i = 0; i < desc->trails; i++) model->trails[i] = make_trail(desc, i);
}

/* Position relative to a trail: along it, across it, and height. */
typedef struct trail_point {
  float along_m, across_m, height_m, puff, fibre; /* puff and fibre: noises in [−½, ½] */
} trail_point;

/* Sine of an angle in turns, by parabolas. */
static float compute_sine(float turns) {
  const float t = turns - floorf(turns), half = t < 0.5f ? t : t - 0.5f, arc = 16.0f * half * (0.5f - half);
  return t < 0.5f ? arc : -arc;
}

/* The pair of vortices: 1 on an axis, 0 outside of the tubes. They oscillate in opposite directions, more with age. */
static float compute_tubes(const np_cloud_model *model, const trail_point *p, float age, float top_m) {
  const float radius_m = np_maxf(tube_radius_m * (1.0f + 2.0f * age + 0.8f * p->puff), model->noises.edge_m);
  const float swing = compute_sine(p->along_m / swing_m) * np_smoothstepf(age / 0.16f);
  const float apart_m = np_maxf(tube_apart_m, 0.7f * radius_m) * (1.0f + 0.75f * swing);
  const float x = fabsf(p->across_m) - apart_m,
              z = p->height_m - (top_m - radius_m - 60.0f * age + 30.0f * (swing - 1.0f) * age);
  return 1.0f - (x * x + z * z) / (radius_m * radius_m);
}

/* The later band, with its tail of falling ice fibres. */
static float compute_band(const np_cloud_model *model, const trail_point *p, float age, float top_m, float width_m) {
  const float thickness_m = (float)model->desc.thickness_m;
  const float half_m = np_maxf(fresh_height_m + height_share * age * thickness_m, model->noises.edge_m);
  const float wide_m = np_maxf(width_m * (1.0f + 0.9f * p->puff), model->noises.edge_m);
  const float x = p->across_m / wide_m, z = p->height_m - (top_m - half_m * (1.0f + 0.6f * p->puff));
  const float tail_m = tail_share * age * age * thickness_m * np_maxf(0.35f + 2.0f * p->fibre, 0.0f);
  const float up = z / (z > 0.0f ? half_m : half_m + tail_m);
  return 1.0f - x * x - up * up;
}

static float compute_age(const np_trail *t, float along_m) {
  return t->age * (1.0f - younger * np_clampf(0.5f + 0.5f * along_m / t->half_m, 0.0f, 1.0f));
}

static float eval_trail(const np_cloud_model *model, const np_trail *t, const trail_point *p) {
  const neph_cloud_desc *desc = &model->desc;
  const float age = compute_age(t, p->along_m);
  const float width_m = fresh_width_m + age * age * (float)desc->billow_m;
  const float top_m = (float)desc->thickness_m * (level - t->drop - sink_share * age);
  const float old = np_smoothstepf((age - 0.08f) / 0.2f);
  float body = 0.0f;
  if (old < 1.0f) body = (1.0f - old) * np_smoothstepf(1.6f * compute_tubes(model, p, age, top_m));
  if (old > 0.0f) {
    const float frayed = compute_band(model, p, age, top_m, width_m) + 1.4f * (float)desc->erosion * old * p->fibre;
    body += old * np_smoothstepf(frayed / np_mixf(0.5f, 1.1f, age)) / (1.0f + 5.0f * age);
  }
  return body;
}

/* Displacement by eddies across a trail of age 1, in metres. */
static void compute_bends(const np_cloud_model *model, np_kind_points *p, float *out_bend_m) {
  static const np_noise_octaves octaves = {.count = 3, .gain = 0.42f};
  const np_noise_points points = np_kind_scale(model, p, bend_size_m, 1.0f);
  const float reach_m = 2.0f * bend_share * (float)model->desc.billow_m;
  for (size_t i = 0; i < p->count; i++) p->sz[i] = 0.47f + 0.3f * model->turnover;
  model->noise->value_fbm(&model->noises.coarse, &octaves, &points, out_bend_m);
  for (size_t i = 0; i < p->count; i++) out_bend_m[i] = reach_m * (out_bend_m[i] - 0.5f);
}

static void compute_noises(const np_cloud_model *model, np_kind_points *p, float *out_puff, float *out_fibre) {
  const np_kind_noises *k = &model->noises;
  const np_noise_octaves two = {.count = 2, .gain = 0.5f}, all = {.count = k->fine_octaves, .gain = 0.6f};
  np_noise_points points = np_kind_scale(model, p, 2.6f * k->fine_m, 1.0f);
  model->noise->value_fbm(&k->medium, &two, &points, out_puff);
  points = np_kind_scale(model, p, k->fine_m, fibre_stretch);
  for (size_t i = 0; i < p->count; i++) p->sz[i] /= fibre_stretch;
  model->noise->value_fbm(&k->fine, &all, &points, out_fibre);
  for (size_t i = 0; i < p->count; i++) {
    out_puff[i] = np_clampf(1.4f * (out_puff[i] - 0.5f), -0.5f, 0.5f);
    out_fibre[i] = np_clampf(1.8f * (out_fibre[i] - 0.5f), -0.5f, 0.5f);
  }
}

static void eval_trails(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  np_kind_points p;
  if (!np_kind_points_collect(model, points, &p)) return;
  const neph_cloud_desc *desc = &model->desc;
  float puff[NP_CLOUD_BLOCK], fibre[NP_CLOUD_BLOCK], bend_m[NP_CLOUD_BLOCK];
  compute_noises(model, &p, puff, fibre);
  compute_bends(model, &p, bend_m);
  for (size_t i = 0; i < p.count; i++) {
    float body = 0.0f;
    for (unsigned n = 0; n < desc->trails; n++) {
      const np_trail *t = &model->trails[n];
      const float x = p.field_x_m[i], y = p.field_y_m[i];
      const float straight_m = y * t->along[0] - x * t->along[1] - t->offset_m;
      const float across_m = straight_m + compute_age(t, x * t->along[0] + y * t->along[1]) * bend_m[i];
      if (fabsf(across_m) > reach * (t->width_max_m + model->noises.edge_m)) continue;
      const trail_point at = {x * t->along[0] + y * t->along[1], across_m, p.height_m[i], puff[i], fibre[i]};
      body += eval_trail(model, t, &at);
    }
    const float share = np_minf(body, 1.0f) * np_smoothstepf(p.strength[i] / patch_strength);
    if (share > extinction_floor) out_extinction_per_m[p.index[i]] = (float)desc->extinction_per_m * share;
  }
}

/* Compares the distance of the box's centre from each line with the largest reach of its corners and the trail. */
static bool is_trail_empty(const np_cloud_model *model, const np_cloud_box *box) {
  np_kind_box bounded;
  if (!np_kind_box_make(model, box, &bounded)) return true;
  const float x = 0.5f * (bounded.field_min_m[0] + bounded.field_max_m[0]);
  const float y = 0.5f * (bounded.field_min_m[1] + bounded.field_max_m[1]);
  const float half_x = 0.5f * (bounded.field_max_m[0] - bounded.field_min_m[0]);
  const float half_y = 0.5f * (bounded.field_max_m[1] - bounded.field_min_m[1]);
  for (unsigned n = 0; n < model->desc.trails; n++) {
    const np_trail *t = &model->trails[n];
    const float across_m = fabsf(y * t->along[0] - x * t->along[1] - t->offset_m);
    const float corner_m = half_x * fabsf(t->along[1]) + half_y * fabsf(t->along[0]);
    const float bend_m = t->age * bend_share * (float)model->desc.billow_m;
    if (across_m - corner_m < reach * (t->width_max_m + model->noises.edge_m) + bend_m + 1.0f) return false;
  }
  return true;
}

const np_cloud_kind np_trails_kind = {
    .name = "trails",
    .landscape = {.form = NP_LANDSCAPE_SHEET, .swirl_size = 1.3f},
    .more_cover = "lines of this number cover no more; raise trails",
    .less_cover = "lines of this number cover no less; reduce trails",
    .repeat_obstacle = "lines across the whole field",
    .is_line = true,
    .billow_grains = 7,
    .census_passes = 4,
    .prepare = prepare_trails,
    .search_waterline = np_waterline_search,
    .eval = eval_trails,
    .is_empty = is_trail_empty,
};

/* SPDX-License-Identifier: Apache-2.0 */
/* Billows: balls on the surface of the previous levels, level by level down to two voxels.
 *
 * Two random points in each cell of a lattice, which rises with the air, are moved along the gradient of the distance
 * to the surface. A ball is placed there, farther out on tops and young thermals than on flanks and old ones, with its
 * centre at most 0.68 of its radius outside, so that it touches its parent. The first level is dense and protrudes,
 * fine ones are sparse and embedded: relief below the transport mean free path would only whiten the cloud. Radii
 * vanish at every limit, so that billows appear gradually. */
#include "cloud/billows.h"

#include <math.h>
#include <string.h>

#include "cloud/ball_rows.h"
#include "cloud/cloud_streams.h"
#include "cloud/repeat.h"
#include "cloud/thermal_density.h"
#include "core/math.h"
#include "core/random.h"

enum { EDGE = 4, CELL_POINTS = 2, BLOCK_POINTS = EDGE * EDGE * EDGE * CELL_POINTS };

static const float first_spacing = 0.71f,
                   spacing_ratio = 0.5f;  /* spacing of the lattices, the first in largest billows */
static const float search_depth = 0.55f;  /* distance from the surface, in spacings */
static const float least_voxels = 0.5f;   /* least radius: smaller ones are invisible */
static const float billow_blend = 0.035f; /* width of the blend, in spacings */

static float compute_spacing_m(const np_cloud_model *model, unsigned level) {
  float spacing_m = first_spacing * model->thermals.billow_m;
  for (unsigned l = 1; l < level; l++) spacing_m *= spacing_ratio;
  return np_repeat_fit(&model->desc, EDGE * spacing_m) / EDGE; /* a repeating field has whole blocks */
}

unsigned np_thermals_count_levels(const np_cloud_model *model) {
  unsigned count = 1;
  while (count < NP_BALL_LEVELS && compute_spacing_m(model, count) >= 2.0f * (float)model->desc.voxel_m) count++;
  return count;
}

typedef struct billow_rows {
  const np_cloud_model *model;
  unsigned level;
  float spacing_m, rise_m;
  float amounts[NEPH_CLOUD_PARTS], octaves[NEPH_CLOUD_PARTS]; /* octaves by which the largest billows are smaller */
  int32_t first[3], count[3];                                 /* blocks of EDGE³ cells */
  int32_t period; /* cells per period of a repeating field; 0: not repeating */
} billow_rows;

/* Points of a block, with a hash for each. */
typedef struct point_block {
  float x_m[BLOCK_POINTS], y_m[BLOCK_POINTS], z_m[BLOCK_POINTS];
  uint64_t hash[BLOCK_POINTS];
  float distance_m[BLOCK_POINTS], age[BLOCK_POINTS], radius_m[BLOCK_POINTS], normal[3][BLOCK_POINTS];
  float patch[BLOCK_POINTS];
} point_block;

static float get_fraction(uint64_t hash, int field) { return (float)(hash >> (16 * field) & 0xffffu) * 0x1p-16f; }

static void draw_points(const billow_rows *rows, const int32_t at[3], point_block *b) {
  const np_cloud_model *model = rows->model;
  for (int n = 0; n < BLOCK_POINTS; n++) {
    const int32_t cell[3] = {at[0] * EDGE + n / (EDGE * EDGE * CELL_POINTS),
                             at[1] * EDGE + n / (EDGE * CELL_POINTS) % EDGE, at[2] * EDGE + n / CELL_POINTS % EDGE};
    const int32_t i = np_repeat_wrap(cell[0], rows->period), j = np_repeat_wrap(cell[1], rows->period);
    const uint64_t seed = np_random_absorb(model->desc.seed, NP_CLOUD_STREAM_BILLOWS + rows->level);
    uint64_t hash = np_random_absorb(seed, (uint64_t)(uint32_t)i << 32 | (uint32_t)j);
    hash = np_random_absorb(hash, (uint64_t)(uint32_t)cell[2] << 1 | (uint64_t)(n % CELL_POINTS));
    b->hash[n] = np_random_mix(hash);
    b->x_m[n] = ((float)cell[0] + get_fraction(hash, 0)) * rows->spacing_m + model->drift_m[0];
    b->y_m[n] = ((float)cell[1] + get_fraction(hash, 1)) * rows->spacing_m + model->drift_m[1];
    b->z_m[n] = ((float)cell[2] + get_fraction(hash, 2)) * rows->spacing_m + rows->rise_m;
  }
}

/* Moves points to the surface, and draws the patches with larger billows. */
static void move_to_surface(const billow_rows *rows, point_block *b) {
  float x[BLOCK_POINTS], y[BLOCK_POINTS], z[BLOCK_POINTS];
  np_noise_lattice lattice = {np_noise_derive_seed(rows->model->desc.seed, NP_CLOUD_STREAM_PATCHES + rows->level),
                              {NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX}};
  const float size_m = 3.1f * rows->spacing_m, frequency_per_m = 1.0f / np_repeat_fit(&rows->model->desc, size_m);
  np_repeat_set_period(&rows->model->desc, size_m, 1.0f, &lattice);
  for (int n = 0; n < BLOCK_POINTS; n++) {
    const float off_m = b->distance_m[n] < 2.0f * rows->spacing_m ? b->distance_m[n] : 0.0f;
    b->x_m[n] -= off_m * b->normal[0][n];
    b->y_m[n] -= off_m * b->normal[1][n];
    b->z_m[n] -= off_m * b->normal[2][n];
    x[n] = (b->x_m[n] - rows->model->drift_m[0]) * frequency_per_m;
    y[n] = (b->y_m[n] - rows->model->drift_m[1]) * frequency_per_m;
    z[n] = (b->z_m[n] - rows->rise_m) * frequency_per_m;
  }
  rows->model->noise->perlin(&lattice, &(np_noise_points){BLOCK_POINTS, x, y, z}, b->patch);
}

/* Interpolates a value between tops, flanks and base at a point of the surface. */
static float blend_parts(const billow_rows *rows, const point_block *b, int n, const float parts[NEPH_CLOUD_PARTS]) {
  const float top = np_smoothstepf((b->normal[2][n] - 0.1f) / 0.5f);
  const float base = 1.0f - np_smoothstepf((b->z_m[n] / rows->model->thermals.billow_m - 0.1f) / 0.5f);
  return np_mixf(np_mixf(parts[1], parts[0], top), parts[2], base);
}

/* Amount and billowiness of the billows at a point, and their level, counted from the largest one in use. */
typedef struct billow_kind {
  float amount, billowiness, level;
} billow_kind;

static billow_kind choose_kind(const billow_rows *rows, const point_block *b, int n) {
  const float amount = blend_parts(rows, b, n, rows->amounts);
  return (billow_kind){np_minf(4.0f * amount, 1.0f), (float)rows->model->desc.billowiness * amount,
                       (float)rows->level - blend_parts(rows, b, n, rows->octaves)};
}

/* Radius relative to the spacing; 0 at each limit. */
static float compute_radius(const billow_rows *rows, const point_block *b, int n, float off_m, float up,
                            const billow_kind *kind) {
  const float spacing_m = rows->spacing_m, drawn = get_fraction(b->hash[n], 0),
              old = rows->level > 1 ? 0.6f * b->age[n] : 0.0f;
  float radius =
      0.88f * (0.34f + 0.48f * drawn * drawn * drawn) * np_mixf(0.75f, 1.0f, up) * (1.0f + 0.5f * b->patch[n]);
  radius *= (n % CELL_POINTS ? 0.62f : 1.0f) * (1.0f - old) * (0.6f + 0.8f * kind->billowiness);
  radius = np_minf(radius, 0.72f * b->radius_m[n] / spacing_m);
  radius *= 1.0f - np_smoothstepf((fabsf(off_m) / spacing_m - 0.40f) / (search_depth - 0.40f));
  radius *= np_smoothstepf((b->z_m[n] / spacing_m + 0.1f) / 0.25f);
  radius *= np_clampf(kind->level, 0.0f, 1.0f) * kind->amount;
  const float least = np_maxf(0.08f, least_voxels * (float)rows->model->desc.voxel_m / spacing_m);
  return radius * np_smoothstepf((radius - least) / least);
}

/* Distance of the centre outside the surface, in radii. */
static float compute_protrusion(const point_block *b, int n, float up, const billow_kind *kind) {
  const uint64_t hash = b->hash[n];
  float out = 0.75f * (0.2f + 1.6f * get_fraction(hash, 1)) * np_mixf(0.35f, 1.0f, up) * (1.0f - b->age[n]);
  const float level = np_maxf(kind->level, 1.0f), first = np_maxf(2.0f - level, 0.0f);
  out += first * 0.30f * np_mixf(0.5f, 1.0f, up) * (0.5f + get_fraction(hash, 2));
  out -= 0.85f * (level - 1.0f) / 3.0f * (0.6f + 0.8f * get_fraction(hash, 3));
  return np_minf(out * (0.5f + kind->billowiness), 0.68f);
}

static neph_result add_billow(const billow_rows *rows, const point_block *b, int n, float off_m, np_ball_list *list) {
  const neph_cloud_desc *desc = &rows->model->desc;
  const billow_kind kind = choose_kind(rows, b, n);
  if (kind.level > 2.0f && get_fraction(np_random_mix(b->hash[n]), 0) >= 0.35f) return NEPH_OK;
  const float up = np_smoothstepf((b->normal[2][n] + 0.75f) / 1.1f);
  const float radius_m = rows->spacing_m * compute_radius(rows, b, n, off_m, up, &kind);
  if (!(radius_m > 0.02f * rows->spacing_m)) return NEPH_OK;
  const float out_m = radius_m * compute_protrusion(b, n, up, &kind);
  const float lift_m = rows->level < 3 ? 0.1f * radius_m * up : 0.0f;
  const float aging = 0.12f * (get_fraction(np_random_mix(b->hash[n]), 1) - 0.5f) * (float)desc->age;
  const np_ball ball = {.x_m = b->x_m[n] + out_m * b->normal[0][n],
                        .y_m = b->y_m[n] + out_m * b->normal[1][n],
                        .z_m =
                            np_minf(b->z_m[n] + out_m * b->normal[2][n] + lift_m, (float)desc->thickness_m - radius_m),
                        .radius_m = radius_m,
                        .age = np_clampf(b->age[n] + aging, 0.0f, 1.0f)};
  return np_ball_list_add(rows->model->context, list, &ball);
}

static neph_result add_block(const billow_rows *rows, const int32_t at[3], np_ball_list *list) {
  point_block b;
  float off_m[BLOCK_POINTS];
  const np_ball_surface surface = {b.distance_m, b.age, b.radius_m, {b.normal[0], b.normal[1], b.normal[2]}};
  const np_ball_points points = {BLOCK_POINTS, b.x_m, b.y_m, b.z_m};
  const float reach_m = search_depth * rows->spacing_m;
  float min_m[3], max_m[3];
  for (int a = 0; a < 3; a++) {
    const float shift_m = a < 2 ? rows->model->drift_m[a] : rows->rise_m;
    min_m[a] = (float)(at[a] * EDGE) * rows->spacing_m + shift_m;
    max_m[a] = (float)(at[a] * EDGE + EDGE) * rows->spacing_m + shift_m;
  }
  if (!np_ball_heap_is_near(&rows->model->balls, min_m, max_m, reach_m)) return NEPH_OK;
  draw_points(rows, at, &b);
  if (!np_ball_heap_search(&rows->model->balls, &points, reach_m, &surface)) return NEPH_OK;
  memcpy(off_m, b.distance_m, sizeof off_m);
  move_to_surface(rows, &b);
  neph_result result = NEPH_OK;
  for (int n = 0; n < BLOCK_POINTS && !result; n++)
    if (fabsf(off_m[n]) < reach_m) result = add_billow(rows, &b, n, off_m[n], list);
  return result;
}

static neph_result add_row(const void *user, size_t row, np_ball_list *list) {
  const billow_rows *rows = user;
  neph_result result = NEPH_OK;
  const int32_t i = (int32_t)(row / (size_t)rows->count[1]), j = (int32_t)(row % (size_t)rows->count[1]);
  for (int32_t k = 0; k < rows->count[2] && !result; k++) {
    const int32_t at[3] = {rows->first[0] + i, rows->first[1] + j, rows->first[2] + k};
    result = add_block(rows, at, list);
  }
  return result;
}

neph_result np_thermals_add_billows(np_cloud_model *model, np_monitor *monitor, unsigned level) {
  const neph_cloud_desc *desc = &model->desc;
  const float spacing_m = compute_spacing_m(model, level), block_m = EDGE * spacing_m;
  billow_rows rows = {.model = model, .level = level, .spacing_m = spacing_m};
  for (int p = 0; p < NEPH_CLOUD_PARTS; p++) {
    rows.amounts[p] = (float)desc->billow_amounts[p];
    rows.octaves[p] = np_thermals_count_octaves(desc->billow_frequencies[p]);
  }
  rows.rise_m = model->turnover * model->thermals.billow_m;
  const float low_m[3] = {-0.5f * (float)desc->extent_m[0] - model->drift_m[0],
                          -0.5f * (float)desc->extent_m[1] - model->drift_m[1], -spacing_m - rows.rise_m};
  const float size_m[3] = {(float)desc->extent_m[0], (float)desc->extent_m[1], (float)desc->thickness_m + spacing_m};
  for (int a = 0; a < 3; a++) {
    rows.first[a] = (int32_t)floorf(low_m[a] / block_m);
    rows.count[a] = (int32_t)floorf((low_m[a] + size_m[a]) / block_m) - rows.first[a] + 1;
  }
  if (desc->repeat_m > 0) {
    rows.count[0] = rows.count[1] = np_repeat_count(desc->extent_m[0], (double)block_m);
    rows.period = EDGE * rows.count[0];
    model->balls.margin_m = np_maxf(3.2f * spacing_m, model->thermals.reach_max_m + 2.0f * model->thermals.warp_max_m);
  }
  return np_ball_rows_collect(&model->balls, monitor, (size_t)rows.count[0] * (size_t)rows.count[1], add_row, &rows,
                              billow_blend * spacing_m, np_maxf(0.8f * spacing_m, 8.0f * (float)desc->voxel_m));
}

/* SPDX-License-Identifier: Apache-2.0 */
/* The weather map: where cumulus cells stand, and how large each is.
 *
 * A jittered grid of paraboloids a − r²/R², of one curvature and random height a, and a finer one of small cells
 * between them; the landscape is the highest of all. Cut by a waterline t it shows rounded islands of radius R·√(a −
 * t), as varied as the heights: many small, few large. Low-frequency Perlin noise raises groups of cells and leaves
 * clearings; a domain warp makes outlines irregular.
 */
#include <math.h>

#include "cloud/cloud_private.h"
#include "core/alloc.h"
#include "core/random.h"

enum { TEXELS_PER_CELL = 48, TEXELS_MAX = 1 << 14 /* along a side */ };

/* In units of the cell spacing. */
static const float cell_radius = 0.52f, warp_size = 0.9f, warp_reach = 0.6f, group_size = 4.3f;
static const float group_height = 0.7f; /* times Perlin noise of standard deviation 0.19 */
static const float small_spacing = 0.43f, small_height = 0.40f;
static const float shore_width = 0.35f, shore_depth = 1.2f; /* where the landscape sinks towards the field's border */

typedef struct cell {
  float x, y, height;            /* centre, relative to the cell's corner */
  float axis_x, axis_y, stretch; /* the outline is an ellipse, longer along the axis by stretch² */
} cell;

static float take_16_bits(uint64_t bits, int field) { return (float)(bits >> (16 * field) & 0xffffu) * 0x1p-16f; }

static cell draw_cell(uint64_t seed, int32_t i, int32_t j) {
  uint64_t bits = np_random_absorb(seed, (uint64_t)(uint32_t)i << 32 | (uint32_t)j), more = np_random_mix(bits);
  float u = take_16_bits(bits, 2), turn = 2.0f * take_16_bits(bits, 3) - 1.0f, norm = 1.0f / (1.0f + turn * turn);
  return (cell){.x = take_16_bits(bits, 0),
                .y = take_16_bits(bits, 1),
                .height = 0.08f + 0.92f * u * u,
                .axis_x = (1.0f - turn * turn) * norm,
                .axis_y = 2.0f * turn * norm,
                .stretch = 1.0f + 0.35f * take_16_bits(more, 0)};
}

/* Highest paraboloid at (x, y), in units of this grid's spacing; `curvature` is 1/R². */
static float find_highest(uint64_t seed, float x, float y, float height, float curvature) {
  int32_t i0 = (int32_t)floorf(x), j0 = (int32_t)floorf(y);
  float best = -INFINITY;
  for (int32_t j = j0 - 2; j <= j0 + 2; j++)
    for (int32_t i = i0 - 2; i <= i0 + 2; i++) {
      cell c = draw_cell(seed, i, j);
      float dx = x - (float)i - c.x, dy = y - (float)j - c.y;
      float along = (dx * c.axis_x + dy * c.axis_y) / c.stretch, across = (dy * c.axis_x - dx * c.axis_y) * c.stretch;
      float h = height * c.height - curvature * (along * along + across * across);
      best = h > best ? h : best;
    }
  return best;
}

typedef struct map_job {
  np_weather_map *map;
  const np_noise_table *noise;
  uint64_t seed;
  double cell_m;
  float half_extent[2]; /* of the field, in cell spacings */
  float shore_depth;
} map_job;

/* Texels of one row, in units of the cell spacing. */
enum { BLOCK = 256 };

typedef struct map_block {
  size_t count;
  float x[BLOCK], y[BLOCK];
} map_block;

static void fill_noise(const map_job *job, np_cloud_stream stream, float size, const map_block *block, float *out) {
  const np_noise_lattice lattice = {np_noise_derive_seed(job->seed, stream),
                                    {NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX}};
  const np_noise_octaves octaves = {.count = 2, .gain = 0.5f};
  float x[BLOCK], y[BLOCK], z[BLOCK];
  for (size_t i = 0; i < block->count; i++) {
    x[i] = block->x[i] / size;
    y[i] = block->y[i] / size;
    z[i] = 0.37f; /* any plane between lattice points, where gradient noise would vanish */
  }
  const np_noise_points points = {block->count, x, y, z};
  job->noise->perlin_fbm(&lattice, &octaves, &points, out);
}

/* The landscape sinks towards the border, so that clouds end there of themselves; less the more of it is covered, since
 * a closed deck has no choice but to end. */
static float find_shore(const map_job *job, float x, float y) {
  float dx = job->half_extent[0] - fabsf(x), dy = job->half_extent[1] - fabsf(y);
  float inside = (dx < dy ? dx : dy) / shore_width, s = inside < 0.0f ? 1.0f : inside > 1.0f ? 0.0f : 1.0f - inside;
  return job->shore_depth * s * s;
}

static void fill_block(const map_job *job, const map_block *block, float *out) {
  float warp_x[BLOCK], warp_y[BLOCK], group[BLOCK];
  fill_noise(job, NP_CLOUD_STREAM_WARP_X, warp_size, block, warp_x);
  fill_noise(job, NP_CLOUD_STREAM_WARP_Y, warp_size, block, warp_y);
  fill_noise(job, NP_CLOUD_STREAM_GROUPS, group_size, block, group);
  const uint64_t cells = np_random_absorb(job->seed, NP_CLOUD_STREAM_CELLS);
  const uint64_t small = np_random_absorb(job->seed, NP_CLOUD_STREAM_SMALL_CELLS);
  const float curvature = 1.0f / (cell_radius * cell_radius),
              small_curvature = curvature * small_spacing * small_spacing;
  for (size_t i = 0; i < block->count; i++) {
    float x = block->x[i] + warp_reach * warp_x[i], y = block->y[i] + warp_reach * warp_y[i];
    float large = find_highest(cells, x, y, 1.0f, curvature);
    float between = find_highest(small, x / small_spacing, y / small_spacing, small_height, small_curvature);
    out[i] = (large > between ? large : between) + group_height * group[i] - find_shore(job, block->x[i], block->y[i]);
  }
}

static void fill_row(const map_job *job, int32_t row) {
  np_weather_map *map = job->map;
  const float per_cell = (float)(1.0 / job->cell_m);
  float *out = map->values + (size_t)row * (size_t)map->size[0];
  map_block block;
  for (int32_t begin = 0; begin < map->size[0]; begin += BLOCK) {
    int32_t rest = map->size[0] - begin;
    block.count = (size_t)(rest < BLOCK ? rest : BLOCK);
    for (size_t i = 0; i < block.count; i++) {
      block.x[i] = (map->origin_m[0] + (float)(begin + (int32_t)i) * map->step_m) * per_cell;
      block.y[i] = (map->origin_m[1] + (float)row * map->step_m) * per_cell;
    }
    fill_block(job, &block, out + begin);
  }
}

static neph_result fill_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t row = begin; row < end; row++) fill_row(user, (int32_t)row);
  return NEPH_OK;
}

static void find_range(np_weather_map *map) {
  map->lowest = INFINITY;
  map->highest = -INFINITY;
  for (size_t i = 0; i < (size_t)map->size[0] * (size_t)map->size[1]; i++) {
    map->lowest = fminf(map->lowest, map->values[i]);
    map->highest = fmaxf(map->highest, map->values[i]);
  }
}

neph_result np_weather_map_build(neph_context *context, const neph_cloud_desc *desc, np_monitor *monitor,
                                 np_weather_map *out_map) {
  np_weather_map map = {.context = context,
                        .step_m = (float)(desc->cell_m / TEXELS_PER_CELL),
                        .radius_m = (float)(desc->cell_m * (double)cell_radius)};
  for (int i = 0; i < 2; i++) {
    double count = ceil(desc->extent_m[i] / (double)map.step_m) + 2;
    if (count > TEXELS_MAX)
      return np_fail(context, NEPH_ERROR_LIMIT,
                     "cloud: extent_m[%d] is %g, must be at most %g times cell_m, which is %g: enlarge cell_m", i,
                     desc->extent_m[i], (double)(TEXELS_MAX - 2) / TEXELS_PER_CELL, desc->cell_m);
    map.size[i] = (int32_t)count;
    map.origin_m[i] = -0.5f * (float)(map.size[i] - 1) * map.step_m;
  }
  map.values = np_alloc(context, (size_t)map.size[0] * (size_t)map.size[1], sizeof *map.values);
  if (!map.values) return NEPH_ERROR_OUT_OF_MEMORY;
  map_job job = {
      .map = &map,
      .noise = np_noise_get_table(context->isa),
      .seed = desc->seed,
      .cell_m = desc->cell_m,
      .half_extent = {(float)(0.5 * desc->extent_m[0] / desc->cell_m), (float)(0.5 * desc->extent_m[1] / desc->cell_m)},
      .shore_depth = shore_depth * (float)(1.0 - desc->coverage)};
  neph_result result = np_parallel_for(context, monitor, (size_t)map.size[1], 4, fill_rows, &job);
  if (result) {
    np_weather_map_clear(&map);
    return result;
  }
  find_range(&map);
  *out_map = map;
  return NEPH_OK;
}

void np_weather_map_clear(np_weather_map *map) {
  if (map->context) np_alloc_free(map->context, map->values);
  *map = (np_weather_map){0};
}

/* Texel coordinate held inside the map. */
static float find_texel(const np_weather_map *map, int axis, float position_m) {
  float t = (position_m - map->origin_m[axis]) / map->step_m, last = (float)(map->size[axis] - 1);
  return t < 0.0f ? 0.0f : t > last ? last : t;
}

float np_weather_map_sample(const np_weather_map *map, float x_m, float y_m) {
  float x = find_texel(map, 0, x_m), y = find_texel(map, 1, y_m);
  int32_t i = (int32_t)x, j = (int32_t)y;
  int32_t right = i + 1 < map->size[0] ? 1 : 0, up = j + 1 < map->size[1] ? map->size[0] : 0;
  const float *texel = map->values + (size_t)j * (size_t)map->size[0] + (size_t)i;
  float u = x - (float)i, v = y - (float)j;
  float low = texel[0] + u * (texel[right] - texel[0]), high = texel[up] + u * (texel[up + right] - texel[up]);
  return low + v * (high - low);
}

float np_weather_map_get_max(const np_weather_map *map, const float min_m[2], const float max_m[2]) {
  int32_t begin[2], end[2];
  for (int a = 0; a < 2; a++) {
    begin[a] = (int32_t)find_texel(map, a, min_m[a]);
    end[a] = (int32_t)find_texel(map, a, max_m[a]) + 1;
    if (end[a] > map->size[a] - 1) end[a] = map->size[a] - 1;
  }
  float highest = -INFINITY;
  for (int32_t j = begin[1]; j <= end[1]; j++)
    for (int32_t i = begin[0]; i <= end[0]; i++)
      highest = fmaxf(highest, map->values[(size_t)j * (size_t)map->size[0] + (size_t)i]);
  return highest;
}

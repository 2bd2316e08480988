/* SPDX-License-Identifier: Apache-2.0 */
/* The weather map: where cumulus cells stand, and how large each is.
 *
 * A jittered grid of paraboloids a − r²/R², of one curvature and random height a, and a finer one of small cells
 * between them; the landscape is the highest of all. Cut by a waterline t it shows rounded islands of radius R·√(a −
 * t), as varied as the heights: many small, few large. Low-frequency Perlin noise raises groups of cells and leaves
 * clearings; a domain warp makes outlines irregular. A slab's landscape is Perlin noise alone, longer along the wind.
 * Cells drift with the wind, grow and decay.
 */
#include <math.h>

#include "cloud/cloud_private.h"
#include "core/alloc.h"
#include "core/random.h"

enum { TEXELS_PER_CELL = 48, TEXELS_MAX = 1 << 14 /* along a side */ };

/* In units of the cell spacing. */
static const float cell_radius = 0.52f, warp_size = 0.9f, warp_reach = 0.6f, group_size = 4.3f;
static const float group_height = 0.7f; /* times Perlin noise of standard deviation 0.17 */
static const float small_spacing = 0.43f, small_height = 0.40f;
static const float shore_width = 0.35f, shore_depth = 1.2f; /* where the landscape sinks towards the field's border */

/* Anvils: of cells at least this high, of this radius more than the cell's at anvil 1. */
static const float anvil_from = 0.55f, anvil_spread = 2.0f;
static const float sheet_height = 2.2f; /* of a slab's noise, to make its range about 1 */

typedef struct cell {
  float x, y, height;            /* centre, relative to the cell's corner */
  float axis_x, axis_y, stretch; /* the outline is an ellipse, longer along the axis by stretch² */
} cell;

static float take_16_bits(uint64_t bits, int field) { return (float)(bits >> (16 * field) & 0xffffu) * 0x1p-16f; }

/* A zigzag between 0 and 1, which is as evenly spread at any time as `start` is; at its own pace in each cell. */
static float age(float start, float pace, double lives) {
  double phase = 0.5 * (double)start + (0.35 + 0.3 * (double)pace) * lives, turn = 2.0 * (phase - floor(phase));
  return (float)(turn > 1.0 ? 2.0 - turn : turn);
}

static cell draw_cell(uint64_t seed, int32_t i, int32_t j, double lives) {
  uint64_t bits = np_random_absorb(seed, (uint64_t)(uint32_t)i << 32 | (uint32_t)j), more = np_random_mix(bits);
  float u = age(take_16_bits(bits, 2), take_16_bits(more, 1), lives), turn = 2.0f * take_16_bits(bits, 3) - 1.0f,
        norm = 1.0f / (1.0f + turn * turn);
  return (cell){.x = take_16_bits(bits, 0),
                .y = take_16_bits(bits, 1),
                .height = 0.08f + 0.92f * u * u,
                .axis_x = (1.0f - turn * turn) * norm,
                .axis_y = 2.0f * turn * norm,
                .stretch = 1.0f + 0.35f * take_16_bits(more, 0)};
}

typedef struct map_job {
  np_weather_map *map;
  const np_noise_table *noise;
  uint64_t seed;
  double cell_m, lives;
  double drift[2];      /* of the air, in cell spacings */
  float half_extent[2]; /* of the field, likewise */
  float shore_depth, heading[2], sheet_shrink, anvil;
  bool is_slab;
} map_job;

typedef struct landscape {
  uint64_t seed;
  float height, curvature; /* curvature is 1/R² */
  float lowest_cell;       /* cells below it are left out */
} landscape;

/* Highest paraboloid at (x, y), in units of this grid's spacing. */
static float find_highest(const map_job *job, const landscape *l, double x, double y) {
  int32_t i0 = (int32_t)floor(x), j0 = (int32_t)floor(y);
  float best = -8.0f; /* lower than anything is asked about */
  for (int32_t j = j0 - 2; j <= j0 + 2; j++)
    for (int32_t i = i0 - 2; i <= i0 + 2; i++) {
      cell c = draw_cell(l->seed, i, j, job->lives);
      if (c.height < l->lowest_cell) continue;
      float dx = (float)(x - i) - c.x, dy = (float)(y - j) - c.y;
      float along = (dx * c.axis_x + dy * c.axis_y) / c.stretch, across = (dy * c.axis_x - dx * c.axis_y) * c.stretch;
      float h = l->height * c.height - l->curvature * (along * along + across * across);
      best = h > best ? h : best;
    }
  return best;
}

/* Texels of one row, in units of the cell spacing. */
enum { BLOCK = 256 };

typedef struct map_block {
  size_t count;
  float x[BLOCK], y[BLOCK];          /* in the field */
  double air_x[BLOCK], air_y[BLOCK]; /* in the air, which drifts */
} map_block;

static void fill_noise(const map_job *job, np_cloud_stream stream, float size, unsigned octave_count,
                       const map_block *block, float *out) {
  const np_noise_lattice lattice = {np_noise_derive_seed(job->seed, stream),
                                    {NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX}};
  const np_noise_octaves octaves = {.count = octave_count, .gain = 0.5f};
  float x[BLOCK], y[BLOCK], z[BLOCK];
  for (size_t i = 0; i < block->count; i++) {
    x[i] = (float)(block->air_x[i] / (double)size);
    y[i] = (float)(block->air_y[i] / (double)size);
    z[i] = 0.37f + 0.15f * (float)job->lives; /* between lattice points, where gradient noise would vanish */
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

static void fill_cells(const map_job *job, const map_block *block, float *out, float *out_anvils) {
  float warp_x[BLOCK], warp_y[BLOCK], group[BLOCK];
  fill_noise(job, NP_CLOUD_STREAM_WARP_X, warp_size, 2, block, warp_x);
  fill_noise(job, NP_CLOUD_STREAM_WARP_Y, warp_size, 2, block, warp_y);
  fill_noise(job, NP_CLOUD_STREAM_GROUPS, group_size, 2, block, group);
  const float curvature = 1.0f / (cell_radius * cell_radius), wide = 1.0f / (1.0f + anvil_spread * job->anvil);
  const landscape cells = {np_random_absorb(job->seed, NP_CLOUD_STREAM_CELLS), 1.0f, curvature, 0.0f};
  const landscape small = {np_random_absorb(job->seed, NP_CLOUD_STREAM_SMALL_CELLS), small_height,
                           curvature * small_spacing * small_spacing, 0.0f};
  const landscape anvils = {cells.seed, 1.0f, curvature * wide * wide, anvil_from};
  for (size_t i = 0; i < block->count; i++) {
    double x = block->air_x[i] + (double)(warp_reach * warp_x[i]),
           y = block->air_y[i] + (double)(warp_reach * warp_y[i]);
    float large = find_highest(job, &cells, x, y);
    float between = find_highest(job, &small, x / (double)small_spacing, y / (double)small_spacing);
    float raised = group_height * group[i] - find_shore(job, block->x[i], block->y[i]);
    out[i] = (large > between ? large : between) + raised;
    if (out_anvils) out_anvils[i] = find_highest(job, &anvils, x, y) + raised;
  }
}

/* Warped by noise of a larger scale, and longer along the heading. */
static void fill_sheet(const map_job *job, const map_block *block, float *out) {
  float warp_x[BLOCK], warp_y[BLOCK];
  map_block turned = *block;
  fill_noise(job, NP_CLOUD_STREAM_WARP_X, 2.0f * warp_size, 2, block, warp_x);
  fill_noise(job, NP_CLOUD_STREAM_WARP_Y, 2.0f * warp_size, 2, block, warp_y);
  for (size_t i = 0; i < block->count; i++) {
    double x = block->air_x[i] + (double)(warp_reach * warp_x[i]),
           y = block->air_y[i] + (double)(warp_reach * warp_y[i]);
    turned.air_x[i] = (x * (double)job->heading[0] + y * (double)job->heading[1]) * (double)job->sheet_shrink;
    turned.air_y[i] = y * (double)job->heading[0] - x * (double)job->heading[1];
  }
  fill_noise(job, NP_CLOUD_STREAM_GROUPS, 1.0f, 4, &turned, out);
  for (size_t i = 0; i < block->count; i++) out[i] = sheet_height * out[i] - find_shore(job, block->x[i], block->y[i]);
}

static void fill_row(const map_job *job, int32_t row) {
  np_weather_map *map = job->map;
  const float per_cell = (float)(1.0 / job->cell_m);
  const size_t first = (size_t)row * (size_t)map->size[0];
  map_block block;
  for (int32_t begin = 0; begin < map->size[0]; begin += BLOCK) {
    int32_t rest = map->size[0] - begin;
    block.count = (size_t)(rest < BLOCK ? rest : BLOCK);
    for (size_t i = 0; i < block.count; i++) {
      block.x[i] = (map->origin_m[0] + (float)(begin + (int32_t)i) * map->step_m) * per_cell;
      block.y[i] = (map->origin_m[1] + (float)row * map->step_m) * per_cell;
      block.air_x[i] = (double)block.x[i] - job->drift[0];
      block.air_y[i] = (double)block.y[i] - job->drift[1];
    }
    float *out = map->values + first + (size_t)begin;
    if (job->is_slab)
      fill_sheet(job, &block, out);
    else
      fill_cells(job, &block, out, map->anvils ? map->anvils + first + (size_t)begin : NULL);
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

void np_cloud_desc_find_heading(const neph_cloud_desc *desc, float out_heading[2]) {
  const double x = desc->wind_m_s[0], y = desc->wind_m_s[1], speed = sqrt(x * x + y * y);
  out_heading[0] = speed > 0 ? (float)(x / speed) : 1.0f;
  out_heading[1] = speed > 0 ? (float)(y / speed) : 0.0f;
}

static map_job make_job(np_weather_map *map, const neph_cloud_desc *desc) {
  map_job job = {.map = map,
                 .noise = np_noise_get_table(map->context->isa),
                 .seed = desc->seed,
                 .cell_m = desc->cell_m,
                 .lives = desc->time_s / desc->lifetime_s,
                 .shore_depth = shore_depth * (float)(1.0 - desc->coverage),
                 .sheet_shrink = (float)(1.0 / sqrt(desc->stretch)),
                 .anvil = (float)desc->anvil,
                 .is_slab = desc->model == NEPH_CLOUD_MODEL_SLAB};
  np_cloud_desc_find_heading(desc, job.heading);
  for (int i = 0; i < 2; i++) {
    job.drift[i] = desc->wind_m_s[i] * desc->time_s / desc->cell_m;
    job.half_extent[i] = (float)(0.5 * desc->extent_m[i] / desc->cell_m);
  }
  return job;
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
  const size_t texel_count = (size_t)map.size[0] * (size_t)map.size[1];
  const bool has_anvils = desc->anvil > 0 && desc->model == NEPH_CLOUD_MODEL_CELLS;
  map.values = np_alloc(context, texel_count, sizeof *map.values);
  if (has_anvils) map.anvils = np_alloc(context, texel_count, sizeof *map.anvils);
  neph_result result = map.values && (map.anvils || !has_anvils) ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  map_job job = make_job(&map, desc);
  if (!result) result = np_parallel_for(context, monitor, (size_t)map.size[1], 4, fill_rows, &job);
  if (result) {
    np_weather_map_clear(&map);
    return result;
  }
  find_range(&map);
  *out_map = map;
  return NEPH_OK;
}

void np_weather_map_clear(np_weather_map *map) {
  if (map->context) {
    np_alloc_free(map->context, map->anvils);
    np_alloc_free(map->context, map->values);
  }
  *map = (np_weather_map){0};
}

/* Texel coordinate held inside the map. */
static float find_texel(const np_weather_map *map, int axis, float position_m) {
  float t = (position_m - map->origin_m[axis]) / map->step_m, last = (float)(map->size[axis] - 1);
  return t < 0.0f ? 0.0f : t > last ? last : t;
}

float np_weather_map_sample(const np_weather_map *map, const float *values, float x_m, float y_m) {
  float x = find_texel(map, 0, x_m), y = find_texel(map, 1, y_m);
  int32_t i = (int32_t)x, j = (int32_t)y;
  int32_t right = i + 1 < map->size[0] ? 1 : 0, up = j + 1 < map->size[1] ? map->size[0] : 0;
  const float *texel = values + (size_t)j * (size_t)map->size[0] + (size_t)i;
  float u = x - (float)i, v = y - (float)j;
  float low = texel[0] + u * (texel[right] - texel[0]), high = texel[up] + u * (texel[up + right] - texel[up]);
  return low + v * (high - low);
}

float np_weather_map_get_max(const np_weather_map *map, const float *values, const float min_m[2],
                             const float max_m[2]) {
  int32_t begin[2], end[2];
  for (int a = 0; a < 2; a++) {
    begin[a] = (int32_t)find_texel(map, a, min_m[a]);
    end[a] = (int32_t)find_texel(map, a, max_m[a]) + 1;
    if (end[a] > map->size[a] - 1) end[a] = map->size[a] - 1;
  }
  float highest = -INFINITY;
  for (int32_t j = begin[1]; j <= end[1]; j++)
    for (int32_t i = begin[0]; i <= end[0]; i++)
      highest = fmaxf(highest, values[(size_t)j * (size_t)map->size[0] + (size_t)i]);
  return highest;
}

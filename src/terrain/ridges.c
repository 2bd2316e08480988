/* SPDX-License-Identifier: Apache-2.0 */
/* Ridged mountains from noise.
 *
 * Ridged multifractal (Musgrave 1994, in "Texturing and Modeling", chapter on procedural fractal terrains): octaves of
 * 1 − |n|, each weighted by the sum so far, so that crests are rough and valley floors smooth. Every octave is looked
 * up at a position moved along the slopes of those before it ("Swiss turbulence", de Carpentier 2011, "Scape: 2.
 * Procedural extensions"), which draws spurs out of the crests and narrows the gullies between them as running water
 * does.
 *
 * Each octave turns the plane by the angle of the triangle 3-4-5, so that no two lattices line up. Only + − × ÷ √ are
 * used: the same bits at every instruction-set level.
 */
#include <math.h>

#include "core/alloc.h"
#include "noise/noise.h"
#include "terrain/heightfield.h"

enum { BLOCK = 256, OCTAVES_MAX = 11 };

static const float lacunarity = 1.97f;
static const float octave_gain = 0.6f;
static const float noise_scale = 2.0f;      /* Perlin noise rarely leaves ±0.5 */
static const float slope_warp = 0.035f;     /* cells of the first octave, per unit of slope gathered */
static const float crest_width = 0.05f;     /* of |n|: rounds crests, which would be creases */
static const float difference_step = 0.02f; /* cells, for slopes */
static const float plain_warp = 0.45f;      /* cells by which the first octave's crests wander */
static const double fade_share = 0.25;      /* of the width: mountains sink into the plain towards the rim */

/* Seeds' streams. */
enum { STREAM_WARP = 0, STREAM_RANGE = 2, STREAM_OCTAVES = 3 };

typedef struct ridge_maker {
  np_heightfield *field;
  const np_noise_table *noise;
  uint64_t seed;
  double spacing_cells; /* between samples, in cells of the first octave */
  unsigned octave_count;
} ridge_maker;

/* A run of samples along a row. */
typedef struct ridge_block {
  size_t count;
  float x[BLOCK], y[BLOCK], z[BLOCK]; /* in cells of the octave at work */
  float slope_x[BLOCK], slope_y[BLOCK];
  float sum[BLOCK], amplitude[BLOCK];
} ridge_block;

static np_noise_lattice make_lattice(const ridge_maker *maker, unsigned stream) {
  return (np_noise_lattice){np_noise_derive_seed(maker->seed, stream),
                            {NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX}};
}

/* Perlin noise of the block, moved by (dx, dy). */
static void evaluate(const ridge_maker *maker, unsigned stream, const ridge_block *block, float dx, float dy,
                     float *out) {
  float x[BLOCK], y[BLOCK];
  for (size_t i = 0; i < block->count; i++) {
    x[i] = block->x[i] + dx;
    y[i] = block->y[i] + dy;
  }
  const np_noise_lattice lattice = make_lattice(maker, stream);
  maker->noise->perlin(&lattice, &(np_noise_points){block->count, x, y, block->z}, out);
}

/* Bends the plane, so that crests wander. */
static void warp(const ridge_maker *maker, ridge_block *block) {
  const np_noise_octaves octaves = {3, 0.5f};
  float dx[BLOCK], dy[BLOCK];
  const np_noise_points points = {block->count, block->x, block->y, block->z};
  const np_noise_lattice lattice_x = make_lattice(maker, STREAM_WARP), lattice_y = make_lattice(maker, STREAM_WARP + 1);
  maker->noise->perlin_fbm(&lattice_x, &octaves, &points, dx);
  maker->noise->perlin_fbm(&lattice_y, &octaves, &points, dy);
  for (size_t i = 0; i < block->count; i++) {
    block->x[i] += 2.0f * plain_warp * dx[i];
    block->y[i] += 2.0f * plain_warp * dy[i];
  }
}

/* How high the range stands here: broad massifs and the low ground between them. */
static void begin_with_range(const ridge_maker *maker, ridge_block *block) {
  float range[BLOCK], x[BLOCK], y[BLOCK];
  for (size_t i = 0; i < block->count; i++) {
    x[i] = 0.37f * block->x[i] + 0.21f * block->y[i];
    y[i] = 0.37f * block->y[i] - 0.21f * block->x[i];
  }
  const np_noise_lattice lattice = make_lattice(maker, STREAM_RANGE);
  maker->noise->perlin_fbm(&lattice, &(np_noise_octaves){2, 0.4f}, &(np_noise_points){block->count, x, y, block->z},
                           range);
  for (size_t i = 0; i < block->count; i++) {
    block->sum[i] = 0;
    block->slope_x[i] = block->slope_y[i] = 0;
    block->amplitude[i] = 0.5f + 0.5f * np_smoothstepf(0.5f + 1.1f * range[i]);
  }
}

/* Takes positions and gathered slopes to the next octave's turned, finer cells. */
static void turn(ridge_block *block) {
  const float c = 0.8f * lacunarity, s = 0.6f * lacunarity;
  for (size_t i = 0; i < block->count; i++) {
    const float x = block->x[i], y = block->y[i], u = block->slope_x[i], v = block->slope_y[i];
    block->x[i] = c * x - s * y;
    block->y[i] = s * x + c * y;
    block->slope_x[i] = c * u - s * v;
    block->slope_y[i] = s * u + c * v;
  }
}

static void add_octave(const ridge_maker *maker, unsigned octave, ridge_block *block) {
  float n[BLOCK], east[BLOCK], north[BLOCK];
  ridge_block moved = *block;
  for (size_t i = 0; i < block->count; i++) {
    moved.x[i] += slope_warp * block->slope_x[i];
    moved.y[i] += slope_warp * block->slope_y[i];
  }
  evaluate(maker, STREAM_OCTAVES + octave, &moved, 0, 0, n);
  evaluate(maker, STREAM_OCTAVES + octave, &moved, difference_step, 0, east);
  evaluate(maker, STREAM_OCTAVES + octave, &moved, 0, difference_step, north);
  for (size_t i = 0; i < block->count; i++) {
    const float signal = noise_scale * n[i], distance = sqrtf(signal * signal + crest_width * crest_width);
    const float fall = -block->amplitude[i] * signal * noise_scale / difference_step;
    block->sum[i] += block->amplitude[i] * (1.0f + crest_width - distance);
    block->slope_x[i] += fall * (east[i] - n[i]);
    block->slope_y[i] += fall * (north[i] - n[i]);
    block->amplitude[i] *= octave_gain * np_clampf(0.25f + block->sum[i], 0, 1);
  }
}

static void make_block(const ridge_maker *maker, unsigned row, unsigned column, ridge_block *block) {
  const np_heightfield *field = maker->field;
  for (size_t i = 0; i < block->count; i++) {
    block->x[i] = (float)(((double)(column + i) - 0.5 * (field->width - 1)) * maker->spacing_cells);
    block->y[i] = (float)((row - 0.5 * (field->height - 1)) * maker->spacing_cells);
    block->z[i] = 0.5f; /* half-way between lattice planes, on which Perlin noise has a zero at each lattice point */
  }
  warp(maker, block);
  begin_with_range(maker, block);
  for (unsigned octave = 0; octave < maker->octave_count; octave++) {
    add_octave(maker, octave, block);
    turn(block);
  }
}

static neph_result make_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const ridge_maker *maker = user;
  const unsigned width = maker->field->width;
  ridge_block block;
  for (size_t row = begin; row < end; row++)
    for (unsigned column = 0; column < width; column += BLOCK) {
      block.count = width - column < BLOCK ? width - column : BLOCK;
      make_block(maker, (unsigned)row, column, &block);
      for (size_t i = 0; i < block.count; i++) maker->field->elevation_m[row * width + column + i] = block.sum[i];
    }
  return NEPH_OK;
}

/* Octaves down to cells of two samples: finer ones would alias. */
static unsigned count_octaves(double spacing_cells) {
  unsigned count = 1;
  for (double cell = 1.0 / (double)lacunarity; cell >= 2.0 * spacing_cells && count < OCTAVES_MAX; count++)
    cell /= (double)lacunarity;
  return count;
}

/* 1 in the middle, 0 at the rim. */
static float compute_fade(unsigned index, unsigned count) {
  const unsigned from_edge = index < count - 1 - index ? index : count - 1 - index;
  return np_smoothstepf((float)(from_edge / (fade_share * (count - 1))));
}

/* Lowest ground 0, sinking to it towards the rim; highest the relief. */
static void scale_to_relief(np_heightfield *field, float relief_m) {
  const size_t count = (size_t)field->width * field->height;
  float low = INFINITY, high = 0;
  for (size_t i = 0; i < count; i++) low = fminf(low, field->elevation_m[i]);
  for (size_t i = 0; i < count; i++) {
    const float fade = compute_fade((unsigned)(i % field->width), field->width) *
                       compute_fade((unsigned)(i / field->width), field->height);
    field->elevation_m[i] = fade * (field->elevation_m[i] - low);
    high = fmaxf(high, field->elevation_m[i]);
  }
  const float scale = high > 0 ? relief_m / high : 0;
  for (size_t i = 0; i < count; i++) field->elevation_m[i] *= scale;
  field->elevation_max_m = high * scale;
}

static neph_result check_ridges(neph_context *context, const neph_ridges_desc *ridges, const neph_terrain_desc *desc) {
  if (ridges->sample_count < 2 || ridges->sample_count > NP_HEIGHTFIELD_SAMPLES_MAX)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "ridges sample_count is %u, must be in [2, %d]",
                   ridges->sample_count, NP_HEIGHTFIELD_SAMPLES_MAX);
  if (!(ridges->relief_m >= 0 && ridges->relief_m <= 1e5))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "ridges relief_m is %g, must be in [0, 1e5]",
                   ridges->relief_m);
  const double finest_m = 2.0 * desc->width_m / (ridges->sample_count - 1);
  if (!(ridges->ridge_m >= finest_m) || isinf(ridges->ridge_m))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "ridges ridge_m is %g, must be at least two samples (%g m)",
                   ridges->ridge_m, finest_m);
  return NEPH_OK;
}

neph_result np_heightfield_make_ridges(neph_context *context, np_monitor *monitor, const neph_ridges_desc *ridges,
                                       const neph_terrain_desc *desc, np_heightfield *out_field) {
  const neph_ridges_desc defaults = NEPH_RIDGES_DESC_DEFAULT;
  neph_ridges_desc read;
  neph_result result = np_desc_read(context, "neph_ridges_desc", &defaults, sizeof defaults, ridges, &read);
  if (!result) result = check_ridges(context, &read, desc);
  if (!result) result = np_heightfield_create_flat(context, read.sample_count, read.sample_count, desc, out_field);
  if (result) return result;
  const double spacing_cells = desc->width_m / (read.sample_count - 1) / read.ridge_m;
  ridge_maker maker = {out_field, np_noise_get_table(context->isa), read.seed, spacing_cells,
                       count_octaves(spacing_cells)};
  np_monitor_set_stage(monitor, "raising ridges");
  result = np_parallel_for(context, monitor, out_field->height, 8, make_rows, &maker);
  if (result)
    np_heightfield_destroy(context, out_field);
  else
    scale_to_relief(out_field, (float)read.relief_m);
  return result;
}

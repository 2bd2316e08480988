/* SPDX-License-Identifier: Apache-2.0 */
/* Mountains that need no file: noise says where the ground rises, rivers cut it into ridges.
 *
 * Massifs rise where octaves of Perlin noise, of cells as wide as the wanted spacing, exceed their mean; the finer
 * octaves bend the rivers, which would otherwise run along the grid. Erosion begins on a coarse grid, where valleys
 * find their way across the field in a few steps, and goes on at doubled resolutions to the field's own.
 *
 * Only + − × ÷ √ are used: the same bits at every instruction-set level.
 */
#include <math.h>

#include "core/random.h"
#include "noise/noise.h"
#include "terrain/erosion.h"
#include "terrain/heightfield.h"

enum { BLOCK = 256, COARSEST_SIDE = 64, LEVELS_MAX = 10 };

/* Lengths in units of the ridges' spacing, times in units of a river that drains such a square. */
static const float warp_length = 0.35f;       /* displacement of massifs */
static const float hillslope_length = 0.035f; /* root of the least catchment that feeds a river */
static const float step_time = 2.0f;          /* time step on the coarsest grid; halved with each doubling */
static const double fade_share = 0.2;         /* share of the width at the rim over which uplift fades */
static const unsigned step_counts[] = {100, 20, 12, 6, 4};

/* Streams of random seeds. */
enum { STREAM_WARP_X, STREAM_WARP_Y, STREAM_UPLIFT };

typedef struct uplift_job {
  np_erosion *erosion;
  const np_noise_table *noise;
  uint64_t seed;
} uplift_job;

/* A row of samples; z lies half-way between lattice planes, where Perlin noise has its zeros. */
typedef struct noise_block {
  size_t count;
  float x[BLOCK], y[BLOCK], z[BLOCK];
} noise_block;

static void evaluate(const uplift_job *job, unsigned stream, unsigned octave_count, const noise_block *block,
                     float *out) {
  const np_noise_lattice lattice = {np_noise_derive_seed(job->seed, stream),
                                    {NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX, NP_NOISE_PERIOD_MAX}};
  job->noise->perlin_fbm(&lattice, &(np_noise_octaves){octave_count, 0.55f},
                         &(np_noise_points){block->count, block->x, block->y, block->z}, out);
}

/* Fade of the uplift: 1 in the middle, 0 at the rim. */
static float compute_fade(unsigned index, unsigned count) {
  const unsigned from_edge = index < count - 1 - index ? index : count - 1 - index;
  return np_smoothstepf((float)(from_edge / (fade_share * (count - 1))));
}

static void raise_block(const uplift_job *job, unsigned row, unsigned column, noise_block *block) {
  const np_erosion *erosion = job->erosion;
  const float middle = 0.5f * (float)(erosion->side - 1);
  float warp_x[BLOCK], warp_y[BLOCK], uplift[BLOCK];
  for (size_t i = 0; i < block->count; i++) {
    block->x[i] = ((float)(column + i) - middle) * erosion->spacing;
    block->y[i] = ((float)row - middle) * erosion->spacing;
    block->z[i] = 0.5f;
  }
  evaluate(job, STREAM_WARP_X, 3, block, warp_x);
  evaluate(job, STREAM_WARP_Y, 3, block, warp_y);
  for (size_t i = 0; i < block->count; i++) {
    block->x[i] += warp_length * 2.0f * warp_x[i];
    block->y[i] += warp_length * 2.0f * warp_y[i];
  }
  evaluate(job, STREAM_UPLIFT, NP_NOISE_OCTAVES_MAX, block, uplift);
  float *out = erosion->uplift + (size_t)row * erosion->side + column;
  const float fade = compute_fade(row, erosion->side);
  for (size_t i = 0; i < block->count; i++)
    out[i] =
        fade * compute_fade(column + (unsigned)i, erosion->side) * (0.08f + np_smoothstepf(0.45f + 1.4f * uplift[i]));
}

static neph_result raise_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const uplift_job *job = user;
  const unsigned side = job->erosion->side;
  noise_block block;
  for (size_t row = begin; row < end; row++)
    for (unsigned column = 0; column < side; column += BLOCK) {
      block.count = side - column < BLOCK ? side - column : BLOCK;
      raise_block(job, (unsigned)row, column, &block);
    }
  return NEPH_OK;
}

/* Number of samples along the side of a level: the field's own on the last, half of the next one's before it. */
static unsigned get_level_side(const neph_ridges_desc *ridges, unsigned levels_left) {
  return ((ridges->sample_count - 1) >> levels_left) + 1;
}

static unsigned count_levels(const neph_ridges_desc *ridges) {
  unsigned count = 1;
  while (count < LEVELS_MAX && get_level_side(ridges, count) >= COARSEST_SIDE) count++;
  return count;
}

static unsigned count_steps(unsigned level) {
  const unsigned last = sizeof step_counts / sizeof *step_counts - 1;
  return step_counts[level < last ? level : last];
}

/* Work before a step of a level, in steps of the coarsest grid; each level has four times the samples. */
static double measure_work(unsigned level, unsigned step) {
  double work = 0;
  for (unsigned i = 0; i < level; i++) work += ldexp(count_steps(i), 2 * (int)i);
  return work + ldexp(step, 2 * (int)level);
}

typedef struct ridge_maker {
  neph_context *context;
  np_monitor *monitor;
  neph_ridges_desc ridges;
  double width_m;
  unsigned level_count;
  np_erosion erosion; /* erosion of the current level */
} ridge_maker;

/* Starts a level: the resampled ground of the last one, with filled basins, and its uplift. */
static neph_result prepare_level(ridge_maker *maker, const np_erosion *coarser, np_erosion *level) {
  uplift_job job = {level, np_noise_get_table(maker->context->isa), maker->ridges.seed};
  neph_result result = np_parallel_for(maker->context, maker->monitor, level->side, 8, raise_rows, &job);
  if (!result && coarser->side > 0)
    result = np_erosion_resample(maker->context, maker->monitor, coarser, level->side, level->height);
  return result ? result : np_erosion_fill_basins(maker->context, maker->monitor, level);
}

static neph_result start_level(ridge_maker *maker, unsigned level) {
  const unsigned side = get_level_side(&maker->ridges, maker->level_count - 1 - level);
  const double spacing = maker->width_m / maker->ridges.ridge_m / (side - 1);
  np_erosion coarser = maker->erosion;
  neph_result result =
      np_erosion_create(maker->context, side, (float)spacing, hillslope_length * hillslope_length, &maker->erosion);
  /* Samples are not scattered on the last level, where that would show as roughness, and valleys exist already. */
  if (!result && level + 1 < maker->level_count)
    np_erosion_scatter(&maker->erosion, np_random_absorb(maker->ridges.seed, level));
  if (!result) result = prepare_level(maker, &coarser, &maker->erosion);
  np_erosion_destroy(maker->context, &coarser);
  return result;
}

static neph_result erode_level(ridge_maker *maker, unsigned level) {
  const double begun = measure_work(level, 0) / measure_work(maker->level_count, 0);
  np_monitor_set_range(maker->monitor, begun, begun);
  neph_result result = start_level(maker, level);
  for (unsigned step = 0; !result && step < count_steps(level); step++) {
    const double done = measure_work(level, step) / measure_work(maker->level_count, 0);
    np_monitor_set_range(maker->monitor, done, done);
    result = np_erosion_step(maker->context, maker->monitor, &maker->erosion, ldexpf(step_time, -(int)level));
  }
  return result;
}

/* Scales the last level to the field: lowest ground, at the rim, 0; highest the relief. */
static void scale_to_relief(const np_erosion *erosion, float relief_m, np_heightfield *field) {
  const size_t count = (size_t)field->width * field->height;
  float high = 0;
  for (size_t i = 0; i < count; i++) high = fmaxf(high, erosion->height[i]);
  const float scale = high > 0 ? relief_m / high : 0;
  for (size_t i = 0; i < count; i++) field->elevation_m[i] = erosion->height[i] * scale;
  field->elevation_max_m = high * scale;
}

static neph_result check_ridges(neph_context *context, const neph_ridges_desc *ridges, const neph_terrain_desc *desc) {
  if (ridges->sample_count < 2 || ridges->sample_count > NP_HEIGHTFIELD_SAMPLES_MAX)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "ridges sample_count is %u, must be in [2, %d]",
                   ridges->sample_count, NP_HEIGHTFIELD_SAMPLES_MAX);
  if (!(ridges->relief_m >= 0 && ridges->relief_m <= 1e5))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "ridges: relief is %g m, must be in [0, 1e5] m",
                   ridges->relief_m);
  const double finest_m = 2.0 * desc->width_m / (ridges->sample_count - 1);
  if (!(ridges->ridge_m >= finest_m) || isinf(ridges->ridge_m))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "ridges: ridge is %g m, must be at least two samples (%g m)",
                   ridges->ridge_m, finest_m);
  return NEPH_OK;
}

neph_result np_heightfield_make_ridges(neph_context *context, np_monitor *monitor, const neph_ridges_desc *ridges,
                                       const neph_terrain_desc *desc, np_heightfield *out_field) {
  const neph_ridges_desc defaults = NEPH_RIDGES_DESC_DEFAULT;
  neph_ridges_desc read;
  neph_result result = np_desc_read(context, "neph_ridges_desc", &defaults, sizeof defaults, ridges, &read);
  if (!result) result = check_ridges(context, &read, desc);
  if (result) return result;
  ridge_maker maker = {context, monitor, read, desc->width_m, count_levels(&read), {0}};
  np_monitor_set_stage(monitor, "raising ridges");
  for (unsigned level = 0; !result && level < maker.level_count; level++) result = erode_level(&maker, level);
  if (!result) result = np_heightfield_create_flat(context, read.sample_count, read.sample_count, desc, out_field);
  if (!result) scale_to_relief(&maker.erosion, (float)read.relief_m, out_field);
  np_erosion_destroy(context, &maker.erosion);
  return result;
}

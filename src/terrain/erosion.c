/* SPDX-License-Identifier: Apache-2.0 */
/* Stream power erosion: ∂h/∂t = U − K·√A·S, with the uplift U, the catchment A upstream of a point, the slope S along
 * the water's way and the erodibility K, here 1.
 *
 * Solved implicitly from the outlets upwards, in one pass over the samples and stable for any time step (Braun and
 * Willett 2013, "A very efficient O(n), implicit and parallel method to solve the stream power equation", eqs. 16 to
 * 22, m = ½, n = 1). As a way to make mountains: Cordonnier et al. 2016, "Large Scale Terrain Generation from Tectonic
 * Uplift and Fluvial Erosion".
 *
 * Basins that a refinement leaves are filled once (Barnes et al. 2014, "Priority-flood: An optimal depression-filling
 * and watershed-labeling algorithm", algorithm 3); a pit that opens later drains nowhere and rises until it spills.
 * Hillslopes that carry no river would grow steeper the finer the grid; an area added to every catchment represents the
 * soil that creeps down them and bounds their slope.
 */
#include "terrain/erosion.h"

#include <math.h>

#include "core/alloc.h"
#include "core/math.h"
#include "core/random.h"

/* Share of the difference from its four neighbours' mean that a sample loses in a step, which smooths features of a
 * single sample. */
static const float smoothing = 0.25f;

/* Slope of the water surface in a filled basin. */
static const float basin_slope = 0.01f;

/* Number of samples between two checks for cancelling. */
enum { CANCEL_STRIDE = 1 << 16, ROWS_PER_PIECE = 16 };

/* Width of the square, in 256ths of a cell, in which samples are scattered. */
enum { SCATTER = 230 };

static size_t count_samples(const np_erosion *erosion) { return (size_t)erosion->side * erosion->side; }

neph_result np_erosion_create(neph_context *context, unsigned side, float spacing, float hillslope_area,
                              np_erosion *out_erosion) {
  *out_erosion = (np_erosion){.side = side, .spacing = spacing, .hillslope_area = hillslope_area};
  const size_t count = count_samples(out_erosion);
  if ((out_erosion->height = np_alloc(context, count, sizeof *out_erosion->height)) &&
      (out_erosion->uplift = np_alloc(context, count, sizeof *out_erosion->uplift)) &&
      (out_erosion->catchment = np_alloc(context, count, sizeof *out_erosion->catchment)) &&
      (out_erosion->receiver = np_alloc(context, count, sizeof *out_erosion->receiver)) &&
      (out_erosion->order = np_alloc(context, count, sizeof *out_erosion->order)) &&
      (out_erosion->donors = np_alloc(context, count, sizeof *out_erosion->donors)) &&
      (out_erosion->place = np_alloc(context, count, sizeof *out_erosion->place)))
    return NEPH_OK;
  np_erosion_destroy(context, out_erosion);
  return NEPH_ERROR_OUT_OF_MEMORY;
}

void np_erosion_destroy(neph_context *context, np_erosion *erosion) {
  np_alloc_free(context, erosion->height);
  np_alloc_free(context, erosion->uplift);
  np_alloc_free(context, erosion->catchment);
  np_alloc_free(context, erosion->receiver);
  np_alloc_free(context, erosion->order);
  np_alloc_free(context, erosion->donors);
  np_alloc_free(context, erosion->place);
  *erosion = (np_erosion){0};
}

void np_erosion_scatter(np_erosion *erosion, uint64_t seed) {
  for (size_t i = 0; i < count_samples(erosion); i++) {
    const uint64_t bits = np_random_absorb(seed, i);
    erosion->place[i][0] = (int8_t)((int)(bits % SCATTER) - SCATTER / 2);
    erosion->place[i][1] = (int8_t)((int)((bits >> 32) % SCATTER) - SCATTER / 2);
  }
}

typedef struct bilinear {
  size_t corner[4];
  float weight[4];
} bilinear;

/* Bilinear weights at (x, y), in cells, clamped to the edge. */
static bilinear locate(const np_erosion *erosion, float x, float y) {
  const unsigned last = erosion->side - 2;
  x = np_clampf(x, 0, (float)(last + 1));
  y = np_clampf(y, 0, (float)(last + 1));
  const unsigned i = (unsigned)x < last ? (unsigned)x : last, j = (unsigned)y < last ? (unsigned)y : last;
  const float u = x - (float)i, v = y - (float)j;
  const size_t corner = (size_t)j * erosion->side + i;
  return (bilinear){{corner, corner + 1, corner + erosion->side, corner + erosion->side + 1},
                    {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v}};
}

/* Height at a place: at the lattice position whose scattered samples lie there. One fixed-point iteration suffices,
 * since the rest is an unevenness finer than the cells. */
static float sample_height(const np_erosion *erosion, float x, float y) {
  bilinear here = locate(erosion, x, y);
  float off_x = 0, off_y = 0, height = 0;
  for (int k = 0; k < 4; k++) {
    off_x += here.weight[k] * (float)erosion->place[here.corner[k]][0];
    off_y += here.weight[k] * (float)erosion->place[here.corner[k]][1];
  }
  here = locate(erosion, x - off_x * (1.0f / 256.0f), y - off_y * (1.0f / 256.0f));
  for (int k = 0; k < 4; k++) height += here.weight[k] * erosion->height[here.corner[k]];
  return height;
}

typedef struct resample_job {
  const np_erosion *erosion;
  unsigned side;
  float *heights;
} resample_job;

static neph_result resample_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const resample_job *job = user;
  const float scale = (float)(job->erosion->side - 1) / (float)(job->side - 1);
  float *height = job->heights + begin * job->side;
  for (size_t row = begin; row < end; row++)
    for (unsigned column = 0; column < job->side; column++)
      *height++ = sample_height(job->erosion, (float)column * scale, (float)row * scale);
  return NEPH_OK;
}

neph_result np_erosion_resample(neph_context *context, np_monitor *monitor, const np_erosion *erosion, unsigned side,
                                float *out_heights) {
  resample_job job = {erosion, side, out_heights};
  return np_parallel_for(context, monitor, side, ROWS_PER_PIECE, resample_rows, &job);
}

static bool is_on_rim(const np_erosion *erosion, unsigned column, unsigned row) {
  return column == 0 || row == 0 || column + 1 == erosion->side || row + 1 == erosion->side;
}

typedef struct carve_job {
  np_erosion *erosion;
  np_monitor *monitor;
  float time;
} carve_job;

static bool is_stopped(const carve_job *job, size_t i) {
  return i % CANCEL_STRIDE == 0 && np_monitor_is_cancelled(job->monitor);
}

/* A heap of samples in `order`, the lowest at its root; their heights beside them, where no catchments are yet. */

static void put_sample(np_erosion *erosion, size_t place, uint32_t sample, float height) {
  erosion->order[place] = sample;
  erosion->catchment[place] = height;
}

static void move_sample(np_erosion *erosion, size_t to, size_t from) {
  put_sample(erosion, to, erosion->order[from], erosion->catchment[from]);
}

static void push_sample(np_erosion *erosion, size_t *count, uint32_t sample) {
  const float height = erosion->height[sample];
  size_t i = (*count)++;
  for (; i > 0 && height < erosion->catchment[(i - 1) / 2]; i = (i - 1) / 2) move_sample(erosion, i, (i - 1) / 2);
  put_sample(erosion, i, sample, height);
}

static uint32_t pop_sample(np_erosion *erosion, size_t *count) {
  const uint32_t lowest = erosion->order[0], last = erosion->order[--*count];
  const float *heights = erosion->catchment, height = heights[*count];
  size_t i = 0;
  for (size_t child; (child = 2 * i + 1) < *count; i = child) {
    if (child + 1 < *count && heights[child + 1] < heights[child]) child++;
    if (!(heights[child] < height)) break;
    move_sample(erosion, i, child);
  }
  put_sample(erosion, i, last, height);
  return lowest;
}

/* Floods the neighbours of a sample that are not flooded yet: to slightly above it, where they are no higher. */
static void flood_neighbours(np_erosion *erosion, uint32_t here, size_t *count) {
  const int64_t side = erosion->side, column = here % side, row = here / side;
  const float level = erosion->height[here] + basin_slope * erosion->spacing;
  for (int64_t j = row - 1; j <= row + 1; j++)
    for (int64_t i = column - 1; i <= column + 1; i++) {
      if (i < 0 || j < 0 || i >= side || j >= side) continue;
      const uint32_t there = (uint32_t)(j * side + i);
      if (erosion->donors[there]) continue;
      erosion->donors[there] = 1;
      erosion->height[there] = fmaxf(erosion->height[there], level);
      push_sample(erosion, count, there);
    }
}

static neph_result flood(void *user) {
  const carve_job *job = user;
  np_erosion *erosion = job->erosion;
  size_t count = 0;
  for (size_t i = 0; i < count_samples(erosion); i++) {
    erosion->donors[i] = is_on_rim(erosion, (unsigned)(i % erosion->side), (unsigned)(i / erosion->side));
    if (erosion->donors[i]) push_sample(erosion, &count, (uint32_t)i);
  }
  for (size_t done = 0; count > 0; done++) {
    if (is_stopped(job, done)) return NEPH_ERROR_CANCELLED;
    flood_neighbours(erosion, pop_sample(erosion, &count), &count);
  }
  return NEPH_OK;
}

neph_result np_erosion_fill_basins(neph_context *context, np_monitor *monitor, np_erosion *erosion) {
  carve_job job = {erosion, monitor, 0};
  return np_parallel_run(context, monitor, flood, &job);
}

/* Distance between neighbours that are some columns and rows apart. */
static float measure_distance(const np_erosion *erosion, uint32_t from, uint32_t to, int columns, int rows) {
  const float x = (float)(256 * columns + erosion->place[to][0] - erosion->place[from][0]);
  const float y = (float)(256 * rows + erosion->place[to][1] - erosion->place[from][1]);
  return erosion->spacing * (1.0f / 256.0f) * sqrtf(x * x + y * y);
}

/* Steepest downhill neighbour of the eight; the sample itself in a pit or on the border. */
static uint32_t choose_receiver(const np_erosion *erosion, unsigned column, unsigned row) {
  const uint32_t here = row * erosion->side + column;
  if (is_on_rim(erosion, column, row)) return here;
  uint32_t receiver = here;
  float steepest = 0;
  for (int j = -1; j <= 1; j++)
    for (int i = -1; i <= 1; i++) {
      const uint32_t there = (uint32_t)((int64_t)here + j * (int64_t)erosion->side + i);
      const float fall = erosion->height[here] - erosion->height[there];
      if (!(fall > 0)) continue;
      const float slope = fall / measure_distance(erosion, here, there, i, j);
      if (!(slope > steepest)) continue;
      steepest = slope;
      receiver = there;
    }
  return receiver;
}

static neph_result route_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  np_erosion *erosion = user;
  for (size_t row = begin; row < end; row++)
    for (unsigned column = 0; column < erosion->side; column++) {
      const size_t here = row * erosion->side + column;
      erosion->receiver[here] = choose_receiver(erosion, column, (unsigned)row);
      erosion->donors[here] = 0;
    }
  return NEPH_OK;
}

/* Computes catchments in Kahn's topological order, sources first. */
static bool gather_catchments(const carve_job *job) {
  np_erosion *erosion = job->erosion;
  const size_t count = count_samples(erosion);
  size_t end = 0;
  for (size_t i = 0; i < count; i++) {
    erosion->catchment[i] = erosion->spacing * erosion->spacing;
    if (erosion->receiver[i] != i) erosion->donors[erosion->receiver[i]]++;
  }
  for (size_t i = 0; i < count; i++)
    if (!erosion->donors[i]) erosion->order[end++] = (uint32_t)i;
  for (size_t i = 0; i < end; i++) {
    if (is_stopped(job, i)) return false;
    const uint32_t here = erosion->order[i], receiver = erosion->receiver[here];
    if (receiver == here) continue;
    erosion->catchment[receiver] += erosion->catchment[here];
    if (--erosion->donors[receiver] == 0) erosion->order[end++] = receiver;
  }
  return true;
}

static float measure_receiver_distance(const np_erosion *erosion, uint32_t here, uint32_t receiver) {
  const int32_t side = (int32_t)erosion->side, step = (int32_t)receiver - (int32_t)here;
  const int rows = step > 1 ? 1 : step < -1 ? -1 : 0;
  return measure_distance(erosion, here, receiver, step - rows * side, rows);
}

/* Backward Euler, receivers first: h = (h + U·t + F·h_receiver)/(1 + F) with F = √A·t/distance. */
static bool cut_valleys(const carve_job *job) {
  np_erosion *erosion = job->erosion;
  for (size_t i = count_samples(erosion); i-- > 0;) {
    if (is_stopped(job, i)) return false;
    const uint32_t here = erosion->order[i], receiver = erosion->receiver[here];
    const float risen = erosion->height[here] + erosion->uplift[here] * job->time;
    if (receiver == here) {
      erosion->height[here] = is_on_rim(erosion, here % erosion->side, here / erosion->side) ? 0 : risen;
      continue;
    }
    const float distance = measure_receiver_distance(erosion, here, receiver);
    const float power = sqrtf(erosion->catchment[here] + erosion->hillslope_area) * job->time / distance;
    erosion->height[here] = (risen + power * erosion->height[receiver]) / (1.0f + power);
  }
  return true;
}

static neph_result carve(void *user) {
  const carve_job *job = user;
  return gather_catchments(job) && cut_valleys(job) ? NEPH_OK : NEPH_ERROR_CANCELLED;
}

static neph_result smooth_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  np_erosion *erosion = user;
  const unsigned side = erosion->side;
  for (size_t row = begin; row < end; row++)
    for (unsigned column = 0; column < side; column++) {
      const float *here = erosion->height + row * side + column;
      float smoothed = *here;
      if (!is_on_rim(erosion, column, (unsigned)row))
        smoothed += smoothing * (0.25f * ((here[-1] + here[1]) + (*(here - side) + here[side])) - *here);
      erosion->catchment[row * side + column] = smoothed;
    }
  return NEPH_OK;
}

neph_result np_erosion_step(neph_context *context, np_monitor *monitor, np_erosion *erosion, float time) {
  carve_job job = {erosion, monitor, time};
  neph_result result = np_parallel_for(context, monitor, erosion->side, ROWS_PER_PIECE, route_rows, erosion);
  if (!result) result = np_parallel_run(context, monitor, carve, &job);
  if (!result) result = np_parallel_for(context, monitor, erosion->side, ROWS_PER_PIECE, smooth_rows, erosion);
  float *smoothed = erosion->catchment;
  erosion->catchment = erosion->height;
  erosion->height = smoothed;
  return result;
}

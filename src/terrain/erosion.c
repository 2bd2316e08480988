/* SPDX-License-Identifier: Apache-2.0 */
/* Stream power erosion: ∂h/∂t = U − K·√A·S, with the uplift U, the catchment A upstream of a point, the slope S along
 * the water's way and the erodibility K, here 1.
 *
 * Solved implicitly from the outlets upwards, tree by tree of samples that drain to one, and stable for any time step
 * (Braun and Willett 2013, "A very efficient O(n), implicit and parallel method to solve the stream power equation",
 * eqs. 16 to 22, m = ½, n = 1). As a way to make mountains: Cordonnier et al. 2016, "Large Scale Terrain Generation
 * from Tectonic Uplift and Fluvial Erosion".
 *
 * Basins that a refinement leaves are filled once (Barnes et al. 2014, "Priority-flood: An optimal depression-filling
 * and watershed-labeling algorithm", algorithm 3); a pit that opens later drains nowhere and rises until it spills.
 * Hillslopes that carry no river would grow steeper the finer the grid; an area added to every catchment represents the
 * soil that creeps down them and bounds their slope.
 */
#include "terrain/erosion.h"

#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/math.h"
#include "core/random.h"

/* Share of the difference from its four neighbours' mean that a sample loses in a step, which smooths features of a
 * single sample. */
static const float smoothing = 0.25f;

/* Slope of the water surface in a filled basin. */
static const float basin_slope = 0.01f;

/* CANCEL_STRIDE is the number of samples between two checks for cancelling. */
enum { CANCEL_STRIDE = 1 << 16, ROWS_PER_PIECE = 16, OUTLETS_PER_PIECE = 4 };

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
      (out_erosion->link = np_alloc(context, count, sizeof *out_erosion->link)) &&
      (out_erosion->way = np_alloc(context, count, sizeof *out_erosion->way)) &&
      (out_erosion->place = np_alloc(context, count, sizeof *out_erosion->place)))
    return NEPH_OK;
  np_erosion_destroy(context, out_erosion);
  return NEPH_ERROR_OUT_OF_MEMORY;
}

void np_erosion_destroy(neph_context *context, np_erosion *erosion) {
  np_alloc_free(context, erosion->height);
  np_alloc_free(context, erosion->uplift);
  np_alloc_free(context, erosion->catchment);
  np_alloc_free(context, erosion->link);
  np_alloc_free(context, erosion->way);
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

/* ---- Drainage ---- */

/* Directions to the neighbours of a sample, and to itself, row by row. */
enum { WAY_COUNT = 9, WAY_NONE = 4 };

/* No sample. */
static const uint32_t none = UINT32_MAX;

static uint32_t step(const np_erosion *erosion, uint32_t here, unsigned way) {
  return (uint32_t)((int64_t)here + ((int)(way / 3) - 1) * (int64_t)erosion->side + (int)(way % 3) - 1);
}

/* Distance of a neighbour. */
static float measure_distance(const np_erosion *erosion, uint32_t from, uint32_t to, unsigned way) {
  const float x = (float)(256 * ((int)(way % 3) - 1) + erosion->place[to][0] - erosion->place[from][0]);
  const float y = (float)(256 * ((int)(way / 3) - 1) + erosion->place[to][1] - erosion->place[from][1]);
  return erosion->spacing * (1.0f / 256.0f) * sqrtf(x * x + y * y);
}

/* Direction of steepest descent; none in a pit and on the rim. */
static unsigned choose_way(const np_erosion *erosion, unsigned column, unsigned row) {
  if (is_on_rim(erosion, column, row)) return WAY_NONE;
  const uint32_t here = row * erosion->side + column;
  const float height = erosion->height[here];
  unsigned way = WAY_NONE;
  float steepest = 0;
  for (unsigned w = 0; w < WAY_COUNT; w++) {
    const uint32_t there = step(erosion, here, w);
    const float fall = height - erosion->height[there];
    if (!(fall > 0)) continue;
    const float slope = fall / measure_distance(erosion, here, there, w);
    if (!(slope > steepest)) continue;
    steepest = slope;
    way = w;
  }
  return way;
}

static neph_result route_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_erosion *erosion = user;
  for (size_t row = begin; row < end; row++)
    for (unsigned column = 0; column < erosion->side; column++)
      erosion->way[row * erosion->side + column] = (uint8_t)choose_way(erosion, column, (unsigned)row);
  return NEPH_OK;
}

static bool has_neighbour(const np_erosion *erosion, unsigned column, unsigned row, unsigned way) {
  return column + way % 3 - 1 < erosion->side && row + way / 3 - 1 < erosion->side;
}

/* Appends the samples that drain directly to a sample to the list of those to visit. */
static void pile_donors(const np_erosion *erosion, uint32_t here, uint32_t *top) {
  const unsigned column = here % erosion->side, row = here / erosion->side;
  for (unsigned way = 0; way < WAY_COUNT; way++) {
    if (way == WAY_NONE || !has_neighbour(erosion, column, row, way)) continue;
    const uint32_t there = step(erosion, here, way);
    if (erosion->way[there] != WAY_COUNT - 1 - way) continue;
    erosion->link[there] = *top;
    *top = there;
  }
}

/* Number of samples on the rim. */
static size_t count_outlets(const np_erosion *erosion) { return 4 * ((size_t)erosion->side - 1); }

/* Samples on the rim, one of each edge in turn: trees of neighbouring outlets are of similar size. */
static uint32_t get_outlet(const np_erosion *erosion, size_t number) {
  const uint32_t side = erosion->side, edge = side - 1, along = (uint32_t)(number / 4);
  const uint32_t corner[4] = {0, edge, edge * side + edge, edge * side};
  const int64_t along_edge[4] = {1, side, -1, -(int64_t)side};
  return (uint32_t)(corner[number % 4] + along_edge[number % 4] * along);
}

/* ---- Filling of basins ---- */

/* Samples that are filled wait in a radix heap, whose lowest never falls (Ahuja et al. 1990, "Faster Algorithms for the
 * Shortest Path Problem"): bucket n has the samples whose heights differ from that of the last sample taken in bit n −
 * 1 at the highest, as a list through `link`. Then `way` is whether a sample has been reached. */
enum { BUCKETS = 33 };

typedef struct fill_job {
  np_erosion *erosion;
  np_monitor *monitor;
  uint32_t last; /* key of the last sample taken */
  uint32_t bucket[BUCKETS];
} fill_job;

/* Bits that are in the order of the heights. */
static uint32_t get_key(float height) {
  uint32_t bits;
  memcpy(&bits, &height, sizeof bits);
  return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

static void push_sample(fill_job *job, uint32_t sample) {
  const uint32_t difference = get_key(job->erosion->height[sample]) ^ job->last;
  uint32_t *bucket = &job->bucket[difference ? 32 - __builtin_clz(difference) : 0];
  job->erosion->link[sample] = *bucket;
  *bucket = sample;
}

/* Takes a lowest sample; `none` where there is no more. */
static uint32_t pop_sample(fill_job *job) {
  const np_erosion *erosion = job->erosion;
  unsigned n = 0;
  while (n < BUCKETS && job->bucket[n] == none) n++;
  if (n == BUCKETS) return none;
  if (n > 0) {
    uint32_t sample = job->bucket[n], next, least = UINT32_MAX;
    for (uint32_t s = sample; s != none; s = erosion->link[s]) {
      const uint32_t key = get_key(erosion->height[s]);
      least = key < least ? key : least;
    }
    job->bucket[n] = none;
    job->last = least;
    for (; sample != none; sample = next) {
      next = erosion->link[sample];
      push_sample(job, sample);
    }
  }
  const uint32_t lowest = job->bucket[0];
  job->bucket[0] = erosion->link[lowest];
  return lowest;
}

/* Floods the neighbours of a sample that have not been reached: to slightly above it, where they are no higher. */
static void flood_neighbours(fill_job *job, uint32_t here) {
  np_erosion *erosion = job->erosion;
  const unsigned column = here % erosion->side, row = here / erosion->side;
  const float level = erosion->height[here] + basin_slope * erosion->spacing;
  for (unsigned way = 0; way < WAY_COUNT; way++) {
    if (!has_neighbour(erosion, column, row, way)) continue;
    const uint32_t there = step(erosion, here, way);
    if (erosion->way[there]) continue;
    erosion->way[there] = 1;
    erosion->height[there] = np_maxf(erosion->height[there], level);
    push_sample(job, there);
  }
}

static neph_result flood(void *user) {
  fill_job *job = user;
  np_erosion *erosion = job->erosion;
  memset(erosion->way, 0, count_samples(erosion) * sizeof *erosion->way);
  for (unsigned n = 0; n < BUCKETS; n++) job->bucket[n] = none;
  for (size_t i = 0; i < count_outlets(erosion); i++) {
    const uint32_t outlet = get_outlet(erosion, i);
    erosion->way[outlet] = 1;
    push_sample(job, outlet);
  }
  uint32_t here = pop_sample(job);
  for (size_t done = 0; here != none; done++, here = pop_sample(job)) {
    if (done % CANCEL_STRIDE == 0 && np_monitor_is_cancelled(job->monitor)) return NEPH_ERROR_CANCELLED;
    flood_neighbours(job, here);
  }
  return NEPH_OK;
}

neph_result np_erosion_fill_basins(neph_context *context, np_monitor *monitor, np_erosion *erosion) {
  fill_job job = {.erosion = erosion, .monitor = monitor};
  return np_parallel_run(context, monitor, flood, &job);
}

/* ---- A step ---- */

/* Links all that drains to a root, receivers first, each to the one before; returns the last. */
static uint32_t link_tree(np_erosion *erosion, uint32_t root) {
  uint32_t top = root, last = none;
  erosion->link[root] = none;
  while (top != none) {
    const uint32_t here = top;
    top = erosion->link[here];
    erosion->link[here] = last;
    last = here;
    erosion->catchment[here] = erosion->spacing * erosion->spacing;
    pile_donors(erosion, here, &top);
  }
  return last;
}

/* Adds up catchments from the last sample of a list to its root, and turns the list round. */
static void gather_catchments(np_erosion *erosion, uint32_t last) {
  uint32_t next = none;
  for (uint32_t here = last, before; here != none; next = here, here = before) {
    if (erosion->way[here] != WAY_NONE)
      erosion->catchment[step(erosion, here, erosion->way[here])] += erosion->catchment[here];
    before = erosion->link[here];
    erosion->link[here] = next;
  }
}

typedef struct carve_job {
  np_erosion *erosion;
  float time;
} carve_job;

/* Backward Euler, receivers first: h = (h + U·t + F·h_receiver)/(1 + F) with F = √A·t/distance. */
static void cut_valleys(const carve_job *job, uint32_t root) {
  np_erosion *erosion = job->erosion;
  for (uint32_t here = root; here != none; here = erosion->link[here]) {
    const unsigned way = erosion->way[here];
    const float risen = erosion->height[here] + erosion->uplift[here] * job->time;
    if (way == WAY_NONE) {
      erosion->height[here] = is_on_rim(erosion, here % erosion->side, here / erosion->side) ? 0 : risen;
      continue;
    }
    const uint32_t receiver = step(erosion, here, way);
    const float distance = measure_distance(erosion, here, receiver, way);
    const float power = sqrtf(erosion->catchment[here] + erosion->hillslope_area) * job->time / distance;
    erosion->height[here] = (risen + power * erosion->height[receiver]) / (1.0f + power);
  }
}

static void carve_tree(const carve_job *job, uint32_t root) {
  gather_catchments(job->erosion, link_tree(job->erosion, root));
  cut_valleys(job, root);
}

/* Carves the trees of outlets, then those of the pits of each row within the rim. */
static neph_result carve_trees(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const carve_job *job = user;
  const np_erosion *erosion = job->erosion;
  const size_t outlets = count_outlets(erosion);
  for (size_t i = begin; i < end; i++) {
    if (i < outlets) {
      carve_tree(job, get_outlet(erosion, i));
      continue;
    }
    const uint32_t first = (uint32_t)(i - outlets + 1) * erosion->side + 1;
    for (uint32_t here = first; here < first + erosion->side - 2; here++)
      if (erosion->way[here] == WAY_NONE) carve_tree(job, here);
  }
  return NEPH_OK;
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
  carve_job carve = {erosion, time};
  const size_t places = count_outlets(erosion) + erosion->side - 2;
  neph_result result = np_parallel_for(context, monitor, erosion->side, ROWS_PER_PIECE, route_rows, erosion);
  if (!result) result = np_parallel_for(context, monitor, places, OUTLETS_PER_PIECE, carve_trees, &carve);
  if (!result) result = np_parallel_for(context, monitor, erosion->side, ROWS_PER_PIECE, smooth_rows, erosion);
  float *smoothed = erosion->catchment;
  erosion->catchment = erosion->height;
  erosion->height = smoothed;
  return result;
}

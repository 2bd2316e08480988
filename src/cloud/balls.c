/* SPDX-License-Identifier: Apache-2.0 */
/* Signed distance of a heap of balls: the union of the balls of each level, blended between the two nearest, and of all
 * levels, coarse to fine. Each blend is Quilez' quadratic "smooth minimum", at most a quarter of its width below the
 * smaller distance. Bins are visited in a fixed order, so that a value depends on its position alone. */
#include "cloud/balls.h"

#include <math.h>

#include "core/alloc.h"
#include "core/math.h"

extern const np_ball_table np_ball_kernels_v1, np_ball_kernels_v3, np_ball_kernels_v4;

const np_ball_table *np_ball_get_table(neph_isa isa) {
  static const np_ball_table *const tables[NP_ISA_COUNT] = {&np_ball_kernels_v1, &np_ball_kernels_v3,
                                                            &np_ball_kernels_v4};
  return tables[isa];
}

neph_result np_ball_list_add(neph_context *context, np_ball_list *list, const np_ball *ball) {
  if (list->count == list->capacity) {
    const size_t capacity = list->capacity ? 2 * list->capacity : 64;
    np_ball *balls = np_alloc_resize(context, list->balls, capacity, sizeof *balls);
    if (!balls) return NEPH_ERROR_OUT_OF_MEMORY;
    list->balls = balls;
    list->capacity = capacity;
  }
  list->balls[list->count++] = *ball;
  return NEPH_OK;
}

/* ---- Bins ---- */

static int32_t compute_bin(const np_ball_level *level, int axis, float position_m) {
  const float scaled = (position_m - level->origin_m[axis]) / level->bin_m;
  return (int32_t)np_clampf(scaled, 0.0f, (float)(level->bins[axis] - 1));
}

static size_t compute_bin_index(const np_ball_level *level, const int32_t at[3]) {
  return ((size_t)at[0] * (size_t)level->bins[1] + (size_t)at[1]) * (size_t)level->bins[2] + (size_t)at[2];
}

static size_t choose_bin(const np_ball_level *level, const np_ball *ball) {
  const int32_t at[3] = {compute_bin(level, 0, ball->x_m), compute_bin(level, 1, ball->y_m),
                         compute_bin(level, 2, ball->z_m)};
  return compute_bin_index(level, at);
}

/* Chooses bins over the box of all centres. */
static size_t choose_bins(np_ball_level *level, const np_ball_list *lists, size_t list_count, float bin_min_m) {
  float low_m[3] = {INFINITY, INFINITY, INFINITY}, high_m[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (size_t l = 0; l < list_count; l++)
    for (size_t i = 0; i < lists[l].count; i++) {
      const np_ball *b = &lists[l].balls[i];
      const float at_m[3] = {b->x_m, b->y_m, b->z_m};
      for (int a = 0; a < 3; a++) {
        low_m[a] = fminf(low_m[a], at_m[a]);
        high_m[a] = fmaxf(high_m[a], at_m[a]);
      }
      level->radius_max_m = fmaxf(level->radius_max_m, b->radius_m);
      level->count++;
    }
  level->bin_m = fmaxf(bin_min_m, level->radius_max_m);
  size_t bin_count = 1;
  for (int a = 0; a < 3; a++) {
    level->origin_m[a] = level->count ? low_m[a] : 0.0f;
    level->bins[a] = level->count ? (int32_t)((high_m[a] - low_m[a]) / level->bin_m) + 1 : 1;
    bin_count *= (size_t)level->bins[a];
  }
  return bin_count;
}

static void put_ball(const np_ball_columns *to, size_t n, const np_ball *ball) {
  to->x_m[n] = ball->x_m;
  to->y_m[n] = ball->y_m;
  to->z_m[n] = ball->z_m;
  to->radius_m[n] = ball->radius_m;
  to->age[n] = ball->age;
}

np_ball np_ball_level_get(const np_ball_level *level, size_t n) {
  const np_ball_columns *b = &level->balls;
  return (np_ball){b->x_m[n], b->y_m[n], b->z_m[n], b->radius_m[n], b->age[n]};
}

/* Counting sort: balls of a bin keep their order. */
static void sort_balls(np_ball_level *level, const np_ball_list *lists, size_t list_count, size_t bin_count) {
  for (size_t l = 0; l < list_count; l++)
    for (size_t i = 0; i < lists[l].count; i++) level->bin_begin[choose_bin(level, &lists[l].balls[i]) + 1]++;
  for (size_t bin = 0; bin < bin_count; bin++) level->bin_begin[bin + 1] += level->bin_begin[bin];
  for (size_t l = 0; l < list_count; l++)
    for (size_t i = 0; i < lists[l].count; i++)
      put_ball(&level->balls, level->bin_begin[choose_bin(level, &lists[l].balls[i])]++, &lists[l].balls[i]);
  for (size_t bin = bin_count; bin > 0; bin--) level->bin_begin[bin] = level->bin_begin[bin - 1];
  level->bin_begin[0] = 0;
}

static neph_result make_columns(neph_context *context, size_t count, np_ball_columns *out) {
  float *block = np_alloc(context, count, 5 * sizeof *block);
  if (!block) return NEPH_ERROR_OUT_OF_MEMORY;
  *out = (np_ball_columns){block, block + count, block + 2 * count, block + 3 * count, block + 4 * count};
  return NEPH_OK;
}

neph_result np_ball_heap_add_level(np_ball_heap *heap, const np_ball_list *lists, size_t list_count, float blend_m,
                                   float bin_min_m) {
  np_ball_level level = {.blend_m = blend_m};
  const size_t bin_count = choose_bins(&level, lists, list_count, bin_min_m);
  const neph_result result = make_columns(heap->context, level.count, &level.balls);
  level.bin_begin = np_alloc(heap->context, bin_count + 2, sizeof *level.bin_begin);
  heap->levels[heap->level_count++] = level;
  if (result || !level.bin_begin) return NEPH_ERROR_OUT_OF_MEMORY;
  sort_balls(&heap->levels[heap->level_count - 1], lists, list_count, bin_count);
  return NEPH_OK;
}

void np_ball_heap_cut(np_ball_heap *heap, unsigned level_count) {
  while (heap->level_count > level_count) {
    np_ball_level *level = &heap->levels[--heap->level_count];
    np_alloc_free(heap->context, level->balls.x_m);
    np_alloc_free(heap->context, level->bin_begin);
    *level = (np_ball_level){0};
  }
}

double np_ball_heap_count_bytes(const np_ball_heap *heap) {
  double bytes = 0;
  for (unsigned l = 0; l < heap->level_count; l++) {
    const np_ball_level *level = &heap->levels[l];
    bytes += (double)level->count * sizeof(np_ball);
    bytes += (double)level->bins[0] * level->bins[1] * level->bins[2] * sizeof *level->bin_begin;
  }
  return bytes;
}

/* ---- Boxes ---- */

/* Distance up to which a level's balls may count for distances up to reach_m. Its own two blends can subtract that
 * much. It counts as far as the blend of a finer level beyond that level's distance; that blend and the finest ones
 * subtract a quarter of their widths. */
static float compute_level_reach(const np_ball_heap *heap, unsigned l, float reach_m) {
  float reach = reach_m + 1.5f * heap->levels[l].blend_m;
  for (unsigned finer = l + 1; finer < heap->level_count; finer++) reach += 1.25f * heap->levels[finer].blend_m;
  return reach * 1.001f;
}

typedef struct bin_range {
  int32_t low[3], high[3];
} bin_range;

static bool compute_range(const np_ball_level *level, const np_ball_box *box, float reach_m, bin_range *out) {
  const float pad_m = level->radius_max_m + reach_m;
  for (int a = 0; a < 3; a++) {
    const float end_m = level->origin_m[a] + (float)level->bins[a] * level->bin_m;
    if (box->max_m[a] + pad_m < level->origin_m[a] || box->min_m[a] - pad_m > end_m) return false;
    out->low[a] = compute_bin(level, a, box->min_m[a] - pad_m);
    out->high[a] = compute_bin(level, a, box->max_m[a] + pad_m);
  }
  return level->count > 0;
}

/* Balls from `first` to `end`, in consecutive bins along z. */
typedef struct bin_run {
  uint32_t first, end;
} bin_run;

static bin_run get_run(const np_ball_level *level, const bin_range *range, int32_t i, int32_t j) {
  const int32_t low[3] = {i, j, range->low[2]}, high[3] = {i, j, range->high[2]};
  return (bin_run){level->bin_begin[compute_bin_index(level, low)],
                   level->bin_begin[compute_bin_index(level, high) + 1]};
}

/* Distance up to which the shape below all levels counts. */
static float compute_shape_reach(const np_ball_heap *heap, float reach_m) {
  float reach = reach_m;
  for (unsigned l = 0; l < heap->level_count; l++) reach += heap->levels[l].blend_m;
  return reach * 1.001f;
}

static bool is_run_near(const np_ball_heap *heap, const np_ball_level *level, const bin_run *run,
                        const np_ball_box *box, float reach_m) {
  uint32_t near[NP_BALL_RUN];
  for (size_t n = run->first; n < run->end; n += NP_BALL_RUN) {
    const size_t count = run->end - n < NP_BALL_RUN ? run->end - n : NP_BALL_RUN;
    if (heap->kernels->choose_near(&level->balls, n, count, box, reach_m, near)) return true;
  }
  return false;
}

bool np_ball_heap_is_near(const np_ball_heap *heap, const float min_m[3], const float max_m[3], float reach_m) {
  if (heap->shape && np_shape_grid_is_near(heap->shape, min_m, max_m, compute_shape_reach(heap, reach_m))) return true;
  const np_ball_box box = {{min_m[0], min_m[1], min_m[2]}, {max_m[0], max_m[1], max_m[2]}};
  for (unsigned l = 0; l < heap->level_count; l++) {
    const np_ball_level *level = &heap->levels[l];
    const float reach = compute_level_reach(heap, l, reach_m);
    bin_range range;
    if (!compute_range(level, &box, reach, &range)) continue;
    for (int32_t i = range.low[0]; i <= range.high[0]; i++)
      for (int32_t j = range.low[1]; j <= range.high[1]; j++) {
        const bin_run run = get_run(level, &range, i, j);
        if (is_run_near(heap, level, &run, &box, reach)) return true;
      }
  }
  return false;
}

/* ---- Search ---- */

enum { SLICE_POINTS_MIN = 24, SLICE_POINTS_MAX = 64, SLICES_MAX = NP_BALL_BLOCK / SLICE_POINTS_MIN + 1 };

typedef struct ball_search {
  const np_ball_heap *heap;
  const np_ball_points *points;
  np_ball_box box; /* around all points */
  float slack_m;   /* margin for rounding */
  size_t slice_count;
  np_ball_slice slices[SLICES_MAX];
  np_ball_chunk chunk;
  np_ball_nearest nearest;
} ball_search;

static void flush(ball_search *s, const np_ball_level *level) {
  for (size_t n = 0; n < s->slice_count; n++)
    s->heap->kernels->search_chunk(&s->chunk, level->blend_m + s->slack_m, s->points, &s->slices[n], &s->nearest);
  s->chunk.count = 0;
}

static void add_candidates(np_ball_chunk *chunk, const np_ball_columns *balls, const uint32_t *numbers, size_t count) {
  for (size_t k = 0; k < count; k++) {
    const size_t n = chunk->count++, from = numbers[k];
    chunk->x_m[n] = balls->x_m[from];
    chunk->y_m[n] = balls->y_m[from];
    chunk->z_m[n] = balls->z_m[from];
    chunk->radius_m[n] = balls->radius_m[from];
    chunk->index[n] = (int32_t)from;
  }
}

/* Limits the reach of a level's balls to the blend with the levels before, whose distances are set. Returns the largest
 * reach of all slices. */
static float limit_reach(ball_search *s, const np_ball_level *level, float reach_m, const float *before_m) {
  float largest_m = -INFINITY;
  for (size_t n = 0; n < s->slice_count; n++) {
    np_ball_slice *slice = &s->slices[n];
    float most_m = -INFINITY;
    for (size_t i = slice->begin; i < slice->end; i++) most_m = np_maxf(most_m, before_m[i]);
    slice->nearest_max_m = INFINITY;
    slice->reach_m = np_minf(reach_m, most_m + 2.25f * level->blend_m + s->slack_m);
    largest_m = np_maxf(largest_m, slice->reach_m);
  }
  return largest_m;
}

/* Returns whether any ball of a run may be near. */
static bool search_run(ball_search *s, const np_ball_level *level, const bin_run *run, float reach_m) {
  uint32_t near[NP_BALL_RUN];
  bool is_any = false;
  for (size_t n = run->first; n < run->end; n += NP_BALL_RUN) {
    const size_t count = run->end - n < NP_BALL_RUN ? run->end - n : NP_BALL_RUN;
    const size_t near_count = s->heap->kernels->choose_near(&level->balls, n, count, &s->box, reach_m, near);
    if (s->chunk.count + near_count > NP_BALL_CHUNK) flush(s, level);
    add_candidates(&s->chunk, &level->balls, near, near_count);
    is_any = is_any || near_count;
  }
  return is_any;
}

/* The two nearest balls of a level. False: none is near. */
static bool search_level(ball_search *s, const np_ball_level *level, float reach_m) {
  bin_range range;
  bool is_any = false;
  if (!compute_range(level, &s->box, reach_m, &range)) return false;
  for (size_t k = 0; k < s->points->count; k++) s->nearest.nearest_m[k] = s->nearest.second_m[k] = INFINITY;
  for (int32_t i = range.low[0]; i <= range.high[0]; i++)
    for (int32_t j = range.low[1]; j <= range.high[1]; j++) {
      const bin_run run = get_run(level, &range, i, j);
      if (search_run(s, level, &run, reach_m)) is_any = true;
    }
  if (s->chunk.count) flush(s, level);
  return is_any;
}

static void compute_normal(const ball_search *s, const np_ball *ball, size_t i, float out[3]) {
  const np_ball_points *p = s->points;
  const float x = p->x_m[i] - ball->x_m, y = p->y_m[i] - ball->y_m, z = p->z_m[i] - ball->z_m;
  const float length = sqrtf(x * x + y * y + z * z), scale = length > 0.0f ? 1.0f / length : 0.0f;
  out[0] = x * scale;
  out[1] = y * scale;
  out[2] = z * scale;
}

/* Interpolates so that a share of 1 gives exactly `second`, even if `first` is not defined: it may come from balls that
 * are too far away to count. */
static float mix_value(float first, float second, float share) {
  return share < 1.0f ? np_mixf(first, second, share) : second;
}

static void add_share(const np_ball_surface *out, size_t i, float share, const float *values) {
  float *targets[] = {out->radius_m, out->normal[0], out->normal[1], out->normal[2]};
  for (int t = 0; t < 4; t++) targets[t][i] = mix_value(targets[t][i], values[t], share);
}

/* Interpolates radius and normal at a point between the two nearest balls of a level. */
static void blend_values(const ball_search *s, const np_ball_level *level, size_t i, float share, float *values) {
  const np_ball one = np_ball_level_get(level, (size_t)s->nearest.nearest[i]);
  const np_ball other = share > 0.0f ? np_ball_level_get(level, (size_t)s->nearest.second[i]) : one;
  float normal[2][3];
  compute_normal(s, &one, i, normal[0]);
  compute_normal(s, &other, i, normal[1]);
  values[0] = np_mixf(one.radius_m, other.radius_m, share);
  for (int a = 0; a < 3; a++) values[1 + a] = np_mixf(normal[0][a], normal[1][a], share);
}

static void blend_ages(const ball_search *s, const np_ball_level *level, float *age) {
  const np_ball_nearest *n = &s->nearest;
  for (size_t i = 0; i < s->points->count; i++) {
    if (!(n->level_share[i] > 0.0f)) continue;
    const float *ages = level->balls.age, one = ages[n->nearest[i]], share = n->second_share[i];
    const float own = share > 0.0f ? np_mixf(one, ages[n->second[i]], share) : one;
    age[i] = mix_value(age[i], own, n->level_share[i]);
  }
}

/* Blends a level's balls with the levels before. */
static void join_level(ball_search *s, const np_ball_level *level, const np_ball_surface *out) {
  s->heap->kernels->join_level(s->points->count, level->blend_m, &s->nearest, out->distance_m);
  if (out->age) blend_ages(s, level, out->age);
  for (size_t i = 0; i < s->points->count && out->radius_m; i++) {
    float values[4];
    if (!(s->nearest.level_share[i] > 0.0f)) continue;
    blend_values(s, level, i, s->nearest.second_share[i], values);
    add_share(out, i, s->nearest.level_share[i], values);
  }
}

/* Fills distance, normal and radius of curvature from the grid of the shape, to which the levels of balls are then
 * blended. */
static void start_from_shape(const np_shape_grid *shape, const np_ball_points *points, const np_ball_surface *out) {
  for (size_t i = 0; i < points->count; i++) {
    const float at_m[3] = {points->x_m[i], points->y_m[i], points->z_m[i]};
    float normal[3];
    out->distance_m[i] = np_shape_grid_sample(shape, at_m, out->radius_m ? normal : NULL);
    if (out->age) out->age[i] = np_shape_compute_age(shape->age, at_m[2], shape->thickness_m);
    if (!out->radius_m) continue;
    out->radius_m[i] = np_shape_grid_compute_radius(shape, at_m, out->distance_m[i], normal);
    for (int a = 0; a < 3; a++) out->normal[a][i] = normal[a];
  }
}

static np_ball_box grow_box(const np_ball_box *box, const np_ball_points *points, size_t i) {
  const float at_m[3] = {points->x_m[i], points->y_m[i], points->z_m[i]};
  np_ball_box grown;
  for (int a = 0; a < 3; a++) {
    grown.min_m[a] = np_minf(box->min_m[a], at_m[a]);
    grown.max_m[a] = np_maxf(box->max_m[a], at_m[a]);
  }
  return grown;
}

static float compute_edge(const np_ball_box *box) {
  return np_maxf(np_maxf(box->max_m[0] - box->min_m[0], box->max_m[1] - box->min_m[1]), box->max_m[2] - box->min_m[2]);
}

static const np_ball_box no_box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

/* Slice of consecutive points from `begin` on within half the edge of the whole box. */
static np_ball_slice cut_slice(const np_ball_points *points, size_t begin, float edge_max_m) {
  np_ball_slice slice = {.begin = begin, .end = begin};
  np_ball_box box = no_box;
  float diagonal2 = 0.0f;
  for (; slice.end < points->count && slice.end < begin + SLICE_POINTS_MAX; slice.end++) {
    const np_ball_box grown = grow_box(&box, points, slice.end);
    if (slice.end >= begin + SLICE_POINTS_MIN && compute_edge(&grown) > edge_max_m) break;
    box = grown;
  }
  for (int a = 0; a < 3; a++) {
    slice.center_m[a] = 0.5f * (box.min_m[a] + box.max_m[a]);
    diagonal2 += (box.max_m[a] - box.min_m[a]) * (box.max_m[a] - box.min_m[a]);
  }
  slice.radius_m = 0.5f * sqrtf(diagonal2);
  return slice;
}

static void cut_slices(ball_search *s) {
  np_ball_box box = no_box;
  float largest_m = 0.0f;
  for (size_t i = 0; i < s->points->count; i++) box = grow_box(&box, s->points, i);
  for (int a = 0; a < 3; a++) {
    largest_m = np_maxf(largest_m, np_maxf(fabsf(box.min_m[a]), fabsf(box.max_m[a])));
  }
  const float edge_m = compute_edge(&box);
  s->box = box;
  s->slack_m = 2e-6f * (largest_m + edge_m);
  s->slice_count = 0;
  for (size_t begin = 0; begin < s->points->count; begin = s->slices[s->slice_count++].end)
    s->slices[s->slice_count] = cut_slice(s->points, begin, 0.5f * edge_m);
}

bool np_ball_heap_search(const np_ball_heap *heap, const np_ball_points *points, float reach_m,
                         const np_ball_surface *out) {
  ball_search s;
  bool is_any = false;
  s.heap = heap;
  s.points = points;
  s.chunk.count = 0;
  for (size_t i = 0; i < points->count; i++) out->distance_m[i] = INFINITY;
  if (points->count == 0) return false;
  float *const values[] = {out->age, out->radius_m, out->normal[0], out->normal[1], out->normal[2]};
  for (int v = 0; v < 5; v++)
    if (values[v]) memset(values[v], 0, points->count * sizeof **values);
  cut_slices(&s);
  if (heap->shape && np_shape_grid_is_near(heap->shape, s.box.min_m, s.box.max_m, compute_shape_reach(heap, reach_m))) {
    start_from_shape(heap->shape, points, out);
    is_any = true;
  }
  for (unsigned l = 0; l < heap->level_count; l++) {
    const np_ball_level *level = &heap->levels[l];
    const float level_reach_m = limit_reach(&s, level, compute_level_reach(heap, l, reach_m), out->distance_m);
    if (!search_level(&s, level, level_reach_m)) continue;
    join_level(&s, level, out);
    is_any = true;
  }
  return is_any;
}

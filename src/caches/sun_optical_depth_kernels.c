/* SPDX-License-Identifier: Apache-2.0 */
/* One column of the sun optical-depth volume: marching its rays, and choosing the nodes that each cell stores. Compiled
 * once per instruction-set level. */
#include <string.h>

#include "core/isa.h"
#include "core/math.h"
#include "core/stable.h"
#include "caches/sun_optical_depth.h"
#include "volume/brick_walk.h"

/* Marches the rays, and chooses the level of each cell. */
void NP_KERNEL(np_sun_column_fill)(np_sun_column *column);

/* Marches steep cells with rays half a step apart, 19 × 19 of them, one beyond the column on each side. */
void NP_KERNEL(np_sun_column_refine)(np_sun_column *column);

enum { EDGE = NP_SUN_CELL_EDGE, NODES = NP_SUN_CELL_NODES, CELL = NODES * NODES * NODES };

/* State of one ray, which computes the depth from the sun to each of its nodes by the midpoint rule. */
typedef struct sun_ray {
  const np_instance *volume;
  double spacing;
  size_t count, next; /* number of nodes, and the first not yet reached */
  double t_next;      /* place of that node; infinite beyond the last */
  float depth, *out;
} sun_ray;

static void set_next(sun_ray *r, size_t next) {
  r->next = next;
  r->t_next = next < r->count ? (double)next * r->spacing : HUGE_VAL;
}

static inline void store_until(sun_ray *r, double t) {
  while (r->t_next <= t) {
    r->out[r->next] = r->depth;
    set_next(r, r->next + 1);
  }
}

/* Cuts a span at nodes, from t on, measured from the span's begin: middles, lengths and ends of the pieces. Returns
 * their number. */
static int cut_span(const sun_ray *r, const np_brick_span *span, double t, float middle[NP_BRICK_LINE],
                    float length[NP_BRICK_LINE], double end[NP_BRICK_LINE]) {
  int count = 0;
  for (; count < NP_BRICK_LINE && t < span->t_end; t = end[count++]) {
    const size_t n = r->next + (size_t)count;
    const double node = (double)n * r->spacing;
    end[count] = n < r->count && node < span->t_end ? node : span->t_end;
    middle[count] = (float)(0.5 * (t + end[count]) - span->t_begin);
    length[count] = (float)(end[count] - t);
  }
  return count;
}

/* Integrates a span of constant density, in which the depth is linear. */
static void follow_constant(sun_ray *r, const np_brick_span *span) {
  const double rate = (double)(r->volume->extinction_per_value * span->range.min);
  const double depth = (double)r->depth - rate * span->t_begin;
  size_t end = (size_t)(span->t_end / r->spacing) + 1;
  end = end < r->count ? end : r->count;
  while (end > r->next && (double)(end - 1) * r->spacing > span->t_end) end--;
  for (size_t n = r->next; n < end; n++) r->out[n] = (float)(depth + rate * ((double)n * r->spacing));
  if (end > r->next) set_next(r, end);
  r->depth += (float)(rate * (span->t_end - span->t_begin));
}

static void follow_span(sun_ray *r, const np_brick_walk *walk, const np_brick_span *span) {
  const np_bricks *bricks = r->volume->bricks;
  const np_vec3 begin = np_brick_walk_local(walk, span, span->t_begin);
  const np_vec3 along = np_dvec3_to_float(np_dvec3_make(walk->direction[0], walk->direction[1], walk->direction[2]));
  float middle[NP_BRICK_LINE] = {0.0f}, length[NP_BRICK_LINE], value[NP_BRICK_LINE];
  double end[NP_BRICK_LINE];
  for (double t = span->t_begin; t < span->t_end;) {
    const int count = cut_span(r, span, t, middle, length, end);
    np_brick_sample_along_plain((np_brick_ref){bricks, span->brick, span->cell}, begin, along, middle, count, value);
    for (int k = 0; k < count; k++) {
      r->depth += r->volume->extinction_per_value * value[k] * length[k];
      store_until(r, end[k]);
    }
    t = end[count - 1];
  }
}

/* Marches a ray from a place on the plane where the rays begin, in steps of the lattice. */
static void follow_ray(const np_sun_column *c, double u, double v, double spacing, size_t count, float *out) {
  sun_ray r = {.volume = c->volume, .spacing = spacing, .count = count, .out = out};
  set_next(&r, 0);
  const np_dvec3 origin = np_affine_point(&c->lattice->lattice_to_world, np_dvec3_make(u, v, 0.0));
  np_brick_walk walk;
  np_brick_span span;
  np_brick_walk_start(&walk, c->volume->bricks, np_affine_point(&c->volume->world_to_index, origin),
                      np_affine_vector(&c->volume->world_to_index, np_vec3_to_double(c->from_sun)), 0.0,
                      (double)(r.count - 1) * r.spacing);
  while (r.depth < c->depth_end && np_brick_walk_next(&walk, &span)) {
    store_until(&r, span.t_begin);
    if (span.brick == NP_BRICK_NONE)
      follow_constant(&r, &span);
    else
      follow_span(&r, &walk, &span);
  }
  while (r.next < r.count) out[r.next++] = r.depth;
}

static void follow_rays(const np_sun_column *c) {
  const size_t count = (size_t)c->lattice->size[2] * EDGE + 1;
  for (int i = 0; i < NODES; i++)
    for (int j = 0; j < NODES; j++)
      follow_ray(c, c->at[0] * EDGE + i, c->at[1] * EDGE + j, c->lattice->spacing_m, count,
                 c->rays + (size_t)(i * NODES + j) * count);
}

/* The largest e^{−x·low}·(1 − e^{−x·gap}) for x from `rate` to 1: the error of light whose depth errs by `gap`. Without
 * calls and branches, for loops that compilers make vectors of. Without bounds on x the maximum is at
 * x·gap = ln(1 + r), r = gap/low, and (1 + r)^{−1/r}·r/(1 + r) there, here within 1.2 %. */
static inline float compute_light_error(float low, float gap, float rate) {
  const float at_full = (1.0f - np_opacity(low)) * np_opacity(gap);
  const float opacity = np_opacity(rate * gap), at_least = (1.0f - np_opacity(rate * low)) * opacity;
  const float r = gap / np_maxf(low, 1e-20f);
  const float within = r / (r + 2.71828f + 2.07f * r / (6.35f + r));
  const float bounded = (1.0f + r) * (1.0f - opacity) < 1.0f ? at_least : within;
  return (1.0f + r) * (1.0f - np_opacity(gap)) > 1.0f ? at_full : bounded;
}

/* Nodes of a cell: `edge` intervals along each axis. */
typedef struct node_block {
  const float *first;
  size_t step[3], edge;
} node_block;

/* Nodes halfway between two others of a plane of nodes: the lower of each node's depth and its interpolation, and their
 * difference. */
typedef struct node_plane {
  size_t count;
  float low[NP_SUN_FINE_EDGE / 2 * (NP_SUN_FINE_EDGE + 1)], gap[NP_SUN_FINE_EDGE / 2 * (NP_SUN_FINE_EDGE + 1)];
} node_plane;

static void gather_plane(const float *first, size_t edge, size_t stride, size_t step, size_t across, node_plane *out) {
  out->count = 0;
  for (size_t j = 0; j <= edge; j += stride)
    for (size_t k = stride; k < edge; k += 2 * stride) {
      const float *node = first + j * across + k * step;
      const float guess = 0.5f * (*(node - stride * step) + node[stride * step]);
      out->low[out->count] = np_minf(guess, *node);
      out->gap[out->count++] = fabsf(guess - *node);
    }
}

static float sum_plane(const node_plane *plane, float rate) {
  enum { LANES = 8 };
  float sums[LANES] = {0.0f}, sum = 0.0f;
  const size_t whole = plane->count - plane->count % LANES;
  for (size_t i = 0; i < whole; i += LANES)
    for (size_t lane = 0; lane < LANES; lane++) {
      const float error = compute_light_error(plane->low[i + lane], plane->gap[i + lane], rate);
      sums[lane] += error * error;
    }
  for (size_t i = whole; i < plane->count; i++) {
    const float error = compute_light_error(plane->low[i], plane->gap[i], rate);
    sum += error * error;
  }
  for (size_t lane = 0; lane < LANES; lane++) sum += sums[lane];
  return sum;
}

/* Sum over nodes halfway between two others, each `stride` apart, of the squared error in light of their
 * interpolation. */
static float sum_curvatures(const node_block *b, size_t stride, int axis, float rate, size_t *count) {
  const size_t other[2] = {b->step[(axis + 1) % 3], b->step[(axis + 2) % 3]};
  node_plane plane;
  float sum = 0.0f;
  for (size_t i = 0; i <= b->edge; i += stride) {
    gather_plane(b->first + i * other[0], b->edge, stride, b->step[axis], other[1], &plane);
    sum += sum_plane(&plane, rate);
    *count += plane.count;
  }
  return sum;
}

/* Root mean square of these errors, over every second node along each axis. */
static float compute_curvature(const node_block *b, size_t stride, float rate) {
  size_t count = 0;
  float sum = 0.0f;
  for (int axis = 0; axis < 3; axis++) sum += sum_curvatures(b, stride, axis, rate, &count);
  return sqrtf(sum / (float)count);
}

/* Chooses the level of a cell. Between nodes one step apart linear interpolation errs by a third of its error between
 * nodes two steps apart: a quarter where the depth is smooth, half at an edge. */
static uint32_t choose_level(const float cell[CELL], const np_sun_optical_depth_desc *desc) {
  const node_block b = {cell, {NODES * NODES, NODES, 1}, EDGE};
  float quadratic = compute_curvature(&b, 1, desc->rate);
  if (quadratic > 3.0f * desc->tolerance) return NP_SUN_CELL_STEEP;
  uint32_t level = 1;
  while (quadratic <= desc->tolerance && ++level + 1 < NP_SUN_CELL_LEVELS)
    quadratic = compute_curvature(&b, (size_t)1 << (level - 1), desc->rate);
  return level;
}

static void gather_cell(const np_sun_column *c, int32_t k, float cell[CELL]) {
  const size_t count = (size_t)c->lattice->size[2] * EDGE + 1;
  for (size_t ray = 0; ray < NODES * NODES; ray++)
    memcpy(cell + ray * NODES, c->rays + ray * count + (size_t)k * EDGE, NODES * sizeof *cell);
}

static uint32_t choose(const np_sun_column *c, const float cell[CELL]) {
  bool is_empty = true, is_dark = true;
  for (size_t ray = 0; ray < NODES * NODES; ray++) {
    is_empty = is_empty && cell[ray * NODES] == cell[ray * NODES + EDGE];
    is_dark = is_dark && cell[ray * NODES] >= c->depth_end;
  }
  return is_dark ? NP_SUN_CELL_DARK : is_empty ? NP_SUN_CELL_EMPTY : choose_level(cell, c->desc);
}

void NP_KERNEL(np_sun_column_fill)(np_sun_column *c) {
  follow_rays(c);
  c->node_count = 0;
  for (int32_t k = 0; k < c->lattice->size[2]; k++) {
    float cell[CELL];
    gather_cell(c, k, cell);
    const uint32_t level = choose(c, cell);
    c->cells[k] = level;
    if (level >= NP_SUN_CELL_STEEP) continue;
    c->cells[k] = (uint32_t)c->node_count << NP_SUN_CELL_LEVEL_BITS | level;
    c->node_count += np_sun_level_count_nodes(level);
  }
}

/* ---- Steep cells ---- */

/* Second differences of 17³ nodes, in tolerances, above which a cell is marched: the error is a third of them, as much
 * as the picture's whole tolerance, and marching takes ten times as long. */
static const float steep_curvature = 3.2f * NP_SUN_STEEP_TOLERANCES;

static void follow_fine_rays(const np_sun_column *c, size_t count) {
  const double half = 0.5 * c->lattice->spacing_m;
  for (int i = 0; i < NP_SUN_FINE_RAYS; i++)
    for (int j = 0; j < NP_SUN_FINE_RAYS; j++)
      follow_ray(c, c->at[0] * EDGE + 0.5 * (i - 1), c->at[1] * EDGE + 0.5 * (j - 1), half, count,
                 c->rays + (size_t)(i * NP_SUN_FINE_RAYS + j) * np_sun_column_count_fine(c));
}

void NP_KERNEL(np_sun_column_refine)(np_sun_column *c) {
  int32_t end = c->lattice->size[2];
  while (end > 0 && c->cells[end - 1] != NP_SUN_CELL_STEEP) end--;
  if (end == 0) return;
  follow_fine_rays(c, (size_t)end * NP_SUN_FINE_EDGE + 2);
  for (int32_t k = 0; k < end; k++) {
    if (c->cells[k] != NP_SUN_CELL_STEEP) continue;
    const size_t stride = np_sun_column_count_fine(c);
    const node_block b = {np_sun_column_get_fine(c, k), {NP_SUN_FINE_RAYS * stride, stride, 1}, NP_SUN_FINE_EDGE};
    if (compute_curvature(&b, 1, c->desc->rate) > steep_curvature * c->desc->tolerance) continue;
    c->cells[k] = (uint32_t)c->node_count << NP_SUN_CELL_LEVEL_BITS;
    c->node_count += np_sun_level_count_nodes(0);
  }
}

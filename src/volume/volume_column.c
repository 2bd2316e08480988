/* SPDX-License-Identifier: Apache-2.0 */
/* The densest column of a volume, for the scene key `optical_depth`.
 *
 * World-vertical lines are parallel in index space. They start at the samples of the layer in the middle of the active
 * box, across the axis closest to vertical. For oblique lines the shear widens the layer, to cover the whole vertical
 * projection of the box. Between two crossings of integer planes the trilinear field along a line is a cubic, which
 * two-point Gauss-Legendre quadrature integrates exactly. Upright lines run along samples: their sums identify the
 * densest, and only they are integrated. Adjacent columns of nodes with equal nodes, as amid a large tile, share their
 * sums. */
#include "volume/volume_private.h"

#include <float.h>
#include <string.h>

#include "core/alloc.h"
#include "volume/brick_walk.h"
#include "volume/volume_tint.h"

typedef struct volume_columns {
  const np_bricks *bricks;
  int axis, across[2]; /* index axis along the lines, and the other two axes */
  double step[3];      /* direction of a line, in index units for one metre upwards */
  double middle;       /* index of the layer along `axis` */
  int32_t low[2];      /* first line of the layer along `across` */
  int32_t size[2];
  unsigned part_count; /* levels of detail, all crossed by a line; 0: `bricks` alone */
  const np_bricks *parts[NP_TINT_PARTS_MAX];
  np_affine to_part[NP_TINT_PARTS_MAX]; /* maps from index positions of `bricks` */
  double *thread_max;                   /* largest integral of each thread */
  double *row_max;                      /* largest sum in each row of cells of upright lines */
} volume_columns;

static double get_component(np_dvec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

/* Next crossing of an integer plane after `t`, at most `t_end`. */
static double compute_crossing(const np_brick_walk *walk, double t, double t_end) {
  double crossing = t_end;
  for (int a = 0; a < 3; a++) {
    if (walk->inverse[a] == 0.0) continue;
    double at = walk->origin[a] + t * walk->direction[a], whole = np_brick_floor(at);
    double forward = walk->inverse[a] > 0.0 ? 1.0 : -1.0;
    double plane = forward > 0.0 ? whole + 1.0 : whole < at ? whole : whole - 1.0;
    double t_plane = (plane - walk->origin[a]) * walk->inverse[a];
    if (!(t_plane > t))
      t_plane = (plane + forward - walk->origin[a]) * walk->inverse[a]; /* rounding put it onto this plane */
    if (t_plane > t && t_plane < crossing) crossing = t_plane;
  }
  return crossing;
}

static double sample_span(const np_brick_walk *walk, const np_brick_span *span, double t) {
  return (double)np_brick_sample(walk->bricks, span->brick, np_brick_walk_local(walk, span, t));
}

static double integrate_span(const np_brick_walk *walk, const np_brick_span *span) {
  static const double gauss = 0.57735026918962576451; /* 1/√3 */
  if (span->brick == NP_BRICK_NONE) return (double)span->range.min * (span->t_end - span->t_begin);
  double sum = 0.0;
  for (double t = span->t_begin; t < span->t_end;) {
    double next = compute_crossing(walk, t, span->t_end), center = 0.5 * (t + next), half = 0.5 * (next - t);
    sum += half * (sample_span(walk, span, center - gauss * half) + sample_span(walk, span, center + gauss * half));
    t = next;
  }
  return sum;
}

static double integrate_line(const np_bricks *bricks, np_dvec3 origin, np_dvec3 step) {
  np_brick_walk walk;
  np_brick_span span;
  double sum = 0.0;
  np_brick_walk_start(&walk, bricks, origin, step, -DBL_MAX, DBL_MAX);
  while (np_brick_walk_next(&walk, &span)) sum += integrate_span(&walk, &span);
  return sum;
}

static double integrate_column(const volume_columns *c, int32_t u, int32_t v) {
  double at[3];
  at[c->axis] = c->middle;
  at[c->across[0]] = c->low[0] + u;
  at[c->across[1]] = c->low[1] + v;
  const np_dvec3 origin = np_dvec3_make(at[0], at[1], at[2]), step = np_dvec3_make(c->step[0], c->step[1], c->step[2]);
  if (!c->part_count) return integrate_line(c->bricks, origin, step);
  double sum = 0.0;
  for (unsigned k = 0; k < c->part_count; k++)
    sum += integrate_line(c->parts[k], np_affine_point(&c->to_part[k], origin), np_affine_vector(&c->to_part[k], step));
  return sum;
}

/* ---- Upright lines ---- */

/* Relative margin for rounding in the sum of the densest column; and the most columns that are integrated when several
 * are equal. */
static const double sum_margin = 4e-6;
enum { EQUAL_MAX = 64 };

static bool is_upright(const volume_columns *c) { return c->step[c->across[0]] == 0.0 && c->step[c->across[1]] == 0.0; }

static float get_sample(const np_bricks *b, size_t at) {
  return b->halves ? np_half_to_float(b->halves[at]) * b->scale : b->floats[at];
}

enum { EDGE = NP_BRICK_EDGE };

/* Adds the sums of a brick's samples along the axis for the lines through it; end samples count half. */
static void add_brick(const volume_columns *c, uint32_t brick, double sums[EDGE][EDGE]) {
  static const size_t strides[3] = {NP_BRICK_STRIDE_X, NP_BRICK_SAMPLES, 1};
  const size_t along = strides[c->axis], first = (size_t)brick * NP_BRICK_STRIDE;
  for (size_t i = 0; i < EDGE; i++)
    for (size_t j = 0; j < EDGE; j++) {
      const size_t at = first + i * strides[c->across[0]] + j * strides[c->across[1]];
      double sum = 0.5 * ((double)get_sample(c->bricks, at) + (double)get_sample(c->bricks, at + EDGE * along));
      for (size_t n = 1; n < EDGE; n++) sum += (double)get_sample(c->bricks, at + n * along);
      sums[i][j] += sum;
    }
}

/* Sums along the lines of a column of cells, by the trapezoidal rule, in voxels. */
static void sum_lines(const volume_columns *c, const int32_t first[2], double sums[EDGE][EDGE]) {
  const np_bricks *b = c->bricks;
  const int32_t end = b->size[c->axis];
  int32_t cell[3];
  double constant = 0.0;
  for (int n = 0; n < 2; n++) {
    const int a = c->across[n];
    cell[a] = first[n] - b->origin[a];
    if (a < 2 && b->is_periodic[a]) cell[a] = np_brick_wrap(cell[a], b->size[a]);
  }
  memset(sums, 0, EDGE * EDGE * sizeof **sums);
  for (int32_t at = 0, count; at < end; at += count) {
    cell[c->axis] = at;
    const np_brick_place place = np_bricks_get_place(b, cell);
    const uint32_t brick = np_bricks_get_brick(b, &place);
    const int32_t left = NP_BRICK_NODE_EDGE - ((at + b->lead[c->axis]) & (NP_BRICK_NODE_EDGE - 1));
    count = place.node != NP_BRICK_NONE ? 1 : left < end - at ? left : end - at;
    if (brick == NP_BRICK_NONE)
      constant += (double)(EDGE * count) * (double)np_bricks_get_range(b, &place, 0).min;
    else
      add_brick(c, brick, sums);
  }
  for (int n = 0; n < EDGE * EDGE; n++) sums[n / EDGE][n % EDGE] += constant;
}

/* First and last column of cells that hold a line. */
static int32_t get_first(const volume_columns *c, int n) { return c->low[n] >> 3; }
static int32_t count_cells(const volume_columns *c, int n) {
  return ((c->low[n] + c->size[n] - 1) >> 3) - get_first(c, n) + 1;
}

/* Called for each line of one row of cells, with its sum. */
typedef void (*line_fn)(const volume_columns *c, int32_t u, int32_t v, double sum, void *user);

/* Sums of a column of nodes, by cell along a row, reused in later columns with the same nodes. */
typedef struct node_sums {
  size_t first; /* first table entry of the column */
  bool is_known[NP_BRICK_NODE_EDGE];
  double sums[NP_BRICK_NODE_EDGE][EDGE][EDGE];
} node_sums;

static bool is_same_entry(const np_bricks *b, size_t a, size_t other) {
  if (b->table[a] != b->table[other]) return false;
  return b->table[a] != NP_BRICK_NONE || b->table_ranges[a].min == b->table_ranges[other].min;
}

static bool is_same_column(const volume_columns *c, size_t a, size_t b, size_t stride) {
  for (int32_t n = 0; n < c->bricks->table_size[c->axis]; n++)
    if (!is_same_entry(c->bricks, a + (size_t)n * stride, b + (size_t)n * stride)) return false;
  return true;
}

/* Moves to the column of nodes that contains a cell, and drops sums that are not valid in it. Returns the cell's index
 * in it. */
static int select_column(const volume_columns *c, const int32_t first[2], node_sums *known) {
  const np_bricks *b = c->bricks;
  const size_t strides[3] = {(size_t)b->table_size[1] * (size_t)b->table_size[2], (size_t)b->table_size[2], 1};
  size_t entry = 0;
  int32_t at = 0;
  for (int n = 0; n < 2; n++) {
    const int a = c->across[n];
    at = first[n] - b->origin[a];
    if (a < 2 && b->is_periodic[a]) at = np_brick_wrap(at, b->size[a]);
    at += b->lead[a];
    entry += (size_t)(at >> NP_BRICK_NODE_SHIFT) * strides[a];
  }
  if (entry != known->first && !is_same_column(c, known->first, entry, strides[c->axis]))
    memset(known->is_known, 0, sizeof known->is_known);
  known->first = entry;
  return at & (NP_BRICK_NODE_EDGE - 1);
}

/* Visits the lines of a row of cells. The row crosses each column of nodes at one cell index. */
static void visit_row(const volume_columns *c, int32_t row, line_fn visit, void *user) {
  node_sums known = {0};
  for (int32_t n = 0; n < count_cells(c, 1); n++) {
    const int32_t cell[2] = {get_first(c, 0) + row, get_first(c, 1) + n};
    const int place = select_column(c, cell, &known);
    double(*sums)[EDGE] = known.sums[place];
    if (!known.is_known[place]) sum_lines(c, cell, sums);
    known.is_known[place] = true;
    for (int32_t i = 0; i < EDGE; i++)
      for (int32_t j = 0; j < EDGE; j++) {
        const int32_t u = EDGE * cell[0] + i - c->low[0], v = EDGE * cell[1] + j - c->low[1];
        if (u >= 0 && u < c->size[0] && v >= 0 && v < c->size[1]) visit(c, u, v, sums[i][j], user);
      }
  }
}

static void add_sum(const volume_columns *c, int32_t u, int32_t v, double sum, void *user) {
  (void)c, (void)u, (void)v;
  double *largest = user;
  if (sum > *largest) *largest = sum;
}

/* Whether a row of cells crosses the same nodes as the row one node before, as amid a large tile. The first and the
 * last row may have fewer lines, and periods end anywhere. */
static bool is_repeated(const volume_columns *c, int32_t row) {
  const np_bricks *b = c->bricks;
  const size_t strides[3] = {(size_t)b->table_size[1] * (size_t)b->table_size[2], (size_t)b->table_size[2], 1};
  const int a = c->across[0];
  if (row <= NP_BRICK_NODE_EDGE || row + 1 >= count_cells(c, 0) || b->is_periodic[0] || b->is_periodic[1]) return false;
  const size_t node = (size_t)((get_first(c, 0) + row - b->origin[a] + b->lead[a]) >> NP_BRICK_NODE_SHIFT);
  const size_t first = node * strides[a], across = strides[c->across[1]];
  for (int32_t n = 0; n < b->table_size[c->across[1]]; n++)
    if (!is_same_column(c, first + (size_t)n * across, first - strides[a] + (size_t)n * across, strides[c->axis]))
      return false;
  return true;
}

static neph_result sum_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const volume_columns *c = user;
  for (size_t row = begin; row < end; row++)
    if (!is_repeated(c, (int32_t)row)) visit_row(c, (int32_t)row, add_sum, &c->row_max[row]);
  return NEPH_OK;
}

static void repeat_rows(const volume_columns *c) {
  for (int32_t row = 0; row < count_cells(c, 0); row++)
    if (is_repeated(c, row)) c->row_max[row] = c->row_max[row - NP_BRICK_NODE_EDGE];
}

typedef struct densest {
  double least, integral;
  int left;
} densest;

static void integrate_if_dense(const volume_columns *c, int32_t u, int32_t v, double sum, void *user) {
  densest *d = user;
  if (sum < d->least || d->left-- <= 0) return;
  d->integral = fmax(d->integral, integrate_column(c, u, v));
}

/* Integrates the columns with the largest sums. */
static double integrate_densest(const volume_columns *c) {
  double largest = 0.0;
  const int32_t rows = count_cells(c, 0);
  for (int32_t row = 0; row < rows; row++) largest = fmax(largest, c->row_max[row]);
  densest d = {.least = largest * (1.0 - sum_margin), .left = EQUAL_MAX};
  for (int32_t row = 0; row < rows && d.left > 0; row++)
    if (c->row_max[row] >= d.least) visit_row(c, row, integrate_if_dense, &d);
  return d.integral;
}

static neph_result measure_upright(volume_columns *c, neph_context *context, np_monitor *monitor, double *out_value_m) {
  c->row_max = np_alloc(context, (size_t)count_cells(c, 0), sizeof *c->row_max);
  if (!c->row_max) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_parallel_for(context, monitor, (size_t)count_cells(c, 0), 1, sum_rows, c);
  if (!result) repeat_rows(c);
  if (!result) *out_value_m = integrate_densest(c);
  np_alloc_free(context, c->row_max);
  return result;
}

/* ---- All lines ---- */

static neph_result integrate_rows(void *user, size_t begin, size_t end, unsigned thread) {
  const volume_columns *c = user;
  for (size_t u = begin; u < end; u++)
    for (int32_t v = 0; v < c->size[1]; v++) {
      double integral = integrate_column(c, (int32_t)u, v);
      if (integral > c->thread_max[thread]) c->thread_max[thread] = integral;
    }
  return NEPH_OK;
}

/* Sets the layer: the box, enlarged along each axis by the displacement of a line between the layer and the ends of the
 * box. */
static void set_layer(volume_columns *c, const neph_volume *volume) {
  double low = volume->active_min[c->axis], high = volume->active_max[c->axis];
  c->middle = np_brick_floor(0.5 * (low + high));
  for (int n = 0; n < 2; n++) {
    int a = c->across[n];
    double slope = fabs(c->step[a] / c->step[c->axis]);
    bool is_periodic = a < 2 && c->bricks->is_periodic[a];
    int32_t beyond = is_periodic ? 0 : (int32_t)ceil(slope * (fmax(high - c->middle, c->middle - low) + 1.0) - 1e-9);
    c->low[n] = volume->active_min[a] - beyond;
    c->size[n] = volume->active_max[a] - volume->active_min[a] + 1 + 2 * beyond;
  }
}

static neph_result set_lines(volume_columns *c, const neph_volume *volume, const np_affine *index_to_world) {
  np_affine world_to_index;
  if (!np_affine_invert(index_to_world, &world_to_index))
    return np_fail(volume->context, NEPH_ERROR_INVALID_ARGUMENT, "grid '%s': the placed transform cannot be inverted",
                   volume->name);
  np_dvec3 step = np_affine_vector(&world_to_index, np_dvec3_make(0.0, 0.0, 1.0));
  c->axis = 0;
  for (int a = 0; a < 3; a++) {
    c->step[a] = get_component(step, a);
    if (fabs(c->step[a]) > fabs(c->step[c->axis])) c->axis = a;
  }
  /* The rounding error of a right angle would make upright lines oblique. */
  for (int a = 0; a < 3; a++)
    if (fabs(c->step[a]) < 1e-12 * fabs(c->step[c->axis])) c->step[a] = 0.0;
  c->across[0] = c->axis == 0 ? 1 : 0;
  c->across[1] = c->axis == 2 ? 1 : 2;
  return NEPH_OK;
}

static neph_result integrate_all(volume_columns *c, neph_context *context, np_monitor *monitor, double *out_value_m) {
  c->thread_max = np_alloc(context, context->thread_count, sizeof *c->thread_max);
  if (!c->thread_max) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_parallel_for(context, monitor, (size_t)c->size[0], 1, integrate_rows, c);
  for (unsigned i = 0; i < context->thread_count && !result; i++) *out_value_m = fmax(*out_value_m, c->thread_max[i]);
  np_alloc_free(context, c->thread_max);
  return result;
}

/* ---- Levels of detail ---- */

/* A level with its own box; the finest level has the box of all levels. */
static neph_volume make_outline(const neph_volume *level) {
  const np_bricks *b = &level->bricks;
  neph_volume outline = {.context = level->context, .name = level->name};
  for (int a = 0; a < 3; a++) {
    outline.active_min[a] = NP_BRICK_EDGE * b->origin[a];
    outline.active_max[a] = NP_BRICK_EDGE * (b->origin[a] + b->size[a]);
  }
  return outline;
}

/* Integrates the lines through the samples of one level, over all levels. */
static neph_result measure_level(const neph_volume *volume, unsigned level, const np_affine *index_to_world,
                                 np_monitor *monitor, double *out_value_m) {
  const neph_volume *own = np_volume_get_part(volume, level);
  const neph_volume outline = make_outline(own);
  volume_columns c = {.bricks = &own->bricks, .part_count = np_volume_count_parts(volume)};
  const np_affine to_whole = np_affine_compose(&volume->world_to_index, &own->index_to_world);
  const np_affine to_world = np_affine_compose(index_to_world, &to_whole);
  for (unsigned k = 0; k < c.part_count; k++) {
    const neph_volume *part = np_volume_get_part(volume, k);
    c.parts[k] = &part->bricks;
    c.to_part[k] = np_affine_compose(&part->world_to_index, &own->index_to_world);
  }
  neph_result result = set_lines(&c, own, &to_world);
  if (result || own->bricks.brick_count == 0) return result;
  set_layer(&c, &outline);
  return integrate_all(&c, volume->context, monitor, out_value_m);
}

static neph_result measure_levels(const neph_volume *volume, const np_affine *index_to_world, np_monitor *monitor,
                                  double *out_value_m) {
  neph_result result = NEPH_OK;
  for (unsigned k = 0; k < np_volume_count_parts(volume) && !result; k++)
    result = measure_level(volume, k, index_to_world, monitor, out_value_m);
  return result;
}

neph_result np_volume_get_column_max(const neph_volume *volume, const np_affine *index_to_world, np_monitor *monitor,
                                     double *out_value_m) {
  neph_context *context = volume->context;
  volume_columns c = {.bricks = &volume->bricks};
  *out_value_m = 0.0;
  if (np_volume_has_parts(volume, NP_PARTS_OF_CELLS))
    return measure_levels(volume, index_to_world, monitor, out_value_m);
  neph_result result = set_lines(&c, volume, index_to_world);
  if (result) return result;
  set_layer(&c, volume);
  np_monitor_set_stage(monitor, "measuring columns");
  if (is_upright(&c)) return measure_upright(&c, context, monitor, out_value_m);
  return integrate_all(&c, context, monitor, out_value_m);
}

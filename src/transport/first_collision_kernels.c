/* SPDX-License-Identifier: Apache-2.0 */
/* Rays of the sun through the cells, and what each cell takes of them. Compiled once per instruction-set level.
 *
 * A ray is followed in blocks of steps, for which cells, extinction and opacity are found together. What it leaves in a
 * cell is gathered until it leaves the cell, since many threads add to the same cells. */
#include "core/isa.h"
#include "core/stable.h"
#include "transport/first_collision.h"
#include "volume/brick_walk.h"
#include "volume/places.h"

neph_result NP_KERNEL(np_first_rays_follow)(void *user, size_t begin, size_t end, unsigned thread);

enum { STEPS = NP_BRICK_LINE };

/* One cloud along the ray, with the walk over its bricks and the current or next cell. */
typedef struct cloud {
  const np_instance *volume;
  float scale[NP_FIRST_MEDIA];
  np_brick_walk walk;
  np_brick_span span;
} cloud;

/* A ray inside one active cell: its losses, losses times distance from the ray's start, and the sums of
 * np_first_surplus by length. */
typedef struct crossing {
  int32_t active;
  double lost[NP_FIRST_MEDIA], lost_at_m[NP_FIRST_MEDIA];
  double surplus_m, length_m;
} crossing;

typedef struct collision_ray {
  const np_first_rays *all;
  double start[3], exit_m;
  double cell[3], cells_per_m[3]; /* where cells are even: coordinate in cells of the start, and how it grows */
  int32_t near[3];                /* where they differ: the cell that the last step was placed in */
  double weight;                  /* cross section of the ray over a cell's share, in units of losses */
  double power[NP_FIRST_MEDIA];   /* remaining power of the ray in each medium */
  crossing crossing;
  unsigned cloud_count;
  cloud clouds[NP_INSTANCES_MAX]; /* places of a hierarchy whose boxes the ray has entered */
  np_place_queue ahead;
} collision_ray;

/* Steps that are evaluated together. Steps from `count` on lie beyond the grid. */
typedef struct collision_block {
  int count;
  double middle_m[STEPS];
  float length_m[STEPS];
  int32_t active[STEPS]; /* cell of the middle, or NP_TRANSPORT_CELL_NONE */
  float opacity[NP_FIRST_MEDIA][STEPS];
} collision_block;

/* ------------------------------------------------------------------------------------------- where the steps are */

static double compute_exit(const np_transport_grid *g, const double p[3], const double d[3]) {
  double exit = INFINITY;
  for (int a = 0; a < 3; a++) {
    if (g->is_wrapped[a] || fabs(d[a]) < 1e-12) continue;
    const double plane = d[a] > 0.0 ? np_transport_grid_get_end(g, a) : g->edge_m[a][0];
    exit = fmin(exit, (plane - p[a]) / d[a]);
  }
  return exit;
}

/* Index of the cell that holds a coordinate along an axis, clamped to the grid; a linear search that starts at
 * `near`. */
static int32_t search_cell(const np_transport_grid *g, int axis, double x, int32_t near) {
  const double *edge = g->edge_m[axis];
  x = np_transport_grid_wrap(g, axis, x);
  while (near > 0 && x < edge[near]) near--;
  while (near + 1 < g->size[axis] && x >= edge[near + 1]) near++;
  return near;
}

/* Length of the step from `t` on in a graded grid: at most half a cell, and an eighth of one at least where voxels
 * would allow less. */
static double choose_step(collision_ray *r, double t) {
  const np_transport_grid *g = r->all->grid;
  double half = INFINITY;
  for (int a = 0; a < 3; a++) {
    const double speed = fabs(r->all->direction[a]);
    if (speed < 1e-9) continue;
    r->near[a] = search_cell(g, a, r->start[a] + t * r->all->direction[a], r->near[a]);
    half = fmin(half, 0.5 * np_transport_grid_width(g, a, r->near[a]) / speed);
  }
  return fmin(half, fmax(r->all->step_m, 0.25 * half));
}

/* Places the steps from `t` on, all of one length but the last; returns where they end. */
static double place_even_steps(const collision_ray *r, double t, collision_block *b) {
  const double step = r->all->step_m;
#pragma omp simd
  for (int k = 0; k < STEPS; k++) {
    const double begin = t + k * step, left = r->exit_m - begin, length = left < step ? left : step;
    b->middle_m[k] = begin + 0.5 * length;
    b->length_m[k] = (float)length;
  }
  const double left = (r->exit_m - t) / step;
  b->count = left < STEPS ? (int)ceil(left) : STEPS;
  return t + STEPS * step;
}

static double place_steps(collision_ray *r, double t, collision_block *b) {
  b->count = 0;
  for (int k = 0; k < STEPS; k++) {
    const double step = choose_step(r, t), left = r->exit_m - t, length = left < step ? left : step;
    b->middle_m[k] = t + 0.5 * length;
    b->length_m[k] = (float)length;
    b->count += length > 0.0;
    t += length;
  }
  return t;
}

/* Cells of the steps' midpoints along an axis, clamped to the grid. */
static void locate_along(const collision_ray *r, int axis, const collision_block *b, int32_t at[STEPS]) {
  const np_transport_grid *g = r->all->grid;
  const double size = (double)g->size[axis], begin = r->cell[axis], rate = r->cells_per_m[axis];
  if (g->even_m[axis] > 0.0 && g->is_wrapped[axis]) {
#pragma omp simd
    for (int k = 0; k < STEPS; k++) {
      const double cell = begin + b->middle_m[k] * rate;
      at[k] = (int32_t)np_clamp(cell - floor(cell / size) * size, 0.0, size - 1.0);
    }
  } else if (g->even_m[axis] > 0.0) {
#pragma omp simd
    for (int k = 0; k < STEPS; k++) at[k] = (int32_t)np_clamp(begin + b->middle_m[k] * rate, 0.0, size - 1.0);
  } else {
    int32_t near = r->near[axis];
    for (int k = 0; k < STEPS; k++)
      at[k] = near = search_cell(g, axis, r->start[axis] + b->middle_m[k] * r->all->direction[axis], near);
  }
}

/* Finds the cells of all steps; false where none is active. */
static bool locate_steps(const collision_ray *r, collision_block *b) {
  const np_transport_grid *g = r->all->grid;
  const int32_t *active = g->active, columns = g->size[0], rows = g->size[1];
  int32_t at[3][STEPS], last = NP_TRANSPORT_CELL_NONE;
  for (int a = 0; a < 3; a++) locate_along(r, a, b, at[a]);
#pragma omp simd reduction(max : last)
  for (int k = 0; k < STEPS; k++) {
    b->active[k] = active[(at[2][k] * rows + at[1][k]) * columns + at[0][k]];
    last = b->active[k] > last ? b->active[k] : last;
  }
  return last >= 0;
}

/* Place of the ray in its cell at `t`, from the middle over the width. */
static double compute_offset(const collision_ray *r, int axis, double t) {
  const np_transport_grid *g = r->all->grid;
  if (g->even_m[axis] > 0.0) {
    const double cell = r->cell[axis] + t * r->cells_per_m[axis];
    return cell - floor(cell) - 0.5;
  }
  const double x = np_transport_grid_wrap(g, axis, r->start[axis] + t * r->all->direction[axis]);
  const int32_t at = search_cell(g, axis, x, r->near[axis]);
  return np_clamp((x - np_transport_grid_middle(g, axis, at)) / np_transport_grid_width(g, axis, at), -0.5, 0.5);
}

/* --------------------------------------------------------------------------------------- what the steps run through */

static void add_cloud(collision_ray *r, const np_instance *volume) {
  const double *d = r->all->direction;
  const unsigned v = np_instances_get_index(&r->all->world->clouds, volume);
  cloud *c = &r->clouds[r->cloud_count];
  c->volume = volume;
  for (unsigned m = 0; m < NP_FIRST_MEDIA; m++) c->scale[m] = r->all->media[m].scale[v];
  const np_affine *map = &c->volume->world_to_index;
  np_brick_walk_start(&c->walk, c->volume->bricks,
                      np_affine_point(map, np_dvec3_make(r->start[0], r->start[1], r->start[2])),
                      np_affine_vector(map, np_dvec3_make(d[0], d[1], d[2])), 0.0, r->exit_m);
  if (np_brick_walk_next(&c->walk, &c->span)) r->cloud_count++;
}

static void start_clouds(collision_ray *r) {
  const np_instances *clouds = &r->all->world->clouds;
  const double *d = r->all->direction;
  r->cloud_count = 0;
  np_place_queue_start(&r->ahead, clouds, np_dvec3_make(r->start[0], r->start[1], r->start[2]),
                       np_vec3_make((float)d[0], (float)d[1], (float)d[2]), r->exit_m);
  for (unsigned v = 0; v < clouds->count && !clouds->places; v++) add_cloud(r, &clouds->at[v]);
}

/* Values of a cloud, with its detail, at the middles of the steps from `first` to before `end`, all in the cell that
 * the walk is in. */
static void fill_values(const cloud *c, const collision_block *b, int first, int end, float value[STEPS]) {
  if (c->span.brick == NP_BRICK_NONE) {
    for (int k = first; k < end; k++) value[k] = c->span.range.min;
    return;
  }
  const np_vec3 begin = np_brick_walk_local(&c->walk, &c->span, b->middle_m[first]);
  const np_vec3 along =
      np_dvec3_to_float(np_dvec3_make(c->walk.direction[0], c->walk.direction[1], c->walk.direction[2]));
  float at[NP_BRICK_LINE] = {0.0f}, found[NP_BRICK_LINE];
  for (int k = first; k < end; k++) at[k - first] = (float)(b->middle_m[k] - b->middle_m[first]);
  const np_brick_ref ref = {c->volume->bricks, c->span.brick, c->span.cell};
  if (ref.bricks->detail && !ref.bricks->motion)
    np_brick_detail_sample_along(ref, begin, along, 0.0f, at, end - first, found);
  else
    np_brick_sample_along_plain(ref, begin, along, at, end - first, found);
  for (int k = first; k < end; k++) value[k] = found[k - first];
}

/* Moves on to the next cell of a cloud's bricks, which lies at infinity where the ray has left the cloud. */
static void advance(cloud *c) {
  if (!np_brick_walk_next(&c->walk, &c->span)) c->span.t_begin = INFINITY;
}

/* The first step, from `k` on, whose middle does not lie before `t`. */
static int search_first(const collision_block *b, int k, double t) {
  while (k < b->count && b->middle_m[k] < t) k++;
  return k;
}

/* Adds a cloud's depth in each step. */
static void add_depths(cloud *c, const collision_block *b, float depth[NP_FIRST_MEDIA][STEPS]) {
  float value[STEPS] = {0.0f};
  for (int end = 0; end < b->count;) {
    const int begin = search_first(b, end, c->span.t_begin);
    end = search_first(b, begin, c->span.t_end);
    if (begin < end) fill_values(c, b, begin, end, value);
    if (end < b->count) advance(c);
  }
  for (unsigned m = 0; m < NP_FIRST_MEDIA; m++)
#pragma omp simd
    for (int k = 0; k < STEPS; k++)
      depth[m][k] += c->scale[m] * c->volume->extinction_per_value * b->length_m[k] * value[k];
}

/* Adds the optical depths of a hierarchy's clouds that begin before the block's end, and drops those that end before
 * it. */
static void pass_places(collision_ray *r, const collision_block *b, float depth[NP_FIRST_MEDIA][STEPS]) {
  const double end = b->count > 0 ? b->middle_m[b->count - 1] : -1.0;
  for (unsigned i = 0; i < r->cloud_count;) {
    if (isinf(r->clouds[i].span.t_begin))
      r->clouds[i] = r->clouds[--r->cloud_count];
    else
      i++;
  }
  while (np_place_queue_get_next(&r->ahead) <= end && r->cloud_count < NP_INSTANCES_MAX) {
    const unsigned before = r->cloud_count;
    add_cloud(r, np_place_queue_take(&r->ahead));
    if (r->cloud_count == before) continue;
    add_depths(&r->clouds[before], b, depth);
    if (isinf(r->clouds[before].span.t_begin)) r->cloud_count--;
  }
}

static void compute_opacities(collision_ray *r, collision_block *b) {
  float depth[NP_FIRST_MEDIA][STEPS] = {{0.0f}};
  for (unsigned i = 0; i < r->cloud_count; i++) add_depths(&r->clouds[i], b, depth);
  if (r->ahead.places) pass_places(r, b, depth);
  for (unsigned m = 0; m < NP_FIRST_MEDIA; m++)
#pragma omp simd
    for (int k = 0; k < STEPS; k++) b->opacity[m][k] = np_opacity(depth[m][k]);
}

/* ------------------------------------------------------------------------------------------- what the cells take */

static void add(int64_t *sum, double units) { (void)__atomic_fetch_add(sum, (int64_t)units, __ATOMIC_RELAXED); }

/* Mean place on the ray of the first collisions in a cell. */
static void count_loss(const collision_ray *r, unsigned medium) {
  const double lost = r->crossing.lost[medium];
  if (!(lost > 0.0)) return;
  const double mean_m = r->crossing.lost_at_m[medium] / lost;
  np_first_loss *l = &r->all->media[medium].losses[r->crossing.active];
  add(&l->sum, lost + 0.5);
  for (int a = 0; a < 3; a++)
    if (r->all->grid->size[a] > 1) add(&l->moment[a], compute_offset(r, a, mean_m) * lost);
}

/* Ends the crossing of a cell, and begins the crossing of the next one. */
static void change_cell(collision_ray *r, int32_t active) {
  const crossing *c = &r->crossing;
  if (c->active >= 0) {
    for (unsigned m = 0; m < r->all->media_count; m++) count_loss(r, m);
    if (r->all->surpluses) {
      np_first_surplus *s = &r->all->surpluses[c->active];
      add(&s->sum, c->surplus_m / r->all->step_m);
      add(&s->length, c->length_m / r->all->step_m * r->weight * 0x1p32);
    }
  }
  r->crossing = (crossing){.active = active};
}

/* The difference of the two media's transmittances is taken in the middle of the step. */
static void cross_step(collision_ray *r, const collision_block *b, int k) {
  crossing *c = &r->crossing;
  double middle[NP_FIRST_MEDIA];
  for (unsigned m = 0; m < NP_FIRST_MEDIA; m++) {
    const double lost = (double)b->opacity[m][k] * r->power[m];
    c->lost[m] += lost;
    c->lost_at_m[m] += lost * b->middle_m[k];
    middle[m] = r->power[m] - 0.5 * lost;
    r->power[m] -= lost;
  }
  const double length = (double)b->length_m[k], beyond = middle[1] - middle[0];
  c->surplus_m += beyond > 0.0 ? length * beyond : 0.0;
  c->length_m += length;
}

/* Sets the power of a ray that enters the cells of one tile from its neighbours, which hold none. */
static void dim(collision_ray *r, double t) {
  static const float depth_max = 16.0f;
  const np_first_rays *all = r->all;
  const double *d = all->direction;
  const np_dvec3 position = np_dvec3_make(r->start[0] + t * d[0], r->start[1] + t * d[1], r->start[2] + t * d[2]);
  const np_vec3 to_sun = np_vec3_make((float)-d[0], (float)-d[1], (float)-d[2]);
  for (unsigned m = 0; m < all->media_count; m++) {
    const float depth = all->depths->get(all->depths->user, position, to_sun, all->media[m].scale, depth_max);
    r->power[m] = r->weight * 0x1p32 * (double)np_transmittance(depth);
  }
}

/* False where the ray has ended: too little is left of it. */
static bool cross_steps(collision_ray *r, const collision_block *b) {
  const double least = r->weight * 0x1p14;
  for (int k = 0; k < b->count; k++) {
    if (r->all->depths && b->active[k] >= 0 && r->crossing.active < 0)
      dim(r, b->middle_m[k] - 0.5 * (double)b->length_m[k]);
    if (b->active[k] != r->crossing.active) change_cell(r, b->active[k]);
    if (b->active[k] >= 0) cross_step(r, b, k);
    if (!(r->power[0] > least || r->power[1] > least)) return false;
  }
  return true;
}

static void follow_ray(collision_ray *r) {
  collision_block b;
  bool is_left = true;
  for (double t = 0.0; is_left && t < r->exit_m;) {
    t = r->all->has_even_steps ? place_even_steps(r, t, &b) : place_steps(r, t, &b);
    if (locate_steps(r, &b)) {
      compute_opacities(r, &b);
      is_left = cross_steps(r, &b);
    } else {
      change_cell(r, NP_TRANSPORT_CELL_NONE);
    }
  }
  change_cell(r, NP_TRANSPORT_CELL_NONE);
}

static double fraction(double x) { return x - floor(x); }

/* Start of the n-th ray, row by row in a serpentine order, so that neighbouring rays share the processor's cache. */
static void place_start(const np_first_rays *all, int axis, size_t number, double start[3]) {
  const np_transport_grid *g = all->grid;
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  const size_t row = number / all->columns, column = number % all->columns;
  const double across = ((double)column + fraction(0.5 + 0.6180339887498949 * (double)row)) / (double)all->columns;
  const double along = ((double)row + 0.5) / (double)all->rows;
  start[axis] = all->direction[axis] < 0.0 ? np_transport_grid_get_end(g, axis) : g->edge_m[axis][0];
  start[b] = g->edge_m[b][0] + across * (np_transport_grid_get_end(g, b) - g->edge_m[b][0]);
  start[c] = g->edge_m[c][0] + along * (np_transport_grid_get_end(g, c) - g->edge_m[c][0]);
}

static void start_ray(collision_ray *r, const np_first_rays *all, int axis, size_t number) {
  const np_transport_grid *g = all->grid;
  r->all = all;
  place_start(all, axis, number, r->start);
  r->exit_m = compute_exit(g, r->start, all->direction);
  for (int a = 0; a < 3; a++) {
    const double per_m = g->even_m[a] > 0.0 ? 1.0 / g->even_m[a] : 0.0;
    const int32_t at = np_transport_grid_locate(g, a, r->start[a]);
    r->near[a] = at < 0 ? 0 : at < g->size[a] ? at : g->size[a] - 1;
    r->cell[a] = (r->start[a] - g->edge_m[a][0]) * per_m;
    r->cells_per_m[a] = all->direction[a] * per_m;
  }
  /* Irradiance on the face times area, over the mean area of a cell's face. */
  const double face_cells = (double)g->used[(axis + 1) % 3] * (double)g->used[(axis + 2) % 3];
  r->weight = fabs(all->direction[axis]) * face_cells / ((double)all->rows * (double)all->columns);
  for (unsigned m = 0; m < NP_FIRST_MEDIA; m++) r->power[m] = m < all->media_count ? r->weight * 0x1p32 : 0.0;
  r->crossing = (crossing){.active = NP_TRANSPORT_CELL_NONE};
  start_clouds(r);
}

/* Traces rays [begin, end) of the present face. */
neph_result NP_KERNEL(np_first_rays_follow)(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_first_rays *all = user;
  collision_ray r;
  for (size_t number = begin; number < end; number++) {
    if (np_monitor_is_cancelled(all->monitor)) return NEPH_ERROR_CANCELLED;
    start_ray(&r, all, all->face_axis, number);
    follow_ray(&r);
  }
  return NEPH_OK;
}

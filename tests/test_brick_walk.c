/* SPDX-License-Identifier: Apache-2.0 */
#include "test_grids.h"

#include "volume/brick_walk.h"

#include <float.h>

/* No ray meets more cells than the table has planes, were nothing skipped. */
static int count_planes(const np_bricks *bricks) { return bricks->size[0] + bricks->size[1] + bricks->size[2] + 3; }

static np_dvec3 compute_position(np_dvec3 origin, np_dvec3 direction, double t) {
  return np_dvec3_add(origin, np_dvec3_scale(direction, t));
}

typedef struct made {
  neph_context *context;
  np_bricks bricks;
} made;

static void make(made *m, uint64_t seed, neph_precision precision) {
  np_sparse_grid grid;
  m->context = test_context_create(1, NULL);
  test_make_grid(m->context, seed, 4, &grid);
  assert_int_equal(np_bricks_build(m->context, &grid, precision, NULL, NULL, &m->bricks), NEPH_OK);
  np_sparse_grid_clear(&grid);
}

static void clear(made *m) {
  np_bricks_clear(&m->bricks);
  neph_context_destroy(m->context);
}

/* ---- Spans tile the ray ---- */

typedef struct ray {
  np_dvec3 origin, direction;
  double t_begin, t_end;
} ray;

/* Ray from a point around the grid to one inside; some along axes and diagonals, from corners, or of odd length. */
static ray make_ray(np_random *random, int number) {
  double length = exp(test_random_in(random, -8.0, 8.0));
  np_dvec3 from = {test_random_in(random, -300, 300), test_random_in(random, -300, 300),
                   test_random_in(random, -300, 300)};
  np_dvec3 to = {test_random_in(random, -32, 32), test_random_in(random, -32, 32), test_random_in(random, -32, 32)};
  if (number % 5 == 1) from.y = to.y, from.z = to.z;
  if (number % 5 == 2) from.x = to.x = 8.0 * rint(to.x / 8.0), from.y = to.y = 8.0 * rint(to.y / 8.0);
  if (number % 5 == 3) from = np_dvec3_make(64, 64, 64), to = np_dvec3_make(0, 0, 0);
  if (number % 5 == 4) from = np_dvec3_scale(to, 0.5);
  np_dvec3 direction = np_dvec3_scale(np_dvec3_subtract(to, from), 1.0 / length);
  return (ray){from, direction, number % 7 ? 0.0 : -length, 3.0 * length};
}

/* Value at `t` by the walk: the value of the span that contains it, or 0 in a gap. Spans must be in order. */
static double sample_by_walk(const np_brick_walk *walk, const np_brick_span *spans, int count, double t) {
  for (int i = 0; i < count; i++) {
    if (t < spans[i].t_begin || t >= spans[i].t_end) continue;
    if (spans[i].brick == NP_BRICK_NONE) return (double)spans[i].range.min;
    return (double)np_brick_sample(walk->bricks, spans[i].brick, np_brick_walk_local(walk, &spans[i], t));
  }
  return 0.0;
}

enum { SPANS_MAX = 1024, SAMPLES = 400, RAYS = 2000 };

static int walk_ray(np_brick_walk *walk, const np_bricks *bricks, const ray *r, np_brick_span spans[SPANS_MAX]) {
  int count = 0;
  double last = r->t_begin;
  np_brick_walk_start(walk, bricks, r->origin, r->direction, r->t_begin, r->t_end);
  while (np_brick_walk_next(walk, &spans[count])) {
    const np_brick_span *span = &spans[count++];
    assert_true(count < SPANS_MAX && count <= count_planes(bricks));
    assert_true(last <= span->t_begin && span->t_begin < span->t_end && span->t_end <= r->t_end);
    assert_false(span->range.min == 0.0f && span->range.max == 0.0f);
    last = span->t_end;
  }
  return count;
}

/* Any point of any ray has the value that a direct look-up gives. At a face either neighbour answers, and both hold the
 * same samples there; 1e-4 is the change of the field over the rounding of a position 300 voxels away in float
 * fractions, with slopes up to 1 per voxel and values up to 1. */
static void spans_tile_every_ray(void **state) {
  (void)state;
  static np_brick_span spans[SPANS_MAX];
  made m;
  make(&m, 11, NEPH_PRECISION_FLOAT);
  np_random random = np_random_start(11, 0, 0, 0, 0);
  for (int i = 0; i < RAYS; i++) {
    ray r = make_ray(&random, i);
    np_brick_walk walk;
    int count = walk_ray(&walk, &m.bricks, &r, spans);
    for (int s = 0; s < SAMPLES; s++) {
      double t = r.t_begin + (r.t_end - r.t_begin) * (s + 0.5) / SAMPLES;
      double expected = (double)np_bricks_sample(&m.bricks, compute_position(r.origin, r.direction, t));
      assert_near(sample_by_walk(&walk, spans, count, t), expected, 1e-4);
    }
  }
  clear(&m);
}

/* One tile in bricks. */
typedef struct tile_made {
  neph_context *context;
  np_sparse_grid grid;
  np_bricks bricks;
} tile_made;

static tile_made make_tile(int32_t origin, int32_t edge, float value, float background) {
  tile_made m = {.context = test_context_create(1, NULL)};
  assert_int_equal(np_sparse_grid_init(m.context, "tile", &m.grid), NEPH_OK);
  m.grid.background = background;
  (void)np_sparse_grid_add_tile(&m.grid, (const int32_t[3]){origin, origin, origin}, edge, value, true);
  assert_int_equal(np_bricks_build(m.context, &m.grid, NEPH_PRECISION_FLOAT, NULL, NULL, &m.bricks), NEPH_OK);
  return m;
}

static void clear_tile(tile_made *m) {
  np_bricks_clear(&m->bricks);
  np_sparse_grid_clear(&m->grid);
  neph_context_destroy(m->context);
}

/* A full grid has nothing to skip: spans join without a gap and add up to the way through the table. */
static void spans_join_where_nothing_is_empty(void **state) {
  (void)state;
  tile_made m = make_tile(-128, 128, 1.0f, 0.5f);
  np_brick_walk walk;
  np_brick_span span;
  np_random random = np_random_start(5, 0, 0, 0, 0);
  for (int i = 0; i < RAYS; i++) {
    ray r = make_ray(&random, i);
    np_brick_walk_start(&walk, &m.bricks, r.origin, r.direction, r.t_begin, r.t_end);
    double t = walk.t, t_end = walk.t_end;
    while (np_brick_walk_next(&walk, &span)) {
      assert_true(span.t_begin == t);
      t = span.t_end;
    }
    assert_true(t == t_end);
  }
  clear_tile(&m);
}

/* A filled block of 1024 voxels, and its rim, of which cells are interpolated: a ray through the middle meets as many
 * spans as nodes of 128, and in the first and the last of them a brick each and the cells up to the next group of four
 * and of sixteen; cell by cell there were 130. */
static void a_constant_is_passed_in_blocks(void **state) {
  (void)state;
  tile_made m = make_tile(0, 1024, 2.0f, 0.0f);
  np_brick_walk walk;
  np_brick_span span;
  int count = 0;
  double depth = 0.0;
  np_brick_walk_start(&walk, &m.bricks, np_dvec3_make(-100, 500.5, 500.5), np_dvec3_make(1, 0, 0), 0.0, 2000.0);
  for (; np_brick_walk_next(&walk, &span); count++)
    if (span.brick == NP_BRICK_NONE) depth += (double)span.range.min * (span.t_end - span.t_begin);
  assert_in_range(count, 10, 30);
  assert_true(depth == 2.0 * 1016.0); /* all but the last cell, which a brick answers for */
  clear_tile(&m);
}

/* The cell of a span is where its middle lies; that of a constant, which may fill many, where it begins. */
static void spans_lie_in_their_cells(void **state) {
  (void)state;
  static np_brick_span spans[SPANS_MAX];
  made m;
  make(&m, 12, NEPH_PRECISION_HALF);
  np_random random = np_random_start(12, 0, 0, 0, 0);
  for (int i = 0; i < RAYS; i++) {
    ray r = make_ray(&random, i);
    np_brick_walk walk;
    int count = walk_ray(&walk, &m.bricks, &r, spans);
    for (int s = 0; s < count; s++) {
      const double middle = 0.5 * (spans[s].t_begin + spans[s].t_end);
      const double t = spans[s].brick == NP_BRICK_NONE ? spans[s].t_begin : middle;
      np_vec3 local = np_brick_walk_local(&walk, &spans[s], t);
      const float place[3] = {local.x, local.y, local.z};
      for (int a = 0; a < 3; a++) assert_true(place[a] > -1e-5f && place[a] < 8.00001f);
    }
  }
  clear(&m);
}

/* A local place a million voxels from index 0 is still good to the rounding of a float below 8. */
static void nothing_is_lost_far_from_the_origin(void **state) {
  (void)state;
  neph_context *context = test_context_create(1, NULL);
  np_sparse_grid grid;
  np_bricks bricks;
  np_brick_walk walk;
  np_brick_span span;
  const int32_t far = 1 << 20;
  assert_int_equal(np_sparse_grid_init(context, "far", &grid), NEPH_OK);
  np_leaf *leaf = np_sparse_grid_add_leaf(&grid, (const int32_t[3]){far, far, far});
  for (int n = 0; n < NP_LEAF_SIZE; n++) leaf->values[n] = 1.0f;
  assert_int_equal(np_bricks_build(context, &grid, NEPH_PRECISION_FLOAT, NULL, NULL, &bricks), NEPH_OK);
  np_dvec3 target = np_dvec3_make(far + 3.7, far + 2.3, far + 5.1), origin = np_dvec3_make(0, -5, 7);
  np_brick_walk_start(&walk, &bricks, origin, np_dvec3_subtract(target, origin), 0.0, 2.0);
  bool is_met = false;
  while (np_brick_walk_next(&walk, &span)) {
    if (span.cell[0] != far / 8 || span.cell[1] != far / 8 || span.cell[2] != far / 8) continue;
    np_vec3 local = np_brick_walk_local(&walk, &span, 1.0);
    assert_near(local.x, 3.7, 1e-6);
    assert_near(local.y, 2.3, 1e-6);
    assert_near(local.z, 5.1, 1e-6);
    is_met = true;
  }
  assert_true(is_met);
  np_bricks_clear(&bricks);
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

/* ---- Hostile rays ---- */

/* All combinations of nasty numbers end, after no more spans than there are planes. */
static void every_walk_ends(void **state) {
  (void)state;
  static const double nasty[] = {0.0,      -0.0,  1.0,  -1.0,   8.0,      1e-300,    -1e-300,
                                 4.9e-324, 1e300, 1e18, -1e300, INFINITY, -INFINITY, NAN};
  enum { N = sizeof nasty / sizeof *nasty };
  made m;
  make(&m, 13, NEPH_PRECISION_HALF);
  np_brick_walk walk;
  np_brick_span span;
  for (int i = 0; i < N * N * N * N; i++) {
    double a = nasty[i % N], b = nasty[i / N % N], c = nasty[i / N / N % N], d = nasty[i / N / N / N];
    int count = 0;
    np_brick_walk_start(&walk, &m.bricks, np_dvec3_make(a, b, 3.0), np_dvec3_make(c, d, b), -DBL_MAX, INFINITY);
    while (np_brick_walk_next(&walk, &span)) assert_true(++count <= count_planes(&m.bricks));
    np_brick_walk_start(&walk, &m.bricks, np_dvec3_make(1.0, b, a), np_dvec3_make(d, 0.5, -1.0), c, d);
    while (np_brick_walk_next(&walk, &span)) assert_true(++count <= 2 * count_planes(&m.bricks));
  }
  clear(&m);
}

static void what_is_not_a_number_makes_a_walk_empty(void **state) {
  (void)state;
  made m;
  make(&m, 13, NEPH_PRECISION_HALF);
  const np_dvec3 good = {1, 1, 1};
  np_brick_walk walk;
  np_brick_span span;
  for (int n = 0; n < 8; n++) {
    double numbers[8] = {1, 1, 1, 1, 1, 1, -10, 10};
    numbers[n] = NAN;
    np_brick_walk_start(&walk, &m.bricks, np_dvec3_make(numbers[0], numbers[1], numbers[2]),
                        np_dvec3_make(numbers[3], numbers[4], numbers[5]), numbers[6], numbers[7]);
    assert_false(np_brick_walk_next(&walk, &span));
  }
  np_brick_walk_start(&walk, &m.bricks, good, good, -10, 10);
  assert_true(np_brick_walk_next(&walk, &span));
  clear(&m);
}

/* ---- Periodic ---- */

static float wave(int i, int j, int k) { return (float)((i * 7 + j * 3 + k * 5) % 11 + 1); }

/* Trilinear interpolation of samples that repeat every 5 along i and 3 along j, and are 0 outside 0 … 3 along k. */
static double sample_wave(np_dvec3 at) {
  double sum = 0;
  int i = (int)floor(at.x), j = (int)floor(at.y), k = (int)floor(at.z);
  for (int n = 0; n < 8; n++) {
    int a = i + (n & 1), b = j + (n >> 1 & 1), c = k + (n >> 2);
    double weight = (1 - fabs(at.x - a)) * (1 - fabs(at.y - b)) * (1 - fabs(at.z - c));
    if (c >= 0 && c < 4) sum += weight * (double)wave(((a % 5) + 5) % 5, ((b % 3) + 3) % 3, c);
  }
  return sum;
}

static neph_volume *make_periodic(neph_context *context) {
  float values[5 * 3 * 4];
  for (int k = 0; k < 4; k++)
    for (int j = 0; j < 3; j++)
      for (int i = 0; i < 5; i++) values[(k * 3 + j) * 5 + i] = wave(i, j, k);
  neph_volume_dense_desc desc = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  desc.size[0] = 5, desc.size[1] = 3, desc.size[2] = 4;
  desc.values = values;
  desc.is_periodic_x = desc.is_periodic_y = true;
  desc.precision = NEPH_PRECISION_FLOAT;
  neph_volume *volume;
  assert_int_equal(neph_volume_create_dense(context, &desc, &volume), NEPH_OK);
  return volume;
}

/* Sizes that are no multiples of 8 repeat all the same, to both sides, in look-ups and along rays. 2e-5: twelve times
 * the rounding of 11 in float, for slopes up to 10 per voxel and places rounded at 8. */
static void periodic_volumes_repeat(void **state) {
  (void)state;
  static np_brick_span spans[SPANS_MAX];
  neph_context *context = test_context_create(1, NULL);
  neph_volume *volume = make_periodic(context);
  np_random random = np_random_start(2, 0, 0, 0, 0);
  for (int i = 0; i < 1000; i++) {
    ray r = {{test_random_in(&random, -50, 50), test_random_in(&random, -50, 50), 2.0},
             {test_random_in(&random, -50, 50), test_random_in(&random, -50, 50), test_random_in(&random, -1, 1)},
             0.0,
             3.0};
    np_brick_walk walk;
    int count = 0;
    np_brick_walk_start(&walk, &volume->bricks, r.origin, r.direction, r.t_begin, r.t_end);
    while (np_brick_walk_next(&walk, &spans[count])) count++;
    for (int s = 0; s < 20; s++) {
      double t = (s + 0.5) * 0.15;
      np_dvec3 at = compute_position(r.origin, r.direction, t);
      assert_near(np_bricks_sample(&volume->bricks, at), sample_wave(at), 2e-5);
      assert_near(sample_by_walk(&walk, spans, count, t), sample_wave(at), 2e-5);
    }
  }
  neph_volume_release(volume);
  neph_context_destroy(context);
}

/* A ray that never leaves the slab ends where periodic volumes do. */
static void endless_rays_in_periodic_volumes_end(void **state) {
  (void)state;
  neph_context *context = test_context_create(1, NULL);
  neph_volume *volume = make_periodic(context);
  np_brick_walk walk;
  np_brick_span span;
  int64_t count = 0;
  np_brick_walk_start(&walk, &volume->bricks, np_dvec3_make(0, 0, 1), np_dvec3_make(1, 0, 0), 0.0, INFINITY);
  while (np_brick_walk_next(&walk, &span)) count++;
  assert_int_equal(count, (int64_t)(NP_BRICK_FAR / NP_BRICK_EDGE));
  assert_true(span.t_end == NP_BRICK_FAR);
  neph_volume_release(volume);
  neph_context_destroy(context);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(spans_tile_every_ray),
      cmocka_unit_test(spans_join_where_nothing_is_empty),
      cmocka_unit_test(a_constant_is_passed_in_blocks),
      cmocka_unit_test(spans_lie_in_their_cells),
      cmocka_unit_test(nothing_is_lost_far_from_the_origin),
      cmocka_unit_test(every_walk_ends),
      cmocka_unit_test(what_is_not_a_number_makes_a_walk_empty),
      cmocka_unit_test(periodic_volumes_repeat),
      cmocka_unit_test(endless_rays_in_periodic_volumes_end),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

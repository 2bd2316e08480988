/* SPDX-License-Identifier: Apache-2.0 */
/* Bricks that move: look-ups against the formula, ranges that hold whatever is looked up, the same bits for any number
 * of threads, and files that name velocities in each way. */
#include "core/random.h"
#include "test_rays.h"
#include "test_velocity_files.h"
#include "volume/brick_motion.h"
#include "volume/tracking.h"

static int set_up(void **state) { return test_set_up(state, 3, "motion.vdb"); }

enum { POINTS = 20000 };

/* A ball that is sheared as it moves, by up to eight voxels either way. */
static const test_velocity ball = {
    .names = {"vel"}, .radius = 17.0, .value = 2.0f, .at = {40.0f, -25.0f, 10.0f}, .shear = 4.0f};
static const double exposure_s = 0.1;

typedef struct moving_ball {
  np_sparse_grid grids[4];
  neph_volume *volume;
  np_moving_bricks *moving;
} moving_ball;

static void make_ball(neph_context *context, const test_velocity *recipe, moving_ball *out) {
  test_velocity_make(context, recipe, out->grids);
  for (int g = 0; g < 4; g++) np_sparse_grid_sort(&out->grids[g]);
  assert_int_equal(np_volume_create_from_grid(context, &out->grids[0], NEPH_PRECISION_HALF, NULL, &out->volume),
                   NEPH_OK);
  const np_brick_motion_desc desc = {.rest = &out->volume->bricks,
                                     .index_to_file = out->volume->index_to_world,
                                     .velocity = &out->grids[1],
                                     .level_count = 1,
                                     .scale = 1.0,
                                     .begin_s = -exposure_s,
                                     .end_s = exposure_s};
  assert_int_equal(np_moving_bricks_build(context, &desc, NULL, &out->moving), NEPH_OK);
}

static void clear_ball(moving_ball *b) {
  np_moving_bricks_destroy(b->moving);
  neph_volume_release(b->volume);
  for (int g = 0; g < 4; g++) np_sparse_grid_clear(&b->grids[g]);
}

static np_bricks get_moment(const moving_ball *b, np_brick_motion *motion, double time_s) {
  np_bricks bricks = b->moving->bricks;
  *motion = b->moving->motion;
  motion->time_s = (float)time_s;
  bricks.motion = motion;
  return bricks;
}

/* Velocities are looked up by their trilinear interpolant: linear ones exactly, but for halves, 2⁻¹¹ of
 * up to 108 voxels a second over 0.1 s, and a value that changes by 0.24 a voxel. */
static void values_are_those_of_the_way_back(void **state) {
  test_fixture *f = *state;
  moving_ball b;
  make_ball(f->context, &ball, &b);
  np_random random = np_random_start(1, 0, 0, 0, 0);
  for (int n = 0; n < POINTS; n++) {
    np_brick_motion motion;
    const double time_s = exposure_s * (2.0 * np_random_double(&random) - 1.0);
    const np_bricks bricks = get_moment(&b, &motion, time_s);
    double at[3];
    for (int a = 0; a < 3; a++) at[a] = 18.0 * np_random_double(&random) - 9.0; /* all corners are active */
    const double velocity[3] = {(double)ball.at[0] + (double)ball.shear * at[1], (double)ball.at[1],
                                (double)ball.at[2]};
    const np_dvec3 back =
        np_dvec3_make(at[0] - time_s * velocity[0], at[1] - time_s * velocity[1], at[2] - time_s * velocity[2]);
    const double expected = (double)np_bricks_sample(&b.volume->bricks, back);
    assert_near((double)np_bricks_sample(&bricks, np_dvec3_make(at[0], at[1], at[2])), expected, 2e-3);
  }
  clear_ball(&b);
}

/* Along rays through everything: no value is outside of its cell's range, and what is not walked through is 0. */
static void ranges_hold_all_values(void **state) {
  test_fixture *f = *state;
  moving_ball b;
  make_ball(f->context, &ball, &b);
  np_random random = np_random_start(2, 0, 0, 0, 0);
  for (int n = 0; n < POINTS / 100; n++) {
    np_brick_motion motion;
    const np_bricks bricks = get_moment(&b, &motion, exposure_s * (2.0 * np_random_double(&random) - 1.0));
    double from[3], along[3];
    for (int a = 0; a < 3; a++) {
      from[a] = 60.0 * np_random_double(&random) - 30.0;
      along[a] = np_random_double(&random) - 0.5;
    }
    const np_dvec3 origin = np_dvec3_make(from[0], from[1], from[2]),
                   direction = np_dvec3_make(along[0], along[1], along[2]);
    np_brick_walk walk;
    np_brick_span span;
    double end = 0.0;
    np_brick_walk_start(&walk, &bricks, origin, direction, 0.0, 200.0);
    while (np_brick_walk_next(&walk, &span)) {
      for (double t = end; t < span.t_begin; t += 0.5)
        assert_near((double)np_bricks_sample(&bricks, np_dvec3_add(origin, np_dvec3_scale(direction, t))), 0.0, 0.0);
      for (int k = 0; k < 32 && span.brick != NP_BRICK_NONE; k++) {
        const double t = span.t_begin + (span.t_end - span.t_begin) * k / 32.0;
        const float value = np_brick_eval(&bricks, span.brick, span.cell, np_brick_walk_local(&walk, &span, t));
        assert_true(value >= span.range.min && value <= span.range.max);
      }
      end = span.t_end;
    }
  }
  clear_ball(&b);
}

/* A rim that moves out is continued: an even velocity carries all of the ball along, to the error of halves. */
static void nothing_is_lost_at_the_rim(void **state) {
  test_fixture *f = *state;
  test_velocity even = ball;
  even.shear = 0.0f;
  moving_ball b;
  make_ball(f->context, &even, &b);
  for (int k = 0; k < 3; k++) {
    np_brick_motion motion;
    const double time_s = exposure_s * (k - 1);
    const np_bricks bricks = get_moment(&b, &motion, time_s);
    for (double x = -24.0; x < 24.0; x += 1.7)
      for (double y = -24.0; y < 24.0; y += 1.7)
        for (double z = -24.0; z < 24.0; z += 1.7) {
          const np_dvec3 back = np_dvec3_make(x - time_s * (double)even.at[0], y - time_s * (double)even.at[1],
                                              z - time_s * (double)even.at[2]);
          assert_near((double)np_bricks_sample(&bricks, np_dvec3_make(x, y, z)),
                      (double)np_bricks_sample(&b.volume->bricks, back), 2e-3);
        }
  }
  clear_ball(&b);
}

/* The mean along a part of a cell by two points a voxel, against a fine sum: the kinks of what is looked up lie between
 * the voxels' faces. */
static void means_are_close(void **state) {
  test_fixture *f = *state;
  moving_ball b;
  make_ball(f->context, &ball, &b);
  np_brick_motion motion;
  const np_bricks bricks = get_moment(&b, &motion, 0.077);
  np_random random = np_random_start(3, 0, 0, 0, 0);
  double worst = 0.0;
  for (int n = 0; n < 300; n++) {
    const uint32_t brick = (uint32_t)(np_random_double(&random) * (double)bricks.brick_count);
    const np_vec3 begin = np_vec3_make(8.0f * np_random_float(&random), 8.0f * np_random_float(&random), 0.0f),
                  along = np_vec3_make(8.0f * np_random_float(&random) - begin.x, 1.0f, 8.0f);
    double sum = 0.0;
    for (int k = 0; k < 1000; k++)
      sum += (double)np_brick_eval(&bricks, brick, motion.cells[brick],
                                   np_vec3_add(begin, np_vec3_scale(along, ((float)k + 0.5f) / 1000.0f)));
    worst = fmax(worst, fabs((double)np_track_mean(&bricks, brick, motion.cells[brick], begin, along) - sum / 1000.0));
  }
  assert_true(worst < 4e-3); /* values are at most 2 */
  clear_ball(&b);
}

static void bits_are_those_of_any_threads(void **state) {
  test_fixture *f = *state;
  test_log log;
  test_log_start(&log);
  neph_context *single = test_context_create(1, &log);
  moving_ball a, b;
  make_ball(f->context, &ball, &a);
  make_ball(single, &ball, &b);
  const np_bricks *x = &a.moving->bricks, *y = &b.moving->bricks;
  assert_int_equal(x->brick_count, y->brick_count);
  assert_int_equal(x->node_count, y->node_count);
  assert_memory_equal(x->nodes, y->nodes, x->node_count * sizeof *x->nodes);
  assert_memory_equal(a.moving->cells, b.moving->cells, x->brick_count * sizeof *a.moving->cells);
  for (size_t n = 0; n < 3 * x->brick_count; n++) /* the stride leaves room behind each */
    assert_memory_equal(a.moving->velocity + n * NP_BRICK_STRIDE, b.moving->velocity + n * NP_BRICK_STRIDE,
                        NP_BRICK_VOLUME * sizeof(uint16_t));
  clear_ball(&a);
  clear_ball(&b);
  neph_context_destroy(single);
}

/* ---- Files ---- */

static neph_result load_velocity(const test_fixture *f, const char *name, np_sparse_grid out[3], bool *out_is_found) {
  const np_vector_request request = {NP_VECTOR_VELOCITY, name, NEPH_IMPORT_REFUSE};
  return np_volume_load_vector(f->context, f->path, &request, NULL, out, out_is_found);
}

static void names_that_are_found(void **state) {
  test_fixture *f = *state;
  static const char *const names[][3] = {{"vel"},
                                         {"v"},
                                         {"velocity"},
                                         {"velx", "vely", "velz"},
                                         {"vel.x", "vel.y", "vel.z"},
                                         {"velocity_x", "velocity_y", "velocity_z"}};
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    test_velocity v = {.half = 3, .value = 1.0f, .at = {1.0f, 2.0f, 3.0f}};
    memcpy(v.names, names[i], sizeof v.names);
    test_velocity_write(f->context, f->path, &v);
    np_sparse_grid velocity[3];
    bool is_found;
    assert_int_equal(load_velocity(f, NULL, velocity, &is_found), NEPH_OK);
    assert_true(is_found);
    for (int a = 0; a < 3; a++) {
      np_grid_extent extent;
      assert_true(np_sparse_grid_measure(&velocity[a], &extent));
      assert_near((double)extent.value_max, 1.0 + a, 0.0);
      assert_int_equal(extent.max[0], 3);
      np_sparse_grid_clear(&velocity[a]);
    }
  }
}

static void a_name_that_is_not_there(void **state) {
  test_fixture *f = *state;
  const test_velocity still = {.half = 3, .value = 1.0f};
  test_velocity_write(f->context, f->path, &still);
  np_sparse_grid velocity[3];
  bool is_found;
  assert_int_equal(load_velocity(f, NULL, velocity, &is_found), NEPH_OK);
  assert_false(is_found);
  test_log_clear(&f->log);
  assert_int_equal(load_velocity(f, "speed", velocity, &is_found), NEPH_ERROR_BAD_FILE);
  assert_non_null(strstr(f->log.text, "no grid 'speed' of vectors"));
}

/* Which keeps a mistaken unit from taking all memory. */
static void too_fast_is_refused(void **state) {
  test_fixture *f = *state;
  test_velocity fast = ball;
  fast.at[0] = 1e6f;
  moving_ball b;
  test_velocity_make(f->context, &fast, b.grids);
  assert_int_equal(np_volume_create_from_grid(f->context, &b.grids[0], NEPH_PRECISION_HALF, NULL, &b.volume), NEPH_OK);
  const np_brick_motion_desc desc = {.rest = &b.volume->bricks,
                                     .index_to_file = b.volume->index_to_world,
                                     .velocity = &b.grids[1],
                                     .level_count = 1,
                                     .scale = 1.0,
                                     .end_s = 1.0};
  assert_int_equal(np_moving_bricks_build(f->context, &desc, NULL, &b.moving), NEPH_ERROR_BAD_SCENE);
  assert_non_null(strstr(f->log.text, "velocity_scale"));
  clear_ball(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(values_are_those_of_the_way_back, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(ranges_hold_all_values, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(nothing_is_lost_at_the_rim, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(means_are_close, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(bits_are_those_of_any_threads, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(names_that_are_found, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_name_that_is_not_there, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(too_fast_is_refused, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

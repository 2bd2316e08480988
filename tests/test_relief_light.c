/* SPDX-License-Identifier: Apache-2.0 */
/* Light between hills: an even sky over white ground stays even, a valley sees its strip of sky, level ground lights
 * walls, and any number of threads computes the same. */
#include "test_terrains.h"

#include <string.h>

#include "caches/relief_light.h"

typedef struct landscape {
  neph_terrain *terrain;
  np_world world;
  np_relief_light light;
} landscape;

/* A landscape under an even sky of 1; owns the terrain. */
static void start(landscape *l, neph_context *context, neph_terrain *terrain, float albedo, np_spectrum sun) {
  *l = (landscape){.terrain = terrain,
                   .world = {.terrain = terrain,
                             .has_planet = true,
                             .planet_radius_m = radius_m,
                             .environment_radiance = np_spectrum_grey(1.0f),
                             .terrain_albedo = np_spectrum_grey(albedo),
                             .ground_albedo = np_spectrum_grey(albedo),
                             .to_sun = np_vec3_make(0.0f, 0.6f, 0.8f),
                             .sun_irradiance = sun}};
  np_terrain_get_bounds(terrain, &l->world.terrain_min, &l->world.terrain_max);
  const np_relief_light_desc desc = {.world = &l->world, .depths = {.clouds = &l->world.clouds}};
  assert_int_equal(np_relief_light_build(context, &desc, &l->light), NEPH_OK);
}

static void end(landscape *l) {
  np_relief_light_clear(&l->light);
  neph_terrain_release(l->terrain);
}

static np_ground_hit look_down(const landscape *l, double x, double y) {
  np_ground_hit hit;
  assert_true(np_world_intersect_ground(&l->world, np_dvec3_make(x, y, 2e4), np_vec3_make(0, 0, -1), &hit));
  return hit;
}

/* Each slope of white hills amid even light sends back what it gets: hills cannot be seen in it. */
static void white_hills_vanish_in_a_furnace(void **state) {
  test_fixture *f = *state;
  landscape l;
  start(&l, f->context, make_ridges(f->context, 129), 1.0f, np_spectrum_grey(0.0f));
  double least = INFINITY, most = 0.0, steepest = 1.0;
  for (int i = 0; i < 400; i++) {
    const np_ground_hit hit = look_down(&l, 60.0 * i - 12e3, 9e3 * sin(i));
    const double value = (double)np_relief_light_get(&l.light, &hit).band[1] / NP_PI;
    least = fmin(least, value);
    most = fmax(most, value);
    steepest = fmin(steepest, (double)hit.normal.z);
  }
  assert_true(steepest < 0.85);
  /* A ray that leaves a summit below its horizon may pass the planet's. */
  assert_near(least, 1.0, 0.003);
  assert_near(most, 1.0, 0.003);
  end(&l);
}

/* A valley from south to north: a floor of 81 samples, walls of 3 km within four more. */
static int make_valley(unsigned column, unsigned row) {
  (void)row;
  const int away = abs((int)column - 600) - 40;
  return away <= 0 ? 0 : away < 4 ? 750 * away : 3000;
}

/* The middle of the floor of a long valley sees the cosine of its walls' elevation of an even sky, the rest of which is
 * black. 2 %: 40 rays upwards from each point, and harmonics of the second degree. */
static void a_black_valley_sees_a_strip_of_sky(void **state) {
  test_fixture *f = *state;
  landscape l;
  start(&l, f->context, make_tile(f, make_valley), 0.0f, np_spectrum_grey(0.0f));
  const double column_m = radius_m * NP_DEGREE / 1200.0 * cos(44.5 * NP_DEGREE);
  double sum = 0.0;
  for (int i = 0; i < 64; i++) {
    const np_ground_hit hit = look_down(&l, 0.0, 600.0 * (i - 32));
    sum += (double)np_relief_light_get(&l.light, &hit).band[0] / (64.0 * NP_PI);
  }
  assert_near_relative(sum, cos(atan(3000.0 / (43.0 * column_m))), 0.04);
  end(&l);
}

static int make_plain(unsigned column, unsigned row) { return (void)column, (void)row, 0; }

/* A wall on a plain sees half of the sky, and half of its directions meet ground under sun and sky: with no hill, to
 * the bit of what is known. The planet's bend hides some of the plain: 0.2 %. */
static void a_plain_lights_a_wall(void **state) {
  test_fixture *f = *state;
  landscape l;
  start(&l, f->context, make_tile(f, make_plain), 0.5f, np_spectrum_grey(2.0f));
  np_ground_hit hit = look_down(&l, 3e3, 5e3);
  assert_near_relative((double)np_relief_light_get(&l.light, &hit).band[0], NP_PI, 0.002);
  hit.normal = np_vec3_make(1.0f, 0.0f, 0.0f);
  const double ground = 0.5 * (NP_PI + 0.8 * 2.0);
  assert_near_relative((double)np_relief_light_get(&l.light, &hit).band[0], 0.5 * NP_PI + 0.5 * ground, 0.002);
  end(&l);
}

typedef struct look_job {
  const landscape *landscape;
  float *out;
} look_job;

static neph_result look(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const look_job *job = user;
  for (size_t n = begin; n < end; n++) {
    const np_ground_hit hit = look_down(job->landscape, 30.0 * (double)(n % 64), 40.0 * (double)(n / 64));
    job->out[n] = np_relief_light_get(&job->landscape->light, &hit).band[2];
  }
  return NEPH_OK;
}

/* Threads that need the same points at once, and one thread that needs them in turn. */
static void threads_compute_the_same_bits(void **state) {
  (void)state;
  enum { COUNT = 4096 };
  static float values[2][COUNT];
  for (int k = 0; k < 2; k++) {
    neph_context *context = test_context_create(k ? 4 : 1, NULL);
    landscape l;
    start(&l, context, make_ridges(context, 129), 0.3f, np_spectrum_grey(1.0f));
    look_job job = {&l, values[k]};
    assert_int_equal(np_parallel_for(context, NULL, COUNT, 1, look, &job), NEPH_OK);
    end(&l);
    neph_context_destroy(context);
  }
  assert_memory_equal(values[0], values[1], sizeof values[0]);
}

/* A valley that the points over the terrain, 1.3 by 1.8 km apart, do not resolve: a floor of 19 samples, walls of 300 m
 * within two more. */
static int make_gully(unsigned column, unsigned row) {
  (void)row;
  const int away = abs((int)column - 600) - 9;
  return away <= 0 ? 0 : away < 2 ? 150 * away : 300;
}

static double look_along_gully(const landscape *l) {
  double sum = 0.0;
  for (int i = 0; i < 64; i++) {
    const np_ground_hit hit = look_down(l, 0.0, 20.0 * (i - 32));
    sum += (double)np_relief_light_get(&l->light, &hit).band[0] / (64.0 * NP_PI);
  }
  return sum;
}

/* Points about the eye see a strip of sky like that of the wide valley; what lies beyond them has the same bits as
 * without them, as have all places once the eye has been elsewhere and back. */
static void the_eye_brings_points_near(void **state) {
  test_fixture *f = *state;
  landscape l;
  start(&l, f->context, make_tile(f, make_gully), 0.0f, np_spectrum_grey(0.0f));
  const double column_m = radius_m * NP_DEGREE / 1200.0 * cos(44.5 * NP_DEGREE);
  const double expected = cos(atan(300.0 / (11.0 * column_m))), coarse = look_along_gully(&l);
  const np_ground_hit far = look_down(&l, 36e3, 0.0);
  const np_dvec3 eye = np_dvec3_make(0.0, 0.0, 100.0), elsewhere = np_dvec3_make(-30e3, 20e3, 400.0);
  np_relief_light_desc desc = l.light.desc;
  const float before = np_relief_light_get(&l.light, &far).band[0];
  desc.eye = &eye;
  assert_int_equal(np_relief_light_set(&l.light, &desc), NEPH_OK);
  const double near = look_along_gully(&l);
  print_message("strip of sky %.4f, by coarse points %.4f, by near ones %.4f\n", expected, coarse, near);
  assert_near_relative(near, expected, 0.05);
  assert_true(fabs(coarse / expected - 1.0) > 0.05);
  assert_true(np_relief_light_get(&l.light, &far).band[0] == before);
  desc.eye = &elsewhere;
  assert_int_equal(np_relief_light_set(&l.light, &desc), NEPH_OK);
  desc.eye = &eye;
  assert_int_equal(np_relief_light_set(&l.light, &desc), NEPH_OK);
  assert_true(look_along_gully(&l) == near);
  end(&l);
}

int main(void) {
  const struct CMUnitTest tests[] = {TEST(white_hills_vanish_in_a_furnace), TEST(a_black_valley_sees_a_strip_of_sky),
                                     TEST(a_plain_lights_a_wall), TEST(the_eye_brings_points_near),
                                     TEST(threads_compute_the_same_bits)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}

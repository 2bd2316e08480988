/* SPDX-License-Identifier: Apache-2.0 */
/* Light of a cloud on ground and air: nothing changes in a furnace, light goes up with the sun, and it fails cleanly.
 */
#include "test_world.h"

#include "caches/lit_air.h"
#include "integrate/emission_rays.h"

typedef struct fixture {
  test_world cloud;
  np_ground_light cache;
  np_lit_air air;
  neph_volume *flame; /* NULL: none */
  np_emission emission;
} fixture;

/* A ball from 10 m above the ground on, under a sun in the zenith. */
static neph_result create_cloud(neph_context *context, test_world *cloud) {
  test_world_init(cloud, context);
  cloud->world.planet_radius_m = 6.36e6;
  return test_world_add(cloud, test_cloud_make_on_axes(test_soft_ball, 10.0));
}

static neph_result build_caches(fixture *f) {
  test_world *c = &f->cloud;
  neph_result result = test_world_solve(c);
  if (result) return result;
  np_cloud_gather gather = {.world = &c->world,
                            .depths = &c->lighting.sun_optical_depths,
                            .scattering = c->scattering,
                            .bounds_min = c->desc.cells.bounds_min,
                            .bounds_max = c->desc.cells.bounds_max};
  np_cloud_gather_init(&gather);
  np_ground_rays rays = {0};
  result = np_ground_light_build(c->context, &gather, NULL, &f->cache, &rays);
  np_ground_rays_clear(c->context, &rays);
  if (!result) result = np_lit_air_build(c->context, &gather, &f->cache, NULL, &f->air);
  if (!result) c->lighting.ground_light = &f->cache;
  return result;
}

static void clear_caches(fixture *f) {
  if (f->air.context) np_lit_air_clear(&f->air);
  if (f->cache.context) np_ground_light_clear(&f->cache);
}

static void start(fixture *f, unsigned threads) {
  assert_int_equal(create_cloud(test_context_create(threads, NULL), &f->cloud), NEPH_OK);
}

static void build(fixture *f) { assert_int_equal(build_caches(f), NEPH_OK); }

static void end(fixture *f) {
  clear_caches(f);
  np_emission_clear(&f->emission);
  neph_volume_release(f->flame);
  test_world_destroy(&f->cloud);
}

static np_spectrum compute_irradiance(const fixture *f, double x, double y) {
  const np_ground_hit hit = {.position = {x, y, 0.0}, .normal = {0, 0, 1}};
  return np_lighting_ground_irradiance(&f->cloud.lighting, &f->cloud.world, &hit);
}

/* Amid even light a white cloud cannot be seen, nor can its shade: its own light replaces the sky that it covers. 2 %
 * for its steps of two voxels, and the tolerance of the solution. */
static void a_white_cloud_casts_no_shade_in_a_furnace(void **state) {
  (void)state;
  fixture f = {0};
  start(&f, 2);
  f.cloud.world.environment_radiance = np_spectrum_make(0.5f, 2.0f, 3.0f);
  build(&f);
  /* It covers the sky to 26 degrees from the zenith, which is a fifth of the light. */
  const np_ground_light_value below = np_ground_light_get(&f.cache, np_dvec3_make(11.5, 11.5, 0.0));
  assert_in_range((int)(100.0f * below.open.band[1]), 75, 90);
  for (double x = -20.0; x < 40.0; x += 2.9) {
    const np_spectrum irradiance = compute_irradiance(&f, x, 0.5 * x);
    assert_near_relative((double)irradiance.band[0], 0.5 * NP_PI, 0.02);
    assert_near_relative((double)irradiance.band[2], 3.0 * NP_PI, 0.02);
  }
  /* Nor does the air around it change: of the flux 2π·0.5 from either hemisphere at most 2 % in the mean of places. */
  double change[2] = {0.0, 0.0};
  for (int n = 0; n < 200; n++) {
    const np_dvec3 place = np_dvec3_make(fmod(7.3 * n, 50.0) - 13.0, fmod(3.1 * n, 50.0) - 13.0, fmod(11.7 * n, 60.0));
    const np_lit_air_value value = np_lit_air_get(&f.air, place);
    change[0] += (double)value.upper.band[0] / 200.0;
    change[1] += (double)value.lower.band[0] / 200.0;
  }
  for (int side = 0; side < 2; side++) assert_near(change[side] / NP_PI, 0.0, 0.02);
  end(&f);
}

/* Under a sky that is black but for the sun the cloud alone lights the ground, below it most; far away nothing does. */
static void the_cloud_shines_on_what_is_below_it(void **state) {
  (void)state;
  fixture f = {0};
  start(&f, 2);
  f.cloud.world.sun_irradiance = np_spectrum_make(1.0f, 2.0f, 3.0f);
  build(&f);
  const np_spectrum below = compute_irradiance(&f, 11.5, 11.5), beside = compute_irradiance(&f, 40.0, 11.5);
  /* It takes 314 W from the sun and scatters half of it down, at twice the mean of the half space: 0.1 W/m² from 21 m.
   */
  assert_in_range((int)(1000.0f * below.band[0]), 30, 150);
  assert_near_relative((double)below.band[2], 3.0 * (double)below.band[0], 0.01);
  assert_true(beside.band[0] > 0.0f && beside.band[0] < 0.3f * below.band[0]);
  assert_near((double)compute_irradiance(&f, 1e4, 11.5).band[0], 0.0, 0.0);
  /* Air under it is lit from above, air over it from below, and air far away not at all. */
  const np_lit_air_value under = np_lit_air_get(&f.air, np_dvec3_make(11.5, 11.5, 2.0)),
                         over = np_lit_air_get(&f.air, np_dvec3_make(11.5, 11.5, 60.0)),
                         away = np_lit_air_get(&f.air, np_dvec3_make(1e4, 11.5, 20.0));
  assert_in_range((int)(1000.0f * under.upper.band[0]), 60, 400);
  assert_true(over.lower.band[0] > 0.003f);
  assert_near((double)over.upper.band[0], 0.0, 0.0);
  assert_near_relative((double)under.upper.band[2], 3.0 * (double)under.upper.band[0], 0.01);
  assert_near((double)away.upper.band[0], 0.0, 0.0);
  end(&f);
}

/* A ball of four voxels. */
static float small_ball(double x, double y, double z) { return (float)fmax(0.0, 1.0 - (x * x + y * y + z * z) / 16.0); }

static void light_flame(fixture *f, np_dvec3 middle_m) {
  static const double bands_nm[NP_BAND_COUNT] = {680.0, 550.0, 440.0};
  const np_black_body body = np_black_body_make(bands_nm);
  test_world *c = &f->cloud;
  assert_int_equal(test_volume_create(c->context, small_ball, TEST_EDGE, np_dvec3_make(1, 1, 1), middle_m, &f->flame),
                   NEPH_OK);
  const np_emitter emitter = {.bricks = &f->flame->bricks,
                              .world_to_index = f->flame->world_to_index,
                              .index_to_world = f->flame->index_to_world,
                              .absorption_per_value = np_spectrum_grey(0.01f),
                              .offset_k = 1900.0f};
  assert_int_equal(np_emission_build(c->context, &emitter, 1, &body, NULL, &f->emission), NEPH_OK);
  c->world.emission = &f->emission;
}

/* Irradiance that comes from the flame without being scattered. */
static double compute_direct(const fixture *f, np_dvec3 position, np_random *random) {
  const np_vec3 up = np_vec3_make(0, 0, 1);
  double sum = 0.0;
  for (int i = 0; i < 400; i++)
    sum += (double)np_emission_irradiance(&f->cloud.world, position, up, random).band[0] / 400.0;
  return sum;
}

/* White smoke only turns a flame's light around: what leaves a ball of it, P/4πr² at any distance, is what the flame
 * sends out. 5 % for the cells of the solution beside the flame and for the directions; a set over the whole sky, which
 * hits or misses it, is 35 % wrong at 55 m. */
static void smoke_around_a_flame_lights_the_ground_evenly(void **state) {
  (void)state;
  fixture f = {0};
  test_world_init(&f.cloud, test_context_create(2, NULL));
  f.cloud.world.planet_radius_m = 6.36e6;
  test_cloud smoke = test_cloud_make(test_soft_ball, 0.1f, np_phase_henyey_greenstein(0.0f));
  smoke.middle_m = np_dvec3_make(0.0, 0.0, 30.0);
  assert_int_equal(test_world_add(&f.cloud, smoke), NEPH_OK);
  light_flame(&f, smoke.middle_m);
  build(&f);
  np_random random = np_random_start(5, 0, 0, 0, 0);
  for (int i = 0; i < 12; i++) {
    const double away = 5.0 * i, angle = 2.4 * i, square = away * away + 900.0;
    const np_dvec3 position = np_dvec3_make(away * cos(angle), away * sin(angle), 0.0);
    const double all = (double)f.emission.power_w_sr_nm.band[0] / square * 30.0 / sqrt(square);
    const double direct = compute_direct(&f, position, &random);
    const double scattered = (double)np_ground_light_get(&f.cache, position).added.band[0];
    assert_near_relative(direct + scattered, all, 0.05);
  }
  end(&f);
}

static void threads_change_no_bit(void **state) {
  (void)state;
  fixture one = {0}, two = {0};
  start(&one, 1);
  start(&two, 3);
  one.cloud.world.sun_irradiance = two.cloud.world.sun_irradiance = np_spectrum_grey(1.0f);
  build(&one);
  build(&two);
  const size_t count = (size_t)one.cache.size[0] * (size_t)one.cache.size[1];
  assert_memory_equal(one.cache.points, two.cache.points, count * sizeof *one.cache.points);
  const size_t places = (size_t)one.air.size[0] * (size_t)one.air.size[1] * NP_LIT_AIR_LEVELS;
  assert_memory_equal(one.air.points, two.air.points, places * sizeof *one.air.points);
  end(&one);
  end(&two);
}

static neph_result attempt(neph_context *context, void *user) {
  fixture *f = user;
  *f = (fixture){0};
  neph_result result = create_cloud(context, &f->cloud);
  f->cloud.world.sun_irradiance = np_spectrum_grey(1.0f);
  f->cloud.desc.tolerance = 0.9;
  f->cloud.desc.degree_max = NP_DEGREE_MIN;
  if (!result) result = build_caches(f);
  clear_caches(f);
  test_world_clear(&f->cloud);
  return result;
}

static void a_failed_allocation_leaves_nothing_behind(void **state) {
  (void)state;
  fixture f;
  assert_survives_failed_allocations(attempt, &f);
}

/* A grid of one period has the same value any number of periods away, is interpolated across the joint, and does not
 * fade into a clear sky. */
static void periods_repeat(void **state) {
  (void)state;
  np_ground_light_value points[6];
  for (int n = 0; n < 6; n++) {
    const float open = n % 3 == 1 ? 0.5f : 0.25f;
    points[n] = (np_ground_light_value){.open = np_spectrum_grey(open), .added = np_spectrum_grey(open)};
  }
  const np_ground_light light = {.size = {3, 2},
                                 .origin_m = {100.0, -50.0},
                                 .spacing_m = 200.0,
                                 .period = {{100.0, 400.0, 400.0}, {-50.0, 200.0, 200.0}},
                                 .points = points};
  for (int k = -3; k < 4; k++) {
    const np_dvec3 joint = np_dvec3_make(100.0 + 400.0 * k, 10.0 + 200.0 * k, 0.0);
    const np_dvec3 middle = np_dvec3_make(300.0 + 400.0 * k, 10.0, 0.0),
                   between = np_dvec3_make(399.0 + 400.0 * k, 0.0, 0.0);
    assert_near((double)np_ground_light_get(&light, joint).open.band[0], 0.25, 1e-6);
    assert_near((double)np_ground_light_get(&light, middle).open.band[0], 0.5, 1e-6);
    assert_near((double)np_ground_light_get(&light, between).added.band[1], 0.5 - 0.25 * 99.0 / 200.0, 1e-6);
  }
}

/* The last period of a stretch stands for all beyond its ends; within it every place has its own light. */
static void last_period_stands_for_all_beyond(void **state) {
  (void)state;
  np_ground_light_value points[8];
  for (int n = 0; n < 8; n++)
    points[n].open = points[n].added = np_spectrum_grey(n % 4 < 2 ? 0.1f * (float)(n % 4) : 0.5f);
  const np_ground_light light = {
      .size = {4, 2}, .origin_m = {0.0, 0.0}, .spacing_m = 100.0, .period[0] = {0.0, 300.0, 100.0}, .points = points};
  const double at_m[] = {0.0, 50.0, 100.0, 250.0, 310.0, 1e4, -10.0, -1e4},
               value[] = {0.0, 0.05, 0.1, 0.5, 0.5, 0.5, 0.5, 0.5};
  for (int n = 0; n < 8; n++) {
    const np_ground_light_value got = np_ground_light_get(&light, np_dvec3_make(at_m[n], 50.0, 0.0));
    assert_near((double)got.added.band[0], value[n], 1e-6);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(periods_repeat),
      cmocka_unit_test(last_period_stands_for_all_beyond),

      cmocka_unit_test(a_white_cloud_casts_no_shade_in_a_furnace),
      cmocka_unit_test(the_cloud_shines_on_what_is_below_it),
      cmocka_unit_test(smoke_around_a_flame_lights_the_ground_evenly),
      cmocka_unit_test(threads_change_no_bit),
      cmocka_unit_test(a_failed_allocation_leaves_nothing_behind),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Laws that hold for any cloud, whatever its shape: light may be followed either way, none is lost where nothing
 * absorbs, and a volume cut in two is the same volume. Held by the tracer within its own standard error, and by the
 * march with ordinates as far as it goes. */
#include "test_world.h"

enum { BATCHES = 16 };

static const double half_m[3] = {22.5, 10.5, 10.5}; /* half size of a box about the origin that contains all */

/* The ball in two parts. */
static const double cut_m = -3.0;
static float left_of_cut(double x, double y, double z) { return x < cut_m ? test_lumpy_ball(x, y, z) : 0.0f; }
static float right_of_cut(double x, double y, double z) { return x < cut_m ? 0.0f : test_lumpy_ball(x, y, z); }

static void add(test_world *w, test_field field, double x, float extinction_per_m, np_phase phase) {
  test_cloud cloud = test_cloud_make(field, extinction_per_m, phase);
  cloud.middle_m.x = x;
  const unsigned i = w->world.clouds.count;
  assert_int_equal(test_world_add(w, cloud), NEPH_OK);
  w->placed[i].albedo = np_spectrum_make(1.0f, 0.9f, 0.0f);
}

static void start_empty(test_world *w) {
  test_world_init(w, test_context_create(2, NULL));
  w->world.sun_irradiance = np_spectrum_grey(1.0f);
}

/* Two lumpy balls 20 m apart, of different density and phase function. */
static void start(test_world *w) {
  start_empty(w);
  add(w, test_lumpy_ball, -12.0, 0.5f, np_phase_henyey_greenstein(0.7f));
  add(w, test_lumpy_ball, 12.0, 0.15f, np_phase_two_lobe(0.5f, -0.3f, 0.3f));
}

static void light(test_world *w, np_vec3 to_sun, bool is_solved) {
  w->world.to_sun = to_sun;
  np_scattering_field_destroy(w->scattering);
  w->lighting.scattering = w->scattering = NULL;
  w->desc.cells.bounds_min = np_dvec3_make(-24.0, -12.0, -12.0);
  w->desc.cells.bounds_max = np_dvec3_make(24.0, 12.0, 12.0);
  if (is_solved) assert_int_equal(test_world_solve(w), NEPH_OK);
}

typedef struct estimate {
  double mean, error;
} estimate;

/* A rectangle that faces a direction, wide enough that all clouds are seen through it. */
typedef struct window {
  np_vec3 from, axis[2];
  double half_m[2], area_m2;
} window;

static window open_window(np_vec3 from) {
  window w = {.from = from};
  np_frame_around(from, &w.axis[0], &w.axis[1]);
  for (int i = 0; i < 2; i++)
    w.half_m[i] = half_m[0] * fabs((double)w.axis[i].x) + half_m[1] * fabs((double)w.axis[i].y) +
                  half_m[2] * fabs((double)w.axis[i].z);
  w.area_m2 = 4.0 * w.half_m[0] * w.half_m[1];
  return w;
}

/* The n-th ray of a low-discrepancy set (Roberts 2018), `shift` along. */
static np_camera_ray make_ray(const window *w, int n, const double shift[2], np_random *random) {
  static const double steps[2] = {0.7548776662466927, 0.5698402909980532};
  np_dvec3 origin = np_vec3_to_double(np_vec3_scale(w->from, 100.0f));
  for (int i = 0; i < 2; i++) {
    const double u = shift[i] + steps[i] * n;
    origin = np_dvec3_along(origin, w->axis[i], w->half_m[i] * (2.0 * (u - floor(u)) - 1.0));
  }
  return (np_camera_ray){
      .origin = origin, .direction = np_vec3_scale(w->from, -1.0f), .jitter = np_random_float(random)};
}

/* An estimate along one ray. */
typedef double (*sample_fn)(const test_world *w, const np_camera_ray *ray, np_random *random, int band);

/* Integrated over the window that faces `from`; the error is that of the means of BATCHES sets. */
static estimate integrate(const test_world *w, np_vec3 from, sample_fn sample, int count, int band, uint64_t seed) {
  np_random random = np_random_start(seed, 0, 0, 0, 0);
  const window facing = open_window(from);
  test_tally batches = {0};
  for (int batch = 0; batch < BATCHES; batch++) {
    const double shift[2] = {np_random_double(&random), np_random_double(&random)};
    double sum = 0.0;
    for (int n = 0; n < count / BATCHES; n++) {
      const np_camera_ray ray = make_ray(&facing, n, shift, &random);
      sum += sample(w, &ray, &random, band);
    }
    test_tally_add(&batches, facing.area_m2 * sum / (count / BATCHES));
  }
  return (estimate){test_tally_mean(&batches), test_tally_error(&batches)};
}

static double sample_radiance(const test_world *w, const np_camera_ray *ray, np_random *random, int band) {
  np_integrator_sample sample;
  (w->lighting.scattering ? test_world_march : test_world_path)(w, ray, random, &sample);
  return test_sum_components(&sample, band);
}

/* Radiant intensity towards `to`. */
static estimate compute_intensity(const test_world *w, np_vec3 to, int count, int band, uint64_t seed) {
  return integrate(w, to, sample_radiance, count, band, seed);
}

/* Chandrasekhar 1960, "Radiative Transfer", section 13: what goes from a to b under light from a is what goes from b to
 * a under light from b. One shadows the other from a, both show from b. */
static void assert_reciprocal(test_world *w, bool is_solved, int band, double tolerance) {
  const np_vec3 a = np_vec3_make(0.96f, 0.0f, 0.28f), b = np_vec3_make(0.0f, -0.8f, 0.6f);
  const int count = is_solved ? 4096 : 131072;
  light(w, a, is_solved);
  const estimate there = compute_intensity(w, b, count, band, 1);
  light(w, b, is_solved);
  const estimate back = compute_intensity(w, a, count, band, 2);
  assert_near(there.mean, back.mean, 4.0 * hypot(there.error, back.error) + tolerance * there.mean);
}

static void light_may_be_followed_either_way(void **state) {
  (void)state;
  test_world w;
  start(&w);
  assert_reciprocal(&w, false, 0, 0.0);
  assert_reciprocal(&w, false, 1, 0.0);
  assert_reciprocal(&w, true, 0, 0.01);
  assert_reciprocal(&w, true, 1, 0.01);
  test_world_destroy(&w);
}

static double sample_opacity(const test_world *w, const np_camera_ray *ray, np_random *random, int band) {
  (void)random, (void)band;
  double depth = 0.0;
  for (int k = 0; k < 240; k++) {
    const np_dvec3 position = np_dvec3_along(ray->origin, ray->direction, 70.0 + 0.25 * (k + 0.5));
    for (unsigned v = 0; v < w->world.clouds.count; v++)
      depth += 0.25 * (double)np_instance_extinction(&w->placed[v], position);
  }
  return -expm1(-depth);
}

/* Outgoing light over the sphere is the light that the clouds take from the sun. */
static void assert_conserved(test_world *w, bool is_solved, double tolerance) {
  enum { DIRECTIONS = 256 };
  light(w, np_vec3_make(0.6f, 0.0f, 0.8f), is_solved);
  double outgoing = 0.0, variance = 0.0;
  for (int n = 0; n < DIRECTIONS; n++) {
    const double z = 1.0 - (2.0 * n + 1.0) / DIRECTIONS, azimuth = n * (NP_PI * (3.0 - sqrt(5.0)));
    const float r = (float)sqrt(1.0 - z * z);
    const np_vec3 to = np_vec3_make(r * (float)cos(azimuth), r * (float)sin(azimuth), (float)z);
    const estimate part = compute_intensity(w, to, is_solved ? 1024 : 2048, 0, 100 + (uint64_t)n);
    outgoing += 4.0 * NP_PI / DIRECTIONS * part.mean;
    variance += pow(4.0 * NP_PI / DIRECTIONS * part.error, 2.0);
  }
  /* Sunlight, by the optical depths alone. */
  const estimate taken = integrate(w, w->world.to_sun, sample_opacity, 16384, 0, 3);
  assert_near(outgoing, taken.mean, 4.0 * sqrt(variance + taken.error * taken.error) + tolerance * taken.mean);
}

static void white_clouds_lose_no_light(void **state) {
  (void)state;
  test_world w;
  start(&w);
  assert_conserved(&w, false, 0.0);
  assert_conserved(&w, true, 0.01);
  test_world_destroy(&w);
}

/* path in [0], march in [1] */
static void compute_intensities(test_world *w, uint64_t seed, estimate out[2]) {
  for (int is_solved = 0; is_solved < 2; is_solved++) {
    light(w, np_vec3_make(0.6f, 0.0f, 0.8f), is_solved);
    out[is_solved] = compute_intensity(w, np_vec3_make(0.0f, -1.0f, 0.0f), is_solved ? 4096 : 131072, 0, seed);
  }
}

/* The interpolant of a grid is the sum of those of its parts: a cloud in two files is the cloud in one. */
static void a_volume_in_two_files_is_one_volume(void **state) {
  (void)state;
  test_world one, two;
  estimate whole[2], parts[2];
  const np_phase phase = np_phase_henyey_greenstein(0.7f);
  start_empty(&one);
  add(&one, test_lumpy_ball, -12.0, 0.5f, phase);
  compute_intensities(&one, 4, whole);
  start_empty(&two);
  add(&two, left_of_cut, -12.0, 0.5f, phase);
  add(&two, right_of_cut, -12.0, 0.5f, phase);
  compute_intensities(&two, 5, parts);
  assert_near(parts[0].mean, whole[0].mean, 4.0 * hypot(parts[0].error, whole[0].error));
  assert_near(parts[1].mean, whole[1].mean, 4.0 * hypot(parts[1].error, whole[1].error) + 0.01 * whole[1].mean);
  test_world_destroy(&one);
  test_world_destroy(&two);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(light_may_be_followed_either_way),
      cmocka_unit_test(white_clouds_lose_no_light),
      cmocka_unit_test(a_volume_in_two_files_is_one_volume),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Known answers for approximations of multiple scattering: each term alone, and in the march. */
#include "test_world.h"

#include "integrate/approximation.h"
#include "integrate/approximation_gain.h"

enum { EDGE = 16 };

/* An approximation on trial. */
typedef struct trial {
  neph_multiple_scattering method;
  np_approximation parameters;
} trial;

static const trial octaves = {NEPH_MULTIPLE_SCATTERING_OCTAVES,
                              {.gain = 1.0, .octave_count = 3, .octave_factors = {0.5, 0.25, 0.0}}};
static const trial softened = {NEPH_MULTIPLE_SCATTERING_SOFTENED_BEER,
                               {.gain = 1.0, .softened_share = 0.7, .softened_rate = 0.25}};
static const trial powder = {NEPH_MULTIPLE_SCATTERING_POWDER,
                             {.gain = 1.0, .softened_share = 0.7, .softened_rate = 0.25, .powder_strength = 1.0}};
static const trial derivative = {NEPH_MULTIPLE_SCATTERING_DERIVATIVE, {.gain = 1.0, .derivative_distance_m = 4.0}};

/* Default parameters, for which gains are calibrated. */
static const trial defaults[] = {
    {NEPH_MULTIPLE_SCATTERING_OCTAVES, {.gain = 1.0, .octave_count = 8, .octave_factors = {0.5, 0.5, 0.5}}},
    {NEPH_MULTIPLE_SCATTERING_SOFTENED_BEER, {.gain = 1.0, .softened_share = 0.7, .softened_rate = 0.25}},
    {NEPH_MULTIPLE_SCATTERING_POWDER,
     {.gain = 1.0, .softened_share = 0.7, .softened_rate = 0.25, .powder_strength = 1.0}},
    {NEPH_MULTIPLE_SCATTERING_DERIVATIVE, {.gain = 1.0, .derivative_distance_m = 30.0}}};

static const np_approximation_row *get_row(const trial *t) { return &np_approximation_rows_v1[t->method]; }

static void fill_transmittances(const trial *t, float depth, float terms[NP_APPROXIMATION_TERMS_MAX]) {
  get_row(t)->fill_transmittances(&t->parameters, depth, terms);
}

static double sum_terms(const trial *t, const float *terms) {
  double sum = 0.0;
  for (unsigned n = 0; n < get_row(t)->count_terms(&t->parameters); n++) sum += (double)terms[n];
  return sum;
}

/* Compares with the definitions, to 1e-6 for floats. */
static void terms_are_what_their_laws_say(void **state) {
  (void)state;
  static const float depths[] = {0.0f, 0.3f, 1.0f, 4.0f, 20.0f};
  const np_phase phase = np_phase_henyey_greenstein(0.8f);
  float terms[NP_APPROXIMATION_TERMS_MAX], phases[NP_APPROXIMATION_TERMS_MAX];
  for (unsigned i = 0; i < sizeof depths / sizeof *depths; i++) {
    const double depth = (double)depths[i];
    fill_transmittances(&softened, depths[i], terms);
    assert_near(sum_terms(&softened, terms), fmax(exp(-depth), 0.7 * exp(-0.25 * depth)), 1e-6);
    fill_transmittances(&octaves, depths[i], terms);
    assert_near((double)terms[2], exp(-depth / 16.0), 1e-6);
  }
  get_row(&octaves)->fill_phases(&octaves.parameters, &phase, 0.4f, phases);
  assert_near_relative((double)phases[0], (double)np_phase_eval(&phase, 0.4f), 1e-6);
  assert_near_relative((double)phases[1], 0.5 / (4.0 * NP_PI), 1e-6);
  assert_near_relative((double)phases[2], 0.25 / (4.0 * NP_PI), 1e-6);
}

/* The slowest term has faded to e^{−16} where a walk towards the light stops. */
static void walks_end_where_every_term_is_faint(void **state) {
  (void)state;
  const trial *trials[] = {&octaves, &softened, &powder};
  for (unsigned i = 0; i < 3; i++) {
    float terms[NP_APPROXIMATION_TERMS_MAX];
    fill_transmittances(trials[i], NP_TRACK_DEPTH_MAX / get_row(trials[i])->get_fade(&trials[i]->parameters), terms);
    for (unsigned n = 0; n < get_row(trials[i])->count_terms(&trials[i]->parameters); n++)
      assert_true((double)terms[n] <= 1.01 * exp(-16.0));
  }
}

/* Full up to half its height, half as dense above. */
static float two_layers(double x, double y, double z) { return (void)x, (void)y, z < 0.0 ? 1.0f : 0.5f; }

/* A box of EDGE³ samples 1 m apart from the origin on. */
static void start(test_world *w, float extinction_per_m) {
  test_cloud cloud = test_cloud_make(two_layers, extinction_per_m, np_phase_henyey_greenstein(0.8f));
  cloud.edge = EDGE;
  cloud.middle_m = np_dvec3_make(7.5, 7.5, 7.5);
  test_world_create(w, 1, cloud);
  w->placed[0].top_m = EDGE - 1;
  w->world.sun_irradiance = np_spectrum_grey(1.0f);
}

static double weigh(const test_world *w, const trial *t, double z) {
  const np_dvec3 place = np_dvec3_make(7.5, 7.5, z);
  return get_row(t)->get_weight ? (double)get_row(t)->get_weight(&t->parameters, &w->placed[0], place) : 1.0;
}

/* Schneider 2017: 0.1^0.8 at the base, 1 in dense cloud above; above 0.85 of the height half the density counts as
 * 0.05 + ½². Without strength, and for other approximations, the weight is 1. */
static void powder_darkens_the_base_and_thin_places(void **state) {
  (void)state;
  test_world w;
  start(&w, 0.3f);
  assert_near(weigh(&w, &powder, 0.5), pow(0.1, 0.8), 1e-5);
  assert_near(weigh(&w, &powder, 5.0), 1.0, 1e-5);
  assert_near(weigh(&w, &powder, 14.0), 0.05 + 0.25, 1e-5);
  trial weak = powder;
  weak.parameters.powder_strength = 0.0;
  assert_near(weigh(&w, &weak, 14.0), 1.0, 0.0);
  assert_near(weigh(&w, &softened, 14.0), 1.0, 0.0);
  test_world_destroy(&w);
}

static double slope(const test_world *w, double z) {
  return (double)get_row(&derivative)
      ->get_slope(&derivative.parameters, &w->world, np_dvec3_make(7.5, 7.5, z), w->world.to_sun);
}

static void the_derivative_is_the_fall_of_density_towards_the_sun(void **state) {
  (void)state;
  test_world w;
  start(&w, 0.3f);
  assert_near(slope(&w, 2.0), 0.0, 1e-6);
  assert_near(slope(&w, 5.0), 0.5, 1e-6);
  assert_near(slope(&w, 13.0), 1.0, 1e-6);
  assert_near(slope(&w, -5.0), 0.0, 0.0);
  test_world_destroy(&w);
}

static double march(test_world *w, const trial *t) {
  w->settings = (np_integrator_settings){.scattering_max = UINT32_MAX,
                                         .multiple_scattering = t->method,
                                         .approximation = t->parameters,
                                         .tolerance = 1e-5f,
                                         .step_voxels = 0.1f};
  const np_camera_ray ray = {.origin = {7.5, 7.5, 100.0}, .direction = {0, 0, -1}, .jitter = 0.5f};
  np_random random = np_random_start(1, 0, 0, 0, 0);
  np_integrator_sample sample;
  test_world_march(w, &ray, &random, &sample);
  return test_sum_components(&sample, 1);
}

/* A cloud too dense to see into, its face towards the sun, is a white wall: E/π. 1 %: the voxel in which the density
 * rises, that the slope from 4 m away does not see as a wall. */
static void an_opaque_face_is_a_white_wall_under_the_derivative(void **state) {
  (void)state;
  test_world w;
  start(&w, 200.0f);
  assert_near_relative(march(&w, &derivative), 1.0 / NP_PI, 0.01);
  test_world_destroy(&w);
}

static void gain_scales_each_approximation(void **state) {
  (void)state;
  test_world w;
  start(&w, 0.3f);
  const trial *trials[] = {&octaves, &softened, &powder, &derivative};
  for (unsigned i = 0; i < 4; i++) {
    trial bright = *trials[i];
    bright.parameters.gain = 3.0;
    const double plain = march(&w, trials[i]);
    assert_true(plain > 0.0);
    assert_near_relative(march(&w, &bright), 3.0 * plain, 1e-5);
  }
  test_world_destroy(&w);
}

/* ---- Calibrated gain ---- */

/* A cuboid of σ = 0.3 m⁻¹, EDGE samples and so EDGE steps of a metre by one by four, to where it is half: the law of
 * the effective depth. 5 %: columns at its faces, which are shallower, count by what they hold. */
static void the_depth_of_a_cuboid_is_that_of_a_cube_that_leaks_as_fast(void **state) {
  (void)state;
  test_world w;
  test_cloud cloud = test_cloud_make(test_full, 0.3f, np_phase_isotropic());
  cloud.edge = EDGE;
  cloud.step_m = np_dvec3_make(1.0, 1.0, 4.0);
  test_world_create(&w, 1, cloud);
  const double depth = 0.3 * EDGE;
  assert_near_relative((double)np_cloud_gain_compute_depth(&w.placed[0]), depth * sqrt(3.0 / (2.0 + 1.0 / 16.0)), 0.05);
  test_world_destroy(&w);
}

static void the_place_of_an_angle_is_even_in_the_sine_of_its_half(void **state) {
  (void)state;
  np_spectrum gain[NP_GAIN_ANGLES];
  for (int a = 0; a < NP_GAIN_ANGLES; a++) gain[a] = np_spectrum_grey((float)a);
  for (double half = 0.0; half <= 0.5 * NP_PI; half += 0.1)
    assert_near((double)np_cloud_gain_get(gain, (float)(1.0 - cos(2.0 * half))).band[0],
                (NP_GAIN_ANGLES - 1) * sin(half), 1e-3);
}

/* Mean radiance over parallel rays through a ball that look towards the sun, and over those that look away from it. */
static void compute_means(test_world *w, double out_means[2]) {
  test_tally tallies[2] = {{.count = 0}};
  np_random random = np_random_start(1, 0, 0, 0, 0);
  for (int i = 0; i < 1500; i++) {
    const float z = 1.0f - 2.0f * np_random_float(&random), turn = 2.0f * NP_PI_F * np_random_float(&random);
    const float r = sqrtf(1.0f - z * z);
    const np_vec3 d = np_vec3_make(r * cosf(turn), r * sinf(turn), z);
    np_vec3 u, v;
    np_frame_around(d, &u, &v);
    np_dvec3 origin = np_dvec3_along(np_dvec3_make(0, 0, 0), d, -1000.0);
    origin = np_dvec3_along(origin, u, 400.0 * (np_random_double(&random) - 0.5));
    origin = np_dvec3_along(origin, v, 400.0 * (np_random_double(&random) - 0.5));
    const np_camera_ray ray = {.origin = origin, .direction = d, .jitter = np_random_float(&random)};
    np_integrator_sample sample;
    test_world_march(w, &ray, &random, &sample);
    test_tally_add(&tallies[z < 0.0f], test_sum_components(&sample, 1));
  }
  for (int s = 0; s < 2; s++) out_means[s] = test_tally_mean(&tallies[s]);
}

/* A ball 400 m across, of a depth, albedo and asymmetry between those of the table. */
static void start_ball(test_world *w) {
  test_cloud cloud = test_cloud_make(test_soft_ball, 0.1f, np_phase_henyey_greenstein(0.75f));
  cloud.step_m = np_dvec3_make(20.0, 20.0, 20.0);
  test_world_create(w, 1, cloud);
  w->placed[0].albedo = np_spectrum_grey(0.98f);
  w->placed[0].bottom_m = -200.0;
  w->placed[0].top_m = 200.0;
  w->world.to_sun = np_vec3_make(0.6f, 0.0f, 0.8f);
  w->world.sun_irradiance = np_spectrum_grey(1.0f);
}

/* Factor between two means, the larger of both. */
static double compute_error(const double means[2], const double solved[2]) {
  return exp(fmax(fabs(log(means[0] / solved[0])), fabs(log(means[1] / solved[1]))));
}

/* Means looking towards and away from the sun are those of the solution to a factor, by the calibrated gain only. It is
 * larger where the method goes by more than optical depths: the powder by where in the cloud it is dense, the
 * derivative by how steep its surface is. */
static void calibrated_gain_gives_the_mean_of_the_solution(void **state) {
  (void)state;
  static const double bounds[] = {1.4, 1.4, 2.0, 2.2};
  test_world w;
  start_ball(&w);
  double solved[2], raw[2], gained[2];
  assert_int_equal(test_world_solve(&w), NEPH_OK);
  compute_means(&w, solved);
  w.lighting.scattering = NULL;
  const float depth = np_cloud_gain_compute_depth(&w.placed[0]);
  for (unsigned i = 0; i < 4; i++) {
    np_cloud_gain gain;
    w.settings.multiple_scattering = defaults[i].method;
    w.settings.approximation = defaults[i].parameters;
    np_cloud_gain_fill(defaults[i].method, &w.placed[0], depth, &gain);
    compute_means(&w, raw);
    w.lighting.gains = &gain;
    compute_means(&w, gained);
    w.lighting.gains = NULL;
    assert_true(compute_error(gained, solved) < bounds[i]);
    assert_true(compute_error(raw, solved) > bounds[i]);
  }
  test_world_destroy(&w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(terms_are_what_their_laws_say),
      cmocka_unit_test(walks_end_where_every_term_is_faint),
      cmocka_unit_test(powder_darkens_the_base_and_thin_places),
      cmocka_unit_test(the_derivative_is_the_fall_of_density_towards_the_sun),
      cmocka_unit_test(an_opaque_face_is_a_white_wall_under_the_derivative),
      cmocka_unit_test(gain_scales_each_approximation),
      cmocka_unit_test(the_depth_of_a_cuboid_is_that_of_a_cube_that_leaks_as_fast),
      cmocka_unit_test(the_place_of_an_angle_is_even_in_the_sine_of_its_half),
      cmocka_unit_test(calibrated_gain_gives_the_mean_of_the_solution),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

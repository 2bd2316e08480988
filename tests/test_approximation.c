/* SPDX-License-Identifier: Apache-2.0 */
/* Known answers for approximations of multiple scattering: each term alone, and in the march. */
#include "test_world.h"

#include "integrate/approximation.h"

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

static const np_approximation_row *get_row(const trial *t) { return &np_approximation_rows_v1[t->method]; }

static void fill_transmittances(const trial *t, float depth, float terms[NP_APPROXIMATION_TERMS_MAX]) {
  get_row(t)->fill_transmittances(&t->parameters, depth, terms);
}

static double sum_terms(const trial *t, const float *terms) {
  double sum = 0.0;
  for (unsigned n = 0; n < get_row(t)->count_terms(&t->parameters); n++) sum += (double)terms[n];
  return sum;
}

/* By the definitions; 1e-6 for floats. */
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

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(terms_are_what_their_laws_say),
      cmocka_unit_test(walks_end_where_every_term_is_faint),
      cmocka_unit_test(powder_darkens_the_base_and_thin_places),
      cmocka_unit_test(the_derivative_is_the_fall_of_density_towards_the_sun),
      cmocka_unit_test(an_opaque_face_is_a_white_wall_under_the_derivative),
      cmocka_unit_test(gain_scales_each_approximation),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

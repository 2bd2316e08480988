/* SPDX-License-Identifier: Apache-2.0 */
/* Known answers for approximations of multiple scattering: each term alone, and in the march. */
#include "test_world.h"

#include "integrate/look.h"

enum { EDGE = 16 };

static const np_look octaves = {
    .gain = 1.0f, .octave_count = 3, .octave_light = 0.5f, .octave_depth = 0.25f, .octave_asymmetry = 0.0f};
static const np_look softened = {
    .kind = NP_LOOK_SOFTENED_BEER, .gain = 1.0f, .softened_share = 0.7f, .softened_rate = 0.25f};
static const np_look powder = {
    .kind = NP_LOOK_POWDER, .gain = 1.0f, .softened_share = 0.7f, .softened_rate = 0.25f, .powder_strength = 1.0f};
static const np_look derivative = {.kind = NP_LOOK_DERIVATIVE, .gain = 1.0f, .derivative_distance_m = 4.0f};

static double sum_terms(const np_look *look, const float *terms) {
  double sum = 0.0;
  for (unsigned n = 0; n < np_look_count_terms(look); n++) sum += (double)terms[n];
  return sum;
}

/* By the definitions; 1e-6 for floats. */
static void terms_are_what_their_laws_say(void **state) {
  (void)state;
  static const float depths[] = {0.0f, 0.3f, 1.0f, 4.0f, 20.0f};
  const np_phase phase = np_phase_henyey_greenstein(0.8f);
  float terms[NP_LOOK_TERMS_MAX], phases[NP_LOOK_TERMS_MAX];
  for (unsigned i = 0; i < sizeof depths / sizeof *depths; i++) {
    const double depth = (double)depths[i];
    np_look_fill_transmittances(&softened, depths[i], terms);
    assert_near(sum_terms(&softened, terms), fmax(exp(-depth), 0.7 * exp(-0.25 * depth)), 1e-6);
    np_look_fill_transmittances(&octaves, depths[i], terms);
    assert_near((double)terms[2], exp(-depth / 16.0), 1e-6);
  }
  np_look_fill_phases(&octaves, &phase, 0.4f, phases);
  assert_near_relative((double)phases[0], (double)np_phase_eval(&phase, 0.4f), 1e-6);
  assert_near_relative((double)phases[1], 0.5 / (4.0 * NP_PI), 1e-6);
  assert_near_relative((double)phases[2], 0.25 / (4.0 * NP_PI), 1e-6);
}

/* The slowest term has faded to e^{−16} where a walk towards the light stops. */
static void walks_end_where_every_term_is_faint(void **state) {
  (void)state;
  const np_look *looks[] = {&octaves, &softened, &powder};
  for (unsigned i = 0; i < 3; i++) {
    float terms[NP_LOOK_TERMS_MAX];
    np_look_fill_transmittances(looks[i], NP_TRACK_DEPTH_MAX / np_look_fade(looks[i]), terms);
    for (unsigned n = 0; n < np_look_count_terms(looks[i]); n++) assert_true((double)terms[n] <= 1.01 * exp(-16.0));
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

static double weigh(const test_world *w, const np_look *look, double z) {
  return (double)np_look_weight(look, &w->placed[0], np_dvec3_make(7.5, 7.5, z));
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
  np_look weak = powder;
  weak.powder_strength = 0.0f;
  assert_near(weigh(&w, &weak, 14.0), 1.0, 0.0);
  assert_near(weigh(&w, &softened, 14.0), 1.0, 0.0);
  test_world_destroy(&w);
}

static double slope(const test_world *w, double z) {
  return (double)np_look_slope(&derivative, &w->world, np_dvec3_make(7.5, 7.5, z), w->world.to_sun);
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

static double march(test_world *w, const np_look *look) {
  w->settings =
      (np_integrator_settings){.scattering_max = UINT32_MAX, .look = *look, .tolerance = 1e-5f, .step_voxels = 0.1f};
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
  const np_look *looks[] = {&octaves, &softened, &powder, &derivative};
  for (unsigned i = 0; i < 4; i++) {
    np_look bright = *looks[i];
    bright.gain = 3.0f;
    const double plain = march(&w, looks[i]);
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

/* SPDX-License-Identifier: Apache-2.0 */
/* Known answers for the artist's lights: each term alone, and what the march makes of them. */
#include "integrate/look.h"
#include "volume/tracking.h"

#include "core/units.h"
#include "test_support.h"
#include "volume/volume_private.h"

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

typedef struct fixture {
  neph_context *context;
  neph_volume *volume;
  np_instance placed;
  np_world world;
} fixture;

/* A box of EDGE³ samples 1 m apart: full up to half its height, half as dense above. */
static void start(fixture *f, float extinction_per_m) {
  static float values[EDGE * EDGE * EDGE];
  for (int n = 0; n < EDGE * EDGE * EDGE; n++) values[n] = n / EDGE / EDGE < EDGE / 2 ? 1.0f : 0.5f;
  neph_volume_dense_desc desc = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  for (int a = 0; a < 3; a++) desc.size[a] = EDGE;
  desc.values = values;
  f->context = test_context_create(1, NULL);
  assert_int_equal(neph_volume_create_dense(f->context, &desc, &f->volume), NEPH_OK);
  f->placed = (np_instance){.bricks = &f->volume->bricks,
                               .world_to_index = f->volume->world_to_index,
                               .extinction_per_value = extinction_per_m,
                               .albedo = np_spectrum_grey(1.0f),
                               .phase = np_phase_henyey_greenstein(0.8f),
                               .top_m = EDGE - 1};
  f->world = (np_world){
      .clouds.count = 1, .clouds.at = &f->placed, .to_sun = {0, 0, 1}, .sun_irradiance = np_spectrum_grey(1.0f)};
}

static void end(fixture *f) {
  neph_volume_release(f->volume);
  neph_context_destroy(f->context);
}

static double weigh(const fixture *f, const np_look *look, double z) {
  return (double)np_look_weight(look, &f->placed, np_dvec3_make(7.5, 7.5, z));
}

/* Schneider 2017: 0.1^0.8 at the base, 1 in dense cloud above; above 0.85 of the height half the density counts as
 * 0.05 + ½². Without strength, and for other looks, nothing is weighed. */
static void powder_darkens_the_base_and_thin_places(void **state) {
  (void)state;
  fixture f;
  start(&f, 0.3f);
  assert_near(weigh(&f, &powder, 0.5), pow(0.1, 0.8), 1e-5);
  assert_near(weigh(&f, &powder, 5.0), 1.0, 1e-5);
  assert_near(weigh(&f, &powder, 14.0), 0.05 + 0.25, 1e-5);
  np_look weak = powder;
  weak.powder_strength = 0.0f;
  assert_near(weigh(&f, &weak, 14.0), 1.0, 0.0);
  assert_near(weigh(&f, &softened, 14.0), 1.0, 0.0);
  end(&f);
}

static double slope(const fixture *f, double z) {
  return (double)np_look_slope(&derivative, &f->world, np_dvec3_make(7.5, 7.5, z), f->world.to_sun);
}

static void the_derivative_is_the_fall_of_density_towards_the_sun(void **state) {
  (void)state;
  fixture f;
  start(&f, 0.3f);
  assert_near(slope(&f, 2.0), 0.0, 1e-6);
  assert_near(slope(&f, 5.0), 0.5, 1e-6);
  assert_near(slope(&f, 13.0), 1.0, 1e-6);
  assert_near(slope(&f, -5.0), 0.0, 0.0);
  end(&f);
}

static double march(const fixture *f, const np_look *look) {
  const np_integrator_settings settings = {
      .scattering_max = UINT32_MAX, .look = *look, .tolerance = 1e-5f, .step_voxels = 0.1f};
  const np_camera_ray ray = {.origin = {7.5, 7.5, 100.0}, .direction = {0, 0, -1}, .jitter = 0.5f};
  np_random random = np_random_start(1, 0, 0, 0, 0);
  np_integrator_sample sample;
  np_integrator_get_kernels(neph_context_get_isa(f->context))->march(&f->world, &settings, &ray, &random, &sample);
  double sum = 0.0;
  for (int c = 0; c < NP_COMPONENT_COUNT; c++) sum += (double)sample.component[c].band[1];
  return sum;
}

/* A cloud too dense to see into, its face towards the sun, is a white wall: E/π. 1 %: the voxel in which the density
 * rises, that the slope from 4 m away does not see as a wall. */
static void an_opaque_face_is_a_white_wall_under_the_derivative(void **state) {
  (void)state;
  fixture f;
  start(&f, 200.0f);
  assert_near_relative(march(&f, &derivative), 1.0 / NP_PI, 0.01);
  end(&f);
}

static void gain_scales_what_a_look_gives(void **state) {
  (void)state;
  fixture f;
  start(&f, 0.3f);
  const np_look *looks[] = {&octaves, &softened, &powder, &derivative};
  for (unsigned i = 0; i < 4; i++) {
    np_look bright = *looks[i];
    bright.gain = 3.0f;
    const double plain = march(&f, looks[i]);
    assert_true(plain > 0.0);
    assert_near_relative(march(&f, &bright), 3.0 * plain, 1e-5);
  }
  end(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(terms_are_what_their_laws_say),
      cmocka_unit_test(walks_end_where_every_term_is_faint),
      cmocka_unit_test(powder_darkens_the_base_and_thin_places),
      cmocka_unit_test(the_derivative_is_the_fall_of_density_towards_the_sun),
      cmocka_unit_test(an_opaque_face_is_a_white_wall_under_the_derivative),
      cmocka_unit_test(gain_scales_what_a_look_gives),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Land cover by climate, and the reflection of rough ground. */
#include "terrain/land_cover.h"

#include "core/random.h"
#include "integrate/ground_scatter.h"
#include "test_support.h"

enum { PLACES = 8000 };

typedef struct cover_statistics {
  double mean[3], deviation; /* deviation: that in the middle band */
} cover_statistics;

/* Statistics over 400 km of a climate at one slope, height and footprint. */
static cover_statistics survey(neph_ground_cover climate, double slope_deg, double elevation_m, float footprint_m) {
  const np_noise_table *noise = np_noise_get_table(NEPH_ISA_X86_64);
  np_random random = np_random_start(3, 0, 0, 0, 0);
  cover_statistics out = {.deviation = 0.0};
  double square = 0.0;
  for (int n = 0; n < PLACES; n++) {
    float albedo[3];
    const np_cover_place place = {.east_m = 4e5 * np_random_double(&random),
                                  .north_m = 4e5 * np_random_double(&random),
                                  .elevation_m = (float)elevation_m,
                                  .slope_rad = (float)(slope_deg * NP_DEGREE),
                                  .footprint_m = footprint_m};
    np_land_cover_eval(climate, noise, &place, albedo);
    for (int b = 0; b < 3; b++) out.mean[b] += (double)albedo[b] / PLACES;
    square += (double)albedo[1] * (double)albedo[1] / PLACES;
  }
  out.deviation = sqrt(fmax(square - out.mean[1] * out.mean[1], 0.0));
  return out;
}

static void heights_and_slopes_have_their_cover(void **state) {
  (void)state;
  const cover_statistics meadow = survey(NEPH_GROUND_COVER_TEMPERATE, 0, 100, 0.0f);
  assert_true(meadow.mean[1] > meadow.mean[0] && meadow.mean[0] > meadow.mean[2]); /* green */
  const cover_statistics snow = survey(NEPH_GROUND_COVER_ALPINE, 5, 3500, 0.0f);
  assert_true(snow.mean[1] > 0.65);
  const cover_statistics wall = survey(NEPH_GROUND_COVER_ALPINE, 75, 3500, 0.0f);
  assert_near_relative(wall.mean[1], 0.152, 0.05);
  const cover_statistics sand = survey(NEPH_GROUND_COVER_DESERT, 0, 100, 0.0f);
  assert_true(sand.mean[0] > 1.2 * sand.mean[1] && sand.mean[1] > 1.2 * sand.mean[2]);
}

/* Noise that a footprint does not resolve leaves its mean: within 6 %, that of patches by rank and of samples. */
static void footprints_keep_the_mean(void **state) {
  (void)state;
  for (int k = NEPH_GROUND_COVER_TEMPERATE; k <= NEPH_GROUND_COVER_SAVANNA; k++) {
    const neph_ground_cover climate = (neph_ground_cover)k;
    const cover_statistics wide = survey(climate, 2, 300, (float)INFINITY);
    double before = INFINITY;
    assert_near(wide.deviation, 0.0, 1e-6);
    for (float footprint_m = 0.0f; footprint_m<2000.0f; footprint_m = footprint_m> 0.0f ? 8.0f * footprint_m : 2.0f) {
      const cover_statistics some = survey(climate, 2, 300, footprint_m);
      for (int b = 0; b < 3; b++) assert_near_relative(some.mean[b], wide.mean[b], 0.06);
      assert_true(some.deviation < before);
      before = some.deviation;
    }
    assert_true(survey(climate, 2, 300, 0.0f).deviation > 0.15 * wide.mean[1]);
  }
}

/* A camera that approaches sees no jump: 1 % of the footprint changes albedo by at most 0.02. */
static void detail_comes_without_a_jump(void **state) {
  (void)state;
  const np_noise_table *noise = np_noise_get_table(NEPH_ISA_X86_64);
  np_random random = np_random_start(4, 0, 0, 0, 0);
  for (int n = 0; n < 2000; n++) {
    np_cover_place place = {.east_m = 4e4 * np_random_double(&random),
                            .north_m = 4e4 * np_random_double(&random),
                            .elevation_m = (float)(3e3 * np_random_double(&random)),
                            .slope_rad = (float)np_random_double(&random),
                            .footprint_m = (float)exp2(12.0 * np_random_double(&random) - 2.0)};
    float here[3], nearer[3];
    np_land_cover_eval(NEPH_GROUND_COVER_ALPINE, noise, &place, here);
    place.footprint_m *= 0.99f;
    np_land_cover_eval(NEPH_GROUND_COVER_ALPINE, noise, &place, nearer);
    for (int b = 0; b < 3; b++) assert_near(nearer[b], here[b], 0.02);
  }
}

/* ---- Rough ground ---- */

static const np_vec3 up = {0.0f, 0.0f, 1.0f};

static np_vec3 make_direction(double cosine, double azimuth) {
  const double sine = sqrt(1.0 - cosine * cosine);
  return np_vec3_make((float)(sine * cos(azimuth)), (float)(sine * sin(azimuth)), (float)cosine);
}

/* Reciprocal, Lambert's law without roughness, brighter with the light behind the viewer, and as bright as Lambert's on
 * the mean of viewers under a uniform sky: within 1 %, what the bound near the horizon costs. */
static void rough_ground_is_reciprocal_and_keeps_light(void **state) {
  (void)state;
  np_random random = np_random_start(5, 0, 0, 0, 0);
  double sum = 0.0;
  enum { PAIRS = 200000 };
  for (int n = 0; n < PAIRS; n++) { /* cosine-weighted, both */
    const np_vec3 a = make_direction(sqrt(np_random_double(&random)), 2.0 * NP_PI * np_random_double(&random));
    const np_vec3 b = make_direction(sqrt(np_random_double(&random)), 2.0 * NP_PI * np_random_double(&random));
    const float ratio = np_ground_brdf_get_ratio(0.5f, up, a, b);
    sum += (double)ratio;
    assert_near_relative(np_ground_brdf_get_ratio(0.5f, up, b, a), ratio, 1e-5);
    assert_true(np_ground_brdf_get_ratio(0.0f, up, a, b) == 1.0f);
  }
  assert_near(sum / PAIRS, 1.0, 0.01);
  const np_vec3 sun = make_direction(0.5, 0.0);
  assert_true(np_ground_brdf_get_ratio(0.5f, up, make_direction(0.5, 0.0), sun) >
              1.5f * np_ground_brdf_get_ratio(0.5f, up, make_direction(0.5, NP_PI), sun));
}

/* A drawn path has the throughput that the integral over light gives. */
static void paths_leave_rough_ground_as_it_reflects(void **state) {
  (void)state;
  const np_ground_hit hit = {.normal = up, .albedo = np_spectrum_grey(0.4f), .roughness = 0.5f};
  np_random random = np_random_start(6, 0, 0, 0, 0);
  const np_vec3 flight = np_vec3_scale(make_direction(0.3, 1.0), -1.0f);
  enum { PATHS = 200000 };
  double drawn = 0.0, integral = 0.0;
  for (int n = 0; n < PATHS; n++) {
    np_spectrum throughput = np_spectrum_grey(1.0f);
    np_vec3 direction;
    float density;
    const np_ground_scatter scatter = np_ground_scatter_make(&hit, flight, &throughput);
    const np_vec3 light = make_direction(np_random_double(&random), 2.0 * NP_PI * np_random_double(&random));
    integral += 2.0 * NP_PI * (double)(throughput.band[0] * np_ground_scatter_eval(&scatter, light).value.band[0]);
    assert_true(np_ground_scatter_sample(&scatter, &random, &throughput, &direction, &density));
    assert_near_relative(np_ground_scatter_eval(&scatter, direction).density, density, 1e-3);
    drawn += (double)throughput.band[0];
  }
  assert_near_relative(drawn / PATHS, integral / PATHS, 0.01);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(heights_and_slopes_have_their_cover),
      cmocka_unit_test(footprints_keep_the_mean),
      cmocka_unit_test(detail_comes_without_a_jump),
      cmocka_unit_test(rough_ground_is_reciprocal_and_keeps_light),
      cmocka_unit_test(paths_leave_rough_ground_as_it_reflects),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

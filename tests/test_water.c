/* SPDX-License-Identifier: Apache-2.0 */
/* Water: reflection by its waves, compared with integrals over their slopes, and conservation of energy. */
#include "core/random.h"
#include "core/units.h"
#include "optics/water.h"
#include "test_support.h"

static const np_vec3 up = {0.0f, 0.0f, 1.0f};

static np_vec3 tilt(double angle_rad) { return np_vec3_make((float)sin(angle_rad), 0.0f, (float)cos(angle_rad)); }

static np_water make(double wind, float albedo) { return np_water_make(0.0, wind, np_spectrum_grey(albedo)); }

/* ((n − 1)/(n + 1))² at normal incidence, half the light's sum of squares at 45°, all at grazing (Hecht, Optics). */
static void fresnel_is_that_of_the_textbook(void **state) {
  (void)state;
  const double n = 1.33, normal = (n - 1.0) * (n - 1.0) / ((n + 1.0) * (n + 1.0));
  assert_near(np_water_fresnel(1.0f), normal, 1e-6); /* rounding of floats, here and below */
  for (int degrees = 5; degrees < 90; degrees += 5) {
    const double in = degrees * NP_DEGREE, out = asin(sin(in) / n);
    const double across = sin(in - out) / sin(in + out), along = tan(in - out) / tan(in + out);
    assert_near(np_water_fresnel((float)cos(in)), 0.5 * (across * across + along * along), 2e-6);
  }
  assert_near(np_water_fresnel(0.0f), 1.0, 1e-6);
}

/* Mean over a sphere of directions of what is scattered from a viewer, by midpoints in cosine and azimuth about the
 * mirror direction's: the waves' part, and the density, which is 1 less what leads below the surface. */
static void integrate(const np_water *water, np_vec3 viewer, double *out_reflected, double *out_scattered,
                      double *out_density) {
  enum { COSINES = 1200, AZIMUTHS = 720 };
  *out_reflected = *out_scattered = *out_density = 0.0;
  for (int i = 0; i < COSINES; i++)
    for (int j = 0; j < AZIMUTHS; j++) {
      const double root = (i + 0.5) / COSINES, cosine = root * root, sine = sqrt(1.0 - cosine * cosine);
      const double azimuth = 2.0 * NP_PI * (j + 0.5) / AZIMUTHS;
      const np_vec3 light = np_vec3_make((float)(sine * cos(azimuth)), (float)(sine * sin(azimuth)), (float)cosine);
      const np_water_value value = np_water_eval(water, up, viewer, light);
      const double sr = 2.0 * root / COSINES * 2.0 * NP_PI / AZIMUTHS;
      *out_reflected += sr * (double)value.reflected;
      *out_scattered += sr * (double)value.scattered.band[0];
      *out_density += sr * (double)value.density;
    }
}

/* Under an even white sky, water of any albedo sends back no more than it gets: its waves R, all of it 1 where nothing
 * stays in the water. R is tabulated at 33 angles and averaged over 512 facets, for 0.5 %; the sum shares the table, so
 * that its own error is that of R again. */
static void furnace_makes_no_energy(void **state) {
  (void)state;
  static const double winds[3] = {0.0, 5.0, 15.0};
  for (int w = 0; w < 3; w++) {
    const np_water white = make(winds[w], 1.0f), dark = make(winds[w], 0.0f);
    for (int degrees = 0; degrees < 90; degrees += 17) {
      double reflected, scattered, density, none;
      const np_vec3 viewer = tilt(degrees * NP_DEGREE);
      integrate(&white, viewer, &reflected, &scattered, &density);
      assert_near(reflected, np_water_reflectance(&white, viewer.z), 0.005);
      assert_near(scattered, 1.0, 0.006);
      assert_true(density < 1.002); /* the quadrature's error; all of it but for the facets that mirror downwards */
      if (degrees < 30) assert_true(density > 0.99);
      integrate(&dark, viewer, &none, &scattered, &density);
      assert_near(scattered, reflected, 1e-6);
    }
  }
}

/* Seen from above, waves change little: within 2 % of flat water's at 5 m/s. Near the horizon they mirror less than a
 * flat surface would, and more than a fifth. */
static void reflectance_rises_to_grazing(void **state) {
  (void)state;
  const np_water water = make(5.0, 0.0f);
  const double from_above = np_water_reflectance(&water, 1.0f);
  assert_near_relative(from_above, 0.0201, 0.02);
  double before = from_above;
  for (int degrees = 40; degrees <= 85; degrees += 5) {
    const double here = np_water_reflectance(&water, cosf((float)(degrees * NP_DEGREE)));
    assert_true(here > before);
    before = here;
  }
  assert_true(before > 0.2 && before < (double)np_water_fresnel(cosf((float)(85.0 * NP_DEGREE))));
}

/* The glint of a sun that is seen over smooth water peaks near the mirror direction, a little above it where it is
 * low; over a wind of 0 m/s slopes are 0.055, so that 3° are one standard deviation of the reflected ray's half. */
static void glint_peaks_at_the_mirror_direction(void **state) {
  (void)state;
  const np_water water = make(0.0, 0.0f);
  const np_vec3 sun = tilt(-40.0 * NP_DEGREE);
  double best = 0.0, at = 0.0;
  for (double degrees = 0.0; degrees < 90.0; degrees += 0.25) {
    const np_vec3 viewer = tilt(degrees * NP_DEGREE);
    const double radiance = (double)np_water_eval(&water, up, viewer, sun).reflected;
    if (radiance > best) best = radiance, at = degrees;
  }
  assert_near(at, 40.0, 3.0);
}

/* All sunlight that the waves reflect is the mean of Fresnel's reflectance over the slopes' normal distribution, each
 * counted by the sunlight that it takes: n·s/(n·z) over s·z. At a zenith angle of 30° and 5 m/s nothing hides. */
static void reflected_flux_is_the_mean_over_slopes(void **state) {
  (void)state;
  const np_water water = make(5.0, 0.0f);
  const np_vec3 sun = tilt(30.0 * NP_DEGREE);
  const double variance = 0.003 + 0.00512 * 5.0;
  enum { STEPS = 400 };
  double mean = 0.0;
  for (int i = 0; i < STEPS; i++)
    for (int j = 0; j < STEPS; j++) {
      const double x = 1.5 * (2.0 * (i + 0.5) / STEPS - 1.0), y = 1.5 * (2.0 * (j + 0.5) / STEPS - 1.0);
      const double density = exp(-(x * x + y * y) / variance) / (NP_PI * variance) * 9.0 / STEPS / STEPS;
      const double projected = -x * (double)sun.x + (double)sun.z; /* (n·s)/(n·z) */
      if (projected <= 0.0) continue;
      const double cosine = projected / sqrt(1.0 + x * x + y * y);
      mean += density * projected / (double)sun.z * (double)np_water_fresnel((float)cosine);
    }
  double reflected, scattered, density;
  integrate(&water, sun, &reflected, &scattered, &density); /* reciprocal: the viewer is the sun */
  assert_near_relative(reflected, mean, 0.005);             /* what little is hidden, and both quadratures */
}

/* The form by cosines is the same function: rounding of floats, which grows where both directions are nearly opposite.
 */
static void cosines_say_as_much_as_directions(void **state) {
  (void)state;
  const np_water water = make(7.0, 0.2f);
  np_random random = np_random_start(5, 0, 0, 0, 0);
  for (int n = 0; n < 2000; n++) {
    np_vec3 direction[2];
    for (int k = 0; k < 2; k++) {
      const float z = 0.05f + 0.95f * np_random_float(&random), azimuth = 2.0f * NP_PI_F * np_random_float(&random);
      const float sine = sqrtf(1.0f - z * z);
      direction[k] = np_vec3_make(sine * cosf(azimuth), sine * sinf(azimuth), z);
    }
    const float between = np_vec3_dot(direction[0], direction[1]);
    const np_spectrum whole = np_water_eval(&water, up, direction[0], direction[1]).scattered;
    const np_spectrum found = np_water_reflect_beam(&water, direction[0].z, direction[1].z, between);
    assert_near(found.band[1], whole.band[1], 1e-5 + 2e-3 * (double)whole.band[1]);
  }
}

/* Directions are drawn with the density that is stated, and with the weight BRDF·cosine/density: means of a function
 * over 2e5 draws against quadrature, within five standard errors of 0.15 %. */
static void draws_follow_their_density(void **state) {
  (void)state;
  const np_water water = make(5.0, 0.0f);
  static const double angles[3] = {0.0, 50.0, 85.0};
  for (int k = 0; k < 3; k++) {
    const np_vec3 viewer = tilt(angles[k] * NP_DEGREE);
    np_random random = np_random_start(1, 0, 0, 0, (uint32_t)k);
    enum { DRAWS = 200000 };
    double weights = 0.0, high = 0.0, expected = 0.0, expected_high = 0.0;
    for (int n = 0; n < DRAWS; n++) {
      float weight;
      const float u = np_random_float(&random), v = np_random_float(&random);
      const np_vec3 light = np_water_sample(&water, up, viewer, u, v, &weight);
      if (weight > 0.0f) {
        const np_water_value value = np_water_eval(&water, up, viewer, light);
        if (value.density > 1e-3f) assert_near_relative(value.reflected / value.density, weight, 0.01);
      }
      weights += (double)weight / DRAWS;
      high += (double)(weight * light.z) / DRAWS;
    }
    enum { COSINES = 1200, AZIMUTHS = 720 };
    for (int i = 0; i < COSINES; i++)
      for (int j = 0; j < AZIMUTHS; j++) {
        const double root = (i + 0.5) / COSINES, cosine = root * root, sine = sqrt(1.0 - cosine * cosine);
        const double azimuth = 2.0 * NP_PI * (j + 0.5) / AZIMUTHS;
        const np_vec3 light = np_vec3_make((float)(sine * cos(azimuth)), (float)(sine * sin(azimuth)), (float)cosine);
        const double share =
            2.0 * root / COSINES * 2.0 * NP_PI / AZIMUTHS * (double)np_water_eval(&water, up, viewer, light).reflected;
        expected += share;
        expected_high += share * cosine;
      }
    assert_near_relative(weights, expected, 0.0075);
    assert_near_relative(high, expected_high, 0.0075);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(fresnel_is_that_of_the_textbook),        cmocka_unit_test(furnace_makes_no_energy),
      cmocka_unit_test(reflectance_rises_to_grazing),           cmocka_unit_test(glint_peaks_at_the_mirror_direction),
      cmocka_unit_test(reflected_flux_is_the_mean_over_slopes), cmocka_unit_test(draws_follow_their_density),
      cmocka_unit_test(cosines_say_as_much_as_directions),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Known answers for both integrators, in a vacuum: no planet, no air, one cloud. */
#include <stdlib.h>

#include "integrate/blue_noise_table.h"
#include "test_world.h"

/* A cloud of albedo 1 in a uniform sky cannot be seen: every single path returns the sky's radiance, exactly. */
static void white_furnace_is_invisible(void **state) {
  (void)state;
  test_world w;
  test_world_create(&w, 1, test_cloud_make(test_lumpy_box, 2.0f, np_phase_droplets(20e-6)));
  w.world.environment_radiance = np_spectrum_make(1.0f, 2.0f, 3.0f);
  np_random random = np_random_start(1, 0, 0, 0, 0);
  int scattered = 0;
  for (int i = 0; i < 2000; i++) {
    const np_camera_ray ray = test_random_ray(&random);
    np_integrator_sample sample;
    test_world_path(&w, &ray, &random, &sample);
    for (int b = 0; b < NP_BAND_COUNT; b++) assert_near(test_sum_components(&sample, b), b + 1.0, 1e-6 * (b + 1));
    scattered += sample.transmittance == 0.0f;
  }
  assert_true(scattered > 1000);
  test_world_destroy(&w);
}

/* Beer and Lambert: 23 m of samples at 0.05 /m. The trilinear field ends at the outermost samples; the cells beyond
 * them fall to 0 over one voxel on either side, which adds two half voxels: 24 m. */
static void homogeneous_box_follows_beer_and_lambert(void **state) {
  (void)state;
  test_world w;
  test_world_create(&w, 1, test_cloud_make(test_full, 0.05f, np_phase_isotropic()));
  w.settings.tolerance = 1e-5f;
  const double expected = exp(-0.05 * TEST_EDGE);
  np_random random = np_random_start(2, 0, 0, 0, 0);
  test_tally path = {0};
  for (int i = 0; i < 20000; i++) {
    const np_camera_ray ray = test_random_ray(&random);
    np_integrator_sample sample;
    test_world_march(&w, &ray, &random, &sample);
    assert_near_relative((double)sample.transmittance, expected, 2e-5); /* float sums over some 30 steps */
    test_world_path(&w, &ray, &random, &sample);
    test_tally_add(&path, (double)sample.transmittance);
  }
  /* Four standard errors: one failure in 16,000 seeds. */
  assert_near(test_tally_mean(&path), expected, 4.0 * test_tally_error(&path));
  test_world_destroy(&w);
}

/* Transmittance before the disk has no noise down to a depth of 3, beyond which rays are thinned out. */
static void sun_is_seen_through_clouds_as_dim_as_they_make_it(void **state) {
  (void)state;
  test_world w;
  test_world_create(&w, 1, test_cloud_make(test_full, 0.1f, np_phase_isotropic()));
  w.world.to_sun = (np_vec3){0, 1, 0};
  w.world.disk = np_disk_make(w.world.to_sun, 0.01, np_spectrum_grey(1.0f));
  np_random random = np_random_start(3, 0, 0, 0, 0);
  for (int i = 0; i < 100; i++) {
    const np_camera_ray ray = test_random_ray(&random);
    np_integrator_sample sample;
    test_world_path(&w, &ray, &random, &sample);
    const double radiance = (double)np_world_disk_radiance(&w.world, ray.direction).band[0];
    assert_near_relative((double)sample.transmittance, exp(-0.1 * TEST_EDGE), 1e-5); /* sums in float */
    assert_near_relative((double)sample.component[NP_COMPONENT_BACKGROUND].band[0], exp(-0.1 * TEST_EDGE) * radiance,
                         1e-5);
  }
  test_world_destroy(&w);
}

/* The depth channel: half is hidden where the optical depth is ln 2. */
static void half_distance_is_where_half_is_hidden(void **state) {
  (void)state;
  test_world w;
  test_world_create(&w, 1, test_cloud_make(test_full, 0.2f, np_phase_isotropic()));
  const np_camera_ray ray = {.origin = {0.3, -100.0, 0.7}, .direction = {0, 1, 0}};
  /* The field rises over the voxel before the first sample at y = −11.5: half a voxel's worth. */
  const double expected = 100.0 - 11.5 - 0.5 + log(2.0) / 0.2;
  assert_near(test_integrators(w.context)->half_distance(&w.world, &ray, INFINITY), expected, 0.01);
  assert_true(isinf(test_integrators(w.context)->half_distance(&w.world, &ray, 90.0)));
  test_world_destroy(&w);
}

static void compare_single_scattering(np_phase phase, double tolerance) {
  test_world w;
  test_world_create(&w, 1, test_cloud_make(test_lumpy_box, 1.0f, phase));
  w.settings.scattering_max = 1;
  w.world.sun_irradiance = np_spectrum_make(1.0f, 2.0f, 0.5f);
  w.world.to_sun = np_vec3_normalize(np_vec3_make(0.6f, -0.5f, 0.7f));
  w.world.sun_angular_radius_rad = 0.005f;
  w.world.environment_radiance = np_spectrum_grey(0.1f);
  w.world.is_environment_upper_only = true;
  test_tally march[2] = {0}, path[2] = {0};
  np_random random = np_random_start(3, 0, 0, 0, 0);
  for (int i = 0; i < 60000; i++) {
    const np_camera_ray ray = test_random_ray(&random);
    np_integrator_sample sample;
    test_world_path(&w, &ray, &random, &sample);
    test_tally_add(&path[0], (double)sample.component[NP_COMPONENT_SUN].band[1]);
    test_tally_add(&path[1], (double)sample.component[NP_COMPONENT_SKY].band[1]);
    if (i % 4) continue;
    test_world_march(&w, &ray, &random, &sample);
    test_tally_add(&march[0], (double)sample.component[NP_COMPONENT_SUN].band[1]);
    test_tally_add(&march[1], (double)sample.component[NP_COMPONENT_SKY].band[1]);
  }
  for (int c = 0; c < 2; c++) {
    const double expected = test_tally_mean(&path[c]);
    const double noise = hypot(test_tally_error(&path[c]), test_tally_error(&march[c]));
    assert_near(test_tally_mean(&march[c]), expected, tolerance * expected + 4.0 * noise);
  }
  test_world_destroy(&w);
}

/* The march's tolerance of 1 % of a ray leaves less in the mean: 0.5 %, beside four standard errors. */
static void march_matches_path_in_single_scattering(void **state) {
  (void)state;
  compare_single_scattering(np_phase_isotropic(), 0.005);
  compare_single_scattering(np_phase_droplets(20e-6), 0.005);
}

/* A volume given twice at half the extinction is the same medium. */
static void overlapping_volumes_add(void **state) {
  (void)state;
  test_world one, two;
  const np_phase phase = np_phase_henyey_greenstein(0.6f);
  test_world_create(&one, 1, test_cloud_make(test_lumpy_box, 1.0f, phase));
  test_world_create(&two, 1, test_cloud_make(test_lumpy_box, 0.5f, phase));
  assert_int_equal(test_world_add(&two, test_cloud_make(test_lumpy_box, 0.5f, phase)), NEPH_OK);
  one.world.sun_irradiance = two.world.sun_irradiance = np_spectrum_grey(1.0f);
  test_tally whole = {0}, parts = {0};
  np_random random = np_random_start(4, 0, 0, 0, 0);
  for (int i = 0; i < 20000; i++) {
    const np_camera_ray ray = test_random_ray(&random);
    np_integrator_sample sample;
    test_world_path(&one, &ray, &random, &sample);
    test_tally_add(&whole, test_sum_components(&sample, 0));
    test_world_path(&two, &ray, &random, &sample);
    test_tally_add(&parts, test_sum_components(&sample, 0));
  }
  assert_near(test_tally_mean(&parts), test_tally_mean(&whole),
              4.0 * hypot(test_tally_error(&parts), test_tally_error(&whole)));
  const np_camera_ray ray = {.origin = {1.0, -100.0, 2.0}, .direction = {0, 1, 0}};
  np_integrator_sample expected, found;
  test_world_march(&one, &ray, &random, &expected);
  test_world_march(&two, &ray, &random, &found);
  assert_near_relative((double)found.transmittance, (double)expected.transmittance, 1e-5); /* rounding of a float sum */
  test_world_destroy(&one);
  test_world_destroy(&two);
}

/* A peak narrower than the sun's disk, seen towards its middle: of what is scattered once, τ·e^{−τ}
 * times the phase function's mean over the disk. By aiming at the disk alone, one sample in some thousand would see any
 * of it; met by chance as well, it is as quiet as any. */
static void disk_is_met_through_a_narrow_peak(void **state) {
  (void)state;
  enum { RINGS = 20000 };
  const double depth = 0.02, radius = 0.0046;
  test_world w;
  test_world_create(&w, 1, test_cloud_make(test_full, (float)(depth / TEST_EDGE), np_phase_henyey_greenstein(0.9999f)));
  w.settings.scattering_max = 1;
  w.world.sun_irradiance = np_spectrum_grey(1.0f);
  w.world.to_sun = np_vec3_make(0, 1, 0);
  w.world.sun_angular_radius_rad = (float)radius;
  double mean = 0.0;
  for (int i = 0; i < RINGS; i++) {
    const double s = sin(0.5 * radius);
    mean += (double)np_phase_eval(&w.placed[0].phase, (float)(2.0 * s * s * (i + 0.5) / RINGS)) / RINGS;
  }
  test_tally path = {0};
  np_random random = np_random_start(6, 0, 0, 0, 0);
  for (int i = 0; i < 20000; i++) {
    const np_camera_ray ray = test_random_ray(&random);
    np_integrator_sample sample;
    test_world_path(&w, &ray, &random, &sample);
    test_tally_add(&path, (double)sample.component[NP_COMPONENT_SUN].band[0]);
  }
  const double expected = depth * exp(-depth) * mean;
  print_message("narrow peak: %.5g +- %.2g, expected %.5g\n", test_tally_mean(&path), test_tally_error(&path),
                expected);
  assert_near(test_tally_mean(&path), expected, 4.0 * test_tally_error(&path));
  assert_true(test_tally_error(&path) < 0.02 * expected);
  test_world_destroy(&w);
}

/* Every instruction-set level computes the same physics: its mean is the others', within float rounding of one ray. */
static void levels_agree(void **state) {
  (void)state;
  test_world w;
  test_world_create(&w, 1, test_cloud_make(test_lumpy_box, 1.0f, np_phase_henyey_greenstein(0.6f)));
  w.world.sun_irradiance = np_spectrum_grey(1.0f);
  const np_camera_ray ray = {.origin = {1.0, -100.0, 2.0}, .direction = {0, 1, 0}, .jitter = 0.3f};
  double reference = 0;
  for (neph_isa isa = NEPH_ISA_X86_64; isa <= neph_context_get_isa(w.context); isa++) {
    np_random random = np_random_start(5, 0, 0, 0, 0);
    np_integrator_sample sample;
    np_integrator_get_kernels(isa)->march(&w.world, &w.lighting, &w.settings, &ray, &random, &sample);
    const double sun = (double)sample.component[NP_COMPONENT_SUN].band[0];
    if (isa == NEPH_ISA_X86_64) reference = sun;
    assert_near_relative(sun, reference, 1e-5);
  }
  test_world_destroy(&w);
}

/* All ranks once; and the mean distance of the lowest 1/16 of the ranks to their nearest neighbour is well above the
 * 2.0 pixels of random points of that density (an ideal lattice has 4.3). */
static void blue_noise_is_blue(void **state) {
  (void)state;
  enum { N = NP_BLUE_NOISE_EDGE };
  static bool seen[N * N];
  double total = 0;
  int count = 0;
  for (int p = 0; p < N * N; p++) {
    const int rank = np_blue_noise_ranks[p];
    assert_false(seen[rank]);
    seen[rank] = true;
    if (rank >= N * N / 16) continue;
    double nearest = N;
    for (int q = 0; q < N * N; q++) {
      if (q == p || np_blue_noise_ranks[q] >= N * N / 16) continue;
      const int dx = abs(p % N - q % N), dy = abs(p / N - q / N);
      nearest = fmin(nearest, hypot(dx < N - dx ? dx : N - dx, dy < N - dy ? dy : N - dy));
    }
    total += nearest;
    count++;
  }
  assert_true(total / count > 3.0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(white_furnace_is_invisible),
      cmocka_unit_test(homogeneous_box_follows_beer_and_lambert),
      cmocka_unit_test(sun_is_seen_through_clouds_as_dim_as_they_make_it),
      cmocka_unit_test(half_distance_is_where_half_is_hidden),
      cmocka_unit_test(march_matches_path_in_single_scattering),
      cmocka_unit_test(overlapping_volumes_add),
      cmocka_unit_test(disk_is_met_through_a_narrow_peak),
      cmocka_unit_test(levels_agree),
      cmocka_unit_test(blue_noise_is_blue),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Aiming at the sky: where it is bright, and that it changes no mean, only the noise. */
#include "caches/sky_guide.h"
#include "test_skies.h"
#include "test_world.h"

typedef struct fixture {
  test_world cloud;
  neph_atmosphere *atmosphere; /* NULL: none */
  neph_sky *sky;
  double height_m; /* height of the cloud's centre above the ground */
  np_sky_guide guide;
} fixture;

static void start(fixture *f, double height_m, float extinction_per_m, np_phase phase) {
  *f = (fixture){.height_m = height_m};
  test_cloud cloud = test_cloud_make(test_lumpy_box, extinction_per_m, phase);
  cloud.middle_m.z = height_m;
  test_world_create(&f->cloud, 1, cloud);
}

static void add_ground(fixture *f, float albedo) {
  f->cloud.world.has_planet = true;
  f->cloud.world.planet_radius_m = 6360e3;
  f->cloud.world.ground_albedo = np_spectrum_grey(albedo);
}

static void build_guide(fixture *f) {
  const np_sun_optical_depth_source depths = np_sun_optical_depths_get_source(&f->cloud.lighting.sun_optical_depths);
  np_sky_guide_build(&f->cloud.world, &depths, np_dvec3_make(0, 0, f->height_m), 1.0f, &f->guide);
}

/* The Earth's air about the cloud, under a sun of this zenith angle. */
static void start_on_earth(fixture *f, double sun_deg, float extinction_per_m, np_phase phase) {
  start(f, 1000.0, extinction_per_m, phase);
  add_ground(f, 0.3f);
  f->atmosphere = test_atmosphere_create(f->cloud.context, NULL);
  f->sky = test_sky_create(f->atmosphere, f->height_m, sun_deg);
  np_world *world = &f->cloud.world;
  world->to_sun = np_dvec3_to_float(test_direction(sun_deg, 0.0));
  world->sun_angular_radius_rad = 0.00467396f;
  world->sun_irradiance = np_spectrum_make(1.474f, 1.8504f, 1.91198f);
  world->atmosphere = f->atmosphere;
  world->camera_sky = world->cloud_sky = f->sky;
  build_guide(f);
}

static void end(fixture *f) {
  neph_sky_destroy(f->sky);
  neph_atmosphere_release(f->atmosphere);
  test_world_destroy(&f->cloud);
}

/* ---- The guide ---- */

/* One half of the sphere, brightest towards x: what no sky is, but light may come from anywhere. */
static void make_crooked_guide(np_sky_guide *guide) {
  float sum = 0.0f;
  *guide = (np_sky_guide){.rate = 0.7f, .excess_sr = 3.0f};
  for (int i = 0; i < NP_SKY_GUIDE_CELLS; i++) {
    const float edges[2] = {2.0f * (float)(i / NP_SKY_GUIDE_COLUMNS) / NP_SKY_GUIDE_ROWS - 1.0f,
                            2.0f * (float)(i / NP_SKY_GUIDE_COLUMNS + 1) / NP_SKY_GUIDE_ROWS - 1.0f};
    const float sr = (edges[1] * fabsf(edges[1]) - edges[0] * fabsf(edges[0])) * 2.0f * NP_PI_F / NP_SKY_GUIDE_COLUMNS;
    const float azimuth = 2.0f * NP_PI_F * ((float)(i % NP_SKY_GUIDE_COLUMNS) + 0.5f) / NP_SKY_GUIDE_COLUMNS;
    guide->density[i] = fmaxf(cosf(azimuth), 0.0f) * (edges[1] > 0.0f ? 3.0f : 1.0f);
    guide->cumulative[i] = sum += guide->density[i] * sr;
  }
  for (int i = 0; i < NP_SKY_GUIDE_CELLS; i++) {
    guide->density[i] /= sum;
    guide->cumulative[i] /= sum;
  }
}

/* A drawn direction has the density that np_sky_guide_eval returns, and the mean of 1 over it is the solid angle of all
 * that may be drawn; that of an even function over it is that function's integral. */
static void directions_are_drawn_as_they_are_weighed(void **state) {
  (void)state;
  np_sky_guide guide;
  make_crooked_guide(&guide);
  np_random random = np_random_start(1, 0, 0, 0, 0);
  test_tally solid_angle = {0}, height = {0};
  int differing = 0;
  for (int i = 0; i < 100000; i++) {
    float density;
    const np_vec3 d = np_sky_guide_draw(&guide, &random, &density);
    assert_true(density > 0.0f);
    assert_near(np_vec3_length(d), 1.0, 1e-6);
    differing += fabsf(np_sky_guide_eval(&guide, d) / density - 1.0f) > 1e-4f;
    test_tally_add(&solid_angle, 1.0 / (double)density);
    test_tally_add(&height, (double)(d.z * d.z) / (double)density);
  }
  assert_true(differing < 20); /* those on edges of cells, by the rounding of an angle */
  assert_near(test_tally_mean(&solid_angle), 2.0 * NP_PI, 4.0 * test_tally_error(&solid_angle));
  assert_near(test_tally_mean(&height), 2.0 * NP_PI / 3.0, 4.0 * test_tally_error(&height));
}

static void an_even_sky_is_not_aimed_at(void **state) {
  (void)state;
  fixture f;
  start(&f, 0.0, 0.1f, np_phase_isotropic());
  f.cloud.world.environment_radiance = np_spectrum_make(1.0f, 2.0f, 3.0f);
  build_guide(&f);
  assert_true(f.guide.rate == 0.0f && f.guide.excess_sr == 0.0f);
  f.cloud.world.environment_radiance = np_spectrum_grey(0.0f);
  build_guide(&f);
  assert_true(f.guide.rate == 0.0f && f.guide.excess_sr == 0.0f);
  end(&f);
}

/* The sun causes the noise of a day. At dusk a fifth to two fifths of the light comes from the glow over the sunset. */
static void dusk_is_aimed_at_and_day_is_not(void **state) {
  (void)state;
  for (int i = 0; i < 2; i++) {
    fixture f;
    start_on_earth(&f, i == 0 ? 94.0 : 60.0, 0.1f, np_phase_isotropic());
    print_message("sun %g deg high: aimed at %.3f times\n", i == 0 ? -4.0 : 30.0, (double)f.guide.rate);
    if (i == 1) assert_true(f.guide.rate == 0.0f);
    if (i == 0) {
      const np_vec3 glow = np_dvec3_to_float(test_direction(86.0, 0.0)), away = {-glow.x, glow.y, glow.z};
      assert_true(f.guide.rate > 0.2f && f.guide.rate < 0.4f);
      assert_true(np_sky_guide_eval(&f.guide, glow) > 1.0f / (4.0f * NP_PI_F));
      assert_true(np_sky_guide_eval(&f.guide, away) == 0.0f);
    }
    end(&f);
  }
}

/* ---- Paths ---- */

typedef struct estimate {
  test_tally all, sky; /* one band; `sky`: scattered once in the cloud */
} estimate;

static estimate trace(const fixture *f, int count, int band, uint64_t seed) {
  np_random random = np_random_start(seed, 0, 0, 0, 0);
  estimate e = {0};
  for (int i = 0; i < count; i++) {
    np_camera_ray ray = test_random_ray(&random);
    ray.origin.z += f->height_m;
    ray.choice = np_random_float(&random);
    np_integrator_sample sample;
    test_world_path(&f->cloud, &ray, &random, &sample);
    test_tally_add(&e.all, test_sum_components(&sample, band));
    test_tally_add(&e.sky, (double)sample.component[NP_COMPONENT_SKY].band[band]);
  }
  return e;
}

static void assert_same(const char *what, const test_tally *a, const test_tally *b) {
  print_message("%s: %.6g +- %.2g, %.6g +- %.2g\n", what, test_tally_mean(a), test_tally_error(a), test_tally_mean(b),
                test_tally_error(b));
  assert_near(test_tally_mean(a), test_tally_mean(b), 4.0 * hypot(test_tally_error(a), test_tally_error(b)));
}

/* However crooked the guide: a white cloud under an even sky stays invisible, from either way with the air, and
 * over white ground. */
static void furnace_stays_white(void **state) {
  (void)state;
  for (int traced = 0; traced < 2; traced++)
    for (int ground = 0; ground < 2; ground++) {
      fixture f;
      start(&f, ground ? 30.0 : 0.0, 1.0f, np_phase_henyey_greenstein(0.6f));
      make_crooked_guide(&f.guide);
      f.cloud.lighting.sky_guide = &f.guide;
      f.cloud.world.environment_radiance = np_spectrum_grey(1.0f);
      f.cloud.settings.is_air_traced = traced;
      if (ground) add_ground(&f, 1.0f);
      const estimate e = trace(&f, 40000, 0, 3);
      print_message("%s%s: %.6g +- %.2g\n", traced ? "traced" : "tables", ground ? ", ground" : "",
                    test_tally_mean(&e.all), test_tally_error(&e.all));
      assert_near(test_tally_mean(&e.all), 1.0, 4.0 * test_tally_error(&e.all));
      assert_true(test_tally_error(&e.all) > 0.0); /* or nothing was aimed at */
      end(&f);
    }
}

/* A thin isotropic cloud that half the sphere shines on scatters out half of what it takes from a ray of light: with
 * what it hides left out, its radiance is half its opacity. A share of 1e-3, its optical depth, is scattered twice.
 */
static void thin_cloud_scatters_out_what_it_gets(void **state) {
  (void)state;
  fixture f;
  start(&f, 0.0, 1e-4f, np_phase_isotropic());
  make_crooked_guide(&f.guide);
  f.cloud.world.environment_radiance = np_spectrum_grey(1.0f);
  f.cloud.world.is_environment_upper_only = true;
  for (int aims = 0; aims < 2; aims++) {
    f.cloud.lighting.sky_guide = aims ? &f.guide : NULL;
    np_random random = np_random_start(4, 0, 0, 0, 0);
    test_tally share = {0};
    for (int i = 0; i < 40000; i++) {
      const np_camera_ray ray = test_random_ray(&random);
      np_integrator_sample sample;
      test_world_path(&f.cloud, &ray, &random, &sample);
      if (sample.transmittance == 1.0f || sample.component[NP_COMPONENT_MULTIPLE].band[0] > 0.0f) continue;
      const double bound = 1.0 - (double)sample.transmittance;
      test_tally_add(&share, (double)sample.component[NP_COMPONENT_SKY].band[0] / bound);
    }
    print_message("share of the sky: %.6g +- %.2g\n", test_tally_mean(&share), test_tally_error(&share));
    assert_near(test_tally_mean(&share), 0.5, 4.0 * test_tally_error(&share) + 2e-3);
  }
  end(&f);
}

/* The same light at dusk, a thin cloud's and a thick one's, all of it and what is scattered once, with less noise:
 * `gain` times less variance at least. */
static void compare_dusk(float extinction_per_m, float asymmetry, bool is_traced, double gain) {
  fixture f;
  start_on_earth(&f, 94.0, extinction_per_m, np_phase_henyey_greenstein(asymmetry));
  f.cloud.settings.is_air_traced = is_traced;
  if (is_traced) f.guide.rate /= np_sky_guide_traced_cost;
  const int count = is_traced ? 10000 : 40000;
  const estimate chance = trace(&f, count, 0, 5);
  f.cloud.lighting.sky_guide = &f.guide;
  const estimate aimed = trace(&f, count, 0, 6);
  assert_same("all", &aimed.all, &chance.all);
  assert_same("sky", &aimed.sky, &chance.sky);
  const double ratio = test_tally_error(&chance.sky) / test_tally_error(&aimed.sky);
  print_message("variance of the sky's light: %.2f times less\n", ratio * ratio);
  assert_true(ratio * ratio > gain);
  end(&f);
}

static void dusk_has_the_same_light_and_less_noise(void **state) {
  (void)state;
  compare_dusk(0.02f, 0.0f, false, 2.5);  /* 3.9 */
  compare_dusk(1.0f, 0.85f, false, 1.15); /* 1.4 */
  /* Through air that is traced the air's own noise comes on top, and with it in what the variance is known to. */
  compare_dusk(0.02f, 0.0f, true, 1.2); /* 2.3 */
  compare_dusk(1.0f, 0.85f, true, 0.0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(directions_are_drawn_as_they_are_weighed),
      cmocka_unit_test(an_even_sky_is_not_aimed_at),
      cmocka_unit_test(dusk_is_aimed_at_and_day_is_not),
      cmocka_unit_test(furnace_stays_white),
      cmocka_unit_test(thin_cloud_scatters_out_what_it_gets),
      cmocka_unit_test(dusk_has_the_same_light_and_less_noise),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

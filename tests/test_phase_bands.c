/* SPDX-License-Identifier: Apache-2.0 */
/* Phase functions with colour: tables against what they are computed from, rainbows and halos where they are seen, and
 * light in both integrators. */
#include <nephos/nephos.h>
#include <stdlib.h>

#include "core/random.h"
#include "core/units.h"
#include "optics/ice_prism.h"
#include "optics/ice_table.h"
#include "optics/mie.h"
#include "optics/phase_bands.h"
#include "optics/refraction.h"
#include "test_support.h"

typedef test_fixture fixture;

static int set_up(void **state) { return test_set_up_cached(state, 2, "bands.csv"); }

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

static const double wavelengths_nm[NP_BAND_COUNT] = {680.0, 550.0, 440.0};

static np_phase_bands build(const fixture *f, np_phase_source source) {
  np_phase_bands bands;
  if (np_phase_bands_build(f->context, NULL, &source, wavelengths_nm, &bands)) fail_msg("%s", f->log.text);
  return bands;
}

static float to_versine(double angle_deg) {
  const double sine = sin(0.5 * angle_deg * NP_DEGREE);
  return (float)(2.0 * sine * sine);
}

static double eval(const np_phase_bands *bands, int band, double angle_deg) {
  return (double)np_phase_table_eval(&bands->band[band], to_versine(angle_deg));
}

/* ---- Tables ---- */

/* Between rows 0.4 % of the light is misplaced at the most, and where droplets have many sizes values are those of Mie
 * theory within 0.2 % (root mean square over angles; one size has minima near 0). The mean cosine is right to 1e-4. */
static void tables_agree_with_mie_theory(void **state) {
  enum { ANGLES = 400 };
  static const double cases[][2] = {{0.1, 0.1}, {2, 0.1}, {8, 0.1}, {8, 0.02}, {30, 0.1}, {20, 0}};
  fixture *f = *state;
  np_random random = np_random_start(1, 0, 0, 0, 0);
  double angle_rad[ANGLES], value[ANGLES];
  for (unsigned k = 0; k < sizeof cases / sizeof *cases; k++) {
    np_phase_bands bands = build(f, (np_phase_source){.kind = NEPH_PHASE_MIE,
                                                      .effective_radius_m = cases[k][0] * 1e-6,
                                                      .effective_variance = cases[k][1]});
    const np_mie_sizes sizes = {cases[k][0] * 1e-6, cases[k][1]};
    np_mie_efficiency mean;
    for (int i = 0; i < ANGLES; i++) angle_rad[i] = NP_PI * pow(np_random_double(&random), 2.0);
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      const np_refractive_index water = {np_refraction_get_water(wavelengths_nm[b]), 0};
      assert_int_equal(np_mie_compute_phase(f->context, NULL, &sizes, wavelengths_nm[b] * 1e-9, water, ANGLES,
                                            angle_rad, value, &mean),
                       NEPH_OK);
      assert_near((double)bands.asymmetry[b], mean.asymmetry, 1e-4);
      double square = 0.0, misplaced = 0.0, light = 0.0;
      for (int i = 0; i < ANGLES; i++) {
        const double error = eval(&bands, b, angle_rad[i] / NP_DEGREE) - value[i];
        const double weight = sin(angle_rad[i]) * sqrt(angle_rad[i]); /* angles are denser forwards by 1/sqrt */
        square += error * error / (value[i] * value[i]) / ANGLES;
        misplaced += weight * fabs(error);
        light += weight * value[i];
      }
      printf("%g um, variance %g, band %d: rms %.5f, misplaced %.6f, g %.6f, %u rows\n", cases[k][0], cases[k][1], b,
             sqrt(square), misplaced / light, mean.asymmetry, bands.mean.count);
      assert_true(misplaced < 0.004 * light);
      if (cases[k][1] > 0.0) assert_true(sqrt(square) < 0.002);
    }
    np_phase_bands_clear(&bands);
  }
}

static const np_phase_source examples[] = {
    {.kind = NEPH_PHASE_MIE, .effective_radius_m = 8e-6, .effective_variance = 0.1},
    {.kind = NEPH_PHASE_RAIN, .mode_diameter_m = 0.5e-3},
    {.kind = NEPH_PHASE_ICE, .habit = NEPH_ICE_MIXED},
    {.kind = NEPH_PHASE_ICE, .habit = NEPH_ICE_COLUMN},
    {.kind = NEPH_PHASE_ICE, .habit = NEPH_ICE_PLATE},
};
enum { EXAMPLES = sizeof examples / sizeof *examples };

/* The grey value is the mean of the bands; a band's phase function is its value in that band; each integrates to one by
 * its samples' pdf: 1/p averages to the sphere's solid angle. */
static void bands_have_a_mean_and_samples(void **state) {
  fixture *f = *state;
  for (int k = 0; k < EXAMPLES; k++) {
    np_phase_bands bands = build(f, examples[k]);
    const np_phase phase = np_phase_of_bands(&bands);
    np_random random = np_random_start(2, k, 0, 0, 0);
    double cosine = 0.0;
    enum { SAMPLES = 20000 };
    for (int i = 0; i < SAMPLES; i++) {
      const float u[3] = {np_random_float(&random), np_random_float(&random), np_random_float(&random)};
      const np_vec3 forward = {0, 0, 1};
      const np_phase blue = np_phase_get_band(&phase, 2);
      float value;
      const np_vec3 out = np_phase_sample(&blue, forward, u, &value);
      const np_spectrum all = np_phase_eval_bands(&phase, 1.0f - out.z);
      assert_near_relative((double)np_phase_eval(&phase, 1.0f - out.z), (double)np_spectrum_mean(all), 1e-5);
      assert_near_relative((double)np_phase_eval(&blue, 1.0f - out.z), (double)all.band[2], 1e-5);
      cosine += (double)out.z;
    }
    printf("%d g %.4f %.4f %.4f rows %u\n", k, (double)bands.asymmetry[0], (double)bands.asymmetry[1],
           (double)bands.asymmetry[2], bands.mean.count);
    assert_near(cosine / SAMPLES, (double)bands.asymmetry[2], 0.01);
    if (examples[k].kind == NEPH_PHASE_ICE && examples[k].habit == NEPH_ICE_MIXED)
      for (int b = 0; b < NP_BAND_COUNT; b++) assert_near((double)bands.asymmetry[b], (double)np_ice_asymmetry, 0.003);
    np_phase_bands_clear(&bands);
  }
}

/* A second build reads what the first has written, and tables have the same bits. */
static void tables_are_kept_on_disk(void **state) {
  fixture *f = *state;
  for (int k = 0; k < EXAMPLES; k++) {
    np_phase_bands first = build(f, examples[k]), second = build(f, examples[k]);
    assert_int_equal(first.mean.count, second.mean.count);
    for (int b = 0; b < NP_BAND_COUNT; b++)
      assert_memory_equal(first.band[b].value, second.band[b].value, first.mean.count * sizeof(float));
    np_phase_bands_clear(&first);
    np_phase_bands_clear(&second);
  }
}

/* The table of the mixed habit, traced anew: its codes within one, for 0.2 % each, and between its rows 0.3 % rms. */
static void the_table_of_ice_is_traced_rays(void **state) {
  enum { BETWEEN = 500, COUNT = NP_ICE_TABLE_ROWS + BETWEEN };
  fixture *f = *state;
  np_random random = np_random_start(3, 0, 0, 0, 0);
  double angle_rad[COUNT], traced[COUNT], read[COUNT];
  for (int k = 0; k < NP_ICE_TABLE_PIECES; k++)
    for (int i = 0; i < np_ice_table_pieces[k].count; i++)
      angle_rad[np_ice_table_pieces[k].first + i] =
          (np_ice_table_pieces[k].begin_deg + i * np_ice_table_pieces[k].step_deg) * NP_DEGREE;
  for (int i = NP_ICE_TABLE_ROWS; i < COUNT; i++) angle_rad[i] = NP_PI * np_random_double(&random);
  for (int b = 0; b < NP_ICE_TABLE_BANDS; b++) {
    const double nm = np_ice_table_nm[b];
    double straight, read_straight, square = 0.0;
    assert_true(np_ice_table_read(nm * 1e-9, COUNT, angle_rad, read, &read_straight));
    assert_int_equal(np_ice_prism_trace(f->context, NULL, NEPH_ICE_MIXED, np_refraction_get_ice(nm), COUNT, angle_rad,
                                        traced, &straight),
                     NEPH_OK);
    assert_near(straight, read_straight, 2e-6);
    for (int i = 0; i < NP_ICE_TABLE_ROWS; i++)
      assert_true(abs((int)np_ice_table_encode(traced[i]) - (int)np_ice_table_codes[b][i]) <= 1);
    for (int i = NP_ICE_TABLE_ROWS; i < COUNT; i++) square += pow(read[i] / traced[i] - 1.0, 2.0) / BETWEEN;
    print_message("ice at %.1f nm: %.3f %% rms between rows\n", nm, 100.0 * sqrt(square));
    assert_true(sqrt(square) < 0.003);
  }
  assert_false(np_ice_table_read(550e-9, COUNT, angle_rad, read, traced));
}

/* ---- Rainbows and halos ---- */

/* Angle of the greatest value, or of the greatest rise of the value, between two angles. */
static double search_greatest(const np_phase_bands *bands, int band, double from_deg, double to_deg, bool is_rise) {
  double best = -1.0, place = from_deg;
  for (double angle = from_deg; angle <= to_deg; angle += 0.02) {
    const double rise = eval(bands, band, angle + 0.05) - eval(bands, band, angle - 0.05);
    const double value = is_rise ? rise : eval(bands, band, angle);
    if (value > best) {
      best = value;
      place = angle;
    }
  }
  return place;
}

/* Scattering angles: 180° less what is seen from the antisolar point. */
static void rain_has_both_rainbows(void **state) {
  static const double diameters_mm[] = {0.3, 0.5, 1.0};
  for (int k = 0; k < 3; k++) {
    np_phase_bands bands =
        build(*state, (np_phase_source){.kind = NEPH_PHASE_RAIN, .mode_diameter_m = diameters_mm[k] * 1e-3});
    double primary[NP_BAND_COUNT], secondary[NP_BAND_COUNT];
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      primary[b] = search_greatest(&bands, b, 132, 145, false);
      secondary[b] = search_greatest(&bands, b, 122, 132, false);
      printf("%g mm: %.2f %.2f dark %.5f\n", diameters_mm[k], primary[b], secondary[b], eval(&bands, b, 133));
      assert_true(primary[b] > 137.6 && primary[b] < 139.7);
      assert_true(secondary[b] > 126 && secondary[b] < 130);
      /* Alexander's band between the bows is dark. */
      assert_true(eval(&bands, b, 133) < 0.1 * eval(&bands, b, primary[b]));
    }
    assert_true(primary[0] < primary[1] && primary[1] < primary[2]);
    assert_true(secondary[0] > secondary[1] && secondary[1] > secondary[2]);
    np_phase_bands_clear(&bands);
  }
}

/* Minimum deviation through faces at 60°: 21.65, 21.9 and 22.35° for red, green and blue; at 90°: 45.1, 45.7 and 46.8°.
 */
static void ice_has_both_halos(void **state) {
  for (int k = 2; k < EXAMPLES; k++) {
    np_phase_bands bands = build(*state, examples[k]);
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      const double n = np_refraction_get_ice(wavelengths_nm[b]);
      const double near = 2.0 * asin(n * sin(30 * NP_DEGREE)) / NP_DEGREE - 60.0;
      const double far = 2.0 * asin(n * sin(45 * NP_DEGREE)) / NP_DEGREE - 90.0;
      printf("%d halo %.2f (%.2f), %.2f (%.2f), contrast %.2f\n", k, search_greatest(&bands, b, 19, 25, true), near,
             search_greatest(&bands, b, 43, 50, true), far, eval(&bands, b, near + 0.3) / eval(&bands, b, near - 1));
      assert_near(search_greatest(&bands, b, 19, 25, true), near, 0.15);
      assert_near(search_greatest(&bands, b, 43, 50, true), far, 0.5);
      assert_true(eval(&bands, b, near + 0.3) > 4.0 * eval(&bands, b, near - 1.0));
    }
    np_phase_bands_clear(&bands);
  }
}

/* ---- Light ---- */

/* A cube of 100 m, seen from 1 km, the sun at an angle behind it; a sky of `sky`. */
static const char scene_text[] =
    "version: 1\n"
    "environment: {planet: none, radiance: %g}\n"
    "camera: {position: [0 m, -1 km, 0 m], look_at: [0, 0, 0], fov: 0.5 deg, resolution: [4, 4]}\n"
    "sun: {elevation: 0 deg, azimuth: %g deg, irradiance: %g W/m2/nm}\n"
    "render: {integrator: %s, samples: %u}\n"
    "output: {color_space: bands, pixel_type: float}\n";

enum { CUBE_EDGE = 10 };

typedef struct look {
  np_phase_source phase;
  double sky, sun, angle_deg, depth;
} look;

static void add_cube(fixture *f, const look *l, neph_scene *scene) {
  static float values[CUBE_EDGE * CUBE_EDGE * CUBE_EDGE];
  neph_volume_dense_desc dense = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  neph_placement_desc p = NEPH_PLACEMENT_DESC_DEFAULT;
  neph_volume *volume;
  for (size_t i = 0; i < sizeof values / sizeof *values; i++) values[i] = 1.0f;
  dense.values = values;
  for (int a = 0; a < 3; a++) {
    dense.size[a] = CUBE_EDGE;
    dense.index_to_world[a][a] = 10.0;
  }
  assert_int_equal(neph_volume_create_dense(f->context, &dense, &volume), NEPH_OK);
  p.has_position = true;
  p.position_m[2] = -0.5 * 10.0 * CUBE_EDGE;
  p.density_value = l->depth / (10.0 * CUBE_EDGE);
  for (int b = 0; b < 3; b++) p.albedo[b] = 1.0;
  p.phase = l->phase.kind;
  p.effective_radius_m = l->phase.effective_radius_m;
  p.effective_variance = l->phase.effective_variance;
  p.rain_mode_diameter_m = l->phase.mode_diameter_m;
  p.ice_habit = l->phase.habit;
  assert_int_equal(neph_scene_add_volume(scene, volume, &p, NULL), NEPH_OK);
  neph_volume_release(volume);
}

typedef struct light {
  double mean[3], error[3];
} light;

/* Means of the bands, and their standard errors by the spread over the pixels. */
static light render(fixture *f, const look *l, const char *integrator, unsigned samples) {
  static const char *const names[] = {"R", "G", "B"};
  char text[2048];
  light out;
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  (void)snprintf(text, sizeof text, scene_text, l->sky, l->angle_deg, l->sun, integrator, samples);
  if (neph_scene_load_text(f->context, text, "bands.yaml", &scene)) fail_msg("%s", f->log.text);
  add_cube(f, l, scene);
  if (neph_render_image(scene, NULL, &image)) fail_msg("%s", f->log.text);
  for (int b = 0; b < 3; b++) {
    const float *values = neph_image_get_channel(image, names[b]);
    double sum = 0.0, square = 0.0;
    for (int p = 0; p < 16; p++) {
      sum += (double)values[p] / 16.0;
      square += (double)values[p] * (double)values[p] / 16.0;
    }
    out.mean[b] = sum;
    out.error[b] = sqrt(fmax(square - sum * sum, 0.0) / 15.0);
  }
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  return out;
}

/* In a uniform sky a cloud of albedo 1 cannot be seen, in any band. */
static void a_white_furnace_is_white(void **state) {
  for (int k = 0; k < EXAMPLES; k++) {
    const look l = {examples[k], 1.0, 0.0, 90.0, 10.0};
    const light path = render(*state, &l, "path", 256);
    printf("%d: %.4f %.4f %.4f ± %.4f\n", k, path.mean[0], path.mean[1], path.mean[2], path.error[0]);
    for (int b = 0; b < 3; b++) assert_near(path.mean[b], 1.0, 4.0 * path.error[b] + 1e-3);
  }
}

/* Angles at which phase functions are nearly straight between the pixels of the picture and the points of the sun's
 * disk. */
static const double angles_deg[EXAMPLES] = {4.0, 30.0, 23.5, 23.5, 23.5};

/* A thin cloud has the phase function of each band: within 3 % at a depth of 0.001, and the noise of the tracer. */
static void thin_clouds_have_the_colors_of_their_phase_functions(void **state) {
  fixture *f = *state;
  for (int k = 0; k < EXAMPLES; k++) {
    np_phase_bands bands = build(f, examples[k]);
    const look l = {examples[k], 0.0, 1.0, angles_deg[k], 0.001};
    const light march = render(f, &l, "march", 16), path = render(f, &l, "path", 1024);
    for (int b = 0; b < 3; b++) {
      const double expected = 0.001 * eval(&bands, b, angles_deg[k]);
      printf("%d band %d: expected %.4g march %.4f path %.4f ± %.4f\n", k, b, expected, march.mean[b] / expected,
             path.mean[b] / expected, path.error[b] / expected);
      assert_near(march.mean[b], expected, 0.03 * expected);
      assert_near(path.mean[b], expected, 0.03 * expected + 4.0 * path.error[b]);
    }
    np_phase_bands_clear(&bands);
  }
}

/* Light that is scattered more than once has the mean of the bands' phase functions in the march: within 5 % of the
 * tracer in each band. */
static void integrators_agree_in_each_band(void **state) {
  static const double depths[] = {1.0, 8.0}, angles[] = {30.0, 150.0};
  for (int k = 0; k < 3; k++)
    for (int i = 0; i < 4; i++) {
      const look l = {examples[k], 0.0, 1.0, angles[i / 2], depths[i % 2]};
      const light march = render(*state, &l, "march", 16), path = render(*state, &l, "path", 512);
      for (int b = 0; b < 3; b++) {
        printf("%d depth %g angle %g band %d: %.5g, march %.4f ± %.4f\n", k, l.depth, l.angle_deg, b, path.mean[b],
               march.mean[b] / path.mean[b], path.error[b] / path.mean[b]);
        assert_near(march.mean[b], path.mean[b], 0.05 * path.mean[b] + 3.0 * path.error[b]);
      }
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(tables_agree_with_mie_theory),   TEST(bands_have_a_mean_and_samples),
      TEST(tables_are_kept_on_disk),        TEST(the_table_of_ice_is_traced_rays),
      TEST(rain_has_both_rainbows),         TEST(ice_has_both_halos),
      TEST(a_white_furnace_is_white),       TEST(thin_clouds_have_the_colors_of_their_phase_functions),
      TEST(integrators_agree_in_each_band),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Light prepared for a viewer is that of the moments, as far as cells are seen from one direction; the march along a
 * ray from there sees the same cloud; threads change no bit; failures leave nothing. */
#include "test_world.h"

enum { CLOUDS = 3 };

/* Three lumpy balls 20 m apart, the last of them like the first. */
static void start(test_world *w, unsigned threads) {
  test_world_init(w, test_context_create(threads, NULL));
  for (unsigned v = 0; v < CLOUDS; v++) {
    const np_phase phase = v == 1 ? np_phase_two_lobe(0.5f, -0.3f, 0.3f) : np_phase_henyey_greenstein(0.7f);
    test_cloud cloud = test_cloud_make(test_lumpy_ball, 0.5f, phase);
    cloud.middle_m.x = 20.0 * (v - 1.0);
    assert_int_equal(test_world_add(w, cloud), NEPH_OK);
    w->placed[v].albedo = np_spectrum_make(1.0f, 0.9f, 0.5f);
  }
  w->world.sun_irradiance = np_spectrum_grey(1.0f);
  w->world.to_sun = np_vec3_make(0.6f, 0.0f, 0.8f);
  w->desc.cells.bounds_min = np_dvec3_make(-32.0, -12.0, -12.0);
  w->desc.cells.bounds_max = np_dvec3_make(32.0, 12.0, 12.0);
  assert_int_equal(test_world_solve(w), NEPH_OK);
}

static np_viewer_light build(const test_world *w, np_dvec3 viewer) {
  np_viewer_light light;
  assert_int_equal(np_viewer_light_build(w->context, w->scattering, viewer, NULL, &light), NEPH_OK);
  return light;
}

/* A place in a cloud. */
static np_dvec3 draw_place(np_random *random, unsigned cloud) {
  const double x = np_random_double(random), y = np_random_double(random), z = np_random_double(random);
  return np_dvec3_make(20.0 * (cloud - 1.0) + 12.0 * x - 6.0, 12.0 * y - 6.0, 12.0 * z - 6.0);
}

/* Radiance that one cloud scatters out to a viewer, by all moments. */
static np_spectrum compute_outgoing(const test_world *w, np_dvec3 place, np_dvec3 viewer, unsigned cloud) {
  float harmonics[NP_HARMONIC_COUNT_MAX], outgoing[NP_HARMONIC_COUNT_MAX];
  np_light_moments moments;
  const np_dvec3 way = np_dvec3_normalize(np_dvec3_subtract(viewer, place));
  np_scattering_field_fill_harmonics(w->scattering, np_dvec3_to_float(way), harmonics);
  np_scattering_field_fill_outgoing(w->scattering, cloud, harmonics, outgoing);
  np_scattering_field_gather(w->scattering, place, &moments);
  return np_scattering_field_get_outgoing(w->scattering, &moments, outgoing);
}

/* Root mean square over places and bands of the difference, over the mean. */
static double measure_difference(const test_world *w, np_dvec3 viewer) {
  np_viewer_light light = build(w, viewer);
  const np_scattering_medium *medium = np_scattering_field_get_medium(w->scattering);
  np_random random = np_random_start(1, 2, 3, 4, 5);
  double squares = 0.0, sum = 0.0;
  int count = 0;
  for (unsigned n = 0; n < 6000; n++) {
    const np_dvec3 at = draw_place(&random, n % CLOUDS);
    if (np_dvec3_length(np_dvec3_subtract(at, viewer)) < light.distance_min) continue;
    const np_spectrum expected = compute_outgoing(w, at, viewer, n % CLOUDS);
    np_scattering_cells cells;
    np_scattering_field_gather_cells(w->scattering, at, &cells);
    const np_spectrum found = np_viewer_light_outgoing(&light, &cells, medium->clouds[n % CLOUDS].phase_kind);
    for (int b = 0; b < NP_BAND_COUNT; b++, count++) {
      squares += pow((double)(found.band[b] - expected.band[b]), 2.0);
      sum += (double)expected.band[b];
    }
  }
  np_viewer_light_clear(&light);
  return count > 0 ? sqrt(squares / count) / (sum / count) : -1.0;
}

/* Cells are of 2 m, and from one to the next light changes by a third or so. A third of ¼·Δφ·ΔY, for its root mean
 * square over a cell, with ΔY = 2 m·l/distance of degrees 1 to 3: 1e-4 from 1 km, 1e-3 from 100 m. Of a ball 65 m away
 * the nearest cells, nearer than 32 of their widths, are left out; the others are as far as 110 m. */
static void prepared_light_is_that_of_the_moments(void **state) {
  (void)state;
  test_world w;
  start(&w, 2);
  const double far = measure_difference(&w, np_dvec3_make(100.0, -1000.0, 50.0));
  const double near = measure_difference(&w, np_dvec3_make(0.0, -100.0, 0.0));
  const double beside = measure_difference(&w, np_dvec3_make(85.0, 0.0, 0.0));
  if (!(far >= 0.0 && far < 1e-4)) fail_msg("from afar %g", far);
  if (!(near >= 0.0 && near < 1e-3)) fail_msg("from near %g", near);
  if (!(beside >= 0.0 && beside < 2e-3)) fail_msg("from the side %g", beside);
  test_world_destroy(&w);
}

/* Clouds of one phase function share their outgoing radiance. */
static void equal_clouds_share_a_table(void **state) {
  (void)state;
  test_world w;
  start(&w, 1);
  np_viewer_light light = build(&w, np_dvec3_make(0.0, -100.0, 0.0));
  const np_scaled_cloud *clouds = np_scattering_field_get_medium(w.scattering)->clouds;
  assert_int_equal(light.phase_count, 2);
  assert_int_equal(clouds[2].phase_kind, clouds[0].phase_kind);
  assert_int_not_equal(clouds[1].phase_kind, clouds[0].phase_kind);
  np_viewer_light_clear(&light);
  test_world_destroy(&w);
}

static double march(const test_world *w, np_dvec3 origin, np_vec3 direction) {
  np_random random = np_random_start(9, 0, 0, 0, 0);
  const np_camera_ray ray = {.origin = origin, .direction = direction, .jitter = 0.5f};
  np_integrator_sample sample;
  test_world_march(w, &ray, &random, &sample);
  return test_sum_components(&sample, 1);
}

/* Rays from the viewer, 50 cells away, are within half a per cent of the sum of all moments; others are equal to the
 * bit. */
static void rays_from_the_viewer_ask_it_and_no_others(void **state) {
  (void)state;
  test_world w;
  start(&w, 2);
  const np_dvec3 viewer = np_dvec3_make(0.0, -100.0, 0.0), other = np_dvec3_make(0.0, -99.0, 0.0);
  np_viewer_light light = build(&w, viewer);
  for (int n = 0; n < 20; n++) {
    const np_vec3 direction = np_vec3_normalize(np_vec3_make(0.02f * (float)(n - 10), 1.0f, 0.01f));
    w.lighting.viewer_light = NULL;
    const double gathered[2] = {march(&w, viewer, direction), march(&w, other, direction)};
    w.lighting.viewer_light = &light;
    assert_near(march(&w, viewer, direction), gathered[0], 5e-3 * gathered[0]);
    assert_near(march(&w, other, direction), gathered[1], 0.0);
  }
  np_viewer_light_clear(&light);
  test_world_destroy(&w);
}

static void threads_change_no_bit(void **state) {
  (void)state;
  test_world w[2];
  np_viewer_light light[2];
  for (unsigned i = 0; i < 2; i++) {
    start(&w[i], 1 + 2 * i);
    light[i] = build(&w[i], np_dvec3_make(0.0, -100.0, 0.0));
  }
  const size_t count = np_scattering_field_count_cells(w[0].scattering) * light[0].phase_count * light[0].band_count;
  assert_memory_equal(light[0].outgoing, light[1].outgoing, count * sizeof(float));
  for (unsigned i = 0; i < 2; i++) {
    np_viewer_light_clear(&light[i]);
    test_world_destroy(&w[i]);
  }
}

static void cancelling_leaves_nothing(void **state) {
  (void)state;
  test_world w;
  start(&w, 2);
  np_monitor monitor;
  np_monitor_start(&monitor, w.context, NULL, NULL);
  atomic_store(&monitor.is_cancelled, true);
  np_viewer_light light;
  assert_int_equal(np_viewer_light_build(w.context, w.scattering, np_dvec3_make(0.0, -100.0, 0.0), &monitor, &light),
                   NEPH_ERROR_CANCELLED);
  assert_null(light.outgoing);
  test_world_destroy(&w);
}

/* Failures with a finished solution: those of its inputs are elsewhere (test_scattering_field.c). */
static neph_result attempt(neph_context *context, void *solved) {
  const test_world *w = solved;
  np_viewer_light light;
  const neph_result result =
      np_viewer_light_build(context, w->scattering, np_dvec3_make(0.0, -100.0, 0.0), NULL, &light);
  assert_int_equal(light.outgoing == NULL, result != NEPH_OK);
  np_viewer_light_clear(&light);
  return result;
}

static void a_failed_allocation_leaves_nothing_behind(void **state) {
  (void)state;
  test_world w;
  start(&w, 1);
  assert_survives_failed_allocations(attempt, &w);
  test_world_destroy(&w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(prepared_light_is_that_of_the_moments),
      cmocka_unit_test(equal_clouds_share_a_table),
      cmocka_unit_test(rays_from_the_viewer_ask_it_and_no_others),
      cmocka_unit_test(threads_change_no_bit),
      cmocka_unit_test(cancelling_leaves_nothing),
      cmocka_unit_test(a_failed_allocation_leaves_nothing_behind),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Known answers for the solved multiple scattering: furnace, conservation; and that it fails cleanly. */
#include "test_lumpy.h"

/* Amid even light a cloud that absorbs nothing cannot be seen. The solution is exact for it; 1 % is left for the
 * march's steps and the tolerance of the iteration. */
static void a_white_cloud_vanishes_in_a_furnace(void **state) {
  (void)state;
  test_world w;
  test_lumpy_create(&w, 2);
  w.world.environment_radiance = np_spectrum_make(0.5f, 2.0f, 3.0f);
  test_lumpy_solve(&w);
  np_random random = np_random_start(1, 2, 3, 4, 5);
  for (int n = 0; n < 200; n++) {
    const np_dvec3 origin = np_dvec3_make(24.0 * np_random_double(&random), -20.0, 24.0 * np_random_double(&random));
    assert_near(test_lumpy_march(&w, origin, np_vec3_make(0, 1, 0), &random), 2.0, 0.02);
  }
  test_world_destroy(&w);
}

static float eval_peak(const np_peak_column *column, float sun_optical_depth) {
  return np_peak_column_mix(column, 0, np_peak_place_get(sun_optical_depth), np_transmittance(sun_optical_depth), 1.0f);
}

/* In the thin limit the direct term is the phase function itself, and at any depth of the peak its mean over all
 * directions is what was scattered: f in the peak, 1 − f outside it. */
static void the_direct_term_is_the_phase_function_and_conserves(void **state) {
  (void)state;
  neph_context *context = test_context_create(1, NULL);
  const np_phase phase = np_phase_droplets(20e-6);
  np_scaled_phase scaled;
  assert_int_equal(np_scaled_phase_init(context, &phase, NP_DEGREE_MIN, &scaled), NEPH_OK);
  static const float depths[] = {0.0f, 0.5f, 2.0f};
  double sums[3] = {0};
  const int count = 20000;
  for (int n = 0; n < count; n++) {
    /* Points crowd into the peak: versine 2u⁴. */
    const double u = (n + 0.5) / count, versine = 2.0 * u * u * u * u, width = 8.0 * u * u * u / count;
    np_peak_column column;
    np_scaled_phase_fill_column(&scaled, (float)versine, &column);
    const double exact = (double)np_phase_eval(&phase, (float)versine);
    assert_near_relative((double)eval_peak(&column, 0.0f), exact, 1e-4);
    for (int d = 0; d < 3; d++) sums[d] += 2.0 * NP_PI * width * (double)eval_peak(&column, depths[d]);
  }
  /* 2 %: the cut at 0 where the series of the spread peak rings, deep inside where little light is left. */
  for (int d = 0; d < 3; d++) assert_near_relative(sums[d], 1.0, 0.02);
  np_scaled_phase_clear(&scaled);
  neph_context_destroy(context);
}

static void assert_same_for_threads(test_world *one, test_world *two) {
  one->world.sun_irradiance = two->world.sun_irradiance = np_spectrum_make(1.0f, 0.9f, 0.8f);
  test_lumpy_solve(one);
  test_lumpy_solve(two);
  assert_int_equal(one->scattering->grid.active_count, two->scattering->grid.active_count);
  assert_memory_equal(one->scattering->moments, two->scattering->moments,
                      one->scattering->grid.active_count *
                          np_scattering_field_get_offset(one->scattering, one->scattering->medium.band_count) *
                          sizeof *one->scattering->moments);
  test_world_destroy(one);
  test_world_destroy(two);
}

/* Also where lines of cells are no whole number of tiles, which then are cut differently from either end. */
static void threads_change_no_bit(void **state) {
  (void)state;
  test_world one, two;
  test_lumpy_create(&one, 1);
  test_lumpy_create(&two, 2);
  assert_same_for_threads(&one, &two);
  test_lumpy_create_fine(&one, 1);
  test_lumpy_create_fine(&two, 2);
  one.desc.cells.bounds_max = two.desc.cells.bounds_max = np_dvec3_make(TEST_EDGE, TEST_EDGE + 10, TEST_EDGE + 10);
  assert_same_for_threads(&one, &two);
}

static np_spectrum compute_light(const test_world *w, np_dvec3 position) {
  float harmonics[NP_HARMONIC_COUNT_MAX], outgoing[NP_HARMONIC_COUNT_MAX];
  np_light_moments moments;
  np_scattering_field_fill_harmonics(w->scattering, np_vec3_make(0, 0, 1), harmonics);
  np_scattering_field_fill_outgoing(w->scattering, 0, harmonics, outgoing);
  np_scattering_field_gather(w->scattering, position, &moments);
  return np_scattering_field_get_outgoing(w->scattering, &moments, outgoing);
}

/* Lights of one colour: the second and third band are the first one, scaled, and cost nothing. Solved each for itself,
 * where one light is not of that colour, they are the same to the solver's tolerance. */
static void grey_bands_are_one(void **state) {
  (void)state;
  test_world one, three;
  test_lumpy_create(&one, 1);
  test_lumpy_create(&three, 1);
  one.world.sun_irradiance = np_spectrum_make(1.0f, 0.0f, 0.0f);
  three.world.sun_irradiance = np_spectrum_make(1.0f, 0.9f, 0.8f);
  test_lumpy_solve(&one);
  test_lumpy_solve(&three);
  assert_int_equal(three.scattering->sweeps, one.scattering->sweeps);
  assert_int_equal(three.scattering->medium.band_count, 1);
  three.world.environment_radiance = np_spectrum_make(0.0f, 0.0f, 1e-6f);
  test_world apart;
  test_lumpy_create(&apart, 1);
  apart.world = three.world;
  test_lumpy_solve(&apart);
  assert_int_equal(apart.scattering->medium.band_count, NP_BAND_COUNT);
  const np_dvec3 middle =
      np_transport_grid_centre(&one.scattering->grid, one.scattering->grid.cell[one.scattering->grid.active_count / 2]);
  const np_spectrum together = compute_light(&three, middle), each = compute_light(&apart, middle);
  for (int b = 0; b < NP_BAND_COUNT; b++) assert_near_relative(each.band[b], together.band[b], 2e-3);
  assert_near_relative(together.band[2], 0.8f * together.band[0], 1e-6);
  test_world_destroy(&one);
  test_world_destroy(&three);
  test_world_destroy(&apart);
}

static void cancelling_leaves_nothing(void **state) {
  (void)state;
  test_world w;
  test_lumpy_create(&w, 2);
  np_monitor monitor;
  np_monitor_start(&monitor, w.context, NULL, NULL);
  atomic_store(&monitor.is_cancelled, true);
  w.world.sun_irradiance = np_spectrum_grey(1.0f);
  const np_sun_optical_depth_source depths = np_sun_optical_depths_get_source(&w.lighting.sun_optical_depths);
  assert_int_equal(np_scattering_field_build(w.context, &w.world, &depths, &w.desc, &monitor, &w.scattering),
                   NEPH_ERROR_CANCELLED);
  assert_null(w.scattering);
  test_world_destroy(&w);
}

/* A clock that goes on by a second whenever it is read: before every loop, for one. */
static double read_ticks(void *user) {
  double *ticks = user;
  return *ticks += 1.0;
}

static void solve_in_ticks(test_world *w, double ticks) {
  np_monitor monitor;
  double clock_s = 0.0;
  np_monitor_start(&monitor, w->context, NULL, NULL);
  monitor.read_clock_s = read_ticks;
  monitor.clock_user = &clock_s;
  monitor.start_s = monitor.last_report_s = 0.0;
  np_scattering_field_destroy(w->scattering);
  w->desc.seconds_max = ticks;
  const np_sun_optical_depth_source depths = np_sun_optical_depths_get_source(&w->lighting.sun_optical_depths);
  assert_int_equal(np_scattering_field_build(w->context, &w->world, &depths, &w->desc, &monitor, &w->scattering),
                   NEPH_OK);
  assert_false(np_monitor_is_cancelled(&monitor));
}

/* The mean radiance of a band in a cell, but for a factor. */
static double get_radiance(const np_scattering_field *s, size_t active, unsigned band) {
  float moments[NP_HARMONIC_COUNT_MAX];
  np_scattering_field_read_band(s, active, band, moments);
  return (double)moments[0];
}

/* Its sum over the cells. */
static double sum_radiance(const np_scattering_field *s, unsigned band) {
  double sum = 0.0;
  for (size_t active = 0; active < s->grid.active_count; active++) sum += get_radiance(s, active, band);
  return sum;
}

/* Whenever time ends the sweeps there is a solution, of all bands, that says so: at first of what went straight on
 * alone, then darker than the converged one by less and less. The last budget outlasts the sweeps and changes no bit.
 * 5 %: a solution on coarser cells may be that much brighter than the one on fine ones. */
static void assert_time_cuts(np_spectrum albedo, np_spectrum sun) {
  static const double ticks[] = {1.0, 30.0, 100.0, 300.0, 1000.0, 3000.0, 1e9};
  test_world w;
  test_lumpy_create(&w, 2);
  w.placed[0].albedo = albedo;
  w.world.sun_irradiance = sun;
  w.world.environment_radiance = np_spectrum_grey(0.01f);
  test_lumpy_solve(&w);
  const size_t count =
      w.scattering->grid.active_count * np_scattering_field_get_offset(w.scattering, w.scattering->medium.band_count);
  np_scattering_field *converged = w.scattering;
  w.scattering = NULL;
  assert_false(converged->quality.is_cut);
  unsigned cuts = 0;
  for (size_t i = 0; i < sizeof ticks / sizeof *ticks; i++) {
    solve_in_ticks(&w, ticks[i]);
    cuts += w.scattering->quality.is_cut;
    assert_int_equal(w.scattering->medium.band_count, NP_BAND_COUNT);
    for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
      const double share = sum_radiance(w.scattering, b) / sum_radiance(converged, b);
      assert_true(share >= 0.0 && share < 1.05);
    }
    if (i == 0) assert_true(w.scattering->quality.is_cut && w.scattering->quality.residual >= 1.0);
    assert_true(w.scattering->quality.is_cut || w.scattering->quality.residual <= w.desc.tolerance);
  }
  assert_true(cuts >= 2 && !w.scattering->quality.is_cut);
  assert_memory_equal(w.scattering->moments, converged->moments, count * sizeof *converged->moments);
  np_scattering_field_destroy(converged);
  test_world_destroy(&w);
}

static void time_cuts_the_solution_of_every_band(void **state) {
  (void)state;
  assert_time_cuts(np_spectrum_make(0.9f, 0.95f, 0.999f), np_spectrum_grey(1.0f));
  assert_time_cuts(np_spectrum_grey(0.999f), np_spectrum_make(1.0f, 0.9f, 0.7f));
}

/* Largest difference of two solutions' mean radiance in any cell and band, over the band's mean. */
static double compare_radiance(const np_scattering_field *a, const np_scattering_field *b) {
  const size_t cells = a->grid.active_count;
  double largest = 0.0;
  for (unsigned band = 0; band < NP_BAND_COUNT; band++)
    for (size_t active = 0; active < cells; active++) {
      const double difference = get_radiance(a, active, band) - get_radiance(b, active, band);
      largest = fmax(largest, fabs(difference) / (sum_radiance(b, band) / (double)cells));
    }
  return largest;
}

/* A lumpy ball under a sun and a sky of other colours. `is_coloured`: its bands differ in their light. */
static void solve_grey(test_world *w, double tolerance, bool is_coloured) {
  test_lumpy_create(w, 2);
  w->world.sun_irradiance = is_coloured ? np_spectrum_make(1.0f, 0.9f, 0.7f) : np_spectrum_grey(1.0f);
  w->world.environment_radiance = is_coloured ? np_spectrum_make(0.02f, 0.05f, 0.1f) : np_spectrum_grey(0.02f);
  w->placed[0].extinction_per_value *= 10.0f;
  w->desc.cells.edge_min_m = 1.0;
  w->desc.work_max = 0.0;
  w->desc.degree_max = NP_DEGREE_MIN;
  w->desc.tolerance = tolerance;
  test_lumpy_solve(w);
}

/* Bands of grey clouds differ by what coarse cells resolve: a further one takes half of the first one's sweeps, for the
 * same solution. A residual of 2.5e-3 leaves up to four of it in single cells. */
static void further_bands_take_half_the_sweeps(void **state) {
  (void)state;
  test_world one, all, exact;
  solve_grey(&one, 2.5e-3, false);
  solve_grey(&all, 2.5e-3, true);
  solve_grey(&exact, 1e-5, true);
  assert_int_equal(one.scattering->medium.band_count, 1);
  assert_int_equal(all.scattering->medium.band_count, NP_BAND_COUNT);
  assert_true(all.scattering->sweeps <= 2 * one.scattering->sweeps);
  assert_true(all.scattering->quality.residual <= 2.5e-3);
  assert_true(compare_radiance(all.scattering, exact.scattering) < 1e-2);
  test_world_destroy(&one);
  test_world_destroy(&all);
  test_world_destroy(&exact);
}

static neph_result attempt(neph_context *context, void *user) {
  test_world *w = user;
  test_world_init(w, context);
  w->world.sun_irradiance = np_spectrum_grey(1.0f);
  w->world.to_sun = np_vec3_make(0.6f, 0.0f, 0.8f);
  w->desc.tolerance = 0.3;
  w->desc.work_max = 0.0;
  neph_result result = test_world_add(w, test_cloud_make_on_axes(test_lumpy_ball, 0.0));
  if (!result) result = test_world_solve(w);
  test_world_clear(w);
  return result;
}

static void a_failed_allocation_leaves_nothing_behind(void **state) {
  (void)state;
  test_world w;
  assert_survives_failed_allocations(attempt, &w);
}

/* The harmonics of one octant of a pair are those of the other with the sign of the odd ones turned. */
static void check_pair(const np_ordinates *o, unsigned pair, unsigned block, unsigned lane) {
  float up[NP_HARMONIC_COUNT_MAX], down[NP_HARMONIC_COUNT_MAX];
  np_harmonics_eval(o->degree, np_ordinates_direction(o, 2 * pair, block, lane), up);
  np_harmonics_eval(o->degree, np_ordinates_direction(o, 2 * pair + 1, block, lane), down);
  for (unsigned i = 0; i < np_harmonics_count(o->degree); i++) {
    const unsigned place = o->place[i];
    assert_true(o->harmonic[pair][block][place][lane] == up[i]);
    assert_float_equal(down[i], place < o->even_count ? up[i] : -up[i], 1e-5f); /* values are up to 4, by recurrence */
  }
}

static void octants_of_a_pair_share_their_harmonics(void **state) {
  (void)state;
  static const unsigned degrees[] = {NP_DEGREE_MIN, 7, NP_DEGREE_MAX};
  static np_ordinates o;
  for (size_t n = 0; n < sizeof degrees / sizeof *degrees; n++) {
    np_ordinates_init(degrees[n], false, &o);
    const unsigned count = np_harmonics_count(degrees[n]);
    assert_int_equal(o.even_count % 2, 0);
    assert_int_equal((count - o.even_count) % 2, 0);
    for (unsigned pair = 0; pair < NP_OCTANT_PAIRS; pair++)
      for (unsigned i = 0; i < o.count; i++) check_pair(&o, pair, i / NP_ORDINATE_LANES, i % NP_ORDINATE_LANES);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_white_cloud_vanishes_in_a_furnace),
      cmocka_unit_test(the_direct_term_is_the_phase_function_and_conserves),
      cmocka_unit_test(threads_change_no_bit),
      cmocka_unit_test(grey_bands_are_one),
      cmocka_unit_test(cancelling_leaves_nothing),
      cmocka_unit_test(time_cuts_the_solution_of_every_band),
      cmocka_unit_test(further_bands_take_half_the_sweeps),
      cmocka_unit_test(a_failed_allocation_leaves_nothing_behind),
      cmocka_unit_test(octants_of_a_pair_share_their_harmonics),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

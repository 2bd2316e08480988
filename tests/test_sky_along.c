/* SPDX-License-Identifier: Apache-2.0 */
/* Air along rays between two places, by rules of few points, against the same rays in many parts. */
#include "test_support.h"

#include <stdlib.h>
#include <string.h>

#include "atmosphere/sky_along.h"

enum { RAYS = 200, PARTS = 40, CELLS = 6 };

/* Largest difference of a band, relative to a spectrum's brightest. */
static double compare(np_spectrum a, np_spectrum b, np_spectrum whole) {
  double worst = 0.0;
  for (int k = 0; k < NP_BAND_COUNT; k++) worst = fmax(worst, fabs((double)a.band[k] - (double)b.band[k]));
  return worst / fmax((double)np_spectrum_max(whole), 1e-30);
}

static double draw(unsigned n, double step) { return fmod(0.5 + step * n, 1.0); }

/* The n-th ray, from up to 5 km high. */
static void choose_ray(unsigned n, np_dvec3 *origin, np_vec3 *towards) {
  const double z = 2.0 * draw(n, 0.8191725133961645) - 1.0, azimuth = 2.0 * NP_PI * draw(n, 0.6710436067037893);
  const double r = sqrt(1.0 - z * z);
  *origin = np_dvec3_make(0.0, 0.0, 10.0 + 5e3 * draw(n, 0.5497004779019703));
  *towards = np_vec3_make((float)(r * cos(azimuth)), (float)(r * sin(azimuth)), (float)z);
}

/* Distance to the ground, or a far one. */
static double get_end(np_dvec3 origin, np_vec3 towards) {
  return towards.z < 0.0f ? fmin(6e4, -0.999 * origin.z / (double)towards.z) : 6e4;
}

/* Error of one ray up to a distance. */
static double compare_air(const neph_sky *sky, np_dvec3 origin, np_vec3 towards, double distance_m) {
  const np_hemisphere_shares shares = np_sky_compute_hemisphere_shares(sky, towards);
  np_air_parts parts[PARTS];
  double ends[PARTS];
  for (int i = 0; i < PARTS; i++) ends[i] = distance_m * (i + 1) / PARTS;
  np_sky_trace_parts(sky, origin, towards, ends, PARTS, &shares, parts);
  const np_aerial_perspective air = np_sky_trace_air(sky, origin, towards, distance_m);
  const np_air_parts *whole = &parts[PARTS - 1];
  return fmax(compare(air.inscatter, whole->all, whole->all),
              compare(air.transmittance, whole->transmittance, whole->transmittance));
}

/* Largest error of cells whose ends lie as the squares of their numbers. */
static double compare_cells(const neph_sky *sky, np_dvec3 origin, np_vec3 towards, double distance_m) {
  const np_hemisphere_shares shares = np_sky_compute_hemisphere_shares(sky, towards);
  np_air_parts cells[CELLS], parts[PARTS];
  double ends[CELLS], fine[PARTS], worst = 0.0;
  for (int i = 0; i < CELLS; i++) ends[i] = distance_m * (i + 1) * (i + 1) / (CELLS * CELLS);
  np_sky_trace_parts(sky, origin, towards, ends, CELLS, &shares, cells);
  for (int i = 0; i < CELLS; i++) {
    for (int k = 0; k < PARTS; k++) fine[k] = ends[i] * (k + 1) / PARTS;
    np_sky_trace_parts(sky, origin, towards, fine, PARTS, &shares, parts);
    const np_air_parts *a = &cells[i], *b = &parts[PARTS - 1];
    worst = fmax(worst, fmax(compare(a->all, b->all, b->all), compare(a->first, b->first, b->all)));
    worst = fmax(worst, fmax(compare(a->upper, b->upper, b->upper), compare(a->lower, b->lower, b->lower)));
  }
  return worst;
}

/* Airs, suns and largest relative errors. After sunset the planet's shadow, which has an edge, lies on the low air. */
static const struct {
  const char *air;
  double haze_m; /* scale height of the aerosol; 0: the preset's */
  double sun_deg, most;
} cases[] = {{"earth", 0, 60, 2e-4},      {"earth", 0, 4, 5e-4},    {"earth", 0, -4, 5e-3},
             {"earth-hazy", 0, 35, 2e-3}, {"earth", 150, 35, 2e-3}, {"mars", 0, 35, 2e-3}};

static neph_atmosphere *create_air(neph_context *context, const char *name, double haze_m) {
  neph_atmosphere_layer layers[NEPH_EARTH_LAYER_COUNT];
  neph_atmosphere_desc desc = NEPH_ATMOSPHERE_DESC_DEFAULT;
  neph_atmosphere *out;
  assert_int_equal(neph_atmosphere_get_preset(context, name, &desc, NULL), NEPH_OK);
  if (haze_m > 0.0) {
    memcpy(layers, neph_earth_layers, sizeof layers);
    layers[1].height_m = haze_m;
    desc.layers = layers;
  }
  assert_int_equal(neph_atmosphere_create(context, &desc, &out), NEPH_OK);
  return out;
}

static void rays_are_near_those_of_many_parts(void **state) {
  test_fixture *f = *state;
  for (size_t s = 0; s < sizeof cases / sizeof *cases; s++) {
    neph_atmosphere *air = create_air(f->context, cases[s].air, cases[s].haze_m);
    neph_sky *sky;
    neph_sky_desc desc = NEPH_SKY_DESC_DEFAULT;
    double worst_air = 0.0, worst_cells = 0.0;
    desc.sun_direction[0] = cos(cases[s].sun_deg * NP_DEGREE),
    desc.sun_direction[2] = sin(cases[s].sun_deg * NP_DEGREE);
    desc.observer_m[2] = 1000.0;
    assert_int_equal(neph_sky_create(air, &desc, &sky), NEPH_OK);
    for (unsigned n = 0; n < RAYS; n++) {
      np_dvec3 origin;
      np_vec3 towards;
      choose_ray(n, &origin, &towards);
      const double end = get_end(origin, towards);
      worst_air = fmax(worst_air, compare_air(sky, origin, towards, end * draw(n, 0.7548776662466927)));
      worst_cells = fmax(worst_cells, compare_cells(sky, origin, towards, end));
    }
    print_message("%s, haze of %g m, sun %+.0f deg: rays err by %.1e, cells by %.1e at most\n", cases[s].air,
                  cases[s].haze_m, cases[s].sun_deg, worst_air, worst_cells);
    assert_true(worst_air < cases[s].most && worst_cells < cases[s].most);
    neph_sky_destroy(sky);
    neph_atmosphere_release(air);
  }
}

static int set_up(void **state) { return test_set_up(state, 2, NULL); }

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(rays_are_near_those_of_many_parts, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Skies whose air lies in a shadow. */
#include "test_skies.h"

#include "atmosphere/atmosphere_tables.h"
#include "core/random.h"

static const double altitude_m = 500.0, sun_deg = 55.0;

static int start(void **state) {
  neph_context *context = test_context_create(2, NULL);
  neph_atmosphere_desc desc = NEPH_ATMOSPHERE_DESC_DEFAULT;
  neph_atmosphere *once = NULL;
  assert_int_equal(np_atmosphere_create_orders(context, &desc, 1, false, NULL, &once), NEPH_OK);
  *state = once;
  neph_context_destroy(context);
  return 0;
}

static neph_sky *create_shadowed(neph_atmosphere *atmosphere, const np_sun_visibility *visibility) {
  const neph_sky_desc desc = test_sky_desc(altitude_m, sun_deg);
  neph_sky *sky = NULL;
  assert_int_equal(np_sky_create_shadowed(atmosphere, &desc, visibility, &sky), NEPH_OK);
  return sky;
}

static float see_all(const void *user, np_dvec3 position) { return (void)user, (void)position, 1.0f; }
static float see_nothing(const void *user, np_dvec3 position) { return (void)user, (void)position, 0.0f; }
/* The sun's azimuth is x; to the left of its plane is day, to the right night. */
static float see_left(const void *user, np_dvec3 position) { return (void)user, position.y > 0.0 ? 1.0f : 0.0f; }

static float see_within(const void *user, np_dvec3 position) {
  const double limit_m = *(const double *)user;
  const np_dvec3 observer = np_dvec3_make(0, 0, altitude_m);
  return np_dvec3_length(np_dvec3_subtract(position, observer)) < limit_m ? 1.0f : 0.0f;
}

/* An unshadowed sky is the clear one, on either side of the sun. Between azimuths the clear one is
 * a spline, of which the whole circle keeps every place: 0.2 % on its steepest slope, by the aureole. */
static void a_shadow_of_nothing_is_none(void **state) {
  neph_context *context = test_context_create(2, NULL);
  neph_atmosphere *earth = test_atmosphere_create(context, NULL), *airs[] = {*state, earth};
  for (int a = 0; a < 2; a++) {
    neph_sky *clear = test_sky_create(airs[a], altitude_m, sun_deg);
    neph_sky *open = create_shadowed(airs[a], &(np_sun_visibility){see_all, NULL});
    np_random random = np_random_start(3, 0, 0, 0, 0);
    for (int i = 0; i < 2000; i++) {
      const double zenith = 180.0 * np_random_double(&random), azimuth = 360.0 * np_random_double(&random);
      const np_vec3 d = np_dvec3_to_float(test_direction(zenith, azimuth));
      const np_spectrum l = np_sky_radiance(clear, d), m = np_sky_radiance(open, d);
      const np_spectrum near = np_sky_aerial_perspective(clear, d, 8e3).inscatter;
      const np_spectrum same = np_sky_aerial_perspective(open, d, 8e3).inscatter;
      for (int b = 0; b < 3; b++) {
        assert_near_relative((double)m.band[b], (double)l.band[b], 2e-3);
        assert_near_relative((double)same.band[b], (double)near.band[b], 2e-3);
      }
    }
    neph_sky_destroy(open);
    neph_sky_destroy(clear);
  }
  neph_atmosphere_release(earth);
  neph_context_destroy(context);
}

/* Light scattered once is gone in the dark; a hundred-thousandth is what logarithms of nothing may leave. */
static void in_the_dark_nothing_is_scattered_once(void **state) {
  neph_sky *dark = create_shadowed(*state, &(np_sun_visibility){see_nothing, NULL});
  for (int i = 0; i < 36; i++) {
    const np_vec3 d = np_dvec3_to_float(test_direction(5.0 * i + 2.0, 10.0 * i));
    assert_true(np_spectrum_max(np_sky_radiance(dark, d)) < 1e-5f);
    assert_true(np_spectrum_max(np_sky_aerial_perspective(dark, d, 2e4).inscatter) < 1e-5f);
  }
  neph_sky_destroy(dark);
}

/* Day on one side of the sun and night on the other: no mirror. The rows next to the border, 7 degrees apart at the
 * most, mix the two. */
static void shadows_are_not_mirrored(void **state) {
  neph_sky *clear = test_sky_create(*state, altitude_m, sun_deg);
  neph_sky *half = create_shadowed(*state, &(np_sun_visibility){see_left, NULL});
  for (int i = 0; i < 30; i++) {
    const double zenith = 10.0 + 2.5 * i, azimuth = 15.0 + 5.0 * i;
    const np_vec3 left = np_dvec3_to_float(test_direction(zenith, azimuth));
    const np_vec3 right = np_dvec3_to_float(test_direction(zenith, -azimuth));
    const np_spectrum day = np_sky_radiance(half, left), wanted = np_sky_radiance(clear, left);
    for (int b = 0; b < 3; b++) assert_near_relative((double)day.band[b], (double)wanted.band[b], 2e-3);
    assert_true(np_spectrum_max(np_sky_radiance(half, right)) < 1e-5f);
    assert_true(np_spectrum_max(np_sky_aerial_perspective(half, right, 1e4).inscatter) < 1e-5f);
  }
  neph_sky_destroy(half);
  neph_sky_destroy(clear);
}

/* Distance at which the light of a row of the tables ends, seen past a wall: a slice has one sample, in its middle, by
 * which all of it lies before the wall or behind. */
static double compute_end_m(const neph_sky *sky, const np_sky_layout *layout, int row, double wall_m) {
  const double cosine = np_sky_row_cosine(&sky->frame, layout, row), count = sky->aerial_sizes.points;
  const np_ray ray = np_aerial_ray(&sky->atmosphere->medium, &sky->frame, cosine, row >= layout->up);
  const np_aerial_scale scale = np_aerial_scale_make(&ray, &sky->frame);
  const double slice = floor(np_aerial_scale_fraction(&scale, wall_m) * count);
  const bool is_before = np_aerial_scale_distance(&scale, (slice + 0.5) / count) < wall_m;
  return np_aerial_scale_distance(&scale, (is_before ? slice + 1.0 : slice) / count);
}

/* Beyond a wall of shade no light is added: the air up to it is the clear one's, and so is all that there is, as well
 * as slices of some 4 km can tell: of the two rows that the direction lies between each ends at the one plane or the
 * other. 1 % for what else differs from row to row. */
static void light_ends_where_the_shadow_begins(void **state) {
  const double wall_m = 12e3;
  neph_sky *clear = test_sky_create(*state, altitude_m, sun_deg);
  neph_sky *walled = create_shadowed(*state, &(np_sun_visibility){see_within, &wall_m});
  const np_sky_layout layout = np_sky_aerial_layout(walled);
  for (int i = 0; i < 24; i++) {
    const np_vec3 d = np_dvec3_to_float(test_direction(75.0 + 0.5 * i, 15.0 * i));
    const np_sky_place place = np_sky_locate(&walled->frame, d, &layout);
    const np_spectrum before = np_sky_aerial_perspective(clear, d, 5e3).inscatter;
    const np_spectrum same = np_sky_aerial_perspective(walled, d, 5e3).inscatter;
    const np_spectrum lower =
        np_sky_aerial_perspective(clear, d, compute_end_m(walled, &layout, place.row, wall_m)).inscatter;
    const np_spectrum upper =
        np_sky_aerial_perspective(clear, d, compute_end_m(walled, &layout, place.row + 1, wall_m)).inscatter;
    const np_spectrum beyond = np_sky_aerial_perspective(walled, d, 30e3).inscatter;
    for (int b = 0; b < 3; b++) {
      assert_near_relative((double)same.band[b], (double)before.band[b], 2e-3);
      const double expected = (double)(lower.band[b] + place.row_upper * (upper.band[b] - lower.band[b]));
      assert_near_relative((double)beyond.band[b], expected, 0.01);
    }
  }
  neph_sky_destroy(walled);
  neph_sky_destroy(clear);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_shadow_of_nothing_is_none),
      cmocka_unit_test(in_the_dark_nothing_is_scattered_once),
      cmocka_unit_test(shadows_are_not_mirrored),
      cmocka_unit_test(light_ends_where_the_shadow_begins),
  };
  return cmocka_run_group_tests(tests, start, test_earth_end);
}

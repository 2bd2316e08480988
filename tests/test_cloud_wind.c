/* SPDX-License-Identifier: Apache-2.0 */
/* Wind by height on every kind of cloud. */
#include "test_clouds.h"

#include "cloud/billows.h"
#include "cloud/thermal_heap.h"
#include "core/random.h"

enum { POINT_COUNT = 2000 };

static const double fall_m_s = 5.0; /* fall speed of rain, from clouds.md */

static neph_cloud_desc make_windy(neph_context *context, const char *preset, double speed_m_s) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(context, preset, &desc), NEPH_OK);
  desc.coverage = 0.5; /* a sheet without gaps has little to be moved */
  desc.skew_m[0] = desc.skew_m[1] = 0;
  desc.has_winds = true;
  for (int k = 0; k < NEPH_CLOUD_PROFILE_POINTS; k++) desc.wind_speed_m_s[k] = speed_m_s;
  return desc; /* the default direction is west: air moves along x */
}

/* Heights as shares of the thickness, or of the rain's depth where they are negative. */
typedef struct place {
  float x_m, y_m, share;
} place;

static place draw_place(const neph_cloud_desc *desc, np_random *random, float low, float high) {
  const float u = np_random_float(random) - 0.5f, v = np_random_float(random) - 0.5f;
  return (place){0.6f * u * (float)desc->extent_m[0], 0.6f * v * (float)desc->extent_m[1],
                 low + (high - low) * np_random_float(random)};
}

static float eval_place(const np_cloud_model *model, const place *p, double offset_m) {
  const float depth_m = p->share < 0 ? model->rain.depth_m : (float)model->desc.thickness_m;
  const float x_m = p->x_m + (float)offset_m, height_m = p->share * depth_m;
  float extinction = 0;
  np_cloud_model_eval(model, &(const np_cloud_points){1, &x_m, &p->y_m, &height_m}, &extinction);
  return extinction;
}

/* Sum of |a − b| over that of a + b: 0 of the same clouds, near 1 of unlike ones; where the second is looked up in its
 * place, and where the wind has carried it. */
typedef struct difference {
  double in_place, carried;
} difference;

static difference compare(const np_cloud_model *calm, const np_cloud_model *windy, float low, float high,
                          double (*get_offset_m)(const np_cloud_model *windy, float share)) {
  np_random random = np_random_start(5, 0, 0, 0, 0);
  double in_place = 0, carried = 0, sum = 0, sum_carried = 0;
  for (int i = 0; i < POINT_COUNT; i++) {
    const place p = draw_place(&calm->desc, &random, low, high);
    const double a = (double)eval_place(calm, &p, 0), b = (double)eval_place(windy, &p, 0);
    const double c = (double)eval_place(windy, &p, get_offset_m(windy, p.share));
    in_place += fabs(a - b), sum += a + b;
    carried += fabs(a - c), sum_carried += a + c;
  }
  assert_true(sum > 0);
  return (difference){in_place / sum, carried / sum_carried};
}

/* The wind grows evenly with the height: D = Δw·h²/(2·u·T), u = 6 thicknesses in a lifetime. */
static double get_carried_m(const np_cloud_model *windy, float share) {
  const neph_cloud_desc *desc = &windy->desc;
  const double gain_m_s = desc->wind_speed_m_s[NEPH_CLOUD_PROFILE_POINTS - 1] - desc->wind_speed_m_s[0];
  return gain_m_s * (double)(share * share) * desc->lifetime_s / 12;
}

/* The wind falls evenly to nothing at sea level. */
static double get_lag_m(const np_cloud_model *windy, float share) {
  const double way_m = (double)(share * windy->rain.depth_m);
  return -windy->desc.wind_speed_m_s[0] * way_m * way_m / (2 * fall_m_s * windy->desc.base_altitude_m);
}

typedef struct kind_row {
  const char *preset;
  double gain;        /* gain on the displacement at the top, in largest billows */
  double carried_max; /* against the difference in place */
} kind_row;

/* Columns are sheared as they are: what is left is rounding. Balls of thermals are carried whole, and each loses its
 * place by what the wind changes over its own height (test_thermals.c has their heads). */
static const kind_row kinds[] = {
    {"stratocumulus", 4, 0.01},  {"stratus", 1.5, 0.01}, {"altostratus", 3, 0.01},
    {"nimbostratus", 1.5, 0.01}, {"cirrus", 4, 0.01},    {"fog", 3, 0.01},
    {"valley_stratus", 3, 0.01}, {"contrail", 2, 0.01},  {"altocumulus_lenticularis", 1, 0.01},
    {"cumulonimbus", 1.5, 0.6},
};

/* The same map and waterline under a wind that grows by `gain_m_s` to the top; it borrows them. */
static np_cloud_model blow(const np_cloud_model *calm, double gain_m_s) {
  np_cloud_model windy = *calm;
  for (int k = 0; k < NEPH_CLOUD_PROFILE_POINTS; k++) windy.desc.wind_speed_m_s[k] += 0.25 * k * gain_m_s;
  windy.wind = np_cloud_wind_make(&windy.desc, windy.kind->skew);
  windy.balls = (np_ball_heap){.context = calm->balls.context, .kernels = calm->balls.kernels};
  if (windy.kind->has_thermals)
    assert_int_equal(np_thermals_build(&windy, NULL, np_thermals_count_levels(&windy)), NEPH_OK);
  return windy;
}

static void wind_by_height_carries_every_kind(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
    const neph_cloud_desc desc = make_windy(context, kinds[i].preset, 5);
    np_cloud_model calm;
    assert_int_equal(np_cloud_model_build(context, &desc, 6.36e6, NULL, &calm), NEPH_OK);
    np_cloud_model windy = blow(&calm, 12 * kinds[i].gain * desc.billow_m / desc.lifetime_s);
    const difference d = compare(&calm, &windy, 0, 1, get_carried_m);
    if (!(d.in_place > 0.1 && d.carried < kinds[i].carried_max * d.in_place))
      fail_msg("%s: %.3f in place, %.3f carried", kinds[i].preset, d.in_place, d.carried);
    np_ball_heap_cut(&windy.balls, 0);
    np_cloud_model_clear(&calm);
  }
  neph_context_destroy(context);
}

static void rain_lags_behind_its_cloud(void **state) {
  (void)state;
  static const char *const presets[] = {"nimbostratus", "altocumulus_floccus", "cumulonimbus"};
  neph_context *context = test_context_create(2, NULL);
  for (int i = 0; i < 3; i++) {
    np_cloud_model models[2];
    for (int windy = 0; windy < 2; windy++) {
      const neph_cloud_desc desc = make_windy(context, presets[i], windy ? 25 : 0);
      assert_int_equal(np_cloud_model_build(context, &desc, 6.36e6, NULL, &models[windy]), NEPH_OK);
    }
    const difference d = compare(&models[0], &models[1], -0.95f, -0.4f, get_lag_m);
    /* A calm has no heading, which is x then too. */
    if (!(d.in_place > 0.1 && d.carried < 0.05 * d.in_place))
      fail_msg("%s: %.3f in place, %.3f carried", presets[i], d.in_place, d.carried);
    for (int windy = 0; windy < 2; windy++) np_cloud_model_clear(&models[windy]);
  }
  neph_context_destroy(context);
}

static double get_anvil(const np_cloud_model *model, double x_m, double y_m) {
  return fmax((double)np_cloud_column_compute(model, (float)x_m, (float)y_m, 0).anvil, 0);
}

/* Share of the strength of anvils 6 km to either side of strong towers that is to the east. */
static double compute_eastern_share(const np_cloud_model *model) {
  const double reach_m = 6e3, half_m = 0.5 * model->desc.extent_m[0] - reach_m;
  double east = 0, west = 0;
  for (double y_m = -half_m; y_m <= half_m; y_m += 500)
    for (double x_m = -half_m; x_m <= half_m; x_m += 500) {
      if (!(np_cloud_column_compute(model, (float)x_m, (float)y_m, 0).strength > 0.5f)) continue;
      east += get_anvil(model, x_m + reach_m, y_m);
      west += get_anvil(model, x_m - reach_m, y_m);
    }
  assert_true(east + west > 0);
  return east / (east + west);
}

/* Towards the wind up there against that at the base: an anvil reaches nearly five times as far behind its tower as
 * before it. Those of other towers are on either side. */
static void wind_by_height_blows_anvils(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = make_windy(context, "cumulonimbus", 10);
  desc.extent_m[0] = desc.extent_m[1] = 60e3;
  desc.coverage = 0.1;
  for (int east = 0; east < 2; east++) {
    np_cloud_model model;
    for (int k = 0; k < NEPH_CLOUD_PROFILE_POINTS; k++) desc.wind_speed_m_s[k] = 10 + (east ? 0.2 : -0.2) * k;
    assert_int_equal(np_cloud_model_build(context, &desc, 6.36e6, NULL, &model), NEPH_OK);
    const double share = compute_eastern_share(&model);
    print_message("share of anvils east of their towers: %.3g\n", share);
    assert_true(east ? share > 0.8 : share < 0.2);
    np_cloud_model_clear(&model);
  }
  neph_context_destroy(context);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(wind_by_height_carries_every_kind),
      cmocka_unit_test(rain_lags_behind_its_cloud),
      cmocka_unit_test(wind_by_height_blows_anvils),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

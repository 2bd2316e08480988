/* SPDX-License-Identifier: Apache-2.0 */
/* Wind, growth and decay. */
#include "test_clouds.h"

#include "core/random.h"

static double compute_change(neph_context *context, neph_cloud_desc desc, double time_s, double later_s) {
  enum { POINTS = 4096 };
  np_cloud_model models[2];
  double squared = 0, norm = 0;
  np_random random = np_random_start(4, 0, 0, 0, 0);
  for (int i = 0; i < 2; i++) {
    desc.time_s = i ? later_s : time_s;
    assert_int_equal(np_cloud_model_build(context, &desc, NULL, &models[i]), NEPH_OK);
  }
  for (int i = 0; i < POINTS; i++) {
    const float x = 5000 * (np_random_float(&random) - 0.5f), y = 4000 * (np_random_float(&random) - 0.5f);
    const float height = 800 * np_random_float(&random);
    const np_cloud_points point = {1, &x, &y, &height};
    float values[2];
    for (int k = 0; k < 2; k++) np_cloud_model_eval(&models[k], &point, &values[k]);
    squared += (double)(values[1] - values[0]) * (double)(values[1] - values[0]);
    norm += (double)values[0] * (double)values[0];
  }
  for (int i = 0; i < 2; i++) np_cloud_model_clear(&models[i]);
  return sqrt(squared / norm);
}

/* A tenth of a second is a tenth of the change of a second, and both small; half an hour is another sky. */
static void clouds_change_steadily_with_time(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  for (neph_cloud_model m = NEPH_CLOUD_MODEL_CELLS; m <= NEPH_CLOUD_MODEL_SLAB; m++) {
    neph_cloud_desc desc = test_small_field(6);
    desc.coverage = 0.6;
    desc.model = m;
    desc.softness = 0.5;
    desc.wind_m_s[0] = 8;
    for (int start = 0; start <= 1000; start += 1000) {
      const double second = compute_change(context, desc, start, start + 1),
                   tenth = compute_change(context, desc, start, start + 0.1);
      assert_true(second < 0.1 && tenth < 0.3 * second + 1e-4);
    }
    assert_true(compute_change(context, desc, 0, 1800) > 0.5);
  }
  neph_context_destroy(context);
}

/* With a wind and no change, the field of later is the field of now moved: the map's texels differ, hence a few per
 * cent. */
static void wind_moves_the_field(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = test_small_field(6);
  desc.coverage = 0.6;
  desc.lifetime_s = 1e9;
  desc.wind_m_s[0] = 10;
  desc.time_s = 60;
  np_cloud_model now, later;
  assert_int_equal(np_cloud_model_build(context, &desc, NULL, &later), NEPH_OK);
  desc.time_s = 0;
  assert_int_equal(np_cloud_model_build(context, &desc, NULL, &now), NEPH_OK);
  np_random random = np_random_start(4, 0, 0, 0, 0);
  double difference = 0, sum = 0;
  for (int i = 0; i < 4096; i++) {
    const float x = 1500 * (np_random_float(&random) - 0.5f), y = 2000 * (np_random_float(&random) - 0.5f);
    const float height = 800 * np_random_float(&random), moved = x + 600.0f;
    const np_cloud_points here = {1, &x, &y, &height}, there = {1, &moved, &y, &height};
    float a, b;
    np_cloud_model_eval(&now, &here, &a);
    np_cloud_model_eval(&later, &there, &b);
    difference += fabs((double)a - (double)b);
    sum += (double)a;
  }
  assert_true(sum > 0 && difference < 0.05 * sum);
  np_cloud_model_clear(&later);
  np_cloud_model_clear(&now);
  neph_context_destroy(context);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(clouds_change_steadily_with_time),
      cmocka_unit_test(wind_moves_the_field),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

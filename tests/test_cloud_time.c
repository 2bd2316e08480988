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
    assert_int_equal(np_cloud_model_build(context, &desc, 6.36e6, NULL, &models[i]), NEPH_OK);
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

/* Wind alone moves the field: the map's texels differ from the first one's, hence a few per cent. */
static void wind_moves_the_field(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = test_small_field(6);
  desc.coverage = 0.6;
  desc.lifetime_s = 1e9;
  desc.wind_m_s[0] = 10;
  desc.time_s = 60;
  np_cloud_model now, later;
  assert_int_equal(np_cloud_model_build(context, &desc, 6.36e6, NULL, &later), NEPH_OK);
  desc.time_s = 0;
  assert_int_equal(np_cloud_model_build(context, &desc, 6.36e6, NULL, &now), NEPH_OK);
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

/* ---- No popping: every preset ---- */

/* Heights of a column are evaluated together, which spares all that is the same in it. */
enum { STEPS = 6, COLUMNS = 2048, HEIGHTS = 8, PROBES = COLUMNS * HEIGHTS };

static neph_cloud_desc make_preset_field(neph_context *context, const char *preset) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(context, preset, &desc), NEPH_OK);
  desc.extent_m[0] = desc.extent_m[1] = fmin(desc.extent_m[0], 3000);
  desc.wind_m_s[0] = desc.wind_m_s[1] = 0;
  desc.seed = 3;
  return desc;
}

static void evaluate_at(neph_context *context, neph_cloud_desc desc, double time_s, float values[PROBES]) {
  np_cloud_model model;
  desc.time_s = time_s;
  assert_int_equal(np_cloud_model_build(context, &desc, 6.36e6, NULL, &model), NEPH_OK);
  np_random random = np_random_start(11, 0, 0, 0, 0);
  for (int column = 0; column < COLUMNS; column++) {
    float x[HEIGHTS], y[HEIGHTS], height[HEIGHTS];
    x[0] = (float)desc.extent_m[0] * 0.8f * (np_random_float(&random) - 0.5f);
    y[0] = (float)desc.extent_m[1] * 0.8f * (np_random_float(&random) - 0.5f);
    for (int k = 0; k < HEIGHTS; k++) {
      x[k] = x[0];
      y[k] = y[0];
      height[k] = (float)desc.thickness_m * np_random_float(&random);
    }
    np_cloud_model_eval(&model, &(np_cloud_points){HEIGHTS, x, y, height}, &values[column * HEIGHTS]);
  }
  np_cloud_model_clear(&model);
}

static double compute_rms_difference(const float a[PROBES], const float b[PROBES]) {
  double sum = 0;
  for (int i = 0; i < PROBES; i++) sum += ((double)a[i] - (double)b[i]) * ((double)a[i] - (double)b[i]);
  return sqrt(sum / PROBES);
}

static int compare_doubles(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* A ball or a cell that appeared at once would make one step's change stand out. The largest is 1.30 of the median, of
 * lenses, which few of the probes meet. */
static void no_preset_pops(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  static float values[2][PROBES];
  char name[TEST_PRESET_NAME_MAX];
  for (size_t p = 0; test_get_preset(context, p, name); p++) {
    const neph_cloud_desc desc = make_preset_field(context, name);
    double changes[STEPS];
    evaluate_at(context, desc, 0, values[0]);
    for (int i = 0; i < STEPS; i++) {
      evaluate_at(context, desc, 10 * (i + 1), values[(i + 1) % 2]);
      changes[i] = compute_rms_difference(values[0], values[1]);
    }
    qsort(changes, STEPS, sizeof *changes, compare_doubles);
    if (changes[STEPS / 2] <= 0) fail_msg("%s: stands still", name);
    if (changes[STEPS - 1] > 1.6 * changes[STEPS / 2])
      fail_msg("%s: largest change of 10 s %.2f of the median", name, changes[STEPS - 1] / changes[STEPS / 2]);
  }
  neph_context_destroy(context);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(no_preset_pops),
      cmocka_unit_test(clouds_change_steadily_with_time),
      cmocka_unit_test(wind_moves_the_field),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

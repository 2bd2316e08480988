/* SPDX-License-Identifier: Apache-2.0 */
/* Leaves that a bake skips by their bound. */
#include "test_clouds.h"

#include <nephos/image.h>

#include "core/math.h"
#include "core/random.h"

static bool has_cloud(const np_cloud_model *model, const np_cloud_box *box) {
  float x[NP_CLOUD_BLOCK], y[NP_CLOUD_BLOCK], height[NP_CLOUD_BLOCK], extinction[NP_CLOUD_BLOCK];
  for (int n = 0; n < NP_CLOUD_BLOCK; n++) {
    x[n] = box->min_m[0] + (box->max_m[0] - box->min_m[0]) * (float)(n / 64) / 7;
    y[n] = box->min_m[1] + (box->max_m[1] - box->min_m[1]) * (float)(n / 8 % 8) / 7;
    height[n] = box->min_m[2] + (box->max_m[2] - box->min_m[2]) * (float)(n % 8) / 7;
  }
  const np_cloud_points points = {NP_CLOUD_BLOCK, x, y, height};
  np_cloud_model_eval(model, &points, extinction);
  for (int n = 0; n < NP_CLOUD_BLOCK; n++)
    if (extinction[n] > 0) return true;
  return false;
}

/* Counts of the first 500 boxes. */
typedef struct box_count {
  int called_empty, clear;
} box_count;

/* A third of the boxes lie outside or across the border. */
static box_count try_boxes(const np_cloud_model *model, uint64_t seed, int count) {
  const neph_cloud_desc *desc = &model->desc;
  np_random random = np_random_start(seed, 0, 0, 0, 0);
  const float top = (float)desc->thickness_m, rain = model->rain.depth_m;
  const float span[3] = {1.17f * (float)desc->extent_m[0], 1.2f * (float)desc->extent_m[1], 1.25f * top + rain};
  const float offset[3] = {-0.5f * span[0], -0.5f * span[1], -0.12f * top - rain};
  box_count c = {0, 0};
  for (int run = 0; run < count; run++) {
    np_cloud_box box;
    for (int a = 0; a < 3; a++) {
      box.min_m[a] = offset[a] + span[a] * np_random_float(&random);
      box.max_m[a] = box.min_m[a] + span[a] * (0.003f + 0.05f * np_random_float(&random));
    }
    const bool is_empty = np_cloud_model_is_empty(model, &box);
    if (is_empty) assert_false(has_cloud(model, &box));
    if (run >= 500) continue;
    c.called_empty += is_empty;
    c.clear += is_empty || !has_cloud(model, &box);
  }
  return c;
}

static box_count try_cloud(neph_context *context, const neph_cloud_desc *desc, int count) {
  np_cloud_model model;
  assert_int_equal(np_cloud_model_build(context, desc, 6.36e6, NULL, &model), NEPH_OK);
  box_count c = try_boxes(&model, 1, count);
  np_cloud_model_clear(&model);
  return c;
}

/* All that moves a cloud about, turned up. */
static neph_cloud_desc wild_field(void) {
  neph_cloud_desc desc = test_small_field(8);
  desc.skew_m[0] = 900;
  desc.skew_m[1] = -400;
  desc.turbulence = 1;
  desc.wispiness = 1;
  desc.erosion = 1;
  desc.anvil = 1;
  desc.precipitation = 0.7;
  return desc;
}

/* 10⁵ boxes in all, with the map below: a wild field in calm and in wind, a hero, thermals, and every preset at another
 * time. */
static void no_box_called_empty_holds_cloud(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = wild_field();
  assert_true(try_cloud(context, &desc, 15000).called_empty > 0);
  for (int i = 0; i < NEPH_CLOUD_PROFILE_POINTS; i++) desc.wind_speed_m_s[i] = 3 + 4 * i % 7;
  desc.has_winds = true;
  assert_true(try_cloud(context, &desc, 5000).called_empty > 0);
  desc.model = NEPH_CLOUD_MODEL_HERO;
  assert_true(try_cloud(context, &desc, 5000).called_empty > 0);
  desc.model = NEPH_CLOUD_MODEL_THERMALS;
  assert_true(try_cloud(context, &desc, 5000).called_empty > 0);
  char name[TEST_PRESET_NAME_MAX];
  for (size_t i = 0; test_get_preset(context, i, name); i++) {
    assert_int_equal(neph_cloud_get_preset(context, name, &desc), NEPH_OK);
    desc.time_s = 700;
    const box_count c = try_cloud(context, &desc, 7000);
    assert_true(2 * c.called_empty > c.clear); /* or it would not be worth it */
  }
  neph_context_destroy(context);
}

/* A picture of random values in each quantity's own channel, from black to white. */
static void write_picture(neph_context *context, const char *path) {
  enum { SIDE = 9 };
  static const char *const names[NEPH_CLOUD_MAP_QUANTITY_COUNT] = {"A", "B", "G", "R", "Y", "Z"};
  neph_image *image = NULL;
  np_random random = np_random_start(2, 0, 0, 0, 0);
  assert_int_equal(neph_image_create(context, SIDE, SIDE, NEPH_CLOUD_MAP_QUANTITY_COUNT, names, &image), NEPH_OK);
  for (int q = 0; q < NEPH_CLOUD_MAP_QUANTITY_COUNT; q++)
    for (int i = 0; i < SIDE * SIDE; i++)
      neph_image_get_channel(image, names[q])[i] = np_maxf(0.0f, np_minf(1.0f, 1.6f * np_random_float(&random) - 0.3f));
  assert_int_equal(neph_image_save_exr(image, path, NEPH_PIXEL_FLOAT), NEPH_OK);
  neph_image_destroy(image);
}

/* Coverage, type, base, thickness and rain that differ from place to place: for cells and for a slab of sheets. */
static void no_box_called_empty_holds_cloud_under_a_map(void **state) {
  (void)state;
  char *folder = test_folder_create(), *path = test_path(folder, "map.exr");
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = wild_field();
  write_picture(context, path);
  desc.coverage = 0.8;
  desc.map_file = path;
  desc.is_map_tiling = true;
  desc.has_map_size = true;
  desc.map_size_m[0] = desc.map_size_m[1] = 9000;
  desc.map_channels[NEPH_CLOUD_MAP_COVERAGE] = "A";
  desc.map_channels[NEPH_CLOUD_MAP_TYPE] = "B";
  desc.map_channels[NEPH_CLOUD_MAP_BASE] = "G";
  desc.map_channels[NEPH_CLOUD_MAP_THICKNESS] = "R";
  desc.map_channels[NEPH_CLOUD_MAP_PRECIPITATION] = "Y";
  desc.map_channels[NEPH_CLOUD_MAP_AGE] = "Z";
  for (int i = 0; i < 3; i++) {
    desc.model = i == 2 ? NEPH_CLOUD_MODEL_SLAB : NEPH_CLOUD_MODEL_CELLS;
    desc.sublayers = 3;
    desc.time_s = 300 * i;
    const box_count c = try_cloud(context, &desc, 5000);
    assert_true(2 * c.called_empty > c.clear);
  }
  neph_context_destroy(context);
  free(path);
  test_folder_destroy(folder);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(no_box_called_empty_holds_cloud),
      cmocka_unit_test(no_box_called_empty_holds_cloud_under_a_map),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

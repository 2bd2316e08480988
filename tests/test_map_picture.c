/* SPDX-License-Identifier: Apache-2.0 */
/* Weather maps from above: the painted values at their places in the world, north up, with the field outlined. */
#include "test_clouds.h"

#include <nephos/image.h>

#include "core/file.h"

static int set_up(void **state) { return test_set_up(state, 2, "map.exr"); }

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

enum { EDGE = 32, LEFT = 4, RIGHT = 12, TOP = 2, BOTTOM = 10 /* painted box, in texels from the north-west */ };

static const double step = 1.51 / 255; /* half a code of 8 bits by rounding, and one by the dither of previews */

static bool is_in_box(int column, int row) { return column >= LEFT && column < RIGHT && row >= TOP && row < BOTTOM; }

/* Coverage: 0.6 in the box, 0.1 around it. Type: from 0 in the west to 1 in the east. */
static void write_map(const test_fixture *f) {
  neph_image *image = NULL;
  assert_int_equal(neph_image_create(f->context, EDGE, EDGE, 2, (const char *const[]){"R", "G"}, &image), NEPH_OK);
  float *coverage = neph_image_get_channel(image, "R"), *type = neph_image_get_channel(image, "G");
  for (int i = 0; i < EDGE * EDGE; i++) {
    coverage[i] = is_in_box(i % EDGE, i / EDGE) ? 0.6f : 0.1f;
    type[i] = (float)(i % EDGE) / (EDGE - 1);
  }
  assert_int_equal(neph_image_save_exr(image, f->path, NEPH_PIXEL_FLOAT), NEPH_OK);
  neph_image_destroy(image);
}

/* A field of 8 by 4 km, away from the origin, below a picture of 16 km. */
static neph_cloud_desc make_desc(const test_fixture *f) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  desc.center_m[0] = 3000;
  desc.center_m[1] = -1000;
  desc.extent_m[1] = 4000;
  desc.map_file = f->path;
  desc.map_channels[NEPH_CLOUD_MAP_COVERAGE] = "R";
  desc.has_map_size = true;
  desc.map_size_m[0] = desc.map_size_m[1] = 16000;
  return desc;
}

/* A picture, and its expected description. */
typedef struct made_picture {
  neph_map_picture said;
  neph_image *image;
} made_picture;

static made_picture make_picture(const test_fixture *f, const neph_cloud_desc *desc) {
  char path[4096];
  made_picture made = {.said = NEPH_MAP_PICTURE_DEFAULT};
  snprintf(path, sizeof path, "%s.png", f->path);
  assert_int_equal(neph_cloud_save_map(f->context, desc, path, &made.said), NEPH_OK);
  assert_int_equal(neph_image_load_png(f->context, path, &made.image), NEPH_OK);
  const neph_map_picture *s = &made.said;
  assert_int_equal(neph_image_get_width(made.image), s->panel_count * s->panel_width + (s->panel_count - 1) * s->gap);
  assert_int_equal(neph_image_get_height(made.image), s->panel_height);
  assert_near((s->panel_max_m[0] - s->panel_min_m[0]) / s->pixel_m, s->panel_width, 1e-6);
  assert_near((s->panel_max_m[1] - s->panel_min_m[1]) / s->pixel_m, s->panel_height, 1e-6);
  return made;
}

/* Code of a colour at a place in a panel. */
static double get_code(const made_picture *made, unsigned panel, const char *channel, double x_m, double y_m) {
  const neph_map_picture *s = &made->said;
  const unsigned column = panel * (s->panel_width + s->gap) + (unsigned)((x_m - s->panel_min_m[0]) / s->pixel_m);
  const unsigned row = (unsigned)((s->panel_max_m[1] - y_m) / s->pixel_m);
  return (double)neph_image_get_values(made->image, channel)[row * neph_image_get_width(made->image) + column];
}

static void assert_grey(const made_picture *made, double x_m, double y_m, double value) {
  static const char *const channels[] = {"R", "G", "B"};
  for (int c = 0; c < 3; c++) assert_near(get_code(made, 0, channels[c], x_m, y_m), value, step);
}

/* The painted box lies 6 to 2 km west and 7 to 3 km north of the picture's middle. */
static void a_painted_box_lies_where_it_is_baked(void **state) {
  test_fixture *f = *state;
  write_map(f);
  neph_cloud_desc desc = make_desc(f);
  desc.extent_m[0] = desc.extent_m[1] = 16000;
  const made_picture made = make_picture(f, &desc);
  assert_int_equal(made.said.panel_count, 1);
  assert_string_equal(made.said.quantities[0], "coverage");
  assert_near(made.said.field_min_m[0], 3000 - 8000, 1e-9);
  assert_near(made.said.field_max_m[1], -1000 + 8000, 1e-9);
  for (double x_m = -7750; x_m < 8000; x_m += 500)
    for (double y_m = -7750; y_m < 8000; y_m += 500) {
      const double beyond_m = fmax(fabs(x_m + 4000), fabs(y_m - 5000)) - 2000;
      if (fabs(beyond_m) > 500) assert_grey(&made, 3000 + x_m, -1000 + y_m, beyond_m < 0 ? 0.6 : 0.1);
    }
  for (int side = 0; side < 4; side++) { /* borders, half way between the texels beside them */
    const double sign = side % 2 ? 1 : -1, x_m = side / 2 ? 0 : sign * 2000, y_m = side / 2 ? sign * 2000 : 0;
    const double code = get_code(&made, 0, "G", 3000 - 4000 + x_m, -1000 + 5000 + y_m);
    assert_near(code, 0.35, step + 0.5 * made.said.pixel_m / 500);
  }
  neph_image_destroy(made.image);
}

static void the_field_is_outlined_and_all_beyond_it_is_dim(void **state) {
  test_fixture *f = *state;
  write_map(f);
  const neph_cloud_desc desc = make_desc(f);
  const made_picture made = make_picture(f, &desc);
  const double m = made.said.pixel_m;
  assert_grey(&made, 3000 + 3999 - m, -1000, 0.1);
  for (int side = 0; side < 4; side++) {
    const double sign = side % 2 ? 1 : -1;
    const double x_m = side / 2 ? 0 : sign * (4000 + m), y_m = side / 2 ? sign * (2000 + m) : 0;
    assert_near(get_code(&made, 0, "R", 3000 + x_m, -1000 + y_m), 1, step);
    assert_near(get_code(&made, 0, "B", 3000 + x_m, -1000 + y_m), 0.12, step);
    assert_grey(&made, 3000 + x_m * 1.2, -1000 + y_m * 1.2, 0.1 * 0.35);
  }
  assert_grey(&made, 3000 - 5000, -1000 + 5000, 0.6 * 0.35);
  neph_image_destroy(made.image);
}

static void each_quantity_has_a_panel(void **state) {
  test_fixture *f = *state;
  write_map(f);
  neph_cloud_desc desc = make_desc(f);
  desc.map_channels[NEPH_CLOUD_MAP_TYPE] = "G";
  const made_picture made = make_picture(f, &desc);
  assert_int_equal(made.said.panel_count, 2);
  assert_string_equal(made.said.quantities[1], "type");
  for (double x_m = -3500; x_m < 4000; x_m += 500) {
    const double type = (x_m / 16000 + 0.5 - 0.5 / EDGE) * EDGE / (EDGE - 1);
    assert_near(get_code(&made, 1, "R", 3000 + x_m, -1000), type, step);
    assert_near(get_code(&made, 1, "G", 3000 + x_m, -1000), 0.62 * type, step);
    assert_grey(&made, 3000 + x_m, -1000, 0.1);
  }
  neph_image_destroy(made.image);
}

static void the_wind_carries_the_picture(void **state) {
  test_fixture *f = *state;
  write_map(f);
  neph_cloud_desc desc = make_desc(f);
  desc.wind_m_s[0] = 5;
  desc.wind_m_s[1] = -10;
  desc.time_s = 400;
  const made_picture made = make_picture(f, &desc);
  assert_near(made.said.painted_min_m[0], 3000 + 2000 - 8000, 1e-9);
  assert_near(made.said.painted_max_m[1], -1000 - 4000 + 8000, 1e-9);
  assert_grey(&made, 3000 + 2000 - 2500, -1000 - 4000 + 3500, 0.6); /* the south-eastern corner of the box */
  assert_grey(&made, 3000 + 2000 - 1500, -1000 - 4000 + 3500, 0.1);
  assert_grey(&made, 3000 + 2000 - 2500, -1000 - 4000 + 2500, 0.1);
  desc.time_s = 0;
  const made_picture before = make_picture(f, &desc);
  assert_int_equal(before.said.panel_width, made.said.panel_width); /* frames of a sequence are alike */
  assert_near(before.said.panel_min_m[0], made.said.panel_min_m[0], 1e-9);
  neph_image_destroy(before.image);
  neph_image_destroy(made.image);
}

/* The field stays a fifth of the panel at least. */
static void a_vast_picture_leaves_the_field_large_enough(void **state) {
  test_fixture *f = *state;
  write_map(f);
  neph_cloud_desc desc = make_desc(f);
  desc.map_size_m[0] = desc.map_size_m[1] = 1e6;
  neph_map_picture said = NEPH_MAP_PICTURE_DEFAULT;
  assert_int_equal(neph_cloud_save_map(f->context, &desc, NULL, &said), NEPH_OK);
  assert_near(said.pixel_m, 5 * 8000 / 1000.0, 1e-9);
  assert_near(said.painted_max_m[0] - said.painted_min_m[0], 1e6, 1e-6);
}

static void assert_refused(test_fixture *f, const neph_cloud_desc *desc, neph_result expected, const char *words) {
  char path[4096];
  snprintf(path, sizeof path, "%s.png", f->path);
  test_log_clear(&f->log);
  assert_int_equal(neph_cloud_save_map(f->context, desc, path, NULL), expected);
  assert_one_error(&f->log, words);
  assert_false(np_file_exists(path));
}

static void a_cloud_without_a_map_is_refused(void **state) {
  test_fixture *f = *state;
  write_map(f);
  const neph_cloud_point ball = {0, 0, 500, 300};
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  assert_refused(f, &desc, NEPH_ERROR_INVALID_ARGUMENT, "cloud has no weather map to show, must have a picture");
  desc = make_desc(f);
  desc.model = NEPH_CLOUD_MODEL_THERMALS;
  desc.shape.spheres = (neph_cloud_points){.points = &ball, .count = 1};
  assert_refused(f, &desc, NEPH_ERROR_INVALID_ARGUMENT, "cloud has no weather map to show beside its shape");
  desc = make_desc(f);
  desc.map_channels[NEPH_CLOUD_MAP_COVERAGE] = "Q";
  assert_refused(f, &desc, NEPH_ERROR_BAD_FILE, "has no channel Q");
}

int main(void) {
  const struct CMUnitTest tests[] = {TEST(a_painted_box_lies_where_it_is_baked),
                                     TEST(the_field_is_outlined_and_all_beyond_it_is_dim),
                                     TEST(each_quantity_has_a_panel),
                                     TEST(the_wind_carries_the_picture),
                                     TEST(a_vast_picture_leaves_the_field_large_enough),
                                     TEST(a_cloud_without_a_map_is_refused)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}

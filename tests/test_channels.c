/* SPDX-License-Identifier: Apache-2.0 */
/* Layers of a comp, in both integrators: coverage as A has it, clouds with the air before them or without it, overscan,
 * optical depth, and means that no weight takes out of their range. */
#include "image/image_private.h"
#include "test_layers.h"

/* Sums of floats of the size of the layers. */
static const double rounding = 2e-6;

/* ---- Coverage ---- */

static void alpha_covers_what_is_asked(void **state) {
  fixture *f = *state;
  for (int i = 0; i < 2; i++) {
    set(f, "output.alpha", "clouds");
    neph_image *clouds = render_layers(f, integrators[i], "[transmittance, clouds]");
    set(f, "output.alpha", "clouds_and_ground");
    neph_image *both = render_layers(f, integrators[i], "[normal]");
    set(f, "output.alpha", "scene");
    neph_image *scene = render_layers(f, integrators[i], "[]");
    set(f, "output.film.background", "false");
    neph_image *shown = render_layers(f, integrators[i], "[]");
    set(f, "output.film.background", "true");
    unsigned ground = 0, sky = 0;
    for (size_t p = 0; p < count_pixels(clouds); p++) {
      const double covered = get_value(clouds, "A", p);
      assert_near(covered, 1.0 - get_value(clouds, "transmittance", p), rounding);
      assert_near(get_value(clouds, "clouds.A", p), covered, 0.0);
      assert_near(get_value(scene, "A", p), 1.0, 0.0);
      assert_near(get_value(shown, "A", p), get_value(both, "A", p), 0.0);
      assert_true(get_value(both, "A", p) >= covered);
      sky += get_value(both, "A", p) == 0.0;
      ground += covered == 0.0 && get_value(both, "A", p) == 1.0;
    }
    assert_true(ground > 50 && sky > 50);
    neph_image_destroy(clouds);
    neph_image_destroy(both);
    neph_image_destroy(scene);
    neph_image_destroy(shown);
    set(f, "output.alpha", "clouds_and_ground");
  }
}

/* ---- Clouds and air ---- */

static const char colors[] = "RGB";

static double get_color(const neph_image *image, const char *layer, int color, size_t pixel) {
  char name[64];
  (void)snprintf(name, sizeof name, "%s%s%c", layer, layer[0] ? "." : "", colors[color]);
  return get_value(image, name, pixel);
}

static double sum_layers(const neph_image *image, const char *const *layers, int color, size_t pixel) {
  double sum = 0.0;
  for (; *layers; layers++) sum += get_color(image, *layers, color, pixel);
  return sum;
}

static void check_layers(const neph_image *kept, const neph_image *apart) {
  static const char *const air[] = {"cloud_air", "ground_air", NULL},
                           *const over[] = {"clouds", "ground_air", "terrain", "background", NULL},
                           *const all[] = {"clouds", "cloud_air", "ground_air", "terrain", "background", NULL};
  double before_clouds = 0.0, before_ground = 0.0;
  for (size_t p = 0; p < count_pixels(kept); p++)
    for (int c = 0; c < 3; c++) {
      const double beauty = get_color(kept, "", c, p), cloud_air = get_color(kept, "cloud_air", c, p);
      assert_near(sum_layers(kept, over, c, p), beauty, rounding);
      assert_near(sum_layers(apart, all, c, p), beauty, rounding);
      assert_near(sum_layers(kept, air, c, p), get_color(kept, "air", c, p), rounding);
      assert_near(get_color(kept, "clouds", c, p), get_color(apart, "clouds", c, p) + cloud_air, rounding);
      if (get_value(kept, "clouds.A", p) == 0.0) assert_near(get_color(kept, "clouds", c, p), 0.0, rounding);
      before_clouds += cloud_air;
      before_ground += get_color(kept, "ground_air", c, p);
    }
  assert_true(before_clouds > 0.0 && before_ground > 0.0);
}

static void layers_merge_to_the_beauty(void **state) {
  fixture *f = *state;
  static const char *const airs[] = {"traced", "tables"};
  for (int i = 0; i < 3; i++) {
    set(f, "render.atmosphere", airs[i == 2]);
    set(f, "output.cloud_air", "kept");
    const char *layers = "[clouds, cloud_air, ground_air, air, terrain, background]";
    neph_image *kept = render_layers(f, integrators[i > 0], layers);
    set(f, "output.cloud_air", "apart");
    neph_image *apart = render_layers(f, integrators[i > 0], layers);
    check_layers(kept, apart);
    neph_image_destroy(kept);
    neph_image_destroy(apart);
    set(f, "render.atmosphere", "traced");
    set(f, "output.cloud_air", "kept");
  }
}

/* ---- Overscan ---- */

/* The pixels of the picture keep their bits. */
static void overscan_widens_the_data_window(void **state) {
  fixture *f = *state;
  enum { WIDTH = 32, HEIGHT = 20, EDGE = 5 };
  for (int i = 0; i < 2; i++) {
    neph_image *plain = render_layers(f, integrators[i], "[clouds]");
    set(f, "camera.overscan", "5");
    neph_image *wide = render_layers(f, integrators[i], "[clouds]");
    assert_int_equal(neph_image_get_width(wide), WIDTH + 2 * EDGE);
    assert_int_equal(neph_image_get_height(wide), HEIGHT + 2 * EDGE);
    assert_int_equal(wide->header.data_min[0], -EDGE);
    assert_int_equal(wide->header.data_max[1], HEIGHT + EDGE - 1);
    assert_int_equal(wide->header.display_min[0], 0);
    assert_int_equal(wide->header.display_max[0], WIDTH - 1);
    for (size_t p = 0; p < count_pixels(plain); p++) {
      const size_t at = (p / WIDTH + EDGE) * (WIDTH + 2 * EDGE) + p % WIDTH + EDGE;
      for (int c = 0; c < 3; c++) assert_near(get_color(wide, "", c, at), get_color(plain, "", c, p), 0.0);
    }
    neph_image_destroy(plain);
    neph_image_destroy(wide);
    set(f, "camera.overscan", "0");
  }
}

/* Parts of the frame cover the overscan once: each has that beyond the edges it lies on. */
static void crops_take_the_overscan_at_the_edges(void **state) {
  fixture *f = *state;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_image *top = NULL, *inner = NULL;
  set(f, "camera.overscan", "5");
  assert_int_equal(neph_scene_get_render_desc(f->scene, &desc), NEPH_OK);
  desc.crop_max[1] = 8;
  assert_int_equal(neph_render_image(f->scene, &desc, &top), NEPH_OK);
  assert_int_equal(neph_image_get_width(top), 42);
  assert_int_equal(neph_image_get_height(top), 13);
  desc.crop_min[0] = desc.crop_min[1] = 4;
  desc.crop_max[0] = 12;
  assert_int_equal(neph_render_image(f->scene, &desc, &inner), NEPH_OK);
  assert_int_equal(neph_image_get_width(inner), 8);
  assert_int_equal(neph_image_get_height(inner), 4);
  neph_image_destroy(top);
  neph_image_destroy(inner);
  set(f, "camera.overscan", "0");
}

/* ---- Means ---- */

/* Along one ray a pixel the march lets through e^{−τ}, to its tolerance of 2 %, or ends at 0.001; the depth is that of
 * the ray, whatever follows it. */
static void optical_depth_is_that_of_the_ray(void **state) {
  fixture *f = *state;
  set(f, "render.samples", "1");
  neph_image *march = render_layers(f, "march", "[optical_depth, transmittance]");
  neph_image *path = render_layers(f, "path", "[optical_depth]");
  unsigned seen = 0;
  for (size_t p = 0; p < count_pixels(march); p++) {
    const double depth = get_value(march, "optical_depth", p), passed = get_value(march, "transmittance", p);
    assert_near(get_value(path, "optical_depth", p), depth, 0.0);
    if (depth < 6.0) assert_near(passed, exp(-depth), 0.02);
    seen += depth > 0.1;
  }
  assert_true(seen > 50);
  neph_image_destroy(march);
  neph_image_destroy(path);
  set(f, "render.samples", "4");
}

/* One cloud scatters all light; the other and the ground less. The march plays Russian roulette with what is left
 * below a half, guided flights have weights: neither takes a mean out of its range. */
static void albedo_never_exceeds_one(void **state) {
  fixture *f = *state;
  set(f, "render.transmittance_end", "0.5");
  set(f, "render.path_guiding", "adjoint");
  for (int i = 0; i < 2; i++) {
    neph_image *image = render_layers(f, integrators[i], "[albedo, mean_distance, position]");
    double largest = 0.0;
    for (size_t p = 0; p < count_pixels(image); p++) {
      for (int c = 0; c < 3; c++) largest = fmax(largest, get_color(image, "albedo", c, p));
      const double away[3] = {get_value(image, "position.X", p), get_value(image, "position.Y", p) + 3000.0,
                              get_value(image, "position.Z", p) - 500.0};
      const double distance = get_value(image, "mean_distance", p);
      /* 1 %: the mean of places on rays about the pixel is nearer than the mean of their distances. */
      if (isfinite(distance)) assert_near_relative(hypot(hypot(away[0], away[1]), away[2]), distance, 0.01);
    }
    assert_true(largest > 0.99 && largest <= 1.0 + 1e-6);
    neph_image_destroy(image);
  }
  set(f, "render.transmittance_end", "0.001");
  set(f, "render.path_guiding", "none");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(alpha_covers_what_is_asked),       cmocka_unit_test(layers_merge_to_the_beauty),
      cmocka_unit_test(overscan_widens_the_data_window),  cmocka_unit_test(crops_take_the_overscan_at_the_edges),
      cmocka_unit_test(optical_depth_is_that_of_the_ray), cmocka_unit_test(albedo_never_exceeds_one),
  };
  return cmocka_run_group_tests(tests, set_up_layers, tear_down);
}

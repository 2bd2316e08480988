/* SPDX-License-Identifier: Apache-2.0 */
/* Groups of lights, in both integrators: they add up to the picture, and each is the picture under its light alone. */
#include "test_layers.h"

static const char colors[] = "RGB";

static double get_color(const neph_image *image, const char *layer, int color, size_t pixel) {
  char name[64];
  (void)snprintf(name, sizeof name, "%s%s%c", layer, layer[0] ? "." : "", colors[color]);
  return get_value(image, name, pixel);
}

/* 1e-5: sums of floats of the size of the layers, the sun's disk not in the picture. */
static void assert_groups_add_up(const neph_image *image, const char *const *groups) {
  for (size_t p = 0; p < count_pixels(image); p++)
    for (int c = 0; c < 3; c++) {
      double sum = 0.0;
      for (const char *const *group = groups; *group; group++) sum += get_color(image, *group, c, p);
      assert_near(sum, get_color(image, "", c, p), 1e-5 * fmax(1.0, fabs(sum)));
    }
}

/* ---- Sun and sky ---- */

typedef struct variant {
  const char *integrator, *atmosphere, *scattering;
  double tolerance; /* tolerance for means of pictures with and without groups */
} variant;

/* The march errs by its tolerance with either, by a few per mille; the mean of 2560 traced paths by 2 %. */
static const variant variants[] = {{"march", "traced", "ordinates", 0.01},
                                   {"march", "traced", "octaves", 0.01},
                                   {"path", "traced", "ordinates", 0.06},
                                   {"path", "tables", "ordinates", 0.06}};

static void groups_add_up_to_the_picture(void **state) {
  fixture *f = *state;
  static const char *const groups[] = {"light_sun", "light_sky", NULL};
  for (size_t i = 0; i < sizeof variants / sizeof *variants; i++) {
    const variant *v = &variants[i];
    set(f, "render.atmosphere", v->atmosphere);
    set(f, "render.multiple_scattering", v->scattering);
    neph_image *plain = render_layers(f, v->integrator, "[]");
    neph_image *grouped = render_layers(f, v->integrator, "[lights]");
    assert_groups_add_up(grouped, groups);
    assert_near_relative(get_mean(grouped, "G"), get_mean(plain, "G"), v->tolerance);
    assert_true(get_mean(grouped, "light_sun.G") > 0.0 && get_mean(grouped, "light_sky.G") > 0.0);
    neph_image_destroy(plain);
    neph_image_destroy(grouped);
  }
  set(f, "render.atmosphere", "traced");
  set(f, "render.multiple_scattering", "ordinates");
}

/* Both ways of the air agree on the parts: 4 %, the noise of 40960 paths and light that clouds and hills send into the
 * air, of which tables know little. */
static void both_ways_agree_on_the_parts(void **state) {
  fixture *f = *state;
  set(f, "render.samples", "64");
  neph_image *march = render_layers(f, "march", "[lights]");
  neph_image *path = render_layers(f, "path", "[lights]");
  assert_near_relative(get_mean(path, "light_sun.G"), get_mean(march, "light_sun.G"), 0.04);
  assert_near_relative(get_mean(path, "light_sky.G"), get_mean(march, "light_sky.G"), 0.04);
  neph_image_destroy(march);
  neph_image_destroy(path);
  set(f, "render.samples", "4");
}

/* ---- One light alone ---- */

static neph_image *render_alone(fixture *f, const char *integrator, const char *key, const char *dark,
                                const char *usual) {
  set(f, key, dark);
  neph_image *image = render_layers(f, integrator, "[]");
  set(f, key, usual);
  return image;
}

/* Without air there is nothing between the lights: a group is the picture that the other light has left. 0.1 %: the
 * march's steps where the sun shines go by its direction. Paths take other ways: 5 % of noise in the mean. */
static void a_group_is_the_picture_under_its_light(void **state) {
  fixture *f = *state;
  set(f, "output.color_space", "bands"); /* whose colours do not go by the scene's lights */
  set(f, "atmosphere.preset", "none");
  set(f, "environment.radiance", "0.05 W/m2/sr/nm");
  for (int i = 0; i < 2; i++) {
    const double tolerance = i ? 0.05 : 1e-3;
    neph_image *groups = render_layers(f, integrators[i], "[lights]");
    neph_image *sky = render_alone(f, integrators[i], "sun.irradiance", "0", "1.5 W/m2/nm");
    set(f, "sun.irradiance", "[1.474, 1.8504, 1.91198]");
    neph_image *sun = render_alone(f, integrators[i], "environment.radiance", "0", "0.05 W/m2/sr/nm");
    assert_near_relative(get_mean(groups, "light_sky.G"), get_mean(sky, "G"), tolerance);
    assert_near_relative(get_mean(groups, "light_sun.G"), get_mean(sun, "G"), tolerance);
    neph_image_destroy(groups);
    neph_image_destroy(sky);
    neph_image_destroy(sun);
  }
  set(f, "environment.radiance", "0");
  set(f, "atmosphere.preset", "earth");
  set(f, "output.color_space", "rec709");
}

/* ---- Moon ---- */

static void the_moon_is_a_group_with_its_sky(void **state) {
  fixture *f = *state;
  static const char *const groups[] = {"light_sun", "light_sky", "light_moon", NULL};
  set(f, "sun.elevation", "-8 deg");
  set(f, "moon.elevation", "40 deg");
  set(f, "moon.azimuth", "90 deg");
  set(f, "moon.brightness", "100");
  for (int i = 0; i < 2; i++) {
    neph_image *image = render_layers(f, integrators[i], "[lights]");
    assert_groups_add_up(image, groups);
    assert_true(get_mean(image, "light_moon.G") > 0.0 && get_mean(image, "light_sky.G") > 0.0);
    neph_image_destroy(image);
  }
  set(f, "moon", "none");
  set(f, "sun.elevation", "35 deg");
}

/* ---- Plan ---- */

static void their_cost_is_in_the_plan(void **state) {
  fixture *f = *state;
  char *plain, *grouped;
  set(f, "output.aovs", "[]");
  assert_int_equal(neph_render_explain(f->scene, NULL, NEPH_TEXT_PLAIN, &plain), NEPH_OK);
  set(f, "output.aovs", "[lights]");
  assert_int_equal(neph_render_explain(f->scene, NULL, NEPH_TEXT_PLAIN, &grouped), NEPH_OK);
  assert_null(strstr(plain, "groups of lights"));
  assert_non_null(strstr(grouped, "2 groups of lights, each solved for and traced apart"));
  neph_text_destroy(f->context, plain);
  neph_text_destroy(f->context, grouped);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(groups_add_up_to_the_picture),
      cmocka_unit_test(both_ways_agree_on_the_parts),
      cmocka_unit_test(a_group_is_the_picture_under_its_light),
      cmocka_unit_test(the_moon_is_a_group_with_its_sky),
      cmocka_unit_test(their_cost_is_in_the_plan),
  };
  return cmocka_run_group_tests(tests, set_up_layers, tear_down);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* render.air_shadows, seen in whole pictures. */
#include "test_support.h"

#include <nephos/nephos.h>

#define CAMERA "version: 1\ncamera: {position: [0, -8 km, 900 m], look_at: [0, 0, 900 m], resolution: [24, 14]}\n"
#define LOW_SUN "sun: {elevation: 4 deg, azimuth: 60 deg}\n"
#define HILLS "terrain: {ridges: {samples: 129, relief: 1500 m}, width: 20 km, albedo: 0}\n"

static neph_image *render(neph_context *context, const char *text, const char *shadows) {
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  assert_int_equal(neph_scene_load_text(context, text, "test.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "output.aovs", "[air]"), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.samples", "4"), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.air_shadows", shadows), NEPH_OK);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  neph_scene_destroy(scene);
  return image;
}

static const float *get_channel(neph_image *image, const char *name, size_t *out_count) {
  *out_count = (size_t)neph_image_get_width(image) * neph_image_get_height(image);
  const float *values = neph_image_get_channel(image, name);
  assert_non_null(values);
  return values;
}

/* Hills under a low sun take light from the air between them, of which some has been scattered more than once and
 * stays; they add none. 1 %: the shadowed sky's azimuths are traced, the clear one's are splines. */
static void hills_darken_the_air_behind_them(void **state) {
  neph_context *context = *state;
  neph_image *clear = render(context, CAMERA LOW_SUN HILLS, "false");
  neph_image *shadowed = render(context, CAMERA LOW_SUN HILLS, "true");
  size_t count;
  const float *a = get_channel(clear, "air.G", &count), *b = get_channel(shadowed, "air.G", &count);
  double before = 0.0, after = 0.0;
  for (size_t i = 0; i < count; i++) {
    assert_true(b[i] <= 1.01f * a[i]);
    before += (double)a[i];
    after += (double)b[i];
  }
  assert_true(after < 0.97 * before && after > 0.3 * before);
  neph_image_destroy(clear);
  neph_image_destroy(shadowed);
}

static void where_nothing_stands_nothing_changes(void **state) {
  neph_context *context = *state;
  neph_image *clear = render(context, CAMERA LOW_SUN, "false"), *shadowed = render(context, CAMERA LOW_SUN, "true");
  size_t count;
  const float *a = get_channel(clear, "G", &count), *b = get_channel(shadowed, "G", &count);
  assert_memory_equal(a, b, count * sizeof *a);
  neph_image_destroy(clear);
  neph_image_destroy(shadowed);
}

static int set_up(void **state) { return *state = test_context_create(2, NULL), 0; }
static int tear_down(void **state) { return neph_context_destroy(*state), 0; }

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(hills_darken_the_air_behind_them),
      cmocka_unit_test(where_nothing_stands_nothing_changes),
  };
  return cmocka_run_group_tests(tests, set_up, tear_down);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Fixture of the tests of the night sky: a context with a log and a folder, and pictures, in bands, of scenes given as
 * text. */
#ifndef NP_TEST_NIGHTS_H
#define NP_TEST_NIGHTS_H

#include <stdlib.h>

#include "test_support.h"

#include <nephos/nephos.h>

#include "core/spectrum.h"
#include "core/units.h"

static inline int set_up(void **state) { return test_set_up(state, 2, "night.exr"); }

static inline neph_scene *load(test_fixture *f, const char *text) {
  neph_scene *scene;
  if (neph_scene_load_text(f->context, text, "night.yaml", &scene)) fail_msg("%s", f->log.text);
  assert_int_equal(neph_scene_set(scene, "output.color_space", "bands"), NEPH_OK);
  return scene;
}

/* The sky of a scene by longitude and latitude. */
static inline neph_image *paint_sky(test_fixture *f, const char *text, unsigned width) {
  neph_scene *scene = load(f, text);
  neph_sky_image_desc desc = NEPH_SKY_IMAGE_DESC_DEFAULT;
  neph_image *image;
  desc.width = width;
  desc.height = width / 2;
  assert_int_equal(neph_render_sky(scene, &desc, &image), NEPH_OK);
  neph_scene_destroy(scene);
  return image;
}

static inline neph_image *render(test_fixture *f, const char *text) {
  neph_scene *scene = load(f, text);
  neph_image *image;
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  neph_scene_destroy(scene);
  return image;
}

static inline size_t count_pixels(const neph_image *image) {
  return (size_t)neph_image_get_width(image) * neph_image_get_height(image);
}

static const double bands_nm[NP_BAND_COUNT] = {680.0, 550.0, 440.0};

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

#endif

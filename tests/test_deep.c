/* SPDX-License-Identifier: Apache-2.0 */
/* Deep pixels of the clouds: they flatten to the layer of the clouds, in order and without overlap, in both
 * integrators; a cut through them has what is before it. */
#include "image/deep.h"
#include "test_layers.h"

/* The limit of the layers' agreement, relative to what is there: floats would do with 1e-5. */
static const double limit = 1e-3;

/* Coverage and light of a pixel's samples before a depth. */
static void flatten(const np_deep_pixel *pixel, double depth, double out[4]) {
  double left = 1.0;
  for (int c = 0; c < 4; c++) out[c] = 0.0;
  for (unsigned s = 0; s < pixel->count; s++) {
    const np_deep_sample *sample = &pixel->samples[s];
    if ((double)sample->front >= depth) break;
    for (int c = 0; c < 3; c++) out[c] += left * (double)sample->color[c];
    left *= 1.0 - (double)sample->alpha;
  }
  out[3] = 1.0 - left;
}

static void check_order(const np_deep_pixel *pixel) {
  assert_true(pixel->count <= NP_DEEP_SAMPLES_MAX);
  for (unsigned s = 0; s < pixel->count; s++) {
    const np_deep_sample *sample = &pixel->samples[s];
    assert_true(sample->front > 0.0f && sample->front <= sample->back);
    assert_true(sample->alpha >= 0.0f && sample->alpha <= 1.0f);
    if (s > 0) assert_true(sample->front >= pixel->samples[s - 1].back);
  }
}

static unsigned check_flat(const neph_image *image) {
  static const char *const channels[] = {"clouds.R", "clouds.G", "clouds.B", "clouds.A"};
  unsigned most = 0;
  assert_true(neph_image_has_deep(image));
  for (size_t p = 0; p < count_pixels(image); p++) {
    double flat[4];
    check_order(&image->deep[p]);
    flatten(&image->deep[p], HUGE_VAL, flat);
    for (int c = 0; c < 4; c++) {
      const double value = get_value(image, channels[c], p);
      assert_near(flat[c], value, limit * fmax(fabs(value), 1e-3));
    }
    if (image->deep[p].count > most) most = image->deep[p].count;
  }
  return most;
}

typedef struct variant {
  const char *integrator, *key, *value, *usual;
} variant;

static void deep_pixels_flatten_to_the_clouds(void **state) {
  fixture *f = *state;
  static const variant variants[] = {{"march", "output.cloud_air", "kept", "kept"},
                                     {"march", "output.cloud_air", "apart", "kept"},
                                     {"march", "render.multiple_scattering", "octaves", "ordinates"},
                                     {"march", "render.wavelengths", "6", "3"},
                                     {"march", "clouds[1].holdout", "true", "false"},
                                     {"march", "render.samples", "40", "4"},
                                     {"march", "render.time_limit", "1000 s", "none"},
                                     {"march", "render.target_error", "0.1", "none"},
                                     {"path", "render.atmosphere", "traced", "traced"},
                                     {"path", "render.atmosphere", "tables", "traced"},
                                     {"path", "output.cloud_air", "apart", "kept"},
                                     {"path", "render.path_guiding", "adjoint", "none"},
                                     {"path", "render.samples", "40", "4"}};
  set(f, "output.deep", "deep.exr");
  for (size_t i = 0; i < sizeof variants / sizeof *variants; i++) {
    const variant *v = &variants[i];
    set(f, v->key, v->value);
    neph_image *image = render_layers(f, v->integrator, "[clouds]");
    assert_true(check_flat(image) >= 4);
    neph_image_destroy(image);
    set(f, v->key, v->usual);
  }
}

/* Before 3.2 km stands the right cloud alone, behind it the left one: a cut there is the right one's matte. 0.01:
 * the march's Russian roulette, whose opacities are scaled to the coverage. Depths count from the eye, wherever the
 * near plane is. */
static void a_cut_between_two_clouds_has_the_first(void **state) {
  fixture *f = *state;
  set(f, "output.deep", "deep.exr");
  for (int i = 0; i < 4; i++) {
    set(f, "camera.near", i < 2 ? "0 m" : "1 km");
    neph_image *image = render_layers(f, integrators[i % 2], "[mattes]");
    unsigned both = 0;
    for (size_t p = 0; p < count_pixels(image); p++) {
      double cut[4];
      const double left = get_value(image, "matte.left", p), right = get_value(image, "matte.right", p);
      flatten(&image->deep[p], 3100.0, cut);
      assert_near(cut[3], right, 0.01);
      both += left > 0.1 && right > 0.1;
    }
    assert_true(both > 0);
    neph_image_destroy(image);
  }
  set(f, "camera.near", "0 m");
}

static void without_a_file_there_are_none(void **state) {
  fixture *f = *state;
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  assert_int_equal(neph_scene_load_text(f->context, layered_scene, "flat.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.samples", "1"), NEPH_OK);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  assert_false(neph_image_has_deep(image));
  test_log_clear(&f->log);
  assert_int_equal(neph_image_save_deep_exr(image, "none.exr", NEPH_PIXEL_HALF), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "none.exr", "no deep pixels", "output.deep");
  neph_image_destroy(image);
  neph_scene_destroy(scene);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(without_a_file_there_are_none),
      cmocka_unit_test(deep_pixels_flatten_to_the_clouds),
      cmocka_unit_test(a_cut_between_two_clouds_has_the_first),
  };
  return cmocka_run_group_tests(tests, set_up_layers, tear_down);
}

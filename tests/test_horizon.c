/* SPDX-License-Identifier: Apache-2.0 */
/* Pixels that the horizon cuts have both of its sides in each sample. */
#include "test_scenes.h"

#include <math.h>

/* A sphere below an even sky. */
static const char scene[] = "camera: {position: [0 m, 0 m, 10 m], look_at: [0 m, 100 m, 10 m], fov: 40 deg,\n"
                            "         resolution: [48, 12]}\n"
                            "sun: {elevation: 40 deg}\n"
                            "atmosphere: none\n"
                            "environment: {radiance: 1}\n";

enum { PIXELS = 48 * 12 };

static int set_up(void **state) { return set_up_scene(state, 2, scene); }

static void render(fixture *f, const char *samples, float out[PIXELS]) {
  neph_image *image;
  set(f, "render.samples", samples);
  assert_int_equal(neph_render_image(f->scene, NULL, &image), NEPH_OK);
  const float *green = neph_image_get_channel(image, "G");
  for (int i = 0; i < PIXELS; i++) out[i] = green[i];
  neph_image_destroy(image);
}

/* Along one axis the coverage of a sample is exact. Across the filter a tilt of 3° changes it by 0.1 of a pixel, of
 * which two samples know two places: 0.02 holds that; one ray a sample errs by 0.2. */
static void two_samples_have_its_coverage(void **state) {
  fixture *f = *state;
  static const char *const integrators[] = {"march", "path"}, *const rolls[] = {"0 deg", "3 deg", "87 deg"};
  for (int i = 0; i < 2; i++)
    for (int r = 0; r < 3; r++) {
      float some[PIXELS], many[PIXELS];
      double sum = 0, bright = 0, dark = HUGE_VAL;
      int cut = 0;
      set(f, "render.integrator", integrators[i]);
      set(f, "camera.roll", rolls[r]);
      render(f, "256", many);
      render(f, "2", some);
      for (int k = 0; k < PIXELS; k++) bright = fmax(bright, (double)many[k]), dark = fmin(dark, (double)many[k]);
      for (int k = 0; k < PIXELS; k++) {
        const double coverage = ((double)many[k] - dark) / (bright - dark);
        if (!(coverage > 0.02 && coverage < 0.98)) continue;
        sum += pow((double)(some[k] - many[k]) / (bright - dark), 2);
        cut++;
      }
      print_message("%s, %s: %.3g over %d pixels\n", integrators[i], rolls[r], sqrt(sum / cut), cut);
      assert_true(cut >= 10);
      assert_true(sqrt(sum / cut) < 0.02);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(two_samples_have_its_coverage, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

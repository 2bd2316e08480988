/* SPDX-License-Identifier: Apache-2.0 */
/* Previews by views of OpenColorIO: known answers of two configurations, and refusals. */
#include "test_support.h"

#include <nephos/exposure.h>
#include <nephos/image.h>

/* The reference space is ACES2065-1. The space `straight` is light with Rec.709's primaries by the matrix of the
 * Academy (ACES 1.0.3, "Utility - Linear - Rec.709", Bradford), which is not the library's. */
static const char aces_config[] = "ocio_profile_version: 2\n"
                                  "roles: {default: raw, scene_linear: aces, aces_interchange: aces}\n"
                                  "displays:\n"
                                  "  screen:\n"
                                  "    - !<View> {name: straight, colorspace: straight}\n"
                                  "    - !<View> {name: raw, colorspace: raw}\n"
                                  "  wall:\n"
                                  "    - !<View> {name: curve, colorspace: curve}\n"
                                  "colorspaces:\n"
                                  "  - !<ColorSpace> {name: raw, isdata: true}\n"
                                  "  - !<ColorSpace> {name: aces}\n"
                                  "  - !<ColorSpace>\n"
                                  "    name: straight\n"
                                  "    from_scene_reference: !<MatrixTransform> {matrix: [2.52168619, -1.13413099, "
                                  "-0.38755520, 0, -0.27647991, 1.37271909, -0.09623917, 0, -0.01537806, "
                                  "-0.15297534, 1.16835340, 0, 0, 0, 0, 1]}\n"
                                  "  - !<ColorSpace>\n"
                                  "    name: curve\n"
                                  "    from_scene_reference: !<ExponentTransform> {value: 0.5}\n";

/* A configuration without roles of interchange; its space of light has the name that the configurations of ACES use. */
static const char named_config[] = "ocio_profile_version: 2\n"
                                   "roles: {default: raw}\n"
                                   "displays:\n"
                                   "  screen:\n"
                                   "    - !<View> {name: curve, colorspace: curve}\n"
                                   "colorspaces:\n"
                                   "  - !<ColorSpace> {name: raw, isdata: true}\n"
                                   "  - !<ColorSpace> {name: %s}\n"
                                   "  - !<ColorSpace>\n"
                                   "    name: curve\n"
                                   "    from_scene_reference: !<ExponentTransform> {value: 0.5}\n";

enum { SIDE = 3, PIXELS = SIDE * SIDE };

static const float lights[PIXELS][3] = {{0, 0, 0},          {0.18f, 0.18f, 0.18f}, {1, 1, 1},
                                        {0.6f, 0.1f, 0.1f}, {0.1f, 0.6f, 0.1f},    {0.1f, 0.1f, 0.6f},
                                        {3, 3, 3},          {0.5f, 0.7f, 0.9f},    {0.9f, 0.4f, 0.05f}};

static neph_image *make_image(neph_context *context) {
  static const char *const names[] = {"R", "G", "B"};
  neph_image *image;
  assert_int_equal(neph_image_create(context, SIDE, SIDE, 3, names, &image), NEPH_OK);
  for (int c = 0; c < 3; c++)
    for (int i = 0; i < PIXELS; i++) neph_image_get_channel(image, names[c])[i] = lights[i][c];
  return image;
}

/* A preview by a configuration of this text, in a file of the test. */
static neph_preview_desc make_desc(test_fixture *f, const char *text) {
  neph_preview_desc desc = NEPH_PREVIEW_DESC_DEFAULT;
  test_file_write_text(f->path, text);
  desc.exposure = NEPH_EXPOSURE_FIXED;
  desc.view = NEPH_VIEW_OCIO;
  desc.ocio_config = f->path;
  desc.bits = 16;
  return desc;
}

/* A configuration is the test's file. */
static int set_up(void **state) { return test_set_up(state, 2, "config.ocio"); }

/* Components of the saved preview in [0, 1]; a step of 16 bits is 1.5e-5, and dither adds one. */
static void show(test_fixture *f, const neph_preview_desc *desc, double out[PIXELS][3]) {
  static const char *const names[] = {"R", "G", "B"};
  char png[600];
  neph_image *image = make_image(f->context), *shown;
  (void)snprintf(png, sizeof png, "%s.png", f->path);
  assert_int_equal(neph_image_save_png(image, png, desc), NEPH_OK);
  assert_int_equal(neph_image_load_png(f->context, png, &shown), NEPH_OK);
  for (int c = 0; c < 3; c++)
    for (int i = 0; i < PIXELS; i++) out[i][c] = (double)neph_image_get_channel(shown, names[c])[i];
  neph_image_destroy(image);
  neph_image_destroy(shown);
  (void)remove(png);
}

static const double step = 3e-5;

/* Rec.709 to ACES2065-1 and back by the Academy's matrix leaves a colour as it is, to the seven digits of either. */
static void light_goes_by_the_interchange(void **state) {
  test_fixture *f = *state;
  const neph_preview_desc desc = make_desc(f, aces_config);
  double shown[PIXELS][3];
  show(f, &desc, shown);
  for (int i = 0; i < PIXELS; i++)
    for (int c = 0; c < 3; c++) assert_near(shown[i][c], fmin((double)lights[i][c], 1.0), step + 2e-5);
}

/* A grey of ACES2065-1 is a grey of Rec.709; its square root is the view's. Exposure comes before. */
static void display_and_exposure_are_chosen(void **state) {
  test_fixture *f = *state;
  neph_preview_desc desc = make_desc(f, aces_config);
  double shown[PIXELS][3];
  desc.ocio_display = "wall";
  desc.exposure_ev = -1.0;
  show(f, &desc, shown);
  for (int c = 0; c < 3; c++) {
    assert_near(shown[1][c], sqrt(0.09), step + 2e-4);
    assert_near(shown[2][c], sqrt(0.5), step + 2e-4);
    assert_near(shown[6][c], 1.0, step);
  }
}

/* Without roles the space goes by its name, or by the description's. */
static void input_goes_by_its_name(void **state) {
  test_fixture *f = *state;
  static const char *const names[] = {"lin_rec709", "film_light"};
  for (int k = 0; k < 2; k++) {
    char text[1000];
    double shown[PIXELS][3];
    (void)snprintf(text, sizeof text, named_config, names[k]);
    neph_preview_desc desc = make_desc(f, text);
    if (k) desc.ocio_input = names[k];
    show(f, &desc, shown);
    for (int i = 0; i < PIXELS; i++)
      for (int c = 0; c < 3; c++) assert_near(shown[i][c], sqrt(fmin((double)lights[i][c], 1.0)), step);
  }
}

/* Pixels in memory are the nearest steps to the same components. */
static void pixels_in_memory_are_the_files(void **state) {
  test_fixture *f = *state;
  neph_preview_desc desc = make_desc(f, aces_config);
  double shown[PIXELS][3];
  uint8_t rgba[PIXELS][4];
  desc.ocio_display = "wall";
  show(f, &desc, shown);
  neph_image *image = make_image(f->context);
  assert_int_equal(neph_image_develop(image, &desc, 0, 0, SIDE, SIDE, rgba[0], sizeof rgba[0] * SIDE), NEPH_OK);
  for (int i = 0; i < PIXELS; i++)
    for (int c = 0; c < 3; c++) assert_near(rgba[i][c] / 255.0, shown[i][c], 0.5 / 255.0 + step);
  neph_image_destroy(image);
}

/* A changed file is read anew. */
static void changes_of_the_file_are_seen(void **state) {
  test_fixture *f = *state;
  char text[1000];
  (void)snprintf(text, sizeof text, named_config, "lin_rec709");
  const neph_preview_desc before = make_desc(f, aces_config);
  assert_int_equal(neph_preview_check(f->context, &before), NEPH_OK);
  neph_preview_desc after = make_desc(f, text);
  after.ocio_display = "wall";
  assert_int_equal(neph_preview_check(f->context, &after), NEPH_ERROR_INVALID_ARGUMENT);
  test_log_clear(&f->log);
}

static void refuse(test_fixture *f, const neph_preview_desc *desc, neph_result result, const char *message) {
  test_log_clear(&f->log);
  assert_int_equal(neph_preview_check(f->context, desc), result);
  assert_one_error(&f->log, message);
}

static void faults_are_named(void **state) {
  test_fixture *f = *state;
  char text[1000];
  neph_preview_desc desc = make_desc(f, aces_config), bad = desc;
  bad.ocio_display = "paper";
  refuse(f, &bad, NEPH_ERROR_INVALID_ARGUMENT, "display is paper, must be one of: screen, wall");
  bad = desc, bad.ocio_view = "curve";
  refuse(f, &bad, NEPH_ERROR_INVALID_ARGUMENT, "view is curve, must be one of: straight, raw");
  bad = desc, bad.ocio_input = "lin";
  refuse(f, &bad, NEPH_ERROR_INVALID_ARGUMENT, "input is lin, must be one of: raw, aces, straight, curve");
  bad = desc, bad.ocio_config = NULL;
  refuse(f, &bad, NEPH_ERROR_INVALID_ARGUMENT, "which needs ocio_config");
  bad.ocio_config = "/nowhere/config.ocio";
  refuse(f, &bad, NEPH_ERROR_NOT_FOUND, "/nowhere/config.ocio: cannot be read: No such file");
  bad.ocio_config = "/";
  refuse(f, &bad, NEPH_ERROR_BAD_FILE, "must be a file");
  (void)snprintf(text, sizeof text, named_config, "film_light");
  bad = make_desc(f, text);
  refuse(f, &bad, NEPH_ERROR_INVALID_ARGUMENT, "no role aces_interchange: input must name its space");
  static const char *const damaged[] = {"", "ocio_profile_version: 99\n", "displays: [[[\n", "\x01\x02\x03",
                                        "ocio_profile_version: 2\nroles: {default: lost}\n"};
  for (size_t i = 0; i < sizeof damaged / sizeof *damaged; i++) {
    bad = make_desc(f, damaged[i]);
    refuse(f, &bad, NEPH_ERROR_BAD_FILE, f->path);
  }
}

/* Every file that lacks its end, or has a byte changed, is refused or used, and never ends the process. */
static void damaged_files_do_no_harm(void **state) {
  test_fixture *f = *state;
  char text[sizeof aces_config];
  unsigned refused = 0;
  for (size_t i = 0; i < sizeof aces_config - 1; i += 7) {
    memcpy(text, aces_config, sizeof text);
    if (i % 2)
      text[i] = '\0';
    else
      text[i] = (char)(text[i] ^ 1 << i % 7);
    const neph_preview_desc desc = make_desc(f, text);
    refused += neph_preview_check(f->context, &desc) != NEPH_OK;
  }
  assert_true(refused > 20);
  test_log_clear(&f->log);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(light_goes_by_the_interchange, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(display_and_exposure_are_chosen, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(input_goes_by_its_name, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(pixels_in_memory_are_the_files, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(changes_of_the_file_are_seen, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(faults_are_named, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(damaged_files_do_no_harm, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

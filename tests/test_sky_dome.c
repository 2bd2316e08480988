/* SPDX-License-Identifier: Apache-2.0 */
/* Skies as light for other renderers: their irradiance, orientation, and USD layers. */
#include <stdlib.h>

#include <nephos/nephos.h>

#include "core/units.h"
#include "test_support.h"

static int set_up(void **state) { return test_set_up_cached(state, 2, NULL); }

static const char day[] = "{camera: {position: [0, 0, 100 m], look_at: [0, 1 km, 100 m], focal_length: 35 mm,"
                          " resolution: [160, 90]}, sun: {elevation: 40 deg, azimuth: 90 deg}, render: {samples: 4},"
                          " output: {scale: 4}}";

static const double scale = 4.0;

static neph_scene *load(test_fixture *f) {
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(f->context, day, "test.yaml", &scene), NEPH_OK);
  return scene;
}

static neph_image *paint(neph_scene *scene, unsigned width, neph_sky_disks disks, double center_rad) {
  neph_sky_image_desc desc = NEPH_SKY_IMAGE_DESC_DEFAULT;
  desc.width = width;
  desc.height = width / 2;
  desc.disks = disks;
  desc.center_azimuth_rad = center_rad;
  neph_image *image;
  assert_int_equal(neph_render_sky(scene, &desc, &image), NEPH_OK);
  return image;
}

static double read_number(const neph_image *image, const char *name, int index) {
  char *rest = NULL;
  const char *text = neph_image_get_attribute(image, name);
  assert_non_null(text);
  double value = strtod(text, &rest);
  for (int i = 0; i < index; i++) value = strtod(rest, &rest);
  return value;
}

/* Irradiance on a level surface that faces up: green, of rows whole pictures of this height have. */
static double sum_irradiance(neph_image *image, unsigned whole, unsigned top) {
  const float *plane = neph_image_get_channel(image, "G");
  const unsigned width = neph_image_get_width(image), height = neph_image_get_height(image);
  double sum = 0.0;
  for (unsigned y = 0; y < height && y + top < whole / 2; y++) {
    const double a = cos(NP_PI * (y + top) / whole), b = cos(NP_PI * (y + top + 1.0) / whole);
    for (unsigned x = 0; x < width; x++) sum += 0.5 * (a * a - b * b) * NP_PI / whole * (double)plane[y * width + x];
  }
  return sum;
}

/* Sun in R, G, B: they are all channels, and light a level surface as sun and sky do. 1 %: a pixel's averages of the
 * disk have 4 to 64 probes a side. */
static void a_dome_holds_sun_and_sky(void **state) {
  neph_scene *scene = load(*state);
  neph_image *image = paint(scene, 512, NEPH_SKY_DISKS_INCLUDE, NP_PI);
  neph_image *sky = paint(scene, 512, NEPH_SKY_DISKS_NONE, NP_PI);
  const double sun = read_number(image, "nephos:sunIrradiance", 1), own = read_number(image, "nephos:skyIrradiance", 1);
  assert_int_equal(neph_image_get_channel_count(image), 3);
  assert_int_equal(neph_image_get_channel_count(sky), 3);
  assert_near_relative(sum_irradiance(image, 256, 0), scale * (sun + own), 0.01);
  assert_near_relative(sum_irradiance(sky, 256, 0), scale * own, 0.01);
  assert_near_relative(read_number(image, "nephos:sunNormalIrradiance", 1) * sin(40.0 * NP_DEGREE), sun, 2e-3);
  assert_near(read_number(image, "nephos:sunDirection", 0), cos(40.0 * NP_DEGREE), 1e-6);
  neph_image_destroy(image);
  neph_image_destroy(sky);
  neph_scene_destroy(scene);
}

static unsigned get_brightest_column(neph_image *image) {
  const float *green = neph_image_get_channel(image, "G");
  const unsigned width = neph_image_get_width(image), count = width * neph_image_get_height(image);
  unsigned brightest = 0;
  for (unsigned p = 0; p < count; p++)
    if (green[p] > green[brightest]) brightest = p;
  return brightest % width;
}

/* The sun in the east: a quarter in, of OpenEXR's layout; in the middle, of Blender's. */
static void the_middle_is_where_it_is_asked_for(void **state) {
  neph_scene *scene = load(*state);
  const double centers[] = {NP_PI, 0.5 * NP_PI, 0.0};
  const int columns[] = {64, 128, 192};
  for (int i = 0; i < 3; i++) {
    neph_image *image = paint(scene, 256, NEPH_SKY_DISKS_INCLUDE, centers[i]);
    assert_near((double)get_brightest_column(image), columns[i], 1.0);
    neph_image_destroy(image);
  }
  neph_scene_destroy(scene);
}

static neph_image *render_panorama(neph_scene *scene, unsigned width, unsigned samples, const unsigned crop[4]) {
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_image *image;
  assert_int_equal(neph_scene_set(scene, "camera.kind", "equirectangular"), NEPH_OK);
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.width = width;
  desc.height = width / 2;
  desc.sample_count = samples;
  for (int a = 0; a < 2; a++) {
    desc.crop_min[a] = crop ? crop[a] : 0;
    desc.crop_max[a] = crop ? crop[2 + a] : a ? desc.height : desc.width;
  }
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_OK);
  return image;
}

/* The camera's panorama: the sky without the disk, and what the disk adds to the part around it. 2 %: of the sky, rows
 * of 2.8°; of the sun, what 256 samples a pixel find of it on 24 pixels. */
static void a_panorama_holds_sun_and_sky(void **state) {
  neph_scene *scene = load(*state);
  neph_image *sky = paint(scene, 64, NEPH_SKY_DISKS_NONE, NP_PI);
  const double sun = read_number(sky, "nephos:sunIrradiance", 1), own = read_number(sky, "nephos:skyIrradiance", 1);
  /* North in the middle, the sun 90° to the right, 50° down. */
  static const unsigned crop[4] = {1528, 276, 1544, 292};
  neph_image *with = render_panorama(scene, 2048, 256, crop);
  assert_int_equal(neph_scene_set(scene, "output.film.disks", "false"), NEPH_OK);
  neph_image *without = render_panorama(scene, 2048, 256, crop), *all = render_panorama(scene, 128, 4, NULL);
  assert_near_relative(sum_irradiance(with, 1024, 276) - sum_irradiance(without, 1024, 276), scale * sun, 0.02);
  assert_near_relative(sum_irradiance(all, 64, 0), scale * own, 0.02);
  neph_image *const images[] = {sky, with, without, all};
  for (int i = 0; i < 4; i++) neph_image_destroy(images[i]);
  neph_scene_destroy(scene);
}

static char *read_text(const char *path) {
  FILE *file = fopen(path, "r");
  assert_non_null(file);
  char *text = calloc(1, 8192);
  assert_non_null(text);
  assert_true(fread(text, 1, 8191, file) > 0);
  assert_int_equal(fclose(file), 0);
  return text;
}

static void assert_holds(const char *text, const char *part) {
  if (!strstr(text, part)) fail_msg("no %s in %s", part, text);
}

/* Braces and brackets close; the lights are the sky's numbers; the sun shines from the east along its -Z. */
static void a_layer_has_dome_sun_and_camera(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load(f);
  neph_image *sky = paint(scene, 16, NEPH_SKY_DISKS_NONE, NP_PI);
  char *path = test_path(f->folder, "sky.usda");
  assert_int_equal(neph_scene_save_usd(scene, sky, "sky.exr", path), NEPH_OK);
  char *text = read_text(path);
  int depth[3] = {0};
  for (const char *c = text; *c; c++)
    for (int k = 0; k < 3; k++) depth[k] += (*c == "{[("[k]) - (*c == "}])"[k]);
  for (int k = 0; k < 3; k++) assert_int_equal(depth[k], 0);
  assert_int_equal(strncmp(text, "#usda 1.0\n", 10), 0);
  assert_holds(text, "def DomeLight \"Sky\"");
  assert_holds(text, "asset inputs:texture:file = @sky.exr@");
  assert_holds(text, "float xformOp:rotateX = 90");
  assert_holds(text, "def DistantLight \"Sun\"");
  assert_holds(text, "bool inputs:normalize = 1");
  assert_holds(text, "float inputs:angle = 0.535");
  assert_holds(text, "float focalLength = 0.35\n"); /* 35 mm in tenths of a metre */
  assert_holds(text, "float horizontalAperture = 0.36\n");
  assert_holds(text, "float verticalAperture = 0.2025\n");
  const char *color = strstr(text, "color = (");
  assert_non_null(color);
  assert_near_relative(strtod(color + strlen("color = ("), NULL),
                       scale * read_number(sky, "nephos:sunNormalIrradiance", 0), 1e-5);
  const char *turn = strstr(strstr(text, "DistantLight"), "matrix4d");
  const char *z = strchr(strchr(strchr(turn, ')') + 1, ')') + 1, '(');
  assert_near(strtod(z + 1, NULL), cos(40.0 * NP_DEGREE), 1e-6);
  free(text);
  neph_image_destroy(sky);
  sky = paint(scene, 16, NEPH_SKY_DISKS_INCLUDE, NP_PI);
  assert_int_equal(neph_scene_save_usd(scene, sky, "sky.exr", path), NEPH_OK);
  text = read_text(path);
  assert_null(strstr(text, "DistantLight")); /* it is in the dome */
  free(text);
  free(path);
  test_log_clear(&f->log);
  assert_int_equal(neph_scene_save_usd(scene, sky, "a@b.exr", "x.usda"), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "texture is a@b.exr, must hold neither @ nor a line break", "");
  neph_image_destroy(sky);
  neph_scene_destroy(scene);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(a_dome_holds_sun_and_sky, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(the_middle_is_where_it_is_asked_for, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_panorama_holds_sun_and_sky, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_layer_has_dome_sun_and_camera, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

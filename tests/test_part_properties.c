/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of one picture agree in what is a property of it, and state figures that can be. One of two parts is forged in
 * one field, and the merge names the field. The error of the whole is a known mean of those that the parts state. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <nephos/nephos.h>

#include "image/image_private.h"
#include "part_forge.h"
#include "test_support.h"

enum { TILES = 3 };

static const char scene_text[] =
    "version: 1\n"
    "camera: {position: [0 m, 0 m, 500 m], look_at: [0 m, 1 km, 700 m], resolution: [9, 17]}\n"
    "sun: {elevation: 30 deg}\n"
    "atmosphere: none\n"
    "environment: {radiance: 0, planet: none}\n"
    "render: {samples: 2, integrator: march, multiple_scattering: octaves}\n";

static neph_image *render_tile(test_fixture *f, unsigned tile, const char *part) {
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_load_text(f->context, scene_text, "test.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.tile_index = tile;
  desc.tile_count = TILES;
  desc.part_path = part;
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_OK);
  neph_scene_destroy(scene);
  return image;
}

/* Three tiles, as images and as the paths of their files. */
typedef struct tiles {
  neph_image *images[TILES];
  char *paths[TILES];
} tiles;

static void save(const tiles *t, unsigned i) {
  assert_int_equal(neph_image_save_exr(t->images[i], t->paths[i], NEPH_PIXEL_FLOAT), NEPH_OK);
}

static void make_tiles(test_fixture *f, const char *ending, tiles *out) {
  const bool is_part = !strcmp(ending, "npart");
  for (unsigned i = 0; i < TILES; i++) {
    char name[16];
    (void)snprintf(name, sizeof name, "%u.%s", i, ending);
    out->paths[i] = test_path(f->folder, name);
    out->images[i] = render_tile(f, i, is_part ? out->paths[i] : NULL);
    if (!is_part) save(out, i);
  }
  test_log_clear(&f->log);
}

static void clear_tiles(tiles *t) {
  for (unsigned i = 0; i < TILES; i++) {
    neph_image_destroy(t->images[i]);
    free(t->paths[i]);
  }
}

static neph_result merge(test_fixture *f, const tiles *t, neph_image **out_image) {
  return neph_parts_merge(f->context, (const char *const *)t->paths, TILES, NULL, out_image);
}

static void assert_merges(test_fixture *f, const tiles *t) {
  neph_image *image = NULL;
  assert_int_equal(merge(f, t, &image), NEPH_OK);
  neph_image_destroy(image);
}

/* One message, which names the file and the field. */
static void assert_refused(test_fixture *f, const tiles *t, const char *path, const char *field) {
  neph_image *image = NULL;
  if (!merge(f, t, &image)) fail_msg("%s was not refused", field);
  assert_null(image);
  assert_one_error(&f->log, path, field);
}

/* ---- Pictures of tiles ---- */

static void texts_of_tiles_agree(void **state) {
  static const char *const names[] = {
      "nephos:integrator", "nephos:colorSpace", "nephos:wavelengths",       "nephos:unit",
      "nephos:bandMatrix", "nephos:white",      "nephos:multipleScattering"};
  test_fixture *f = *state;
  tiles t;
  make_tiles(f, "exr", &t);
  assert_merges(f, &t);
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    const char *stated = neph_image_get_attribute(t.images[1], names[i]);
    char *kept = stated ? strdup(stated) : NULL;
    if (!kept) continue;
    assert_int_equal(neph_image_set_attribute(t.images[1], names[i], "\x1b[31many"), NEPH_OK);
    save(&t, 1);
    assert_refused(f, &t, t.paths[1], names[i]);
    assert_int_equal(neph_image_set_attribute(t.images[1], names[i], kept), NEPH_OK);
    free(kept);
  }
  save(&t, 1);
  assert_merges(f, &t);
  clear_tiles(&t);
}

/* Each value is refused for itself, whatever the other tiles state. */
static void numbers_of_tiles_can_be(void **state) {
  static const struct {
    const char *name;
    double values[4];
  } rows[] = {{"nephos:scale", {NAN, INFINITY, -1.0, 0.0}},
              {"whiteLuminance", {NAN, INFINITY, -1.0, 0.0}},
              {"nephos:meter", {NAN, INFINITY, -1.0, -1.0}},
              {"nephos:meterLuminance", {NAN, INFINITY, -1.0, -1.0}},
              {"nephos:meterX", {NAN, INFINITY, -1.0, 1.5}},
              {"nephos:meterY", {NAN, INFINITY, -1.0, 1.5}},
              {"nephos:sunElevation", {NAN, INFINITY, 1e30, -91.0}},
              {"nephos:moonElevation", {NAN, INFINITY, 1e30, -91.0}},
              {"nephos:sunAzimuth", {NAN, INFINITY, 1e30, -1.0}},
              {"nephos:pixelError", {NAN, INFINITY, -INFINITY, -1.0}},
              {"renderTime", {NAN, INFINITY, -INFINITY, -1.0}},
              {"nephos:predictedBytes", {NAN, INFINITY, -INFINITY, -1.0}}};
  test_fixture *f = *state;
  tiles t;
  make_tiles(f, "exr", &t);
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    const np_image_attribute *stated = np_image_search_attribute(t.images[0], rows[i].name);
    const double kept = stated ? stated->number : 1.0;
    for (size_t k = 0; k < 4; k++) {
      assert_int_equal(np_image_set_real(t.images[0], rows[i].name, rows[i].values[k]), NEPH_OK);
      save(&t, 0);
      assert_refused(f, &t, t.paths[0], rows[i].name);
    }
    assert_int_equal(np_image_set_real(t.images[0], rows[i].name, kept), NEPH_OK);
  }
  save(&t, 0);
  assert_merges(f, &t);
  clear_tiles(&t);
}

static void numbers_of_tiles_agree(void **state) {
  static const char *const names[] = {"nephos:scale", "whiteLuminance",      "nephos:meter", "nephos:meterLuminance",
                                      "expTime",      "nephos:sunElevation", "aperture"};
  test_fixture *f = *state;
  tiles t;
  make_tiles(f, "exr", &t);
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    for (unsigned k = 0; k < TILES; k++) {
      assert_int_equal(np_image_set_real(t.images[k], names[i], 2.0 + (k == 2)), NEPH_OK);
      save(&t, k);
    }
    assert_refused(f, &t, t.paths[2], names[i]);
    assert_int_equal(np_image_set_real(t.images[2], names[i], 2.0), NEPH_OK);
  }
  save(&t, 2);
  assert_int_equal(np_image_set_real(t.images[1], "renderTime", 77.0), NEPH_OK); /* changes the tile alone */
  save(&t, 1);
  assert_merges(f, &t);
  clear_tiles(&t);
}

static void matrices_of_tiles_agree(void **state) {
  static const struct {
    const char *name;
    size_t at;
  } rows[] = {{"worldToCamera", offsetof(np_image_header, world_to_camera)},
              {"worldToNDC", offsetof(np_image_header, world_to_ndc)},
              {"chromaticities", offsetof(np_image_header, chromaticities)}};
  test_fixture *f = *state;
  tiles t;
  make_tiles(f, "exr", &t);
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    float *number = (float *)(void *)((char *)&t.images[1]->header + rows[i].at) + 3;
    const float kept = *number, forged[] = {NAN, INFINITY, kept + 1.0f};
    for (size_t k = 0; k < sizeof forged / sizeof *forged; k++) {
      *number = forged[k];
      save(&t, 1);
      assert_refused(f, &t, t.paths[1], rows[i].name);
    }
    *number = kept;
  }
  save(&t, 1);
  assert_merges(f, &t);
  clear_tiles(&t);
}

/* ---- Files of parts ---- */

static void forge_part(test_fixture *f, const tiles *t, const char *field, size_t at, const void *value, size_t size) {
  test_file part = test_file_read(t->paths[1]);
  uint8_t kept[16];
  memcpy(kept, part.bytes + at, size);
  memcpy(part.bytes + at, value, size);
  part_forge_mend(f->context, part.bytes, part.size);
  test_file_write(t->paths[1], part.bytes, part.size);
  assert_refused(f, t, t->paths[1], field);
  memcpy(part.bytes + at, kept, size);
  part_forge_mend(f->context, part.bytes, part.size);
  test_file_write(t->paths[1], part.bytes, part.size);
  free(part.bytes);
}

/* Place of a field's largest member, or of an attribute's value, in a file. */
static size_t search_field(const char *path, const char *field, const char *attribute) {
  test_file part = test_file_read(path);
  part_field fields[PART_FIELDS_MAX];
  const unsigned count = part_forge_list(part.bytes, part.size, fields);
  size_t at = 0, size = 0;
  for (unsigned i = 0; i < count && !attribute; i++)
    if (!strcmp(fields[i].name, field) && fields[i].size > size) at = fields[i].at, size = fields[i].size;
  const uint8_t *name = attribute ? memmem(part.bytes, part.size, attribute, strlen(attribute)) : NULL;
  if (name) at = (size_t)(name - part.bytes) + strlen(attribute) + sizeof(uint32_t);
  free(part.bytes);
  assert_true(at > 0);
  return at;
}

static void fields_of_parts_agree(void **state) {
  static const double dim = 1e300;
  static const float number = 7.0f;
  static const uint32_t type = NEPH_PIXEL_FLOAT;
  test_fixture *f = *state;
  tiles t;
  make_tiles(f, "npart", &t);
  assert_merges(f, &t);
  forge_part(f, &t, "'dim'", search_field(t.paths[1], "dim", NULL), &dim, sizeof dim);
  forge_part(f, &t, "'pixel type'", search_field(t.paths[1], "pixel type", NULL), &type, sizeof type);
  forge_part(f, &t, "worldToCamera", search_field(t.paths[1], "image: camera", NULL), &number, sizeof number);
  forge_part(f, &t, "nephos:colorSpace", search_field(t.paths[1], NULL, "nephos:colorSpace"), "\x1b", 1);
  forge_part(f, &t, "nephos:wavelengths", search_field(t.paths[1], NULL, "nephos:wavelengths"), "9", 1);
  assert_merges(f, &t);
  clear_tiles(&t);
}

/* ---- Error statements ---- */

static void state_error(neph_image *image, const char *figure, double value, double low, double high) {
  char name[32];
  assert_int_equal(np_image_set_real(image, figure, value), NEPH_OK);
  (void)snprintf(name, sizeof name, "%sMin", figure);
  assert_int_equal(np_image_set_real(image, name, low), NEPH_OK);
  (void)snprintf(name, sizeof name, "%sMax", figure);
  assert_int_equal(np_image_set_real(image, name, high), NEPH_OK);
}

static void bounds_are_in_order(void **state) {
  static const struct {
    const char *figure, *name;
    double value, low, high;
  } rows[] = {{"nephos:bias", "nephos:biasMin", 0.1, 0.2, 0.3},
              {"nephos:error", "nephos:errorMax", 0.3, 0.1, 0.2},
              {"nephos:noise", "nephos:noiseMin", 0.1, 0.3, 0.2}};
  test_fixture *f = *state;
  tiles t;
  make_tiles(f, "exr", &t);
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    state_error(t.images[1], rows[i].figure, rows[i].value, rows[i].low, rows[i].high);
    save(&t, 1);
    assert_refused(f, &t, t.paths[1], rows[i].name);
    state_error(t.images[1], rows[i].figure, 0.2, 0.1, 0.3);
  }
  save(&t, 1);
  assert_merges(f, &t);
  clear_tiles(&t);
}

static double get_number(const neph_image *image, const char *name) {
  const np_image_attribute *a = np_image_search_attribute(image, name);
  return a ? a->number : (double)NAN;
}

/* Mean squares by pixels, of the two tiles that state an error: the third, which is black, has none. One bound that a
 * tile leaves out is none of the whole. */
static void error_of_the_whole_is_the_mean_of_those_that_state_one(void **state) {
  static const double noise[2] = {0.03, 0.05}, bias[2] = {0.04, 0.02};
  test_fixture *f = *state;
  tiles t;
  neph_image *whole = NULL;
  make_tiles(f, "exr", &t);
  double pixels[2];
  for (unsigned i = 0; i < 2; i++) {
    pixels[i] = 9.0 * neph_image_get_height(t.images[i]);
    state_error(t.images[i], "nephos:noise", noise[i], 0.5 * noise[i], 2.0 * noise[i]);
    assert_int_equal(np_image_set_real(t.images[i], "nephos:bias", bias[i]), NEPH_OK);
    assert_int_equal(np_image_set_real(t.images[i], "nephos:error", hypot(noise[i], bias[i])), NEPH_OK);
    save(&t, i);
  }
  assert_int_equal(np_image_set_real(t.images[0], "nephos:biasMax", 0.05), NEPH_OK);
  save(&t, 0);
  assert_true(isnan(get_number(t.images[2], "nephos:noise")));
  assert_true(pixels[0] != pixels[1]);
  assert_int_equal(merge(f, &t, &whole), NEPH_OK);
  const double all = pixels[0] + pixels[1];
  const double noise2 = (pixels[0] * noise[0] * noise[0] + pixels[1] * noise[1] * noise[1]) / all;
  const double bias2 = (pixels[0] * bias[0] * bias[0] + pixels[1] * bias[1] * bias[1]) / all;
  /* Files of pictures hold floats. */
  assert_near_relative(get_number(whole, "nephos:noise"), sqrt(noise2), 1e-6);
  assert_near_relative(get_number(whole, "nephos:noiseMin"), 0.5 * sqrt(noise2), 1e-6);
  assert_near_relative(get_number(whole, "nephos:noiseMax"), 2.0 * sqrt(noise2), 1e-6);
  assert_near_relative(get_number(whole, "nephos:bias"), sqrt(bias2), 1e-6);
  assert_near_relative(get_number(whole, "nephos:error"), sqrt(noise2 + bias2), 1e-6);
  assert_true(isnan(get_number(whole, "nephos:biasMax")));
  assert_true(isnan(get_number(whole, "nephos:errorMax")));
  neph_image_destroy(whole);
  clear_tiles(&t);
}

static int set_up(void **state) { return test_set_up(state, 1, "file"); }

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {TEST(texts_of_tiles_agree),
                                     TEST(numbers_of_tiles_can_be),
                                     TEST(numbers_of_tiles_agree),
                                     TEST(matrices_of_tiles_agree),
                                     TEST(fields_of_parts_agree),
                                     TEST(bounds_are_in_order),
                                     TEST(error_of_the_whole_is_the_mean_of_those_that_state_one)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}

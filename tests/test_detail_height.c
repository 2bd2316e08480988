/* SPDX-License-Identifier: Apache-2.0 */
/* A small picture with the detail of the whole one: both share terrain, clouds, air and light. */
#include <nephos/nephos.h>

#include "test_scenes.h"

/* Voxels, heights and cells of light that follow the size of the picture; light in few directions, coarse tables of the
 * air. */
static const char text[] =
    "camera: {position: [0, -6 km, 900 m], look_at: [0, 0, 1200 m], fov: 50 deg, resolution: [96, 64]}\n"
    "sun: {elevation: 30 deg, azimuth: 140 deg}\n"
    "clouds: [{name: a, bake: {preset: cumulus_mediocris, seed: 3, extent: [2 km, 2 km], voxel: 20 m}}]\n"
    "atmosphere: {tolerance: 0.1}\n"
    "terrain: {ridges: {samples: 129, relief: 400 m}}\n"
    "render: {samples: 2, detail: 0.4, light_detail: 0.8, light_degree: 3, light_residual: 0.03}\n"
    "output: {pixel_type: float}\n";

static int set_up(void **state) { return set_up_scene_verbose(state, 2, text); }

static neph_image *render_samples(fixture *f, neph_renderer *renderer, unsigned shrink, unsigned detail_height,
                                  unsigned sample_count) {
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_image *image;
  assert_int_equal(neph_scene_get_render_desc(f->scene, &desc), NEPH_OK);
  desc.width /= shrink, desc.height /= shrink;
  desc.crop_max[0] = desc.width, desc.crop_max[1] = desc.height;
  desc.detail_height = detail_height;
  if (sample_count) desc.sample_count = sample_count;
  test_log_clear(&f->log);
  if (renderer)
    assert_int_equal(neph_renderer_render(renderer, f->scene, &desc, &image), NEPH_OK);
  else
    assert_int_equal(neph_render_image(f->scene, &desc, &image), NEPH_OK);
  return image;
}

static neph_image *render(fixture *f, neph_renderer *renderer, unsigned shrink, unsigned detail_height) {
  return render_samples(f, renderer, shrink, detail_height, shrink > 1 ? 1 : 0);
}

static void a_small_picture_shares_all_with_the_whole(void **state) {
  fixture *f = *state;
  static const char *const stages[] = {"terrain: reused", "cloud a: reused", "multiple scattering: reused"};
  neph_image_destroy(render(f, f->renderer, 4, 64));
  neph_image *shared = render(f, f->renderer, 1, 64);
  for (size_t i = 0; i < sizeof stages / sizeof *stages; i++)
    if (!strstr(f->log.text, stages[i])) fail_msg("%s: %s", stages[i], f->log.text);
  /* Light on the ground alone has fewer points in the first picture, and light between hills goes with it. */
  unsigned rebuilt = 0;
  for (const char *at = f->log.text; (at = strstr(at, "rebuilt")); at++) rebuilt++;
  if (rebuilt) assert_non_null(strstr(f->log.text, "clouds on ground: rebuilt"));
  if (rebuilt > 1) assert_non_null(strstr(f->log.text, "relief light: rebuilt"));
  assert_true(rebuilt <= 2);
  assert_null(strstr(f->log.text, "rebaked"));
  /* The same bits as those of the whole picture alone. */
  neph_image *alone = render(f, NULL, 1, 0);
  neph_image_difference difference = NEPH_IMAGE_DIFFERENCE_DEFAULT;
  assert_int_equal(neph_image_compare(f->context, shared, alone, &difference), NEPH_OK);
  assert_int_equal(difference.differing_count, 0);
  neph_image_destroy(alone);
  neph_image_destroy(shared);
}

/* Without it the small picture has coarser clouds, and the whole one bakes them anew. */
static void the_picture_chooses_its_own_detail_by_default(void **state) {
  fixture *f = *state;
  neph_image_destroy(render(f, f->renderer, 4, 0));
  neph_image_destroy(render(f, f->renderer, 1, 0));
  assert_null(strstr(f->log.text, "cloud a: reused"));
  assert_null(strstr(f->log.text, "multiple scattering: reused"));
}

static void assert_bits_of_the_picture_alone(fixture *f, const neph_image *image) {
  neph_image *alone = render(f, NULL, 1, 0);
  neph_image_difference difference = NEPH_IMAGE_DIFFERENCE_DEFAULT;
  assert_int_equal(neph_image_compare(f->context, image, alone, &difference), NEPH_OK);
  assert_int_equal(difference.differing_count, 0);
  neph_image_destroy(alone);
}

/* After an edit, the first picture takes light and voxels that are near its own; the next has the bits of its own. */
static void a_first_picture_takes_what_is_near(void **state) {
  fixture *f = *state;
  static const struct {
    const char *key, *value, *taken, *then_made;
  } edits[] = {
      {"sun.elevation", "31 deg", "multiple scattering: reused", "multiple scattering: rebuilt"},
      {"sun.elevation", "29.5 deg", "clouds on ground: reused", "clouds on ground: rebuilt"},
      {"camera.fov", "34 deg", "cloud a: reused", "cloud a: rebuilt"},
      {"camera.fov", "50 deg", "multiple scattering: reused", "multiple scattering: rebuilt"},
      {"terrain.albedo", "0.16", "multiple scattering: reused", "multiple scattering: rebuilt"},
  };
  set(f, "render.detail", "1.2"); /* two voxels in one at 50 degrees, √2 at 34 */
  neph_image_destroy(render(f, f->renderer, 1, 64));
  for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
    set(f, edits[i].key, edits[i].value);
    neph_image_destroy(render(f, f->renderer, 4, 64));
    if (!strstr(f->log.text, edits[i].taken)) fail_msg("%s: %s", edits[i].key, f->log.text);
    neph_image *image = render(f, f->renderer, 1, 64);
    if (!strstr(f->log.text, edits[i].then_made)) fail_msg("%s: %s", edits[i].key, f->log.text);
    assert_bits_of_the_picture_alone(f, image);
    neph_image_destroy(image);
  }
}

/* So does a picture with fewer samples than the scene's. The one behind it takes its samples anew, unless all was its
 * own: then it goes on with them. */
static void a_picture_of_few_samples_takes_what_is_near(void **state) {
  fixture *f = *state;
  static const struct {
    const char *key, *value;
    bool is_near; /* light is that of the edit before */
  } edits[] = {{"sun.elevation", "31 deg", true}, {"camera.position", "[50 m, -6 km, 900 m]", false}};
  set(f, "render.detail", "1.2");
  assert_int_equal(neph_renderer_keep_samples(f->renderer, true), NEPH_OK);
  neph_image_destroy(render(f, f->renderer, 1, 64));
  for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
    set(f, edits[i].key, edits[i].value);
    neph_image_destroy(render_samples(f, f->renderer, 1, 64, 1));
    if (!strstr(f->log.text, "multiple scattering: reused")) fail_msg("%s: %s", edits[i].key, f->log.text);
    neph_image *image = render(f, f->renderer, 1, 64);
    if (edits[i].is_near != !!strstr(f->log.text, "rebuilt")) fail_msg("%s: %s", edits[i].key, f->log.text);
    assert_bits_of_the_picture_alone(f, image);
    neph_image_destroy(image);
  }
}

/* Clouds of a first picture by an approximation are sketches, which no other picture takes; it takes those of others.
 */
static void clouds_of_a_sketch_are_for_first_pictures_alone(void **state) {
  fixture *f = *state;
  set(f, "render.multiple_scattering", "octaves");
  neph_image_destroy(render(f, f->renderer, 4, 64));
  neph_image_destroy(render_samples(f, f->renderer, 1, 64, 1));
  assert_non_null(strstr(f->log.text, "cloud a: rebuilt"));
  neph_image *image = render(f, f->renderer, 1, 64);
  assert_non_null(strstr(f->log.text, "cloud a: reused"));
  assert_bits_of_the_picture_alone(f, image);
  neph_image_destroy(image);
  neph_image_destroy(render(f, f->renderer, 1, 64));
  set(f, "camera.position", "[50 m, -6 km, 900 m]");
  neph_image_destroy(render(f, f->renderer, 4, 64));
  assert_non_null(strstr(f->log.text, "cloud a: reused"));
}

/* Light that has turned by more than a few degrees, and clouds of another shape, are not near. */
static void a_first_picture_makes_what_is_far(void **state) {
  fixture *f = *state;
  neph_image_destroy(render(f, f->renderer, 1, 64));
  set(f, "sun.elevation", "45 deg");
  neph_image_destroy(render(f, f->renderer, 4, 64));
  assert_non_null(strstr(f->log.text, "multiple scattering: rebuilt"));
  set(f, "clouds[0].bake.coverage", "0.5");
  neph_image_destroy(render(f, f->renderer, 4, 64));
  assert_non_null(strstr(f->log.text, "cloud a: rebuilt"));
}

static void heights_stay_under_another_cover(void **state) {
  fixture *f = *state;
  static const char *const albedos[] = {"0.3", "[0.1, 0.2, 0.3]", "0.18"};
  neph_image_destroy(render(f, f->renderer, 1, 64));
  for (size_t i = 0; i < sizeof albedos / sizeof *albedos; i++) {
    set(f, "terrain.albedo", albedos[i]);
    neph_image *image = render(f, f->renderer, 1, 64);
    assert_non_null(strstr(f->log.text, "terrain: reused"));
    assert_bits_of_the_picture_alone(f, image);
    neph_image_destroy(image);
  }
}

static void heights_beyond_a_picture_are_refused(void **state) {
  fixture *f = *state;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_image *image;
  assert_int_equal(neph_scene_get_render_desc(f->scene, &desc), NEPH_OK);
  desc.detail_height = 65537;
  assert_int_equal(neph_render_image(f->scene, &desc, &image), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "detail_height is 65537 pixels, must be at most 65536");
}

#define DETAIL_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      DETAIL_TEST(a_small_picture_shares_all_with_the_whole),
      DETAIL_TEST(the_picture_chooses_its_own_detail_by_default),
      DETAIL_TEST(a_first_picture_takes_what_is_near),
      DETAIL_TEST(a_picture_of_few_samples_takes_what_is_near),
      DETAIL_TEST(clouds_of_a_sketch_are_for_first_pictures_alone),
      DETAIL_TEST(a_first_picture_makes_what_is_far),
      DETAIL_TEST(heights_stay_under_another_cover),
      DETAIL_TEST(heights_beyond_a_picture_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

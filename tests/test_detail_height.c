/* SPDX-License-Identifier: Apache-2.0 */
/* A small picture with the detail of the whole one: both share terrain, clouds, air and light. */
#include <nephos/nephos.h>

#include "test_scenes.h"

/* Voxels, heights and cells of light that follow the size of the picture. */
static const char text[] =
    "camera: {position: [0, -6 km, 900 m], look_at: [0, 0, 1200 m], fov: 50 deg, resolution: [96, 64]}\n"
    "sun: {elevation: 30 deg, azimuth: 140 deg}\n"
    "clouds: [{name: a, bake: {preset: cumulus_mediocris, seed: 3, extent: [3 km, 3 km], voxel: 20 m}}]\n"
    "terrain: {ridges: {samples: 257, relief: 400 m}}\n"
    "render: {samples: 2, detail: 0.4, light_detail: 0.8}\n"
    "output: {pixel_type: float}\n";

static int set_up(void **state) { return set_up_scene_verbose(state, 2, text); }

static neph_image *render(fixture *f, neph_renderer *renderer, unsigned shrink, unsigned detail_height) {
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  neph_image *image;
  assert_int_equal(neph_scene_get_render_desc(f->scene, &desc), NEPH_OK);
  desc.width /= shrink, desc.height /= shrink;
  desc.crop_max[0] = desc.width, desc.crop_max[1] = desc.height;
  desc.detail_height = detail_height;
  if (shrink > 1) desc.sample_count = 1;
  test_log_clear(&f->log);
  if (renderer)
    assert_int_equal(neph_renderer_render(renderer, f->scene, &desc, &image), NEPH_OK);
  else
    assert_int_equal(neph_render_image(f->scene, &desc, &image), NEPH_OK);
  return image;
}

static void a_small_picture_shares_all_with_the_whole(void **state) {
  fixture *f = *state;
  static const char *const stages[] = {"terrain: reused", "cloud a: reused", "multiple scattering: reused"};
  neph_image_destroy(render(f, f->renderer, 4, 64));
  neph_image *shared = render(f, f->renderer, 1, 64);
  for (size_t i = 0; i < sizeof stages / sizeof *stages; i++)
    if (!strstr(f->log.text, stages[i])) fail_msg("%s: %s", stages[i], f->log.text);
  assert_null(strstr(f->log.text, "rebuilt"));
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
      DETAIL_TEST(heights_beyond_a_picture_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

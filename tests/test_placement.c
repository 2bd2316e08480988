/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds in their places, by scale, tilt, rotation, position and pivot: corners of a box where they must be. */
#include <nephos/nephos.h>

#include "plan/placement.h"
#include "scene/scene_private.h"
#include "test_box_files.h"

/* Samples from 8 to 12, 16 and 24 m. */
static const test_box block = {{8, 8, 8}, {13, 17, 25}, 1.0f};

static int set_up(void **state) {
  const int failed = test_set_up(state, 1, "block.vdb");
  const test_fixture *f = *state;
  if (!failed) test_boxes_write(f->context, f->path, "density", &block, 1);
  return failed;
}

static neph_scene *load(const test_fixture *f, const char *keys) {
  char text[1024];
  neph_scene *scene = NULL;
  (void)snprintf(text, sizeof text, "clouds: [{vdb: \"%s\", extinction: 0.01 1/m, %s}]", f->path, keys);
  assert_int_equal(neph_scene_load_text(f->context, text, "s.yaml", &scene), NEPH_OK);
  return scene;
}

/* The world's place of one of the file's; all numbers here are sums and products of small ones. */
static void assert_place_of(const test_fixture *f, const neph_volume_load_desc *desc, const char *keys,
                            const double file[3], const double world[3]) {
  neph_scene *scene = load(f, keys);
  neph_volume *volume;
  np_anchor anchor;
  assert_int_equal(neph_volume_load(f->context, f->path, desc, &volume), NEPH_OK);
  assert_int_equal(np_placement_anchor(&scene->clouds[0], volume, NULL, &anchor), NEPH_OK);
  const np_dvec3 at = np_affine_point(&anchor.file_to_world, np_dvec3_make(file[0], file[1], file[2]));
  print_message("%s: %g, %g, %g\n", keys, at.x, at.y, at.z);
  assert_near(at.x, world[0], 1e-9);
  assert_near(at.y, world[1], 1e-9);
  assert_near(at.z, world[2], 1e-9);
  neph_volume_release(volume);
  neph_scene_destroy(scene);
}

static void assert_place(const test_fixture *f, const char *keys, const double file[3], const double world[3]) {
  assert_place_of(f, NULL, keys, file, world);
}

#define AT(x, y, z)                                                                                                    \
  (const double[3]) { x, y, z }

static void axes_have_scales_of_their_own(void **state) {
  const test_fixture *f = *state;
  assert_place(f, "scale: 2", AT(8, 16, 24), AT(16, 32, 48));
  assert_place(f, "scale: [2, 3, 0.5]", AT(8, 16, 24), AT(16, 48, 12));
  assert_place(f, "scale: [-1, 1, 1]", AT(8, 16, 24), AT(-8, 16, 24));
  assert_place(f, "scale: [2, 3, 0.5], voxel: 10 m", AT(8, 16, 24), AT(160, 480, 120));
  assert_place(f, "scale: [2, 3, 0.5], up: y", AT(8, 16, 24), AT(16, -72, 8)); /* along the world's axes */
}

/* A limit on memory makes voxels twice as long; the key is the size of the file's. */
static void a_cloud_of_halved_voxels_has_its_size(void **state) {
  const test_fixture *f = *state;
  neph_volume_load_desc halved = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  halved.is_halved = true;
  assert_place_of(f, &halved, "voxel: 10 m", AT(8, 16, 24), AT(80, 160, 240));
  assert_place_of(f, &halved, "scale: [2, 3, 0.5], voxel: 10 m", AT(8, 16, 24), AT(160, 480, 120));
  assert_place_of(f, &halved, "scale: 2", AT(8, 16, 24), AT(16, 32, 48));
}

/* Counter-clockwise, seen from the positive end of the axis; first about x, then y, then the vertical. */
static void tilts_come_before_the_rotation(void **state) {
  const test_fixture *f = *state;
  assert_place(f, "tilt: [90 deg, 0 deg]", AT(8, 16, 24), AT(8, -24, 16));
  assert_place(f, "tilt: [0 deg, 90 deg]", AT(8, 16, 24), AT(24, 16, -8));
  assert_place(f, "rotation: 90 deg", AT(8, 16, 24), AT(-16, 8, 24));
  assert_place(f, "tilt: [90 deg, 90 deg], rotation: 90 deg", AT(8, 16, 24), AT(24, 16, -8));
  assert_place(f, "scale: [2, 1, 1], rotation: 90 deg", AT(8, 16, 24), AT(-16, 16, 24));
}

/* The middle of the box is at 10, 12, 16. */
static void a_pivot_stands_at_the_position(void **state) {
  const test_fixture *f = *state;
  assert_place(f, "position: [1, 2, 3]", AT(10, 12, 8), AT(1, 2, 3));
  assert_place(f, "position: [1, 2, 3], pivot: base", AT(10, 12, 8), AT(1, 2, 3));
  assert_place(f, "position: [1, 2, 3], pivot: center", AT(10, 12, 16), AT(1, 2, 3));
  assert_place(f, "position: [1, 2, 3], pivot: origin", AT(0, 0, 0), AT(1, 2, 3));
  assert_place(f, "position: [1, 2, 3], pivot: [8, 16, 24]", AT(8, 16, 24), AT(1, 2, 3));
  assert_place(f, "position: [1, 2, 3], pivot: center, tilt: [30 deg, 40 deg], scale: [1, -2, 3]", AT(10, 12, 16),
               AT(1, 2, 3));
  assert_place(f, "position: [1, 2, 3], pivot: origin, scale: 2", AT(8, 0, 0), AT(17, 2, 3));
}

static void only_pivots_of_the_box_go_by_a_reference(void **state) {
  const test_fixture *f = *state;
  static const char *const keys[] = {"position: [1, 2, 3], pivot: origin", "position: [1, 2, 3], pivot: [1, 2, 3]",
                                     "position: [1, 2, 3], pivot: base", "position: [1, 2, 3], pivot: center"};
  for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
    neph_scene *scene = load(f, keys[i]);
    assert_int_equal(np_placement_needs_reference(&scene->clouds[0]), i >= 2);
    neph_scene_destroy(scene);
  }
}

/* Mirrored, tilted and stretched, a cloud is as opaque along a ray as its box is long there, in both integrators. */
static void turned_clouds_are_rendered(void **state) {
  const test_fixture *f = *state;
  static const char *const keys[] = {"scale: [-1, 2, 1]", "tilt: [90 deg, 0 deg], scale: [1, 1, 2]"};
  static const double depth_m[] = {2.0 * 9.0, 2.0 * 17.0}; /* trilinear edges count for half a voxel at each end */
  for (size_t i = 0; i < 4; i++) {
    char text[2048];
    (void)snprintf(text, sizeof text,
                   "camera: {position: [0, -200, 0], look_at: [0, 0, 0], fov: 1 deg, resolution: [8, 8]}\n"
                   "atmosphere: none\n"
                   "environment: {radiance: 1, planet: none}\n"
                   "clouds: [{vdb: \"%s\", extinction: 0.05, albedo: 0, position: [0, 0, 0], pivot: center, %s}]\n"
                   "render: {samples: 64, integrator: %s, tolerance: 0.005}\n"
                   "output: {aovs: [transmittance]}\n",
                   f->path, keys[i / 2], i % 2 ? "path" : "march");
    neph_scene *scene;
    neph_image *image;
    assert_int_equal(neph_scene_load_text(f->context, text, "s.yaml", &scene), NEPH_OK);
    assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
    const float *transmittance = neph_image_get_channel(image, "transmittance");
    double mean = 0.0;
    for (int p = 0; p < 64; p++) mean += (double)transmittance[p] / 64.0;
    assert_near(mean, exp(-0.05 * depth_m[i / 2]),
                i % 2 ? 0.03 : 0.002); /* 4096 binary samples; the march's tolerance */
    neph_image_destroy(image);
    neph_scene_destroy(scene);
  }
}

static void a_flat_cloud_is_refused(void **state) {
  test_fixture *f = *state;
  neph_scene *scene;
  test_log_clear(&f->log);
  assert_int_equal(neph_scene_load_text(f->context, "clouds: [{bake: {}, scale: [1, 0, 1]}]", "s", &scene),
                   NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "clouds[0].scale is [1, 0, 1], must be at least 1e-06");
}

#define PLACEMENT_TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      PLACEMENT_TEST(axes_have_scales_of_their_own),
      PLACEMENT_TEST(a_cloud_of_halved_voxels_has_its_size),
      PLACEMENT_TEST(tilts_come_before_the_rotation),
      PLACEMENT_TEST(a_pivot_stands_at_the_position),
      PLACEMENT_TEST(only_pivots_of_the_box_go_by_a_reference),
      PLACEMENT_TEST(turned_clouds_are_rendered),
      PLACEMENT_TEST(a_flat_cloud_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

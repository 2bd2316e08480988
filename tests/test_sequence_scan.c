/* SPDX-License-Identifier: Apache-2.0 */
/* All files of a sequence: the union of their boxes, their densest column, kept on disk until a file changes. */
#include <nephos/nephos.h>

#include "test_box_files.h"

#include "core/alloc.h"
#include "core/frame_name.h"
#include "plan/sequence_scan.h"
#include "scene/cloud_file.h"

static int set_up(void **state) { return test_set_up(state, 2, "jet[1].####.vdb"); }

static void write_file(const test_fixture *f, double number, const test_box *box) {
  char *path = np_frame_name_make(f->context, f->path, number);
  static const test_box nothing;
  test_boxes_write(f->context, path, "density", box ? box : &nothing, box ? 1 : 0);
  np_alloc_free(f->context, path);
}

/* A block that is there from the first file on, one above it that comes, and nothing at the end. */
static void write_files(const test_fixture *f) {
  static const test_box low = {{8, 8, 8}, {16, 16, 16}, 1.0f}, high = {{24, 8, 8}, {40, 16, 48}, 0.5f};
  write_file(f, 1, &low);
  write_file(f, 2, &high);
  write_file(f, 3, NULL);
  char *other = np_alloc_printf(f->context, "%s/jet[1].-old.vdb", f->folder);
  test_boxes_write(f->context, other, "density", &(test_box){{0, 0, 0}, {64, 64, 64}, 9.0f}, 1);
  np_alloc_free(f->context, other);
}

static neph_scene *load(neph_context *context, const char *path, const char *keys) {
  char text[2048];
  neph_scene *scene = NULL;
  (void)snprintf(
      text, sizeof text,
      "camera: {position: [0 m, -300 m, 20 m], look_at: [0 m, 0 m, 20 m], fov: 40 deg, resolution: [16, 9]}\n"
      "atmosphere: none\nrender: {samples: 1, multiple_scattering: none}\n"
      "clouds: [{name: jet, vdb: \"%s\", reference_frame: all, %s}]\n",
      path, keys);
  assert_int_equal(neph_scene_load_text(context, text, "jet.yaml", &scene), NEPH_OK);
  return scene;
}

static np_sequence_scan scan(neph_context *context, const neph_scene *scene) {
  const np_scene_cloud *cloud = &scene->clouds[0];
  const neph_volume_load_desc desc = np_cloud_file_describe_load(cloud);
  char key[33];
  np_sequence_scan found;
  np_monitor monitor;
  np_monitor_start(&monitor, context, NULL, NULL);
  assert_int_equal(np_sequence_scan_compute_key(cloud, context, key), NEPH_OK);
  assert_int_equal(np_sequence_scan_get(context, cloud, &desc, key, &monitor, &found), NEPH_OK);
  return found;
}

/* Boxes are of samples, the outermost included: 8 to 15 and 24 to 39. The field falls to 0 over a voxel at either end,
 * so that columns are as long as there are samples: 8 of 1 and 40 of 0.5. A neighbour of another name does not count.
 */
static void the_union_and_the_densest_are_found(void **state) {
  test_fixture *f = *state;
  write_files(f);
  neph_scene *scene = load(f->context, f->path, "position: [0, 0, 0], optical_depth: 4");
  const np_sequence_scan found = scan(f->context, scene);
  assert_int_equal(found.file_count, 3);
  assert_int_equal(found.filled_count, 2);
  assert_near(found.low.x, 8.0, 0.0);
  assert_near(found.high.x, 39.0, 0.0);
  assert_near(found.low.z, 8.0, 0.0);
  assert_near(found.high.z, 47.0, 0.0);
  assert_near(found.densest, 2.0, 0.0);
  assert_near_relative(found.column, 20.0, 1e-3); /* halves */
  neph_scene_destroy(scene);
}

/* The middle of the union's bottom stands at the position, in each frame. */
static void the_union_stands_at_the_position(void **state) {
  test_fixture *f = *state;
  write_files(f);
  neph_scene *scene = load(f->context, f->path, "position: [100 m, 0, 50 m], voxel: 2 m, optical_depth: 4");
  const np_sequence_scan found = scan(f->context, scene);
  np_anchor anchor;
  np_sequence_scan_anchor(&found, &scene->clouds[0], &anchor);
  const np_dvec3 at = np_affine_point(&anchor.file_to_world, np_dvec3_make(23.5, 11.5, 8));
  assert_near(at.x, 100.0, 1e-9);
  assert_near(at.y, 0.0, 1e-9);
  assert_near(at.z, 50.0, 1e-9);
  assert_near_relative((double)anchor.extinction_per_value, 4.0 / 40.0, 1e-3);
  neph_scene_destroy(scene);
}

static bool has_read_all(test_fixture *f) {
  const bool has = strstr(f->log.text, "reads all 3 files of its sequence");
  test_log_clear(&f->log);
  return has;
}

static neph_context *make_cached(test_fixture *f, const char *folder) {
  neph_context *context;
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.thread_count = 1;
  desc.cache_dir = folder;
  desc.log = test_log_receive;
  desc.log_user = &f->log;
  assert_int_equal(neph_context_create(&desc, &context), NEPH_OK);
  return context;
}

/* A second process would find it, and so would a task of a farm; a file that has changed is read again, with all. */
static void a_scan_is_kept_on_disk(void **state) {
  test_fixture *f = *state;
  char folder[1200];
  (void)snprintf(folder, sizeof folder, "%s/cache", f->folder);
  write_files(f);
  for (int i = 0; i < 4; i++) {
    neph_context *context = make_cached(f, folder);
    neph_scene *scene = load(context, f->path, "position: [0, 0, 0], optical_depth: 4");
    const np_sequence_scan found = scan(context, scene);
    assert_int_equal(has_read_all(f), i == 0 || i == 2);
    assert_near(found.high.x, i < 2 ? 39.0 : 55.0, 0.0);
    neph_scene_destroy(scene);
    neph_context_destroy(context);
    if (i == 1) write_file(f, 3, &(test_box){{48, 8, 8}, {56, 16, 16}, 1.0f});
  }
}

/* Renders of one frame and of several place it alike, and the plan says by what. */
static void frames_alone_are_those_of_the_sequence(void **state) {
  test_fixture *f = *state;
  write_files(f);
  neph_image *images[2];
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  char *text;
  for (int i = 0; i < 2; i++) {
    neph_scene *scene = load(f->context, f->path, "position: [0, 0, 0], optical_depth: 4");
    assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
    for (desc.frame = i ? 2 : 1; desc.frame <= 2; desc.frame++) {
      assert_int_equal(neph_render_image(scene, &desc, &images[i]), NEPH_OK);
      if (desc.frame == 1) neph_image_destroy(images[i]);
    }
    desc.frame = 2;
    assert_int_equal(neph_render_explain(scene, &desc, NEPH_TEXT_PLAIN, &text), NEPH_OK);
    assert_non_null(strstr(text, "reference frames     jet all files\n"));
    neph_text_destroy(f->context, text);
    neph_scene_destroy(scene);
  }
  for (unsigned c = 0; c < neph_image_get_channel_count(images[0]); c++) {
    const char *name = neph_image_get_channel_name(images[0], c);
    assert_memory_equal(neph_image_get_channel(images[0], name), neph_image_get_channel(images[1], name),
                        16 * 9 * sizeof(float));
  }
  for (int i = 0; i < 2; i++) neph_image_destroy(images[i]);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(the_union_and_the_densest_are_found, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(the_union_stands_at_the_position, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(a_scan_is_kept_on_disk, set_up, test_tear_down),
      cmocka_unit_test_setup_teardown(frames_alone_are_those_of_the_sequence, set_up, test_tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

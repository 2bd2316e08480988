/* SPDX-License-Identifier: Apache-2.0 */
/* Structs that the library fills, for callers that were built against an older, smaller version of them. */
#include "test_support.h"

#include <stdlib.h>

#include <nephos/nephos.h>

typedef struct objects {
  neph_context *context;
  neph_scene *scene;
  neph_volume *volume;
  neph_image *image;
} objects;

static neph_result fill_cloud_preset(const objects *o, void *out) {
  return neph_cloud_get_preset(o->context, "stratus", out);
}

static neph_result fill_atmosphere_preset(const objects *o, void *out) {
  return neph_atmosphere_get_preset(o->context, "mars", out, NULL);
}

static neph_result fill_ephemeris(const objects *o, void *out) {
  return neph_ephemeris_compute(o->context, "2026-06-21T16:00Z", 0.8, -1.2, out);
}

static neph_result fill_render_desc(const objects *o, void *out) { return neph_scene_get_render_desc(o->scene, out); }

static neph_result fill_memory(const objects *o, void *out) { return neph_render_estimate_memory(o->scene, NULL, out); }

static neph_result fill_effort(const objects *o, void *out) { return neph_scene_choose_effort(o->scene, NULL, out); }

static neph_result fill_machine(const objects *o, void *out) {
  char *folder = test_folder_create(), *path = test_path(folder, "machine.json");
  const neph_machine machine = NEPH_MACHINE_DEFAULT;
  neph_result result = neph_machine_save(o->context, &machine, path);
  if (!result) result = neph_machine_load(o->context, path, out);
  free(path);
  test_folder_destroy(folder);
  return result;
}

static neph_result fill_output(const objects *o, void *out) { return neph_scene_get_output(o->scene, out); }

static neph_result fill_volume_info(const objects *o, void *out) { return neph_volume_get_info(o->volume, out); }

static neph_result fill_difference(const objects *o, void *out) {
  return neph_image_compare(o->context, o->image, o->image, out);
}

static neph_result fill_image_error(const objects *o, void *out) { return neph_image_get_error(o->image, out); }

static neph_result load_nothing(void *user, neph_scene **out_scene) { return neph_scene_create(user, out_scene); }

static neph_result fill_report_row(const objects *o, void *out) {
  neph_report_desc desc = NEPH_REPORT_DESC_DEFAULT;
  neph_report *report;
  desc.load = load_nothing;
  desc.load_user = o->context;
  desc.is_quick = true;
  assert_int_equal(neph_report_create(o->context, &desc, &report), NEPH_OK);
  neph_result result = neph_report_get_row(report, 0, out);
  neph_report_destroy(report);
  return result;
}

static neph_result fill_bake_error(const objects *o, void *out) {
  char *folder = test_folder_create(), *path = test_path(folder, "cloud.vdb");
  neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  cloud.extent_m[0] = cloud.extent_m[1] = 500;
  cloud.voxel_m = 100;
  desc.error = out;
  neph_result result = neph_cloud_bake_file(o->context, &cloud, &desc, "density", path);
  free(path);
  test_folder_destroy(folder);
  return result;
}

static const struct {
  const char *name;
  size_t size;
  neph_result (*fill)(const objects *o, void *out);
} structs[] = {
    {"neph_cloud_desc", sizeof(neph_cloud_desc), fill_cloud_preset},
    {"neph_atmosphere_desc", sizeof(neph_atmosphere_desc), fill_atmosphere_preset},
    {"neph_ephemeris", sizeof(neph_ephemeris), fill_ephemeris},
    {"neph_render_desc", sizeof(neph_render_desc), fill_render_desc},
    {"neph_effort", sizeof(neph_effort), fill_effort},
    {"neph_machine", sizeof(neph_machine), fill_machine},
    {"neph_memory_estimate", sizeof(neph_memory_estimate), fill_memory},
    {"neph_output", sizeof(neph_output), fill_output},
    {"neph_volume_info", sizeof(neph_volume_info), fill_volume_info},
    {"neph_image_difference", sizeof(neph_image_difference), fill_difference},
    {"neph_image_error", sizeof(neph_image_error), fill_image_error},
    {"neph_report_row", sizeof(neph_report_row), fill_report_row},
    {"neph_bake_error", sizeof(neph_bake_error), fill_bake_error},
};

enum { STRUCT_COUNT = sizeof structs / sizeof *structs, ROOM = 1024, GUARD = 0xa5 };

static objects make_objects(test_log *log) {
  static const char *const channels[] = {"R", "G", "B"};
  static const float values[8] = {1, 1, 1, 1, 1, 1, 1, 1};
  objects o = {.context = test_context_create(2, log)};
  neph_volume_dense_desc dense = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  for (int a = 0; a < 3; a++) dense.size[a] = 2;
  dense.values = values;
  assert_int_equal(neph_scene_create(o.context, &o.scene), NEPH_OK);
  assert_int_equal(neph_volume_create_dense(o.context, &dense, &o.volume), NEPH_OK);
  assert_int_equal(neph_image_create(o.context, 16, 16, 3, channels, &o.image), NEPH_OK);
  return o;
}

static void destroy_objects(objects *o) {
  neph_image_destroy(o->image);
  neph_volume_release(o->volume);
  neph_scene_destroy(o->scene);
  neph_context_destroy(o->context);
}

typedef union block {
  size_t struct_size;
  unsigned char bytes[ROOM];
} block;

static block make_block(size_t struct_size) {
  block b;
  memset(b.bytes, GUARD, sizeof b.bytes);
  b.struct_size = struct_size;
  return b;
}

static void nothing_is_written_behind_a_struct(void **state) {
  (void)state;
  objects o = make_objects(NULL);
  for (int i = 0; i < STRUCT_COUNT; i++) {
    const size_t sizes[] = {sizeof(size_t), 2 * sizeof(size_t), structs[i].size - sizeof(size_t), structs[i].size};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
      block b = make_block(sizes[s]);
      print_message("%s of %zu bytes\n", structs[i].name, sizes[s]);
      assert_int_equal(structs[i].fill(&o, &b), NEPH_OK);
      assert_int_equal(b.struct_size, sizes[s]);
      for (size_t byte = sizes[s]; byte < ROOM; byte++) assert_int_equal(b.bytes[byte], GUARD);
    }
  }
  destroy_objects(&o);
}

static void impossible_sizes_are_refused(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  objects o = make_objects(&log);
  for (int i = 0; i < STRUCT_COUNT; i++) {
    const size_t sizes[] = {0, sizeof(size_t) - 1, structs[i].size + 1, SIZE_MAX};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
      block b = make_block(sizes[s]);
      assert_int_equal(structs[i].fill(&o, &b), NEPH_ERROR_INVALID_ARGUMENT);
      assert_one_error(&log, structs[i].name, "struct_size is", "default initializer");
      for (size_t byte = sizeof(size_t); byte < ROOM; byte++) assert_int_equal(b.bytes[byte], GUARD);
    }
  }
  destroy_objects(&o);
}

/* Fields that an older caller knows have the values that a newer one gets. */
static void known_fields_are_filled(void **state) {
  (void)state;
  objects o = make_objects(NULL);
  neph_ephemeris whole = NEPH_EPHEMERIS_DEFAULT, older = {.struct_size = offsetof(neph_ephemeris, moon_distance_m)};
  assert_int_equal(fill_ephemeris(&o, &whole), NEPH_OK);
  assert_int_equal(fill_ephemeris(&o, &older), NEPH_OK);
  assert_true(whole.moon_distance_m > 3.5e8);
  assert_true(older.moon_distance_m == 0);
  assert_memory_equal(older.sun_direction, whole.sun_direction, sizeof whole.sun_direction);
  assert_memory_equal(older.moon_direction, whole.moon_direction, sizeof whole.moon_direction);
  destroy_objects(&o);
}

/* The description within a description is as large as its room. */
static void preview_of_an_older_output_is_its_own_size(void **state) {
  (void)state;
  objects o = make_objects(NULL);
  const size_t known = offsetof(neph_preview_desc, white);
  neph_output whole = NEPH_OUTPUT_DEFAULT, older = NEPH_OUTPUT_DEFAULT;
  older.struct_size = offsetof(neph_output, preview_desc) + known;
  assert_int_equal(neph_scene_get_output(o.scene, &whole), NEPH_OK);
  assert_int_equal(neph_scene_get_output(o.scene, &older), NEPH_OK);
  assert_int_equal(whole.preview_desc.struct_size, sizeof(neph_preview_desc));
  assert_int_equal(older.preview_desc.struct_size, known);
  destroy_objects(&o);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(nothing_is_written_behind_a_struct),
      cmocka_unit_test(impossible_sizes_are_refused),
      cmocka_unit_test(known_fields_are_filled),
      cmocka_unit_test(preview_of_an_older_output_is_its_own_size),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

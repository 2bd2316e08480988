/* SPDX-License-Identifier: Apache-2.0 */
/* Every public function with NULL for its objects, and with an object and NULL for the rest. The hygiene test `symbols`
 * holds this file to the list of what the library exports. */
#include <nephos/nephos.h>

#include "test_support.h"

/* A call, and whether it returned the expected result. */
typedef struct row {
  const char *function;
  bool is_right;
} row;

#define FAILS(function, ...)                                                                                           \
  { #function, function(__VA_ARGS__) == NEPH_ERROR_INVALID_ARGUMENT }
#define GIVES(function, ...)                                                                                           \
  { #function, !function(__VA_ARGS__) }
#define DOES(function, ...)                                                                                            \
  { #function, (function(__VA_ARGS__), true) }

typedef struct objects {
  test_log log;
  neph_context *context;
  neph_image *image;
  neph_scene *scene;
  neph_atmosphere *atmosphere;
  neph_renderer *renderer;
} objects;

static void check_rows(const row *rows, size_t count, const objects *o) {
  size_t named = 0;
  for (size_t i = 0; i < count; i++) {
    if (!rows[i].is_right) fail_msg("%s returned something else", rows[i].function);
    for (const char *at = o ? o->log.text : ""; (at = strstr(at, rows[i].function)); at++)
      if (at[strlen(rows[i].function)] == ':') named++;
  }
  if (!o) return;
  assert_int_equal(o->log.counts[NEPH_LOG_ERROR], count); /* one message each, */
  assert_int_equal(named, count);                         /* which names the function */
}

/* ---- The calls ---- */

static void call_a_core_without_objects(void) {
  const row rows[] = {FAILS(neph_context_create, NULL, NULL),
                      DOES(neph_context_destroy, NULL),
                      GIVES(neph_context_get_thread_count, NULL),
                      GIVES(neph_context_get_isa, NULL),
                      FAILS(neph_context_set_names, NULL, NULL),
                      GIVES(neph_feature_is_present, NULL, (neph_feature)0),
                      FAILS(neph_target_check, NULL, NULL),
                      FAILS(neph_text_save, NULL, NULL, NULL),
                      DOES(neph_text_destroy, NULL, NULL),
                      DOES(neph_text_clean, NULL),
                      FAILS(neph_files_create, NULL, NULL),
                      DOES(neph_files_destroy, NULL),
                      FAILS(neph_files_add, NULL, NEPH_FILE_READ, NULL, NULL),
                      FAILS(neph_files_add_scene, NULL, NULL),
                      FAILS(neph_files_add_bake, NULL, NEPH_FILE_READ, NULL, NULL, 0, NULL),
                      FAILS(neph_files_add_light, NULL, NULL),
                      FAILS(neph_files_check, NULL),
                      FAILS(neph_ephemeris_compute, NULL, NULL, 0, 0, NULL),
                      FAILS(neph_machine_calibrate, NULL, NULL, NULL, NULL),
                      FAILS(neph_machine_save, NULL, NULL, NULL),
                      FAILS(neph_machine_load, NULL, NULL, NULL),
                      FAILS(neph_noise_texture_create, NULL, (neph_noise_texture_kind)0, 0, NULL),
                      DOES(neph_noise_texture_destroy, NULL),
                      GIVES(neph_noise_texture_get_size, NULL),
                      GIVES(neph_noise_texture_get_values, NULL),
                      GIVES(neph_noise_texture_sample, NULL, 0, 0, 0),
                      FAILS(neph_render_compute_hash, NULL, NULL, NULL),
                      FAILS(neph_render_is_done, NULL, NULL, NULL, NULL),
                      DOES(neph_checkpoint_clear_light, NULL),
                      FAILS(neph_parts_merge, NULL, NULL, 0, NULL, NULL),
                      FAILS(neph_probe_slab, NULL, NULL, NULL, NULL),
                      FAILS(neph_probe_sky, NULL, NULL, NULL, NULL),
                      FAILS(neph_probe_field, NULL, NULL, NULL),
                      FAILS(neph_probe_i3rc, NULL, NULL, NULL, NULL),
                      FAILS(neph_report_create, NULL, NULL, NULL),
                      DOES(neph_report_destroy, NULL),
                      FAILS(neph_report_run, NULL),
                      GIVES(neph_report_get_row_count, NULL),
                      FAILS(neph_report_get_row, NULL, 0, NULL),
                      FAILS(neph_report_describe, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_report_save, NULL, NULL)};
  check_rows(rows, sizeof rows / sizeof *rows, NULL);
}

static void call_an_image_without_objects(void) {
  const row rows[] = {FAILS(neph_image_create, NULL, 0, 0, 0, NULL, NULL),
                      DOES(neph_image_destroy, NULL),
                      GIVES(neph_image_get_width, NULL),
                      GIVES(neph_image_get_height, NULL),
                      GIVES(neph_image_get_channel_count, NULL),
                      GIVES(neph_image_get_channel_name, NULL, 0),
                      GIVES(neph_image_get_channel, NULL, NULL),
                      GIVES(neph_image_get_values, NULL, NULL),
                      GIVES(neph_image_get_attribute, NULL, NULL),
                      FAILS(neph_image_set_attribute, NULL, NULL, NULL),
                      FAILS(neph_image_save_exr, NULL, NULL, (neph_pixel_type)0),
                      GIVES(neph_image_has_deep, NULL),
                      FAILS(neph_image_save_deep_exr, NULL, NULL, (neph_pixel_type)0),
                      FAILS(neph_image_load_exr, NULL, NULL, NULL),
                      FAILS(neph_image_load_png, NULL, NULL, NULL),
                      FAILS(neph_image_compute_exposure, NULL, NULL, NULL),
                      FAILS(neph_image_develop, NULL, NULL, 0, 0, 0, 0, NULL, 0),
                      FAILS(neph_preview_check, NULL, NULL),
                      FAILS(neph_image_save_png, NULL, NULL, NULL),
                      FAILS(neph_image_describe_file, NULL, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_image_get_error, NULL, NULL),
                      FAILS(neph_image_compare, NULL, NULL, NULL, NULL),
                      FAILS(neph_image_compare_seeds, NULL, NULL, NULL, NULL, NULL),
                      FAILS(neph_image_create_difference, NULL, NULL, NULL, NULL)};
  check_rows(rows, sizeof rows / sizeof *rows, NULL);
}

static void call_a_world_without_objects(void) {
  const row rows[] = {FAILS(neph_atmosphere_get_preset, NULL, NULL, NULL, NULL),
                      FAILS(neph_atmosphere_create, NULL, NULL, NULL),
                      GIVES(neph_atmosphere_retain, NULL),
                      DOES(neph_atmosphere_release, NULL),
                      FAILS(neph_sky_create, NULL, NULL, NULL),
                      DOES(neph_sky_destroy, NULL),
                      DOES(neph_sky_get_radiance, NULL, NULL, NULL),
                      DOES(neph_sky_get_aerial_perspective, NULL, NULL, 0, NULL, NULL),
                      DOES(neph_sky_get_irradiance, NULL, NULL, NULL),
                      DOES(neph_atmosphere_get_transmittance, NULL, NULL, NULL, NULL),
                      FAILS(neph_terrain_load, NULL, NULL, NULL, NULL),
                      FAILS(neph_terrain_create_ridges, NULL, NULL, NULL, NULL),
                      FAILS(neph_terrain_load_mesh, NULL, NULL, NULL),
                      GIVES(neph_terrain_retain, NULL),
                      DOES(neph_terrain_release, NULL),
                      GIVES(neph_terrain_get_elevation_m, NULL, 0, 0),
                      FAILS(neph_terrain_describe_file, NULL, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_volume_load, NULL, NULL, NULL, NULL),
                      FAILS(neph_volume_create_dense, NULL, NULL, NULL),
                      FAILS(neph_volume_load_memory, NULL, NULL, 0, NULL, NULL),
                      FAILS(neph_volume_create_sparse, NULL, NULL, NULL),
                      GIVES(neph_volume_retain, NULL),
                      DOES(neph_volume_release, NULL),
                      FAILS(neph_volume_get_info, NULL, NULL),
                      DOES(neph_volume_sample, NULL, 0, NULL, NULL),
                      FAILS(neph_volume_describe_file, NULL, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_cloud_get_preset, NULL, NULL, NULL),
                      FAILS(neph_cloud_eval, NULL, NULL, 0, 0, NULL, NULL),
                      FAILS(neph_cloud_bake, NULL, NULL, NULL, NULL),
                      FAILS(neph_cloud_bake_file, NULL, NULL, NULL, NULL, NULL),
                      FAILS(neph_cloud_save_map, NULL, NULL, NULL, NULL),
                      FAILS(neph_cloud_verify_file, NULL, NULL, NULL, NULL, NULL)};
  check_rows(rows, sizeof rows / sizeof *rows, NULL);
}

static void call_a_scene_without_objects(void) {
  const row rows[] = {FAILS(neph_scene_create, NULL, NULL),
                      FAILS(neph_scene_load, NULL, NULL, NULL),
                      FAILS(neph_scene_load_text, NULL, NULL, NULL, NULL),
                      FAILS(neph_scene_open, NULL, NULL, NULL),
                      DOES(neph_scene_destroy, NULL),
                      FAILS(neph_scene_clone, NULL, NULL),
                      FAILS(neph_scene_set, NULL, NULL, NULL),
                      FAILS(neph_scene_unset, NULL, NULL),
                      FAILS(neph_scene_insert, NULL, NULL, NULL),
                      FAILS(neph_scene_set_keys, NULL, NULL, NULL, 0),
                      FAILS(neph_scene_get_text, NULL, NULL),
                      FAILS(neph_scene_save, NULL, NULL),
                      FAILS(neph_scene_describe_edits, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_scene_set_frame, NULL, 0),
                      GIVES(neph_scene_is_animated, NULL),
                      FAILS(neph_scene_check, NULL),
                      FAILS(neph_scene_check_files, NULL),
                      FAILS(neph_schema_describe, NULL, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_scene_describe, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_scene_get_output, NULL, NULL),
                      GIVES(neph_scene_is_stereo, NULL),
                      GIVES(neph_scene_get_cloud_count, NULL),
                      GIVES(neph_scene_get_cloud_name, NULL, 0),
                      GIVES(neph_scene_is_cloud_baked, NULL, 0),
                      GIVES(neph_scene_get_cloud_map, NULL, 0),
                      GIVES(neph_scene_get_cloud_file, NULL, 0),
                      GIVES(neph_frame_is_numbered, NULL),
                      FAILS(neph_frame_get_path, NULL, NULL, 0, NULL),
                      FAILS(neph_check_create, NULL, NULL),
                      DOES(neph_check_destroy, NULL),
                      DOES(neph_check_set_progress, NULL, NULL, NULL),
                      FAILS(neph_check_set_file, NULL, NULL),
                      FAILS(neph_check_file, NULL, NULL),
                      GIVES(neph_check_is_file, NULL),
                      FAILS(neph_check_scene, NULL, NULL, 0),
                      GIVES(neph_check_count, NULL, (neph_severity)0),
                      GIVES(neph_check_get_finding_count, NULL),
                      FAILS(neph_check_get_finding, NULL, 0, NULL),
                      FAILS(neph_check_describe, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_check_mend_file, NULL, NULL, NULL, NULL),
                      FAILS(neph_scene_set_camera, NULL, NULL),
                      FAILS(neph_scene_set_sun, NULL, NULL),
                      FAILS(neph_scene_add_volume, NULL, NULL, NULL, NULL),
                      FAILS(neph_scene_set_placement, NULL, 0, NULL),
                      FAILS(neph_scene_set_terrain, NULL, NULL),
                      FAILS(neph_scene_set_water, NULL, NULL),
                      FAILS(neph_scene_set_atmosphere, NULL, NULL)};
  check_rows(rows, sizeof rows / sizeof *rows, NULL);
}

static void call_a_render_without_objects(void) {
  const row rows[] = {FAILS(neph_scene_get_render_desc, NULL, NULL),
                      DOES(neph_scene_warn_of_tasks, NULL),
                      FAILS(neph_scene_choose_effort, NULL, NULL, NULL),
                      FAILS(neph_render_image, NULL, NULL, NULL),
                      FAILS(neph_render_explain, NULL, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_render_estimate_memory, NULL, NULL, NULL),
                      FAILS(neph_render_estimate_time, NULL, NULL, NULL, NULL),
                      FAILS(neph_render_sky, NULL, NULL, NULL),
                      FAILS(neph_scene_save_usd, NULL, NULL, NULL, NULL),
                      FAILS(neph_render_sky_table, NULL, (neph_sky_table)0, NULL),
                      FAILS(neph_render_sky_verify, NULL, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_scene_bake_file, NULL, 0, 0, NULL, NULL),
                      FAILS(neph_scene_save_map, NULL, 0, 0, NULL, NULL),
                      FAILS(neph_scene_export_cloud, NULL, 0, 0, NULL, NULL, NULL),
                      FAILS(neph_scene_save_volumes_usd, NULL, NULL, 0, NULL),
                      FAILS(neph_scene_export_textures, NULL, 0, NULL, NULL),
                      FAILS(neph_renderer_create, NULL, NULL),
                      DOES(neph_renderer_destroy, NULL),
                      FAILS(neph_renderer_render, NULL, NULL, NULL, NULL),
                      FAILS(neph_renderer_keep_samples, NULL, false),
                      FAILS(neph_renderer_set_focus, NULL, 0.5, 0.5),
                      FAILS(neph_renderer_explain, NULL, NULL, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_renderer_choose_effort, NULL, NULL, NULL, NULL),
                      DOES(neph_renderer_cancel, NULL)};
  check_rows(rows, sizeof rows / sizeof *rows, NULL);
}

static void call_with_a_context_alone(const objects *o) {
  const row rows[] = {FAILS(neph_target_check, o->context, NULL),
                      FAILS(neph_text_save, o->context, NULL, NULL),
                      FAILS(neph_atmosphere_get_preset, o->context, NULL, NULL, NULL),
                      FAILS(neph_atmosphere_create, o->context, NULL, NULL),
                      FAILS(neph_image_create, o->context, 0, 0, 0, NULL, NULL),
                      FAILS(neph_image_load_exr, o->context, NULL, NULL),
                      FAILS(neph_image_load_png, o->context, NULL, NULL),
                      FAILS(neph_image_describe_file, o->context, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_image_compare, o->context, NULL, NULL, NULL),
                      FAILS(neph_image_compare_seeds, o->context, NULL, NULL, NULL, NULL),
                      FAILS(neph_image_create_difference, o->context, NULL, NULL, NULL),
                      FAILS(neph_scene_create, o->context, NULL),
                      FAILS(neph_scene_load, o->context, NULL, NULL),
                      FAILS(neph_scene_load_text, o->context, NULL, NULL, NULL),
                      FAILS(neph_scene_open, o->context, NULL, NULL),
                      FAILS(neph_schema_describe, o->context, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_frame_get_path, o->context, NULL, 0, NULL),
                      FAILS(neph_check_create, o->context, NULL),
                      FAILS(neph_check_mend_file, o->context, NULL, NULL, NULL),
                      FAILS(neph_terrain_load, o->context, NULL, NULL, NULL),
                      FAILS(neph_terrain_create_ridges, o->context, NULL, NULL, NULL)};
  check_rows(rows, sizeof rows / sizeof *rows, o);
}

static void call_more_with_a_context_alone(const objects *o) {
  const row rows[] = {FAILS(neph_terrain_load_mesh, o->context, NULL, NULL),
                      FAILS(neph_terrain_describe_file, o->context, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_volume_load, o->context, NULL, NULL, NULL),
                      FAILS(neph_volume_create_dense, o->context, NULL, NULL),
                      FAILS(neph_volume_load_memory, o->context, NULL, 0, NULL, NULL),
                      FAILS(neph_volume_create_sparse, o->context, NULL, NULL),
                      FAILS(neph_volume_describe_file, o->context, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_cloud_get_preset, o->context, NULL, NULL),
                      FAILS(neph_cloud_eval, o->context, NULL, 0, 0, NULL, NULL),
                      FAILS(neph_cloud_bake, o->context, NULL, NULL, NULL),
                      FAILS(neph_cloud_bake_file, o->context, NULL, NULL, NULL, NULL),
                      FAILS(neph_cloud_verify_file, o->context, NULL, NULL, NULL, NULL),
                      FAILS(neph_ephemeris_compute, o->context, NULL, 0, 0, NULL),
                      FAILS(neph_machine_calibrate, o->context, NULL, NULL, NULL),
                      FAILS(neph_machine_save, o->context, NULL, NULL),
                      FAILS(neph_machine_load, o->context, NULL, NULL),
                      FAILS(neph_noise_texture_create, o->context, (neph_noise_texture_kind)0, 0, NULL),
                      FAILS(neph_parts_merge, o->context, NULL, 0, NULL, NULL),
                      FAILS(neph_probe_slab, o->context, NULL, NULL, NULL),
                      FAILS(neph_probe_sky, o->context, NULL, NULL, NULL),
                      FAILS(neph_probe_field, o->scene, NULL, NULL),
                      FAILS(neph_probe_i3rc, o->context, NULL, NULL, NULL),
                      FAILS(neph_renderer_create, o->context, NULL),
                      FAILS(neph_report_create, o->context, NULL, NULL)};
  check_rows(rows, sizeof rows / sizeof *rows, o);
}

static void call_with_an_object_alone(const objects *o) {
  const row rows[] = {FAILS(neph_image_set_attribute, o->image, NULL, NULL),
                      FAILS(neph_image_save_exr, o->image, NULL, (neph_pixel_type)0),
                      FAILS(neph_image_save_deep_exr, o->image, NULL, (neph_pixel_type)0),
                      FAILS(neph_image_save_png, o->image, NULL, NULL),
                      FAILS(neph_image_get_error, o->image, NULL),
                      FAILS(neph_image_develop, o->image, NULL, 0, 0, 1, 1, NULL, 4),
                      FAILS(neph_scene_clone, o->scene, NULL),
                      FAILS(neph_scene_set, o->scene, NULL, NULL),
                      FAILS(neph_scene_unset, o->scene, NULL),
                      FAILS(neph_scene_insert, o->scene, NULL, NULL),
                      FAILS(neph_scene_set_keys, o->scene, NULL, NULL, 0),
                      FAILS(neph_scene_get_text, o->scene, NULL),
                      FAILS(neph_scene_save, o->scene, NULL),
                      FAILS(neph_scene_describe_edits, o->scene, (neph_text_format)0, NULL),
                      FAILS(neph_scene_describe, o->scene, (neph_text_format)0, NULL),
                      FAILS(neph_scene_get_output, o->scene, NULL),
                      FAILS(neph_scene_get_render_desc, o->scene, NULL),
                      FAILS(neph_scene_choose_effort, o->scene, NULL, NULL),
                      FAILS(neph_render_image, o->scene, NULL, NULL),
                      FAILS(neph_render_explain, o->scene, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_render_estimate_memory, o->scene, NULL, NULL),
                      FAILS(neph_render_estimate_time, o->scene, NULL, NULL, NULL),
                      FAILS(neph_render_sky, o->scene, NULL, NULL),
                      FAILS(neph_scene_save_usd, o->scene, NULL, NULL, NULL),
                      FAILS(neph_render_sky_table, o->scene, (neph_sky_table)0, NULL),
                      FAILS(neph_render_sky_verify, o->scene, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_scene_bake_file, o->scene, 0, 0, NULL, NULL),
                      FAILS(neph_scene_export_cloud, o->scene, 0, 0, NULL, NULL, NULL),
                      FAILS(neph_scene_save_volumes_usd, o->scene, NULL, 0, NULL),
                      FAILS(neph_scene_export_textures, o->scene, 0, NULL, NULL),
                      FAILS(neph_render_compute_hash, o->scene, NULL, NULL),
                      FAILS(neph_render_is_done, o->scene, NULL, NULL, NULL),
                      FAILS(neph_scene_add_volume, o->scene, NULL, NULL, NULL),
                      FAILS(neph_sky_create, o->atmosphere, NULL, NULL),
                      FAILS(neph_renderer_render, o->renderer, NULL, NULL, NULL),
                      FAILS(neph_renderer_explain, o->renderer, NULL, NULL, (neph_text_format)0, NULL),
                      FAILS(neph_renderer_choose_effort, o->renderer, NULL, NULL, NULL)};
  check_rows(rows, sizeof rows / sizeof *rows, o);
}

/* ---- Tests ---- */

/* Functions of no object at all have an answer for every value. */
static void functions_without_objects_answer(void **state) {
  (void)state;
  assert_non_null(neph_version_get_text());
  assert_true(neph_version_get_number() > 0);
  assert_non_null(neph_result_get_name((neph_result)-1));
  assert_non_null(neph_result_get_text((neph_result)-1));
  (void)neph_isa_get_name(NEPH_ISA_X86_64);
  (void)neph_work_get_name((neph_work)0);
  (void)neph_sky_table_get_name((neph_sky_table)0);
}

static void getters_without_an_object_write_zeros(void **state) {
  (void)state;
  const double up[3] = {0, 0, 1};
  double a[3] = {1, 1, 1}, b[3] = {1, 1, 1};
  float value = 1.0f;
  neph_sky_get_radiance(NULL, up, a);
  assert_near(a[0] + a[1] + a[2], 0, 0);
  neph_sky_get_irradiance(NULL, a, b);
  assert_near(b[0] + b[1] + b[2], 0, 0);
  a[1] = b[2] = 1.0;
  neph_sky_get_aerial_perspective(NULL, up, 1.0, a, b);
  assert_near(a[1] + b[2], 0, 0);
  a[0] = 1.0;
  neph_atmosphere_get_transmittance(NULL, up, up, a);
  assert_near(a[0], 0, 0);
  neph_volume_sample(NULL, 1, up, &value);
  assert_near((double)value, 0, 0);
}

static void outputs_are_null_where_an_input_is(void **state) {
  const objects *o = *state;
  neph_image *image = o->image;
  neph_scene *scene = o->scene;
  char other, *text = &other;
  assert_int_equal(neph_image_load_exr(o->context, NULL, &image), NEPH_ERROR_INVALID_ARGUMENT);
  assert_null(image);
  assert_int_equal(neph_scene_load(NULL, "a.yaml", &scene), NEPH_ERROR_INVALID_ARGUMENT);
  assert_null(scene);
  assert_int_equal(neph_render_explain(NULL, NULL, NEPH_TEXT_PLAIN, &text), NEPH_ERROR_INVALID_ARGUMENT);
  assert_null(text);
}

static void every_function_takes_null_for_its_objects(void **state) {
  (void)state;
  call_a_core_without_objects();
  call_an_image_without_objects();
  call_a_world_without_objects();
  call_a_scene_without_objects();
  call_a_render_without_objects();
}

static void a_context_brings_one_message(void **state) {
  objects *o = *state;
  call_with_a_context_alone(o);
  test_log_clear(&o->log);
  call_more_with_a_context_alone(o);
}

static void an_object_brings_one_message(void **state) { call_with_an_object_alone(*state); }

static objects shared;

static int set_up(void **state) {
  objects *o = &shared;
  const char *const channel = "Y";
  test_log_start(&o->log);
  o->context = test_context_create(1, &o->log);
  *state = o;
  return neph_image_create(o->context, 1, 1, 1, &channel, &o->image) || neph_scene_create(o->context, &o->scene) ||
         neph_atmosphere_create(o->context, NULL, &o->atmosphere) || neph_renderer_create(o->context, &o->renderer);
}

static int tear_down(void **state) {
  objects *o = *state;
  neph_renderer_destroy(o->renderer);
  neph_atmosphere_release(o->atmosphere);
  neph_scene_destroy(o->scene);
  neph_image_destroy(o->image);
  neph_context_destroy(o->context);
  return 0;
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(functions_without_objects_answer),
      cmocka_unit_test(getters_without_an_object_write_zeros),
      cmocka_unit_test(every_function_takes_null_for_its_objects),
      cmocka_unit_test_setup_teardown(outputs_are_null_where_an_input_is, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_context_brings_one_message, set_up, tear_down),
      cmocka_unit_test_setup_teardown(an_object_brings_one_message, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

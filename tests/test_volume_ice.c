/* SPDX-License-Identifier: Apache-2.0 */
/* Ice in the cold part of a cloud: its share by altitude, the parts, which clouds have it, and pictures. */
#include "test_scenes.h"

#include <math.h>

#include "core/disk_cache.h"
#include "core/random.h"
#include "scene/scene_private.h"
#include "test_clouds.h"
#include "volume/instance.h"
#include "volume/volume_ice.h"

static const char scene[] =
    "camera: {position: [0 m, -34 km, 50 m], look_at: [0 m, 0 m, 6.5 km], fov: 60 deg, resolution: [24, 14]}\n"
    "sun: {elevation: 30 deg, azimuth: 10 deg}\n"
    "atmosphere: {tolerance: 0.1}\n"
    "clouds: [{name: storm, bake: {preset: cumulonimbus, seed: 3, voxel: 600 m}}]\n"
    "render: {samples: 16, light_memory: 100 MB}\n";

static int set_up(void **state) { return set_up_scene_verbose(state, 2, scene); }

/* The standard atmosphere has -15 °C at 30/6.5 km and -38 °C at 53/6.5 km. */
static void ice_follows_the_temperature(void **state) {
  (void)state;
  assert_near((double)np_ice_compute_share(0), 0, 0);
  assert_near((double)np_ice_compute_share(1e3 * 30 / 6.5), 0, 1e-3);
  assert_near((double)np_ice_compute_share(1e3 * 41.5 / 6.5), 0.5, 1e-3);
  assert_near((double)np_ice_compute_share(1e3 * 53 / 6.5), 1, 1e-3);
  assert_near((double)np_ice_compute_share(12e3), 1, 0);
}

static float sample(const neph_volume *volume, np_dvec3 at) {
  const np_instance one = {
      .bricks = &volume->bricks, .extinction_per_value = 1.0f, .world_to_index = volume->world_to_index};
  return np_instance_extinction(&one, at);
}

/* The parts add up in voxels, and the second has the share of its altitude. */
static void parts_add_up(void **state) {
  fixture *f = *state;
  const neph_cloud_desc desc = f->scene->clouds[0].bake;
  neph_volume *whole;
  np_tint *tint;
  int cold = 0;
  assert_int_equal(neph_cloud_bake(f->context, &desc, NULL, &whole), NEPH_OK);
  assert_int_equal(np_tint_create_ice(f->context, whole, NEPH_PRECISION_FLOAT, NULL, &tint), NEPH_OK);
  assert_int_equal(tint->count, 2);
  assert_false(tint->parts[0].is_ice);
  assert_true(tint->parts[1].is_ice);
  for (int x = whole->active_min[0]; x <= whole->active_max[0]; x += 3)
    for (int z = whole->active_min[2]; z <= whole->active_max[2]; z++) {
      const int y = (whole->active_min[1] + whole->active_max[1]) / 2;
      const np_dvec3 at = np_affine_point(&whole->index_to_world, np_dvec3_make(x, y, z));
      const double all = (double)sample(whole, at), ice = (double)sample(tint->parts[1].volume, at);
      assert_near((double)sample(tint->parts[0].volume, at) + ice, all, 1e-3 * all + 1e-7);
      assert_near(ice, (double)np_ice_compute_share(at.z) * all, 1e-3 * all + 1e-7);
      cold += ice > 0;
    }
  assert_true(cold > 10);
  np_tint_destroy(tint);
  neph_volume_release(whole);
}

enum { POINTS = 4000 };

/* Sum of a volume's levels, and of those of crystals alone. */
static void sample_levels(const neph_volume *volume, np_dvec3 at, double *out_all, double *out_ice) {
  *out_all = *out_ice = 0;
  for (unsigned k = 0; k < np_volume_count_parts(volume); k++) {
    const double value = (double)sample(np_volume_get_part(volume, k), at);
    *out_all += value;
    *out_ice += volume->tint->parts[k].is_ice ? value : 0;
  }
}

/* A copy of a volume that a cache returns. */
static neph_volume *pass_cache(const neph_volume *volume) {
  static const char key[] = "00000000000000000000000000000000";
  neph_context *context = test_context_create_cached(1, NULL);
  neph_volume *copy = NULL;
  np_cache_entry entry;
  np_cache_write_begin(context, "test", key, &entry);
  np_volume_save_to_cache(volume, &entry);
  np_cache_write_commit(&entry);
  assert_true(np_cache_read_begin(context, "test", key, &entry));
  assert_int_equal(np_volume_load_from_cache(context, &entry, &copy), NEPH_OK);
  assert_true(np_cache_read_end(&entry));
  neph_context_destroy(context);
  return copy;
}

/* Between samples and across borders of levels too the parts of three levels add up to what the levels were, but for
 * rounding. Ice is in the share of the altitudes within a voxel. A cache returns
 * the levels to the bit, although the box of the first is that of all. */
static void levels_have_parts_that_add_up(void **state) {
  fixture *f = *state;
  neph_cloud_desc desc = f->scene->clouds[0].bake;
  neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  neph_volume *volumes[3];
  desc.voxel_m = 200;
  bake.precision = NEPH_PRECISION_FLOAT;
  bake.lod_count = 3;
  bake.lod_angle_rad = 0.03;
  bake.lod_viewer_min_m[1] = bake.lod_viewer_max_m[1] = -16e3;
  for (int i = 0; i < 2; i++) assert_int_equal(neph_cloud_bake(f->context, &desc, &bake, &volumes[i]), NEPH_OK);
  const unsigned levels = np_volume_count_parts(volumes[0]);
  assert_int_equal(levels, 3);
  assert_int_equal(np_volume_split_ice(volumes[1], NEPH_PRECISION_FLOAT, NULL), NEPH_OK);
  assert_int_equal(np_volume_count_parts(volumes[1]), 6);
  volumes[2] = pass_cache(volumes[1]);
  assert_non_null(volumes[2]);
  int mixed = 0;
  np_random random = np_random_start(3, 0, 0, 0, 0);
  for (int n = 0; n < POINTS; n++) {
    const np_dvec3 at = np_dvec3_make(28e3 * (np_random_double(&random) - 0.5),
                                      28e3 * (np_random_double(&random) - 0.5), 1e3 + 10e3 * np_random_double(&random));
    double all, ice, whole, none, loaded, loaded_ice;
    sample_levels(volumes[0], at, &whole, &none);
    sample_levels(volumes[1], at, &all, &ice);
    sample_levels(volumes[2], at, &loaded, &loaded_ice);
    assert_true(loaded == all && loaded_ice == ice);
    assert_near(all, whole, 1e-4 * whole + 1e-7);
    assert_true(ice <= 1.0001 * all * (double)np_ice_compute_share(at.z + 800) + 1e-7);
    assert_true(ice >= 0.9999 * all * (double)np_ice_compute_share(at.z - 800) - 1e-7);
    mixed += ice > 0 && ice < 0.99 * all;
  }
  print_message("%d of %d points in droplets and crystals\n", mixed, POINTS);
  assert_true(mixed > 100);
  for (int i = 0; i < 3; i++) neph_volume_release(volumes[i]);
}

static void a_warm_cloud_has_no_parts(void **state) {
  fixture *f = *state;
  neph_cloud_desc desc = f->scene->clouds[0].bake;
  neph_volume *whole;
  np_tint *tint;
  desc.thickness_m = 3000;
  assert_int_equal(neph_cloud_bake(f->context, &desc, NULL, &whole), NEPH_OK);
  assert_int_equal(np_tint_create_ice(f->context, whole, NEPH_PRECISION_FLOAT, NULL, &tint), NEPH_OK);
  assert_null(tint);
  neph_volume_release(whole);
}

enum { FULL_NODES = 257 }; /* nodes of 16³ blocks: one more than 2^20 blocks take */

/* A cloud of more blocks than can be split keeps droplets, with and without levels; the advice is the key that leaves
 * crystals out. Tiles of a table hold the blocks. */
static void too_many_blocks_are_of_droplets(void **state) {
  fixture *f = *state;
  static uint32_t table[FULL_NODES];
  static np_brick_range ranges[FULL_NODES];
  for (int i = 0; i < FULL_NODES; i++) {
    table[i] = NP_BRICK_NONE;
    ranges[i] = (np_brick_range){1.0f, 1.0f};
  }
  neph_volume volume = {.context = f->context,
                        .index_to_world = np_affine_identity(),
                        .bricks = {.context = f->context,
                                   .size = {FULL_NODES * NP_BRICK_NODE_EDGE, NP_BRICK_NODE_EDGE, NP_BRICK_NODE_EDGE},
                                   .table_size = {FULL_NODES, 1, 1},
                                   .table = table,
                                   .table_ranges = ranges,
                                   .scale = 1.0f}};
  np_tint *tint;
  test_log_clear(&f->log);
  assert_int_equal(np_tint_create_ice(f->context, &volume, NEPH_PRECISION_FLOAT, NULL, &tint), NEPH_OK);
  assert_null(tint);
  assert_non_null(
      strstr(f->log.text, "bake: 1052672 blocks of 8³ voxels of the cloud are not empty, must be at most 1048576"));
  assert_non_null(strstr(f->log.text, "enlarge voxel, or set phase to {droplets: {}}"));
  test_log_clear(&f->log);
  assert_int_equal(np_tint_create_levels(f->context, NP_PARTS_OF_CELLS, &volume.tint), NEPH_OK);
  assert_int_equal(np_volume_split_ice(&volume, NEPH_PRECISION_FLOAT, NULL), NEPH_OK);
  assert_int_equal(volume.tint->count, 1);
  assert_false(volume.tint->parts[0].is_ice);
  assert_non_null(strstr(f->log.text, "voxels of level 0 are not empty"));
  np_tint_destroy(volume.tint);
}

static double estimate_volumes(fixture *f) {
  neph_memory_estimate estimate = NEPH_MEMORY_ESTIMATE_DEFAULT;
  assert_int_equal(neph_render_estimate_memory(f->scene, NULL, &estimate), NEPH_OK);
  return (double)estimate.volume_bytes;
}

/* A plan adds the memory of the parts beside the whole cloud, within a third. Where there is hardly any light, the grid
 * from which a part is built counts too: 4 bytes a voxel. */
static void a_plan_counts_the_memory_of_ice(void **state) {
  fixture *f = *state;
  neph_volume *whole;
  np_tint *tint;
  set(f, "clouds[0].bake.voxel", "300 m");
  const double with_ice = estimate_volumes(f);
  set(f, "atmosphere", "none");
  set(f, "render.integrator", "path");
  const double by_path = estimate_volumes(f);
  set(f, "clouds[0].phase", "{droplets: {}}");
  const double without = estimate_volumes(f);
  assert_int_equal(neph_cloud_bake(f->context, &f->scene->clouds[0].bake, NULL, &whole), NEPH_OK);
  assert_int_equal(np_tint_create_ice(f->context, whole, NEPH_PRECISION_HALF, NULL, &tint), NEPH_OK);
  double parts = 0, largest = 0;
  for (unsigned k = 0; k < tint->count; k++) {
    const double bricks = (double)tint->parts[k].volume->bricks.brick_count;
    parts += bricks;
    largest = fmax(largest, bricks);
  }
  const double stored = parts * NP_BRICK_STRIDE * sizeof(uint16_t), built = largest * sizeof(np_leaf);
  print_message("ice adds %.3g MB of %.3g, %.3g more while it is built of %.3g\n", 1e-6 * (with_ice - without),
                1e-6 * stored, 1e-6 * (by_path - with_ice), 1e-6 * built);
  assert_near(with_ice - without, stored, stored / 3);
  assert_near(by_path - with_ice, built, built / 2);
  np_tint_destroy(tint);
  neph_volume_release(whole);
}

static void anvils_have_ice_unless_a_key_says_otherwise(void **state) {
  fixture *f = *state;
  static const struct {
    const char *key, *value;
    bool has_ice;
  } rows[] = {{"clouds[0].bake.seed", "5", true},
              {"clouds[0].phase", "{droplets: {}}", false},
              {"clouds[0].phase", "{hg: 0.85}", false},
              {"clouds[0].bake.anvil", "0", false},
              {"clouds[0].bake.levels", "4", true},
              {"clouds[0].bake.levels", "5", false},
              {"clouds[0].bake.preset", "cumulus_congestus", false}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    neph_scene *other;
    assert_int_equal(neph_scene_load_text(f->context, scene, "dir/scene.yaml", &other), NEPH_OK);
    assert_int_equal(neph_scene_set(other, rows[i].key, rows[i].value), NEPH_OK);
    if (np_scene_cloud_has_ice(other->clouds) != rows[i].has_ice) fail_msg("%s %s", rows[i].key, rows[i].value);
    neph_scene_destroy(other);
  }
}

static double render(fixture *f, bool has_ice) {
  neph_image *image;
  double sum = 0;
  test_log_clear(&f->log);
  assert_int_equal(neph_render_image(f->scene, NULL, &image), NEPH_OK);
  assert_int_equal(strstr(f->log.text, "storm: ice from 4.6 km up, ice alone from 8.2 km") != NULL, has_ice);
  const unsigned count = neph_image_get_width(image) * neph_image_get_height(image);
  const float *green = neph_image_get_channel(image, "G");
  for (unsigned i = 0; i < count; i++) sum += (double)green[i];
  neph_image_destroy(image);
  return sum / count;
}

/* The march's bias of a coarse storm is some percent; 10 % holds it with the noise of 16 paths a pixel. Crystals
 * scatter less forward than droplets: what the sun behind the storm sends through its anvil changes, in the march's
 * picture, which has little noise. */
static void both_integrators_render_ice(void **state) {
  fixture *f = *state;
  const double marched = render(f, true);
  set(f, "render.integrator", "path");
  const double traced = render(f, true);
  set(f, "render.integrator", "march");
  set(f, "clouds[0].phase", "{droplets: {}}");
  const double without = render(f, false);
  print_message("march %g, path %g, of droplets %g\n", marched, traced, without);
  assert_near(marched / traced, 1.0, 0.1);
  assert_true(fabs(without / marched - 1.0) > 0.002);
}

/* The green of a picture of the anvil alone, from the height of its ice. */
static double render_rim(fixture *f, const char *detail) {
  neph_image *image;
  double sum = 0;
  set(f, "clouds[0].detail", detail);
  assert_int_equal(neph_render_image(f->scene, NULL, &image), NEPH_OK);
  const unsigned count = neph_image_get_width(image) * neph_image_get_height(image);
  const float *green = neph_image_get_channel(image, "G");
  for (unsigned i = 0; i < count; i++) sum += (double)green[i] * (1 + i % 7);
  neph_image_destroy(image);
  return sum;
}

/* Above 8.2 km all is ice, which has no billows. A fiftieth of the change of droplets is left for light from below,
 * where droplets have them: it changes the sum by 0.0009, droplets there would change it by 0.13. */
static void ice_has_no_billows(void **state) {
  fixture *f = *state;
  set(f, "camera.position", "[0 m, -24 km, 10 km]");
  set(f, "camera.look_at", "[0 m, 0 m, 10 km]");
  set(f, "camera.fov", "6 deg");
  set(f, "render.samples", "4");
  const double crystals[2] = {render_rim(f, "none"), render_rim(f, "auto")};
  set(f, "clouds[0].phase", "{droplets: {}}");
  const double droplets[2] = {render_rim(f, "none"), render_rim(f, "auto")};
  print_message("detail changes ice by %g, droplets by %g\n", crystals[1] / crystals[0] - 1,
                droplets[1] / droplets[0] - 1);
  assert_true(fabs(droplets[1] / droplets[0] - 1) > 0.01);
  assert_near(crystals[1] / crystals[0], 1, 0.02 * fabs(droplets[1] / droplets[0] - 1));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(ice_follows_the_temperature),
      cmocka_unit_test_setup_teardown(parts_add_up, set_up, tear_down),
      cmocka_unit_test_setup_teardown(levels_have_parts_that_add_up, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_warm_cloud_has_no_parts, set_up, tear_down),
      cmocka_unit_test_setup_teardown(too_many_blocks_are_of_droplets, set_up, tear_down),
      cmocka_unit_test_setup_teardown(a_plan_counts_the_memory_of_ice, set_up, tear_down),
      cmocka_unit_test_setup_teardown(anvils_have_ice_unless_a_key_says_otherwise, set_up, tear_down),
      cmocka_unit_test_setup_teardown(both_integrators_render_ice, set_up, tear_down),
      cmocka_unit_test_setup_teardown(ice_has_no_billows, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

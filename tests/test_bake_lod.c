/* SPDX-License-Identifier: Apache-2.0 */
/* Levels of detail of a bake: each place in one of them, all samples the model's, optical depths that stay, the same
 * bits for any number of threads and from the cache on disk, and what a scene makes of its keys. */
#include "test_clouds.h"
#include "test_scenes.h"

#include "cloud/bake_field.h"
#include "cloud/bake_grid.h"
#include "core/random.h"
#include "volume/volume_tint.h"

enum { LEVELS = 3 };

static const double no_curve_m = 1e9;

/* A field of 5 km, seen from above one of its corners. */
static neph_cloud_desc make_field(neph_context *context, const char *preset) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(context, preset, &desc), NEPH_OK);
  desc.extent_m[0] = desc.extent_m[1] = 5000;
  desc.voxel_m = 20;
  desc.coverage = fmax(desc.coverage, 0.4);
  return desc;
}

static neph_bake_desc make_bake(unsigned lod_count) {
  neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  desc.planet_radius_m = no_curve_m;
  desc.precision = NEPH_PRECISION_FLOAT;
  desc.lod_count = lod_count;
  desc.lod_angle_rad = 0.025;
  for (int a = 0; a < 3; a++) desc.lod_viewer_min_m[a] = desc.lod_viewer_max_m[a] = a < 2 ? -2500 : 1500;
  return desc;
}

static neph_volume *bake(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc) {
  neph_volume *volume;
  assert_int_equal(neph_cloud_bake(context, cloud, desc, &volume), NEPH_OK);
  return volume;
}

/* Sum of all levels at a place. */
static double sample(const neph_volume *volume, np_dvec3 position) {
  double sum = 0;
  for (unsigned k = 0; k < np_volume_count_parts(volume); k++) {
    const neph_volume *level = np_volume_get_part(volume, k);
    sum += (double)np_bricks_sample(&level->bricks, np_affine_point(&level->world_to_index, position));
  }
  return sum;
}

/* ---- Samples ---- */

/* The levels together contain each sample of the model exactly once. The samples of the coarsest level are samples of
 * all others too; samples of a finer one belong to it alone. */
static void check_active(neph_context *context, const neph_cloud_desc *cloud, const neph_volume *volume, unsigned k) {
  const neph_volume *level = np_volume_get_part(volume, k);
  const bool is_coarsest = k + 1 == np_volume_count_parts(volume);
  enum { POINTS = 4000 };
  static double at_m[POINTS][3];
  static float expected[POINTS];
  np_random random = np_random_start(7, 0, 0, 0, 0);
  int cloudy = 0;
  for (int n = 0; n < POINTS; n++) {
    double index[3];
    for (int a = 0; a < 3; a++)
      index[a] = level->active_min[a] +
                 floor(np_random_double(&random) * (1.0 + (double)level->active_max[a] - level->active_min[a]));
    const np_dvec3 p = np_affine_point(&level->index_to_world, np_dvec3_make(index[0], index[1], index[2]));
    at_m[n][0] = p.x, at_m[n][1] = p.y, at_m[n][2] = p.z;
  }
  assert_int_equal(neph_cloud_eval(context, cloud, no_curve_m, POINTS, *at_m, expected), NEPH_OK);
  for (int n = 0; n < POINTS; n++) {
    const np_dvec3 p = np_dvec3_make(at_m[n][0], at_m[n][1], at_m[n][2]);
    const np_dvec3 index = np_affine_point(&level->world_to_index, p);
    const double own =
        (double)np_bricks_sample(&level->bricks, np_dvec3_make(round(index.x), round(index.y), round(index.z)));
    if (!is_coarsest && !(own > 0)) continue; /* belongs to another level, or is clear */
    cloudy += own > 0;
    assert_near(sample(volume, p), (double)expected[n], 1e-5 + 1e-3 * (double)expected[n]);
  }
  assert_true(cloudy > 20);
}

static void each_place_is_in_one_level(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  const neph_cloud_desc cloud = make_field(context, "cumulus_mediocris");
  const neph_bake_desc desc = make_bake(LEVELS);
  neph_volume *volume = bake(context, &cloud, &desc);
  assert_int_equal(np_volume_count_parts(volume), LEVELS);
  for (unsigned k = 0; k < LEVELS; k++) check_active(context, &cloud, volume, k);
  neph_volume_release(volume);
  neph_context_destroy(context);
}

/* ---- Optical depth ---- */

/* Mean optical depth of columns, 12.5 m apart. */
static double compute_depth(const neph_volume *volume, const neph_cloud_desc *cloud) {
  const double step_m = 12.5, bottom_m = cloud->base_altitude_m - 100;
  const int columns = (int)(cloud->extent_m[0] / 80), rows = (int)((cloud->thickness_m + 200) / step_m);
  double sum = 0;
  for (int n = 0; n < columns * columns; n++)
    for (int k = 0; k < rows; k++)
      sum += step_m * sample(volume, np_dvec3_make(cloud->extent_m[0] * ((n % columns + 0.5) / columns - 0.5),
                                                   cloud->extent_m[1] * ((n / columns + 0.5) / columns - 0.5),
                                                   bottom_m + (k + 0.5) * step_m));
  return sum / (columns * columns);
}

/* Coarse levels sample the finest model, so that their mean is its, but for the luck of where their samples are: three
 * fields of each kind, and voxels of a 32nd of the thickness, 20 m at least, to an eighth of it. */
static void optical_depth_is_kept(void **state) {
  static const char *const presets[] = {"cumulus_mediocris", "stratocumulus", "cirrus", "nimbostratus",
                                        "altocumulus_floccus"};
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  for (size_t p = 0; p < sizeof presets / sizeof *presets; p++) {
    neph_cloud_desc cloud = make_field(context, presets[p]);
    const neph_bake_desc fine = make_bake(1);
    neph_bake_desc levels = make_bake(LEVELS);
    cloud.voxel_m = fmax(cloud.voxel_m, cloud.thickness_m / 32);
    levels.lod_angle_rad *= cloud.voxel_m / 20; /* distances of the levels are those of voxels of 20 m */
    double all_fine = 0, leveled = 0;
    for (cloud.seed = 1; cloud.seed <= 3; cloud.seed++) {
      neph_volume *a = bake(context, &cloud, &fine), *b = bake(context, &cloud, &levels);
      all_fine += compute_depth(a, &cloud) / 3;
      leveled += compute_depth(b, &cloud) / 3;
      assert_true(2 * b->active_voxel_count < a->active_voxel_count);
      neph_volume_release(a);
      neph_volume_release(b);
    }
    print_message("%-20s mean optical depth %.4f, in levels %.4f (%+.2f %%)\n", presets[p], all_fine, leveled,
                  100 * (leveled / all_fine - 1));
    assert_near(leveled / all_fine, 1.0, 0.01);
  }
  neph_context_destroy(context);
}

/* ---- The same bits ---- */

static void assert_same_volume(const neph_volume *a, const neph_volume *b) {
  assert_int_equal(np_volume_count_parts(a), np_volume_count_parts(b));
  assert_memory_equal(a->active_min, b->active_min, sizeof a->active_min);
  assert_memory_equal(a->active_max, b->active_max, sizeof a->active_max);
  for (unsigned k = 0; k < np_volume_count_parts(a); k++) {
    const np_bricks *p = &np_volume_get_part(a, k)->bricks, *q = &np_volume_get_part(b, k)->bricks;
    assert_int_equal(p->brick_count, q->brick_count);
    assert_memory_equal(p->floats, q->floats, p->brick_count * NP_BRICK_STRIDE * sizeof *p->floats);
  }
}

static void threads_do_not_matter(void **state) {
  (void)state;
  neph_context *one = test_context_create(1, NULL), *three = test_context_create(3, NULL);
  const neph_cloud_desc cloud = make_field(one, "cumulus_mediocris");
  const neph_bake_desc desc = make_bake(3);
  neph_volume *a = bake(one, &cloud, &desc), *b = bake(three, &cloud, &desc);
  assert_same_volume(a, b);
  neph_volume_release(a);
  neph_volume_release(b);
  neph_context_destroy(one);
  neph_context_destroy(three);
}

/* A viewer far away: the finest level holds nothing, and the rest is there. */
static void a_far_field_has_no_fine_level(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc cloud = make_field(context, "cumulus_mediocris");
  neph_bake_desc desc = make_bake(2), coarse = make_bake(1);
  desc.lod_viewer_min_m[0] = desc.lod_viewer_max_m[0] = -50e3;
  neph_volume *a = bake(context, &cloud, &desc);
  assert_int_equal(np_volume_count_parts(a), 2);
  assert_int_equal(a->bricks.brick_count, 0);
  cloud.voxel_m *= 2;
  neph_volume *b = bake(context, &cloud, &coarse);
  assert_near((double)a->active_voxel_count / (double)b->active_voxel_count, 1.0, 0.1);
  neph_volume_release(a);
  neph_volume_release(b);
  neph_context_destroy(context);
}

/* ---- Regions ---- */

/* A level of a bake to a file, as a grid. */
static np_sparse_grid bake_level(neph_context *context, const neph_cloud_desc *cloud, const neph_bake_desc *desc,
                                 unsigned number) {
  np_bake bake, level;
  np_monitor monitor;
  np_sparse_grid grid;
  assert_int_equal(np_bake_start_checked(context, cloud, desc, NP_BAKE_FOR_FILE, &monitor, &bake), NEPH_OK);
  assert_int_equal(np_bake_get_level(&bake, number, &level), NEPH_OK);
  assert_int_equal(np_bake_make_grid(&level, "density", &grid), NEPH_OK);
  np_bake_end(&bake);
  return grid;
}

/* The leaf of a grid where another one has its own; NULL: none. */
static np_leaf *search_leaf(const np_sparse_grid *grid, const int32_t origin[3]) {
  for (size_t i = 0; i < grid->leaf_count; i++)
    if (!memcmp(grid->leaves[i].origin, origin, sizeof grid->leaves[i].origin)) return &grid->leaves[i];
  return NULL;
}

/* Takes a part out of the whole: its voxels are the whole's, to the bit, and are not taken twice. */
static void take_part(np_sparse_grid *whole, const np_sparse_grid *part) {
  assert_memory_equal(&part->index_to_world, &whole->index_to_world, sizeof part->index_to_world);
  for (size_t i = 0; i < part->leaf_count; i++) {
    const np_leaf *leaf = &part->leaves[i];
    np_leaf *of = search_leaf(whole, leaf->origin);
    assert_non_null(of);
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const uint64_t bit = leaf->active[n / 64] & UINT64_C(1) << n % 64;
      if (!bit) continue;
      assert_true(of->active[n / 64] & bit);
      assert_memory_equal(&leaf->values[n], &of->values[n], sizeof leaf->values[n]);
      of->active[n / 64] &= ~bit;
    }
  }
}

/* Four regions that meet in the middle of cells, and between samples of all levels. */
static void regions_add_up_to_the_whole(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  const neph_cloud_desc cloud = make_field(context, "cumulus_mediocris");
  const double cuts_m[2] = {-1003.7, -871.3};
  for (unsigned k = 0; k < LEVELS; k++) {
    neph_bake_desc desc = make_bake(LEVELS);
    np_sparse_grid whole = bake_level(context, &cloud, &desc, k);
    const uint64_t count = np_sparse_grid_count_active(&whole);
    uint64_t sum = 0;
    desc.has_region = true;
    for (int n = 0; n < 4; n++) {
      for (int a = 0; a < 3; a++) desc.region_min_m[a] = -9e3, desc.region_max_m[a] = 9e3;
      for (int a = 0; a < 2; a++) *(n >> a & 1 ? &desc.region_min_m[a] : &desc.region_max_m[a]) = cuts_m[a];
      np_sparse_grid part = bake_level(context, &cloud, &desc, k);
      sum += np_sparse_grid_count_active(&part);
      take_part(&whole, &part);
      np_sparse_grid_clear(&part);
    }
    print_message("level %u: %llu voxels in four regions\n", k, (unsigned long long)sum);
    assert_true(count > 1000);
    assert_int_equal(sum, count);
    assert_int_equal(np_sparse_grid_count_active(&whole), 0);
    np_sparse_grid_clear(&whole);
  }
  neph_context_destroy(context);
}

/* Nearer the border of the region than a voxel the volume fades; farther away it is the whole, and nothing beyond. */
static void a_region_in_memory_is_the_whole_inside(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  const neph_cloud_desc cloud = make_field(context, "cumulus_mediocris");
  neph_bake_desc desc = make_bake(LEVELS);
  const double rim_m = ldexp(cloud.voxel_m, LEVELS - 1);
  neph_volume *whole = bake(context, &cloud, &desc);
  desc.has_region = true;
  for (int a = 0; a < 3; a++) {
    desc.region_min_m[a] = a < 2 ? -1703.7 : 0;
    desc.region_max_m[a] = a < 2 ? -103.7 : 9e3;
  }
  neph_volume *part = bake(context, &cloud, &desc);
  np_random random = np_random_start(8, 0, 0, 0, 0);
  int cloudy = 0;
  for (int n = 0; n < 50000; n++) {
    double low_m = INFINITY, at_m[3]; /* distance from the nearest border, inwards */
    for (int a = 0; a < 2; a++) {
      at_m[a] = desc.region_min_m[a] + (1.2 * np_random_double(&random) - 0.1) * 1600;
      low_m = fmin(low_m, fmin(at_m[a] - desc.region_min_m[a], desc.region_max_m[a] - at_m[a]));
    }
    at_m[2] = cloud.base_altitude_m + np_random_double(&random) * cloud.thickness_m;
    const np_dvec3 p = np_dvec3_make(at_m[0], at_m[1], at_m[2]);
    const double expected = sample(whole, p);
    if (low_m < -rim_m) assert_true(sample(part, p) == 0);
    if (low_m > rim_m) assert_true(sample(part, p) == expected);
    cloudy += low_m > rim_m && expected > 0;
  }
  assert_true(cloudy > 1000);
  neph_volume_release(part);
  neph_volume_release(whole);
  neph_context_destroy(context);
}

/* Between two samples of the coarsest level, but on one of the finest. */
static void a_thin_region_is_in_fine_levels_alone(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(2, &log);
  const neph_cloud_desc cloud = make_field(context, "cumulus_mediocris");
  neph_bake_desc desc = make_bake(LEVELS);
  neph_volume *volume;
  np_sparse_grid whole = bake_level(context, &cloud, &desc, 0);
  const np_dvec3 at = np_affine_point(&whole.index_to_world, np_dvec3_make(whole.leaves[0].origin[0] + 1, 0, 0));
  np_sparse_grid_clear(&whole);
  desc.has_region = true;
  for (int a = 0; a < 3; a++) desc.region_min_m[a] = -9e3, desc.region_max_m[a] = 9e3;
  desc.region_min_m[0] = at.x - 0.4 * cloud.voxel_m;
  desc.region_max_m[0] = at.x + 0.4 * cloud.voxel_m;
  for (unsigned k = 0; k < LEVELS; k++) {
    np_sparse_grid grid = bake_level(context, &cloud, &desc, k);
    assert_int_equal(grid.leaf_count > 0, k == 0);
    np_sparse_grid_clear(&grid);
  }
  desc.region_max_m[0] = at.x - 0.3 * cloud.voxel_m;
  assert_int_equal(neph_cloud_bake(context, &cloud, &desc, &volume), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "the region runs from ", "must meet a voxel of the cloud's box");
  neph_context_destroy(context);
}

/* ---- Refusals ---- */

static void bad_levels_are_refused(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  const neph_cloud_desc cloud = make_field(context, "cumulus_mediocris");
  neph_volume *volume;
  neph_bake_desc desc = make_bake(NEPH_BAKE_LODS_MAX + 1);
  assert_int_equal(neph_cloud_bake(context, &cloud, &desc, &volume), NEPH_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(log.text, "lod_count is 7, must be in [1, 6]"));
  desc = make_bake(2);
  desc.level_count = 2;
  assert_int_equal(neph_cloud_bake_file(context, &cloud, &desc, "density", "never.vdb"), NEPH_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(log.text, "level_count is 2, must be 1 where lod_count is 2, above 1"));
  desc.lod_angle_rad = 0;
  assert_int_equal(neph_cloud_bake(context, &cloud, &desc, &volume), NEPH_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(log.text, "lod_angle_rad is 0, must be in (0, 1]"));
  desc = make_bake(2);
  desc.lod_viewer_max_m[1] = -9e3;
  assert_int_equal(neph_cloud_bake(context, &cloud, &desc, &volume), NEPH_ERROR_INVALID_ARGUMENT);
  assert_non_null(strstr(log.text, "lod_viewer_max_m[1] is -9000"));
  neph_context_destroy(context);
}

/* ---- Scenes ---- */

static const char scene[] = "version: 1\n"
                            "camera: {position: [0 m, -1500 m, 900 m], look_at: [0 m, 0 m, 1100 m], fov: 60 deg,\n"
                            "  resolution: [48, 27]}\n"
                            "sun: {elevation: 20 deg, azimuth: 12 deg}\n"
                            "clouds:\n"
                            "  - bake: {extent: 2400 m, cell: 600 m, billow: 200 m, base: 900 m, thickness: 400 m,\n"
                            "      coverage: 0.6, voxel: 20 m, levels: 3}\n"
                            "render: {samples: 4, light_memory: 0.001 GB}\n";

static int set_up(void **state) { return set_up_scene_cached(state, 2, scene); }

static double render_mean(fixture *f, float *out_red) {
  neph_image *image;
  if (neph_render_image(f->scene, NULL, &image)) fail_msg("%s", f->log.text);
  const float *red = neph_image_get_values(image, "R");
  double sum = 0;
  for (int i = 0; i < 48 * 27; i++) {
    out_red[i] = red[i];
    assert_true(isfinite(out_red[i]));
    sum += (double)out_red[i];
  }
  neph_image_destroy(image);
  return sum / (48 * 27);
}

/* Two pixels a voxel: the picture is that of the finest voxels throughout, in both integrators. */
static void pictures_are_those_of_fine_voxels(void **state) {
  fixture *f = *state;
  static const char *const integrators[] = {"march", "path"};
  static float red[48 * 27], fine[48 * 27];
  for (int i = 0; i < 2; i++) {
    set(f, "render.integrator", integrators[i]);
    set(f, "clouds[0].bake.levels", "3");
    set(f, "clouds[0].bake.level_pixels", "1");
    const double leveled = render_mean(f, red);
    set(f, "clouds[0].bake.levels", "1");
    const double expected = render_mean(f, fine);
    double squares = 0;
    for (int n = 0; n < 48 * 27; n++)
      squares += ((double)red[n] - (double)fine[n]) * ((double)red[n] - (double)fine[n]);
    print_message("%-5s mean %.4g for %.4g, differences of %.3g of it\n", integrators[i], leveled, expected,
                  sqrt(squares / (48 * 27)) / expected);
    assert_near(leveled / expected, 1.0, 0.02);
    assert_true(squares > 0);
  }
}

static void levels_ignore_and_exclude(void **state) {
  fixture *f = *state;
  static const struct {
    const char *key, *value, *message;
  } rows[] = {
      {"clouds[0].position", "[0 m, 0 m, 900 m]", "clouds[0].position and clouds[0].bake.levels exclude each other"},
      {"clouds[0].scale", "2", "clouds[0].scale and clouds[0].bake.levels exclude"},
  };
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    neph_scene *other;
    neph_image *image;
    test_log_clear(&f->log);
    assert_int_equal(neph_scene_load_text(f->context, scene, "dir/scene.yaml", &other), NEPH_OK);
    assert_int_equal(neph_scene_set(other, rows[i].key, rows[i].value), NEPH_OK);
    assert_int_not_equal(neph_render_image(other, NULL, &image), NEPH_OK);
    if (!strstr(f->log.text, rows[i].message)) fail_msg("%s: %s", rows[i].key, f->log.text);
    neph_scene_destroy(other);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_place_is_in_one_level),
      cmocka_unit_test(optical_depth_is_kept),
      cmocka_unit_test(threads_do_not_matter),
      cmocka_unit_test(a_far_field_has_no_fine_level),
      cmocka_unit_test(regions_add_up_to_the_whole),
      cmocka_unit_test(a_region_in_memory_is_the_whole_inside),
      cmocka_unit_test(a_thin_region_is_in_fine_levels_alone),
      cmocka_unit_test(bad_levels_are_refused),
      cmocka_unit_test_setup_teardown(pictures_are_those_of_fine_voxels, set_up, tear_down),
      cmocka_unit_test_setup_teardown(levels_ignore_and_exclude, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

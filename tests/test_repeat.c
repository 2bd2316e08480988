/* SPDX-License-Identifier: Apache-2.0 */
/* Fields that repeat: their borders meet, tiles follow the sphere, and what cannot repeat is refused. */
#include "test_clouds.h"
#include "test_scenes.h"

#include <math.h>
#include <unistd.h>

#include "scene/cloud_places.h"
#include "stages/copies.h"
#include "volume/instance.h"
#include "volume/volume_coarser.h"

/* One preset of each model that repeats; a slab is nimbostratus without its rain. */
static const char *const presets[] = {"cumulus_mediocris", "altocumulus_floccus", "nimbostratus", "stratocumulus",
                                      "cirrus"};

enum { PRESETS = sizeof presets / sizeof *presets, ROWS = 48, HEIGHTS = 24, POINTS = ROWS * HEIGHTS };

static const double no_curve_m = 1e9;

static neph_cloud_desc make_tile(neph_context *context, const char *preset) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(context, preset, &desc), NEPH_OK);
  desc.extent_m[0] = desc.extent_m[1] = 6000;
  desc.voxel_m = 62.5;
  desc.coverage = 0.6;
  desc.precipitation = 0;
  desc.stretch = 3;
  desc.wind_m_s[1] = 0;
  desc.time_s = 40;
  desc.repeat_m = 50e3;
  desc.streets = 0.5;
  desc.cells_kind = NEPH_CLOUD_CELLS_CLOSED;
  desc.cells_size_m = 2500;
  return desc;
}

/* Points on a plane across x or y. */
static void list_points(const neph_cloud_desc *desc, int axis, double across_m, double shift_m, double (*out)[3]) {
  for (int n = 0; n < POINTS; n++) {
    const double along_m = desc->extent_m[0] * ((n / HEIGHTS + 0.37) / ROWS - 0.5) + shift_m;
    out[n][axis] = across_m;
    out[n][1 - axis] = along_m;
    out[n][2] = desc->base_altitude_m + desc->thickness_m * (n % HEIGHTS + 0.5) / HEIGHTS;
  }
}

static double compute_change(const float *a, const float *b) {
  double sum = 0;
  for (int n = 0; n < POINTS; n++) sum += fabs((double)a[n] - (double)b[n]);
  return sum / POINTS;
}

static double compute_mean(const float *values) {
  double sum = 0;
  for (int n = 0; n < POINTS; n++) sum += (double)values[n];
  return sum / POINTS;
}

/* Planes across an axis: one inside, the same some tiles off, both sides of the border, and the middle. */
enum { HERE, FAR, INNER, OUTER, MIDDLE, PLANES };

static void list_planes(const neph_cloud_desc *desc, int axis, double (*out)[POINTS][3]) {
  const double width_m = desc->extent_m[0], half_m = 0.5 * width_m;
  list_points(desc, axis, half_m - 1300, 0, out[HERE]);
  list_points(desc, axis, half_m - 1300 - 3 * width_m, 2 * width_m, out[FAR]);
  list_points(desc, axis, half_m - 0.25, 0, out[INNER]);
  list_points(desc, axis, half_m + 0.25, 0, out[OUTER]);
  list_points(desc, axis, 0, 0, out[MIDDLE]);
}

/* Planes across both axes, of one field. */
static void eval_planes(neph_context *context, const neph_cloud_desc *desc, float (*out)[PLANES][POINTS]) {
  static double at_m[2][PLANES][POINTS][3];
  for (int axis = 0; axis < 2; axis++) list_planes(desc, axis, at_m[axis]);
  assert_int_equal(neph_cloud_eval(context, desc, no_curve_m, 2 * PLANES * POINTS, ***at_m, **out), NEPH_OK);
}

/* Positions a whole number of tiles apart are one, to the bit. Over 50 cm across the border the model changes as it
 * does elsewhere: less than a twentieth of its mean, where planes with nothing in common differ by about as much as the
 * mean. There is cloud at the border. */
static void borders_meet(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  for (int p = 0; p < PRESETS; p++) {
    const neph_cloud_desc desc = make_tile(context, presets[p]);
    static float both[2][PLANES][POINTS];
    eval_planes(context, &desc, both);
    for (int axis = 0; axis < 2; axis++) {
      float(*planes)[POINTS] = both[axis];
      assert_memory_equal(planes[HERE], planes[FAR], sizeof *planes);
      const double mean = compute_mean(planes[INNER]), change = compute_change(planes[INNER], planes[OUTER]);
      print_message("%-20s %d: mean %.3g, change %.3g, to the middle %.3g 1/m\n", presets[p], axis, mean, change,
                    compute_change(planes[INNER], planes[MIDDLE]));
      if (!(mean > 2e-3 * desc.extinction_per_m)) fail_msg("%s: no cloud at the border: %g 1/m", presets[p], mean);
      if (!(change < 0.05 * mean)) fail_msg("%s: %g of %g 1/m change at border %d", presets[p], change, mean, axis);
      assert_true(compute_change(planes[INNER], planes[MIDDLE]) > 2.0 * change);
    }
  }
  neph_context_destroy(context);
}

/* Straight lines between voxels: where two copies meet, half-way between their voxels, the sum is the mean of both. */
static void copies_add_up_across_a_border(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  const neph_cloud_desc desc = make_tile(context, "stratocumulus");
  neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  neph_volume *volume;
  bake.planet_radius_m = no_curve_m;
  bake.precision = NEPH_PRECISION_FLOAT;
  assert_int_equal(neph_cloud_bake(context, &desc, &bake, &volume), NEPH_OK);
  np_instance one = {.bricks = &volume->bricks, .extinction_per_value = 1.0f}, other;
  assert_true(np_affine_invert(&volume->index_to_world, &one.world_to_index));
  other = one;
  other.world_to_index.m[0][3] -= desc.extent_m[0] / desc.voxel_m;
  const double half_m = 0.5 * desc.extent_m[0], step_m = desc.voxel_m;
  int cloudy = 0;
  for (int n = 0; n < 40 * 8; n++) {
    const double y = step_m * (n / 8 - 20 + 0.5), z = desc.base_altitude_m + step_m * (n % 8 + 0.5);
    const float sum = np_instance_extinction(&one, np_dvec3_make(half_m, y, z)) +
                      np_instance_extinction(&other, np_dvec3_make(half_m, y, z));
    const float low = np_instance_extinction(&one, np_dvec3_make(half_m - 0.5 * step_m, y, z));
    const float high = np_instance_extinction(&one, np_dvec3_make(-half_m + 0.5 * step_m, y, z));
    assert_near((double)sum, 0.5 * ((double)low + (double)high), 1e-5);
    cloudy += sum > 0.001f;
  }
  assert_true(cloudy > 40);
  neph_volume_release(volume);
  neph_context_destroy(context);
}

/* Every tile's base is at its altitude over the sphere, in the middle and at its border but for what a plane of 3 km
 * leaves, 0.7 m; and corners of neighbours are less than 2 m apart. */
static void check_tiles(neph_context *context, double east_m_s, double north_m_s) {
  static const double radius_m = 6360e3;
  np_scene_cloud cloud = {.is_baked = true, .bake = NEPH_CLOUD_DESC_DEFAULT};
  cloud.bake.extent_m[0] = cloud.bake.extent_m[1] = 6000;
  cloud.bake.repeat_m = 120e3;
  cloud.bake.wind_m_s[0] = east_m_s;
  cloud.bake.wind_m_s[1] = north_m_s;
  assert_int_equal(np_cloud_places_repeat(context, radius_m, &cloud), NEPH_OK);
  assert_in_range(cloud.place_count, 1230, 1280); /* 400 π */
  double farthest_m = 0;
  for (unsigned i = 0; i < cloud.place_count; i++) {
    const np_affine way = np_cloud_place_get_affine(&cloud.place[i]);
    const np_dvec3 base = np_affine_point(&way, np_dvec3_make(0, 0, 1200));
    const np_dvec3 edge = np_affine_point(&way, np_dvec3_make(3000, 0, 1200));
    assert_near(np_altitude(base, radius_m), 1200, 1e-3);
    assert_near(np_altitude(edge, radius_m), 1200, 0.75);
    farthest_m = fmax(farthest_m, hypot(base.x, base.y));
    if (i == 0) continue;
    const np_affine before = np_cloud_place_get_affine(&cloud.place[i - 1]);
    const np_dvec3 last = np_affine_point(&before, np_dvec3_make(0, 0, 1200));
    if (np_dvec3_length(np_dvec3_subtract(base, last)) > 6100) continue; /* another row */
    const np_dvec3 mine = np_affine_point(&way, np_dvec3_make(-3000, 3000, 1800));
    const np_dvec3 its = np_affine_point(&before, np_dvec3_make(3000, 3000, 1800));
    assert_true(np_dvec3_length(np_dvec3_subtract(mine, its)) < 2.0);
  }
  assert_in_range((int)farthest_m, 117000, 120000);
  np_cloud_places_clear(context, &cloud);
}

static void tiles_follow_the_sphere(void **state) {
  (void)state;
  neph_context *context = test_context_create(1, NULL);
  check_tiles(context, 0, 0);
  check_tiles(context, 0, 8);
  check_tiles(context, 3, 4);
  check_tiles(context, -3, 4);
  neph_context_destroy(context);
}

/* A wind along neither axis turns the tile: what is baked is the field with that wind along x, its skew turned as well,
 * and the tiles stand with their x along the wind. */
static void a_slanting_wind_turns_the_tiles(void **state) {
  (void)state;
  neph_context *context = test_context_create(1, NULL);
  np_scene_cloud cloud = {.is_baked = true};
  cloud.bake = make_tile(context, "stratocumulus");
  neph_cloud_desc along = cloud.bake;
  along.wind_m_s[0] = 5;
  along.wind_m_s[1] = 0;
  along.skew_m[0] = 200;
  along.skew_m[1] = 100;
  cloud.bake.wind_m_s[0] = 3;
  cloud.bake.wind_m_s[1] = 4;
  cloud.bake.skew_m[0] = 0.6 * 200 - 0.8 * 100;
  cloud.bake.skew_m[1] = 0.8 * 200 + 0.6 * 100;
  static double at_m[POINTS][3];
  static float turned[POINTS], straight[POINTS];
  list_points(&along, 0, 300, 0, at_m);
  assert_int_equal(neph_cloud_eval(context, &cloud.bake, no_curve_m, POINTS, *at_m, turned), NEPH_OK);
  assert_int_equal(neph_cloud_eval(context, &along, no_curve_m, POINTS, *at_m, straight), NEPH_OK);
  assert_true(compute_mean(straight) > 0);
  assert_true(compute_change(turned, straight) < 1e-5 * compute_mean(straight));
  assert_int_equal(np_cloud_places_repeat(context, 6360e3, &cloud), NEPH_OK);
  const np_affine way = np_cloud_place_get_affine(&cloud.place[cloud.place_count / 2]);
  const np_dvec3 end = np_affine_point(&way, np_dvec3_make(1000, 0, 0));
  assert_near(end.x, 600, 1e-6);
  assert_near(end.y, 800, 1e-6);
  np_cloud_places_clear(context, &cloud);
  neph_context_destroy(context);
}

static void a_tile_has_the_same_bits_with_any_threads(void **state) {
  (void)state;
  np_sparse_grid grids[2];
  neph_context *contexts[2];
  for (int k = 0; k < 2; k++) {
    contexts[k] = test_context_create(k ? 3 : 1, NULL);
    const neph_cloud_desc desc = make_tile(contexts[k], "cumulus_mediocris");
    grids[k] = test_bake(contexts[k], &desc);
  }
  assert_int_equal(grids[0].leaf_count, grids[1].leaf_count);
  assert_memory_equal(grids[0].leaves, grids[1].leaves, grids[0].leaf_count * sizeof *grids[0].leaves);
  for (int k = 0; k < 2; k++) np_sparse_grid_clear(&grids[k]), neph_context_destroy(contexts[k]);
}

/* ---- Levels ---- */

static neph_volume *bake_levels(neph_context *context, const neph_cloud_desc *desc, unsigned count) {
  neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  neph_volume *volume;
  np_monitor monitor;
  bake.planet_radius_m = no_curve_m;
  bake.precision = NEPH_PRECISION_FLOAT;
  assert_int_equal(neph_cloud_bake(context, desc, &bake, &volume), NEPH_OK);
  np_monitor_start(&monitor, context, NULL, NULL);
  assert_int_equal(np_volume_add_coarser(volume, count, NEPH_PRECISION_FLOAT, &monitor), NEPH_OK);
  assert_int_equal(np_volume_count_parts(volume), count);
  return volume;
}

/* A level in its place, and `tiles` tiles farther east. */
static np_instance place_level(const neph_volume *volume, unsigned level, const neph_cloud_desc *desc, int tiles) {
  const neph_volume *part = np_volume_get_part(volume, level);
  np_instance out = {.bricks = &part->bricks, .extinction_per_value = 1.0f};
  assert_true(np_affine_invert(&part->index_to_world, &out.world_to_index));
  out.world_to_index.m[0][3] -= tiles * desc->extent_m[0] / ldexp(desc->voxel_m, (int)level);
  return out;
}

/* Extinction times volume of a tile, by the middles of cells of half a voxel, in a box wider by 500 m. */
static double integrate(const np_instance *at, const neph_cloud_desc *desc, double step_m) {
  const double margin_m = 500.0;
  const int side = (int)((desc->extent_m[0] + 2.0 * margin_m) / step_m),
            height = (int)((desc->thickness_m + 2.0 * margin_m) / step_m);
  double sum = 0.0;
  for (int n = 0; n < side * side * height; n++) {
    const double x = step_m * (n / height / side + 0.5) - 0.5 * desc->extent_m[0] - margin_m;
    const double y = step_m * (n / height % side + 0.5) - 0.5 * desc->extent_m[0] - margin_m;
    const double z = desc->base_altitude_m + step_m * (n % height + 0.5) - margin_m;
    sum += (double)np_instance_extinction(at, np_dvec3_make(x, y, z));
  }
  return sum * step_m * step_m * step_m;
}

/* A level is the mean of the one before, and its interpolant is integrated exactly where all cells of half a voxel are
 * summed by their middles: rounding of floats is all that is left. */
static void levels_of_copies_keep_all_matter(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = make_tile(context, "stratocumulus");
  desc.extent_m[0] = desc.extent_m[1] = 2000;
  neph_volume *volume = bake_levels(context, &desc, 3);
  double sums[3];
  for (unsigned k = 0; k < 3; k++) {
    const np_instance at = place_level(volume, k, &desc, 0);
    sums[k] = integrate(&at, &desc, 0.5 * desc.voxel_m);
    print_message("level %u: %.9g m²\n", k, sums[k]);
    assert_near(sums[k] / sums[0], 1.0, 1e-5);
  }
  assert_true(sums[0] > 0.0);
  neph_volume_release(volume);
  neph_context_destroy(context);
}

/* Copies of two levels share a border: over it they add up to what both have on the mean. A twentieth: voxels of the
 * coarser one reach a quarter of one across it. */
static void copies_of_two_levels_meet(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = make_tile(context, "stratocumulus");
  neph_volume *volume = bake_levels(context, &desc, 2);
  const np_instance fine = place_level(volume, 0, &desc, 0), coarse = place_level(volume, 1, &desc, 1),
                    same = place_level(volume, 0, &desc, 1);
  enum { STEPS = 64 };
  double mixed = 0.0, alike = 0.0;
  const double step_m = 4.0 * desc.voxel_m / STEPS;
  for (int n = 0; n < STEPS * 32 * 12; n++) {
    const double x = 0.5 * desc.extent_m[0] + step_m * (n % STEPS + 0.5 - STEPS / 2);
    const double y = desc.voxel_m * (n / STEPS % 32 * 2 - 32),
                 z = desc.base_altitude_m + desc.voxel_m * (n / STEPS / 32);
    const np_dvec3 at = np_dvec3_make(x, y, z);
    const double own = (double)np_instance_extinction(&fine, at);
    mixed += own + (double)np_instance_extinction(&coarse, at);
    alike += own + (double)np_instance_extinction(&same, at);
  }
  print_message("across the border: %.6g, of one level %.6g\n", mixed, alike);
  assert_true(alike > 0.0);
  assert_near(mixed / alike, 1.0, 0.05);
  neph_volume_release(volume);
  neph_context_destroy(context);
}

/* Voxels span 0.004 at most where they are not the smallest: those of 125 m from 31.25 km on, of 250 m from 62.5 km. */
static void far_copies_are_coarser(void **state) {
  (void)state;
  neph_context *context = test_context_create(1, NULL);
  static char name[] = "tiles";
  np_scene_cloud cloud = {.name = name, .is_baked = true};
  cloud.bake = make_tile(context, "stratocumulus");
  cloud.bake.repeat_m = 90e3;
  assert_int_equal(np_cloud_places_repeat(context, 1e12, &cloud), NEPH_OK);
  np_cloud_parts parts = {.volume = bake_levels(context, &cloud.bake, 3)};
  const np_lod_viewers viewers = {.angle_rad = 0.004};
  const double half_m = 0.5 * cloud.bake.extent_m[0], low_m = cloud.bake.base_altitude_m;
  const np_placement origin = {.world.bricks = &parts.volume->bricks,
                               .world.world_to_index = parts.volume->world_to_index,
                               .index_to_world = parts.volume->index_to_world,
                               .bounds_min = {-half_m, -half_m, low_m},
                               .bounds_max = {half_m, half_m, low_m}};
  np_dvec3 low = {0, 0, 0}, high = {0, 0, 0};
  unsigned counts[3] = {0, 0, 0};
  assert_int_equal(np_copies_make(context, &cloud, &origin, &viewers, &parts, &low, &high), NEPH_OK);
  for (unsigned i = 0; i < parts.copy_count; i++) {
    const double *at = cloud.place[i].position_m;
    const double away_m = hypot(hypot(fmax(fabs(at[0]) - half_m, 0.0), fmax(fabs(at[1]) - half_m, 0.0)), low_m);
    assert_int_equal(parts.copies[i].part, away_m < 31250.0 ? 0 : away_m < 62500.0 ? 1 : 2);
    counts[parts.copies[i].part]++;
  }
  print_message("%u, %u and %u copies\n", counts[0], counts[1], counts[2]);
  for (int k = 0; k < 3; k++) assert_true(counts[k] > 0);
  np_copies_clear(context, &parts);
  neph_volume_release(parts.volume);
  np_cloud_places_clear(context, &cloud);
  neph_context_destroy(context);
}

/* ---- Scenes ---- */

static const char scene[] =
    "version: 1\n"
    "camera: {position: [0 m, 0 m, 600 m], look_at: [7 km, 20 km, 1.6 km], fov: 50 deg, resolution: [24, 14]}\n"
    "sun: {elevation: 40 deg, azimuth: 120 deg}\n"
    "atmosphere: {tolerance: 0.1}\n"
    "clouds:\n"
    "  - {detail: none,\n"
    "     bake: {model: deck, extent: 4 km, voxel: 100 m, coverage: 0.7, cell: 1 km, seed: 3, repeat: 16 km}}\n"
    "render: {integrator: path, samples: 4, light_memory: 400 MB, light_residual: 0.01}\n";

/* Pictures of one field in its copies and levels share bakes and tables by a cache, which holds the bits of a bake. */
static int set_up(void **state) { return set_up_scene_cached(state, 2, scene); }

enum { PIXELS = 24 * 14 };

static double render(fixture *f, float out[PIXELS]) {
  neph_image *image;
  double sum = 0;
  assert_int_equal(neph_render_image(f->scene, NULL, &image), NEPH_OK);
  const float *green = neph_image_get_channel(image, "G");
  assert_non_null(green);
  for (int i = 0; i < PIXELS; i++) sum += (double)(out[i] = green[i]);
  neph_image_destroy(image);
  return sum / PIXELS;
}

/* Tiles turned by a slanting wind. The march's own bias on a deck is some 5 %; 12 % holds it with the noise of 4 paths
 * a pixel. A field that ends 2 km off leaves the sky of this view clear. */
static void both_integrators_render_tiles(void **state) {
  fixture *f = *state;
  float traced[PIXELS], marched[PIXELS], alone[PIXELS];
  set(f, "clouds[0].bake.wind", "[3 m/s, 4 m/s]");
  const double mean = render(f, traced);
  set(f, "render.integrator", "march");
  assert_near(render(f, marched) / mean, 1.0, 0.12);
  set(f, "clouds[0].bake.repeat", "0 m");
  (void)render(f, alone);
  double change2 = 0;
  for (int i = 0; i < PIXELS; i++) change2 += pow((double)(alone[i] - marched[i]), 2);
  print_message("path %g, change without tiles %g\n", mean, sqrt(change2 / PIXELS));
  assert_true(sqrt(change2 / PIXELS) > 0.15 * mean);
}

/* A file holds the smallest voxels alone and is not baked again when the camera moves; its voxels of 35 m are rounded
 * to 35.7 m. Voxels as wide as a pixel, 2° here, smooth the deck: with 256 paths a pixel, of two seeds, the mean falls
 * by 2.5 %, in the march by 2.2 %, for which 4 % leaves room; three standard errors of 64 paths a pixel are 5 % more.
 */
static void copies_in_levels_render(void **state) {
  fixture *f = *state;
  static const char *const integrators[] = {"path", "march"};
  char *folder = test_folder_create(), *path = test_path(folder, "tile.vdb"),
       *second = test_path(folder, "tile.lod1.vdb");
  float values[PIXELS];
  set(f, "clouds[0].bake.voxel", "35 m");
  set(f, "render.detail", "0");
  set(f, "render.light_memory", "50 MB");
  set(f, "render.light_degree", "3");
  set(f, "render.light_residual", "0.01");
  for (int i = 0; i < 2; i++) {
    set(f, "render.integrator", integrators[i]);
    set(f, "render.samples", i ? "4" : "64");
    set(f, "clouds[0].albedo", i ? "1" : "0.9"); /* paths end soon */
    set(f, "clouds[0].bake.levels", "1");
    const double alone = render(f, values);
    set(f, "clouds[0].bake.levels", "3");
    set(f, "clouds[0].bake.level_pixels", "1");
    const double levels = render(f, values);
    set(f, "clouds[0].vdb", path);
    const double baked = render(f, values);
    set(f, "camera.position", "[0 m, 10 m, 600 m]");
    set(f, "render.samples", "1"); /* only the messages matter */
    set(f, "render.multiple_scattering", "none");
    test_log_clear(&f->log);
    (void)render(f, values);
    assert_null(strstr(f->log.text, "rebaked"));
    set(f, "camera.position", "[0 m, 0 m, 600 m]");
    set(f, "render.multiple_scattering", "ordinates");
    print_message("%-5s %.6g, in levels %.6g, of a file %.6g\n", integrators[i], alone, levels, baked);
    assert_near(levels / alone, 1.0, i ? 0.04 : 0.09);
    assert_near(baked / levels, 1.0, i ? 0.002 : 0.05);
    assert_true(levels != alone);
  }
  assert_int_not_equal(access(second, R_OK), 0);
  free(second);
  free(path);
  test_folder_destroy(folder);
}

static void what_cannot_repeat_is_refused(void **state) {
  fixture *f = *state;
  static const struct {
    const char *key, *value, *message;
  } bad[] = {
      {"clouds[0].bake.model", "fog", "follows the ground"},
      {"clouds[0].bake.model", "lenses", "must be cells, slab, thermals, deck or streaks"},
      {"clouds[0].bake.model", "trails", "lines across the whole field"},
      {"clouds[0].bake.model", "hero", "one cloud in the middle"},
      {"clouds[0].bake.extent", "[4 km, 5 km]", "extent must be square"},
      {"clouds[0].bake.center", "[1 km, 0 km]", "center must be"},
      {"clouds[0].bake.precipitation", "0.5", "precipitation must be 0"},
      {"clouds[0].bake.ground_cover", "0.5", "tiles are alike"},
      {"clouds[0].bake.wind", "[3 m/s, 4 m/s]", NULL},
      {"clouds[0].rotation", "30 deg", "exclude each other"},
      {"clouds[0].position", "[0 m, 0 m, 2 km]", "exclude each other"},
      {"clouds[0].bake.repeat", "1000 km", NULL},
      {"clouds[0].bake.extent", "1 km", "at most 499000 m"},
  };
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
    neph_scene *other = NULL;
    neph_image *image = NULL;
    assert_int_equal(neph_scene_load_text(f->context, scene, "dir/scene.yaml", &other), NEPH_OK);
    test_log_clear(&f->log);
    neph_result result = NEPH_OK;
    if (bad[i].message && strstr(bad[i].message, "at most"))
      result = neph_scene_set(other, "clouds[0].bake.repeat", "900 km");
    if (!result) result = neph_scene_set(other, bad[i].key, bad[i].value);
    if (!result && bad[i].message) result = neph_render_image(other, NULL, &image);
    if (bad[i].message && !result) fail_msg("%s: %s was taken", bad[i].key, bad[i].value);
    if (bad[i].message && !strstr(f->log.text, bad[i].message)) fail_msg("%s: %s", bad[i].key, f->log.text);
    neph_scene_destroy(other);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(borders_meet),
      cmocka_unit_test(copies_add_up_across_a_border),
      cmocka_unit_test(tiles_follow_the_sphere),
      cmocka_unit_test(a_slanting_wind_turns_the_tiles),
      cmocka_unit_test(a_tile_has_the_same_bits_with_any_threads),
      cmocka_unit_test(levels_of_copies_keep_all_matter),
      cmocka_unit_test(copies_of_two_levels_meet),
      cmocka_unit_test(far_copies_are_coarser),
      cmocka_unit_test_setup_teardown(both_integrators_render_tiles, set_up, tear_down),
      cmocka_unit_test_setup_teardown(copies_in_levels_render, set_up, tear_down),
      cmocka_unit_test_setup_teardown(what_cannot_repeat_is_refused, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

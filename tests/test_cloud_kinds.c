/* SPDX-License-Identifier: Apache-2.0 */
/* Fog, lenses and trails, and clouds over ground that a caller gives. */
#include "test_clouds.h"

#include "cloud/bake_file.h"
#include "test_scenes.h"

/* A ridge along y, 600 m high, 1 km east of the middle; half a kilometre off it the ground is flat. */
static double get_ridge_m(void *user, double x_m, double y_m) {
  const double off = fabs(x_m - 1000) / 500;
  (void)y_m;
  if (user) ++*(atomic_int *)user;
  return off < 1 ? 600 * (1 - off) : 0;
}

static double get_nothing_m(void *user, double x_m, double y_m) {
  (void)user, (void)x_m, (void)y_m;
  return (double)NAN;
}

static neph_cloud_desc make_kind(neph_context *context, const char *preset) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(context, preset, &desc), NEPH_OK);
  desc.extent_m[0] = desc.extent_m[1] = 6000;
  desc.voxel_m = 50;
  return desc;
}

/* Sums of extinction and of extinction times x, the lowest and the highest voxel, between two x. */
typedef struct slice {
  double sum, moment, base_m, top_m;
} slice;

static slice sum_slice(const np_sparse_grid *grid, const neph_cloud_desc *desc, double low_m, double high_m) {
  slice s = {0, 0, INFINITY, -INFINITY};
  for (size_t l = 0; l < grid->leaf_count; l++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const np_leaf *leaf = &grid->leaves[l];
      const double x_m = grid->index_to_world.m[0][3] + desc->voxel_m * (leaf->origin[0] + n / 64);
      if (!(leaf->values[n] > 0) || x_m < low_m || x_m >= high_m) continue;
      s.sum += (double)leaf->values[n];
      s.moment += (double)leaf->values[n] * x_m;
      const double z_m = grid->index_to_world.m[2][3] + desc->voxel_m * (leaf->origin[2] + n % 8);
      s.base_m = fmin(s.base_m, z_m);
      s.top_m = fmax(s.top_m, z_m);
    }
  return s;
}

static void fog_fills_low_ground_to_its_top(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = make_kind(context, "fog");
  desc.thickness_m = 400;
  desc.coverage = 1;
  desc.ground_height = get_ridge_m;
  np_sparse_grid grid = test_bake(context, &desc);
  const slice low = sum_slice(&grid, &desc, -1000, 0), high = sum_slice(&grid, &desc, 900, 1100);
  assert_true(low.sum > 0);
  assert_true(low.top_m > 250 && low.top_m < 400);
  assert_true(high.sum == 0); /* 480 m and more, above the top */
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

/* The first crest lies over the ridge, the wind's side first: the middle of the cloud within a third of a wavelength.
 */
static void lenses_stand_over_the_ridge(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = make_kind(context, "altocumulus_lenticularis");
  desc.ground_height = get_ridge_m;
  desc.skew_m[0] = 0;
  desc.cell_m = 3000;
  desc.thickness_m = 600;
  desc.voxel_m = 40;
  np_sparse_grid grid = test_bake(context, &desc);
  const slice all = sum_slice(&grid, &desc, -1e4, 1e4);
  assert_true(all.sum > 0);
  assert_near(all.moment / all.sum, 1000, 1000);
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

/* Mean extinction of a few heights in a column of the field. */
static double compute_column(const np_cloud_model *model, double x_m, double y_m) {
  enum { HEIGHTS = 40 };
  float x[HEIGHTS], y[HEIGHTS], height[HEIGHTS], extinction[HEIGHTS];
  double sum = 0;
  for (int k = 0; k < HEIGHTS; k++) {
    x[k] = (float)x_m, y[k] = (float)y_m;
    height[k] = ((float)k + 0.5f) / HEIGHTS * (float)model->desc.thickness_m;
  }
  np_cloud_model_eval(model, &(np_cloud_points){HEIGHTS, x, y, height}, extinction);
  for (int k = 0; k < HEIGHTS; k++) sum += (double)extinction[k] / HEIGHTS;
  return sum;
}

/* Extinction from the border inwards, in shares of the field: no wall, but a rim that thickens. */
static void fog_thins_out_to_the_border(void **state) {
  (void)state;
  static const double insets[] = {0.005, 0.02, 0.05, 0.09, 0.2};
  enum { INSETS = sizeof insets / sizeof *insets, ROWS = 60 };
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = make_kind(context, "valley_stratus");
  np_cloud_model model;
  assert_int_equal(np_cloud_model_build(context, &desc, 6.36e6, NULL, &model), NEPH_OK);
  double means[INSETS] = {0};
  for (int i = 0; i < INSETS; i++)
    for (int row = 0; row < ROWS; row++)
      means[i] += compute_column(&model, (insets[i] - 0.5) * desc.extent_m[0],
                                 (0.5 * (row + 0.5) / ROWS - 0.25) * desc.extent_m[1]);
  for (int i = 0; i < INSETS; i++) print_message("%g of the field: %.3f\n", insets[i], means[i] / means[INSETS - 1]);
  assert_true(means[0] < 0.02 * means[INSETS - 1]);
  for (int i = 1; i < INSETS; i++) assert_true(means[i] > 1.2 * means[i - 1]);
  np_cloud_model_clear(&model);
  neph_context_destroy(context);
}

/* Between rows across the wind the lee outline of the first crest moves more than the other one. */
static void lenses_are_ragged_on_the_lee(void **state) {
  (void)state;
  enum { ROWS = 80, STEPS = 120 };
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(context, "altocumulus_lenticularis", &desc), NEPH_OK);
  np_cloud_model model;
  desc.skew_m[0] = 0;
  assert_int_equal(np_cloud_model_build(context, &desc, 6.36e6, NULL, &model), NEPH_OK);
  double moved[2] = {0, 0};
  int before[2] = {0, 0};
  for (int row = 0; row < ROWS; row++) {
    int ends[2] = {-1, -1};
    for (int i = 0; i < STEPS; i++) {
      if (!(compute_column(&model, (0.9 * i / STEPS - 0.6) * desc.cell_m, (0.4 * row / ROWS - 0.2) * desc.cell_m) > 0))
        continue;
      if (ends[0] < 0) ends[0] = i;
      ends[1] = i;
    }
    assert_true(ends[0] >= 0);
    for (int e = 0; e < 2; e++) {
      if (row > 0) moved[e] += abs(ends[e] - before[e]);
      before[e] = ends[e];
    }
  }
  print_message("outline moves by %g before the ridge, %g behind it\n", moved[0], moved[1]);
  assert_true(moved[1] > 2 * moved[0]);
  np_cloud_model_clear(&model);
  neph_context_destroy(context);
}

enum { FACE_SIDE = 220 };

/* The lower face of ice over clear air, voxel by voxel; 0 where there is none, or a tower among it, which is denser. */
static float *list_overhangs(const np_sparse_grid *grid, int32_t from, int32_t clear, float densest) {
  float *face = calloc((size_t)FACE_SIDE * FACE_SIDE, sizeof *face);
  int32_t *highest = calloc((size_t)FACE_SIDE * FACE_SIDE, sizeof *highest);
  for (size_t l = 0; l < grid->leaf_count; l++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const np_leaf *leaf = &grid->leaves[l];
      const int32_t i = leaf->origin[0] + n / 64, j = leaf->origin[1] + n / 8 % 8, k = leaf->origin[2] + n % 8;
      if (i < 0 || j < 0 || i >= FACE_SIDE || j >= FACE_SIDE || !(leaf->values[n] > 1e-3f)) continue;
      float *at = &face[j * FACE_SIDE + i];
      int32_t *below = &highest[j * FACE_SIDE + i];
      if (k < from && k > *below) *below = k;
      if (k >= from && leaf->values[n] > densest) *below = INT32_MAX / 2;
      if (k >= from && (*at == 0 || (float)k < *at)) *at = (float)k;
    }
  for (int32_t n = 0; n < FACE_SIDE * FACE_SIDE; n++)
    if (face[n] < (float)(highest[n] + clear) || face[n] <= (float)from + 1) face[n] = 0;
  free(highest);
  return face;
}

enum { POUCH_REACH = 3, POUCH_SIDE = 2 * POUCH_REACH + 1 };

/* Depth of a place of the lower face below the mean around it, which slopes do not change; 0 near its border. */
static float compute_bulge(const float *face, int32_t i, int32_t j) {
  float sum = 0;
  for (int n = 0; n < POUCH_SIDE * POUCH_SIDE; n++) {
    const int32_t x = i + n % POUCH_SIDE - POUCH_REACH, y = j + n / POUCH_SIDE - POUCH_REACH;
    if (x < 0 || y < 0 || x >= FACE_SIDE || y >= FACE_SIDE || !(face[y * FACE_SIDE + x] > 0)) return 0;
    sum += face[y * FACE_SIDE + x];
  }
  return sum / (POUCH_SIDE * POUCH_SIDE) - face[j * FACE_SIDE + i];
}

/* Middles of the runs of cloud in a column, and their number. */
static int count_sheets(const np_cloud_model *model, double x_m, double y_m, double middles_m[16]) {
  enum { HEIGHTS = 500 };
  static float x[HEIGHTS], y[HEIGHTS], height[HEIGHTS], extinction[HEIGHTS];
  int count = 0, begin = -1;
  for (int k = 0; k < HEIGHTS; k++) {
    x[k] = (float)x_m, y[k] = (float)y_m;
    height[k] = ((float)k + 0.5f) / HEIGHTS * (float)model->desc.thickness_m;
  }
  np_cloud_model_eval(model, &(np_cloud_points){HEIGHTS, x, y, height}, extinction);
  for (int k = 0; k <= HEIGHTS; k++) {
    const bool is_cloud = k < HEIGHTS && extinction[k] > 0;
    if (is_cloud && begin < 0) begin = k;
    if (is_cloud || begin < 0) continue;
    if (count < 16) middles_m[count] = 0.5 * (begin + k) / HEIGHTS * model->desc.thickness_m;
    count++;
    begin = -1;
  }
  return count;
}

/* Largest deviation of the distances between sheets from their mean, in a column near the rim of a pile; −1: no column
 * cuts all of its lenses apart. */
static double measure_pitches(const np_cloud_model *model) {
  enum { STEPS = 400 };
  const int wanted = (int)model->desc.sublayers;
  double middles_m[16];
  for (int step = 0; step < STEPS; step++) {
    if (count_sheets(model, (0.9 * step / STEPS - 0.6) * model->desc.cell_m, 0, middles_m) != wanted) continue;
    const double mean_m = (middles_m[wanted - 1] - middles_m[0]) / (wanted - 1);
    double most = 0;
    for (int k = 1; k < wanted; k++) most = fmax(most, fabs((middles_m[k] - middles_m[k - 1]) / mean_m - 1));
    return most;
  }
  return -1;
}

/* Lenses of a pile are not as far apart from each other: over seeds, the distance that differs most from the mean does
 * so by some 40 %. */
static void lenses_of_a_pile_are_unequal(void **state) {
  (void)state;
  enum { SEEDS = 24 };
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(context, "altocumulus_lenticularis", &desc), NEPH_OK);
  desc.skew_m[0] = desc.erosion = desc.softness = 0;
  double sum = 0, most = 0;
  int piles = 0;
  for (desc.seed = 1; desc.seed <= SEEDS; desc.seed++) {
    np_cloud_model model;
    assert_int_equal(np_cloud_model_build(context, &desc, 6.36e6, NULL, &model), NEPH_OK);
    const double deviation = measure_pitches(&model);
    np_cloud_model_clear(&model);
    if (deviation < 0) continue;
    sum += deviation, piles++;
    most = fmax(most, deviation);
  }
  print_message("%d piles: pitches deviate by %.2f at most on the mean, %.2f in one\n", piles, sum / piles, most);
  assert_true(piles >= SEEDS / 2);
  assert_near(sum / piles, 0.35, 0.12);
  assert_true(most < 0.8);
  neph_context_destroy(context);
}

/* Pouches under the overhang of an anvil bulge most within 270 m, and by more than a voxel. They are 400 to 800 m
 * apart, as wide as mammatus at least are, and bulge by 100 to 500 m over their mean: lobes are half a kilometre long
 * (Schultz et al. 2006). A face without pouches has bulges at its rim, 0.9 km apart. */
static void anvils_carry_mammatus(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = make_kind(context, "cumulonimbus");
  desc.extent_m[0] = desc.extent_m[1] = 18e3;
  desc.voxel_m = 90;
  desc.seed = 3;
  desc.precipitation = 0;
  np_sparse_grid grid = test_bake(context, &desc);
  float *face =
      list_overhangs(&grid, (int32_t)(0.5 * desc.thickness_m / desc.voxel_m), 10, 0.3f * (float)desc.extinction_per_m);
  double pouches = 0, columns = 0, depth_m = 0;
  for (int32_t j = 0; j < FACE_SIDE; j++)
    for (int32_t i = 0; i < FACE_SIDE; i++) {
      const float here = compute_bulge(face, i, j);
      float most = 0;
      for (int n = 0; n < POUCH_SIDE * POUCH_SIDE; n++)
        most = fmaxf(most, compute_bulge(face, i + n % POUCH_SIDE - POUCH_REACH, j + n / POUCH_SIDE - POUCH_REACH));
      columns += here != 0;
      if (here == most && here > 1) pouches++, depth_m += (double)here * desc.voxel_m;
    }
  const double apart_m = desc.voxel_m * sqrt(columns / fmax(pouches, 1));
  print_message("%g pouches under %g columns, %.0f m apart, %.0f m deep\n", pouches, columns, apart_m,
                depth_m / pouches);
  assert_true(pouches >= 20);
  assert_true(apart_m > 400 && apart_m < 800);
  assert_true(depth_m / pouches > 100 && depth_m / pouches < 500);
  free(face);
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

enum { SHEET_SIDE = 60, SHEET_HEIGHTS = 40, STORMS = 8 };

static np_cloud_model build_storm(neph_context *context, uint64_t seed) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  np_cloud_model model;
  assert_int_equal(neph_cloud_get_preset(context, "cumulonimbus", &desc), NEPH_OK);
  desc.seed = seed;
  desc.voxel_m = 200;
  desc.precipitation = 0;
  assert_int_equal(np_cloud_model_build(context, &desc, 6.36e6, NULL, &model), NEPH_OK);
  return model;
}

/* Counts columns with ice above 0.6 of the thickness and clear air for a fifth of it below, and those of them whose
 * optical depth is below 1. */
static void count_thin_ice(const np_cloud_model *model, int *columns, int *thin) {
  float x[SHEET_HEIGHTS], y[SHEET_HEIGHTS], height[SHEET_HEIGHTS], extinction[SHEET_HEIGHTS];
  const float step_m = (float)model->desc.extent_m[0] / SHEET_SIDE, top_m = (float)model->desc.thickness_m;
  for (int column = 0; column < SHEET_SIDE * SHEET_SIDE; column++) {
    double ice = 0, below = 0;
    for (int k = 0; k < SHEET_HEIGHTS; k++) {
      x[k] = ((float)(column % SHEET_SIDE) + 0.5f) * step_m - 0.5f * (float)model->desc.extent_m[0];
      y[k] = ((float)(column / SHEET_SIDE) + 0.5f) * step_m - 0.5f * (float)model->desc.extent_m[1];
      height[k] = ((float)k + 0.5f) / SHEET_HEIGHTS * top_m;
    }
    np_cloud_model_eval(model, &(np_cloud_points){SHEET_HEIGHTS, x, y, height}, extinction);
    for (int k = SHEET_HEIGHTS * 2 / 5; k < SHEET_HEIGHTS; k++)
      *(k < SHEET_HEIGHTS * 3 / 5 ? &below : &ice) += (double)(extinction[k] * top_m / SHEET_HEIGHTS);
    if (below > 0 || ice < 0.02) continue;
    ++*columns;
    *thin += ice < 1;
  }
}

/* A sheet that is as dense as its heart but for a narrow rim has depths below 1 in 0.105 of these columns; over the
 * eight storms 0.184 have. The limit is between both. */
static void anvils_thin_out(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  static const uint64_t seeds[STORMS] = {77123, 50331, 90017, 31337, 12, 13, 14, 15};
  int columns = 0, thin = 0;
  for (int i = 0; i < STORMS; i++) {
    np_cloud_model model = build_storm(context, seeds[i]);
    count_thin_ice(&model, &columns, &thin);
    np_cloud_model_clear(&model);
  }
  print_message("depth below 1 in %.3f of %d columns of anvils\n", 1.0 * thin / columns, columns);
  assert_true(columns > 1000);
  assert_true(thin > 0.17 * columns);
  neph_context_destroy(context);
}

enum { OUTLINE_ROWS = 120 };

/* Number of 250 m from a side of the field to the first anvil in a row of 7 km; −1: none. */
static int search_anvil(const np_cloud_model *model, int side, int row) {
  const float half_m = 0.5f * (float)model->desc.extent_m[0], step_m = 2 * half_m / OUTLINE_ROWS;
  const float along_m = step_m * ((float)row + 0.5f) - half_m;
  for (int i = 0; i < 28; i++) {
    const float across_m = (step_m * ((float)i + 0.5f) - half_m) * (side % 2 ? -1.0f : 1.0f);
    const np_cloud_column column =
        np_cloud_column_compute(model, side < 2 ? across_m : along_m, side < 2 ? along_m : across_m, 8500);
    if (column.anvil > 0) return i;
  }
  return -1;
}

/* An anvil that its field's border cuts ends at the same distance from it, row by row: in 0.66 of neighbouring rows of
 * twelve storms. Where each anvil fits into its field 0.535 do: outlines are parallel to the border somewhere. */
static void anvils_do_not_follow_the_border(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  int pairs = 0, equal = 0;
  for (uint64_t seed = 1; seed <= 12; seed++) {
    np_cloud_model model = build_storm(context, seed);
    for (int side = 0; side < 4; side++)
      for (int row = 0, before = -1, at; row < OUTLINE_ROWS; row++, before = at) {
        at = search_anvil(&model, side, row);
        pairs += at >= 0 && before >= 0;
        equal += at >= 0 && at == before;
      }
    np_cloud_model_clear(&model);
  }
  print_message("%.3f of %d rows of anvils end where the next one does\n", 1.0 * equal / pairs, pairs);
  assert_true(pairs > 500);
  assert_true(equal < 0.6 * pairs);
  neph_context_destroy(context);
}

/* Error of a value between two layers of voxels that is interpolated from both, over the values' root mean square, in
 * the lowest 400 m of cirrus, where the skew displaces it by eight voxels in a layer. Fibres half as long have 0.11 to
 * 0.16, and show as a lattice of dashes from below; these have 0.035 to 0.066. */
static void fibres_cross_layers_of_voxels(void **state) {
  (void)state;
  enum { SIDE = 100, LAYERS = 33 };
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(context, "cirrus", &desc), NEPH_OK);
  static const uint64_t seeds[] = {77123, 50331, 12};
  for (int s = 0; s < 3; s++) {
    np_cloud_model model;
    double errors = 0, squares = 0;
    desc.seed = seeds[s];
    assert_int_equal(np_cloud_model_build(context, &desc, 6.36e6, NULL, &model), NEPH_OK);
    for (int column = 0; column < SIDE * SIDE; column++) {
      float x[LAYERS], y[LAYERS], height[LAYERS], extinction[LAYERS];
      for (int k = 0; k < LAYERS; k++) {
        x[k] = 100 * (float)(column % SIDE) - 5000;
        y[k] = 100 * (float)(column / SIDE) - 5000;
        height[k] = 0.5f * (float)((k + 1) * desc.voxel_m);
      }
      np_cloud_model_eval(&model, &(np_cloud_points){LAYERS, x, y, height}, extinction);
      for (int k = 1; k + 1 < LAYERS; k += 2) {
        const double here = (double)extinction[k], between = 0.5 * (double)(extinction[k - 1] + extinction[k + 1]);
        errors += (here - between) * (here - between);
        squares += here * here;
      }
    }
    print_message("error between layers %.3f\n", sqrt(errors / squares));
    assert_true(squares > 0);
    assert_true(sqrt(errors / squares) < 0.085);
    np_cloud_model_clear(&model);
  }
  neph_context_destroy(context);
}

static void trails_spread_with_age(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  double before = 0;
  for (int i = 0; i <= 4; i++) {
    neph_cloud_desc desc = make_kind(context, "contrail");
    desc.coverage = 1; /* no gaps */
    desc.trails = 1;
    desc.voxel_m = 30;
    desc.age = 0.25 * i;
    const double covered = test_compute_covered(context, &desc);
    assert_true(covered > 1.05 * before);
    before = covered;
  }
  assert_true(before > 0.1 && before < 0.6);
  neph_context_destroy(context);
}

/* Cumulus, once with bases that follow the ground, once over high and once over low ground alone. */
static void ground_lifts_and_draws_clouds(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  neph_cloud_desc desc = make_kind(context, "cumulus_mediocris");
  desc.ground_height = get_ridge_m;
  desc.cell_m = 700;
  desc.billow_m = 200;
  desc.coverage = 0.2;
  double share[3];
  for (int i = 0; i < 3; i++) {
    desc.ground_cover = i - 1;
    np_sparse_grid grid = test_bake(context, &desc);
    share[i] = sum_slice(&grid, &desc, 600, 1400).sum / sum_slice(&grid, &desc, -1e4, 1e4).sum;
    np_sparse_grid_clear(&grid);
  }
  assert_true(share[0] < 0.5 * share[1]);
  assert_true(share[2] > 0.7 && share[2] > 2 * share[1]);
  desc.ground_lift = 1;
  np_sparse_grid grid = test_bake(context, &desc);
  /* 480 m of ground and more lift bases there by as much; noise of the base and the planet's curve take less than 50 m.
   */
  assert_true(sum_slice(&grid, &desc, 900, 1100).base_m > desc.base_altitude_m + 430);
  np_sparse_grid_clear(&grid);
  neph_context_destroy(context);
}

static void threads_and_levels_give_the_same_bits_over_ground(void **state) {
  (void)state;
  static const char *const presets[] = {"fog", "altocumulus_lenticularis"};
  neph_context *context = test_context_create(1, NULL);
  for (int i = 0; i < 2; i++) {
    neph_cloud_desc desc = make_kind(context, presets[i]);
    desc.ground_height = get_ridge_m;
    desc.time_s = 200;
    test_check_bits(2, &desc, 1);
  }
  neph_context_destroy(context);
}

/* A ground counts by its heights, or by the text that stands for it, and not at all where it has no part. */
static void a_ground_is_part_of_the_parameters(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(2, &log);
  char *folder = test_folder_create(), *path = test_path(folder, "fog.vdb");
  neph_cloud_desc desc = make_kind(context, "fog");
  const neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  bool is_same;
  desc.voxel_m = 100;
  desc.ground_height = get_ridge_m;
  assert_int_equal(neph_cloud_bake_file(context, &desc, NULL, "density", path), NEPH_OK);
  assert_int_equal(np_cloud_file_is_current(context, path, &desc, &bake, &is_same), NEPH_OK);
  assert_true(is_same);
  desc.ground_id = "another";
  assert_int_equal(np_cloud_file_is_current(context, path, &desc, &bake, &is_same), NEPH_OK);
  assert_false(is_same);
  assert_int_equal(neph_cloud_verify_file(context, path, NULL, NULL, &is_same), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "fog.vdb", "ground", "bake its scene");
  test_log_clear(&log);
  desc.ground_height = get_nothing_m;
  neph_volume *volume;
  assert_int_equal(neph_cloud_bake(context, &desc, NULL, &volume), NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&log, "ground_height gives nan", "must be");
  atomic_int calls = 0;
  desc = make_kind(context, "stratocumulus");
  desc.ground_height = get_ridge_m;
  desc.ground_user = &calls;
  np_sparse_grid grid = test_bake(context, &desc);
  assert_int_equal(calls, 0);
  np_sparse_grid_clear(&grid);
  assert_int_equal(remove(path), 0);
  free(path);
  test_folder_destroy(folder);
  neph_context_destroy(context);
}

static const char valley[] =
    "{camera: {position: [0, -4 km, 2 km], look_at: [0, 0, 200 m], resolution: [12, 8]}, terrain: {ridges: {relief: "
    "900 m, ridge: 3 km, samples: 65}, width: 8 km}, sun: {elevation: 40 deg}, clouds: [{name: fog, bake: {preset: "
    "valley_stratus, extent: [5 km, 5 km], voxel: 100 m, base: 0 m, top: 500 m}}], render: {samples: 1}}";

static double sum_clouds(neph_image *image) {
  const float *alpha = neph_image_get_channel(image, "A");
  double sum = 0;
  assert_non_null(alpha);
  for (int i = 0; i < 12 * 8; i++) sum += (double)alpha[i];
  return sum;
}

/* Covers both integrators; a bake of the scene equals the render's; higher mountains are another ground. */
static void a_scene_bakes_over_its_terrain(void **state) {
  fixture *f = *state;
  char *folder = test_folder_create(), *path = test_path(folder, "fog.vdb");
  for (int i = 0; i < 2; i++) {
    neph_image *image = NULL;
    set(f, "render.integrator", i ? "path" : "march");
    if (neph_render_image(f->scene, NULL, &image)) fail_msg("%s", f->log.text);
    assert_true(sum_clouds(image) > 0);
    neph_image_destroy(image);
  }
  if (neph_scene_bake_file(f->scene, 0, 1, NULL, path)) fail_msg("%s", f->log.text);
  set(f, "render.integrator", "march");
  set(f, "clouds[0].vdb", path);
  render_changed(f, "render.samples", "1");
  assert_null(strstr(f->log.text, "rebaked"));
  render_changed(f, "terrain.ridges.relief", "700 m");
  assert_non_null(strstr(f->log.text, "rebaked"));
  assert_int_equal(remove(path), 0);
  free(path);
  test_folder_destroy(folder);
}

static int set_up(void **state) { return set_up_scene(state, 2, valley); }

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(fog_fills_low_ground_to_its_top),
      cmocka_unit_test(lenses_stand_over_the_ridge),
      cmocka_unit_test(fog_thins_out_to_the_border),
      cmocka_unit_test(lenses_are_ragged_on_the_lee),
      cmocka_unit_test(lenses_of_a_pile_are_unequal),
      cmocka_unit_test(anvils_carry_mammatus),
      cmocka_unit_test(anvils_thin_out),
      cmocka_unit_test(anvils_do_not_follow_the_border),
      cmocka_unit_test(fibres_cross_layers_of_voxels),
      cmocka_unit_test(trails_spread_with_age),
      cmocka_unit_test(ground_lifts_and_draws_clouds),
      cmocka_unit_test(threads_and_levels_give_the_same_bits_over_ground),
      cmocka_unit_test(a_ground_is_part_of_the_parameters),
      cmocka_unit_test_setup_teardown(a_scene_bakes_over_its_terrain, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Streets along the wind, open and closed cells: statistics of vertical optical depth as observers give them, and of
 * pictures by both integrators. */
#include "test_clouds.h"
#include "test_scenes.h"

enum { EDGE_MAX = 400 };

/* The inner three quarters of a field, as the mean of each block of columns. */
typedef struct depth_map {
  int edge;
  double cell_m;
  float values[EDGE_MAX][EDGE_MAX];
} depth_map;

static depth_map *make_map(neph_context *context, const neph_cloud_desc *desc, int block) {
  np_sparse_grid grid = test_bake(context, desc);
  const int columns = (int)(0.75 * desc->extent_m[0] / desc->voxel_m);
  depth_map *map = calloc(1, sizeof *map);
  map->edge = columns / block;
  map->cell_m = block * desc->voxel_m;
  assert_true(map->edge <= EDGE_MAX);
  for (size_t l = 0; l < grid.leaf_count; l++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const int i = grid.leaves[l].origin[0] + n / 64 - columns / 6,
                j = grid.leaves[l].origin[1] + n / 8 % 8 - columns / 6;
      if (i < 0 || j < 0 || i / block >= map->edge || j / block >= map->edge) continue;
      map->values[i / block][j / block] += grid.leaves[l].values[n] * (float)desc->voxel_m / (float)(block * block);
    }
  np_sparse_grid_clear(&grid);
  return map;
}

static double compute_moment(const depth_map *map, double mean, int power) {
  double sum = 0;
  for (int i = 0; i < map->edge; i++)
    for (int j = 0; j < map->edge; j++) sum += pow((double)map->values[i][j] - mean, power);
  return sum / map->edge / map->edge;
}

static double compute_skewness(const depth_map *map) {
  const double mean = compute_moment(map, 0, 1);
  return compute_moment(map, mean, 3) / pow(compute_moment(map, mean, 2), 1.5);
}

/* Autocorrelation at an offset in cells, of which the first is not negative. */
static double correlate(const depth_map *map, double mean, int di, int dj) {
  double sum = 0, squares = 0;
  for (int i = 0; i < map->edge - di; i++)
    for (int j = dj < 0 ? -dj : 0; j < map->edge - (dj > 0 ? dj : 0); j++) {
      const double here = (double)map->values[i][j] - mean;
      sum += here * ((double)map->values[i + di][j + dj] - mean);
      squares += here * here;
    }
  return sum / squares;
}

static double correlate_axis(const depth_map *map, int axis, int lag) {
  return correlate(map, compute_moment(map, 0, 1), axis == 0 ? lag : 0, axis == 1 ? lag : 0);
}

/* Mean over all directions. */
static double correlate_ring(const depth_map *map, int lag) {
  const double mean = compute_moment(map, 0, 1);
  double sum = 0, count = 0;
  for (int di = 0; di <= lag; di++)
    for (int dj = -lag; dj <= lag; dj++)
      if (fabs(sqrt(di * di + dj * dj) - lag) < 0.5) sum += correlate(map, mean, di, dj), count++;
  return sum / count;
}

/* Sum of the autocorrelation along an axis up to its first zero. */
static double compute_length_m(const depth_map *map, int axis) {
  double sum = 0.5, value;
  for (int lag = 1; lag < map->edge / 2 && (value = correlate_axis(map, axis, lag)) > 0; lag++) sum += value;
  return sum * map->cell_m;
}

/* Distance of the highest autocorrelation beyond its first zero, up to a limit; in all directions for axis 2. */
static double search_period_m(const depth_map *map, int axis, double limit_m) {
  double best = -1;
  int highest = 0;
  bool is_beyond = false;
  for (int lag = 1; lag * map->cell_m < limit_m; lag++) {
    const double value = axis < 2 ? correlate_axis(map, axis, lag) : correlate_ring(map, lag);
    is_beyond = is_beyond || value < 0;
    if (is_beyond && value > best) best = value, highest = lag;
  }
  return highest * map->cell_m;
}

/* ---- Streets ---- */

static neph_cloud_desc make_streets(neph_cloud_model model, double streets) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  desc.model = model;
  desc.seed = 5;
  desc.extent_m[0] = desc.extent_m[1] = 12e3;
  desc.voxel_m = 100;
  desc.thickness_m = 600;
  desc.cell_m = 800;
  desc.billow_m = 300;
  desc.coverage = 0.25;
  desc.streets = streets;
  return desc;
}

/* Streets are much longer than wide, 2 cells apart; without them no direction is preferred. Over a field of some nine
 * streets lengths vary by a third from seed to seed. */
static void streets_lie_along_the_wind(void **state) {
  (void)state;
  static const neph_cloud_model models[] = {NEPH_CLOUD_MODEL_THERMALS, NEPH_CLOUD_MODEL_CELLS, NEPH_CLOUD_MODEL_SLAB,
                                            NEPH_CLOUD_MODEL_DECK};
  neph_context *context = test_context_create(2, NULL);
  for (size_t m = 0; m < sizeof models / sizeof *models; m++)
    for (int n = 0; n < 2; n++) {
      const int along = (int)m % 2;
      neph_cloud_desc desc = make_streets(models[m], n);
      desc.wind_m_s[along] = 8;
      depth_map *map = make_map(context, &desc, 2);
      const double ratio = compute_length_m(map, along) / compute_length_m(map, 1 - along);
      const double spacing_m = search_period_m(map, 1 - along, 3 * desc.cell_m);
      print_message("model %d, streets %d: along over across %.2f, spacing %.0f m\n", (int)models[m], n, ratio,
                    spacing_m);
      if (n == 0) assert_true(ratio > 0.5 && ratio < 2);
      if (n == 1) assert_true(ratio > 3);
      if (n == 1) assert_near_relative(spacing_m, 2 * desc.cell_m, 0.2);
      free(map);
    }
  neph_context_destroy(context);
}

/* ---- Cells ---- */

static neph_cloud_desc make_cells(neph_context *context, neph_cloud_cells kind, double coverage) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(context, "stratocumulus", &desc), NEPH_OK);
  desc.seed = 5;
  desc.extent_m[0] = desc.extent_m[1] = 60e3;
  desc.voxel_m = 200;
  desc.cell_m = 3000;
  desc.billow_m = 600;
  desc.thickness_m = 1000;
  desc.cells_kind = kind;
  desc.coverage = coverage;
  return desc;
}

/* Optical depth of open cells is skewed towards thick, by more than 1.8 (Wood), of closed ones towards thin. Their
 * distance is the requested size, to 2.5 of the map's cells, and 5 to 50 times the depth of the boundary layer, base
 * and cloud. */
static void cells_are_open_and_closed(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  static const struct {
    neph_cloud_cells kind;
    double coverage;
  } cases[] = {{NEPH_CLOUD_CELLS_OPEN, 0.3}, {NEPH_CLOUD_CELLS_CLOSED, 0.85}};
  double skewness[2];
  for (int n = 0; n < 2; n++) {
    const neph_cloud_desc desc = make_cells(context, cases[n].kind, cases[n].coverage);
    depth_map *map = make_map(context, &desc, 1);
    skewness[n] = compute_skewness(map);
    free(map);
    map = make_map(context, &desc, 5);
    const double size_m = search_period_m(map, 2, 1.6 * desc.cells_size_m);
    print_message("kind %d, coverage %.2f: skewness %.2f, size %.1f km\n", (int)cases[n].kind, cases[n].coverage,
                  skewness[n], 1e-3 * size_m);
    assert_near_relative(size_m, desc.cells_size_m, 0.2);
    const double depth_m = desc.base_altitude_m + desc.thickness_m;
    assert_true(size_m > 5 * depth_m && size_m < 50 * depth_m);
    free(map);
  }
  assert_true(skewness[0] > 1.8 && skewness[1] < -0.3);
  neph_context_destroy(context);
}

/* ---- Pictures ---- */

enum { PICTURE = 30 };

static const char *const scene_text =
    "version: 1\n"
    "camera: {position: [0 m, -1 m, 14 km], look_at: [0 m, 0 m, 0 m], fov: 60 deg, resolution: [30, 30]}\n"
    "sun: {elevation: 80 deg, azimuth: 90 deg}\n"
    "atmosphere: {ground_albedo: 0}\n"
    "render: {samples: 16}\n"
    "clouds:\n"
    "  - bake: {model: deck, extent: 16 km, voxel: 100 m, thickness: 500 m, cell: 1 km, billow: 300 m, seed: 2,\n"
    "           coverage: 0.4, wind: [8 m/s, 0 m/s]}\n";

/* Correlation of the picture with itself some pixels off. */
static double correlate_picture(const float *y, int dx, int dy) {
  double mean = 0, sum = 0, squares = 0;
  for (int i = 0; i < PICTURE * PICTURE; i++) mean += (double)y[i] / PICTURE / PICTURE;
  for (int j = 0; j < PICTURE - dy; j++)
    for (int i = 0; i < PICTURE - dx; i++) {
      const double here = (double)y[j * PICTURE + i] - mean;
      sum += here * ((double)y[(j + dy) * PICTURE + i + dx] - mean);
      squares += here * here;
    }
  return sum / squares;
}

/* Streets are bright along x; open cells are bright where closed ones are dark. */
static void pictures_have_streets_and_cells(void **state) {
  fixture *f = *state;
  static const char *const integrators[] = {"march", "path"};
  for (int n = 0; n < 2; n++) {
    neph_image *image;
    set(f, "render.integrator", integrators[n]);
    set(f, "clouds[0].bake.cells.kind", "none");
    set(f, "clouds[0].bake.streets", "1");
    assert_int_equal(neph_render_image(f->scene, NULL, &image), NEPH_OK);
    const float *green = neph_image_get_channel(image, "G");
    const double along = correlate_picture(green, 2, 0), across = correlate_picture(green, 0, 2);
    print_message("%s: correlation at 1.1 km %.2f along, %.2f across\n", integrators[n], along, across);
    assert_true(along > 0.3 && across < 0);
    neph_image_destroy(image);
    double differences = 0, squares = 0;
    float *open = calloc(PICTURE * PICTURE, sizeof *open);
    set(f, "clouds[0].bake.streets", "0");
    set(f, "clouds[0].bake.cells.size", "6 km");
    for (int kind = 0; kind < 2; kind++) {
      set(f, "clouds[0].bake.cells.kind", kind ? "closed" : "open");
      assert_int_equal(neph_render_image(f->scene, NULL, &image), NEPH_OK);
      green = neph_image_get_channel(image, "G");
      if (!kind) memcpy(open, green, PICTURE * PICTURE * sizeof *open);
      double mean[2] = {0};
      for (int i = 0; i < PICTURE * PICTURE && kind; i++)
        mean[0] += (double)open[i] / PICTURE / PICTURE, mean[1] += (double)green[i] / PICTURE / PICTURE;
      for (int i = 0; i < PICTURE * PICTURE && kind; i++) {
        differences += ((double)open[i] - mean[0]) * ((double)green[i] - mean[1]);
        squares += ((double)open[i] - mean[0]) * ((double)open[i] - mean[0]);
      }
      neph_image_destroy(image);
    }
    print_message("%s: open against closed %.2f\n", integrators[n], differences / squares);
    assert_true(differences < -0.2 * squares); /* one is bright where the other is dark */
    free(open);
  }
}

static int set_up(void **state) { return set_up_scene(state, 2, scene_text); }

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(streets_lie_along_the_wind),
      cmocka_unit_test(cells_are_open_and_closed),
      cmocka_unit_test_setup_teardown(pictures_have_streets_and_cells, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

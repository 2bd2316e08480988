/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures that say what grows where, and heroes, which need none. */
#include "test_clouds.h"

#include "cloud/bake_file.h"
#include "cloud/cloud_desc.h"
#include "cloud/weather_picture.h"

#include <nephos/image.h>

#include <png.h>

#include "core/alloc.h"

static int set_up(void **state) { return test_set_up(state, 2, "map.exr"); }

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

/* Writes a picture of one channel, Y, row by row from the north. */
static void write_map(const test_fixture *f, unsigned width, unsigned height, const float *values) {
  neph_image *image = NULL;
  assert_int_equal(neph_image_create(f->context, width, height, 1, (const char *const[]){"Y"}, &image), NEPH_OK);
  memcpy(neph_image_get_channel(image, "Y"), values, (size_t)width * height * sizeof *values);
  assert_int_equal(neph_image_save_exr(image, f->path, NEPH_PIXEL_FLOAT), NEPH_OK);
  neph_image_destroy(image);
}

static neph_cloud_desc mapped_field(const test_fixture *f, neph_cloud_map_quantity quantity) {
  neph_cloud_desc desc = test_small_field(3);
  desc.map_file = f->path;
  desc.map_channels[quantity] = "Y";
  return desc;
}

/* ---- Pictures ---- */

static void a_picture_lies_north_up_over_its_size(void **state) {
  test_fixture *f = *state;
  const float values[4] = {0.1f, 0.2f, 0.3f, 0.4f};
  write_map(f, 2, 2, values);
  neph_cloud_desc desc = mapped_field(f, NEPH_CLOUD_MAP_TYPE);
  desc.has_map_size = true;
  desc.map_size_m[0] = 4000;
  desc.map_size_m[1] = 2000;
  for (int tiling = 0; tiling < 2; tiling++) {
    np_weather_picture picture;
    desc.is_map_tiling = tiling;
    assert_int_equal(np_weather_picture_load(f->context, &desc, &picture), NEPH_OK);
    const double at[6][3] = {{-1000, 500, 0.1}, /* the middle of each texel … */
                             {1000, 500, 0.2},
                             {-1000, -500, 0.3},
                             {1000, -500, 0.4},
                             {0, 0, 0.25},                     /* … between all four … */
                             {3000, 500, tiling ? 0.1 : 0.2}}; /* … and beyond the border */
    for (int i = 0; i < 6; i++)
      assert_near(np_weather_picture_sample(&picture, NEPH_CLOUD_MAP_TYPE, at[i][0], at[i][1]), at[i][2], 1e-7);
    np_weather_picture_clear(&picture);
  }
}

/* Share of the columns between two fractions of the width that hold cloud. */
static double compute_covered_between(const test_columns *c, double from, double to) {
  const int begin = (int)(from * c->size[0]), end = (int)(to * c->size[0]);
  int covered = 0;
  for (int i = begin; i < end; i++)
    for (int j = 0; j < c->size[1]; j++) covered += c->lowest[i * c->size[1] + j] < INT32_MAX;
  return (double)covered / ((end - begin) * c->size[1]);
}

/* Black, grey and white thirds: clear, half covered, closed; 0.05 for the whole is the promise, and a third of a field
 * of three cells strays by a few times as much. Swirl and billows carry cloud over the borders: a margin stays out. */
static void cloud_grows_where_the_picture_says(void **state) {
  test_fixture *f = *state;
  write_map(f, 6, 1, (const float[]){0, 0, 0.5f, 0.5f, 1, 1});
  for (neph_cloud_model model = NEPH_CLOUD_MODEL_CELLS; model <= NEPH_CLOUD_MODEL_SLAB; model++) {
    neph_cloud_desc desc = mapped_field(f, NEPH_CLOUD_MAP_COVERAGE);
    desc.coverage = 1;
    desc.model = model;
    desc.extent_m[0] = 12000;
    desc.extent_m[1] = 8000;
    desc.voxel_m = 60;
    np_sparse_grid grid = test_bake(f->context, &desc);
    const test_columns c = test_gather_columns(&grid, &desc);
    assert_near(c.covered, 0.5, 0.05);
    assert_near(compute_covered_between(&c, 0, 0.25), 0, 0.01);
    assert_near(compute_covered_between(&c, 0.4, 0.6), 0.5, 0.25);
    assert_true(compute_covered_between(&c, 0.75, 1) > 0.85);
    free(c.lowest);
    np_sparse_grid_clear(&grid);
  }
}

static void a_black_picture_is_a_clear_sky(void **state) {
  test_fixture *f = *state;
  write_map(f, 1, 1, (const float[]){0});
  neph_cloud_desc desc = mapped_field(f, NEPH_CLOUD_MAP_COVERAGE);
  np_sparse_grid grid = test_bake(f->context, &desc);
  assert_int_equal(grid.leaf_count, 0);
  np_sparse_grid_clear(&grid);
}

static np_grid_extent measure(neph_context *context, const neph_cloud_desc *desc) {
  np_sparse_grid grid = test_bake(context, desc);
  np_grid_extent extent;
  assert_true(np_sparse_grid_measure(&grid, &extent));
  np_sparse_grid_clear(&grid);
  return extent;
}

/* Half of 1200 m is 15 voxels of 40 m. */
static void a_picture_raises_bases_and_lowers_tops(void **state) {
  test_fixture *f = *state;
  write_map(f, 1, 1, (const float[]){0.5f});
  neph_cloud_desc desc = mapped_field(f, NEPH_CLOUD_MAP_BASE);
  np_grid_extent extent = measure(f->context, &desc);
  assert_true(extent.min[2] >= 15 && extent.min[2] <= 16 && extent.max[2] < 30);
  desc = mapped_field(f, NEPH_CLOUD_MAP_THICKNESS);
  extent = measure(f->context, &desc);
  assert_true(extent.min[2] <= 1 && extent.max[2] < 15 && extent.max[2] > 6);
}

/* White in the west, where alone it rains. */
static void it_rains_where_the_picture_says(void **state) {
  test_fixture *f = *state;
  write_map(f, 2, 1, (const float[]){1, 0});
  neph_cloud_desc desc = mapped_field(f, NEPH_CLOUD_MAP_PRECIPITATION);
  desc.coverage = 0.7;
  desc.precipitation = 0.5;
  np_sparse_grid grid = test_bake(f->context, &desc);
  int west = 0, far_east = 0;
  for (size_t l = 0; l < grid.leaf_count; l++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      if (!(grid.leaves[l].values[n] > 0) || grid.leaves[l].origin[2] + n % 8 >= 0) continue;
      const int i = grid.leaves[l].origin[0] + n / 64;
      west += i < 75;
      far_east += i > 125; /* the picture fades between the middles of its two texels */
    }
  assert_true(west > 1000 && far_east == 0);
  np_sparse_grid_clear(&grid);
}

/* More type is taller towers and lower clouds between them: the tops spread. */
static void a_picture_chooses_the_type(void **state) {
  test_fixture *f = *state;
  double volume[2];
  for (int i = 0; i < 2; i++) {
    write_map(f, 1, 1, (const float[]){(float)i});
    neph_cloud_desc desc = mapped_field(f, NEPH_CLOUD_MAP_TYPE);
    desc.type = 1;
    np_sparse_grid grid = test_bake(f->context, &desc), same;
    volume[i] = test_count_voxels(&grid, 8, 30);
    desc.map_file = NULL;
    desc.map_channels[NEPH_CLOUD_MAP_TYPE] = NULL;
    desc.type = i;
    same = test_bake(f->context, &desc);
    assert_near(test_count_voxels(&same, 8, 30), volume[i], 0); /* a share of the key, and nothing else */
    np_sparse_grid_clear(&same);
    np_sparse_grid_clear(&grid);
  }
  assert_true(volume[0] > 1.2 * volume[1]);
}

static void a_png_is_read_too(void **state) {
  test_fixture *f = *state;
  char *path = test_path(f->folder, "map.png");
  png_image picture = {.version = PNG_IMAGE_VERSION, .width = 2, .height = 1, .format = PNG_FORMAT_LINEAR_Y};
  assert_true(png_image_write_to_file(&picture, path, 0, (const png_uint_16[]){0, 65535}, 0, NULL));
  neph_cloud_desc desc = mapped_field(f, NEPH_CLOUD_MAP_COVERAGE);
  desc.map_file = path;
  desc.coverage = 0.8; /* the picture takes its place */
  np_sparse_grid grid = test_bake(f->context, &desc);
  const test_columns c = test_gather_columns(&grid, &desc);
  assert_near(c.covered, 0.5, 0.05);
  assert_true(compute_covered_between(&c, 0, 0.5) < 0.5 * compute_covered_between(&c, 0.5, 1));
  free(c.lowest);
  np_sparse_grid_clear(&grid);
  free(path);
}

/* ---- In files ---- */

static char *describe(const test_fixture *f, const neph_cloud_desc *desc) {
  const neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  char *text = NULL;
  assert_int_equal(np_cloud_desc_to_json(f->context, desc, &bake, &text), NEPH_OK);
  return text;
}

static void parameters_hold_what_is_in_the_picture(void **state) {
  test_fixture *f = *state;
  const neph_cloud_desc desc = mapped_field(f, NEPH_CLOUD_MAP_COVERAGE);
  write_map(f, 1, 1, (const float[]){0.5f});
  char *first = describe(f, &desc), *again = describe(f, &desc);
  write_map(f, 1, 1, (const float[]){0.6f});
  char *other = describe(f, &desc);
  assert_string_equal(first, again);
  assert_string_not_equal(first, other);
  neph_cloud_desc read;
  neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  assert_int_equal(np_cloud_desc_from_json(f->context, "x.vdb", other, &read, &bake), NEPH_OK);
  assert_string_equal(read.map_file, f->path);
  assert_string_equal(read.map_channels[NEPH_CLOUD_MAP_COVERAGE], "Y");
  assert_null(read.map_channels[NEPH_CLOUD_MAP_TYPE]);
  np_cloud_desc_clear(f->context, &read);
  np_alloc_free(f->context, other);
  np_alloc_free(f->context, again);
  np_alloc_free(f->context, first);
}

static void a_file_is_current_while_its_picture_is(void **state) {
  test_fixture *f = *state;
  char *vdb = test_path(f->folder, "field.vdb");
  neph_cloud_desc desc = mapped_field(f, NEPH_CLOUD_MAP_COVERAGE);
  desc.voxel_m = 100;
  const neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  for (int i = 0; i < 2; i++) {
    bool is_current = i, is_same = i;
    write_map(f, 1, 1, (const float[]){0.5f + 0.25f * (float)i});
    if (i == 0) assert_int_equal(neph_cloud_bake_file(f->context, &desc, NULL, "density", vdb), NEPH_OK);
    assert_int_equal(np_cloud_file_is_current(f->context, vdb, &desc, &bake, &is_current), NEPH_OK);
    assert_int_equal(neph_cloud_verify_file(f->context, vdb, NULL, NULL, &is_same), NEPH_OK);
    assert_int_equal(is_current, i == 0);
    assert_int_equal(is_same, i == 0);
  }
  free(vdb);
}

/* ---- Failures ---- */

static void assert_refused(test_fixture *f, const neph_cloud_desc *desc, neph_result expected) {
  neph_volume *volume = (neph_volume *)8; /* must be overwritten */
  assert_int_equal(neph_cloud_bake(f->context, desc, NULL, &volume), expected);
  assert_null(volume);
}

static void pictures_that_say_nothing_are_refused(void **state) {
  test_fixture *f = *state;
  neph_cloud_desc desc = mapped_field(f, NEPH_CLOUD_MAP_COVERAGE);
  assert_refused(f, &desc, NEPH_ERROR_NOT_FOUND);
  assert_one_error(&f->log, f->path, "no such file");
  test_file_write_text(f->path, "a text");
  assert_refused(f, &desc, NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, f->path);
  write_map(f, 2, 1, (const float[]){0, 1});
  desc.map_channels[NEPH_CLOUD_MAP_THICKNESS] = "G";
  assert_refused(f, &desc, NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, f->path, "no channel G for the weather map's thickness", "must be one of Y");
  desc.map_file = "map.jpeg";
  assert_refused(f, &desc, NEPH_ERROR_NOT_FOUND);
  test_log_clear(&f->log);
  desc.map_file = NEPHOS_TEST_SOURCE_DIR "/CMakeLists.txt";
  assert_refused(f, &desc, NEPH_ERROR_UNSUPPORTED);
  assert_one_error(&f->log, ".exr and .png", "\".txt\"");
}

static void values_that_are_no_share_are_named_with_their_place(void **state) {
  test_fixture *f = *state;
  const neph_cloud_desc desc = mapped_field(f, NEPH_CLOUD_MAP_COVERAGE);
  const float bad[] = {1.5f, -0.25f, NAN};
  const char *const words[] = {"1.5", "-0.25", "nan"};
  for (int i = 0; i < 3; i++) {
    write_map(f, 2, 2, (const float[]){0, 1, 0.5f, bad[i]});
    test_log_clear(&f->log); /* writing a NaN warns */
    assert_refused(f, &desc, NEPH_ERROR_BAD_FILE);
    assert_one_error(&f->log, f->path, "channel Y is", words[i], "column 1, row 1", "must be in [0, 1]");
  }
}

/* Writes channels of 2 × 1 values each. */
static void write_channels(const test_fixture *f, unsigned count, const char *const *names, const float (*values)[2]) {
  neph_image *image = NULL;
  assert_int_equal(neph_image_create(f->context, 2, 1, count, names, &image), NEPH_OK);
  for (unsigned c = 0; c < count; c++) memcpy(neph_image_get_channel(image, names[c]), values[c], sizeof *values);
  assert_int_equal(neph_image_save_exr(image, f->path, NEPH_PIXEL_FLOAT), NEPH_OK);
  neph_image_destroy(image);
}

/* Without names: the only channel, a grey picture in colours, and what is beside an alpha of 1. */
static void a_grey_picture_needs_no_channel(void **state) {
  test_fixture *f = *state;
  static const float values[4][2] = {{0.25f, 0.75f}, {0.25f, 0.75f}, {0.25f, 0.75f}, {1, 1}};
  static const struct {
    unsigned first, count;
    const char *names[4];
  } rows[] = {{0, 1, {"Y"}}, {0, 1, {"R"}}, {0, 1, {"A"}}, {0, 3, {"R", "G", "B"}}, {0, 4, {"R", "G", "B", "A"}}};
  neph_cloud_desc desc = test_small_field(3);
  desc.map_file = f->path;
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    np_weather_picture picture;
    write_channels(f, rows[i].count, rows[i].names, values);
    assert_int_equal(np_weather_picture_load(f->context, &desc, &picture), NEPH_OK);
    assert_near(np_weather_picture_sample(&picture, NEPH_CLOUD_MAP_COVERAGE, 1e4, 0), 0.75, 1e-6);
    np_weather_picture_clear(&picture);
  }
  static const float colours[3][2] = {{0, 1}, {1, 0}, {0, 0}};
  write_channels(f, 3, (const char *const[]){"R", "G", "B"}, colours);
  assert_refused(f, &desc, NEPH_ERROR_BAD_FILE);
  assert_one_error(&f->log, f->path, "names no channel of", "{image: FILE, coverage: ");
}

static void a_channel_needs_a_picture(void **state) {
  test_fixture *f = *state;
  neph_cloud_desc desc = test_small_field(0);
  desc.map_channels[NEPH_CLOUD_MAP_TYPE] = "R";
  assert_refused(f, &desc, NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "cloud.map.type is channel R of no picture");
  desc = mapped_field(f, NEPH_CLOUD_MAP_TYPE);
  desc.map_size_m[1] = 0;
  assert_refused(f, &desc, NEPH_ERROR_INVALID_ARGUMENT);
  assert_one_error(&f->log, "cloud.map.size[1] is 0 m", "must be in (0");
}

typedef struct attempt {
  const char *path;
} attempt;

static neph_result bake_mapped(neph_context *context, void *user) {
  const attempt *a = user;
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  desc.extent_m[0] = desc.extent_m[1] = 1500;
  desc.voxel_m = 100;
  desc.map_file = a->path;
  for (int q = 0; q < NEPH_CLOUD_MAP_QUANTITY_COUNT; q++) desc.map_channels[q] = "Y";
  neph_volume *volume = NULL;
  neph_result result = neph_cloud_bake(context, &desc, NULL, &volume);
  neph_volume_release(volume);
  return result;
}

static void a_failed_allocation_leaves_nothing_behind(void **state) {
  test_fixture *f = *state;
  attempt a = {f->path};
  write_map(f, 1, 1, (const float[]){0.7f});
  assert_survives_failed_allocations(bake_mapped, &a);
}

/* ---- Heroes ---- */

/* One cloud: it covers what it says, has nothing near the border, and its middle is where its field's is. */
static void a_hero_stands_alone_in_the_middle(void **state) {
  test_fixture *f = *state;
  for (uint64_t seed = 0; seed < 3; seed++) {
    neph_cloud_desc desc = test_small_field(seed);
    desc.model = NEPH_CLOUD_MODEL_HERO;
    desc.extent_m[0] = desc.extent_m[1] = 4000;
    desc.coverage = 0.3;
    np_sparse_grid grid = test_bake(f->context, &desc);
    const test_columns c = test_gather_columns(&grid, &desc);
    double sum[2] = {0, 0};
    int count = 0;
    for (int i = 0; i < c.size[0]; i++)
      for (int j = 0; j < c.size[1]; j++) {
        if (c.lowest[i * c.size[1] + j] == INT32_MAX) continue;
        assert_true(i > 5 && j > 5 && i < c.size[0] - 6 && j < c.size[1] - 6);
        sum[0] += i, sum[1] += j, count++;
      }
    assert_near(c.covered, 0.3, 0.05);
    for (int a = 0; a < 2; a++) assert_near(sum[a] / count, 0.5 * c.size[a], 0.1 * c.size[a]);
    free(c.lowest);
    np_sparse_grid_clear(&grid);
  }
}

/* ---- Types that meet ---- */

enum { TYPES_SIDE = 152 };

static void sum_columns(const np_sparse_grid *grid, double voxel_m, double (*depth)[TYPES_SIDE]) {
  for (size_t l = 0; l < grid->leaf_count; l++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const int i = grid->leaves[l].origin[0] + n / 64, j = grid->leaves[l].origin[1] + n / 8 % 8;
      if (i < TYPES_SIDE && j < TYPES_SIDE) depth[i][j] += (double)grid->leaves[l].values[n] * voxel_m;
    }
}

/* Three types in bands of a third of the field: optical depth jumps no more from column to column within two voxels of
 * a border than it does inside the bands, whose billows have flanks as steep as any. */
static void painted_types_meet_without_a_seam(void **state) {
  test_fixture *f = *state;
  write_map(f, 6, 1, (const float[]){0, 0, 0.5f, 0.5f, 1, 1});
  neph_cloud_desc desc = mapped_field(f, NEPH_CLOUD_MAP_TYPE);
  desc.model = NEPH_CLOUD_MODEL_THERMALS;
  desc.type = 1;
  desc.coverage = 0.7;
  double(*depth)[TYPES_SIDE] = calloc(TYPES_SIDE, sizeof *depth), at_border = 0, inside = 0;
  double border_sum = 0, sum = 0;
  np_sparse_grid grid = test_bake(f->context, &desc);
  sum_columns(&grid, desc.voxel_m, depth);
  for (int i = 0; i + 1 < TYPES_SIDE; i++)
    for (int j = 0; j < TYPES_SIDE; j++) {
      const double jump = fabs(depth[i + 1][j] - depth[i][j]);
      const bool is_border = abs(i - 50) <= 2 || abs(i - 100) <= 2; /* out of 150 voxels */
      *(is_border ? &at_border : &inside) = fmax(is_border ? at_border : inside, jump);
      if (is_border) border_sum += depth[i][j];
      sum += depth[i][j];
    }
  const double share = border_sum / 10 / (sum / 150); /* relative to the mean column, in the ten columns at borders */
  print_message("largest jump %.1f at borders, %.1f inside; mean at borders %.2f of the field's\n", at_border, inside,
                share);
  assert_true(share > 0.5); /* there is cloud to jump */
  assert_true(at_border <= inside);
  free(depth);
  np_sparse_grid_clear(&grid);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(painted_types_meet_without_a_seam),
      TEST(a_picture_lies_north_up_over_its_size),
      TEST(cloud_grows_where_the_picture_says),
      TEST(a_black_picture_is_a_clear_sky),
      TEST(a_picture_raises_bases_and_lowers_tops),
      TEST(it_rains_where_the_picture_says),
      TEST(a_picture_chooses_the_type),
      TEST(a_png_is_read_too),
      TEST(parameters_hold_what_is_in_the_picture),
      TEST(a_file_is_current_while_its_picture_is),
      TEST(pictures_that_say_nothing_are_refused),
      TEST(values_that_are_no_share_are_named_with_their_place),
      TEST(a_channel_needs_a_picture),
      TEST(a_grey_picture_needs_no_channel),
      TEST(a_failed_allocation_leaves_nothing_behind),
      TEST(a_hero_stands_alone_in_the_middle),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

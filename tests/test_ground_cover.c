/* SPDX-License-Identifier: Apache-2.0 */
/* Albedo of a terrain from place to place: pictures, rock and snow, and the mean that the air is given. */
#include "test_terrains.h"

#include <nephos/image.h>

#include "terrain/ground_cover.h"
#include "world/world.h"

enum { SQUARES = 4 };
static const double width_m = 4000.0;

/* 0.6 and 0.1 in turn, the north-western square 0.6; blue is a third of that. */
static float get_square(unsigned column, unsigned row, int channel) {
  return ((column + row) % 2 ? 0.1f : 0.6f) / (channel == 2 ? 3.0f : 1.0f);
}

static char *save_checkerboard(const test_fixture *f, const char *name, unsigned texels_each) {
  static const char *const names[3] = {"R", "G", "B"};
  const unsigned side = SQUARES * texels_each;
  neph_image *image = NULL;
  char *path = malloc(4096);
  (void)snprintf(path, 4096, "%s/%s", f->folder, name);
  assert_int_equal(neph_image_create(f->context, side, side, 3, names, &image), NEPH_OK);
  for (int c = 0; c < 3; c++)
    for (unsigned i = 0; i < side * side; i++)
      neph_image_get_channel(image, names[c])[i] = get_square(i % side / texels_each, i / side / texels_each, c);
  assert_int_equal(neph_image_save_exr(image, path, NEPH_PIXEL_HALF), NEPH_OK);
  neph_image_destroy(image);
  return path;
}

static neph_terrain_desc make_desc(const char *image) {
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  desc.width_m = width_m;
  desc.albedo_image = image;
  return desc;
}

static neph_ridges_desc make_ridges_desc(void) {
  neph_ridges_desc ridges = NEPH_RIDGES_DESC_DEFAULT;
  ridges.sample_count = 65;
  ridges.relief_m = 0.0;
  return ridges;
}

static neph_terrain *make_flat(neph_context *context, const neph_terrain_desc *desc) {
  const neph_ridges_desc ridges = make_ridges_desc();
  neph_terrain *terrain = NULL;
  assert_int_equal(neph_terrain_create_ridges(context, &ridges, desc, &terrain), NEPH_OK);
  return terrain;
}

static void get_albedo(const neph_terrain *terrain, double x, double y, float out[3]) {
  np_terrain_hit hit;
  assert_true(np_terrain_intersect(terrain, np_dvec3_make(x, y, 5e3), np_vec3_make(0, 0, -1), 1e5, &hit));
  np_terrain_eval_albedo(terrain, &hit, 0.0f, out);
}

/* Halves of the EXR: 2⁻¹¹ of a value. The middles of squares are eight texels from the next. */
static void squares_land_where_they_should(void **state) {
  test_fixture *f = *state;
  char *path = save_checkerboard(f, "board.exr", 16);
  const neph_terrain_desc desc = make_desc(path);
  neph_terrain *terrain = make_flat(f->context, &desc);
  assert_true(np_terrain_has_cover(terrain));
  for (unsigned row = 0; row < SQUARES; row++)
    for (unsigned column = 0; column < SQUARES; column++) {
      float albedo[3];
      get_albedo(terrain, width_m * ((column + 0.5) / SQUARES - 0.5), width_m * (0.5 - (row + 0.5) / SQUARES), albedo);
      for (int c = 0; c < 3; c++) assert_near_relative(albedo[c], get_square(column, row, c), 1e-3);
    }
  assert_near(np_terrain_get_mean_albedo(terrain)[0], 0.35, 1e-3); /* squares are as many of each */
  neph_terrain_release(terrain);
  free(path);
}

/* A plain with a rim of 1 km, which goes on beyond it. */
static int make_bowl(unsigned column, unsigned row) {
  return column < 6 || row < 6 || column > 1194 || row > 1194 ? 1000 : 0;
}

/* Snow on the land beyond the rim, until that falls below 500 m half-way between 50 and 250 km from there, lights the
 * air by the share of its light that comes from so far; where the field fades at the border, none does. */
static void the_air_is_lit_by_land_beyond(void **state) {
  enum { ANGLES = 3600 };
  test_fixture *f = *state;
  char *path = test_hgt_write(f->folder, "N44W072.hgt", 1201, make_bowl);
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  desc.has_snow = true;
  desc.snow_level_m = 500.0;
  neph_terrain *terrain = NULL;
  assert_int_equal(neph_terrain_load(f->context, path, &desc, &terrain), NEPH_OK);
  const double degree_m = 6360e3 * NP_DEGREE, half[2] = {0.5 * degree_m * cos(44.5 * NP_DEGREE), 0.5 * degree_m};
  double snow = 0.0;
  for (int i = 0; i < ANGLES; i++) {
    const double angle = 2.0 * NP_PI * (i + 0.5) / ANGLES;
    const double rim_m = fmin(half[0] / fabs(cos(angle)), half[1] / fabs(sin(angle)));
    snow += (8e3 / hypot(8e3, rim_m) - 8e3 / hypot(8e3, rim_m + 150e3)) / ANGLES;
  }
  const double mean = np_terrain_get_mean_albedo(terrain)[1], bright = desc.snow_albedo[1];
  assert_true(snow > 0.1 && mean < 0.3);
  assert_near(np_terrain_get_air_albedo(terrain)[1] - mean, snow * (bright - mean), 0.02);
  neph_terrain_release(terrain);
  desc.edge = NEPH_TERRAIN_EDGE_FADE;
  assert_int_equal(neph_terrain_load(f->context, path, &desc, &terrain), NEPH_OK);
  assert_true(np_terrain_get_air_albedo(terrain)[1] == np_terrain_get_mean_albedo(terrain)[1]);
  neph_terrain_release(terrain);
  free(path);
}

/* Half-way between two texels a picture is their mean. */
static void pictures_are_bilinear(void **state) {
  test_fixture *f = *state;
  char *path = save_checkerboard(f, "board.exr", 1);
  const neph_terrain_desc desc = make_desc(path);
  neph_terrain *terrain = make_flat(f->context, &desc);
  float albedo[3];
  get_albedo(terrain, 0.0, 0.125 * width_m, albedo);
  assert_near(albedo[0], 0.35, 1e-3);
  neph_terrain_release(terrain);
  free(path);
}

/* Code values of PNG are sRGB's: 188 of 255 is a linear 0.503 (IEC 61966-2-1); dither moves a pixel by
 * a code value, 1.2 % of the albedo, and the mean of four by less: twice that. */
static void png_is_srgb(void **state) {
  test_fixture *f = *state;
  char path[4096];
  neph_image *image = NULL;
  (void)snprintf(path, sizeof path, "%s/grey.png", f->folder);
  static const char *const names[3] = {"R", "G", "B"};
  assert_int_equal(neph_image_create(f->context, 4, 4, 3, names, &image), NEPH_OK);
  for (int c = 0; c < 3; c++)
    for (int i = 0; i < 16; i++) neph_image_get_channel(image, names[c])[i] = 0.503f;
  neph_preview_desc preview = NEPH_PREVIEW_DESC_DEFAULT;
  preview.view = NEPH_VIEW_RAW;
  preview.exposure_ev = 0.0;
  assert_int_equal(neph_image_save_png(image, path, &preview), NEPH_OK);
  neph_image_destroy(image);
  assert_int_equal(neph_image_load_png(f->context, path, &image), NEPH_OK);
  const double code = (double)neph_image_get_channel(image, "R")[0];
  neph_image_destroy(image);
  const neph_terrain_desc desc = make_desc(path);
  neph_terrain *terrain = make_flat(f->context, &desc);
  float albedo[3];
  get_albedo(terrain, 0.0, 0.0, albedo);
  assert_near_relative(albedo[0], pow((code + 0.055) / 1.055, 2.4), 0.03);
  neph_terrain_release(terrain);
}

/* ---- Rock and snow ---- */

static np_ground_cover make_layers(test_fixture *f) {
  neph_terrain_desc desc = make_desc(NULL);
  desc.has_rock = desc.has_snow = true;
  np_ground_cover cover;
  assert_int_equal(np_ground_cover_create(f->context, &desc, NULL, &cover), NEPH_OK);
  return cover;
}

/* Mean of the red albedo over places of one slope and height. */
static double compute_mean(const np_ground_cover *cover, double slope_deg, double elevation_m) {
  np_random random = np_random_start(3, 0, 0, 0, 0);
  enum { PLACES = 2000 };
  double sum = 0.0;
  for (int n = 0; n < PLACES; n++) {
    float albedo[3];
    const np_cover_place place = {.east_m = 1e4 * np_random_double(&random),
                                  .north_m = 1e4 * np_random_double(&random),
                                  .elevation_m = (float)elevation_m,
                                  .slope_rad = (float)(slope_deg * NP_DEGREE)};
    np_ground_cover_eval(cover, &place, albedo);
    sum += (double)albedo[0];
  }
  return sum / PLACES;
}

/* Land 0.2, rock 0.13, snow 0.86. Far from every border there is one of them alone; at a border, half of each, within
 * what the noise's mean over 10 km leaves: 0.1. */
static void slopes_are_rock_and_heights_snow(void **state) {
  np_ground_cover cover = make_layers(*state);
  assert_near(compute_mean(&cover, 0.0, 0.0), 0.2, 1e-6);
  assert_near(compute_mean(&cover, 88.0, 0.0), 0.13, 1e-6);
  assert_near(compute_mean(&cover, 0.0, 3000.0), 0.86, 1e-6);
  assert_near((compute_mean(&cover, 0.0, 1500.0) - 0.2) / 0.66, 0.5, 0.1);
  assert_near((compute_mean(&cover, 35.0, 0.0) - 0.2) / -0.07, 0.5, 0.1);
  assert_near((compute_mean(&cover, 50.0, 3000.0) - 0.13) / 0.73, 0.5, 0.1);
  np_ground_cover_destroy(&cover);
}

/* ---- Errors ---- */

static void assert_refused(test_fixture *f, const neph_terrain_desc *desc, const char *text) {
  const neph_ridges_desc ridges = make_ridges_desc();
  neph_terrain *terrain = NULL;
  test_log_clear(&f->log);
  assert_int_not_equal(neph_terrain_create_ridges(f->context, &ridges, desc, &terrain), NEPH_OK);
  assert_null(terrain);
  assert_one_error(&f->log, text);
}

static void save_single(const test_fixture *f, const char *path, const char *channel, float value) {
  neph_image *image = NULL;
  assert_int_equal(neph_image_create(f->context, 2, 2, 1, &channel, &image), NEPH_OK);
  for (int i = 0; i < 4; i++) neph_image_get_channel(image, channel)[i] = value;
  assert_int_equal(neph_image_save_exr(image, path, NEPH_PIXEL_HALF), NEPH_OK);
  neph_image_destroy(image);
}

static void bad_files_and_values_are_refused(void **state) {
  test_fixture *f = *state;
  char path[4096];
  neph_terrain_desc desc = make_desc("no/such.exr");
  assert_refused(f, &desc, "no/such.exr");
  desc = make_desc("ground.jpg");
  assert_refused(f, &desc, "ground.jpg: pictures of albedo are read from .exr and .png, not from \".jpg\"");
  (void)snprintf(path, sizeof path, "%s/depth.exr", f->folder);
  save_single(f, path, "Z", 0.5f);
  desc = make_desc(path);
  assert_refused(f, &desc, "must have channels R, G and B, or Y");
  (void)snprintf(path, sizeof path, "%s/bright.exr", f->folder);
  save_single(f, path, "Y", 1.5f);
  desc = make_desc(path);
  assert_refused(f, &desc, "albedo is 1.5 at column 0, row 0, must be in [0, 1]");
  desc = make_desc(NULL);
  desc.snow_albedo[1] = 1.1;
  assert_refused(f, &desc, "terrain snow_albedo[1] is 1.1, must be in [0, 1]");
  desc = make_desc(NULL);
  desc.rock_slope_rad = 2.0;
  assert_refused(f, &desc, "terrain rock_slope_rad is 2, must be in [0, pi/2]");
}

/* ---- Shadow terminator ---- */

/* A round hill of 400 m on 21 samples, 200 m apart: facets turn by 2° from one to the next. */
static neph_terrain *make_hill(test_fixture *f) {
  enum { SIDE = 21 };
  const char *channel = "Y";
  char path[4096];
  neph_image *image = NULL;
  (void)snprintf(path, sizeof path, "%s/hill.exr", f->folder);
  assert_int_equal(neph_image_create(f->context, SIDE, SIDE, 1, &channel, &image), NEPH_OK);
  for (int i = 0; i < SIDE * SIDE; i++) {
    const double x = i % SIDE - 10.0, y = i / SIDE - 10.0; /* half-integers of nothing: exact in float */
    neph_image_get_channel(image, channel)[i] = (float)(400.0 - 2.0 * (x * x + y * y));
  }
  assert_int_equal(neph_image_save_exr(image, path, NEPH_PIXEL_FLOAT), NEPH_OK);
  neph_image_destroy(image);
  const neph_terrain_desc desc = make_desc(NULL);
  neph_terrain *terrain = NULL;
  assert_int_equal(neph_terrain_load(f->context, path, &desc, &terrain), NEPH_OK);
  return terrain;
}

/* The sun lights a convex hill wherever the smooth surface faces it by a thousandth more than grazing, a margin for
 * rounding. Facets face away up to half a degree earlier: without a rise 17 of these places are dark. */
static void facets_cast_no_shadow_on_themselves(void **state) {
  test_fixture *f = *state;
  neph_terrain *terrain = make_hill(f);
  np_world world = {.has_planet = true, .planet_radius_m = radius_m, .terrain = terrain};
  np_terrain_get_bounds(terrain, &world.terrain_min, &world.terrain_max);
  const np_vec3 to_sun = np_vec3_normalize(np_vec3_make(1.0f, 0.3f, 0.1f));
  np_random random = np_random_start(5, 0, 0, 0, 0);
  int faces = 0;
  for (int n = 0; n < 4000; n++) {
    const double x = 2400.0 * (np_random_double(&random) - 0.5), y = 2400.0 * (np_random_double(&random) - 0.5);
    np_ground_hit hit;
    assert_true(np_world_intersect_ground(&world, np_dvec3_make(x, y, 2e3), np_vec3_make(0, 0, -1), &hit));
    if (np_vec3_dot(hit.normal, to_sun) < 1e-3f) continue;
    faces++;
    assert_false(np_world_is_behind_terrain(&world, hit.position, to_sun));
  }
  assert_true(faces > 1000);
  neph_terrain_release(terrain);
}

/* ---- Water over land ---- */

static np_ground_hit meet(const np_world *world, double x, double y) {
  np_ground_hit hit;
  assert_true(np_world_intersect_ground(world, np_dvec3_make(x, y, 3e3), np_vec3_make(0, 0, -1), &hit));
  return hit;
}

/* The hill is 400 − 2r²/(200 m)² high: 300 m at r = 1414 m. Water stands 0.1 m above its level, and hits 0.05 m above
 * that. */
static void water_covers_what_is_below_its_level(void **state) {
  test_fixture *f = *state;
  neph_terrain *terrain = make_hill(f);
  np_water water = np_water_make(300.0, 5.0, np_spectrum_grey(0.02f));
  np_world world = {.has_planet = true, .planet_radius_m = radius_m, .terrain = terrain, .water = &water};
  np_terrain_get_bounds(terrain, &world.terrain_min, &world.terrain_max);
  assert_null(meet(&world, 0.0, 0.0).water);
  assert_null(meet(&world, 1200.0, 0.0).water);
  assert_ptr_equal(meet(&world, 1500.0, 0.0).water, &water);
  const np_ground_hit sea = meet(&world, 2e4, 1e3); /* beyond the field */
  assert_ptr_equal(sea.water, &water);
  assert_near(np_altitude(sea.position, radius_m), 300.15, 1e-3);
  np_ground_hit again; /* a ray that leaves it upwards meets nothing */
  assert_false(np_world_intersect_ground(&world, sea.position, np_vec3_make(0.0f, 1.0f, 0.001f), &again));
  water.level_m = -50.0; /* a lake below the sea fills hollows of the field alone */
  assert_null(meet(&world, 2e4, 1e3).water);
  assert_null(meet(&world, 0.0, 0.0).water);
  neph_terrain_release(terrain);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(squares_land_where_they_should),
      TEST(the_air_is_lit_by_land_beyond),
      TEST(pictures_are_bilinear),
      TEST(png_is_srgb),
      TEST(slopes_are_rock_and_heights_snow),
      TEST(bad_files_and_values_are_refused),
      TEST(facets_cast_no_shadow_on_themselves),
      TEST(water_covers_what_is_below_its_level),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

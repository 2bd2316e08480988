/* SPDX-License-Identifier: Apache-2.0 */
/* Shadows in the air before the camera: of a block whose shadow is known, and in whole pictures. */
#include "test_skies.h"
#include "test_world.h"

#include <nephos/nephos.h>

#include "atmosphere/atmosphere_tables.h"

#define CAMERA "version: 1\ncamera: {position: [0, -8 km, 900 m], look_at: [0, 0, 900 m], resolution: [24, 14]}\n"
#define LOW_SUN "sun: {elevation: 4 deg, azimuth: 60 deg}\n"
#define HILLS "terrain: {ridges: {samples: 129, relief: 1500 m}, width: 20 km, albedo: 0}\n"

static neph_image *render(neph_context *context, const char *text, const char *shadows) {
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  assert_int_equal(neph_scene_load_text(context, text, "test.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "output.aovs", "[air]"), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.samples", "4"), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.air_shadows", shadows), NEPH_OK);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  neph_scene_destroy(scene);
  return image;
}

static const float *get_channel(neph_image *image, const char *name, size_t *out_count) {
  *out_count = (size_t)neph_image_get_width(image) * neph_image_get_height(image);
  const float *values = neph_image_get_channel(image, name);
  assert_non_null(values);
  return values;
}

/* Hills under a low sun take light from the air between them, of which some has been scattered more than once and
 * stays; they add none. */
static void hills_darken_the_air_behind_them(void **state) {
  neph_context *context = *state;
  neph_image *clear = render(context, CAMERA LOW_SUN HILLS, "false");
  neph_image *shadowed = render(context, CAMERA LOW_SUN HILLS, "true");
  size_t count;
  const float *a = get_channel(clear, "air.G", &count), *b = get_channel(shadowed, "air.G", &count);
  double before = 0.0, after = 0.0;
  for (size_t i = 0; i < count; i++) {
    assert_true(b[i] <= a[i]);
    before += (double)a[i];
    after += (double)b[i];
  }
  assert_true(after < 0.97 * before && after > 0.3 * before);
  neph_image_destroy(clear);
  neph_image_destroy(shadowed);
}

/* Hazy hills under a low sun, and the air before them, have a mean radiance of 0.02391 in green by `path` (250 samples
 * and two seeds, which differ by 0.8 %): the four lower rows of a picture. 5 %: the march has 3.0 % more, and had 15 %
 * more while haze scattered on the light that hills hide. */
static void hills_hide_sky_from_the_air(void **state) {
  enum { WIDTH = 16, HEIGHT = 9, ROWS = 4 };
  neph_context *context = *state;
  neph_image *image =
      render(context,
             "version: 1\n"
             "camera: {position: [0, -8 km, 900 m], look_at: [0, 0, 1100 m], fov: 60 deg, resolution: [16, 9]}\n"
             "sun: {elevation: 9 deg, azimuth: 40 deg}\n"
             "atmosphere: {preset: earth-hazy, ground_albedo: 0.15}\n"
             "terrain: {ridges: {samples: 129, relief: 1500 m, seed: 12}, width: 20 km, albedo: 0.15}\n"
             "output: {color_space: bands}\n",
             "true");
  size_t count;
  const float *green = get_channel(image, "G", &count);
  double sum = 0.0;
  assert_int_equal(count, WIDTH * HEIGHT);
  for (size_t i = count - ROWS * WIDTH; i < count; i++) sum += (double)green[i];
  assert_near_relative(sum / (ROWS * WIDTH), 0.02391, 0.05);
  neph_image_destroy(image);
}

/* Land of hills 20 m high is nearly what it is without them: the air before it has what the bare ground sends through
 * it. 2 %: it lost 12 to 18 %, as the air behind that ground was taken from it. */
static void low_hills_change_little(void **state) {
  neph_context *context = *state;
  static const char *const text =
      "version: 1\n"
      "camera: {position: [0, -8500 m, 1200 m], look_at: [0, 0, 1100 m], fov: 35 deg, resolution: [24, 14]}\n"
      "sun: {elevation: 25 deg, azimuth: 250 deg}\n"
      "atmosphere: {haze: hazy, visibility: 20 km}\n"
      "terrain: {ridges: {seed: 12, relief: 20 m, ridge: 3 km, samples: 129}, width: 10 km, albedo: 0.15}\n";
  static const char *const channels[3] = {"R", "G", "B"};
  neph_image *clear = render(context, text, "false"), *shadowed = render(context, text, "true");
  for (int c = 0; c < 3; c++) {
    size_t count;
    const float *a = get_channel(clear, channels[c], &count), *b = get_channel(shadowed, channels[c], &count);
    for (size_t i = 0; i < count; i++) assert_near_relative((double)b[i], (double)a[i], 0.02);
  }
  neph_image_destroy(clear);
  neph_image_destroy(shadowed);
}

/* A slope before the low sun, and the air before it, which only the light from over the ridge reaches: means of 48
 * pixels by `path`, of two seeds that differ by 11, 5 and 2 %. 20 %: the march has +6, −18 and −5 % of them; it had
 * −86, −63 and −15 % while what hides the sun hid all light from around it. */
static void light_comes_over_a_ridge(void **state) {
  enum { LEFT = 10, RIGHT = 22, TOP = 6, BOTTOM = 10, WIDTH = 24 };
  static const char *const channels[3] = {"R", "G", "B"};
  static const double paths[3] = {0.0152, 0.01048, 0.01022};
  neph_context *context = *state;
  neph_image *image =
      render(context,
             "version: 1\n"
             "camera: {position: [0, -9 km, 500 m], look_at: [0, 0, 700 m], fov: 55 deg, resolution: [24, 14]}\n"
             "sun: {elevation: 4 deg, azimuth: 10 deg}\n"
             "atmosphere: {haze: hazy, visibility: 10 km}\n"
             "terrain: {ridges: {seed: 8, relief: 1500 m, ridge: 5 km, samples: 129}, width: 20 km, albedo: 0.2}\n",
             "true");
  for (int c = 0; c < 3; c++) {
    size_t count;
    double sum = 0.0;
    const float *values = get_channel(image, channels[c], &count);
    for (int y = TOP; y < BOTTOM; y++)
      for (int x = LEFT; x < RIGHT; x++) sum += (double)values[y * WIDTH + x];
    assert_near_relative(sum / ((BOTTOM - TOP) * (RIGHT - LEFT)), paths[c], 0.2);
  }
  neph_image_destroy(image);
}

/* Haze in which hills are hundreds of optical depths away is dimmed by their shade, and neither black nor brighter. */
static void thick_haze_among_hills_stays_between(void **state) {
  neph_context *context = *state;
  static const char *const text = CAMERA LOW_SUN HILLS "atmosphere: {haze: hazy, visibility: 1 km}\n";
  neph_image *clear = render(context, text, "false"), *shadowed = render(context, text, "true");
  size_t count;
  const float *a = get_channel(clear, "G", &count), *b = get_channel(shadowed, "G", &count);
  for (size_t i = 0; i < count; i++) assert_true(b[i] <= 1.05f * a[i] && b[i] > 0.1f * a[i]);
  neph_image_destroy(clear);
  neph_image_destroy(shadowed);
}

static void where_nothing_stands_nothing_changes(void **state) {
  neph_context *context = *state;
  neph_image *clear = render(context, CAMERA LOW_SUN, "false"), *shadowed = render(context, CAMERA LOW_SUN, "true");
  size_t count;
  const float *a = get_channel(clear, "G", &count), *b = get_channel(shadowed, "G", &count);
  assert_memory_equal(a, b, count * sizeof *a);
  neph_image_destroy(clear);
  neph_image_destroy(shadowed);
}

/* A pixel's shadows do not depend on what part of the picture is wanted. */
static void a_crop_is_a_part_of_the_picture(void **state) {
  neph_context *context = *state;
  neph_scene *scene = NULL;
  neph_image *whole = NULL, *part = NULL;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_load_text(context, CAMERA LOW_SUN HILLS, "test.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  desc.sample_count = 1;
  assert_int_equal(neph_render_image(scene, &desc, &whole), NEPH_OK);
  desc.crop_min[0] = 9, desc.crop_min[1] = 4, desc.crop_max[0] = 15, desc.crop_max[1] = 11;
  assert_int_equal(neph_render_image(scene, &desc, &part), NEPH_OK);
  const float *a = neph_image_get_channel(whole, "B"), *b = neph_image_get_channel(part, "B");
  for (int y = 4; y < 11; y++)
    for (int x = 9; x < 15; x++) assert_true(a[y * 24 + x] == b[(y - 4) * 6 + x - 9]);
  neph_image_destroy(part);
  neph_image_destroy(whole);
  neph_scene_destroy(scene);
}

/* ---- A block over the plain ---- */

/* Opaque, 2.5 km wide, and under it its shadow: the sun stands at the zenith, a camera looks through from the side. */
typedef struct block {
  test_world base; /* in the context of the air */
  neph_sky *sky;
  np_air_visibility visibility;
  np_air_shadow shadow;
  const np_lit_air *lit_air; /* NULL: none */
} block;

static const double block_m = 6000.0, half_width_m = 1250.0, voxel_m = 100.0, camera_m = 500.0;

/* An Earth without aerosols, whose light goes on straight nowhere. */
static neph_atmosphere *create_molecules(neph_context *context) {
  test_air clean;
  test_air_start(&clean);
  test_air_scale(&clean, TEST_AEROSOL, 0.0);
  return test_atmosphere_create(context, &clean.desc);
}

static void place_block(block *b, neph_atmosphere *air) {
  test_cloud cloud = test_cloud_make(test_full, 1.0f, np_phase_isotropic());
  cloud.step_m = np_dvec3_make(voxel_m, voxel_m, voxel_m);
  cloud.middle_m = np_dvec3_make(block_m, 0.0, 3000.0);
  *b = (block){.sky = test_sky_create(air, camera_m, 0.0)};
  test_world_init(&b->base, air->context);
  assert_int_equal(test_world_add(&b->base, cloud), NEPH_OK);
  b->base.world.camera_sky = b->sky;
  b->base.world.has_planet = true;
  b->base.world.planet_radius_m = 6360e3;
}

static void cast(block *b, int32_t half_width) {
  const np_lighting *lighting = &b->base.lighting;
  const np_air_rays rays = {.origin = {0, 0, camera_m},
                            .forward = {1.0f, 0.0f, 0.0f},
                            .right = {0.0f, -0.005f, 0.0f},
                            .down = {0.0f, 0.0f, -0.005f},
                            .begin = {-half_width, -half_width},
                            .end = {half_width, half_width},
                            .whole_begin = {-60, -60},
                            .whole_end = {60, 60}};
  const np_air_casters casters = {.count = 1,
                                  .low = {{block_m - half_width_m, -half_width_m, 3000.0 - half_width_m}},
                                  .high = {{block_m + half_width_m, half_width_m, 3000.0 + half_width_m}}};
  assert_int_equal(np_air_visibility_build(b->base.context, &b->base.world, &lighting->sun_optical_depths, &rays,
                                           &casters, NULL, &b->visibility),
                   NEPH_OK);
  assert_int_equal(np_air_shadow_build(&b->visibility, &b->base.world, b->lit_air, NULL, NULL, &b->shadow), NEPH_OK);
}

static void clear_block(block *b) {
  np_air_shadow_clear(&b->shadow);
  np_air_visibility_clear(&b->visibility);
  neph_sky_destroy(b->sky);
  test_world_clear(&b->base);
}

static double compute_first(const block *b, np_vec3 direction, double distance_m, int band) {
  np_spectrum first;
  const np_sky_ray ray = np_sky_ray_start(b->sky, direction);
  (void)np_sky_ray_get_air(&ray, distance_m, &first);
  return (double)first.band[band];
}

static np_air_change get_change(const block *b, np_vec3 direction, double distance_m) {
  return np_air_shadow_get(&b->shadow, &(np_view_ray){.direction = direction}, distance_m, NP_RAY_END_NONE);
}

/* Change of the light of the higher orders: light of the clouds, less what is lost. */
static np_spectrum get_added(const block *b, np_vec3 direction, double distance_m) {
  const np_air_change change = get_change(b, direction, distance_m);
  const np_sky_ray ray = np_sky_ray_start(b->sky, direction);
  np_spectrum first;
  const np_spectrum all = np_sky_ray_get_air(&ray, distance_m, &first).inscatter;
  return np_spectrum_subtract(change.other,
                              np_spectrum_multiply(change.higher_share, np_spectrum_subtract(all, first)));
}

static np_spectrum get_lost(const block *b, np_vec3 direction, double distance_m) {
  return get_change(b, direction, distance_m).lost_share;
}

/* The light lost is that between the planes of the shadow's sides, before it nothing. 4 %: the block's faces are
 * soft over half a voxel at each side. */
static void what_is_lost_lies_in_the_shadow(void **state) {
  neph_atmosphere *air = *state;
  block b;
  place_block(&b, air);
  cast(&b, 40);
  for (int i = -8; i <= 8; i++) {
    const np_vec3 d = np_vec3_normalize(np_vec3_make(1.0f, 0.0137f * (float)i, 0.002f * (float)i));
    const double ends[] = {7.5e3, 20e3, INFINITY};
    for (int e = 0; e < 3; e++)
      for (int band = 0; band < 3; band++) {
        if (d.z < 0.0f && isinf(ends[e])) continue; /* there is ground */
        const double near = (block_m - half_width_m) / (double)d.x, far = (block_m + half_width_m) / (double)d.x;
        const double lost = compute_first(&b, d, far, band) - compute_first(&b, d, near, band);
        const double found = (double)get_lost(&b, d, ends[e]).band[band];
        assert_near_relative(found * compute_first(&b, d, ends[e], band), lost, 0.04);
      }
    assert_near((double)np_spectrum_max(get_lost(&b, d, 4.4e3)), 0.0, 1e-4);
  }
  clear_block(&b);
}

/* Beside the block the air is in the sun. */
static void beside_the_shadow_nothing_is_lost(void **state) {
  neph_atmosphere *air = *state;
  block b;
  place_block(&b, air);
  cast(&b, 120);
  const np_vec3 rays[] = {{1.0f, 0.35f, 0.0f}, {1.0f, -0.35f, 0.1f}};
  for (int i = 0; i < 2; i++) {
    const np_vec3 d = np_vec3_normalize(rays[i]);
    assert_near((double)np_spectrum_max(get_lost(&b, d, INFINITY)), 0.0, 1e-4);
  }
  clear_block(&b);
}

/* Clouds that add a fifth of the sun's irradiance to the actinic flux from above, and three fifths of a tenth to that
 * from below, everywhere: beside the block molecules have the sun's light of the first order and this. 1 %: the sun's
 * transmittance is taken in the middle of each cell. */
static void clouds_light_the_air_around_them(void **state) {
  neph_atmosphere *earth = *state, *air = create_molecules(earth->context);
  block b;
  place_block(&b, air);
  const np_spectrum sun = b.sky->irradiance;
  np_lit_air_value points[4 * NP_LIT_AIR_LEVELS];
  np_lit_air lit = {.size = {2, 2}, .origin_m = {-1e6, -1e6}, .spacing_m = 2e6, .points = points};
  for (int n = 0; n < 4 * NP_LIT_AIR_LEVELS; n++)
    points[n] = (np_lit_air_value){.upper = np_spectrum_scale(sun, 0.2f), .lower = np_spectrum_scale(sun, 0.06f)};
  for (int k = 0; k < NP_LIT_AIR_LEVELS; k++) lit.level_m[k] = 1000.0 * k;
  b.base.world.atmosphere = air;
  b.base.world.sun_irradiance = sun;
  b.lit_air = &lit;
  cast(&b, 120);
  const np_vec3 d = np_vec3_normalize(np_vec3_make(1.0f, 0.35f, 0.01f));
  const np_dvec3 middle = np_dvec3_make(3000.0, 1000.0, camera_m);
  const np_spectrum through = np_atmosphere_transmittance_to_sun(air, middle, b.base.world.to_sun, 0.0f);
  const np_hemisphere_shares shares = np_sky_compute_hemisphere_shares(b.sky, d);
  const np_sky_ray ray = np_sky_ray_start(b.sky, d);
  const np_even_inscatter even = np_sky_compute_even_inscatter(&ray, 6e3, &shares);
  for (int band = 0; band < 3; band++) {
    const double flux[2] = {0.2 / (double)through.band[band], 0.06 / (double)through.band[band]};
    const double found = (double)get_added(&b, d, 6e3).band[band];
    const double expected = flux[0] * (double)even.upper.band[band] + flux[1] * (double)even.lower.band[band];
    assert_near_relative(found, expected, 0.01);
  }
  clear_block(&b);
  neph_atmosphere_release(air);
}

/* A block in air that clouds light alike at each height, and the directions of three rays beside it. */
typedef struct lit_block {
  block block;
  np_lit_air lit;
  np_lit_air_value points[4 * NP_LIT_AIR_LEVELS];
  np_vec3 rays[3];
} lit_block;

/* Levels a kilometre apart, without light until `points` and `lit.clear` are filled. */
static void place_lit_block(lit_block *l, neph_atmosphere *air) {
  *l = (lit_block){.lit = {.size = {2, 2}, .origin_m = {-1e6, -1e6}, .spacing_m = 2e6, .points = l->points}};
  place_block(&l->block, air);
  for (int k = 0; k < NP_LIT_AIR_LEVELS; k++) l->lit.level_m[k] = 1000.0 * k;
  for (int i = 0; i < 3; i++)
    l->rays[i] = np_vec3_normalize(np_vec3_make(1.0f, 0.35f - 0.35f * (float)i, 0.01f + 0.1f * (float)i));
  l->block.base.world.atmosphere = air;
  l->block.lit_air = &l->lit;
}

static void set_level(lit_block *l, int level, np_lit_air_value value) {
  for (int n = 0; n < 4; n++) l->points[4 * level + n] = value;
}

/* A beam as strong as the sun's irradiance at each height, from the sun's direction, adds as much light to the air as
 * the sun's light of the first order is. 1 %: the sun's transmittance is taken on the lattice's levels. */
static void a_beam_is_scattered_as_sunlight(void **state) {
  neph_atmosphere *air = *state;
  lit_block l;
  place_lit_block(&l, air);
  const block *b = &l.block;
  const np_vec3 to_sun = b->base.world.to_sun;
  for (int k = 0; k < NP_LIT_AIR_LEVELS; k++) {
    const np_dvec3 at = np_dvec3_make(3000.0, 1000.0, l.lit.level_m[k]);
    const np_spectrum through = np_atmosphere_transmittance_to_sun(air, at, to_sun, 0.0f);
    set_level(&l, k, (np_lit_air_value){.beam = np_spectrum_multiply(through, b->sky->irradiance), .way = to_sun});
  }
  cast(&l.block, 120);
  for (int i = 0; i < 3; i++)
    for (int band = 0; band < 3; band++)
      assert_near_relative((double)get_added(b, l.rays[i], 4e3).band[band], compute_first(b, l.rays[i], 4e3, band),
                           0.01);
  clear_block(&l.block);
}

/* Molecules to which clouds leave none of the sky's and the ground's light have the sun's light of the first order
 * alone, in whatever direction the rest of it was scattered. 1e-3: the clear light is not even, and is taken as a
 * share. */
static void air_without_sky_and_ground_has_no_higher_order(void **state) {
  neph_atmosphere *earth = *state, *air = create_molecules(earth->context);
  lit_block l;
  place_lit_block(&l, air);
  for (int k = 0; k < NP_LIT_AIR_LEVELS; k++) {
    l.lit.clear[k] = (np_clear_flux){np_spectrum_grey(0.4f), np_spectrum_grey(0.2f)};
    set_level(&l, k,
              (np_lit_air_value){.upper = np_spectrum_grey(-0.4f),
                                 .hidden = np_spectrum_grey(-0.4f),
                                 .lower = np_spectrum_grey(-0.2f)});
  }
  cast(&l.block, 120);
  for (int i = 0; i < 3; i++) {
    const np_sky_ray ray = np_sky_ray_start(l.block.sky, l.rays[i]);
    np_spectrum first;
    const np_spectrum all = np_sky_ray_get_air(&ray, 4e3, &first).inscatter;
    for (int band = 0; band < 3; band++)
      assert_near_relative((double)get_added(&l.block, l.rays[i], 4e3).band[band],
                           (double)(first.band[band] - all.band[band]), 1e-3);
  }
  clear_block(&l.block);
  neph_atmosphere_release(air);
}

/* Optical depth of a kilometre of the air, of what haze scatters straight on. */
static double get_forward_rate(const neph_atmosphere *air, double height_m, int band) {
  np_scattering there;
  np_scattering_at(&air->medium, height_m, &there);
  return (double)np_bands_to_spectrum(np_aerosol_sum(&air->medium, &there, 2)).band[band] * 1000.0;
}

/* Haze hands on the shade of the block: the first order's light that a cell loses at a distance t is lost as often
 * again as haze scatters it straight on, e^(Φ + s) − 1, along t and, at the zenith, from a scale height of 1.2 km.
 * Other light is too bright for the sun's surroundings to add to it. 5 %: the block's faces are soft, and cells have
 * 0.2 of its width. */
static void haze_hands_on_the_shade(void **state) {
  neph_atmosphere *air = *state;
  lit_block l;
  place_lit_block(&l, air);
  const block *b = &l.block;
  const np_clear_flux bright = {np_spectrum_grey(10.0f), np_spectrum_grey(0.0f)};
  for (int k = 0; k < NP_LIT_AIR_LEVELS; k++) l.lit.clear[k] = bright;
  cast(&l.block, 40);
  const double near = block_m - half_width_m, far = block_m + half_width_m, scale_km = 1.2;
  const np_vec3 d = np_vec3_make(1.0f, 0.0f, 0.0f);
  for (int band = 0; band < 3; band++) {
    const double rate = get_forward_rate(air, camera_m, band), to_sun = rate * scale_km;
    double expected = 0.0;
    for (int k = 0; k < 100; k++) {
      const double begin = near + (far - near) * k / 100, end = near + (far - near) * (k + 1) / 100;
      const double lost = compute_first(b, d, end, band) - compute_first(b, d, begin, band);
      expected -= lost * expm1(rate * 0.5 * (begin + end) / 1000.0 + to_sun);
    }
    assert_true(expected < -1e-3 * compute_first(b, d, far, band));
    const np_sky_ray ray = np_sky_ray_start(b->sky, d);
    const double unit = (double)np_sky_ray_get_air(&ray, 20e3, NULL).inscatter.band[band] / (double)NP_AIR_SHADOW_UNIT;
    assert_near((double)get_added(b, d, 20e3).band[band], expected, 0.05 * fabs(expected) + 2.0 * unit);
  }
  clear_block(&l.block);
}

/* Molecules alone scatter as much of the even light of either hemisphere as they scatter once, over 4π times their
 * phase function. */
static void even_light_is_scattered_without_a_phase_function(void **state) {
  neph_atmosphere *earth = *state, *air = create_molecules(earth->context);
  neph_sky *sky = test_sky_create(air, camera_m, 40.0);
  for (int i = 0; i < 12; i++) {
    const np_vec3 d = np_dvec3_to_float(test_direction(15.0 * i, 25.0 * i));
    const double cosine = (double)np_vec3_dot(d, sky->sun);
    const np_hemisphere_shares shares = np_sky_compute_hemisphere_shares(sky, d);
    const np_sky_ray ray = np_sky_ray_start(sky, d);
    const np_even_inscatter even = np_sky_compute_even_inscatter(&ray, 400.0, &shares);
    for (int band = 0; band < 3; band++) {
      const double once = (double)even.first.band[band] / (0.75 * (1.0 + cosine * cosine));
      assert_near_relative((double)even.upper.band[band], once, 1e-5);
      assert_near_relative((double)even.lower.band[band], once, 1e-5);
    }
  }
  neph_sky_destroy(sky);
  neph_atmosphere_release(air);
}

/* Aerosols of mean cosine 0.8 along level rays scatter as much of either hemisphere; along opposite rays the
 * hemispheres change places; and straight up they scatter ∫ p over the angles below 90° of the light from above: 0.949
 * for Henyey and Greenstein's function, (1+g)/2g·(1 − (1−g)/√(1+g²)), and within 0.02 for the air's function. */
static void aerosols_scatter_forward_from_either_hemisphere(void **state) {
  neph_atmosphere *air = *state;
  neph_sky *sky = test_sky_create(air, camera_m, 40.0);
  const np_hemisphere_shares up = np_sky_compute_hemisphere_shares(sky, np_vec3_make(0.0f, 0.0f, 1.0f));
  const np_hemisphere_shares level = np_sky_compute_hemisphere_shares(sky, np_vec3_make(0.6f, 0.8f, 0.0f));
  for (int band = 0; band < 3; band++) {
    assert_near((double)level.upper.band[band], 0.5, 1e-3);
    assert_near((double)up.upper.band[band], 0.949, 0.02);
  }
  for (int i = 1; i < 6; i++) {
    const np_vec3 d = np_dvec3_to_float(test_direction(15.0 * i, 50.0 * i));
    const np_hemisphere_shares there = np_sky_compute_hemisphere_shares(sky, d);
    const np_hemisphere_shares back = np_sky_compute_hemisphere_shares(sky, np_vec3_scale(d, -1.0f));
    for (int band = 0; band < 3; band++) {
      assert_near((double)there.upper.band[band], (double)back.lower.band[band], 1e-3);
      assert_near((double)(there.upper.band[band] + there.lower.band[band]), 1.0, 1e-6);
    }
  }
  neph_sky_destroy(sky);
}

static void without_casters_nothing_is_kept(void **state) {
  neph_atmosphere *air = *state;
  block b;
  place_block(&b, air);
  cast(&b, 4);
  np_air_visibility none;
  const np_air_rays rays = b.visibility.rays;
  const np_air_casters nothing = {.count = 0};
  assert_int_equal(np_air_visibility_build(air->context, &b.base.world, &b.base.lighting.sun_optical_depths, &rays,
                                           &nothing, NULL, &none),
                   NEPH_OK);
  assert_null(none.seen);
  clear_block(&b);
}

static int set_up(void **state) { return *state = test_context_create(2, NULL), 0; }
static int tear_down(void **state) { return neph_context_destroy(*state), 0; }

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(hills_darken_the_air_behind_them),
      cmocka_unit_test(hills_hide_sky_from_the_air),
      cmocka_unit_test(low_hills_change_little),
      cmocka_unit_test(light_comes_over_a_ridge),
      cmocka_unit_test(thick_haze_among_hills_stays_between),
      cmocka_unit_test(where_nothing_stands_nothing_changes),
      cmocka_unit_test(a_crop_is_a_part_of_the_picture),
  };
  const struct CMUnitTest blocks[] = {
      cmocka_unit_test(what_is_lost_lies_in_the_shadow),
      cmocka_unit_test(beside_the_shadow_nothing_is_lost),
      cmocka_unit_test(clouds_light_the_air_around_them),
      cmocka_unit_test(a_beam_is_scattered_as_sunlight),
      cmocka_unit_test(air_without_sky_and_ground_has_no_higher_order),
      cmocka_unit_test(haze_hands_on_the_shade),
      cmocka_unit_test(even_light_is_scattered_without_a_phase_function),
      cmocka_unit_test(aerosols_scatter_forward_from_either_hemisphere),
      cmocka_unit_test(without_casters_nothing_is_kept),
  };
  return cmocka_run_group_tests(tests, set_up, tear_down) +
         cmocka_run_group_tests(blocks, test_earth_start, test_earth_end);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of the night: moonlight that adds up, darkness, and nothing by day. */
#include "test_nights.h"
#include "test_render_once.h"

#include "atmosphere/moon.h"
#include "stages/assembly.h"

static const char *const bands[NP_BAND_COUNT] = {"R", "G", "B"};

/* ---- Moonlight ---- */

#define CAMERA "camera: {position: [0 m, 0 m, 500 m], look_at: [0 m, 1 km, 700 m], fov: 60 deg, resolution: [24, 16]}\n"

/* Transfer is linear: the sky under a moon is that under a sun of its place and size, times how much fainter it is. */
static void the_moonlit_sky_is_the_sunlit_one_fainter(void **state) {
  test_fixture *f = *state;
  neph_image *day = paint_sky(f, CAMERA "sun: {elevation: 30 deg, azimuth: 120 deg, angular_radius: 0.258966 deg}", 32);
  neph_image *night = paint_sky(f,
                                CAMERA "sun: {elevation: -35 deg, azimuth: 290 deg}\n"
                                       "moon: {elevation: 30 deg, azimuth: 120 deg, earthshine: false}",
                                32);
  const np_moon_place moon = np_moon_place_between(
      np_dvec3_make(cos(NP_PI / 6) * sin(2 * NP_PI / 3), cos(NP_PI / 6) * cos(2 * NP_PI / 3), 0.5),
      np_dvec3_make(cos(-35 * NP_DEGREE) * sin(290 * NP_DEGREE), cos(-35 * NP_DEGREE) * cos(290 * NP_DEGREE),
                    sin(-35 * NP_DEGREE)));
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const double ratio = np_moon_irradiance_ratio(&moon, bands_nm[b]);
    const float *sunlit = neph_image_get_channel(day, bands[b]), *moonlit = neph_image_get_channel(night, bands[b]);
    for (size_t p = 0; p < count_pixels(day); p++)
      assert_near_relative((double)moonlit[p], ratio * (double)sunlit[p], 1e-4); /* floats; 6 digits of the radius */
  }
  neph_image_destroy(day);
  neph_image_destroy(night);
}

/* Extinction of the Earth's air over 2800 m, magnitudes for an air mass of 1 in green. */
static double compute_extinction(neph_context *context) {
  neph_atmosphere *atmosphere;
  const double position[3] = {0, 0, 2800}, up[3] = {0, 0, 1};
  double transmittance[3];
  assert_int_equal(neph_atmosphere_create(context, NULL, &atmosphere), NEPH_OK);
  neph_atmosphere_get_transmittance(atmosphere, position, up, transmittance);
  neph_atmosphere_release(atmosphere);
  return -2.5 * log10(transmittance[1]);
}

/* Measured over Mauna Kea: Krisciunas and Schaefer 1991, equations 3, 15 (a full moon), 16 (of its f the part of
 * molecules: our air is nearly free of dust) and 27. They state errors of 8 to 23 %, a quarter of a magnitude. */
static void the_moonlit_zenith_is_as_bright_as_measured(void **state) {
  test_fixture *f = *state;
  const double extinction = compute_extinction(f->context), arc_second = NP_DEGREE / 3600.0;
  for (int angle = 30; angle <= 60; angle += 15) {
    char text[256];
    snprintf(text, sizeof text,
             "camera: {position: [0 m, 0 m, 2800 m], look_at: [0 m, 1 m, 2800 m]}\n"
             "sun: {elevation: %d deg, azimuth: 0 deg}\nmoon: {elevation: %d deg, azimuth: 180 deg}",
             angle - 90, 90 - angle);
    neph_image *image = paint_sky(f, text, 360);
    const double radiance = (double)neph_image_get_channel(image, "G")[0];
    const double c = cos(angle * NP_DEGREE), mass = 1.0 / sqrt(1.0 - 0.96 * (1.0 - c * c));
    const double nanolamberts = pow(10.0, 5.36) * (1.06 + c * c) * pow(10.0, -0.4 * 3.84) *
                                pow(10.0, -0.4 * extinction * mass) * (1.0 - pow(10.0, -0.4 * extinction));
    const double measured = (20.7233 - log(nanolamberts / 34.08)) / 0.92104;
    assert_near(-2.5 * log10(radiance * arc_second * arc_second / 3.631e-11), measured, 0.25);
    neph_image_destroy(image);
  }
}

/* Half an hour after sunset sun and moon both count: what a moon twice as bright adds is twice what it adds, on ground
 * and sky alike. Differences of floats a few times larger. */
static void sunlight_and_moonlight_add_up(void **state) {
  test_fixture *f = *state;
  neph_image *image[3];
  for (int i = 0; i < 3; i++) {
    char text[512];
    snprintf(text, sizeof text,
             CAMERA "sun: {elevation: -7 deg, azimuth: 270 deg}\nrender: {samples: 1}\n"
                    "moon: {elevation: 20 deg, azimuth: 80 deg, brightness: %d}",
             i);
    image[i] = render(f, text);
  }
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float *none = neph_image_get_channel(image[0], bands[b]), *once = neph_image_get_channel(image[1], bands[b]);
    const float *twice = neph_image_get_channel(image[2], bands[b]);
    for (size_t p = 0; p < count_pixels(image[0]); p++) {
      assert_true(once[p] > none[p]);
      assert_near((double)twice[p] - (double)once[p], (double)once[p] - (double)none[p], 1e-6 * (double)twice[p]);
    }
  }
  for (int i = 0; i < 3; i++) neph_image_destroy(image[i]);
}

/* A camera on the moon: the bright limb of a waxing half moon is on the side of the sun that has set in the west, on
 * the right when looking south from the northern hemisphere. */
static void the_quarter_moon_is_lit_from_the_sunset(void **state) {
  test_fixture *f = *state;
  neph_image *image = render(f, "camera: {position: [0 m, 0 m, 10 m], look_at: [0 m, -1 km, 588 m], fov: 0.7 deg, "
                                "resolution: [32, 32]}\n"
                                "sun: {elevation: -10 deg, azimuth: 270 deg}\n"
                                "moon: {elevation: 30 deg, azimuth: 180 deg}\n"
                                "render: {samples: 1}");
  const float *green = neph_image_get_channel(image, "G");
  double left = 0.0, right = 0.0;
  for (unsigned y = 12; y < 20; y++)
    for (unsigned x = 8; x < 24; x++) *(x < 16 ? &left : &right) += (double)green[y * 32 + x];
  assert_true(right > 20.0 * left && left > 0.0);
  neph_image_destroy(image);
}

#define TOWARDS_SUN                                                                                                    \
  "camera: {position: [0 m, 0 m, 10 m], look_at: [0 m, -1 km, 587 m], fov: 0.7 deg, resolution: [32, 32]}\n"           \
  "sun: {elevation: 30 deg, azimuth: 180 deg}\nrender: {samples: 1}\n"

/* A new moon before the sun hides it: what is left is the sky, and a ring of sun where the moon is the smaller. */
static void the_moon_hides_the_sun(void **state) {
  test_fixture *f = *state;
  neph_image *open = render(f, TOWARDS_SUN);
  neph_image *eclipsed = render(f, TOWARDS_SUN "moon: {elevation: 30 deg, azimuth: 180 deg}");
  const float *sun = neph_image_get_channel(open, "G"), *ring = neph_image_get_channel(eclipsed, "G");
  assert_true(ring[16 * 32 + 16] < 1e-3f * sun[16 * 32 + 16]);
  float brightest = 0.0f;
  for (size_t p = 0; p < count_pixels(open); p++) brightest = fmaxf(brightest, ring[p]);
  assert_true(brightest > 0.1f * sun[16 * 32 + 16]);
  neph_image_destroy(open);
  neph_image_destroy(eclipsed);
}

/* ---- Darkness ---- */

/* Without moon and with the sun 25° down there are no tables, and no light but airglow; without airglow, none at all.
 */
static void a_moonless_night_is_airglow_alone(void **state) {
  test_fixture *f = *state;
  neph_image *dark = render(f, CAMERA "sun: {elevation: -25 deg}\nmoon: {elevation: -30 deg, azimuth: 0 deg}");
  neph_image *glowing = render(f, CAMERA "sun: {elevation: -25 deg}\nairglow: {}");
  const float *none = neph_image_get_channel(dark, "G"), *some = neph_image_get_channel(glowing, "G");
  for (size_t p = 0; p < count_pixels(dark); p++) {
    assert_near((double)none[p], 0.0, 0.0);
    assert_true(some[p] > 0.0f && some[p] < 1e-7f);
  }
  neph_image_destroy(dark);
  neph_image_destroy(glowing);
}

/* Airglow, all over the sky, is scattered out of a ray and into it: 80° from the zenith it is brighter than there, in
 * blue too, of which the air takes all but a fifth from a star. */
static void airglow_brightens_towards_the_horizon(void **state) {
  test_fixture *f = *state;
  neph_image *image = paint_sky(f,
                                "camera: {position: [0 m, 0 m, 0 m], look_at: [0 m, 1 m, 0 m]}\n"
                                "sun: {elevation: -30 deg}\nairglow: {}",
                                36);
  for (int b = 0; b < NP_BAND_COUNT; b++) {
    const float *plane = neph_image_get_channel(image, bands[b]); /* rows of 10 degrees */
    assert_true(plane[7 * 36] > 1.5f * plane[0] && plane[7 * 36] < 4.0f * plane[0]);
    assert_near((double)plane[9 * 36], 0.0, 0.0);
  }
  neph_image_destroy(image);
}

/* A sky down to 18°; by 19° it has faded to nothing, and never brightens on the way. */
static void the_sky_fades_out_by_nineteen_degrees(void **state) {
  test_fixture *f = *state;
  double before = INFINITY;
  for (int i = 0; i <= 12; i++) {
    char text[256];
    snprintf(text, sizeof text,
             "camera: {position: [0 m, 0 m, 0 m], look_at: [0 m, 1 m, 0 m]}\n"
             "sun: {elevation: %.2f deg, azimuth: 0 deg}",
             -17.8 - 0.1 * i);
    neph_image *image = paint_sky(f, text, 8);
    const double zenith = (double)neph_image_get_channel(image, "G")[0];
    assert_true(zenith >= 0.0 && zenith <= before);
    if (i == 12) assert_near(zenith, 0.0, 0.0);
    if (i <= 2) assert_true(zenith > 0.0);
    before = zenith;
    neph_image_destroy(image);
  }
}

#define ALL_NIGHT                                                                                                      \
  "place: {latitude: 45 deg, longitude: 0 deg}\nstars: {sidereal_time: 90 deg}\nairglow: {}\n"                         \
  "camera: {look_at: [0 m, -12 km, 4 km], fov: 90 deg}\n"

static const char whole_night[] =
    ALL_NIGHT "sun: {elevation: -8 deg, azimuth: 270 deg}\nmoon: {elevation: 40 deg, azimuth: 100 deg}\n";

/* Stars are not of a sample but of the picture; yet a part of it has the bits of the whole. */
static void a_part_of_the_night_has_the_bits_of_the_whole(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load(f, whole_night);
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  desc.width = desc.crop_max[0] = 60;
  desc.height = desc.crop_max[1] = 40;
  desc.sample_count = 2;
  neph_image *whole, *part;
  assert_int_equal(neph_render_image(scene, &desc, &whole), NEPH_OK);
  desc.crop_min[0] = 17;
  desc.crop_min[1] = 5;
  assert_int_equal(neph_render_image(scene, &desc, &part), NEPH_OK);
  const float *all = neph_image_get_channel(whole, "G"), *some = neph_image_get_channel(part, "G");
  for (unsigned y = 0; y < 35; y++) assert_memory_equal(all + (y + 5) * 60 + 17, some + y * 43, 43 * sizeof *all);
  neph_image_destroy(whole);
  neph_image_destroy(part);
  neph_scene_destroy(scene);
}

/* Halves cannot hold a night as it is: it is written as float. The warning says by what to multiply it, and then they
 * do. */
static void halves_of_a_night_name_their_scale(void **state) {
  test_fixture *f = *state;
  neph_image *image = render(f, CAMERA "sun: {elevation: -25 deg}\nairglow: {}");
  char text[512];
  double scale = 0.0;
  assert_int_equal(neph_image_save_exr(image, f->path, NEPH_PIXEL_HALF), NEPH_OK);
  assert_non_null(strstr(f->log.text, "set output.scale to "));
  assert_int_equal(sscanf(strstr(f->log.text, "set output.scale to "), "set output.scale to %lf", &scale), 1);
  snprintf(text, sizeof text, CAMERA "sun: {elevation: -25 deg}\nairglow: {}\noutput: {scale: %.17g}", scale);
  assert_one_warning(&f->log, "written as float");
  neph_image_destroy(image);
  image = render(f, text);
  assert_int_equal(neph_image_save_exr(image, f->path, NEPH_PIXEL_HALF), NEPH_OK);
  assert_int_equal(f->log.counts[NEPH_LOG_WARNING], 0);
  neph_image_destroy(image);
}

/* ---- Cost ---- */

static void assert_lights(test_fixture *f, const char *text, unsigned lights, bool has_stars, bool has_airglow) {
  neph_scene *scene = load(f, text);
  np_plan plan;
  np_stores stores = {.results = NULL};
  const np_build_job job = np_build_job_make(&stores);
  np_assembly assembly;
  np_monitor monitor;
  np_monitor_start(&monitor, f->context, NULL, NULL);
  assert_int_equal(np_plan_make(scene, NULL, &plan), NEPH_OK);
  assert_int_equal(np_assembly_build(scene, &plan, &job, &monitor, &assembly), NEPH_OK);
  assert_int_equal(assembly.packets[0].light_count, lights);
  assert_int_equal(assembly.packets[0].stars.count > 0, has_stars);
  assert_int_equal(assembly.packets[0].night.has_airglow, has_airglow);
  np_assembly_clear(&assembly);
  np_plan_clear(&plan);
  np_stores_clear(f->context, &stores);
  neph_scene_destroy(scene);
}

static void by_day_the_night_costs_nothing(void **state) {
  test_fixture *f = *state;
  assert_lights(f, ALL_NIGHT "sun: {elevation: 50 deg}\nmoon: {elevation: 40 deg, azimuth: 300 deg}", 1, false, false);
  assert_lights(f, ALL_NIGHT "sun: {elevation: -5 deg, azimuth: 270 deg}\nmoon: {elevation: 40 deg, azimuth: 100 deg}",
                2, true, false);
  assert_lights(f, ALL_NIGHT "sun: {elevation: -30 deg}\nmoon: {elevation: 40 deg, azimuth: 100 deg}", 1, true, true);
  /* A set moon, and a slip of one at dusk, shine on nothing. */
  assert_lights(f, ALL_NIGHT "sun: {elevation: -30 deg}\nmoon: {elevation: -10 deg, azimuth: 100 deg}", 1, true, true);
  assert_lights(f, ALL_NIGHT "sun: {elevation: -2 deg, azimuth: 270 deg}\nmoon: {elevation: 8 deg, azimuth: 270 deg}",
                1, true, false);
}

static void the_plan_says_what_outshines_the_night(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load(f, ALL_NIGHT "sun: {elevation: 50 deg}\nmoon: {elevation: 40 deg, azimuth: 300 deg}");
  char *text;
  assert_int_equal(neph_render_explain(scene, NULL, NEPH_TEXT_PLAIN, &text), NEPH_OK);
  assert_non_null(strstr(text, "moon                 no   outshone"));
  assert_non_null(strstr(text, "less than a thousandth"));
  assert_non_null(strstr(text, "stars                no   outshone"));
  neph_text_destroy(f->context, text);
  neph_scene_destroy(scene);
}

/* ---- Wrong scenes ---- */

static void assert_refused(test_fixture *f, const char *text, const char *what, const char *allowed) {
  neph_scene *scene;
  assert_int_equal(neph_scene_load_text(f->context, text, "night.yaml", &scene), NEPH_ERROR_BAD_SCENE);
  assert_one_error(&f->log, "night.yaml:", what, allowed);
  assert_null(scene);
}

static void wrong_nights_are_refused(void **state) {
  test_fixture *f = *state;
  assert_refused(f, "moon: {}", "moon has no position", "sun.time");
  assert_refused(f, "moon: {elevation: 10 deg}", "moon has one of elevation and azimuth", "both or neither");
  assert_refused(f, "moon: {elevation: 95 deg, azimuth: 0 deg}", "moon.elevation is 95 deg", "[-90, 90]");
  assert_refused(f, "moon: {brightness: -1}", "moon.brightness is -1", "[0,");
  assert_refused(f, "moon: full", "moon is full", "none");
  assert_refused(f, "stars: {}", "stars have no orientation", "sidereal_time");
  assert_refused(f, "stars: {sidereal_time: 3 deg}", "stars need the latitude", "place");
  assert_refused(f, "stars: {twinkling: 2}", "stars.twinkling is 2", "[0, 1]");
  assert_refused(f, "stars: {map_radiance: -2}", "stars.map_radiance is -2", "[0,");
  assert_refused(f, "stars: {faintest: 41}", "stars.faintest is 41", "[-2, 40]");
  assert_refused(f, "airglow: {magnitude: 41}", "airglow.magnitude is 41", "[0, 40]");
  assert_refused(f, "airglow: {altitude: 1 m}", "airglow.altitude is 1 m", "[1000");
  assert_refused(f, "sun: {limb_darkening: 1}", "sun.limb_darkening is 1", "true");
}

static void missing_files_are_named(void **state) {
  test_fixture *f = *state;
  neph_scene *scene = load(f, "place: {latitude: 1 deg, longitude: 1 deg}\nsun: {elevation: -30 deg}\n"
                              "stars: {catalogue: nowhere.csv, sidereal_time: 0 deg}");
  neph_image *image;
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_ERROR_NOT_FOUND);
  assert_one_error(&f->log, "nowhere.csv");
  assert_null(image);
  neph_scene_destroy(scene);
}

static void failed_allocations_leave_nothing(void **state) {
  (void)state;
  static char text[] = "place: {latitude: 45 deg, longitude: 0 deg}\nsun: {elevation: -30 deg}\natmosphere: none\n"
                       "moon: {elevation: 30 deg, azimuth: 20 deg}\nstars: {sidereal_time: 10 deg}\nairglow: {}\n"
                       "camera: {resolution: [4, 4]}\nrender: {samples: 1}";
  assert_survives_failed_allocations(test_render_once, text);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(the_moonlit_sky_is_the_sunlit_one_fainter),
      TEST(the_moonlit_zenith_is_as_bright_as_measured),
      TEST(sunlight_and_moonlight_add_up),
      TEST(the_quarter_moon_is_lit_from_the_sunset),
      TEST(the_moon_hides_the_sun),
      TEST(a_moonless_night_is_airglow_alone),
      TEST(airglow_brightens_towards_the_horizon),
      TEST(the_sky_fades_out_by_nineteen_degrees),
      TEST(a_part_of_the_night_has_the_bits_of_the_whole),
      TEST(halves_of_a_night_name_their_scale),
      TEST(by_day_the_night_costs_nothing),
      TEST(the_plan_says_what_outshines_the_night),
      TEST(wrong_nights_are_refused),
      TEST(missing_files_are_named),
      cmocka_unit_test(failed_allocations_leave_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

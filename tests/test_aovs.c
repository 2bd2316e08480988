/* SPDX-License-Identifier: Apache-2.0 */
/* Known answers for the channels of ground and shadow: normals of a plane and a slope, full light, the shadow of a
 * wall, of a slab and of a cloud on itself; and asking for them changes no other channel. */
#include <nephos/nephos.h>

#include "core/units.h"
#include "test_world.h"

static int set_up(void **state) { return test_set_up_cached(state, 2, NULL); }

/* ---- Pictures of ground ---- */

enum { SIDE = 481, EDGE = 16 };
static const double field_m = 24e3, slope_rad = 20.0 * NP_DEGREE, wall_m = 1000.0;

static double get_east_m(unsigned column) { return field_m * (column / (SIDE - 1.0) - 0.5); }

static float raise_slope(unsigned column) { return (float)(tan(slope_rad) * get_east_m(column)); }

/* Samples are 50 m apart. */
static float raise_wall(unsigned column) { return fabs(get_east_m(column)) < 130.0 ? (float)wall_m : 0.0f; }

static void write_field(test_fixture *f, float (*raise)(unsigned column)) {
  static const char *const name = "Y";
  neph_image *image = NULL;
  char *path = test_path(f->folder, "field.exr");
  assert_int_equal(neph_image_create(f->context, SIDE, SIDE, 1, &name, &image), NEPH_OK);
  float *values = neph_image_get_channel(image, name);
  for (unsigned i = 0; i < SIDE * SIDE; i++) values[i] = raise(i % SIDE);
  assert_int_equal(neph_image_save_exr(image, path, NEPH_PIXEL_FLOAT), NEPH_OK);
  neph_image_destroy(image);
  free(path);
}

/* 100 m of ground around (east_m, 0), seen from 3 km above it. */
static neph_image *look_down(test_fixture *f, const char *terrain, double east_m, const char *integrator) {
  char text[1024];
  (void)snprintf(text, sizeof text,
                 "version: 1\n"
                 "camera: {position: [%g m, 0 m, 3 km], look_at: [%g m, 0 m, 0 m], fov: 2 deg,\n"
                 "  resolution: [%d, %d]}\n"
                 "sun: {elevation: 30 deg, azimuth: 90 deg}\n"
                 "atmosphere: {preset: none}\n"
                 "%s\n"
                 "render: {samples: 2, integrator: %s}\n"
                 "output: {beauty: false, aovs: [normal, shadow]}\n",
                 east_m, east_m, EDGE, EDGE, terrain, integrator);
  char *path = test_path(f->folder, "scene.yaml");
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_load_text(f->context, text, path, &scene), NEPH_OK);
  assert_int_equal(neph_scene_get_render_desc(scene, &desc), NEPH_OK);
  assert_int_equal(neph_render_image(scene, &desc, &image), NEPH_OK);
  neph_scene_destroy(scene);
  free(path);
  return image;
}

static void assert_all(neph_image *image, const char *channel, double expected, double tolerance) {
  const float *values = neph_image_get_channel(image, channel);
  for (unsigned i = 0; i < EDGE * EDGE; i++) assert_near((double)values[i], expected, tolerance);
}

static const char field[] = "terrain: {heightfield: field.exr, width: 24 km}";
static const char *const integrators[] = {"march", "path"};

/* The sphere turns by 8e-6 over the 50 m to the picture's rim; floats leave 1e-7. */
static void a_plain_looks_up_and_is_lit(void **state) {
  test_fixture *f = *state;
  for (unsigned i = 0; i < 2; i++) {
    neph_image *image = look_down(f, "", 0.0, integrators[i]);
    assert_all(image, "normal.X", 0.0, 1e-5);
    assert_all(image, "normal.Y", 0.0, 1e-5);
    assert_all(image, "normal.Z", 1.0, 1e-6);
    assert_all(image, "shadow", 1.0, 0.0);
    neph_image_destroy(image);
  }
}

/* 1e-4: floats of vertices 50 m apart that lie up to 12 km from the field's middle. */
static void a_slope_leans_by_its_inclination(void **state) {
  test_fixture *f = *state;
  write_field(f, raise_slope);
  for (unsigned i = 0; i < 2; i++) {
    neph_image *image = look_down(f, field, 500.0, integrators[i]);
    assert_all(image, "normal.X", -sin(slope_rad), 1e-4);
    assert_all(image, "normal.Y", 0.0, 1e-4);
    assert_all(image, "normal.Z", cos(slope_rad), 1e-4);
    assert_all(image, "shadow", 1.0, 0.0);
    neph_image_destroy(image);
  }
}

/* A wall of 1 km before a sun 30° high throws a shadow of 1.73 km, to the west. */
static void a_wall_throws_a_shadow(void **state) {
  test_fixture *f = *state;
  write_field(f, raise_wall);
  static const struct {
    double east_m, share;
  } places[] = {{-1000.0, 0.0}, {-1700.0, 0.0}, {-2200.0, 1.0}, {1000.0, 1.0}};
  for (unsigned i = 0; i < 2; i++)
    for (unsigned p = 0; p < 4; p++) {
      neph_image *image = look_down(f, field, places[p].east_m, integrators[i]);
      assert_all(image, "shadow", places[p].share, 0.0);
      neph_image_destroy(image);
    }
}

/* Nothing hides anything: no normal, no shadow. */
static void the_sky_has_neither(void **state) {
  test_fixture *f = *state;
  neph_image *image = look_down(f, "environment: {planet: none}", 0.0, "march");
  assert_all(image, "normal.Z", 0.0, 0.0);
  assert_all(image, "shadow", 1.0, 0.0);
  neph_image_destroy(image);
}

/* ---- Clouds ---- */

/* A box of cloud over a planet's ground, under a point sun. */
static void start_cloud(test_world *w, float extinction_per_m, np_dvec3 middle_m) {
  test_cloud cloud = test_cloud_make(test_full, extinction_per_m, np_phase_henyey_greenstein(0.8f));
  cloud.middle_m = middle_m;
  test_world_create(w, 1, cloud);
  w->world.has_planet = true;
  w->world.planet_radius_m = 6360e3;
  w->world.sun_irradiance = np_spectrum_grey(1.0f);
  w->settings.has_sun_share = true;
}

/* Mean over a sample's opacity, and its standard error. */
static void measure_shadow(const test_world *w, bool is_path, np_dvec3 origin, np_vec3 direction, int count,
                           double *out_mean, double *out_error) {
  double sum = 0.0, squares = 0.0;
  np_random random = np_random_start(1, 2, 3, 4, 5);
  for (int n = 0; n < count; n++) {
    const np_camera_ray ray = {.origin = origin, .direction = direction, .jitter = np_random_float(&random)};
    np_integrator_sample sample;
    (is_path ? test_world_path : test_world_march)(w, &ray, &random, &sample);
    sum += (double)sample.opaque_sun_share;
    squares += (double)(sample.opaque_sun_share * sample.opaque_sun_share);
  }
  *out_mean = sum / count;
  *out_error = sqrt(fmax(squares / count - *out_mean * *out_mean, 0.0) / count);
}

/* Below a slab of depth τ = 1.2, its column the sum of its samples, e^{−τ} of the sunlight arrives: in the march to the
 * 1 % of its tolerance, in the mean of paths within four standard errors. */
static void ground_below_a_slab_is_as_dark_as_beers_law_says(void **state) {
  (void)state;
  test_world w;
  start_cloud(&w, 1.2f / TEST_EDGE, np_dvec3_make(0.0, 0.0, 100.0));
  const np_dvec3 origin = np_dvec3_make(0.3, 0.2, 50.0);
  const np_vec3 down = np_vec3_make(0, 0, -1);
  double mean, error;
  measure_shadow(&w, false, origin, down, 4, &mean, &error);
  assert_near_relative(mean, exp(-1.2), 0.012);
  measure_shadow(&w, true, origin, down, 20000, &mean, &error);
  assert_true(error < 0.01);
  assert_near(mean, exp(-1.2), 4.0 * error);
  test_world_destroy(&w);
}

/* Seen from the sun, the places of a thick cloud that hide what is behind them, ∫e^{−t}·e^{−t} dt, are half lit; seen
 * from below they are dark. 2 %: the march's steps. */
static void a_thick_cloud_is_half_lit_from_the_sun(void **state) {
  (void)state;
  test_world w;
  start_cloud(&w, 2.0f, np_dvec3_make(0.0, 0.0, 100.0));
  double mean, error;
  for (int is_path = 0; is_path < 2; is_path++) {
    measure_shadow(&w, is_path, np_dvec3_make(0.3, 0.2, 200.0), np_vec3_make(0, 0, -1), 4000, &mean, &error);
    assert_near(mean, 0.5, 4.0 * error + (is_path ? 0.0 : 0.01));
    measure_shadow(&w, is_path, np_dvec3_make(0.3, 0.2, 50.0), np_vec3_make(0, 0, 1), 200, &mean, &error);
    assert_near(mean, 0.0, 1e-6);
  }
  test_world_destroy(&w);
}

/* The same random numbers go into all else. */
static void asking_changes_nothing_else(void **state) {
  (void)state;
  test_world w;
  start_cloud(&w, 0.1f, np_dvec3_make(0.0, 0.0, 100.0));
  for (int is_path = 0; is_path < 2; is_path++) {
    np_integrator_sample samples[2];
    for (int asks = 0; asks < 2; asks++) {
      w.settings.has_sun_share = asks;
      np_random random = np_random_start(7, 0, 0, 0, 0);
      const np_camera_ray ray = {.origin = {0.3, 0.2, 200.0}, .direction = {0, 0, -1}, .jitter = 0.5f};
      (is_path ? test_world_path : test_world_march)(&w, &ray, &random, &samples[asks]);
    }
    assert_true(samples[0].opaque_sun_share == 0.0f && samples[1].opaque_sun_share > 0.0f);
    samples[1].opaque_sun_share = 0.0f;
    assert_memory_equal(&samples[0], &samples[1], sizeof samples[0]);
  }
  test_world_destroy(&w);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(a_plain_looks_up_and_is_lit),
      TEST(a_slope_leans_by_its_inclination),
      TEST(a_wall_throws_a_shadow),
      TEST(the_sky_has_neither),
      cmocka_unit_test(ground_below_a_slab_is_as_dark_as_beers_law_says),
      cmocka_unit_test(a_thick_cloud_is_half_lit_from_the_sun),
      cmocka_unit_test(asking_changes_nothing_else),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

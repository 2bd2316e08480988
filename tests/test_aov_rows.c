/* SPDX-License-Identifier: Apache-2.0 */
/* A known answer for each AOV, by both integrators: a row of np_aov_rows without an example fails. The scenes are so
 * simple that a channel is a number, or the whole picture but for one other channel. */
#include <nephos/nephos.h>

#include <stdlib.h>

#include "core/units.h"
#include "image/aov.h"
#include "image/image_private.h"
#include "test_box_files.h"

enum { SIDE = 4, PIXELS = SIDE * SIDE, SAMPLES = 2 };

static int set_up(void **state) { return test_set_up_cached(state, 2, NULL); }

/* ---- Scenes ---- */

/* Every camera looks straight down. A box of cloud of 16 voxels of 1 m hangs 8 m above the ground. */
#define HIGH "camera: {position: [0 m, 0 m, 3 km], look_at: [0 m, 0 m, 0 m], fov: 2 deg, resolution: [4, 4]}\n"
#define LOW "camera: {position: [16 m, 16 m, 1 km], look_at: [16 m, 16 m, 0 m], fov: 1 deg, resolution: [4, 4]}\n"
#define UP "camera: {position: [0 m, 0 m, 10 m], look_at: [0 m, 9 m, 15 m], fov: 9 deg, resolution: [4, 4]}\n"
#define NO_AIR "atmosphere: {preset: none, ground_albedo: 0.3}\n"
#define SPACE "environment: {planet: none}\n"
#define BOX "clouds: [{name: box, vdb: box.vdb, extinction: 0.075 1/m, phase: {hg: 0.5}}]\n"
#define SINGLE "render: {max_scatterings: 1}\n"

/* A pixel of the ground is as long as the way of the camera in a frame. */
static const char ground[] = HIGH NO_AIR "animate:\n"
                                         "  camera.position: [[1, [0 m, 0 m, 3 km]], [2, [26.183 m, 0 m, 3 km]]]\n"
                                         "  camera.look_at: [[1, [0 m, 0 m, 0 m]], [2, [26.183 m, 0 m, 0 m]]]\n";
static const char stars[] = UP NO_AIR "environment: {planet: none, radiance: 1}\nsun: {irradiance: 0}\n";
static const char haze[] = LOW "atmosphere: {tolerance: 0.1}\n";
static const char sunlit[] = LOW NO_AIR SPACE BOX SINGLE;
static const char skylit[] = LOW NO_AIR BOX SINGLE
    "environment: {planet: none, radiance: 1}\nsun: {irradiance: 0}\noutput: {film: {background: false}}\n";
static const char over_ground[] = LOW NO_AIR BOX SINGLE;
static const char cloud[] = LOW NO_AIR SPACE BOX "airglow: none\n";
static const char cloud_in_haze[] = LOW "atmosphere: {tolerance: 0.1}\n" BOX;
static const char fire[] = LOW NO_AIR SPACE "sun: {irradiance: 0}\nrender: {max_scatterings: 0}\n"
                                            "clouds: [{vdb: box.vdb, extinction: 0.075 1/m, albedo: 0,\n"
                                            "  emission: {flame: none, temperature: none, offset: 2000 K}}]\n";

/* ---- Examples ---- */

typedef struct pixel {
  neph_image *image;
  unsigned index;
} pixel;

static double get(const pixel *p, const char *channel) {
  const float *values = neph_image_get_values(p->image, channel);
  if (!values) fail_msg("no channel %s", channel);
  return (double)values[p->index];
}

static double get_picture(const pixel *p) { return get(p, "R"); }
static double get_all_but_terrain(const pixel *p) { return get(p, "R") - get(p, "terrain.R"); }
static double get_all_but_sun(const pixel *p) { return get(p, "R") - get(p, "sun.R"); }
static double get_all_but_sun_and_terrain(const pixel *p) { return get_all_but_sun(p) - get(p, "terrain.R"); }
static double get_all_but_sky_light(const pixel *p) { return get(p, "R") - get(p, "light_sky.R"); }
static double get_air_before_cloud(const pixel *p) { return get(p, "air.R") - get(p, "ground_air.R"); }
static double get_air_before_ground(const pixel *p) { return get(p, "air.R") - get(p, "cloud_air.R"); }
static double get_share_beside_cloud(const pixel *p) { return 1.0 - get(p, "clouds.A"); }
static double get_squared_error(const pixel *p) { return pow(get(p, "standard_error.R"), 2.0); }
static double get_root_of_variance(const pixel *p) { return sqrt(get(p, "variance.R")); }
static double get_x_m(const pixel *p) {
  return 3000.0 * tan(NP_DEGREE) * ((p->index % SIDE + 0.5) / (0.5 * SIDE) - 1.0);
}

/* A scene and the value of a channel in each pixel: `value`, or, where it is given, the result of `expect`. */
typedef struct example {
  np_aov_index aov;
  const char *scene, *channel;
  double tolerance;
  double value;
  double (*expect)(const pixel *p);
} example;

/* Colours are sums of floats: 1e-5 of them. Lengths: a pixel, into whose neighbours the filter reaches, and the way to
 * the picture's corner. */
static const example examples[] = {
    {NP_AOV_INDEX_BACKGROUND, stars, "background.R", 1e-5, .expect = get_picture},
    {NP_AOV_INDEX_TERRAIN, ground, "terrain.R", 1e-5, .expect = get_picture},
    {NP_AOV_INDEX_AIR, haze, "air.R", 1e-5, .expect = get_all_but_terrain},
    {NP_AOV_INDEX_SUN, sunlit, "sun.R", 1e-5, .expect = get_picture},
    {NP_AOV_INDEX_SKY, skylit, "sky.R", 1e-5, .expect = get_picture},
    {NP_AOV_INDEX_GROUND, over_ground, "ground.R", 1e-5, .expect = get_all_but_sun_and_terrain},
    {NP_AOV_INDEX_MULTIPLE, cloud, "multiple.R", 1e-5, .expect = get_all_but_sun},
    {NP_AOV_INDEX_TRANSMITTANCE, cloud, "transmittance", 1e-6, .expect = get_share_beside_cloud},
    {NP_AOV_INDEX_DISTANCE, ground, "distance", 2.0, .value = 3000.0},
    {NP_AOV_INDEX_DEPTH, ground, "Z", 0.01, .value = 3000.0},
    {NP_AOV_INDEX_STANDARD_ERROR, cloud, "standard_error.R", 1e-5, .expect = get_root_of_variance},
    {NP_AOV_INDEX_VARIANCE, cloud, "variance.R", 1e-5, .expect = get_squared_error},
    {NP_AOV_INDEX_SAMPLE_COUNT, ground, "sample_count", 0.0, .value = SAMPLES},
    {NP_AOV_INDEX_ALBEDO, ground, "albedo.R", 1e-6, .value = 0.3},
    {NP_AOV_INDEX_MEAN_DISTANCE, ground, "mean_distance", 2.0, .value = 3000.0},
    {NP_AOV_INDEX_POSITION, ground, "position.X", 26.2, .expect = get_x_m},
    {NP_AOV_INDEX_EMISSION, fire, "emission.R", 1e-5, .expect = get_picture},
    {NP_AOV_INDEX_NORMAL, ground, "normal.Z", 1e-6, .value = 1.0},
    {NP_AOV_INDEX_SHADOW, ground, "shadow", 0.0, .value = 1.0},
    {NP_AOV_INDEX_CLOUDS, over_ground, "clouds.R", 1e-5, .expect = get_all_but_terrain},
    {NP_AOV_INDEX_CLOUD_AIR, cloud_in_haze, "cloud_air.R", 1e-5, .expect = get_air_before_cloud},
    {NP_AOV_INDEX_GROUND_AIR, cloud_in_haze, "ground_air.R", 1e-5, .expect = get_air_before_ground},
    {NP_AOV_INDEX_OPTICAL_DEPTH, cloud, "optical_depth", 0.012, .value = 1.2}, /* 1 %: the march's steps */
    {NP_AOV_INDEX_LIGHTS, cloud, "light_sun.R", 1e-5, .expect = get_all_but_sky_light},
    {NP_AOV_INDEX_MATTES, ground, "matte.ground", 0.0, .value = 1.0},
    {NP_AOV_INDEX_CRYPTOMATTE, ground, "CryptoObject00.G", 0.0, .value = 1.0}, /* coverage of the first rank */
    {NP_AOV_INDEX_MOTION, ground, "forward.u", 1e-3, .value = -1.0},
};

enum { EXAMPLES = sizeof examples / sizeof *examples };

static void every_aov_has_an_example(void **state) {
  (void)state;
  for (unsigned aov = 0; aov < NP_AOV_COUNT; aov++) {
    unsigned i = 0;
    while (i < EXAMPLES && examples[i].aov != aov) i++;
    if (i == EXAMPLES)
      fail_msg("the AOV %s has no known answer: add a row to `examples` in tests/test_aov_rows.c",
               np_aov_rows[aov].name);
  }
}

/* ---- Pictures ---- */

static void list_aovs(char *out, size_t size) {
  size_t length = 0;
  for (unsigned aov = 0; aov < NP_AOV_COUNT; aov++)
    length += (size_t)snprintf(out + length, size - length, "%s%s", aov ? ", " : "[", np_aov_rows[aov].name);
  snprintf(out + length, size - length, "]");
}

/* One with all AOVs. */
static neph_image *render(test_fixture *f, const char *text, const char *integrator) {
  char aovs[1024], samples[8], *path = test_path(f->folder, "scene.yaml");
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  list_aovs(aovs, sizeof aovs);
  snprintf(samples, sizeof samples, "%d", SAMPLES);
  if (neph_scene_load_text(f->context, text, path, &scene)) fail_msg("%s: %s", text, f->log.text);
  assert_int_equal(neph_scene_set(scene, "output.aovs", aovs), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.integrator", integrator), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.samples", samples), NEPH_OK);
  if (neph_render_image(scene, NULL, &image)) fail_msg("%s: %s", text, f->log.text);
  neph_scene_destroy(scene);
  free(path);
  return image;
}

static void check(const example *e, neph_image *image) {
  double largest = 0.0;
  for (unsigned i = 0; i < PIXELS; i++) {
    const pixel p = {image, i};
    const double found = get(&p, e->channel), wanted = e->expect ? e->expect(&p) : e->value;
    largest = fmax(largest, fabs(found));
    if (!(fabs(found - wanted) <= e->tolerance))
      fail_msg("%s in pixel %u is %g, must be %g\n%s", e->channel, i, found, wanted, e->scene);
  }
  if (!(largest > 0.0)) fail_msg("%s is 0 everywhere: its example shows nothing\n%s", e->channel, e->scene);
}

static void every_example_is_met(void **state) {
  test_fixture *f = *state;
  static const test_box box = {{0, 0, 8}, {32, 32, 24}, 1.0f};
  static const char *const integrators[] = {"march", "path"};
  char *path = test_path(f->folder, "box.vdb");
  test_boxes_write(f->context, path, "density", &box, 1);
  for (unsigned i = 0; i < 2; i++)
    for (unsigned e = 0; e < EXAMPLES; e++) {
      bool is_first = true; /* first row of its scene */
      for (unsigned k = 0; k < e; k++) is_first = is_first && examples[k].scene != examples[e].scene;
      if (!is_first) continue;
      neph_image *image = render(f, examples[e].scene, integrators[i]);
      for (unsigned k = e; k < EXAMPLES; k++)
        if (examples[k].scene == examples[e].scene) check(&examples[k], image);
      neph_image_destroy(image);
    }
  free(path);
}

/* ---- Files ---- */

static void each_channel_has_the_pixels_of_its_row(void **state) {
  (void)state;
  for (unsigned e = 0; e < EXAMPLES; e++) {
    const bool is_float = np_aov_rows[examples[e].aov].pixel_type == NEPH_PIXEL_FLOAT;
    if (np_image_is_float_channel(examples[e].channel) != is_float)
      fail_msg("%s must be stored as %s", examples[e].channel, is_float ? "floats" : "halves");
  }
  assert_true(np_image_is_float_channel("P.X"));
  assert_false(np_image_is_float_channel("R") || np_image_is_float_channel("A"));
  assert_false(np_image_is_float_channel("positions.X") || np_image_is_float_channel("Zone"));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_aov_has_an_example),
      cmocka_unit_test_setup_teardown(every_example_is_met, set_up, test_tear_down),
      cmocka_unit_test(each_channel_has_the_pixels_of_its_row),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

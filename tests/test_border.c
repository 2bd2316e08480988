/* SPDX-License-Identifier: Apache-2.0 */
/* Light that comes to clouds from outside: among hills, over bright ground, in a white furnace; and light that leaves
 * them, by Lambert's law. */
#include <nephos/nephos.h>

#include "core/alloc.h"
#include "test_support.h"
#include "transport/border.h"

static neph_image *render(neph_context *context, const char *text, const char *integrator, const char *samples) {
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  assert_int_equal(neph_scene_load_text(context, text, "test.yaml", &scene), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.integrator", integrator), NEPH_OK);
  assert_int_equal(neph_scene_set(scene, "render.samples", samples), NEPH_OK);
  assert_int_equal(neph_render_image(scene, NULL, &image), NEPH_OK);
  neph_scene_destroy(scene);
  return image;
}

/* Mean, least and most of green over the pixels that are nearly all cloud in another picture of the scene. */
typedef struct green {
  double mean, least, most;
} green;

static green measure_green(neph_image *image, neph_image *cover) {
  const unsigned count = neph_image_get_width(image) * neph_image_get_height(image);
  const float *values = neph_image_get_channel(image, "G"), *alpha = neph_image_get_channel(cover, "A");
  green out = {0.0, HUGE_VAL, 0.0};
  double cloudy = 0.0;
  for (unsigned i = 0; i < count; i++) {
    if (alpha[i] < 0.9f) continue;
    out.mean += (double)values[i];
    cloudy++;
    out.least = fmin(out.least, (double)values[i]);
    out.most = fmax(out.most, (double)values[i]);
  }
  assert_true(cloudy > 20.0);
  out.mean /= cloudy;
  return out;
}

/* Green of the march over that of paths, in the same pixels. */
static double compare(neph_context *context, const char *text, const char *path_samples, const char *march_samples) {
  neph_image *path = render(context, text, "path", path_samples),
             *march = render(context, text, "march", march_samples);
  const double ratio = measure_green(march, march).mean / measure_green(path, march).mean;
  print_message("march over path %.4f\n", ratio);
  neph_image_destroy(path);
  neph_image_destroy(march);
  return ratio;
}

#define VALLEY                                                                                                         \
  "camera: {position: [0, -8 km, 1900 m], look_at: [0, 0, 700 m], fov: 55 deg, resolution: [32, 18]}\n"                \
  "atmosphere: none\nsun: {irradiance: 0}\nenvironment: {radiance: 1}\noutput: {alpha: clouds}\n"                      \
  "clouds: [{bake: {preset: valley_stratus, seed: 61, extent: [12 km, 12 km], voxel: 100 m}, albedo: 1}]\n"

/* Fog among black hills under an even sky: what comes from below and from the sides is dark. 128 samples of a path
 * leave 1 % in the mean; 3.6 % is the march's own, from hills that are cells. It was 30 % off while all directions came
 * from one place. */
static void hills_hide_the_sky(void **state) {
  test_fixture *f = *state;
  static const char scene[] =
      VALLEY "terrain: {ridges: {seed: 23, relief: 1300 m, samples: 257}, width: 24 km, albedo: 0}\n";
  assert_near(compare(f->context, scene, "128", "4"), 1.0, 0.07);
}

/* A white furnace: clouds under an even sky over white hills vanish. Their pixels have the sky's radiance, 3 % for the
 * hills that do not quite light each other (docs/transport.md) and for four samples a pixel. */
static void white_hills_and_fog_are_a_furnace(void **state) {
  test_fixture *f = *state;
  static const char fog[] =
      VALLEY "terrain: {ridges: {seed: 23, relief: 1300 m, samples: 257}, width: 24 km, albedo: 1}\n";
  static const char sky[] = "camera: {resolution: [8, 8]}\natmosphere: none\nsun: {irradiance: 0}\nenvironment: "
                            "{planet: none, radiance: 1}\n";
  neph_image *clouds = render(f->context, fog, "march", "4"), *clear = render(f->context, sky, "march", "1");
  const green g = measure_green(clouds, clouds);
  const double expected = (double)neph_image_get_channel(clear, "G")[0];
  print_message("mean %.4f, %.4f to %.4f\n", g.mean / expected, g.least / expected, g.most / expected);
  assert_near_relative(g.mean, expected, 0.02);
  assert_true(g.least > 0.92 * expected && g.most < 1.05 * expected);
  neph_image_destroy(clouds);
  neph_image_destroy(clear);
}

/* A deck over snow is lit from below by what it lets through, time and again. Sun alone, no air; paths to 1 %. It was
 * 26 % too dark while the ground under the clouds had a clear sky's light. */
static void ground_sends_back_what_a_deck_lets_through(void **state) {
  test_fixture *f = *state;
  static const char scene[] =
      "camera: {position: [0, -3 km, 300 m], look_at: [0, 2 km, 1500 m], fov: 60 deg, resolution: [24, 14]}\n"
      "atmosphere: none\nsun: {elevation: 50 deg}\noutput: {alpha: clouds}\n"
      "terrain: {ridges: {relief: 0 m, samples: 65}, width: 40 km, albedo: 0.8}\n"
      "clouds: [{bake: {preset: stratocumulus, seed: 5, extent: [12 km, 12 km], base: 1500 m, voxel: 80 m}}]\n";
  assert_near(compare(f->context, scene, "128", "4"), 1.0, 0.06);
}

/* Stratus a cell above bright ground: sunlit ground beyond its rim ends where its shadow begins. Sun alone, no air;
 * paths to 1 %. It was 5 % too bright while the ground was seen from places 1.7 km apart. */
static void ground_close_below_is_lit_column_by_column(void **state) {
  test_fixture *f = *state;
  static const char scene[] =
      "camera: {position: [-1 km, 1.5 km, 40 m], look_at: [0, 0, 300 m], fov: 70 deg, resolution: [24, 14]}\n"
      "atmosphere: {preset: none, ground_albedo: 0.7}\nsun: {elevation: 40 deg, azimuth: 200 deg}\n"
      "output: {alpha: clouds}\n"
      "clouds: [{bake: {preset: stratus, seed: 12, extent: [7 km, 7 km], base: 120 m, voxel: 60 m}}]\n";
  assert_near(compare(f->context, scene, "128", "8"), 1.0, 0.035);
}

/* ---- Light that leaves the box ---- */

enum { PLACES = 5, LIT_U = 3, LIT_V = 20, BELOW = 2 };

/* Squares around the lit one: beneath it, beside it along either axis, far off, and past the plan. */
static const int places[PLACES][2] = {{LIT_U, LIT_V}, {LIT_U + 2, LIT_V}, {LIT_U, LIT_V - 3}, {17, 5}, {-6, 30}};

/* One node responds to these squares, with a gain of 1. */
static void prepare_border(neph_context *context, np_border *border, np_border_response *responses) {
  const unsigned margin = (NP_BORDER_WIDE - NP_BORDER_PLAN) / 2;
  border->square_m[0] = 100.0;
  border->square_m[1] = 130.0;
  border->depth_m = 800.0;
  for (unsigned i = 0; i < PLACES; i++)
    responses[i] =
        (np_border_response){i,
                             (BELOW * NP_BORDER_WIDE + (unsigned)(places[i][1] + (int)margin)) * NP_BORDER_WIDE +
                                 (unsigned)(places[i][0] + (int)margin),
                             np_spectrum_grey(1.0f)};
  border->responses[0].at = responses;
  border->responses[0].count = PLACES;
  border->faces[0].block_count = border->clear[0].block_count = 1;
  border->faces[0].radiance = np_alloc(context, np_border_count_radiances(1), sizeof(float));
  border->clear[0].radiance = np_alloc(context, np_border_count_radiances(1), sizeof(float));
  assert_non_null(border->faces[0].radiance);
  assert_non_null(border->clear[0].radiance);
}

/* One square shines on those at half the depth: h⁴/(h² + d²)² of the light beneath it arrives at a distance d, and
 * there an even radiance of 1/π sends h²/(π·h⁴) of its area. The kernel's sum over 80 squares is the plane's to 2 %. */
static void a_square_lights_the_ground_by_its_distance(void **state) {
  test_fixture *f = *state;
  np_border *border = np_alloc(f->context, 1, sizeof *border);
  np_border_response responses[PLACES];
  np_outflow outflow = {0};
  assert_non_null(border);
  prepare_border(f->context, border, responses);
  outflow.way[NP_BORDER_DOWN][LIT_V][LIT_U] = 7.0f;
  np_border_set_outflow(f->context, border, 0, &outflow);
  const float *found = border->faces[0].radiance;
  const double h2 = 400.0 * 400.0;
  assert_near_relative((double)found[0], 7.0 * 100.0 * 130.0 / (NP_PI * h2), 0.02);
  for (int i = 1; i < PLACES; i++) {
    const double x = 100.0 * (places[i][0] - LIT_U), y = 130.0 * (places[i][1] - LIT_V), d2 = h2 + x * x + y * y;
    assert_near_relative((double)found[i], (double)found[0] * h2 * h2 / (d2 * d2), 1e-5);
  }
  np_alloc_free(f->context, border->faces[0].radiance);
  np_alloc_free(f->context, border->clear[0].radiance);
  np_alloc_free(f->context, border);
}

/* A deck of an optical depth of 476 over bright ground, from a file: what its coarse solution lets out is far from what
 * it is. Paths to some 3 %. The march came to a thousand times as much; it is a fifth too bright. */
static void a_deep_deck_is_lit_by_what_it_lets_out(void **state) {
  test_fixture *f = *state;
  char *folder = test_folder_create(), *path = test_path(folder, "deck.vdb"), text[1024];
  neph_cloud_desc deck = NEPH_CLOUD_DESC_DEFAULT;
  neph_bake_desc bake = NEPH_BAKE_DESC_DEFAULT;
  assert_int_equal(neph_cloud_get_preset(f->context, "stratocumulus", &deck), NEPH_OK);
  deck.seed = 194707;
  deck.extent_m[0] = deck.extent_m[1] = 8641;
  deck.voxel_m = 125.4;
  deck.base_altitude_m = 1065;
  assert_int_equal(neph_cloud_bake_file(f->context, &deck, &bake, "density", path), NEPH_OK);
  snprintf(text, sizeof text,
           "camera: {position: [-99, -914, 166], look_at: [0, 0, 1407], fov: 50 deg, resolution: [16, 9]}\n"
           "sun: {elevation: 83.8 deg, azimuth: 229.4 deg}\natmosphere: {ground_albedo: 0.686}\n"
           "clouds: [{vdb: %s, optical_depth: 476.4}]\noutput: {alpha: clouds}\n",
           path);
  const double ratio = compare(f->context, text, "8", "1");
  assert_true(ratio > 0.8 && ratio < 1.3);
  test_folder_destroy(folder);
  free(path);
}

static int set_up(void **state) { return test_set_up(state, 2, NULL); }

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, test_tear_down)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(hills_hide_the_sky),
      TEST(white_hills_and_fog_are_a_furnace),
      TEST(ground_sends_back_what_a_deck_lets_through),
      TEST(ground_close_below_is_lit_column_by_column),
      TEST(a_deep_deck_is_lit_by_what_it_lets_out),
      TEST(a_square_lights_the_ground_by_its_distance),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

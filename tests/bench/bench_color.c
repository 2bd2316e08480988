/* SPDX-License-Identifier: Apache-2.0 */
/* Colour error by the number of wavelengths: of clear skies, of grounds under them, or of a scene's picture.
 *
 * Usage: bench_color skies | grounds | SCENE.yaml
 *
 * The reference is 60 wavelengths, in linear Rec.709. Besides numbers of wavelengths there are the radiances at 680,
 * 550 and 440 nm, each over the sun's. For each colour both are scaled until the reference's luminance is 0.4.
 * Printed: the mean and the largest ΔE*ab (CIE 1976, white D65).
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <nephos/nephos.h>

#include "core/units.h"
#include "stages/assembly.h"
#include "test_color_difference.h"

enum { COLORS_MAX = 1 << 18 };

static const unsigned counts[] = {3, 3, 6, 9, 15, 30, 60}; /* the first in bands */
enum { COUNTS = sizeof counts / sizeof *counts, REFERENCE = COUNTS - 1 };

static const double elevations_deg[] = {60, 30, 10, 5, 2, 0, -3, -6};
enum { ELEVATIONS = sizeof elevations_deg / sizeof *elevations_deg };

typedef struct colors {
  size_t count;
  double (*rgb)[3];
} colors;

static void fail(const char *what) {
  fprintf(stderr, "bench_color: %s\n", what);
  exit(1);
}

static void check(neph_result result) {
  if (result) fail(neph_result_get_text(result));
}

/* Scenes by their number of wavelengths. */
static void set_count(neph_scene *scene, int k) {
  char text[16];
  (void)snprintf(text, sizeof text, "%u", counts[k]);
  check(neph_scene_set(scene, "output.color_space", k == 0 ? "bands" : "rec709"));
  check(neph_scene_set(scene, "render.wavelengths", text));
}

/* In bands the sun is white: it is given its colour in Rec.709, W m⁻² nm⁻¹ by 60 wavelengths. */
static void map_bands(double rgb[3]) {
  static const double bands[3] = {1.474, 1.8504, 1.91198}, rec709[3] = {2.0019, 1.7828, 1.7153};
  for (int c = 0; c < 3; c++) rgb[c] *= rec709[c] / bands[c];
}

static void keep(int k, np_spectrum color, colors *out) {
  double *rgb = out->rgb[out->count++];
  if (out->count >= COLORS_MAX) fail("too many colours");
  for (int c = 0; c < 3; c++) rgb[c] = (double)color.band[c];
  if (k == 0) map_bands(rgb);
}

/* ---- Skies ---- */

static np_spectrum spectrum_of(const double values[3]) {
  return np_spectrum_make((float)values[0], (float)values[1], (float)values[2]);
}

/* Thirty directions from the zenith to 85 degrees. */
static np_spectrum look(const np_assembly *a, int i) {
  const double zenith = (i % 6) * 17.0 * NP_DEGREE, azimuth = (i / 6) * 45.0 * NP_DEGREE;
  const np_vec3 d =
      np_vec3_make((float)(sin(zenith) * sin(azimuth)), (float)(sin(zenith) * cos(azimuth)), (float)cos(zenith));
  np_spectrum color = np_spectrum_grey(0.0f);
  for (unsigned p = 0; p < a->packet_count; p++) {
    const np_world *world = &a->packets[p].lights[0].world;
    const np_spectrum bands = np_world_sky_radiance(world, world->camera_sky, a->camera.origin, d);
    color = np_packet_add_color(&a->packets[p], color, bands);
  }
  return color;
}

/* Ground of an albedo under the sun, the sky and both. */
static void light_ground(const np_assembly *a, const double albedo[3], np_spectrum out[3]) {
  for (int i = 0; i < 3; i++) out[i] = np_spectrum_grey(0.0f);
  for (unsigned p = 0; p < a->packet_count; p++) {
    const np_packet *packet = &a->packets[p];
    const np_spectrum share = np_picture_color_convert_albedo(&a->color, &packet->bands, albedo);
    double sun[3], sky[3];
    neph_sky_get_irradiance(packet->lights[0].camera_sky, sun, sky);
    out[0] = np_packet_add_color(packet, out[0], np_spectrum_multiply(share, spectrum_of(sun)));
    out[1] = np_packet_add_color(packet, out[1], np_spectrum_multiply(share, spectrum_of(sky)));
  }
  out[2] = np_spectrum_add(out[0], out[1]);
}

static void look_at_sky(int k, const np_assembly *a, const double *albedo, colors *out) {
  static const double white[3] = {1.0, 1.0, 1.0};
  np_spectrum grounds[3];
  for (int i = 0; i < 30 && !albedo; i++) keep(k, look(a, i), out);
  light_ground(a, albedo ? albedo : white, grounds);
  for (int i = 0; i < (albedo ? 3 : 2); i++) keep(k, grounds[i], out);
}

static void look_at_sun(neph_scene *scene, int k, double elevation_deg, const double *albedo, colors *out) {
  char text[32];
  np_plan plan;
  np_stores stores = {.results = NULL};
  const np_build_job job = np_build_job_make(&stores);
  np_assembly assembly;
  np_monitor monitor;
  set_count(scene, k);
  (void)snprintf(text, sizeof text, "%g deg", elevation_deg);
  check(neph_scene_set(scene, "sun.elevation", text));
  check(neph_scene_set(scene, "sun.azimuth", "0 deg"));
  np_monitor_start(&monitor, scene->context, NULL, NULL);
  check(np_plan_make_sky(scene, &(np_sky_request){.is_of_bands = false}, &plan));
  check(np_assembly_build(scene, &plan, &job, &monitor, &assembly));
  look_at_sky(k, &assembly, albedo, out);
  np_assembly_clear(&assembly);
  np_plan_clear(&plan);
  np_stores_clear(scene->context, &stores);
}

/* ---- Tables ---- */

static void print_row(const char *name, const colors *all, size_t begin) {
  printf("| %s |", name);
  for (int k = 0; k < REFERENCE; k++) {
    color_difference d = {.count = 0};
    for (size_t i = begin; i < all[k].count; i++) color_difference_add(&d, all[k].rgb[i], all[REFERENCE].rgb[i]);
    printf(" %.2g, %.2g |", d.sum / (double)(d.count ? d.count : 1), d.max);
  }
  printf("\n");
  fflush(stdout);
}

static void print_head(const char *first) {
  printf("| %s | bands | 3 | 6 | 9 | 15 | 30 |\n| --- | --- | --- | --- | --- | --- | --- |\n", first);
}

static neph_scene *create_sky(neph_context *context, const char *air, double height_m) {
  char text[160];
  neph_scene *scene = NULL;
  (void)snprintf(text, sizeof text, "{version: 1, atmosphere: %s, camera: {position: [0, 0, %g m]}}", air, height_m);
  check(neph_scene_load_text(context, text, "sky.yaml", &scene));
  return scene;
}

/* A row a sun, and one for all. */
static void compare_suns(neph_scene *scene, const char *name, const double *albedo, colors *all) {
  char row[96];
  size_t first = all[REFERENCE].count;
  for (int e = 0; e < ELEVATIONS; e++) {
    const size_t begin = all[REFERENCE].count;
    for (int k = 0; k < COUNTS; k++) look_at_sun(scene, k, elevations_deg[e], albedo, &all[k]);
    (void)snprintf(row, sizeof row, "%s, %g°", name, elevations_deg[e]);
    if (!albedo) print_row(row, all, begin);
  }
  (void)snprintf(row, sizeof row, "%s, all suns", name);
  print_row(row, all, first);
}

static const char *const airs[] = {"earth", "earth-hazy"};
static const double heights_m[] = {500.0, 10000.0};

static void compare_skies(neph_context *context, colors *all) {
  print_head("air, height, sun");
  for (int a = 0; a < 2; a++)
    for (int h = 0; h < 2; h++) {
      char name[48];
      neph_scene *scene = create_sky(context, airs[a], heights_m[h]);
      (void)snprintf(name, sizeof name, "%s, %g m", airs[a], heights_m[h]);
      compare_suns(scene, name, NULL, all);
      neph_scene_destroy(scene);
    }
  print_row("all", all, 0);
}

static void compare_grounds(neph_context *context, colors *all) {
  static const struct {
    const char *name;
    double albedo[3];
  } grounds[] = {{"grass", {0.12, 0.16, 0.08}},
                 {"sand", {0.4, 0.27, 0.15}},
                 {"rock", {0.22, 0.2, 0.17}},
                 {"red", {0.6, 0.05, 0.05}},
                 {"blue", {0.05, 0.1, 0.6}}};
  print_head("ground");
  for (size_t g = 0; g < sizeof grounds / sizeof *grounds; g++) {
    neph_scene *scene = create_sky(context, "earth", 500.0);
    compare_suns(scene, grounds[g].name, grounds[g].albedo, all);
    neph_scene_destroy(scene);
  }
}

static void take_picture(neph_scene *scene, int k, colors *out) {
  neph_image *image = NULL;
  set_count(scene, k);
  check(neph_render_image(scene, NULL, &image));
  const size_t count = (size_t)neph_image_get_width(image) * neph_image_get_height(image);
  const float *plane[3] = {neph_image_get_channel(image, "R"), neph_image_get_channel(image, "G"),
                           neph_image_get_channel(image, "B")};
  const float scale = (float)(k == 0 ? 1.0 : 0.5); /* relative to the picture's scale */
  for (size_t i = 0; i < count; i++)
    keep(k, np_spectrum_make(scale * plane[0][i], scale * plane[1][i], scale * plane[2][i]), out);
  neph_image_destroy(image);
}

static void compare_pictures(neph_context *context, const char *path, colors *all) {
  neph_scene *scene = NULL;
  check(neph_scene_load(context, path, &scene));
  for (int k = 0; k < COUNTS; k++) take_picture(scene, k, &all[k]);
  print_head("picture");
  print_row(path, all, 0);
  neph_scene_destroy(scene);
}

int main(int argc, char **argv) {
  static colors all[COUNTS];
  neph_context *context = NULL;
  if (argc != 2) fail("usage: bench_color skies | grounds | SCENE.yaml");
  check(neph_context_create(NULL, &context));
  for (int k = 0; k < COUNTS; k++) {
    all[k].rgb = malloc(COLORS_MAX * sizeof *all[k].rgb);
    if (!all[k].rgb) fail("no memory");
  }
  if (!strcmp(argv[1], "skies"))
    compare_skies(context, all);
  else if (!strcmp(argv[1], "grounds"))
    compare_grounds(context, all);
  else
    compare_pictures(context, argv[1], all);
  for (int k = 0; k < COUNTS; k++) free(all[k].rgb);
  neph_context_destroy(context);
  return 0;
}

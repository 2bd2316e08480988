/* SPDX-License-Identifier: Apache-2.0 */
/* Error of colours by the number of wavelengths: the clear sky of a scene under several suns, or its picture.
 *
 * Usage: bench_color SCENE.yaml [picture]. The reference is 60 wavelengths, in linear Rec.709. Three bands have no
 * place there, and are mapped to it in three ways: by their white alone, as previews are; by the matrix that keeps the
 * sun white and else makes the least relative error over clear skies, and over white ground under sun and sky; and by
 * the best matrix without such a condition.
 *
 * For each colour both are scaled until the reference's luminance is 0.4. Printed: relative rms of R, G and B over the
 * reference's largest component, and the mean and the largest ΔE*ab (CIE 1976, white D65).
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <nephos/nephos.h>

#include "core/units.h"
#include "render/assembly.h"

enum { DIRECTIONS = 30, LOOKS = DIRECTIONS + 2, SAMPLES_MAX = 1 << 18 };

static const double elevations_deg[] = {60, 30, 10, 5, 2, 0, -3, -6};
enum { ELEVATIONS = sizeof elevations_deg / sizeof *elevations_deg };
static const unsigned counts[] = {3, 6, 9, 15, 30, 60};
enum { COUNTS = sizeof counts / sizeof *counts, REFERENCE = COUNTS - 1 };

typedef struct colors {
  size_t count;
  double (*rgb)[3];
} colors;

typedef struct error {
  double squares[3], delta_sum, delta_max;
  size_t count;
} error;

static void fail(const char *what) {
  fprintf(stderr, "bench_color: %s\n", what);
  exit(1);
}

static void check(neph_result result) {
  if (result) fail(neph_result_get_text(result));
}

static neph_scene *load(neph_context *context, const char *path, unsigned count) {
  neph_scene *scene = NULL;
  char text[16];
  (void)snprintf(text, sizeof text, "%u", count);
  check(neph_scene_load(context, path, &scene));
  check(neph_scene_set(scene, "render.wavelengths", text));
  return scene;
}

/* ---- Colours ---- */

static void compute_lab(const double rgb[3], double out[3]) {
  static const double xyz_from_rgb[3][3] = {
      {0.4124564, 0.3575761, 0.1804375}, {0.2126729, 0.7151522, 0.0721750}, {0.0193339, 0.1191920, 0.9503041}};
  static const double white[3] = {0.95047, 1.0, 1.08883};
  double f[3];
  for (int r = 0; r < 3; r++) {
    double t = 0.0;
    for (int c = 0; c < 3; c++) t += xyz_from_rgb[r][c] * rgb[c] / white[r];
    f[r] = t > 216.0 / 24389.0 ? cbrt(t) : (24389.0 / 27.0 * t + 16.0) / 116.0;
  }
  out[0] = 116.0 * f[1] - 16.0;
  out[1] = 500.0 * (f[0] - f[1]);
  out[2] = 200.0 * (f[1] - f[2]);
}

static double compute_luminance(const double rgb[3]) {
  return 0.2126729 * rgb[0] + 0.7151522 * rgb[1] + 0.072175 * rgb[2];
}

static void add_error(error *e, const double rgb[3], const double reference[3]) {
  const double luminance = compute_luminance(reference);
  if (!(luminance > 0.0)) return;
  double own[3], exact[3], own_lab[3], exact_lab[3], largest = 0.0, delta = 0.0;
  for (int c = 0; c < 3; c++) {
    own[c] = 0.4 * rgb[c] / luminance;
    exact[c] = 0.4 * reference[c] / luminance;
    largest = fmax(largest, exact[c]);
  }
  compute_lab(own, own_lab);
  compute_lab(exact, exact_lab);
  for (int c = 0; c < 3; c++) {
    e->squares[c] += pow((own[c] - exact[c]) / largest, 2.0);
    delta += pow(own_lab[c] - exact_lab[c], 2.0);
  }
  e->delta_sum += sqrt(delta);
  e->delta_max = fmax(e->delta_max, sqrt(delta));
  e->count++;
}

static void print_error(const char *name, const error *e) {
  const double n = (double)(e->count ? e->count : 1);
  printf("%-24s %6.2f %6.2f %6.2f %%   dE mean %6.2f max %6.2f\n", name, 100.0 * sqrt(e->squares[0] / n),
         100.0 * sqrt(e->squares[1] / n), 100.0 * sqrt(e->squares[2] / n), e->delta_sum / n, e->delta_max);
}

/* ---- Maps from bands ---- */

typedef struct matrix {
  double at[3][3];
} matrix;

/* Both divided by the colour of the sun above the air, and so by its luminance. */
static void divide(const double rgb[3], const double sun[3], double out[3]) {
  for (int c = 0; c < 3; c++) out[c] = rgb[c] / sun[c];
}

/* The matrix between bands and reference, both over the sun, whose rows make the least relative error: three normal
 * equations a row; a heavy sun among the colours keeps it white. */
static matrix fit(const colors *bands, const colors *reference, const double bands_sun[3], const double sun[3],
                  double sun_weight) {
  matrix out;
  for (int c = 0; c < 3; c++) {
    double a[3][4] = {{0}};
    for (size_t i = 0; i <= bands->count; i++) {
      const bool is_sun = i == bands->count;
      double x[3], y[3];
      divide(is_sun ? bands_sun : bands->rgb[i], bands_sun, x);
      divide(is_sun ? sun : reference->rgb[i], sun, y);
      const double luminance = compute_luminance(y), weight = (is_sun ? sun_weight : 1.0) / (luminance * luminance);
      for (int r = 0; luminance > 0.0 && r < 3; r++) {
        for (int k = 0; k < 3; k++) a[r][k] += weight * x[r] * x[k];
        a[r][3] += weight * x[r] * y[c];
      }
    }
    for (int p = 0; p < 3; p++)
      for (int r = 0; r < 3; r++) {
        const double factor = r == p ? 0.0 : a[r][p] / a[p][p];
        for (int k = p; k < 4; k++) a[r][k] -= factor * a[p][k];
      }
    for (int r = 0; r < 3; r++) out.at[c][r] = a[r][3] / a[r][r];
  }
  return out;
}

/* From bands to the reference, through colours over the sun. */
static void map(const matrix *m, const double bands_sun[3], const double sun[3], const double in[3], double out[3]) {
  double x[3];
  divide(in, bands_sun, x);
  for (int r = 0; r < 3; r++) out[r] = sun[r] * (m->at[r][0] * x[0] + m->at[r][1] * x[1] + m->at[r][2] * x[2]);
}

/* The sun above the air, in the picture's colours. */
static void compute_sun(const np_assembly *a, double out[3]) {
  np_spectrum color = np_spectrum_grey(0.0f);
  for (unsigned p = 0; p < a->packet_count; p++)
    color = np_packet_add_color(&a->packets[p], color, a->packets[p].lights[0].world.sun_irradiance);
  for (int c = 0; c < 3; c++) out[c] = (double)color.band[c];
}

/* ---- Skies and pictures ---- */

static void keep(np_spectrum color, double out[3]) {
  for (int c = 0; c < 3; c++) out[c] = (double)color.band[c];
}

static np_spectrum spectrum_of(const double values[3]) {
  return np_spectrum_make((float)values[0], (float)values[1], (float)values[2]);
}

/* The sky in all directions, and white ground under the sun and under the sky. */
static void look(const np_assembly *a, double (*rgb)[3]) {
  np_spectrum color[LOOKS];
  memset(color, 0, sizeof color);
  for (unsigned p = 0; p < a->packet_count; p++) {
    const np_packet *packet = &a->packets[p];
    const np_world *world = &packet->lights[0].world;
    for (int i = 0; i < DIRECTIONS; i++) {
      const double zenith = (i % 6) * 17.0 * NP_DEGREE, azimuth = (i / 6) * 45.0 * NP_DEGREE;
      const np_vec3 d =
          np_vec3_make((float)(sin(zenith) * sin(azimuth)), (float)(sin(zenith) * cos(azimuth)), (float)cos(zenith));
      color[i] =
          np_packet_add_color(packet, color[i], np_world_sky_radiance(world, world->camera_sky, a->camera.origin, d));
    }
    double sun[3], sky[3];
    neph_sky_get_irradiance(world->camera_sky, sun, sky);
    color[DIRECTIONS] = np_packet_add_color(packet, color[DIRECTIONS], spectrum_of(sun));
    color[DIRECTIONS + 1] = np_packet_add_color(packet, color[DIRECTIONS + 1], spectrum_of(sky));
  }
  for (int i = 0; i < LOOKS; i++) keep(color[i], rgb[i]);
}

static void look_at_skies(neph_scene *scene, colors *out, double out_sun[3]) {
  for (int e = 0; e < ELEVATIONS; e++) {
    char text[32];
    np_plan plan;
    np_assembly assembly;
    np_monitor monitor;
    (void)snprintf(text, sizeof text, "%g deg", elevations_deg[e]);
    check(neph_scene_set(scene, "sun.elevation", text));
    check(neph_scene_set(scene, "sun.azimuth", "0 deg"));
    np_monitor_start(&monitor, scene->context, NULL, NULL);
    check(np_plan_make_sky(scene, &plan));
    check(np_assembly_build(scene, &plan, &monitor, &assembly));
    look(&assembly, out->rgb + (size_t)e * LOOKS);
    compute_sun(&assembly, out_sun);
    np_assembly_clear(&assembly);
  }
  out->count = (size_t)ELEVATIONS * LOOKS;
}

static void take_picture(neph_scene *scene, colors *out) {
  neph_image *image = NULL;
  check(neph_render_image(scene, NULL, &image));
  out->count = (size_t)neph_image_get_width(image) * neph_image_get_height(image);
  if (out->count > SAMPLES_MAX) fail("the picture has too many pixels");
  for (int c = 0; c < 3; c++) {
    const char name[2] = {"RGB"[c], '\0'};
    const float *plane = neph_image_get_channel(image, name);
    for (size_t i = 0; i < out->count; i++) out->rgb[i][c] = (double)plane[i];
  }
  neph_image_destroy(image);
}

/* ---- Tables ---- */

typedef struct bench {
  colors all[COUNTS];
  double sun[COUNTS][3]; /* above the air */
  matrix white, neutral, best;
} bench;

static void compare_mapped(const char *name, const bench *b, int k, const matrix *m, size_t begin, size_t end) {
  error e = {.count = 0};
  for (size_t i = begin; i < end; i++) {
    const double *reference = b->all[REFERENCE].rgb[i], *own = b->all[k].rgb[i];
    double mapped[3];
    if (m) map(m, b->sun[k], b->sun[REFERENCE], own, mapped);
    add_error(&e, m ? mapped : own, reference);
  }
  print_error(name, &e);
}

static void compare_all(const bench *b, size_t begin, size_t end) {
  compare_mapped("  3, as previews", b, 0, &b->white, begin, end);
  compare_mapped("  3, matrix, white sun", b, 0, &b->neutral, begin, end);
  compare_mapped("  3, best matrix", b, 0, &b->best, begin, end);
  for (int k = 1; k < REFERENCE; k++) {
    char name[32];
    (void)snprintf(name, sizeof name, "  %u", counts[k]);
    compare_mapped(name, b, k, NULL, begin, end);
  }
}

static void print_matrix(const char *name, const matrix *m) {
  printf("%s:", name);
  for (int r = 0; r < 3; r++)
    printf(" %8.4f %8.4f %8.4f%s", m->at[r][0], m->at[r][1], m->at[r][2], r < 2 ? " /" : "\n");
}

static void compare_skies(const bench *b) {
  for (size_t e = 0; e < ELEVATIONS; e++) {
    printf("clear sky, sun at %g deg\n", elevations_deg[e]);
    compare_all(b, e * LOOKS, (e + 1) * LOOKS);
  }
  printf("all of them\n");
  compare_all(b, 0, (size_t)ELEVATIONS * LOOKS);
}

static void compare_pictures(bench *b, neph_context *context, const char *path) {
  for (int k = 0; k < COUNTS; k++) {
    neph_scene *scene = load(context, path, counts[k]);
    take_picture(scene, &b->all[k]);
    neph_scene_destroy(scene);
  }
  printf("%s\n", path);
  compare_all(b, 0, b->all[0].count);
}

int main(int argc, char **argv) {
  static bench b = {.white = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  if (argc < 2) fail("usage: bench_color SCENE.yaml [picture]");
  neph_context *context = NULL;
  check(neph_context_create(NULL, &context));
  for (int k = 0; k < COUNTS; k++) {
    b.all[k].rgb = malloc(SAMPLES_MAX * sizeof *b.all[k].rgb);
    if (!b.all[k].rgb) fail("no memory");
    neph_scene *scene = load(context, argv[1], counts[k]);
    look_at_skies(scene, &b.all[k], b.sun[k]);
    neph_scene_destroy(scene);
  }
  b.neutral = fit(&b.all[0], &b.all[REFERENCE], b.sun[0], b.sun[REFERENCE], 1e9);
  b.best = fit(&b.all[0], &b.all[REFERENCE], b.sun[0], b.sun[REFERENCE], 0.0);
  print_matrix("white sun", &b.neutral);
  print_matrix("best     ", &b.best);
  if (argc > 2)
    compare_pictures(&b, context, argv[1]);
  else
    compare_skies(&b);
  for (int k = 0; k < COUNTS; k++) free(b.all[k].rgb);
  neph_context_destroy(context);
  return 0;
}

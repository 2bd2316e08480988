/* SPDX-License-Identifier: Apache-2.0 */
/* How wrong colours are by the number of wavelengths: the clear sky of a scene under several suns, or its picture.
 *
 * Usage: bench_color SCENE.yaml [picture]. The reference is 60 wavelengths, in linear Rec.709. Three bands have no
 * place there, and are mapped to it in two ways: by their white alone, as previews are (then the reference is white
 * under the same sun), and by the 3 x 3 matrix that makes the least relative error over all that is compared, which is
 * the best that any fixed matrix does here.
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

enum { DIRECTIONS = 30, SAMPLES_MAX = 1 << 18 };

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

static void find_lab(const double rgb[3], double out[3]) {
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

static double find_luminance(const double rgb[3]) {
  return 0.2126729 * rgb[0] + 0.7151522 * rgb[1] + 0.072175 * rgb[2];
}

static void add_error(error *e, const double rgb[3], const double reference[3]) {
  const double luminance = find_luminance(reference);
  if (!(luminance > 0.0)) return;
  double own[3], exact[3], own_lab[3], exact_lab[3], largest = 0.0, delta = 0.0;
  for (int c = 0; c < 3; c++) {
    own[c] = 0.4 * rgb[c] / luminance;
    exact[c] = 0.4 * reference[c] / luminance;
    largest = fmax(largest, exact[c]);
  }
  find_lab(own, own_lab);
  find_lab(exact, exact_lab);
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

/* Row `c` of the matrix that maps bands to the reference with the least relative error: three normal equations. */
static void fit_row(const colors *bands, const colors *reference, int c, double out[3]) {
  double a[3][4] = {{0}};
  for (size_t i = 0; i < bands->count; i++) {
    const double luminance = find_luminance(reference->rgb[i]);
    if (!(luminance > 0.0)) continue;
    const double weight = 1.0 / (luminance * luminance);
    for (int r = 0; r < 3; r++) {
      for (int k = 0; k < 3; k++) a[r][k] += weight * bands->rgb[i][r] * bands->rgb[i][k];
      a[r][3] += weight * bands->rgb[i][r] * reference->rgb[i][c];
    }
  }
  for (int p = 0; p < 3; p++)
    for (int r = 0; r < 3; r++) {
      if (r == p) continue;
      const double factor = a[r][p] / a[p][p];
      for (int k = p; k < 4; k++) a[r][k] -= factor * a[p][k];
    }
  for (int r = 0; r < 3; r++) out[r] = a[r][3] / a[r][r];
}

static void map(const double matrix[9], const double in[3], double out[3]) {
  for (int r = 0; r < 3; r++) out[r] = matrix[3 * r] * in[0] + matrix[3 * r + 1] * in[1] + matrix[3 * r + 2] * in[2];
}

/* What a band of 1 must become for the sun to be white: bands are divided by it, and so is the reference. */
static void find_whites(neph_scene *bands, const double reference_sun[3], double out[9]) {
  double white[3];
  memset(out, 0, 9 * sizeof *out);
  np_scene_get_white(bands, white);
  for (int c = 0; c < 3; c++) out[4 * c] = reference_sun[c] / (bands->sun.irradiance_w_m2_nm[1] * white[c]);
}

/* The sun above the air, in the picture's colours. */
static void find_sun(const np_assembly *a, double out[3]) {
  np_spectrum color = np_spectrum_grey(0.0f);
  for (unsigned p = 0; p < a->packet_count; p++)
    color = np_packet_add_color(&a->packets[p], color, a->packets[p].view.sun_irradiance);
  for (int c = 0; c < 3; c++) out[c] = (double)color.band[c];
}

/* ---- Skies and pictures ---- */

static void look(const np_assembly *a, double (*rgb)[3]) {
  for (int i = 0; i < DIRECTIONS; i++) {
    const double zenith = (i % 6) * 17.0 * NP_DEGREE, azimuth = (i / 6) * 45.0 * NP_DEGREE;
    const np_vec3 d =
        np_vec3_make((float)(sin(zenith) * sin(azimuth)), (float)(sin(zenith) * cos(azimuth)), (float)cos(zenith));
    np_spectrum color = np_spectrum_grey(0.0f);
    for (unsigned p = 0; p < a->packet_count; p++) {
      const np_scene_view *view = &a->packets[p].lights[0].view;
      color = np_packet_add_color(&a->packets[p], color, np_light_sky(view, view->camera_sky, a->camera.origin, d));
    }
    for (int c = 0; c < 3; c++) rgb[i][c] = (double)color.band[c];
  }
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
    look(&assembly, out->rgb + (size_t)e * DIRECTIONS);
    find_sun(&assembly, out_sun);
    np_assembly_clear(&assembly);
  }
  out->count = (size_t)ELEVATIONS * DIRECTIONS;
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

static void compare_mapped(const char *name, const colors *own, const double matrix[9], const colors *reference,
                           size_t begin, size_t end) {
  error e = {.count = 0};
  for (size_t i = begin; i < end; i++) {
    double rgb[3];
    map(matrix, own->rgb[i], rgb);
    add_error(&e, rgb, reference->rgb[i]);
  }
  print_error(name, &e);
}

static void compare_all(const colors *all, const double white[9], const double best[9], size_t begin, size_t end) {
  static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  compare_mapped("  3, by their white", &all[0], white, &all[REFERENCE], begin, end);
  compare_mapped("  3, by the best matrix", &all[0], best, &all[REFERENCE], begin, end);
  for (int k = 1; k < REFERENCE; k++) {
    char name[32];
    (void)snprintf(name, sizeof name, "  %u", counts[k]);
    compare_mapped(name, &all[k], identity, &all[REFERENCE], begin, end);
  }
}

int main(int argc, char **argv) {
  if (argc < 2) fail("usage: bench_color SCENE.yaml [picture]");
  const bool is_picture = argc > 2;
  neph_context *context = NULL;
  check(neph_context_create(NULL, &context));
  colors all[COUNTS];
  double white[9], best[9], sun[3];
  for (int k = 0; k < COUNTS; k++) {
    all[k].rgb = malloc(SAMPLES_MAX * sizeof *all[k].rgb);
    if (!all[k].rgb) fail("no memory");
    neph_scene *scene = load(context, argv[1], counts[k]);
    look_at_skies(scene, &all[k], sun);
    neph_scene_destroy(scene);
  }
  for (int c = 0; c < 3; c++) fit_row(&all[0], &all[REFERENCE], c, best + (ptrdiff_t)3 * c);
  neph_scene *bands = load(context, argv[1], 3);
  find_whites(bands, sun, white);
  neph_scene_destroy(bands);
  printf("best matrix from bands: %.4f %.4f %.4f / %.4f %.4f %.4f / %.4f %.4f %.4f\n", best[0], best[1], best[2],
         best[3], best[4], best[5], best[6], best[7], best[8]);
  for (size_t e = 0; !is_picture && e < ELEVATIONS; e++) {
    printf("clear sky, sun at %g deg\n", elevations_deg[e]);
    compare_all(all, white, best, e * DIRECTIONS, (e + 1) * DIRECTIONS);
  }
  if (is_picture) {
    for (int k = 0; k < COUNTS; k++) {
      neph_scene *scene = load(context, argv[1], counts[k]);
      take_picture(scene, &all[k]);
      neph_scene_destroy(scene);
    }
    printf("%s, the matrix as for clear skies\n", argv[1]);
    compare_all(all, white, best, 0, all[0].count);
  }
  for (int k = 0; k < COUNTS; k++) free(all[k].rgb);
  neph_context_destroy(context);
  return 0;
}

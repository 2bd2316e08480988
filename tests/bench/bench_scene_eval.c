/* SPDX-License-Identifier: Apache-2.0 */
/* Evaluates frames of a scene of 40 tracks, and of ten clouds: least, median and greatest time of 10,000 frames.
 *
 * usage: bench_scene_eval
 */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include <nephos/nephos.h>

#include "scene/scene_eval.h"

enum { CLOUDS = 10, FRAMES = 10000, TEXT_SIZE = 16384 };

static void check(neph_result result) {
  if (result) exit(1);
}

static double read_clock_s(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Ten tracks of camera, sun and air, and three of each cloud. */
static void write_scene(char text[TEXT_SIZE]) {
  static const char *const tracks[] = {
      "camera.position: [[1, [0 m, -3 km, 400 m]], [100, [400 m, -2 km, 700 m]]]",
      "camera.look_at: {interpolation: smooth, keys: [[1, [0 m, 0 m, 1 km]], [50, [1 km, 0 m, 1 km]], [100, [0 m, 0 m, "
      "2 km]]]}",
      "camera.fov: [[1, 40 deg], [100, 60 deg]]",
      "camera.roll: [[1, 0 deg], [100, 5 deg]]",
      "sun.elevation: [[1, 10 deg], [100, 40 deg]]",
      "sun.azimuth: [[1, 100 deg], [100, 140 deg]]",
      "atmosphere.mie_scattering: [[1, 4e-6], [100, 8e-6]]",
      "atmosphere.mie_extinction: [[1, 4.5e-6], [100, 9e-6]]",
      "camera.focus_distance: [[1, 1 km], [100, 2 km]]",
      "camera.sensor: [[1, 0.03 m], [100, 0.04 m]]"};
  FILE *out = fmemopen(text, TEXT_SIZE, "w");
  if (!out) exit(1);
  fputs("clouds:\n", out);
  for (int i = 0; i < CLOUDS; i++) fputs("  - {bake: {preset: cumulus_mediocris, extent: 2 km}}\n", out);
  fputs("animate:\n", out);
  for (size_t i = 0; i < sizeof tracks / sizeof *tracks; i++) fprintf(out, "  %s\n", tracks[i]);
  for (int i = 0; i < CLOUDS; i++)
    fprintf(out,
            "  clouds[%d].position: [[1, [0 m, %d m, 0 m]], [100, [3 km, %d m, 0 m]]]\n"
            "  clouds[%d].rotation: [[1, 0 deg], [100, 30 deg]]\n"
            "  clouds[%d].bake.coverage: [[1, 0.2], [100, 0.6]]\n",
            i, 500 * i, 500 * i, i, i);
  fclose(out);
}

static int compare(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

int main(void) {
  static char text[TEXT_SIZE];
  static double seconds[FRAMES];
  neph_context *context;
  neph_scene *scene;
  double sum = 0.0;
  check(neph_context_create(NULL, &context));
  write_scene(text);
  check(neph_scene_load_text(context, text, "bench", &scene));
  for (int i = 0; i < FRAMES; i++) {
    neph_scene at;
    const double begin = read_clock_s();
    check(np_scene_eval(scene, 1.0 + i % 100, &at));
    sum += at.clouds[CLOUDS - 1].position_m[0];
    np_scene_eval_clear(&at);
    seconds[i] = read_clock_s() - begin;
  }
  qsort(seconds, FRAMES, sizeof *seconds, compare);
  printf("| tracks | clouds | least, µs | median, µs | greatest, µs |\n| --- | --- | --- | --- | --- |\n"
         "| %d | %d | %.1f | %.1f | %.1f |\n",
         10 + 3 * CLOUDS, CLOUDS, 1e6 * seconds[0], 1e6 * seconds[FRAMES / 2], 1e6 * seconds[FRAMES - 1]);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
  return sum > 0.0 ? 0 : 1;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Error of a picture against look-ups of density: the march, and jittered exponential Euler with a fixed step
 * (tests/march_picture.h defines both), whose steps towards the sun are one, two or four times as long as its
 * others, whichever is best.
 *
 * Usage: bench_march CLOUD.vdb UP DEPTH, with the axis of the file that is up (y or z) and the optical depth of its
 * densest column. HG 0.85, a sun of 60° in front and of 25° behind. Not a test: it prints, and the reader judges.
 */
#include <stdio.h>
#include <stdlib.h>

#include <nephos/nephos.h>

#include "core/units.h"
#include "march_picture.h"
#include "volume/volume_private.h"

enum { POINTS_MAX = 64 };

static int measure_baseline(const march_picture *p, march_point points[POINTS_MAX]) {
  int count = 0;
  for (double step = 8.0; step > 0.1; step *= 0.5)
    for (double ratio = 1.0; ratio <= 4.0; ratio *= 2.0) {
      points[count] = march_picture_measure_euler(p, step, step * ratio);
      printf("  Euler, steps of %5.3f, %5.3f to the sun   %9.0f look-ups   error %7.3f %%\n", step, step * ratio,
             points[count].lookups, 100.0 * points[count].error);
      count++;
    }
  return count;
}

static void run(march_picture *p, double elevation_deg, double azimuth_deg) {
  march_point baseline[POINTS_MAX];
  march_picture_light(p, elevation_deg * NP_DEGREE, azimuth_deg * NP_DEGREE);
  printf("sun at %g degrees, %g from the line of sight; look-ups a pixel\n", elevation_deg, azimuth_deg);
  const int count = measure_baseline(p, baseline);
  for (float tolerance = 0.16f; tolerance > 0.002f; tolerance *= 0.5f) {
    const march_point m = march_picture_measure(p, tolerance);
    printf("  march, tolerance %6.4f   %9.1f look-ups   error %7.3f %%   Euler %6.1f times as many, %6.1f without "
           "empty bricks\n",
           (double)tolerance, m.lookups, 100.0 * m.error,
           march_points_compute_lookups(baseline, count, m.error, false) / m.lookups,
           march_points_compute_lookups(baseline, count, m.error, true) / m.lookups);
  }
}

static void print_message(void *user, neph_log_level level, const char *message) {
  (void)user, (void)level;
  fprintf(stderr, "%s\n", message);
}

int main(int count, char **arguments) {
  static march_picture p;
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  neph_context *context;
  neph_volume *volume;
  desc.log = print_message;
  if (count != 4) {
    fprintf(stderr, "usage: bench_march CLOUD.vdb UP DEPTH\n");
    return 2;
  }
  const int up = arguments[2][0] == 'y' ? 1 : 2;
  if (neph_context_create(&desc, &context) || neph_volume_load(context, arguments[1], NULL, &volume)) return 1;
  double column = 0.0;
  const np_affine upright = up == 1 ? (np_affine){{{1, 0, 0, 0}, {0, 0, 1, 0}, {0, 1, 0, 0}}} : np_affine_identity();
  if (np_volume_get_column_max(volume, &upright, NULL, &column)) return 1;
  march_picture_init(&p, &volume->bricks, (float)(atof(arguments[3]) / column));
  p.width = 96, p.height = 64, p.up = up;
  for (int a = 0; a < 3; a++) {
    p.low[a] = volume->active_min[a] - 1.0;
    p.high[a] = volume->active_max[a] + 1.0;
  }
  run(&p, 60.0, 130.0);
  run(&p, 25.0, 20.0);
  neph_volume_release(volume);
  neph_context_destroy(context);
  return 0;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Usage: bench_measured_loop FOLDER [CASE]. Prints the closed loop of measured maps for stratocumulus and cumulus, at
 * several seeds, pixels and heights of the sun, and writes both pictures of each case as EXR into FOLDER. */
#include "measured_loop.h"

#include <stdio.h>

#define STRATOCUMULUS "preset: stratocumulus"

static const loop_case cases[] = {
    {"deck", LOOP_DECK, 3, 64, 10000, 62.5, 500, 30},
    {"deck", LOOP_DECK, 4, 64, 10000, 62.5, 500, 30},
    {"deck", LOOP_DECK, 5, 64, 10000, 62.5, 500, 30},
    {"deck", LOOP_DECK, 10, 64, 10000, 62.5, 500, 30},
    {"deck", LOOP_DECK, 76, 64, 10000, 62.5, 500, 30},
    {"deck", LOOP_DECK, 3, 64, 10000, 62.5, 1000, 30},
    {"deck", LOOP_DECK, 3, 64, 10000, 62.5, 500, 60},
    {"stratocumulus, broken", STRATOCUMULUS, 3, 64, 10000, 62.5, 500, 30},
    {"cumulus humilis", "preset: cumulus_humilis", 3, 64, 10000, 62.5, 500, 30},
    {"cumulus mediocris", "preset: cumulus_mediocris", 3, 64, 10000, 62.5, 500, 30},
};

static neph_result save_picture(neph_context *context, const loop_field *field, const char *path) {
  const unsigned n = (unsigned)field->pixels;
  neph_image *image = NULL;
  neph_result result = neph_image_create(context, n, n, 1, (const char *const[]){"Y"}, &image);
  if (result) return result;
  float *values = neph_image_get_channel(image, "Y");
  for (unsigned i = 0; i < n * n; i++) values[i] = (float)field->reflectances[(n - 1 - i / n) * n + i % n];
  result = neph_image_save_exr(image, path, NEPH_PIXEL_FLOAT);
  neph_image_destroy(image);
  return result;
}

static neph_result run_case(neph_context *context, const char *folder, unsigned number) {
  const loop_case *c = &cases[number];
  char path[4096];
  loop_result r;
  snprintf(path, sizeof path, "%s/map%u.tif", folder, number);
  neph_result result = loop_run(context, c, path, &r);
  for (int i = 0; i < 2 && !result; i++) {
    snprintf(path, sizeof path, "%s/picture%u_%d.exr", folder, number, i);
    result = save_picture(context, &r.fields[i], path);
  }
  if (!result)
    printf("| %s | %u | %g | %g | %.2g to %.2g | %.2f | %.2f | %.1f | %+.1f | %.3f | %.3f | %.3f | %.3f | %.3f |\n",
           c->name, c->seed, c->pixel_m, 90 - c->elevation_deg, r.low, r.high, r.mean[0], r.mean[1], 100 * r.block_rms,
           100 * r.block_bias, r.covered[0], r.covered[1], r.reflectance[0], r.reflectance[1], r.picture_rms);
  fflush(stdout);
  loop_clear(&r);
  return result;
}

int main(int count, char **arguments) {
  neph_context *context;
  if (count < 2 || neph_context_create(NULL, &context)) return 2;
  puts("| field | seed | pixel, m | sun from zenith, ° | depth of pixels | mean depth | measured | rms, 2 km, % | "
       "bias, % | "
       "coverage | measured | reflectance | again | rms, 2 km |");
  puts("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
  neph_result result = NEPH_OK;
  for (unsigned i = 0; i < sizeof cases / sizeof *cases && !result; i++)
    if (count < 3 || (unsigned)atoi(arguments[2]) == i) result = run_case(context, arguments[1], i);
  neph_context_destroy(context);
  return result ? 1 : 0;
}

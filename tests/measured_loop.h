/* SPDX-License-Identifier: Apache-2.0 */
/* The closed loop of measured maps: a field of clouds is baked and rendered from above, its reflectance is written as a
 * GeoTIFF, which another seed of the model is fitted to, baked and rendered again. */
#ifndef TEST_MEASURED_LOOP_H
#define TEST_MEASURED_LOOP_H

#include "test_geotiffs.h"

#include <math.h>
#include <stdlib.h>

#include <nephos/nephos.h>

#include "cloud/bake_grid.h"
#include "scene/scene_eval.h"

typedef struct loop_case {
  const char *name, *bake; /* keys of the field: "preset: stratocumulus" */
  unsigned seed, samples;
  double extent_m, voxel_m, pixel_m, elevation_deg;
} loop_case;

/* A closed deck, whose pixels of 500 m have depths of 2 to 40. */
#define LOOP_DECK "preset: stratocumulus, coverage: 1, extinction: 0.12 1/m"

enum { LOOP_BLOCK_M = 2000, LOOP_RIM_M = 1000 /* rim of a field, which stays clear in a bake and is not compared */ };

/* One field: columns and pixels, from the south-west. */
typedef struct loop_field {
  int side, pixels;
  double voxel_m, *depths, *reflectances;
} loop_field;

typedef struct loop_result {
  loop_field fields[2];               /* the first one, and the one that was measured */
  double low, high;                   /* 5 % and 95 % of the first field's depths of pixels */
  double mean[2], covered[2];         /* mean depth, and share of columns deeper than 0.3 */
  double block_rms, block_bias;       /* relative error of the second field's depths in blocks */
  double reflectance[2], picture_rms; /* means of both pictures, and rms of their difference in blocks */
} loop_result;

static inline void loop_clear(loop_result *result) {
  for (int i = 0; i < 2; i++) {
    free(result->fields[i].depths);
    free(result->fields[i].reflectances);
  }
}

/* Scene of a field over a black ground, without air, seen from above. */
static inline char *loop_write_scene(const loop_case *c, const char *map) {
  char *text = NULL;
  const int pixels = (int)round(c->extent_m / c->pixel_m);
  const int length = asprintf(
      &text,
      "version: 1\nplace: {latitude: 34 deg, longitude: -117 deg}\n"
      "camera: {kind: orthographic, position: [0 m, 0 m, 20 km], look_at: [0 m, 0 m, 0 m], orthographic_width: %g m, "
      "resolution: [%d, %d]}\n"
      "sun: {elevation: %g deg, azimuth: 120 deg, irradiance: 1}\natmosphere: none\nenvironment: {planet: none}\n"
      "clouds:\n  - {phase: {hg: 0.85}, albedo: 1, bake: {%s, seed: %u, extent: [%g m, %g m], voxel: %g m%s}}\n"
      "render: {integrator: march, samples: %u}\noutput: {color_space: bands, pixel_type: float}\n",
      c->extent_m, pixels, pixels, c->elevation_deg, c->bake, map ? c->seed + 100 : c->seed, c->extent_m, c->extent_m,
      c->voxel_m, map ? map : "", c->samples);
  return length > 0 ? text : NULL;
}

static inline neph_result loop_bake(const neph_scene *scene, loop_field *field) {
  neph_scene at;
  neph_result result = np_scene_eval(scene, 1, &at);
  if (result) return result;
  const neph_bake_desc bake_desc = NEPH_BAKE_DESC_DEFAULT;
  np_sparse_grid grid;
  np_monitor monitor;
  np_monitor_start(&monitor, scene->context, NULL, NULL);
  result = np_cloud_bake_grid(scene->context, &at.clouds[0].bake, &bake_desc, "density", &monitor, &grid);
  np_scene_eval_clear(&at);
  if (result) return result;
  for (size_t l = 0; l < grid.leaf_count; l++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const np_leaf *leaf = &grid.leaves[l];
      const int i = leaf->origin[0] + n / 64, j = leaf->origin[1] + n / 8 % 8;
      if (i < field->side && j < field->side)
        field->depths[j * field->side + i] += (double)leaf->values[n] * field->voxel_m;
    }
  np_sparse_grid_clear(&grid);
  return NEPH_OK;
}

static inline neph_result loop_render(const neph_scene *scene, const loop_case *c, loop_field *field) {
  neph_image *image = NULL;
  const neph_result result = neph_render_image(scene, NULL, &image);
  if (result) return result;
  const float *values = neph_image_get_channel(image, "R");
  const double white = sin(c->elevation_deg * 0.017453292519943295) / 3.14159265358979;
  for (int row = 0; row < field->pixels; row++)
    for (int i = 0; i < field->pixels; i++)
      field->reflectances[(field->pixels - 1 - row) * field->pixels + i] =
          (double)values[row * field->pixels + i] / white;
  neph_image_destroy(image);
  return NEPH_OK;
}

/* Bakes and renders one field. */
static inline neph_result loop_make_field(neph_context *context, const loop_case *c, const char *map, loop_field *out) {
  const int side = (int)round(c->extent_m / c->voxel_m), pixels = (int)round(c->extent_m / c->pixel_m);
  neph_scene *scene = NULL;
  char *text = loop_write_scene(c, map);
  *out = (loop_field){side, pixels, c->voxel_m, calloc((size_t)(side * side), sizeof(double)),
                      calloc((size_t)(pixels * pixels), sizeof(double))};
  neph_result result = neph_scene_load_text(context, text, "loop.yaml", &scene);
  if (!result) result = loop_bake(scene, out);
  if (!result) result = loop_render(scene, c, out);
  neph_scene_destroy(scene);
  free(text);
  return result;
}

/* Mean of values in square `number` of `across` along each side. */
static inline double loop_average(const double *values, int side, int across, int number) {
  const int edge = side / across, first_i = number % across * edge, first_j = number / across * edge;
  double sum = 0;
  for (int j = 0; j < edge; j++)
    for (int i = 0; i < edge; i++) sum += values[(first_j + j) * side + first_i + i];
  return sum / (edge * edge);
}

static inline int loop_compare(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Cuts the rim off. */
static inline void loop_crop(double *values, int *side, double step_m) {
  const int rim = (int)round(LOOP_RIM_M / step_m), inner = *side - 2 * rim;
  for (int j = 0; j < inner; j++)
    memmove(values + j * inner, values + (j + rim) * *side + rim, (size_t)inner * sizeof *values);
  *side = inner;
}

static inline void loop_measure(const loop_case *c, loop_result *r) {
  for (int i = 0; i < 2; i++) {
    loop_crop(r->fields[i].depths, &r->fields[i].side, c->voxel_m);
    loop_crop(r->fields[i].reflectances, &r->fields[i].pixels, c->pixel_m);
  }
  const int blocks = (int)((c->extent_m - 2 * LOOP_RIM_M) / LOOP_BLOCK_M), pixels = r->fields[0].pixels,
            side = r->fields[0].side;
  double *depths = calloc((size_t)(pixels * pixels), sizeof *depths), squares = 0, picture = 0, count = 0;
  for (int n = 0; n < pixels * pixels; n++) depths[n] = loop_average(r->fields[0].depths, side, pixels, n);
  qsort(depths, (size_t)(pixels * pixels), sizeof *depths, loop_compare);
  r->low = depths[pixels * pixels / 20];
  r->high = depths[pixels * pixels - 1 - pixels * pixels / 20];
  free(depths);
  r->block_bias = 0;
  for (int n = 0; n < blocks * blocks; n++) {
    double depth[2], bright[2];
    for (int i = 0; i < 2; i++) {
      depth[i] = loop_average(r->fields[i].depths, side, blocks, n);
      bright[i] = loop_average(r->fields[i].reflectances, pixels, blocks, n);
    }
    picture += pow(bright[1] - bright[0], 2);
    if (!(depth[0] > 0)) continue;
    squares += pow(depth[1] / depth[0] - 1, 2);
    r->block_bias += depth[1] / depth[0] - 1;
    count++;
  }
  r->block_rms = sqrt(squares / count);
  r->block_bias /= count;
  r->picture_rms = sqrt(picture / (blocks * blocks));
  for (int i = 0; i < 2; i++) {
    r->mean[i] = loop_average(r->fields[i].depths, side, 1, 0);
    r->reflectance[i] = loop_average(r->fields[i].reflectances, pixels, 1, 0);
    r->covered[i] = 0;
    for (int n = 0; n < side * side; n++) r->covered[i] += (r->fields[i].depths[n] > 0.3) / ((double)side * side);
  }
}

/* Writes the reflectances of the first field, north up, on pixels of UTM around the scene's place. */
static inline neph_result loop_write_map(const loop_case *c, const loop_field *field, const char *path) {
  const int n = field->pixels;
  const double step_m = c->pixel_m * 0.9996, half_m = 0.5 * n * step_m; /* scale on the zone's central meridian */
  const test_geotiff tiff = {.width = n,
                             .height = n,
                             .crs = "EPSG:32611",
                             .transform = {500000 - half_m, step_m, 0, 3762155.9776 + half_m, 0, -step_m}};
  float *values = calloc((size_t)(n * n), sizeof *values);
  for (int i = 0; i < n * n; i++) values[i] = (float)field->reflectances[(n - 1 - i / n) * n + i % n];
  test_save_geotiff(path, &tiff, values);
  free(values);
  return NEPH_OK;
}

/* Runs the loop with a GeoTIFF at `path`. The caller clears the result, whatever the outcome. */
static inline neph_result loop_run(neph_context *context, const loop_case *c, const char *path, loop_result *out) {
  char map[4400];
  *out = (loop_result){.low = 0};
  neph_result result = loop_make_field(context, c, NULL, &out->fields[0]);
  if (!result) result = loop_write_map(c, &out->fields[0], path);
  snprintf(map, sizeof map,
           ", map: {file: \"%s\", quantity: reflectance, sun: {elevation: %g deg, azimuth: 120 deg}, ground_albedo: 0}",
           path, c->elevation_deg);
  if (!result) result = loop_make_field(context, c, map, &out->fields[1]);
  if (!result) loop_measure(c, out);
  return result;
}

#endif

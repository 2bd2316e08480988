/* SPDX-License-Identifier: Apache-2.0 */
/* Statistics of baked fields as observers of nature give them: `bench_nature PRESET [KEY=VALUE…]`, keys seed, extent,
 * voxel, coverage, cell, billow, thickness in metres and shares, streets, cells (open or closed), cells_size, model
 * (cells or thermals), deck (1: spectra). It fails where a field of cumulus, or with deck=1 the spectrum of a deck, is
 * not as in nature.
 *
 * Columns of voxels are evaluated leaf by leaf and kept as their vertical optical depth, so that a field of 40 km takes
 * the memory of its map and a byte a voxel.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cloud/cloud_build.h"
#include "cloud/cloud_density.h"
#include "field_statistics.h"

enum { LEAF = 8 };

static const double region_cells_min = 30;   /* area of what counts in a dimension, in columns */
static const double size_cells_min = 4;      /* √area of what counts in sizes, in columns */
static const double crumb_cells = 33;        /* volume of a ball of four voxels */
static const double aloft_share = 0.25;      /* share of the thickness: crumbs above it are aloft */
static const double deck_shortest_cells = 6; /* wavelengths of spectra, in columns */
static const double deck_decade = 10;

typedef struct field {
  np_cloud_model model;
  int32_t size[3];
  float *optical_depth; /* x fastest */
  int16_t *low, *high;  /* range of the cloud in the column, in voxels */
  uint8_t *is_cloud;    /* z fastest, then y: x slowest */
} field;

/* ---- The field ---- */

static void take_leaf(field *f, const int32_t origin[3], const float *extinction) {
  const float voxel_m = (float)f->model.desc.voxel_m;
  for (int n = 0; n < NP_CLOUD_BLOCK; n++) {
    const int32_t i = origin[0] + n / 64, j = origin[1] + n / 8 % 8, k = origin[2] + n % 8;
    if (!(extinction[n] > 0) || i >= f->size[0] || j >= f->size[1] || k >= f->size[2]) continue;
    const size_t column = (size_t)j * (size_t)f->size[0] + (size_t)i;
    f->optical_depth[column] += extinction[n] * voxel_m;
    if (k < f->low[column]) f->low[column] = (int16_t)k;
    if (k > f->high[column]) f->high[column] = (int16_t)k;
    f->is_cloud[((size_t)i * (size_t)f->size[1] + (size_t)j) * (size_t)f->size[2] + (size_t)k] = 1;
  }
}

static void eval_leaf(field *f, const int32_t origin[3]) {
  const neph_cloud_desc *desc = &f->model.desc;
  const float voxel_m = (float)desc->voxel_m;
  float x[NP_CLOUD_BLOCK], y[NP_CLOUD_BLOCK], z[NP_CLOUD_BLOCK], extinction[NP_CLOUD_BLOCK] = {0};
  np_cloud_box box;
  for (int a = 0; a < 3; a++) {
    const float low_m = a < 2 ? -0.5f * (float)desc->extent_m[a] : 0.0f;
    box.min_m[a] = low_m + (float)origin[a] * voxel_m;
    box.max_m[a] = low_m + (float)(origin[a] + LEAF) * voxel_m;
  }
  if (np_cloud_model_is_empty(&f->model, &box)) return;
  for (int n = 0; n < NP_CLOUD_BLOCK; n++) {
    x[n] = box.min_m[0] + ((float)(n / 64) + 0.5f) * voxel_m;
    y[n] = box.min_m[1] + ((float)(n / 8 % 8) + 0.5f) * voxel_m;
    z[n] = box.min_m[2] + ((float)(n % 8) + 0.5f) * voxel_m;
  }
  np_cloud_model_eval(&f->model, &(np_cloud_points){NP_CLOUD_BLOCK, x, y, z}, extinction);
  take_leaf(f, origin, extinction);
}

static neph_result eval_rows(void *user, size_t begin, size_t end, unsigned thread) {
  field *f = user;
  (void)thread;
  for (size_t row = begin; row < end; row++)
    for (int32_t j = 0; j < f->size[1]; j += LEAF)
      for (int32_t k = 0; k < f->size[2]; k += LEAF) eval_leaf(f, (int32_t[]){(int32_t)row * LEAF, j, k});
  return NEPH_OK;
}

static neph_result make_field(neph_context *context, const neph_cloud_desc *desc, field *f) {
  neph_result result = np_cloud_model_build(context, desc, 6.36e6, NULL, &f->model);
  if (result) return result;
  for (int a = 0; a < 3; a++)
    f->size[a] = (int32_t)ceil((a < 2 ? desc->extent_m[a] : desc->thickness_m) / desc->voxel_m);
  const size_t columns = (size_t)f->size[0] * (size_t)f->size[1];
  f->optical_depth = calloc(columns, sizeof *f->optical_depth);
  f->low = malloc(columns * sizeof *f->low);
  f->high = malloc(columns * sizeof *f->high);
  f->is_cloud = calloc(columns * (size_t)f->size[2], 1);
  if (!f->optical_depth || !f->low || !f->high || !f->is_cloud) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t n = 0; n < columns; n++) f->low[n] = INT16_MAX, f->high[n] = -1;
  return np_parallel_for(context, NULL, (size_t)(f->size[0] + LEAF - 1) / LEAF, 1, eval_rows, f);
}

static void clear_field(field *f) {
  np_cloud_model_clear(&f->model);
  free(f->optical_depth);
  free(f->low);
  free(f->high);
  free(f->is_cloud);
}

/* ---- Statistics ---- */

static int compare_doubles(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double get_quantile(double *values, size_t count, double share) {
  qsort(values, count, sizeof *values, compare_doubles);
  return count ? values[(size_t)(share * (double)(count - 1))] : nan("");
}

/* Height of each region over its √area: medians of those below and above 500 m across. */
static void print_aspects(const field *f, const field_region *regions, const int32_t *labels, size_t count) {
  const size_t columns = (size_t)f->size[0] * (size_t)f->size[1];
  double *ratios[2] = {malloc((count + 1) * sizeof(double)), malloc((count + 1) * sizeof(double))};
  int32_t *low = malloc((count + 1) * sizeof *low), *high = calloc(count + 1, sizeof *high);
  size_t counts[2] = {0};
  for (size_t r = 0; r < count && low; r++) low[r] = INT32_MAX;
  for (size_t n = 0; n < columns; n++) {
    if (!labels[n]) continue;
    if (f->low[n] < low[labels[n] - 1]) low[labels[n] - 1] = f->low[n];
    if (f->high[n] > high[labels[n] - 1]) high[labels[n] - 1] = f->high[n];
  }
  for (size_t r = 0; r < count; r++) {
    const double size = sqrt(regions[r].area);
    const int is_large = size * f->model.desc.voxel_m > 500;
    if (size >= 2 * size_cells_min) ratios[is_large][counts[is_large]++] = (high[r] - low[r] + 1) / size;
  }
  printf("height/width  small %.2f  large %.2f (%zu, %zu)\n", get_quantile(ratios[0], counts[0], 0.5),
         get_quantile(ratios[1], counts[1], 0.5), counts[0], counts[1]);
  free(ratios[0]);
  free(ratios[1]);
  free(low);
  free(high);
}

static void print_crumbs(const field *f) {
  size_t count = 0, crumbs = 0, aloft = 0;
  const int32_t size[3] = {f->size[0], f->size[1], f->size[2]};
  field_component *components = field_label_components(size, f->is_cloud, &count);
  for (size_t c = 0; c < count && components; c++) {
    const bool is_crumb = components[c].volume < crumb_cells;
    crumbs += is_crumb;
    aloft += is_crumb && components[c].lowest > aloft_share * size[2];
  }
  printf("components    %zu, crumbs %zu, aloft %zu\n", count, crumbs, aloft);
  free(components);
}

/* A figure against the range of docs/results/nature.md. */
static bool is_within(const char *name, double value, double low, double high) {
  if (value >= low && value <= high) return true;
  fprintf(stderr, "%s is %.3f, must be in [%g, %g]\n", name, value, low, high);
  return false;
}

static bool check_regions(const field_power_law *law, const field_line *line) {
  const bool are_many = is_within("number of clouds", (double)law->count, 500, 1e9);
  const bool are_sized = is_within("exponent of sizes", -law->below, -2.3, -1.7);
  return is_within("dimension", line->slope, 1.30, 1.40) && is_within("decades of area", line->decades, 2, 9) &&
         are_many && are_sized;
}

/* False: clouds of a field that is no deck are not as in nature. */
static bool print_regions(const field *f, bool is_deck) {
  const size_t columns = (size_t)f->size[0] * (size_t)f->size[1];
  const double voxel_m = f->model.desc.voxel_m;
  uint8_t *is_inside = malloc(columns);
  int32_t *labels = malloc(columns * sizeof *labels);
  size_t count = 0, covered = 0;
  for (size_t n = 0; n < columns; n++) covered += is_inside[n] = f->optical_depth[n] > 1;
  field_region *regions = field_label_regions(f->size[0], f->size[1], is_inside, labels, &count);
  double *sizes = malloc((count + 1) * sizeof *sizes), largest = 0;
  for (size_t r = 0; r < count; r++) {
    sizes[r] = sqrt(regions[r].area) * voxel_m;
    largest = fmax(largest, sizes[r]);
  }
  field_power_law law = {0};
  const bool is_fitted = field_fit_power_law(sizes, count, size_cells_min * voxel_m, &law);
  const field_line line = field_fit_dimension(regions, count, region_cells_min);
  printf("clouds        %zu, of which %zu above %.0f m; largest %.0f m, cover %.3f\n", count, law.count,
         size_cells_min * voxel_m, largest, (double)covered / (double)columns);
  if (is_fitted)
    printf("sizes         -%.2f ± %.2f below %.0f m, -%.2f above; gain %.1f\n", law.below, law.below_error,
           law.break_size, law.above, law.gain);
  printf("dimension     %.3f ± %.3f over %.2f decades\n", line.slope, line.error, line.decades);
  print_aspects(f, regions, labels, count);
  free(sizes);
  free(regions);
  free(labels);
  free(is_inside);
  return is_deck || (is_fitted && check_regions(&law, &line));
}

/* The middle half of the field: borders, where clouds end, are not the deck's. */
static bool print_spectrum(const field *f) {
  const int32_t width = f->size[0] * 3 / 4, height = f->size[1] * 3 / 4;
  const float *corner = f->optical_depth + (size_t)(f->size[1] / 8) * (size_t)f->size[0] + f->size[0] / 8;
  float *values = malloc((size_t)width * (size_t)height * sizeof *values);
  field_line line = {0};
  bool is_found = false;
  double mean = 0, squares = 0;
  for (int32_t j = 0; j < height; j++)
    for (int32_t i = 0; i < width; i++) {
      const float value = corner[(size_t)j * (size_t)f->size[0] + (size_t)i];
      values[(size_t)j * (size_t)width + (size_t)i] = value;
      mean += (double)value;
      squares += (double)value * (double)value;
    }
  const double count = (double)width * height, voxel_m = f->model.desc.voxel_m;
  for (double shortest = deck_shortest_cells; 2.5 * shortest * deck_decade <= width; shortest *= 2)
    if (field_fit_spectrum(width, height, values, shortest, shortest * deck_decade, &line)) {
      is_found = is_found || fabs(line.slope + 5.0 / 3) <= 0.2;
      printf("spectrum      %.2f ± %.2f from %.0f to %.0f m\n", line.slope, line.error, shortest * voxel_m,
             shortest * deck_decade * voxel_m);
    }
  printf("depth         mean %.2f, std/mean %.2f\n", mean / count,
         sqrt(squares / count - mean * mean / count / count) / (mean / count));
  free(values);
  if (!is_found) fprintf(stderr, "no decade has a slope within 0.2 of -5/3\n");
  return is_found;
}

/* ---- Arguments ---- */

static bool set_value(neph_cloud_desc *desc, bool *is_deck, const char *argument) {
  struct {
    const char *key;
    double *value;
  } keys[] = {
      {"voxel", &desc->voxel_m},           {"coverage", &desc->coverage},     {"cell", &desc->cell_m},
      {"billow", &desc->billow_m},         {"thickness", &desc->thickness_m}, {"erosion", &desc->erosion},
      {"wispiness", &desc->wispiness},     {"turbulence", &desc->turbulence}, {"age", &desc->age},
      {"billowiness", &desc->billowiness}, {"streets", &desc->streets},       {"cells_size", &desc->cells_size_m}};
  const char *value = strchr(argument, '=');
  if (!value) return false;
  const size_t length = (size_t)(value++ - argument);
  for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
    if (strlen(keys[i].key) == length && !memcmp(keys[i].key, argument, length)) {
      *keys[i].value = strtod(value, NULL);
      return true;
    }
  if (!strncmp(argument, "extent=", 7)) return (desc->extent_m[0] = desc->extent_m[1] = strtod(value, NULL)) > 0;
  if (!strncmp(argument, "seed=", 5)) return (desc->seed = strtoull(value, NULL, 10)) || true;
  if (!strncmp(argument, "cells=", 6)) {
    desc->cells_kind = !strcmp(value, "open") ? NEPH_CLOUD_CELLS_OPEN : NEPH_CLOUD_CELLS_CLOSED;
    return true;
  }
  if (!strncmp(argument, "deck=", 5)) return (*is_deck = *value == '1') || true;
  if (strncmp(argument, "model=", 6)) return false;
  desc->model = !strcmp(value, "cells") ? NEPH_CLOUD_MODEL_CELLS : NEPH_CLOUD_MODEL_THERMALS;
  return true;
}

int main(int argc, char **argv) {
  neph_cloud_desc desc = NEPH_CLOUD_DESC_DEFAULT;
  neph_context *context = NULL;
  field f = {0};
  bool is_deck = false, is_natural = true;
  neph_result result = neph_context_create(NULL, &context);
  if (!result) result = neph_cloud_get_preset(context, argc > 1 ? argv[1] : "", &desc);
  for (int n = 2; n < argc && !result; n++)
    if (!set_value(&desc, &is_deck, argv[n])) {
      fprintf(stderr, "\"%s\" is none of the keys: see the head of bench_nature.c\n", argv[n]);
      result = NEPH_ERROR_INVALID_ARGUMENT;
    }
  if (!result) result = make_field(context, &desc, &f);
  if (!result) {
    const bool has_sizes = print_regions(&f, is_deck);
    print_crumbs(&f);
    is_natural = is_deck ? print_spectrum(&f) : has_sizes;
  }
  clear_field(&f);
  neph_context_destroy(context);
  return result || !is_natural ? EXIT_FAILURE : EXIT_SUCCESS;
}

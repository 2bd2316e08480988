/* SPDX-License-Identifier: Apache-2.0 */
/* Error that a picture's header states, against the true one.
 *
 * Usage: bench_error NAME PICTURE SECOND REFERENCE REFERENCE…  SECOND is the picture with another seed; references are
 * an even number of pictures by the tracer, of different seeds. T is their mean, A and B are the means of every other
 * one: error² = mean of (I − A)(I − B)/T² over pixels above a hundredth of the mean, noise² = (I − I₂)²/2T², bias² =
 * (I − A)(I₂ − B)/T², in which no noise of a reference stays. Prints a row of docs/results/error.md: the true figures
 * with 95 % bounds by blocks of 8×8 pixels, the stated ones, and stated over true error.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <nephos/nephos.h>

enum { BLOCK_PIXELS = 8, MEASURES = 3, REFERENCES_MAX = 16 };

static const double dim_of_mean = 0.01, normal_quantile_975 = 1.959963984540054;

typedef struct pictures {
  neph_context *context;
  neph_image *picture, *second, *references[REFERENCES_MAX];
  int reference_count;
  unsigned width, height;
} pictures;

static neph_image *load(neph_context *context, const char *path) {
  neph_image *image;
  if (neph_image_load_exr(context, path, &image)) exit(1);
  return image;
}

/* Rec.709, the default of a scene. */
static double get_luminance(neph_image *image, size_t i) {
  return 0.2126 * (double)neph_image_get_channel(image, "R")[i] +
         0.7152 * (double)neph_image_get_channel(image, "G")[i] +
         0.0722 * (double)neph_image_get_channel(image, "B")[i];
}

/* Means of every other reference. */
static void get_references(const pictures *p, size_t i, double out[2]) {
  out[0] = out[1] = 0.0;
  for (int r = 0; r < p->reference_count; r++)
    out[r % 2] += get_luminance(p->references[r], i) / (0.5 * p->reference_count);
}

static double compute_dim(const pictures *p) {
  double sum = 0.0, reference[2];
  const size_t count = (size_t)p->width * p->height;
  for (size_t i = 0; i < count; i++) {
    get_references(p, i, reference);
    sum += 0.5 * (reference[0] + reference[1]) / (double)count;
  }
  return dim_of_mean * sum;
}

/* Squares of error, noise and bias, summed over a block; the last is the number of pixels. */
static void add_pixel(const pictures *p, size_t i, double dim, double sums[MEASURES + 1]) {
  double r[2];
  get_references(p, i, r);
  const double mean = 0.5 * (r[0] + r[1]), a = get_luminance(p->picture, i), b = get_luminance(p->second, i);
  if (!(mean > dim)) return;
  sums[0] += 0.5 * ((a - r[0]) * (a - r[1]) + (b - r[0]) * (b - r[1])) / (mean * mean);
  sums[1] += 0.5 * (a - b) * (a - b) / (mean * mean);
  sums[2] += 0.5 * ((a - r[0]) * (b - r[1]) + (a - r[1]) * (b - r[0])) / (mean * mean);
  sums[MEASURES] += 1.0;
}

static void print_measure(size_t block_count, double (*blocks)[MEASURES + 1], int m, double *out_root) {
  double sum = 0.0, pixels = 0.0, residual2 = 0.0;
  for (size_t i = 0; i < block_count; i++) sum += blocks[i][m], pixels += blocks[i][MEASURES];
  const double mean = sum / pixels;
  for (size_t i = 0; i < block_count; i++) residual2 += pow(blocks[i][m] - mean * blocks[i][MEASURES], 2.0);
  const double half = normal_quantile_975 * sqrt(residual2) / pixels;
  *out_root = sqrt(fmax(mean, 0.0));
  printf(" %.1f (%.1f to %.1f) |", 100.0 * *out_root, 100.0 * sqrt(fmax(mean - half, 0.0)),
         100.0 * sqrt(fmax(mean + half, 0.0)));
}

static double get_stated(const neph_image *image, const char *name) {
  const char *text = neph_image_get_attribute(image, name);
  return text ? strtod(text, NULL) : (double)NAN;
}

static void print_row(const char *name, const pictures *p) {
  static double blocks[(65536 / BLOCK_PIXELS)][MEASURES + 1];
  const unsigned columns = (p->width + BLOCK_PIXELS - 1) / BLOCK_PIXELS;
  const double dim = compute_dim(p);
  double roots[MEASURES];
  for (unsigned y = 0; y < p->height; y++)
    for (unsigned x = 0; x < p->width; x++)
      add_pixel(p, (size_t)y * p->width + x, dim, blocks[y / BLOCK_PIXELS * columns + x / BLOCK_PIXELS]);
  printf("| %s |", name);
  for (int m = 0; m < MEASURES; m++)
    print_measure((size_t)columns * ((p->height + BLOCK_PIXELS - 1) / BLOCK_PIXELS), blocks, m, &roots[m]);
  const double error = get_stated(p->picture, "nephos:error");
  printf(" %.1f | %.1f | %.1f | %.2f |\n", 100.0 * error, 100.0 * get_stated(p->picture, "nephos:noise"),
         100.0 * get_stated(p->picture, "nephos:bias"), error / roots[0]);
}

int main(int argc, char **argv) {
  pictures p = {.reference_count = argc - 4};
  if (argc < 6 || p.reference_count % 2 || p.reference_count > REFERENCES_MAX) {
    (void)fprintf(stderr, "usage: bench_error NAME PICTURE SECOND REFERENCE REFERENCE…, an even number of the last\n");
    return 2;
  }
  if (neph_context_create(NULL, &p.context)) return 1;
  p.picture = load(p.context, argv[2]);
  p.second = load(p.context, argv[3]);
  for (int r = 0; r < p.reference_count; r++) p.references[r] = load(p.context, argv[4 + r]);
  p.width = neph_image_get_width(p.picture);
  p.height = neph_image_get_height(p.picture);
  print_row(argv[1], &p);
  for (int r = 0; r < p.reference_count; r++) neph_image_destroy(p.references[r]);
  neph_image_destroy(p.picture);
  neph_image_destroy(p.second);
  neph_context_destroy(p.context);
  return 0;
}

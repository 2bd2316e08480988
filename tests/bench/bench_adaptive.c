/* SPDX-License-Identifier: Apache-2.0 */
/* Noise and CPU time of pictures with a target error, compared with equal numbers of samples in each pixel.
 *
 * Usage: bench_adaptive NAME SCENE KEY=VALUE… [SEEDS SECONDS TARGET…]
 *
 * Each target is rendered with SEEDS seeds, then 1, 2, 4 … samples for all pixels until they are less noisy than the
 * least target, or a picture takes SECONDS of CPU. The true noise is that of docs/error.md, by the variance over seeds
 * and by the mean of all pictures. Prints rows of docs/results/adaptive.md: target noise, true noise, mean, least and
 * largest number of samples, the uniform number with equal noise, its ratio to the mean, and the ratio of the CPU
 * times. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include <nephos/nephos.h>

enum { SETS_MAX = 32, SEEDS_MAX = 64 };

static const double dim_of_mean = 0.01;

/* Pictures that differ in their seeds. */
typedef struct picture_set {
  double target; /* infinite: the same number of samples for all */
  double asked, samples, least, most, seconds, noise;
  double *sum, *squares; /* sums over each pixel's luminance */
} picture_set;

typedef struct bench {
  neph_scene *scene;
  neph_renderer *renderer;
  unsigned seeds;
  size_t pixels;
  unsigned count;
  picture_set set[SETS_MAX];
} bench;

static double get_cpu_s(void) {
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return (double)usage.ru_utime.tv_sec + 1e-6 * (double)usage.ru_utime.tv_usec;
}

static double get_number(const neph_image *image, const char *name) {
  const char *text = neph_image_get_attribute(image, name);
  return text ? strtod(text, NULL) : (double)NAN;
}

static void check(neph_result result) {
  if (result) exit(1);
}

static void add_picture(picture_set *set, neph_image *image, size_t pixels) {
  const float *r = neph_image_get_channel(image, "R"), *g = neph_image_get_channel(image, "G"),
              *b = neph_image_get_channel(image, "B"), *n = neph_image_get_channel(image, "sample_count");
  for (size_t i = 0; i < pixels; i++) {
    const double y = 0.2126 * (double)r[i] + 0.7152 * (double)g[i] + 0.0722 * (double)b[i];
    set->sum[i] += y;
    set->squares[i] += y * y;
    set->least = fmin(set->least, (double)n[i]);
    set->most = fmax(set->most, (double)n[i]);
  }
}

static picture_set *render_set(bench *b, double target, unsigned samples) {
  picture_set *set = &b->set[b->count++];
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  check(neph_scene_get_render_desc(b->scene, &desc));
  b->pixels = (size_t)desc.width * desc.height;
  *set = (picture_set){.target = target, .least = HUGE_VAL};
  set->sum = calloc(b->pixels, sizeof *set->sum);
  set->squares = calloc(b->pixels, sizeof *set->squares);
  if (!set->sum || !set->squares) exit(1);
  desc.sample_count = samples;
  desc.target_error = target;
  for (unsigned k = 0; k < b->seeds; k++) {
    neph_image *image;
    desc.seed = 1 + k + 1000 * b->count;
    const double begin_s = get_cpu_s();
    check(neph_renderer_render(b->renderer, b->scene, &desc, &image));
    set->seconds += (get_cpu_s() - begin_s) / b->seeds;
    set->samples += get_number(image, "nephos:samples") / b->seeds;
    set->asked = get_number(image, "nephos:targetNoise");
    add_picture(set, image, b->pixels);
    neph_image_destroy(image);
  }
  return set;
}

/* Mean of all pictures, by the samples that they have. */
static double *compute_means(const bench *b, double *out_dim) {
  double *mean = calloc(b->pixels, sizeof *mean), all = 0.0, sum = 0.0;
  if (!mean) exit(1);
  for (unsigned s = 0; s < b->count; s++) all += b->seeds * b->set[s].samples;
  for (size_t i = 0; i < b->pixels; i++) {
    for (unsigned s = 0; s < b->count; s++) mean[i] += b->set[s].samples * b->set[s].sum[i] / all;
    sum += mean[i];
  }
  *out_dim = dim_of_mean * sum / (double)b->pixels;
  return mean;
}

static void compute_noises(bench *b) {
  double dim, *mean = compute_means(b, &dim);
  for (unsigned s = 0; s < b->count; s++) {
    double sum = 0.0, count = 0.0;
    for (size_t i = 0; i < b->pixels; i++) {
      if (!(mean[i] > dim)) continue;
      const double own = b->set[s].sum[i] / b->seeds;
      const double variance = (b->set[s].squares[i] - b->seeds * own * own) / (b->seeds - 1);
      sum += fmax(variance, 0.0) / (mean[i] * mean[i]);
      count += 1.0;
    }
    b->set[s].noise = sqrt(sum / count);
  }
  free(mean);
}

/* A quantity of uniform pictures at a noise, interpolated or continued along the logarithms. */
typedef double quantity_fn(const picture_set *set);

static double get_samples(const picture_set *set) { return set->samples; }
static double get_seconds(const picture_set *set) { return set->seconds; }

static double interpolate(const bench *b, double noise, quantity_fn *quantity) {
  const picture_set *pair[2] = {&b->set[0], &b->set[0]};
  unsigned count = 0;
  for (unsigned s = 0; s < b->count; s++) {
    if (isfinite(b->set[s].target)) continue;
    if (count > 1 && pair[1]->noise <= noise) break;
    pair[0] = count ? pair[1] : &b->set[s];
    pair[1] = &b->set[s];
    count++;
  }
  if (count < 2) return quantity(pair[1]);
  const double share = log(pair[0]->noise / noise) / log(pair[0]->noise / pair[1]->noise);
  return quantity(pair[0]) * pow(quantity(pair[1]) / quantity(pair[0]), share);
}

static void print_rows(const bench *b, const char *name) {
  for (unsigned s = 0; s < b->count; s++) {
    const picture_set *set = &b->set[s];
    if (!isfinite(set->target)) {
      fprintf(stderr, "%s: %g samples for all, noise %.3g %%, %.3g s\n", name, set->samples, 100.0 * set->noise,
              set->seconds);
      continue;
    }
    const double samples = interpolate(b, set->noise, get_samples), seconds = interpolate(b, set->noise, get_seconds);
    printf("| %s | %g | %.3g | %.3g | %.2f | %.4g | %.0f | %.0f | %.4g | %.2f | %.2f |\n", name, 100.0 * set->target,
           100.0 * set->asked, 100.0 * set->noise, set->noise / set->asked, set->samples, set->least, set->most,
           samples, samples / set->samples, seconds / set->seconds);
  }
  fflush(stdout);
}

static void set_keys(neph_scene *scene, int count, char **keys) {
  for (int i = 0; i < count; i++) {
    char *equals = strchr(keys[i], '=');
    *equals = '\0';
    check(neph_scene_set(scene, keys[i], equals + 1));
  }
}

int main(int argc, char **argv) {
  bench b = {.seeds = 2};
  neph_context *context;
  int keys = 0;
  if (argc < 6) return 2;
  check(neph_context_create(NULL, &context));
  check(neph_scene_load(context, argv[2], &b.scene));
  check(neph_renderer_create(context, &b.renderer));
  while (3 + keys < argc && strchr(argv[3 + keys], '=')) keys++;
  set_keys(b.scene, keys, argv + 3);
  char **rest = argv + 3 + keys;
  const int rest_count = argc - 3 - keys;
  b.seeds = (unsigned)atoi(rest[0]);
  if (b.seeds < 2 || rest_count < 3) return 2;
  const double seconds = atof(rest[1]);
  double least = HUGE_VAL;
  neph_image *warm;
  check(neph_renderer_render(b.renderer, b.scene, NULL, &warm));
  neph_image_destroy(warm);
  for (int i = 2; i < rest_count; i++) least = fmin(least, render_set(&b, atof(rest[i]), 1)->asked);
  for (unsigned samples = 1; b.count < SETS_MAX; samples *= 2) {
    const picture_set *set = render_set(&b, NEPH_UNLIMITED, samples);
    compute_noises(&b);
    if (set->noise < 0.9 * least || 2.0 * set->seconds > seconds) break;
  }
  print_rows(&b, argv[1]);
  for (unsigned s = 0; s < b.count; s++) free(b.set[s].sum), free(b.set[s].squares);
  neph_renderer_destroy(b.renderer);
  neph_scene_destroy(b.scene);
  neph_context_destroy(context);
  return 0;
}

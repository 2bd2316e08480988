/* SPDX-License-Identifier: Apache-2.0 */
/* Speed of each noise at each instruction-set level, and of a bake: `bench_noise`. Rates are by CPU time, which other
 * programs on the machine do not lengthen much. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include <nephos/cloud.h>
#include <nephos/noise_texture.h>

#include "core/random.h"
#include "noise/noise.h"

enum { COUNT = 512 }; /* a leaf of voxels */

typedef struct bench_points {
  float x[COUNT], y[COUNT], z[COUNT], out[3][COUNT];
} bench_points;

static const np_noise_lattice lattice = {.seed = 1, .period = {65536, 65536, 65536}};
static const np_noise_octaves octaves = {.count = 4, .gain = 0.5f};

/* Compiled for the benchmark alone, without vectors. */
extern const np_noise_table np_noise_kernels_scalar;

typedef void (*bench_fn)(const np_noise_table *table, bench_points *p);

static np_noise_points view(const bench_points *p) { return (np_noise_points){COUNT, p->x, p->y, p->z}; }

static void run_value(const np_noise_table *table, bench_points *p) {
  const np_noise_points points = view(p);
  table->value(&lattice, &points, p->out[0]);
}

static void run_value_fbm(const np_noise_table *table, bench_points *p) {
  const np_noise_points points = view(p);
  table->value_fbm(&lattice, &octaves, &points, p->out[0]);
}

static void run_perlin(const np_noise_table *table, bench_points *p) {
  const np_noise_points points = view(p);
  table->perlin(&lattice, &points, p->out[0]);
}

static void run_perlin_fbm(const np_noise_table *table, bench_points *p) {
  const np_noise_points points = view(p);
  table->perlin_fbm(&lattice, &octaves, &points, p->out[0]);
}

static void run_worley(const np_noise_table *table, bench_points *p) {
  const np_noise_points points = view(p);
  table->worley(&lattice, &points, p->out[0]);
}

static void run_perlin_worley(const np_noise_table *table, bench_points *p) {
  const np_noise_points points = view(p);
  table->perlin_worley(&lattice, &octaves, &points, p->out[0]);
}

static void run_curl(const np_noise_table *table, bench_points *p) {
  const np_noise_points points = view(p);
  table->curl(&lattice, &points, p->out[0], p->out[1], p->out[2]);
}

static const struct {
  const char *name;
  bench_fn run;
} noises[] = {{"value", run_value},
              {"value, 4 octaves", run_value_fbm},
              {"perlin", run_perlin},
              {"perlin, 4 octaves", run_perlin_fbm},
              {"worley", run_worley},
              {"curl", run_curl},
              {"perlin-worley, 4 octaves", run_perlin_worley}};

static double read_seconds(clockid_t clock) {
  struct timespec t;
  clock_gettime(clock, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

enum { RUNS = 7 };

static int compare_rates(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* The median of several short runs: other programs on the machine slow some of them. */
static double measure_rate(bench_fn run, const np_noise_table *table, bench_points *points) {
  double rates[RUNS];
  for (int k = 0; k < RUNS; k++) {
    const double start = read_seconds(CLOCK_PROCESS_CPUTIME_ID);
    double elapsed = 0, evaluated = 0;
    for (; elapsed < 0.02; elapsed = read_seconds(CLOCK_PROCESS_CPUTIME_ID) - start, evaluated += COUNT * 16)
      for (int i = 0; i < 16; i++) run(table, points);
    rates[k] = evaluated / elapsed;
  }
  qsort(rates, RUNS, sizeof *rates, compare_rates);
  return rates[RUNS / 2];
}

static void bench_noises(void) {
  static bench_points points;
  np_random random = np_random_start(1, 0, 0, 0, 0);
  for (int i = 0; i < COUNT; i++) {
    points.x[i] = 100.0f * np_random_float(&random);
    points.y[i] = 100.0f * np_random_float(&random);
    points.z[i] = 100.0f * np_random_float(&random);
  }
  const neph_isa last = np_isa_detect();
  printf("%-26s%12s", "million samples/s", "scalar");
  for (neph_isa isa = NEPH_ISA_X86_64; isa <= last; isa++) printf("%12s", neph_isa_get_name(isa));
  printf("%12s", "ratio");
  for (size_t k = 0; k < sizeof noises / sizeof *noises; k++) {
    const double scalar = measure_rate(noises[k].run, &np_noise_kernels_scalar, &points);
    double rate = scalar;
    printf("\n%-26s%12.1f", noises[k].name, 1e-6 * scalar);
    for (neph_isa isa = NEPH_ISA_X86_64; isa <= last; isa++) {
      rate = measure_rate(noises[k].run, np_noise_get_table(isa), &points);
      printf("%12.1f", 1e-6 * rate);
    }
    printf("%12.1f", rate / scalar);
  }
  printf("\n");
}

/* Look-ups in a texture; their error against the noise is the test's to hold. */
static neph_result bench_texture(neph_noise_texture_kind kind, const char *name) {
  neph_context *context = NULL;
  neph_noise_texture *texture = NULL;
  neph_result result = neph_context_create(NULL, &context);
  if (!result) result = neph_noise_texture_create(context, kind, 1, &texture);
  if (!result) {
    np_random random = np_random_start(1, 0, 0, 0, 0);
    float x[COUNT], y[COUNT], z[COUNT];
    volatile float sum = 0;
    for (int i = 0; i < COUNT; i++) {
      x[i] = np_random_float(&random);
      y[i] = np_random_float(&random);
      z[i] = np_random_float(&random);
    }
    const double start = read_seconds(CLOCK_PROCESS_CPUTIME_ID);
    double elapsed = 0, looked_up = 0;
    for (; elapsed < 0.1; elapsed = read_seconds(CLOCK_PROCESS_CPUTIME_ID) - start, looked_up += COUNT)
      for (int i = 0; i < COUNT; i++) sum = sum + neph_noise_texture_sample(texture, x[i], y[i], z[i]);
    printf("%s texture, look-ups: %.1f million/s\n", name, 1e-6 * looked_up / elapsed);
  }
  neph_noise_texture_destroy(texture);
  neph_context_destroy(context);
  return result;
}

static neph_result bench_bake(neph_isa isa, double voxel_m) {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  neph_context *context = NULL;
  neph_volume *volume = NULL;
  neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
  desc.isa_max = isa;
  neph_result result = neph_context_create(&desc, &context);
  if (!result) result = neph_cloud_get_preset(context, "cumulus_mediocris", &cloud);
  const double start = read_seconds(CLOCK_MONOTONIC), cpu_start = read_seconds(CLOCK_PROCESS_CPUTIME_ID);
  if (!result) {
    cloud.voxel_m = voxel_m;
    result = neph_cloud_bake(context, &cloud, NULL, &volume);
  }
  if (!result) {
    const double elapsed = read_seconds(CLOCK_MONOTONIC) - start,
                 cpu = read_seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu_start;
    neph_volume_info info = NEPH_VOLUME_INFO_DEFAULT;
    result = neph_volume_get_info(volume, &info);
    printf("bake, %s, %u threads, %g m: %.2f s, %.2f CPU s, %.1f million active voxels, %.1f million a CPU second\n",
           neph_isa_get_name(isa), neph_context_get_thread_count(context), voxel_m, elapsed, cpu,
           1e-6 * (double)info.active_voxel_count, 1e-6 * (double)info.active_voxel_count / cpu);
  }
  neph_volume_release(volume);
  neph_context_destroy(context);
  return result;
}

int main(void) {
  bench_noises();
  neph_result result = bench_texture(NEPH_NOISE_TEXTURE_BASE, "base");
  if (!result) result = bench_texture(NEPH_NOISE_TEXTURE_DETAIL, "detail");
  for (neph_isa isa = NEPH_ISA_X86_64; isa <= np_isa_detect() && !result; isa++) result = bench_bake(isa, 20);
  if (!result) result = bench_bake(np_isa_detect(), 10);
  return result ? EXIT_FAILURE : EXIT_SUCCESS;
}

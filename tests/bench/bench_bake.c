/* SPDX-License-Identifier: Apache-2.0 */
/* Speed of a bake against that of the noise in it: `bench_bake [VOXEL_M]`, on one thread, by its CPU time.
 *
 * The bake runs twice: as it is, and with a table of noises that counts samples and takes the time, and one of the
 * distances to balls. What these kernels alone allow is the bake's voxels in their time; the bake reaches the printed
 * part of that, and must reach half. With noise built without vectors the same is done once more: that is what vectors
 * are compared with. Last comes the time of a voxel of each preset.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "core/alloc.h"
#include "cloud/bake_field.h"
#include "cloud/bake_grid.h"
#include "cloud/presets.h"

/* Compiled for the benchmark alone, without vectors. */
extern const np_noise_table np_noise_kernels_scalar;

enum { RUNS = 3 };

/* Limits at the highest level: noise against noise without vectors, and the bake, beside the preparing,
 * against its noise. */
static const double noise_ratio_min = 6, bake_ratio_min = 0.5;

static double read_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- Noise that is watched ---- */

static struct {
  const np_noise_table *table;
  double samples, seconds; /* a sample is a point at one octave */
  double start_s;
  double ball_seconds; /* in the kernels of balls */
} watch;

static void begin(void) { watch.start_s = read_seconds(); }

static void end(const np_noise_points *points, unsigned octaves) {
  watch.seconds += read_seconds() - watch.start_s;
  watch.samples += (double)points->count * octaves;
}

static void value(const np_noise_lattice *lattice, const np_noise_points *points, float *out) {
  begin();
  watch.table->value(lattice, points, out);
  end(points, 1);
}

static void perlin(const np_noise_lattice *lattice, const np_noise_points *points, float *out) {
  begin();
  watch.table->perlin(lattice, points, out);
  end(points, 1);
}

static void worley(const np_noise_lattice *lattice, const np_noise_points *points, float *out) {
  begin();
  watch.table->worley(lattice, points, out);
  end(points, 1);
}

static void value_fbm(const np_noise_lattice *lattice, const np_noise_octaves *octaves, const np_noise_points *points,
                      float *out) {
  begin();
  watch.table->value_fbm(lattice, octaves, points, out);
  end(points, octaves->count);
}

static void perlin_fbm(const np_noise_lattice *lattice, const np_noise_octaves *octaves, const np_noise_points *points,
                       float *out) {
  begin();
  watch.table->perlin_fbm(lattice, octaves, points, out);
  end(points, octaves->count);
}

static void worley_fbm(const np_noise_lattice *lattice, const np_noise_octaves *octaves, const np_noise_points *points,
                       float *out) {
  begin();
  watch.table->worley_fbm(lattice, octaves, points, out);
  end(points, octaves->count);
}

static void perlin_worley(const np_noise_lattice *lattice, const np_noise_octaves *octaves,
                          const np_noise_points *points, float *out) {
  begin();
  watch.table->perlin_worley(lattice, octaves, points, out);
  end(points, 2 * octaves->count);
}

static void curl(const np_noise_lattice *lattice, const np_noise_points *points, float *out_x, float *out_y,
                 float *out_z) {
  begin();
  watch.table->curl(lattice, points, out_x, out_y, out_z);
  end(points, 2);
}

static const np_noise_table watched = {.value = value,
                                       .value_fbm = value_fbm,
                                       .perlin = perlin,
                                       .perlin_fbm = perlin_fbm,
                                       .worley = worley,
                                       .worley_fbm = worley_fbm,
                                       .perlin_worley = perlin_worley,
                                       .curl = curl};

/* ---- Balls that are watched ---- */

static const np_ball_table *watched_balls;

/* Not timed: calls are too short. */
static size_t choose_near(const np_ball_columns *balls, size_t first, size_t count, const np_ball_box *box,
                          float reach_m, uint32_t *out) {
  return watched_balls->choose_near(balls, first, count, box, reach_m, out);
}

static void take_chunk(const np_ball_chunk *chunk, float blend_m, const np_ball_points *points, np_ball_slice *slice,
                       np_ball_nearest *nearest) {
  const double start_s = read_seconds();
  watched_balls->take_chunk(chunk, blend_m, points, slice, nearest);
  watch.ball_seconds += read_seconds() - start_s;
}

static void join_level(size_t count, float blend_m, np_ball_nearest *nearest, float *distance_m) {
  const double start_s = read_seconds();
  watched_balls->join_level(count, blend_m, nearest, distance_m);
  watch.ball_seconds += read_seconds() - start_s;
}

static const np_ball_table watching_balls = {choose_near, take_chunk, join_level};

/* ---- Bakes ---- */

typedef struct measurement {
  double voxels, grid_bytes;
  double samples, noise_s, ball_s, bake_s, prepare_s;
} measurement;

static neph_result bake_once(neph_context *context, const neph_cloud_desc *cloud, const np_noise_table *noise,
                             bool is_watched, measurement *m) {
  const neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  np_bake bake;
  np_monitor monitor;
  np_sparse_grid grid;
  double start = read_seconds();
  neph_result result = np_bake_start_checked(context, cloud, &desc, NP_BAKE_FOR_GRID, &monitor, &bake);
  if (result) return result;
  m->prepare_s = read_seconds() - start;
  bake.model.noise = is_watched ? &watched : noise;
  watched_balls = bake.model.balls.kernels;
  if (is_watched) bake.model.balls.kernels = &watching_balls;
  watch.table = noise;
  watch.samples = watch.seconds = watch.ball_seconds = 0;
  start = read_seconds();
  result = np_bake_make_grid(&bake, "density", &grid);
  if (is_watched) m->noise_s = watch.seconds, m->ball_s = watch.ball_seconds, m->samples = watch.samples;
  if (!is_watched) m->bake_s = read_seconds() - start;
  if (!result) {
    m->voxels = (double)np_sparse_grid_count_active(&grid);
    m->grid_bytes = (double)grid.leaf_count * sizeof(np_leaf);
    np_sparse_grid_clear(&grid);
  }
  np_bake_end(&bake);
  return result;
}

static int compare_ratios(const void *a, const void *b) {
  const measurement *x = a, *y = b;
  const double p = (x->noise_s + x->ball_s) / x->bake_s, q = (y->noise_s + y->ball_s) / y->bake_s;
  return (p > q) - (p < q);
}

/* The run of the median ratio: other programs on the machine disturb some. */
static neph_result measure(neph_isa isa, const np_noise_table *noise, const neph_cloud_desc *cloud,
                           measurement *out_measurement) {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  neph_context *context = NULL;
  measurement runs[RUNS];
  desc.thread_count = 1;
  desc.isa_max = isa;
  neph_result result = neph_context_create(&desc, &context);
  for (int i = 0; i < RUNS && !result; i++) {
    result = bake_once(context, cloud, noise, false, &runs[i]);
    if (!result) result = bake_once(context, cloud, noise, true, &runs[i]);
  }
  if (!result) {
    qsort(runs, RUNS, sizeof *runs, compare_ratios);
    *out_measurement = runs[RUNS / 2];
  }
  neph_context_destroy(context);
  return result;
}

/* Whether both ratios are reached. */
static bool print_row(const char *name, const measurement *m, double scalar_rate) {
  const double rate = m->samples / m->noise_s, bake_ratio = (m->noise_s + m->ball_s) / m->bake_s;
  printf("%-12s%14.1f%10.1f%14.2f%14.2f%12.2f%12.2f\n", name, 1e-6 * rate, rate / scalar_rate,
         1e-6 * m->voxels / (m->noise_s + m->ball_s), 1e-6 * m->voxels / m->bake_s, bake_ratio, m->prepare_s);
  return rate >= noise_ratio_min * scalar_rate && bake_ratio >= bake_ratio_min;
}

static neph_result bench_preset(const char *preset, double voxel_m, bool *out_is_reached) {
  neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
  neph_context *context = NULL;
  measurement m = {0};
  neph_result result = neph_context_create(NULL, &context);
  if (!result) result = neph_cloud_get_preset(context, preset, &cloud);
  neph_context_destroy(context);
  if (result) return result;
  cloud.voxel_m = voxel_m;
  cloud.extent_m[0] = cloud.extent_m[1] = 4000;
  printf("%s, voxels of %g m\n%-12s%14s%10s%14s%14s%12s%12s\n", preset, voxel_m, "noise", "M samples/s", "ratio",
         "allows Mvox/s", "bake Mvox/s", "ratio", "prepare s");
  result = measure(NEPH_ISA_X86_64, &np_noise_kernels_scalar, &cloud, &m);
  if (result) return result;
  const double scalar_rate = m.samples / m.noise_s;
  (void)print_row("scalar", &m, scalar_rate);
  for (neph_isa isa = NEPH_ISA_X86_64; isa <= np_isa_detect() && !result; isa++) {
    result = measure(isa, np_noise_get_table(isa), &cloud, &m);
    if (!result) *out_is_reached = print_row(neph_isa_get_name(isa), &m, scalar_rate);
  }
  if (!result)
    printf("%.3g million voxels, %.2f bytes for each in leaves, %.1f samples of noise for each\n\n", 1e-6 * m.voxels,
           m.grid_bytes / m.voxels, m.samples / m.voxels);
  return result;
}

/* A preset as it is but for its extent, which is that of at most so many voxels. */
static neph_result bench_kind(neph_context *context, const char *preset) {
  enum { SIDE_VOXELS = 300 };
  neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
  measurement m = {0};
  neph_result result = neph_cloud_get_preset(context, preset, &cloud);
  if (result) return result;
  for (int a = 0; a < 2; a++) cloud.extent_m[a] = fmin(cloud.extent_m[a], SIDE_VOXELS * cloud.voxel_m);
  result = bake_once(context, &cloud, np_noise_get_table(np_isa_detect()), false, &m);
  if (!result)
    printf("%-26s%10g%12.3f%14.0f%12.2f\n", preset, cloud.voxel_m, 1e-6 * m.voxels, 1e9 * m.bake_s / m.voxels,
           m.prepare_s);
  return result;
}

static neph_result bench_kinds(void) {
  char *names = NULL;
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  neph_context *context = NULL;
  desc.thread_count = 1;
  neph_result result = neph_context_create(&desc, &context);
  np_text list = {.context = context};
  np_cloud_list_presets(&list);
  if (!result) result = np_text_finish(&list, &names);
  printf("%-26s%10s%12s%14s%12s\n", "preset", "voxel m", "M voxels", "ns/voxel", "prepare s");
  for (char *name = result ? NULL : strtok(names, ", "); name && !result; name = strtok(NULL, ", "))
    result = bench_kind(context, name);
  np_alloc_free(context, names);
  neph_context_destroy(context);
  return result;
}

int main(int argc, char **argv) {
  const double voxel_m = argc > 1 ? strtod(argv[1], NULL) : 20;
  static const char *const presets[] = {"cumulus_mediocris", "stratus"};
  neph_result result = NEPH_OK;
  bool are_reached = true;
  for (size_t i = 0; i < sizeof presets / sizeof *presets && !result; i++) {
    bool is_reached = false;
    result = bench_preset(presets[i], voxel_m, &is_reached);
    are_reached = are_reached && is_reached;
  }
  if (!result) result = bench_kinds();
  if (!are_reached) printf("MISSED: noise must reach %g, the bake %g\n", noise_ratio_min, bake_ratio_min);
  return result || !are_reached ? EXIT_FAILURE : EXIT_SUCCESS;
}

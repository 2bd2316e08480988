/* SPDX-License-Identifier: Apache-2.0 */
/* Nanoseconds for a look-up along rays: bricks of halves and floats at every instruction-set level, and for walks,
 * beside OpenVDB's BoxSampler. Usage: bench_bricks CLOUD.vdb. Not a test: it prints, and the reader judges.
 */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "bench_bricks_kernels.h"
#include "core/random.h"
#include "volume/volume_file.h"

enum { RAYS = 4000, STEPS = 256, REPEATS = 7 };

/* Seconds of this thread's processor time, so that a busy machine disturbs less. */
static double read_seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Rays through the table, in index space, from one random point of it to another. */
static void make_rays(const np_bricks *bricks, bench_ray rays[RAYS]) {
  np_random random = np_random_start(1, 0, 0, 0, 0);
  for (int n = 0; n < RAYS; n++) {
    double ends[2][3];
    for (int end = 0; end < 2; end++)
      for (int a = 0; a < 3; a++)
        ends[end][a] = 8.0 * (bricks->origin[a] + bricks->size[a] * np_random_double(&random));
    rays[n].origin = np_dvec3_make(ends[0][0], ends[0][1], ends[0][2]);
    rays[n].direction = np_dvec3_subtract(np_dvec3_make(ends[1][0], ends[1][1], ends[1][2]), rays[n].origin);
  }
}

static double time_kernel(double (*kernel)(const np_bricks *, const bench_ray *, int, int, double *),
                          const np_bricks *bricks, const bench_ray *rays, double *out_sum) {
  double best = 1e30;
  for (int n = 0; n < REPEATS; n++) {
    double lookups, begin = read_seconds();
    *out_sum = kernel(bricks, rays, RAYS, STEPS, &lookups);
    best = fmin(best, (read_seconds() - begin) * 1e9 / lookups);
  }
  return best;
}

static void print_bricks(const char *what, const np_bricks *bricks, const bench_ray *rays) {
  static const struct {
    const char *name;
    bench_kernels kernels;
  } levels[] = {{"x86-64", {bench_sample_v1, bench_walk_v1, bench_lines_v1}},
                {"x86-64-v3", {bench_sample_v3, bench_walk_v3, bench_lines_v3}},
                {"x86-64-v4", {bench_sample_v4, bench_walk_v4, bench_lines_v4}}};
  neph_isa best = np_isa_detect();
  for (int level = 0; level <= (int)best; level++) {
    double sum, walk_sum, sample_ns = time_kernel(levels[level].kernels.sample, bricks, rays, &sum);
    double walk_ns = time_kernel(levels[level].kernels.walk, bricks, rays, &walk_sum);
    double lines_ns = time_kernel(levels[level].kernels.lines, bricks, rays, &walk_sum);
    printf("%-7s %-10s look-up anywhere %6.2f ns   inside walked bricks %6.2f ns   in lines %6.2f ns   (mean %.6f)\n",
           what, levels[level].name, sample_ns, walk_ns, lines_ns, sum / ((double)RAYS * STEPS));
  }
}

static void print_openvdb(neph_context *context, const np_sparse_grid *grid, const bench_ray *rays) {
  const np_vdb_module *module;
  np_vdb_error error;
  double *points = malloc(sizeof *points * 3 * RAYS * STEPS), seconds[2];
  float *values = malloc(sizeof *values * RAYS * STEPS);
  if (!points || !values || np_vdb_module_get(context, &module)) exit(1);
  for (int n = 0; n < RAYS * STEPS; n++) {
    const bench_ray *ray = &rays[n / STEPS];
    np_dvec3 at = np_dvec3_add(ray->origin, np_dvec3_scale(ray->direction, (n % STEPS + 0.5) / STEPS));
    points[3 * n] = at.x, points[3 * n + 1] = at.y, points[3 * n + 2] = at.z;
  }
  for (int n = 0; n < 2; n++) { /* the first builds the tree alone: its time is taken off */
    double begin = read_seconds();
    if (module->sample(grid, n ? RAYS * STEPS : 1, points, values, &error)) exit(1);
    seconds[n] = read_seconds() - begin;
  }
  printf("OpenVDB BoxSampler look-up anywhere %6.2f ns\n", (seconds[1] - seconds[0]) * 1e9 / (RAYS * STEPS));
  free(points);
  free(values);
}

static void print_message(void *user, neph_log_level level, const char *message) {
  (void)user, (void)level;
  fprintf(stderr, "%s\n", message);
}

int main(int count, char **arguments) {
  static bench_ray rays[RAYS];
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  neph_context *context;
  np_volume_file file;
  np_sparse_grid grid;
  np_bricks bricks;
  uint64_t tree_bytes;
  desc.log = print_message;
  if (count != 2) {
    fprintf(stderr, "usage: bench_bricks CLOUD.vdb\n");
    return 2;
  }
  if (neph_context_create(&desc, &context) || np_volume_file_open(context, arguments[1], NULL, NULL, &file)) return 1;
  if (np_volume_file_read(&file, 0, &grid, &tree_bytes)) return 1;
  for (int precision = NEPH_PRECISION_HALF; precision <= NEPH_PRECISION_FLOAT; precision++) {
    if (np_bricks_build(context, &grid, (neph_precision)precision, NULL, NULL, &bricks)) return 1;
    make_rays(&bricks, rays);
    print_bricks(precision == NEPH_PRECISION_HALF ? "half" : "float", &bricks, rays);
    np_bricks_clear(&bricks);
  }
  print_openvdb(context, &grid, rays);
  np_sparse_grid_clear(&grid);
  np_volume_file_close(&file);
  neph_context_destroy(context);
  return 0;
}

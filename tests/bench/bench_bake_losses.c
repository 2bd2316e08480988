/* SPDX-License-Identifier: Apache-2.0 */
/* Cost of a bake's comparison with finer voxels: `bench_bake_losses [PRESET…]`, on one thread, by its CPU time.
 *
 * Each preset is baked in its own voxels and in ones three times as large, at most 300 of its own to a side. The share
 * is the comparison's time against the bake's, which holds it. Where the comparison warns, the search for the voxel
 * that keeps what is lost comes on top, and has a column of its own.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "cloud/bake_field.h"
#include "cloud/bake_grid.h"
#include "cloud/bake_loss.h"
#include "cloud/presets.h"
#include "core/alloc.h"

enum { SIDE_VOXELS = 300, RUNS = 3 };

static double read_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

typedef struct measurement {
  double prepare_s, compare_s, warn_s, grid_s;
  bool warns;
} measurement;

static neph_result time_parts(neph_context *context, np_bake *bake, measurement *m) {
  np_bake_losses losses;
  np_sparse_grid grid;
  double start_s = read_seconds();
  neph_result result = np_bake_measure_losses(context, &bake->model, bake->monitor, &losses);
  m->compare_s = fmin(m->compare_s, read_seconds() - start_s);
  m->warns = np_bake_loses(&losses);
  start_s = read_seconds();
  if (!result) result = np_bake_warn_of_losses(context, &bake->model, bake->monitor);
  m->warn_s = fmin(m->warn_s, read_seconds() - start_s);
  start_s = read_seconds();
  if (!result) result = np_bake_make_grid(bake, "density", &grid);
  m->grid_s = fmin(m->grid_s, read_seconds() - start_s);
  if (!result) np_sparse_grid_clear(&grid);
  return result;
}

static neph_result measure(neph_context *context, const neph_cloud_desc *cloud, measurement *m) {
  const neph_bake_desc desc = NEPH_BAKE_DESC_DEFAULT;
  neph_result result = NEPH_OK;
  *m = (measurement){INFINITY, INFINITY, INFINITY, INFINITY, false};
  for (int i = 0; i < RUNS && !result; i++) {
    np_bake bake;
    np_monitor monitor;
    const double start_s = read_seconds();
    result = np_bake_start_checked(context, cloud, &desc, NP_BAKE_FOR_GRID, &monitor, &bake);
    if (result) return result;
    m->prepare_s = fmin(m->prepare_s, read_seconds() - start_s);
    result = time_parts(context, &bake, m);
    np_bake_end(&bake);
  }
  return result;
}

static neph_result bench_voxel(neph_context *context, const char *preset, double scale) {
  neph_cloud_desc cloud = NEPH_CLOUD_DESC_DEFAULT;
  measurement m;
  neph_result result = neph_cloud_get_preset(context, preset, &cloud);
  if (result) return result;
  for (int a = 0; a < 2; a++) cloud.extent_m[a] = fmin(cloud.extent_m[a], SIDE_VOXELS * cloud.voxel_m);
  cloud.voxel_m *= scale;
  result = measure(context, &cloud, &m);
  if (result) return result;
  const double bake_s = m.prepare_s + m.grid_s - m.warn_s + m.compare_s;
  printf("%-26s%10g%10.3f%12.4f%10.1f%%", preset, cloud.voxel_m, bake_s, m.compare_s, 100 * m.compare_s / bake_s);
  if (m.warns) printf("%12.3f", m.warn_s - m.compare_s);
  printf("\n");
  fflush(stdout);
  return NEPH_OK;
}

/* Names of presets, parted by ", ", to be freed. */
static neph_result list_presets(neph_context *context, char **out_names) {
  np_text list = {.context = context};
  np_cloud_list_presets(&list);
  return np_text_finish(&list, out_names);
}

static neph_result bench_presets(neph_context *context) {
  char *names = NULL;
  neph_result result = list_presets(context, &names);
  for (char *name = result ? NULL : strtok(names, ", "); name && !result; name = strtok(NULL, ", ")) {
    result = bench_voxel(context, name, 1);
    if (!result) result = bench_voxel(context, name, 3);
  }
  np_alloc_free(context, names);
  return result;
}

int main(int argc, char **argv) {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  neph_context *context = NULL;
  desc.thread_count = 1;
  neph_result result = neph_context_create(&desc, &context);
  printf("%-26s%10s%10s%12s%11s%12s\n", "preset", "voxel m", "bake s", "compare s", "share", "search s");
  for (int i = 1; i < argc && !result; i++) {
    result = bench_voxel(context, argv[i], 1);
    if (!result) result = bench_voxel(context, argv[i], 3);
  }
  if (!result && argc == 1) result = bench_presets(context);
  neph_context_destroy(context);
  return result ? EXIT_FAILURE : EXIT_SUCCESS;
}

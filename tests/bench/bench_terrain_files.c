/* SPDX-License-Identifier: Apache-2.0 */
/* Loads height fields with one thread: bench_terrain_files FILE… prints, for each, CPU seconds and peak memory of
 * GDAL's own reading of all samples, of the height field, and of the terrain with Embree's tree. Each is a process of
 * its own, from whose memory that of one which loads nothing is taken off. */
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "terrain/gdal_module.h"
#include "terrain/heightfield.h"

typedef neph_result (*step)(neph_context *context, const char *path);

static neph_result do_nothing(neph_context *context, const char *path) {
  (void)context, (void)path;
  return NEPH_OK;
}

static neph_result load_module(neph_context *context, const char *path) {
  (void)path;
  const np_gdal_module *module;
  return np_gdal_module_get(context, &module);
}

/* Rows of tiles at a time, as GDAL's own tools read. */
static neph_result read_samples(neph_context *context, const char *path) {
  enum { ROWS = 256 };
  const np_gdal_source source = {.paths = &path, .path_count = 1};
  const np_gdal_module *module;
  np_gdal_raster *raster;
  np_gdal_info info;
  np_gdal_error error;
  neph_result result = np_gdal_module_get(context, &module);
  if (!result) result = module->open(&source, &raster, &error);
  if (result) return result;
  module->describe(raster, &info);
  float *values = malloc((size_t)info.width * info.height * sizeof *values);
  for (unsigned row = 0; row < info.height && !result; row += ROWS) {
    const unsigned count = info.height - row < ROWS ? info.height - row : ROWS;
    const np_gdal_window window = {0, row, info.width, count, info.width, count};
    result = module->read(raster, 1, &window, values + (size_t)row * info.width, &error);
  }
  free(values);
  module->close(raster);
  return result;
}

static neph_result load_field(neph_context *context, const char *path) {
  const neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  np_heightfield field;
  neph_result result = np_heightfield_load(context, NULL, path, &desc, &field);
  if (!result) np_heightfield_destroy(context, &field);
  return result;
}

static neph_result load_terrain(neph_context *context, const char *path) {
  neph_terrain *terrain;
  neph_result result = neph_terrain_load(context, path, NULL, &terrain);
  if (!result) neph_terrain_release(terrain);
  return result;
}

typedef struct cost {
  double cpu_s, peak_mb;
} cost;

static neph_result run_step(step run, const char *path) {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  neph_context *context;
  desc.thread_count = 1;
  neph_result result = neph_context_create(&desc, &context);
  if (result) return result;
  result = run(context, path);
  neph_context_destroy(context);
  return result;
}

static cost measure(step run, const char *path) {
  int status;
  struct rusage use;
  const pid_t child = fork();
  if (child == 0) _exit(run_step(run, path) ? 1 : 0);
  if (child < 0 || wait4(child, &status, 0, &use) < 0 || status != 0) {
    fprintf(stderr, "bench_terrain_files: %s cannot be loaded\n", path);
    exit(1);
  }
  return (cost){(double)(use.ru_utime.tv_sec + use.ru_stime.tv_sec) +
                    1e-6 * (double)(use.ru_utime.tv_usec + use.ru_stime.tv_usec),
                (double)use.ru_maxrss * 1024e-6};
}

int main(int count, char **words) {
  static const step steps[] = {read_samples, load_field, load_terrain};
  printf("| file | GDAL's reading | height field | terrain |\n| --- | --- | --- | --- |\n");
  for (int i = 1; i < count; i++) {
    printf("| %s |", words[i]);
    for (size_t k = 0; k < sizeof steps / sizeof *steps; k++) {
      const bool has_module = k == 0 || np_heightfield_is_raster(words[i]);
      const cost c = measure(steps[k], words[i]), idle = measure(has_module ? load_module : do_nothing, words[i]);
      printf(" %.2f s, %.0f MB |", c.cpu_s - idle.cpu_s, c.peak_mb - idle.peak_mb);
      fflush(stdout);
    }
    printf("\n");
  }
  return 0;
}

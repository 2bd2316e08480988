/* SPDX-License-Identifier: Apache-2.0 */
/* Loads clouds: bench_files [-t THREADS] FILE… prints, for each file that can be loaded, seconds and peak memory of
 * OpenVDB's own reading of its first density, unchecked (of a .vdb alone), and of loading it as bricks: CPU seconds on
 * one thread, or, with -t, seconds of the wall on THREADS. Each is a process of its own, from whose memory and time
 * those of one which only opens the file are taken off. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "core/alloc.h"
#include "volume/vdb_file.h"
#include "volume/volume_choice.h"
#include "volume/volume_format.h"

typedef neph_result (*step)(neph_context *context, const char *path);

/* The first density, or -1. */
static int search_density(const np_volume_file *file) {
  for (size_t i = 0; i < np_volume_file_count(file); i++) {
    const np_vdb_grid_info info = np_volume_file_describe(file, i);
    if (np_volume_get_role(file, &info) == NP_GRID_DENSITY) return (int)i;
  }
  return -1;
}

static neph_result open_file(neph_context *context, const char *path) {
  np_volume_file file;
  const neph_result result = np_volume_file_open(context, path, NULL, NULL, &file);
  if (!result) np_volume_file_close(&file);
  return result;
}

/* ---- OpenVDB alone ---- */

static neph_result read_file(neph_context *context, const char *path) {
  np_volume_file file;
  neph_result result = np_volume_file_open(context, path, NULL, NULL, &file);
  if (result) return result;
  const int index = search_density(&file);
  const np_vdb_reader *reader = file.reader;
  np_vdb_error error;
  result = index < 0 || file.format != &np_vdb_format ? NEPH_ERROR_BAD_FILE
                                                      : reader->module->read_alone(reader->vdb, (size_t)index, &error);
  np_volume_file_close(&file);
  return result;
}

/* ---- Bricks ---- */

/* "density", or, where several grids are called so, "density[0]". */
static char *get_name(const np_volume_file *file, size_t index) {
  const np_vdb_grid_info info = np_volume_file_describe(file, index);
  size_t count = 0;
  for (size_t i = 0; i < np_volume_file_count(file); i++)
    count += !strcmp(info.name, np_volume_file_describe(file, i).name);
  return np_alloc_printf(file->context, count > 1 ? "%s[0]" : "%s", info.name);
}

static neph_result load_file(neph_context *context, const char *path) {
  np_volume_file file;
  neph_volume *volume = NULL;
  neph_volume_load_desc desc = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  neph_result result = np_volume_file_open(context, path, NULL, NULL, &file);
  if (result) return result;
  const int index = search_density(&file);
  char *name = index < 0 ? NULL : get_name(&file, (size_t)index);
  np_volume_file_close(&file);
  if (!name) return NEPH_ERROR_BAD_FILE;
  desc.grid = name;
  desc.policy = NEPH_IMPORT_REPAIR;
  result = np_volume_load_density(context, path, &desc, NULL, &volume);
  neph_volume_release(volume);
  np_alloc_free(context, name);
  return result;
}

/* ---- Processes ---- */

typedef struct cost {
  double seconds, megabytes;
  int failed;
} cost;

static void be_silent(void *user, neph_log_level level, const char *message) { (void)user, (void)level, (void)message; }

static unsigned thread_count = 1;
static bool is_by_wall = false;

static int run(step work, const char *path) {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  neph_context *context;
  desc.thread_count = thread_count;
  desc.log = be_silent;
  return neph_context_create(&desc, &context) || work(context, path);
}

static double read_clock_s(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double get_cpu_s(const struct rusage *usage) {
  return (double)(usage->ru_utime.tv_sec + usage->ru_stime.tv_sec) +
         1e-6 * (double)(usage->ru_utime.tv_usec + usage->ru_stime.tv_usec);
}

static cost measure(step work, const char *path) {
  int status = 0;
  struct rusage usage = {0};
  const double begin_s = read_clock_s();
  const pid_t child = fork();
  if (child == 0) _exit(run(work, path) != 0);
  if (child < 0 || wait4(child, &status, 0, &usage) < 0) exit(1);
  return (cost){is_by_wall ? read_clock_s() - begin_s : get_cpu_s(&usage), (double)usage.ru_maxrss * 1.024e-3, status};
}

/* The least of some runs: what else the machine does only adds. */
static cost measure_best(step work, const char *path) {
  enum { RUNS = 5 };
  cost best = measure(work, path);
  for (int i = 1; i < RUNS && !best.failed; i++) {
    const cost next = measure(work, path);
    if (next.seconds < best.seconds) best.seconds = next.seconds;
    if (next.megabytes < best.megabytes) best.megabytes = next.megabytes;
  }
  return best;
}

static void print_file(const char *path) {
  const char *slash = strrchr(path, '/');
  const cost opened = measure_best(open_file, path), read = measure_best(read_file, path),
             loaded = measure_best(load_file, path);
  if (loaded.failed) return;
  const double read_s = read.failed ? (double)NAN : fmax(0.0, read.seconds - opened.seconds),
               read_mb = read.failed ? (double)NAN : fmax(0.0, read.megabytes - opened.megabytes);
  printf("| %s | %.3f s | %.3f s | %.1f MB | %.1f MB |\n", slash ? slash + 1 : path, read_s,
         fmax(0.0, loaded.seconds - opened.seconds), read_mb, fmax(0.0, loaded.megabytes - opened.megabytes));
}

int main(int count, char **files) {
  is_by_wall = count > 2 && !strcmp(files[1], "-t");
  if (is_by_wall) thread_count = (unsigned)strtoul(files[2], NULL, 10);
  printf("| file | OpenVDB | bricks | OpenVDB's memory | bricks' memory |\n| --- | --- | --- | --- | --- |\n");
  for (int i = is_by_wall ? 3 : 1; i < count; i++) {
    print_file(files[i]);
    fflush(stdout);
  }
  return 0;
}

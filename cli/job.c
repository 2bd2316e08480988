/* SPDX-License-Identifier: Apache-2.0 */
#include "job.h"

#include <string.h>

/* ---- Frames ---- */

size_t farm_job_count_chunks(const farm_job *job) { return (job->frame_count + job->chunk_size - 1) / job->chunk_size; }

/* Frames from `begin` on that follow each other by one step. */
static size_t count_run(const int *frames, size_t begin, size_t end) {
  size_t count = end - begin < 2 ? end - begin : 2;
  while (begin + count < end && frames[begin + count] - frames[begin + count - 1] == frames[begin + 1] - frames[begin])
    count++;
  return count;
}

void farm_job_print_frames(const farm_job *job, size_t begin, size_t end, char step) {
  const int *frames = job->frames;
  for (size_t i = begin; i < end;) {
    size_t run = count_run(frames, i, end);
    const int apart = run > 1 ? frames[i + 1] - frames[i] : 1;
    if (run == 2 && apart > 1) run = 1; /* "1,5", not "1-5x4" */
    printf(i > begin ? ",%d" : "%d", frames[i]);
    if (run > 1) printf("-%d", frames[i + run - 1]);
    if (run > 1 && apart > 1) printf("%c%d", step, apart);
    i += run;
  }
}

void farm_job_print_chunk(const farm_job *job, size_t chunk) {
  const size_t begin = chunk * job->chunk_size, end = begin + job->chunk_size;
  farm_job_print_frames(job, begin, end < job->frame_count ? end : job->frame_count, 'x');
}

/* ---- Commands ---- */

static void print_option(const char *name, const char *value, farm_print_fn *print) {
  print(name);
  print(value);
}

void farm_job_print_render(const farm_job *job, const char *frames, const char *tile, const char *style,
                           farm_print_fn *print) {
  print("render");
  print(job->scene);
  print_option("--frames", frames, print);
  if (job->tile_count > 1) print_option("--tile", tile, print);
  for (size_t i = 0; i < job->argument_count; i++) print(job->arguments[i]);
  print_option("--checkpoint", job->checkpoint, print);
  print("--resume");
  print("--skip-existing");
  print_option("--progress", style, print);
}

void farm_job_print_threads(const farm_job *job, farm_print_fn *print) {
  char count[16];
  if (!job->thread_count) return;
  snprintf(count, sizeof count, "%u", job->thread_count);
  print_option("--threads", count, print);
}

void farm_job_print_merge(const farm_job *job, const char *frames, farm_print_fn *print) {
  char tiles[16];
  snprintf(tiles, sizeof tiles, "%u", job->tile_count);
  print("merge");
  print(job->scene);
  print_option("--frames", frames, print);
  print_option("--tiles", tiles, print);
  for (size_t i = 0; i < job->setting_count; i++) print_option("--set", job->settings[i], print);
}

void farm_print_shell_argument(const char *argument) {
  static const char safe[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./,:@%{}#";
  if (*argument && *argument != '{' && *argument != '#' && argument[strspn(argument, safe)] == '\0') {
    printf(" %s", argument);
    return;
  }
  printf(" '");
  for (const char *c = argument; *c; c++)
    if (*c == '\'')
      printf("'\\''");
    else
      putchar(*c);
  putchar('\'');
}

void farm_job_print_origin(const farm_job *job, const char *mark, const farm *of) {
  printf("%s nephos job %s", mark, of->name);
  farm_print_shell_argument(job->scene);
  printf(" --frames ");
  farm_job_print_frames(job, 0, job->frame_count, 'x');
  printf(" --tiles %u --chunk %u", job->tile_count, job->chunk_size);
  if (job->thread_count) printf(" --threads %u", job->thread_count);
  printf(" --checkpoint %s", job->checkpoint);
  if (job->argument_count) printf(" --");
  for (size_t i = 0; i < job->argument_count; i++) farm_print_shell_argument(job->arguments[i]);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Jobs for farms: tasks of frames and tiles, then merging. Each farm is a row in a file of its own, job_<farm>.c. */
#ifndef NEPHOS_CLI_JOB_H
#define NEPHOS_CLI_JOB_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#define CLI_FARMS(ROW) ROW(slurm) ROW(openjd) ROW(opencue) ROW(parallel)

/* A job. Its tasks are the chunks of frames times the tiles; chunks of frames are merged where there are tiles. */
typedef struct farm_job {
  const char *scene;
  char name[64]; /* the scene's, without folder and ending; letters, digits, - and _ */
  int *frames;   /* in order, each once */
  size_t frame_count;
  unsigned chunk_size, tile_count;
  unsigned thread_count;  /* of a task; 0: what the farm gives */
  const char *checkpoint; /* time, as 60s */
  const char **arguments; /* for nephos render, besides those above */
  size_t argument_count;
  const char **settings; /* of those, KEY=VALUE, which nephos merge takes too */
  size_t setting_count;
} farm_job;

typedef struct farm {
  const char *name;
  size_t chunk_max;     /* 0: any number of chunks */
  const char *reserved; /* begins what the farm replaces, and is in no argument of a user; NULL: nothing */
  void (*print)(const farm_job *job);
} farm;

#define CLI_DECLARE_FARM(name) extern const farm farm_##name;
CLI_FARMS(CLI_DECLARE_FARM)
#undef CLI_DECLARE_FARM

size_t farm_job_count_chunks(const farm_job *job);

/* Prints frames begin, …, end - 1 of the list as nephos, OpenCue and, with ':' for `step`, OpenJD read them:
 * "1-99x2,120". */
void farm_job_print_frames(const farm_job *job, size_t begin, size_t end, char step);

/* Prints the frames of a chunk. */
void farm_job_print_chunk(const farm_job *job, size_t chunk);

/* One argument of a command. */
typedef void farm_print_fn(const char *argument);

/* Calls `print` for each argument of a task behind "nephos", with `frames` and `tile`, which stand for those of the
 * task, and `style`, of progress; of its number of threads, where it has one; and of its merging. */
void farm_job_print_render(const farm_job *job, const char *frames, const char *tile, const char *style,
                           farm_print_fn *print);
void farm_job_print_threads(const farm_job *job, farm_print_fn *print);
void farm_job_print_merge(const farm_job *job, const char *frames, farm_print_fn *print);

/* Prints a blank, and an argument for a shell, quoted where it has to be. */
void farm_print_shell_argument(const char *argument);

/* Prints a comment: the command line that makes the job, behind `mark`. */
void farm_job_print_origin(const farm_job *job, const char *mark, const farm *of);

#endif

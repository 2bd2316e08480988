/* SPDX-License-Identifier: Apache-2.0 */
/* Jobs for farms: tasks of frames and tiles, then merging. Each farm is a row in a file of its own, job_<farm>.c. */
#ifndef NEPHOS_CLI_JOB_H
#define NEPHOS_CLI_JOB_H

#include "job_text.h"

#define CLI_FARMS(ROW) ROW(slurm) ROW(openjd) ROW(opencue) ROW(parallel)

/* Memory and time of a task, which some farms require before it starts. */
typedef struct farm_demand {
  double predicted_bytes, predicted_s; /* prediction of nephos render --explain, on the threads of a task */
  unsigned long long memory_mib, minutes;
} farm_demand;

/* A job. Its tasks are the chunks of frames times the tiles; chunks of frames are merged where there are tiles. */
typedef struct farm_job {
  FILE *out;
  const char *scene;  /* its name in the tasks */
  const char *given;  /* the same, as the command line names it */
  const char *folder; /* absolute; names that are relative start from it */
  char name[64];      /* the scene's, without folder and ending; letters, digits, - and _ */
  int *frames;        /* in order, each once */
  size_t frame_count;
  unsigned chunk_size, tile_count;
  unsigned thread_count;  /* of a task; 0: what the farm gives */
  const char *checkpoint; /* time, as 60s */
  const char **arguments; /* for nephos render, besides those above */
  size_t argument_count;
  const char **settings; /* of those, KEY=VALUE, which nephos merge takes too */
  size_t setting_count;
  farm_demand render, merge; /* demands of one task */
} farm_job;

typedef struct farm {
  const char *name;
  size_t chunk_max;  /* 0: any number of chunks */
  bool maps_scene;   /* the farm itself knows the scene's path on each machine; else it is absolute */
  bool has_demands;  /* tasks say how much memory and time they take */
  farm_text_rule text;
  void (*print)(const farm_job *job);
} farm;

#define CLI_DECLARE_FARM(name) extern const farm farm_##name;
CLI_FARMS(CLI_DECLARE_FARM)
#undef CLI_DECLARE_FARM

/* Names the job by its scene: "shots/dawn 2.yaml" is "dawn_2". */
void farm_job_set_name(farm_job *job);

size_t farm_job_count_chunks(const farm_job *job);

/* Frames of the longest chunk. */
size_t farm_job_get_chunk_length(const farm_job *job);

/* Prints frames begin, …, end - 1 of the list as nephos, OpenCue and, with ':' for `step`, OpenJD read them:
 * "1-99x2,120". */
void farm_job_print_frames(const farm_job *job, size_t begin, size_t end, char step);

/* Prints the frames of a chunk. */
void farm_job_print_chunk(const farm_job *job, size_t chunk);

/* One argument of a command. `is_template`: it is the farm's own, with a text that the farm replaces. */
typedef void farm_print_fn(const farm_job *job, const char *argument, bool is_template);

/* Calls `print` for each argument of a task behind "nephos", with `frames` and `tile`, which stand for those of the
 * task, and `style`, of progress; of its number of threads, where it has one; and of its merging. */
void farm_job_print_render(const farm_job *job, const char *frames, const char *tile, const char *style,
                           farm_print_fn *print);
void farm_job_print_threads(const farm_job *job, farm_print_fn *print);
void farm_job_print_merge(const farm_job *job, const char *frames, farm_print_fn *print);

/* Prints a comment: the command line that makes the job, behind `mark`. */
void farm_job_print_origin(const farm_job *job, const char *mark, const farm *of);

/* Whether the farm can hold all texts of the job; false after a message that names the character and its place. */
bool farm_job_check_texts(const farm_job *job, const farm *of);

#endif

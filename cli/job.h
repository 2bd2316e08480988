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

/* A job. It has one task for each chunk of frames and each tile; frames with tiles are merged chunk by chunk. */
typedef struct farm_job {
  FILE *out;
  const char *scene;  /* name of the scene in the tasks */
  const char *given;  /* name of the scene on the command line */
  const char *folder; /* absolute folder in which relative names start */
  char name[64];      /* name of the scene without folder and ending; letters, digits, - and _ */
  int *frames;        /* frame numbers in order, each once */
  size_t frame_count;
  unsigned chunk_size, tile_count;
  unsigned thread_count;  /* threads of a task; 0: all that the farm gives */
  const char *checkpoint; /* interval of checkpoints, such as 60s */
  const char **arguments; /* other arguments of nephos render */
  size_t argument_count;
  const char **settings; /* settings KEY=VALUE among the arguments, which nephos merge takes too */
  size_t setting_count;
  farm_demand render, merge; /* demands of one task */
} farm_job;

typedef struct farm {
  const char *name;
  size_t chunk_max;  /* greatest number of chunks; 0: no limit */
  bool maps_scene;   /* the farm maps the scene's path on each machine; otherwise the path is absolute */
  bool has_demands;  /* tasks state the memory and time that they take */
  farm_text_rule text;
  void (*print)(const farm_job *job);
} farm;

#define CLI_DECLARE_FARM(name) extern const farm farm_##name;
CLI_FARMS(CLI_DECLARE_FARM)
#undef CLI_DECLARE_FARM

/* Names the job after its scene: "shots/dawn 2.yaml" becomes "dawn_2". */
void farm_job_set_name(farm_job *job);

size_t farm_job_count_chunks(const farm_job *job);

/* Number of frames in the longest chunk. */
size_t farm_job_get_chunk_length(const farm_job *job);

/* Prints frames begin, …, end - 1 of the list as "1-99x2,120", the format of nephos, OpenCue and, with ':' for `step`,
 * OpenJD. */
void farm_job_print_frames(const farm_job *job, size_t begin, size_t end, char step);

/* Prints the frames of a chunk. */
void farm_job_print_chunk(const farm_job *job, size_t chunk);

/* Prints one argument of a command. `is_template`: the farm replaces a text in it. */
typedef void farm_print_fn(const farm_job *job, const char *argument, bool is_template);

/* Calls `print` for each argument of a task after "nephos". `frames` and `tile` are placeholders for the task's frames
 * and tile; `style` is the style of progress. Variants print its number of threads, where it has one, and the arguments
 * of its merging. */
void farm_job_print_render(const farm_job *job, const char *frames, const char *tile, const char *style,
                           farm_print_fn *print);
void farm_job_print_threads(const farm_job *job, farm_print_fn *print);
void farm_job_print_merge(const farm_job *job, const char *frames, farm_print_fn *print);

/* Prints a comment with the command line that generated the job, after `mark`. */
void farm_job_print_origin(const farm_job *job, const char *mark, const farm *of);

/* Whether the farm can hold all texts of the job; false after a message that names the character and its place. */
bool farm_job_check_texts(const farm_job *job, const farm *of);

#endif

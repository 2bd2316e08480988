/* SPDX-License-Identifier: Apache-2.0 */
/* The parsed command line. */
#ifndef NEPHOS_CLI_OPTIONS_H
#define NEPHOS_CLI_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <nephos/context.h>

typedef enum cli_exit {
  CLI_DONE = 0,
  CLI_INTERNAL = 1,
  CLI_USAGE = 2,
  CLI_BAD_SCENE = 3,
  CLI_NOT_FOUND = 4,
  CLI_IO = 5,
  CLI_LIMIT = 6,
  CLI_DIFFERENT = 7,
  CLI_SOME_FAILED = 8,
  CLI_STOPPED = 75,
  CLI_INTERRUPTED = 130
} cli_exit;

struct cli_verb;

/* Style of progress; progress_styles.c has a row for each. */
typedef enum cli_progress_mode {
  CLI_PROGRESS_AUTO, /* a bar on a terminal, lines elsewhere */
  CLI_PROGRESS_BAR,
  CLI_PROGRESS_LINES,
  CLI_PROGRESS_JSON,
  CLI_PROGRESS_ALF,
  CLI_PROGRESS_OPENJD,
  CLI_PROGRESS_NONE,
  CLI_PROGRESS_COUNT
} cli_progress_mode;

/* Frames first, first + step, … up to last. */
typedef struct cli_frame_range {
  int first, last, step;
} cli_frame_range;

/* One `key=value` for the scene, from --set or from an option that sets a key. */
typedef struct cli_setting {
  const char *key, *value;
  const char *option; /* the option that sets the key; NULL: --set */
} cli_setting;

typedef struct cli_options {
  const struct cli_verb *verb; /* NULL: none is given */
  bool wants_help, wants_version, wants_man;
  bool has_ended;    /* "--" has been read: no further word is an option */
  const char *shell; /* shell of a completion script; NULL: not given */
  const char **files;
  size_t file_count;
  cli_setting *settings;
  size_t setting_count;
  const char **outputs;
  size_t output_count;
  bool has_frame;
  int frame; /* frame of the scene to describe */
  cli_frame_range *frames;
  size_t frame_range_count;
  unsigned thread_count;
  neph_isa isa;
  bool has_resolution, has_crop;
  unsigned resolution[2];          /* width, height */
  unsigned crop[4];                /* x0, y0, x1, y1 */
  unsigned tile_index, tile_count; /* tile numbers; 1 is the first; 0 of 0: no tile */
  bool has_sample_range;
  unsigned sample_range[2]; /* the second excluded */
  unsigned shard_count;     /* tiles of each frame in a job, or to merge; 0: not given */
  unsigned chunk_size;      /* frames in a task of a job; 0: not given */
  double checkpoint_s;      /* seconds between checkpoints; 0: none */
  const char *checkpoint;   /* argument of --checkpoint as given */
  bool is_resumed, skips_existing;
  bool is_json, is_fixed, is_exact, wants_plan, is_dry_run;
  const char *method;       /* method of a probe; NULL: not given */
  const char *table_folder; /* folder for the tables of a sky; NULL: not given */
  const char *disks;        /* disks in the picture of a sky; NULL: not given */
  const char *usd_path;     /* USD layer of a sky; NULL: not given */
  const char *export_use;   /* use of an export: "clouds", "textures"; NULL: not given */
  const char *texture_file; /* format of textures: "ktx2", "raw"; NULL: not given */
  unsigned texture_size;    /* voxels along the longest edge of textures of clouds; 0: not given */
  bool has_center;
  double center_deg;   /* azimuth in the middle of a sky's picture */
  unsigned path_count; /* paths of a probe or a sky; 0: not given */
  const char *heights; /* heights of the planes of a probe; NULL: not given */
  double target_error; /* 0: not given */
  bool has_time_limit;
  double time_limit_s;
  double budget_s;       /* budget of a report; 0: not given */
  const char *reference; /* reference of a report; NULL: not given */
  bool is_quick, is_calibrating;
  const char *machine; /* file of a calibration; NULL: not given */
  bool has_relative_mse_max;
  double relative_mse_max;
  const char *preview_map; /* file or folder for weather maps; NULL: not given */
  const char *second;      /* picture with another seed; NULL: not given */
  const char *listen;      /* address of the server of a view; NULL: not given */
  unsigned port;           /* port of the server of `view`; 0: any free port */
  bool allows_files, opens_browser;
  bool is_half, has_region, has_memory_max, wants_velocity, wants_error, is_verifying;
  double prune_per_m, region_m[6];
  uint64_t memory_max_bytes, cache_size_max_bytes;
  const char *cache_dir; /* NULL: not given */
  unsigned level_count;  /* 0: not given */
  cli_progress_mode progress;
  const char *log_path;     /* NULL: no log file */
  const char *path_mapping; /* rules for names of files; NULL: none */
  const char *loop_log;     /* log of parallel loops; NULL: none */
  neph_log_level log_level;
  bool *given;   /* whether each option of the table is given, in its order */
  char *storage; /* memory to which settings point */
} cli_options;

/* Walk over the frames of --frames, each once, in the order of first mention; frame 1 where no frame is given. It
 * begins as {0}, and returns false after the last frame. */
typedef struct cli_frame_walk {
  size_t range;
  int64_t next; /* next frame of the current range, counted in steps from its first */
} cli_frame_walk;

bool cli_next_frame(const cli_options *options, cli_frame_walk *walk, int *out_frame);

/* Parses the command line. Returns CLI_USAGE, after a message on standard error, when it is wrong. */
cli_exit cli_options_read(int argc, char **argv, cli_options *out_options);
void cli_options_clear(cli_options *options);

#endif

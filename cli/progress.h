/* SPDX-License-Identifier: Apache-2.0 */
/* Progress and messages, on standard error and in a log file. */
#ifndef NEPHOS_CLI_PROGRESS_H
#define NEPHOS_CLI_PROGRESS_H

#include <stdbool.h>
#include <stdio.h>

#include <nephos/context.h>

#include "options.h"

/* The frame under way, of the whole job. */
typedef struct cli_progress_frame {
  int number;
  unsigned index, count; /* from 0; a count of 0 or 1: no frame is named */
  double begin, end;     /* part of the whole */
  double start_s;        /* after the start of the job */
} cli_progress_frame;

/* Progress of the whole job. */
typedef struct cli_progress_state {
  const char *stage;
  double fraction;  /* of the whole, never less than before */
  double elapsed_s; /* since the job began */
  double left_s;    /* until it ends; infinite: not told yet */
  cli_progress_frame frame;
} cli_progress_state;

struct cli_progress_style;

typedef struct cli_progress {
  const struct cli_progress_style *style;
  neph_log_level level;   /* of messages on standard error */
  FILE *log;              /* NULL: none */
  const char *log_path;   /* borrowed */
  bool is_log_lost;       /* a line of it, which a message has said */
  bool is_bar_drawn;      /* the last line of the terminal is the bar */
  char stage[48];         /* shown last, */
  int shown_frame;        /* of this frame, */
  double shown_fraction;  /* this far, */
  double shown_elapsed_s; /* at this time */
  char *message;          /* the last error; owned; NULL: there was none */
  double start_s;         /* of the job, by the machine's clock */
  double call_end;        /* part of the frame that the library's call is; the rest is the program's */
  double fraction;        /* of the whole, reported last */
  cli_progress_frame frame;
  unsigned timed_count; /* frames that are done, but for the first, and the time that they took */
  double timed_s;
} cli_progress;

void cli_progress_start(cli_progress *progress, const cli_options *options);

/* Opens a log file. Fails, after a message, where that cannot be, or it is a file of another kind. */
cli_exit cli_progress_open_log(cli_progress *progress, const char *path);

/* Closes the log file. */
void cli_progress_end(cli_progress *progress);

/* Begins a frame, which is the part [begin, end] of the whole. */
void cli_progress_begin_frame(cli_progress *progress, int number, unsigned index, unsigned count, double begin,
                              double end);

/* Seconds since its begin. */
double cli_progress_get_frame_s(const cli_progress *progress);

/* Ends it; `is_timed` where it was rendered, so that it tells of the frames to come. */
void cli_progress_end_frame(cli_progress *progress, bool is_timed);

/* A neph_progress_fn; `progress` is a cli_progress. False once the process was interrupted. */
bool cli_progress_report(void *progress, const neph_progress *report);

/* Lets the library's next calls be the first part of the frame, `call_end` of it; 1 at the start. */
void cli_progress_set_call(cli_progress *progress, double call_end);

/* A stage of the program's own, `fraction` of the frame. */
void cli_progress_set_stage(cli_progress *progress, const char *stage, double fraction);

/* Takes the bar away. */
void cli_progress_finish(cli_progress *progress);

/* A neph_log_fn; `progress` is a cli_progress. */
void cli_progress_log(void *progress, neph_log_level level, const char *message);

/* A message of the program's own, in the style of the progress. */
void cli_progress_complain(cli_progress *progress, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* A line for the log file alone. */
void cli_progress_note(cli_progress *progress, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif

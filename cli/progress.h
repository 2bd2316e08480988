/* SPDX-License-Identifier: Apache-2.0 */
/* Progress and messages, on standard error and in a log file. */
#ifndef NEPHOS_CLI_PROGRESS_H
#define NEPHOS_CLI_PROGRESS_H

#include <stdbool.h>
#include <stdio.h>

#include <nephos/context.h>

#include "options.h"

/* The current frame of the whole job. */
typedef struct cli_progress_frame {
  int number;
  unsigned index, count; /* position among the frames, 0 first; a count of 0 or 1: no frame is named */
  double begin, end;     /* share of the job before and after the frame */
  double start_s;        /* seconds since the start of the job */
} cli_progress_frame;

/* Progress of the whole job. */
typedef struct cli_progress_state {
  const char *stage;
  double fraction;  /* completed share of the job, never less than before */
  double elapsed_s; /* seconds since the job began */
  double left_s;    /* predicted seconds until it ends; infinite: unknown */
  cli_progress_frame frame;
} cli_progress_state;

struct cli_progress_style;

typedef struct cli_progress {
  const struct cli_progress_style *style;
  neph_log_level level;   /* least urgent level of messages on standard error */
  FILE *log;              /* NULL: none */
  const char *log_path;   /* borrowed */
  bool is_log_lost;       /* whether a line of the log was lost, after a warning */
  bool is_bar_drawn;      /* whether the last line of the terminal is the bar */
  char stage[48];         /* stage that was shown last */
  int shown_frame;        /* frame that was shown last */
  double shown_fraction;  /* share that was shown last */
  double shown_elapsed_s; /* time at which it was shown */
  bool (*hear)(void *user, neph_log_level level, const char *message); /* listener, which returns whether it takes a
                                                                          message; NULL: none */
  void *hear_user;
  char *message;   /* the last error; owned; NULL: there was none */
  double start_s;  /* start of the job, by the machine's clock */
  double call_end; /* share of the frame that the library's call takes; the program takes the rest */
  double fraction; /* share of the job that was reported last */
  cli_progress_frame frame;
  unsigned timed_count; /* finished frames after the first, and the time that they took */
  double timed_s;
} cli_progress;

void cli_progress_start(cli_progress *progress, const cli_options *options);

/* Opens a log file. Fails, after a message, where it cannot be opened, or is a file of another kind. */
cli_exit cli_progress_open_log(cli_progress *progress, const char *path);

/* Closes the log file. */
void cli_progress_end(cli_progress *progress);

/* Begins a frame, which is the part [begin, end] of the whole. */
void cli_progress_begin_frame(cli_progress *progress, int number, unsigned index, unsigned count, double begin,
                              double end);

/* Seconds since the frame began. */
double cli_progress_get_frame_s(const cli_progress *progress);

/* Ends the frame; `is_timed`: it was rendered, so that its time predicts later frames. */
void cli_progress_end_frame(cli_progress *progress, bool is_timed);

/* Progress callback, a neph_progress_fn; `progress` is a cli_progress. Returns false after an interrupt. */
bool cli_progress_report(void *progress, const neph_progress *report);

/* Sets the share of the frame, `call_end`, that the library's next calls take; 1 at the start. */
void cli_progress_set_call(cli_progress *progress, double call_end);

/* Reports a stage of the program's own at the share `fraction` of the frame. */
void cli_progress_set_stage(cli_progress *progress, const char *stage, double fraction);

/* Clears the bar. */
void cli_progress_finish(cli_progress *progress);

/* Log callback, a neph_log_fn; `progress` is a cli_progress. */
void cli_progress_log(void *progress, neph_log_level level, const char *message);

/* Sets a listener, which is called with each message before it is printed, on the thread of the message. A message that
 * it takes, by returning true, is not printed. NULL: none. */
void cli_progress_set_listener(cli_progress *progress,
                               bool (*hear)(void *user, neph_log_level level, const char *message), void *user);

/* Prints a message of the program's own, in the style of the progress. */
void cli_progress_complain(cli_progress *progress, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Writes a line to the log file alone. */
void cli_progress_note(cli_progress *progress, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif

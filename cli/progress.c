/* SPDX-License-Identifier: Apache-2.0 */
#include "progress.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include <nephos/text.h>

#include "print.h"
#include "process.h"
#include "progress_styles.h"

static double get_clock_s(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double get_elapsed_s(const cli_progress *progress) { return get_clock_s() - progress->start_s; }

/* Checks that a log can be appended to. A file of another kind, such as an input, stays as it is. A pipe would block
 * until it has a reader. */
static bool check_log(const char *path) {
  int year, month, day;
  struct stat status;
  if (stat(path, &status)) return true;
  if (S_ISFIFO(status.st_mode) || S_ISSOCK(status.st_mode)) {
    cli_complain("--log is %s, which is a pipe or a socket: give a file", path);
    return false;
  }
  if (!S_ISREG(status.st_mode) || !status.st_size) return true;
  char start[32] = "";
  FILE *file = fopen(path, "re");
  const bool is_read = file && fgets(start, sizeof start, file);
  if (file) fclose(file);
  if (is_read && sscanf(start, "%4d-%2d-%2dT", &year, &month, &day) == 3) return true;
  cli_complain("--log is %s, which is a file of another kind: give a log of nephos, or a new name", path);
  return false;
}

void cli_progress_start(cli_progress *progress, const cli_options *options) {
  *progress = (cli_progress){.style = cli_progress_style_get(options->progress),
                             .level = options->log_level,
                             .call_end = 1.0,
                             .frame = {.end = 1.0},
                             .start_s = get_clock_s()};
}

cli_exit cli_progress_open_log(cli_progress *progress, const char *path) {
  if (!check_log(path)) return CLI_USAGE;
  progress->log_path = path;
  progress->log = fopen(path, "ae");
  if (progress->log) return CLI_DONE;
  cli_complain("%s: the log cannot be opened: %s", path, strerror(errno));
  return CLI_IO;
}

void cli_progress_end(cli_progress *progress) {
  cli_progress_finish(progress);
  if (progress->log) fclose(progress->log);
  progress->log = NULL;
  free(progress->message);
  progress->message = NULL;
}

/* ---- The log file ---- */

/* Warns once that lines of the log are lost, as on a full disk; later lines are still tried. */
static void note_loss(cli_progress *progress) {
  const int error = errno;
  clearerr(progress->log);
  if (progress->is_log_lost) return;
  progress->is_log_lost = true;
  cli_text text = {0};
  cli_text_add(&text, "%s: the log cannot be written: %s: lines of it are lost", progress->log_path, strerror(error));
  neph_text_clean(text.characters);
  cli_progress_log(progress, NEPH_LOG_WARNING, cli_text_get(&text));
  cli_text_clear(&text);
}

/* Writes a line with its time. The last line of a killed job is complete. */
static void write_log(cli_progress *progress, const char *kind, const char *text) {
  struct tm utc;
  char date[32];
  const time_t now = time(NULL);
  if (!progress->log) return;
  strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%SZ", gmtime_r(&now, &utc));
  if (fprintf(progress->log, "%s %s%s\n", date, kind, text) < 0 || fflush(progress->log)) note_loss(progress);
}

void cli_progress_note(cli_progress *progress, const char *format, ...) {
  cli_text text = {0};
  va_list arguments;
  va_start(arguments, format);
  cli_text_add_list(&text, format, arguments);
  va_end(arguments);
  write_log(progress, "", cli_text_get(&text));
  cli_text_clear(&text);
}

/* ---- Fractions and times ---- */

void cli_progress_begin_frame(cli_progress *progress, int number, unsigned index, unsigned count, double begin,
                              double end) {
  progress->call_end = 1.0;
  progress->frame = (cli_progress_frame){number, index, count, begin, end, get_elapsed_s(progress)};
}

double cli_progress_get_frame_s(const cli_progress *progress) {
  return get_elapsed_s(progress) - progress->frame.start_s;
}

/* Ends a frame. The first frame is not timed for predictions: it solves what later frames reuse. */
void cli_progress_end_frame(cli_progress *progress, bool is_timed) {
  const cli_progress_frame *frame = &progress->frame;
  if (is_timed && frame->index > 0) {
    progress->timed_count++;
    progress->timed_s += cli_progress_get_frame_s(progress);
  }
  progress->fraction = fmax(progress->fraction, frame->end);
}

/* Remaining seconds, predicted by the mean time of finished frames, or before the first by the finished share of the
 * whole. */
static double predict_left(const cli_progress *progress, double frame_fraction, double elapsed_s) {
  const cli_progress_frame *frame = &progress->frame;
  if (progress->timed_count > 0 && frame->count > frame->index) {
    const double mean_s = progress->timed_s / progress->timed_count;
    return mean_s * (frame->count - frame->index - frame_fraction);
  }
  return progress->fraction > 0.01 ? elapsed_s * (1.0 / progress->fraction - 1.0) : HUGE_VAL;
}

/* State of the whole job, with `fraction` of the frame done. */
static cli_progress_state get_state(cli_progress *progress, const char *stage, double fraction) {
  const cli_progress_frame *frame = &progress->frame;
  const double elapsed_s = get_elapsed_s(progress);
  progress->fraction = fmax(progress->fraction, frame->begin + fraction * (frame->end - frame->begin));
  return (cli_progress_state){.stage = stage,
                              .fraction = progress->fraction,
                              .elapsed_s = elapsed_s,
                              .left_s = predict_left(progress, fraction, elapsed_s),
                              .frame = *frame};
}

/* ---- Reports ---- */

static bool is_new_stage(const cli_progress *progress, const cli_progress_state *state) {
  return progress->shown_frame != state->frame.number ||
         strncmp(progress->stage, state->stage, sizeof progress->stage - 1);
}

static bool is_due(const cli_progress *progress, const cli_progress_state *state) {
  const cli_progress_style *style = progress->style;
  if (!style->show) return false;
  if (style->has_stages && is_new_stage(progress, state)) return true;
  const double passed_s = state->elapsed_s - progress->shown_elapsed_s;
  return passed_s >= style->interval_s && state->fraction - progress->shown_fraction >= style->step;
}

static void show(cli_progress *progress, const cli_progress_state *state) {
  flockfile(stderr);
  progress->style->show(state);
  progress->is_bar_drawn = progress->style->is_bar;
  progress->shown_fraction = state->fraction;
  progress->shown_elapsed_s = state->elapsed_s;
  funlockfile(stderr);
}

static void note_stage(cli_progress *progress, const cli_progress_state *state) {
  if (!is_new_stage(progress, state)) return;
  if (state->frame.count > 0)
    cli_progress_note(progress, "frame %d, %s: %.1f %%", state->frame.number, state->stage, 100.0 * state->fraction);
  else
    cli_progress_note(progress, "%s: %.1f %%", state->stage, 100.0 * state->fraction);
  cli_print(progress->stage, sizeof progress->stage, "%s", state->stage);
  progress->shown_frame = state->frame.number;
}

bool cli_progress_report(void *user, const neph_progress *report) {
  cli_progress *progress = user;
  const cli_progress_state state = get_state(progress, report->stage, report->fraction * progress->call_end);
  if (is_due(progress, &state)) show(progress, &state);
  note_stage(progress, &state);
  return !cli_is_interrupted();
}

void cli_progress_set_call(cli_progress *progress, double call_end) { progress->call_end = call_end; }

void cli_progress_set_stage(cli_progress *progress, const char *stage, double fraction) {
  const cli_progress_state state = get_state(progress, stage, fraction);
  if (progress->style->show) show(progress, &state);
  note_stage(progress, &state);
}

static void clear_bar(cli_progress *progress) {
  if (progress->is_bar_drawn) fputs("\r\033[K", stderr);
  progress->is_bar_drawn = false;
}

void cli_progress_finish(cli_progress *progress) {
  flockfile(stderr);
  clear_bar(progress);
  funlockfile(stderr);
  progress->stage[0] = '\0';
}

/* ---- Messages ---- */

void cli_progress_set_listener(cli_progress *progress,
                               bool (*hear)(void *user, neph_log_level level, const char *message), void *user) {
  progress->hear = hear;
  progress->hear_user = user;
}

void cli_progress_log(void *user, neph_log_level level, const char *message) {
  cli_progress *progress = user;
  if (progress->hear && progress->hear(progress->hear_user, level, message)) return;
  const cli_progress_state state = {.stage = progress->stage, .frame = progress->frame};
  flockfile(stderr);
  if (level == NEPH_LOG_ERROR) {
    free(progress->message);
    progress->message = strdup(message);
  }
  if (level <= progress->level) {
    clear_bar(progress);
    progress->style->say(&state, level, message);
  }
  write_log(progress, level == NEPH_LOG_ERROR ? "error: " : level == NEPH_LOG_WARNING ? "warning: " : "", message);
  funlockfile(stderr);
}

void cli_progress_complain(cli_progress *progress, const char *format, ...) {
  cli_text text = {0};
  va_list arguments;
  va_start(arguments, format);
  cli_text_add_list(&text, format, arguments);
  va_end(arguments);
  neph_text_clean(text.characters);
  cli_progress_log(progress, NEPH_LOG_ERROR, cli_text_get(&text));
  cli_text_clear(&text);
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "progress_styles.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

#include "print.h"
#include "session.h"

/* ---- Words ---- */

/* Prints a duration: "12.3 s", "4 min 5 s", "2 h 3 min". */
static void describe_time(double seconds, char out[32]) {
  const unsigned long whole = seconds < 1e9 ? (unsigned long)(seconds + 0.5) : 1000000000ul;
  if (whole < 60)
    cli_print(out, 32, "%.1f s", seconds);
  else if (whole < 3600)
    cli_print(out, 32, "%lu min %lu s", whole / 60, whole % 60);
  else
    cli_print(out, 32, "%lu h %lu min", whole / 3600, whole % 3600 / 60);
}

/* Prints the elapsed and the remaining time: "12.3 s, 1 min 2 s left". */
static void describe_times(const cli_progress_state *state, char out[80]) {
  char elapsed[32], left[32];
  describe_time(state->elapsed_s, elapsed);
  describe_time(state->left_s, left);
  if (state->left_s < HUGE_VAL)
    cli_print(out, 80, "%s, %s left", elapsed, left);
  else
    cli_print(out, 80, "%s", elapsed);
}

/* Prints frame and stage: "frame 12 (3 of 100), rendering". */
static void describe_stage(const cli_progress_state *state, char out[96]) {
  const cli_progress_frame *frame = &state->frame;
  if (frame->count > 1)
    cli_print(out, 96, "frame %d (%u of %u), %s", frame->number, frame->index + 1, frame->count, state->stage);
  else
    cli_print(out, 96, "%s", state->stage);
}

static void say_plainly(const cli_progress_state *state, neph_log_level level, const char *message) {
  (void)state;
  fprintf(stderr, "nephos: %s%s\n", level == NEPH_LOG_WARNING ? "warning: " : "", message);
}

/* ---- Styles to read ---- */

/* Draws "frame 12, 3/100: rendering" and a bar beside it, on one line of 80 columns. */
static void draw_bar(const cli_progress_state *state) {
  enum { WIDTH = 24 };
  static const char full[WIDTH + 1] = "########################", empty[WIDTH + 1] = "........................";
  const cli_progress_frame *frame = &state->frame;
  const bool is_batch = frame->count > 1;
  const int width = is_batch ? WIDTH / 2 : WIDTH, done = (int)(state->fraction * width);
  char stage[96], time[32];
  if (is_batch)
    cli_print(stage, sizeof stage, "frame %d, %u/%u: %s", frame->number, frame->index + 1, frame->count, state->stage);
  else
    cli_print(stage, sizeof stage, "%s", state->stage);
  describe_time(state->left_s < HUGE_VAL ? state->left_s : state->elapsed_s, time);
  fprintf(stderr, "\r%-*.*s [%.*s%.*s] %3.0f %%  %s%s\033[K", is_batch ? 38 : 26, is_batch ? 38 : 26, stage, done, full,
          width - done, empty, floor(state->fraction * 100.0), time, state->left_s < HUGE_VAL ? " left" : "");
  fflush(stderr);
}

static void print_line(const cli_progress_state *state) {
  char stage[96], times[80];
  describe_stage(state, stage);
  describe_times(state, times);
  fprintf(stderr, "nephos: %s %.0f %%, %s\n", stage, floor(state->fraction * 100.0), times);
}

/* ---- Styles to parse ---- */

static void open_record(const cli_progress_state *state) {
  fputc('{', stderr);
  if (state->frame.count > 0)
    fprintf(stderr, "\"frame\": %d, \"frame_index\": %u, \"frame_count\": %u, ", state->frame.number,
            state->frame.index + 1, state->frame.count);
}

static void print_json(const cli_progress_state *state) {
  open_record(state);
  fputs("\"stage\": ", stderr);
  cli_put_json_text(stderr, state->stage);
  fprintf(stderr, ", \"fraction\": %.4f, \"seconds\": %.3f, \"seconds_left\": ", state->fraction, state->elapsed_s);
  fprintf(stderr, state->left_s < HUGE_VAL ? "%.3f}\n" : "null}\n", state->left_s);
}

static void say_json(const cli_progress_state *state, neph_log_level level, const char *message) {
  static const char *const levels[] = {
      [NEPH_LOG_ERROR] = "error", [NEPH_LOG_WARNING] = "warning", [NEPH_LOG_INFO] = "info", [NEPH_LOG_DEBUG] = "debug"};
  open_record(state);
  fprintf(stderr, "\"level\": \"%s\", \"message\": ", levels[level]);
  cli_put_json_text(stderr, message);
  fputs("}\n", stderr);
}

static void print_alf(const cli_progress_state *state) {
  fprintf(stderr, "ALF_PROGRESS %.0f%%\n", floor(state->fraction * 100.0));
}

static void print_openjd(const cli_progress_state *state) {
  char stage[96];
  describe_stage(state, stage);
  fprintf(stderr, "openjd_progress: %.1f\nopenjd_status: %s\n", floor(state->fraction * 1000.0) / 10.0, stage);
}

static void say_openjd(const cli_progress_state *state, neph_log_level level, const char *message) {
  if (level == NEPH_LOG_ERROR)
    fprintf(stderr, "openjd_fail: %s\n", message);
  else
    say_plainly(state, level, message);
}

/* ---- The table ---- */

const cli_progress_style *cli_progress_style_get(cli_progress_mode mode) {
  static const cli_progress_style styles[CLI_PROGRESS_COUNT] = {
      [CLI_PROGRESS_BAR] = {"bar", draw_bar, say_plainly, .is_bar = true, .has_stages = true, .interval_s = 0.1},
      [CLI_PROGRESS_LINES] = {"lines", print_line, say_plainly, .has_stages = true, .interval_s = 1.0, .step = 0.1},
      [CLI_PROGRESS_JSON] = {"json", print_json, say_json, .has_stages = true, .interval_s = 0.5},
      [CLI_PROGRESS_ALF] = {"alf", print_alf, say_plainly, .interval_s = 0.5, .step = 0.01},
      [CLI_PROGRESS_OPENJD] = {"openjd", print_openjd, say_openjd, .has_stages = true, .interval_s = 0.5},
      [CLI_PROGRESS_NONE] = {"none", NULL, say_plainly},
  };
  if (mode == CLI_PROGRESS_AUTO) mode = isatty(STDERR_FILENO) ? CLI_PROGRESS_BAR : CLI_PROGRESS_LINES;
  return &styles[mode];
}

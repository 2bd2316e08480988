/* SPDX-License-Identifier: Apache-2.0 */
#include "progress.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "process.h"

void cli_progress_start(cli_progress *progress, cli_progress_mode mode) {
  *progress = (cli_progress){.mode = mode, .call_end = 1.0};
  if (mode != CLI_PROGRESS_AUTO) return;
  progress->mode = isatty(STDERR_FILENO) ? CLI_PROGRESS_BAR : CLI_PROGRESS_LINES;
}

static void clear_bar(cli_progress *progress) {
  if (progress->is_bar_drawn) fputs("\r\033[K", stderr);
  progress->is_bar_drawn = false;
}

static void draw_bar(cli_progress *progress, const neph_progress *report) {
  enum { WIDTH = 32 };
  static const char full[WIDTH + 1] = "################################",
                                 empty[WIDTH + 1] = "................................";
  int done = (int)(report->fraction * WIDTH);
  fprintf(stderr, "\r%-24.24s [%.*s%.*s] %3.0f %%  %.1f s\033[K", report->stage, done, full, WIDTH - done, empty,
          report->fraction * 100, report->elapsed_s);
  fflush(stderr);
  progress->is_bar_drawn = true;
}

static void print_json(const neph_progress *report) {
  fprintf(stderr, "{\"stage\": \"%s\", \"fraction\": %.4f, \"elapsed_s\": %.3f}\n", report->stage, report->fraction,
          report->elapsed_s);
}

static void print_line(const neph_progress *report) {
  fprintf(stderr, "nephos: %s %.0f %%, %.1f s\n", report->stage, report->fraction * 100, report->elapsed_s);
}

/* A bar ten times a second; lines at each stage's begin, then at every tenth of it but no more than one a second. */
static bool is_due(const cli_progress *progress, const neph_progress *report) {
  if (strncmp(progress->stage, report->stage, sizeof progress->stage - 1)) return true;
  double passed_s = report->elapsed_s - progress->shown_elapsed_s;
  if (passed_s < 0) return true;
  if (progress->mode == CLI_PROGRESS_BAR) return passed_s >= 0.1;
  return passed_s >= 1 && report->fraction - progress->shown_fraction >= 0.1;
}

static void show(cli_progress *progress, const neph_progress *report) {
  flockfile(stderr);
  if (progress->mode == CLI_PROGRESS_BAR) draw_bar(progress, report);
  if (progress->mode == CLI_PROGRESS_JSON) print_json(report);
  if (progress->mode == CLI_PROGRESS_LINES) print_line(report);
  snprintf(progress->stage, sizeof progress->stage, "%s", report->stage);
  progress->shown_fraction = report->fraction;
  progress->shown_elapsed_s = report->elapsed_s;
  funlockfile(stderr);
}

bool cli_progress_report(void *user, const neph_progress *report) {
  cli_progress *progress = user;
  const neph_progress whole = {report->stage, report->fraction * progress->call_end, report->elapsed_s,
                               report->remaining_s};
  progress->elapsed_s = report->elapsed_s;
  if (progress->mode != CLI_PROGRESS_NONE && is_due(progress, &whole)) show(progress, &whole);
  return !cli_is_interrupted();
}

void cli_progress_set_call(cli_progress *progress, double call_end) { progress->call_end = call_end; }

void cli_progress_set_stage(cli_progress *progress, const char *stage, double fraction) {
  const neph_progress whole = {.stage = stage, .fraction = fraction, .elapsed_s = progress->elapsed_s};
  if (progress->mode != CLI_PROGRESS_NONE) show(progress, &whole);
}

void cli_progress_finish(cli_progress *progress) {
  flockfile(stderr);
  clear_bar(progress);
  funlockfile(stderr);
  progress->stage[0] = '\0';
}

void cli_progress_log(void *user, neph_log_level level, const char *message) {
  cli_progress *progress = user;
  flockfile(stderr);
  clear_bar(progress);
  fprintf(stderr, "nephos: %s%s\n", level == NEPH_LOG_WARNING ? "warning: " : "", message);
  funlockfile(stderr);
}

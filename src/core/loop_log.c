/* SPDX-License-Identifier: Apache-2.0 */
#include "core/loop_log.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "core/alloc.h"
#include "core/file.h"

struct np_loop_log {
  neph_context *context;
  np_file_write write;
  FILE *file;
  const void *owner; /* place of the thread that opened the log */
  double end_s;      /* CPU seconds of that thread at the end of the last loop */
  size_t piece_count, piece_capacity;
  double *piece_s; /* pieces of the loop under way */
};

/* A place that is different in each thread. */
static const void *get_thread(void) {
  static _Thread_local char place;
  return &place;
}

static double read_clock(clockid_t clock) {
  struct timespec now;
  clock_gettime(clock, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double np_loop_log_read_clock(void) { return read_clock(CLOCK_THREAD_CPUTIME_ID); }

static neph_result open_file(np_loop_log *log, const char *path) {
  neph_result result = np_file_write_begin(log->context, path, &log->write);
  if (result) return result;
  log->file = fopen(log->write.temporary, "w");
  if (log->file) return NEPH_OK;
  const int error = errno;
  np_file_write_abandon(&log->write);
  return np_fail(log->context, NEPH_ERROR_IO, "%s: cannot write: %s", path, strerror(error));
}

neph_result np_loop_log_open(neph_context *context, const char *path, np_loop_log **out_log) {
  np_loop_log *log = *out_log = np_alloc(context, 1, sizeof *log);
  if (!log) return NEPH_ERROR_OUT_OF_MEMORY;
  log->context = context;
  log->owner = get_thread();
  const neph_result result = open_file(log, path);
  if (!result) return NEPH_OK;
  np_alloc_free(context, log);
  *out_log = NULL;
  return result;
}

/* The calling thread's CPU time since the last loop begins with the thread, so that the start of the program counts. */
void np_loop_log_close(neph_context *context, np_loop_log *log) {
  if (!log) return;
  fprintf(log->file, "{\"before_s\": %.9f, \"process_s\": %.9f}\n", np_loop_log_read_clock() - log->end_s,
          read_clock(CLOCK_PROCESS_CPUTIME_ID));
  const bool is_bad = ferror(log->file), is_unwritten = fclose(log->file);
  if (is_bad || is_unwritten) {
    np_log(context, NEPH_LOG_WARNING, "%s: the log of loops could not be written", log->write.target);
    np_file_write_abandon(&log->write);
  } else {
    (void)np_file_write_commit(&log->write);
  }
  np_alloc_free(context, log->piece_s);
  np_alloc_free(context, log);
}

bool np_loop_log_begin(np_loop_log *log, size_t piece_count) {
  if (!log || log->owner != get_thread()) return false;
  if (piece_count > log->piece_capacity) {
    np_alloc_free(log->context, log->piece_s);
    log->piece_s = np_alloc(log->context, piece_count, sizeof *log->piece_s);
    log->piece_capacity = log->piece_s ? piece_count : 0;
    if (!log->piece_s) return false;
  }
  memset(log->piece_s, 0, piece_count * sizeof *log->piece_s);
  log->piece_count = piece_count;
  return fprintf(log->file, "{\"before_s\": %.9f, ", np_loop_log_read_clock() - log->end_s) > 0;
}

void np_loop_log_note(np_loop_log *log, size_t piece, double seconds) { log->piece_s[piece] = seconds; }

static void write_waits(FILE *file, const np_waits *waits, size_t count) {
  fputs(", \"waits\": [", file);
  for (size_t i = 0; i < count; i++) {
    const char *comma = "";
    fputs(i ? ", [" : "[", file);
    for (unsigned w = 0; w < NP_WAITS_MAX; w++) {
      if (waits[i].on[w] == NP_WAITS_NONE) continue;
      fprintf(file, "%s%u", comma, waits[i].on[w]);
      comma = ", ";
    }
    fputc(']', file);
  }
  fputc(']', file);
}

void np_loop_log_end(np_loop_log *log, const np_loop_site *site, const char *stage, const np_waits *waits) {
  fprintf(log->file, "\"work\": \"%s\", \"caller\": \"%s\", \"stage\": \"%s\", \"pieces_us\": [", site->work,
          site->caller, stage ? stage : "");
  for (size_t i = 0; i < log->piece_count; i++) fprintf(log->file, i ? ", %.1f" : "%.1f", 1e6 * log->piece_s[i]);
  fputc(']', log->file);
  if (waits) write_waits(log->file, waits, log->piece_count);
  fputs("}\n", log->file);
  log->end_s = np_loop_log_read_clock();
}

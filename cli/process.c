/* SPDX-License-Identifier: Apache-2.0 */
#include "process.h"

#include <fcntl.h>
#include <malloc.h>
#include <signal.h>
#include <stddef.h>
#include <stdio.h>
#include <sys/resource.h>
#include <unistd.h>

/* ---- Streams ---- */

bool cli_open_streams(void) {
  static const int modes[] = {[STDIN_FILENO] = O_WRONLY, [STDOUT_FILENO] = O_RDONLY, [STDERR_FILENO] = O_WRONLY};
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; stream++)
    if (fcntl(stream, F_GETFD) < 0 && open("/dev/null", modes[stream]) < 0) return false;
  return true;
}

/* ---- Signals ---- */

/* Variables that signal handlers set. The first is the number of the last signal. */
static volatile sig_atomic_t interrupted_by, wants_snapshot;

static void note_interrupt(int signal_number) { interrupted_by = signal_number; }

static void note_snapshot(int signal_number) {
  (void)signal_number;
  wants_snapshot = 1;
}

static void catch_signal(int number) {
  struct sigaction inherited, action = {.sa_handler = note_interrupt, .sa_flags = SA_RESTART};
  if (number != SIGPIPE && number != SIGXCPU) action.sa_flags |= (int)SA_RESETHAND;
  sigemptyset(&action.sa_mask);
  if (!sigaction(number, NULL, &inherited) && inherited.sa_handler != SIG_IGN) sigaction(number, &action, NULL);
}

void cli_ignore_size_signal(void) { signal(SIGXFSZ, SIG_IGN); }

void cli_save_memory(void) {
#ifdef M_MMAP_THRESHOLD
  enum { LARGE = 4 << 20 };
  (void)mallopt(M_MMAP_THRESHOLD, LARGE);
#endif
#ifdef M_ARENA_MAX
  struct rlimit limit;
  if (!getrlimit(RLIMIT_AS, &limit) && limit.rlim_cur != RLIM_INFINITY) (void)mallopt(M_ARENA_MAX, 1);
#endif
}

void cli_catch_interrupts(void) {
  static const int numbers[] = {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXCPU};
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) catch_signal(numbers[i]);
}

bool cli_is_interrupted(void) { return interrupted_by; }

const char *cli_get_terminator(void) {
  return interrupted_by == SIGTERM ? "SIGTERM" : interrupted_by == SIGXCPU ? "SIGXCPU, the limit on CPU time" : NULL;
}

void cli_catch_snapshots(void) {
  struct sigaction action = {.sa_handler = note_snapshot, .sa_flags = SA_RESTART};
  sigemptyset(&action.sa_mask);
  sigaction(SIGUSR1, &action, NULL);
}

bool cli_take_snapshot(void) {
  const bool wants = wants_snapshot;
  wants_snapshot = 0;
  return wants;
}

/* ---- Memory ---- */

/* Peak memory from VmHWM, which starts at 0 with exec. ru_maxrss includes the parent's memory until then. */
double cli_get_peak_memory_bytes(void) {
  unsigned long long kilobytes = 0;
  char line[256];
  FILE *status = fopen("/proc/self/status", "r");
  while (status && !kilobytes && fgets(line, sizeof line, status))
    if (sscanf(line, "VmHWM: %llu kB", &kilobytes) != 1) kilobytes = 0;
  if (status) fclose(status);
  if (kilobytes) return 1024.0 * (double)kilobytes;
  struct rusage usage; /* fallback without /proc */
  return getrusage(RUSAGE_SELF, &usage) ? 0.0 : 1024.0 * (double)usage.ru_maxrss;
}

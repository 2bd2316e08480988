/* SPDX-License-Identifier: Apache-2.0 */
#include "process.h"

#include <fcntl.h>
#include <signal.h>
#include <stddef.h>
#include <unistd.h>

/* ---- Streams ---- */

bool cli_open_streams(void) {
  static const int modes[] = {[STDIN_FILENO] = O_WRONLY, [STDOUT_FILENO] = O_RDONLY, [STDERR_FILENO] = O_WRONLY};
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; stream++)
    if (fcntl(stream, F_GETFD) < 0 && open("/dev/null", modes[stream]) < 0) return false;
  return true;
}

/* ---- Signals ---- */

/* The one variable that outlives a call: a signal handler can reach no other. */
static volatile sig_atomic_t is_interrupted;

static void note_interrupt(int signal_number) {
  (void)signal_number;
  is_interrupted = 1;
}

static void catch_signal(int number) {
  struct sigaction inherited, action = {.sa_handler = note_interrupt, .sa_flags = SA_RESTART};
  if (number != SIGPIPE) action.sa_flags |= (int)SA_RESETHAND;
  sigemptyset(&action.sa_mask);
  if (!sigaction(number, NULL, &inherited) && inherited.sa_handler != SIG_IGN) sigaction(number, &action, NULL);
}

void cli_ignore_size_signal(void) { signal(SIGXFSZ, SIG_IGN); }

void cli_catch_interrupts(void) {
  static const int numbers[] = {SIGINT, SIGTERM, SIGHUP, SIGPIPE};
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) catch_signal(numbers[i]);
}

bool cli_is_interrupted(void) { return is_interrupted; }

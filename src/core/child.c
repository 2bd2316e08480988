/* SPDX-License-Identifier: Apache-2.0 */
/* Child processes by posix_spawn, not fork: in a process of several threads a forked copy may hold locks that no thread
 * releases. */
#include "core/child.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdint.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

/* ---- Start ---- */

/* Sets default signals, whatever this thread blocks or ignores, so that a broken pipe ends the child. A process group
 * of its own keeps a terminal's Ctrl-C away from it: the reader ends it, and can distinguish that from a crash.
 */
static int set_signals(posix_spawnattr_t *attributes) {
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  int error = posix_spawnattr_setsigmask(attributes, &none);
  if (!error) error = posix_spawnattr_setsigdefault(attributes, &all);
  if (!error) error = posix_spawnattr_setpgroup(attributes, 0);
  const short flags = POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP;
  return error ? error : posix_spawnattr_setflags(attributes, flags);
}

/* Input and output of the child, on descriptors above its first three. */
typedef struct child_files {
  int input, output; /* input −1: /dev/null */
} child_files;

static int set_files(posix_spawn_file_actions_t *actions, const child_files *files) {
  int error = posix_spawn_file_actions_adddup2(actions, files->output, STDOUT_FILENO);
  if (!error && files->input >= 0) error = posix_spawn_file_actions_adddup2(actions, files->input, STDIN_FILENO);
  if (!error && files->input < 0)
    error = posix_spawn_file_actions_addopen(actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  if (!error) error = posix_spawn_file_actions_addopen(actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  return error ? error : posix_spawn_file_actions_addclosefrom_np(actions, STDERR_FILENO + 1);
}

static int spawn(const char *program, const char *const words[], const child_files *files, pid_t *out_process) {
  char *arguments[NP_CHILD_WORDS_MAX + 2] = {(char *)(uintptr_t)program};
  for (int i = 0; i < NP_CHILD_WORDS_MAX && words[i]; i++) arguments[i + 1] = (char *)(uintptr_t)words[i];
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_t actions;
  int error = posix_spawnattr_init(&attributes);
  if (error) return error;
  error = posix_spawn_file_actions_init(&actions);
  if (!error) {
    error = set_signals(&attributes);
    if (!error) error = set_files(&actions, files);
    if (!error) error = posix_spawn(out_process, program, &actions, &attributes, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
  }
  posix_spawnattr_destroy(&attributes);
  return error;
}

/* Capacity of the pipe: with the usual 64 KB both ends often wait for each other. */
enum { PIPE_BYTES = 1 << 20 };

static int duplicate(int file) { return fcntl(file, F_DUPFD_CLOEXEC, STDERR_FILENO + 1); }

int np_child_start_on(const char *program, const char *const words[], int input, np_child *out_child) {
  int ends[2];
  *out_child = (np_child){.output = -1};
  if (pipe2(ends, O_CLOEXEC)) return errno;
  (void)fcntl(ends[0], F_SETPIPE_SZ, PIPE_BYTES);
  const child_files files = {input < 0 ? -1 : duplicate(input), duplicate(ends[1])};
  int error = files.output < 0 || (input >= 0 && files.input < 0) ? errno : 0;
  close(ends[1]);
  if (!error) error = spawn(program, words, &files, &out_child->process);
  if (files.input >= 0) close(files.input);
  if (files.output >= 0) close(files.output);
  out_child->output = ends[0];
  if (error) {
    out_child->process = 0;
    np_child_end(out_child);
  }
  return error;
}

int np_child_start(const char *program, const char *const words[], np_child *out_child) {
  return np_child_start_on(program, words, -1, out_child);
}

/* ---- Output and end ---- */

enum { PAUSE_MS = 50 };

neph_result np_child_read(np_child *child, neph_context *context, const np_monitor *monitor, void *out_bytes,
                          size_t count) {
  char *to = out_bytes;
  while (count > 0) {
    struct pollfd output = {.fd = child->output, .events = POLLIN};
    if (np_wait_is_cancelled(context, monitor)) return NEPH_ERROR_CANCELLED;
    if (poll(&output, 1, PAUSE_MS) <= 0) continue; /* no output yet, or a signal */
    const ssize_t got = read(child->output, to, count);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return NEPH_ERROR_BAD_FILE;
    to += got;
    count -= (size_t)got;
  }
  return NEPH_OK;
}

int np_child_wait(np_child *child) {
  int status = -1;
  pid_t waited = 0;
  do waited = child->process > 0 ? waitpid(child->process, &status, 0) : 0;
  while (waited < 0 && errno == EINTR);
  const bool is_known = waited > 0 && waited == child->process;
  child->process = 0;
  return is_known ? status : -1;
}

void np_child_end(np_child *child) {
  if (child->output >= 0) close(child->output);
  child->output = -1;
  if (child->process > 0) kill(child->process, SIGKILL);
  (void)np_child_wait(child);
}

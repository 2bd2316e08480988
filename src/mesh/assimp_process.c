/* SPDX-License-Identifier: Apache-2.0 */
#include "mesh/assimp_process.h"

#include <limits.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>

#include "core/file.h"
#include "core/module.h"
#include "mesh/mesh_header.h"

static const np_module_kind assimp_kind = {.file = NP_ASSIMP_PROGRAM_FILE, .purpose = "reads meshes and cameras"};

bool np_assimp_is_present(neph_context *context) { return np_module_has_program(context, &assimp_kind); }

/* ---- Failures ---- */

static neph_result fail_by_signal(const np_assimp_process *p, int signal) {
  if (signal == SIGXCPU)
    return np_fail(p->context, NEPH_ERROR_BAD_FILE,
                   "%s: cannot be read: Assimp took more than %u s and 1 s a megabyte: it is damaged, or convert it",
                   p->path, NP_ASSIMP_TIME_S);
  return np_fail(p->context, NEPH_ERROR_BAD_FILE,
                 "%s: cannot be read: Assimp ended by the signal SIG%s: it is damaged, or convert it", p->path,
                 sigabbrev_np(signal) ? sigabbrev_np(signal) : "");
}

static neph_result fail_by_end(np_assimp_process *p) {
  enum { NOT_STARTED = 127 /* the dynamic linker failed */ };
  const int status = np_child_wait(&p->child);
  if (status != -1 && WIFSIGNALED(status)) return fail_by_signal(p, WTERMSIG(status));
  if (status != -1 && WIFEXITED(status) && WEXITSTATUS(status) == NOT_STARTED)
    return np_fail(p->context, NEPH_ERROR_UNSUPPORTED, "%s: cannot be read: libraries of %s, which %s, are missing",
                   p->path, assimp_kind.file, assimp_kind.purpose);
  return np_fail(p->context, NEPH_ERROR_BAD_FILE,
                 "%s: cannot be read: Assimp ended before it was done: it is damaged, or convert it", p->path);
}

static neph_result fail_by_message(np_assimp_process *p, size_t length) {
  char message[NP_ASSIMP_MESSAGE_BYTES] = "";
  if (length >= sizeof message) return fail_by_end(p);
  const neph_result result = np_assimp_read(p, message, length);
  if (result) return result;
  if (strstr(message, "bad_alloc"))
    return np_fail(p->context, NEPH_ERROR_BAD_FILE,
                   "%s: cannot be read: Assimp needs more than %u MB and %u times the file: it is damaged, or convert "
                   "it",
                   p->path, (unsigned)(NP_ASSIMP_ROOM_BYTES / 1000000), NP_ASSIMP_ROOM_FACTOR);
  return np_fail(p->context, NEPH_ERROR_BAD_FILE, "%s: cannot be read: Assimp: %s", p->path, message);
}

/* ---- Begin, read, end ---- */

static neph_result read_start(np_assimp_process *p) {
  np_assimp_start start;
  const neph_result result = np_assimp_read(p, &start, sizeof start);
  if (result) return result;
  if (start.version != NP_ASSIMP_STREAM_VERSION)
    return np_fail(p->context, NEPH_ERROR_UNSUPPORTED, "%s: cannot be read: %s is of another version of nephos",
                   p->path, assimp_kind.file);
  return start.message_length ? fail_by_message(p, start.message_length) : NEPH_OK;
}

static neph_result start_program(np_assimp_process *p, const char *const request[]) {
  char program[PATH_MAX];
  const char *words[NP_CHILD_WORDS_MAX + 1] = {p->path};
  for (int i = 0; i + 1 < NP_CHILD_WORDS_MAX && request[i]; i++) words[i + 1] = request[i];
  neph_result result = np_module_get_program(p->context, &assimp_kind, program);
  if (result) return result;
  const int error = np_child_start(program, words, &p->child);
  return error ? np_fail(p->context, NEPH_ERROR_UNSUPPORTED, "cannot start %s, which %s: %s", program,
                         assimp_kind.purpose, strerrordesc_np(error))
               : NEPH_OK;
}

neph_result np_assimp_begin(neph_context *context, const char *path, const char *const request[],
                            const np_monitor *monitor, np_assimp_process *out_process) {
  const char *reason;
  *out_process = (np_assimp_process){.context = context, .path = path, .monitor = monitor, .child.output = -1};
  neph_result result = np_file_probe(path, &reason);
  if (result) return np_fail(context, result, "%s: %s", path, reason);
  result = np_mesh_header_check(context, path);
  if (!result) result = start_program(out_process, request);
  if (!result) result = read_start(out_process);
  if (result) np_assimp_end(out_process);
  return result;
}

neph_result np_assimp_read(np_assimp_process *process, void *out_bytes, size_t count) {
  const neph_result result = np_child_read(&process->child, process->context, process->monitor, out_bytes, count);
  return result == NEPH_ERROR_BAD_FILE ? fail_by_end(process) : result;
}

void np_assimp_end(np_assimp_process *process) { np_child_end(&process->child); }

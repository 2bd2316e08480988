/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/netcdf_process.h"

#include <errno.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <stdbool.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "core/alloc.h"
#include "core/child.h"
#include "core/module.h"
#include "core/text.h"
#include "core/text_copy.h"
#include "volume/netcdf_stream.h"

static const np_module_kind reader_kind = {.file = NP_NETCDF_PROGRAM_FILE, .purpose = "reads NetCDF files of HDF5"};

bool np_netcdf_process_is_present(neph_context *context) { return np_module_has_program(context, &reader_kind); }

/* The process of a file, in the place of the module's np_netcdf_file. The table's functions take constant files. */
typedef struct netcdf_link {
  neph_context *context;     /* borrowed, as is the monitor */
  const np_monitor *monitor; /* monitor that can cancel the reading; NULL: none */
  np_child child;
  int requests; /* socket to its input; -1: the process has ended */
  int variable_count;
  np_netcdf_error end; /* reason of the end, which all later calls repeat */
} netcdf_link;

static netcdf_link *get_link(const np_netcdf_file *file) { return (netcdf_link *)(uintptr_t)file; }

/* ---- The end of a process ---- */

static void end(netcdf_link *link) {
  if (link->requests >= 0) close(link->requests);
  link->requests = -1;
  np_child_end(&link->child);
}

/* Ends the process with a message, or the message of its first end. */
static neph_result fail(netcdf_link *link, neph_result result, const char *message, np_netcdf_error *error) {
  if (link->requests >= 0) {
    link->end.result = result;
    np_text_copy_short(link->end.message, sizeof link->end.message, message);
  }
  end(link);
  *error = link->end;
  return error->result;
}

/* Whether the process ends by itself within a second: after a crash its output closes a little before it has ended. */
static bool has_ended(const netcdf_link *link) {
  enum { WAITS = 100, WAIT_NS = 10000000 };
  for (int n = 0; n < WAITS; n++) {
    siginfo_t facts = {.si_pid = 0};
    if (waitid(P_PID, (id_t)link->child.process, &facts, WEXITED | WNOHANG | WNOWAIT) || facts.si_pid) return true;
    (void)nanosleep(&(struct timespec){.tv_nsec = WAIT_NS}, NULL);
  }
  return false;
}

static neph_result fail_by_cancel(netcdf_link *link, np_netcdf_error *error) {
  return fail(link, NEPH_ERROR_CANCELLED, "cancelled", error);
}

/* The reason why a process does not answer. */
static neph_result fail_by_end(netcdf_link *link, np_netcdf_error *error) {
  char message[200];
  if (np_wait_is_cancelled(link->context, link->monitor)) return fail_by_cancel(link, error);
  const int status = link->requests >= 0 && has_ended(link) ? np_child_wait(&link->child) : -1;
  const int by = status != -1 && WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  if (!by)
    np_print(message, sizeof message,
             "cannot be read: " NP_NETCDF_PROGRAM_FILE
             " ended before it was done: the file is damaged, or the program is of another "
             "version");
  else if (by == SIGXCPU)
    np_print(message, sizeof message,
             "cannot be read: HDF5 took more than %u s and 1 s for each 10 MB: it is damaged, or convert it "
             "(nccopy -k 64-bit-offset)",
             NP_NETCDF_TIME_S);
  else
    np_print(message, sizeof message, "cannot be read: HDF5 ended by the signal SIG%s: it is damaged",
             sigabbrev_np(by) ? sigabbrev_np(by) : "");
  return fail(link, NEPH_ERROR_BAD_FILE, message, error);
}

/* Waits for the first byte of an answer. */
static neph_result wait_for_answer(netcdf_link *link, np_netcdf_error *error) {
  enum { PAUSE_MS = 50, PAUSES = NP_NETCDF_WAIT_S * 1000 / PAUSE_MS };
  for (int n = 0; n < PAUSES; n++) {
    struct pollfd output = {.fd = link->child.output, .events = POLLIN};
    if (np_wait_is_cancelled(link->context, link->monitor)) return fail_by_cancel(link, error);
    if (poll(&output, 1, PAUSE_MS) > 0) return NEPH_OK;
  }
  char message[120];
  np_print(message, sizeof message, "cannot be read: HDF5 has not answered for %d s: it is damaged, or convert it",
           NP_NETCDF_WAIT_S);
  return fail(link, NEPH_ERROR_BAD_FILE, message, error);
}

/* ---- Requests ---- */

/* Without a signal where the process has ended. */
static bool send_all(int to, const void *bytes, size_t count) {
  for (const char *from = bytes; count > 0;) {
    const ssize_t sent = send(to, from, count, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    from += sent;
    count -= (size_t)sent;
  }
  return true;
}

/* Sends a request, and the bytes of a file after it; receives up to `capacity` bytes of the answer. */
static neph_result ask(netcdf_link *link, np_netcdf_request *request, const void *bytes, void *out, size_t capacity,
                       int *out_value, np_netcdf_error *error) {
  np_netcdf_reply reply;
  request->version = NP_NETCDF_STREAM_VERSION;
  if (link->requests < 0) return fail(link, NEPH_ERROR_BAD_FILE, "", error);
  bool is_sent = send_all(link->requests, request, sizeof *request);
  if (is_sent && bytes) is_sent = send_all(link->requests, bytes, request->byte_count);
  if (!is_sent) return fail_by_end(link, error);
  if (wait_for_answer(link, error)) return error->result;
  if (np_child_read(&link->child, link->context, link->monitor, &reply, sizeof reply)) return fail_by_end(link, error);
  reply.error.message[sizeof reply.error.message - 1] = '\0';
  *error = reply.error;
  if (error->result) return error->result;
  if (reply.byte_count != capacity || np_child_read(&link->child, link->context, link->monitor, out, capacity))
    return fail_by_end(link, error);
  *out_value = reply.value;
  return NEPH_OK;
}

static neph_result ask_file(const np_netcdf_file *file, np_netcdf_request request, void *out, size_t capacity,
                            np_netcdf_error *error) {
  int ignored;
  return ask(get_link(file), &request, NULL, out, capacity, &ignored, error);
}

/* ---- Opening ---- */

/* A socket in place of a pipe: writing to a process that has ended must not end this one. */
static neph_result start(neph_context *context, const char *path, netcdf_link *link, np_netcdf_error *error) {
  char program[PATH_MAX];
  int ends[2];
  const char *const words[] = {path, NULL};
  *error = (np_netcdf_error){.result = np_module_get_program(context, &reader_kind, program)};
  if (error->result) return error->result;
  int failure = socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) ? errno : 0;
  if (!failure) {
    link->requests = ends[0];
    failure = np_child_start_on(program, words, ends[1], &link->child);
    close(ends[1]);
  }
  if (!failure) return NEPH_OK;
  np_print(error->message, sizeof error->message, "cannot be read: " NP_NETCDF_PROGRAM_FILE " does not start: %s",
           strerrordesc_np(failure));
  return error->result = NEPH_ERROR_UNSUPPORTED;
}

static void close_file(np_netcdf_file *file) {
  netcdf_link *link = get_link(file);
  if (!link) return;
  end(link);
  np_alloc_free(link->context, link);
}

neph_result np_netcdf_process_open(neph_context *context, const np_monitor *monitor, const char *path,
                                   const void *memory, size_t byte_count, np_netcdf_file **out_file,
                                   np_netcdf_error *error) {
  np_netcdf_request request = {.question = NP_NETCDF_OPEN, .byte_count = memory ? byte_count : 0};
  netcdf_link *link = np_alloc(context, 1, sizeof *link);
  *out_file = NULL;
  *error = (np_netcdf_error){.result = NEPH_ERROR_OUT_OF_MEMORY, .message = "cannot be opened: out of memory"};
  if (!link) return error->result;
  *link = (netcdf_link){.context = context, .monitor = monitor, .child.output = -1, .requests = -1};
  neph_result result = start(context, path, link, error);
  if (!result) result = ask(link, &request, memory, NULL, 0, &link->variable_count, error);
  if (result)
    close_file((np_netcdf_file *)link);
  else
    *out_file = (np_netcdf_file *)link;
  return result;
}

bool np_netcdf_process_has_ended(const np_netcdf_file *file) { return get_link(file)->requests < 0; }

/* ---- The table ---- */

static int count_variables(const np_netcdf_file *file) { return get_link(file)->variable_count; }

static neph_result describe(const np_netcdf_file *file, int variable, np_netcdf_variable *out, np_netcdf_error *error) {
  memset(out, 0, sizeof *out);
  const np_netcdf_request request = {.question = NP_NETCDF_DESCRIBE, .number = variable};
  const neph_result result = ask_file(file, request, out, sizeof *out, error);
  out->name[sizeof out->name - 1] = '\0';
  if (!result && out->rank > NP_NETCDF_RANK_MAX) out->rank = -1;
  return result;
}

static neph_result name_dimension(const np_netcdf_file *file, int dimension, char out_name[NP_NETCDF_NAME_BYTES],
                                  np_netcdf_error *error) {
  char text[NP_NETCDF_TEXT_BYTES] = "";
  const np_netcdf_request request = {.question = NP_NETCDF_NAME_DIMENSION, .number = dimension};
  const neph_result result = ask_file(file, request, text, sizeof text, error);
  memcpy(out_name, text, NP_NETCDF_NAME_BYTES);
  out_name[NP_NETCDF_NAME_BYTES - 1] = '\0';
  return result;
}

/* Whether the file has an attribute; none where the process has ended, whose next call of another kind fails. */
static int ask_attribute(const np_netcdf_file *file, np_netcdf_question question, int variable, const char *name,
                         void *out, size_t capacity) {
  np_netcdf_request request = {.question = question, .number = variable};
  np_netcdf_error ignored;
  int is_found = 0;
  np_text_copy_short(request.name, sizeof request.name, name);
  return !ask(get_link(file), &request, NULL, out, capacity, &is_found, &ignored) && is_found;
}

static int read_text(const np_netcdf_file *file, int variable, const char *name, char *out_text, size_t capacity) {
  char text[NP_NETCDF_TEXT_BYTES] = "";
  const int is_found = ask_attribute(file, NP_NETCDF_READ_TEXT, variable, name, text, sizeof text);
  text[sizeof text - 1] = '\0';
  np_text_copy_short(out_text, capacity, is_found ? text : "");
  return is_found;
}

static int read_number(const np_netcdf_file *file, int variable, const char *name, double *out_number) {
  *out_number = 0.0;
  return ask_attribute(file, NP_NETCDF_READ_NUMBER, variable, name, out_number, sizeof *out_number);
}

static neph_result read_values(const np_netcdf_file *file, int variable, const size_t *starts, const size_t *counts,
                               double *out_values, np_netcdf_error *error) {
  np_netcdf_variable info;
  np_netcdf_request request = {.question = NP_NETCDF_READ, .number = variable, .byte_count = sizeof *out_values};
  const neph_result result = describe(file, variable, &info, error);
  if (result) return result;
  for (int d = 0; d < info.rank && d < NP_NETCDF_RANK_MAX; d++) {
    request.starts[d] = starts[d];
    request.counts[d] = counts[d];
    request.byte_count *= counts[d];
  }
  return ask_file(file, request, out_values, request.byte_count, error);
}

const np_netcdf_module np_netcdf_process_table = {.version = NP_NETCDF_MODULE_VERSION,
                                                  .close = close_file,
                                                  .count = count_variables,
                                                  .describe = describe,
                                                  .name_dimension = name_dimension,
                                                  .read_text = read_text,
                                                  .read_number = read_number,
                                                  .read = read_values};

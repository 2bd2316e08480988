/* SPDX-License-Identifier: Apache-2.0 */
/* The program nephos_netcdf_reader (netcdf_stream.h). It limits its memory by the file and by what is requested, and
 * the CPU time of each request, and ends with the library's process. */
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/mapped_bytes.h"
#include "core/text_copy.h"
#include "volume/netcdf_stream.h"

typedef struct reader {
  const char *path;
  const np_netcdf_module *table;
  np_netcdf_file *file;
  uint64_t file_bytes, mapped_bytes; /* size of the file, and of the program before it opens one */
} reader;

/* ---- Limits ---- */

static void set_limit(int resource, uint64_t wanted) {
  struct rlimit limit;
  if (getrlimit((__rlimit_resource_t)resource, &limit)) return;
  limit.rlim_cur = wanted < limit.rlim_max ? wanted : limit.rlim_max;
  (void)setrlimit((__rlimit_resource_t)resource, &limit);
}

static uint64_t get_used_s(void) {
  struct rusage usage;
  return getrusage(RUSAGE_SELF, &usage) ? 0 : (uint64_t)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec);
}

static void limit_request(const reader *r, uint64_t answer_bytes) {
  set_limit(RLIMIT_AS,
            r->mapped_bytes + NP_NETCDF_ROOM_BYTES + NP_NETCDF_ROOM_FACTOR * r->file_bytes + 2 * answer_bytes);
  set_limit(RLIMIT_CPU, get_used_s() + NP_NETCDF_TIME_S + r->file_bytes / NP_NETCDF_TIME_BYTES_PER_S);
}

/* ---- Streams ---- */

/* Whether all bytes came. The input ends where the library closes the file. */
static int get(void *bytes, size_t count) { return fread(bytes, 1, count, stdin) == count; }

static void put(const np_netcdf_reply *reply, const void *bytes) {
  (void)fwrite(reply, sizeof *reply, 1, stdout);
  if (!reply->error.result) (void)fwrite(bytes, 1, reply->byte_count, stdout);
  if (fflush(stdout)) _exit(EXIT_FAILURE);
}

static void fail(np_netcdf_reply *reply, neph_result result, const char *message) {
  reply->error.result = result;
  np_text_copy_short(reply->error.message, sizeof reply->error.message, message);
}

/* ---- Requests ---- */

/* The bytes of a file in memory stay for as long as the program runs. */
static void open_file(reader *r, const np_netcdf_request *request, np_netcdf_reply *reply) {
  struct stat facts;
  r->file_bytes = request->byte_count ? request->byte_count : stat(r->path, &facts) ? 0 : (uint64_t)facts.st_size;
  limit_request(r, 0);
  char *bytes = request->byte_count ? malloc(request->byte_count) : NULL;
  if (request->byte_count && !bytes) {
    fail(reply, NEPH_ERROR_OUT_OF_MEMORY, "cannot be opened: out of memory");
    return;
  }
  if (bytes && !get(bytes, request->byte_count)) _exit(EXIT_FAILURE);
  if (!r->table->open(r->path, bytes, request->byte_count, &r->file, &reply->error))
    reply->value = r->table->count(r->file);
}

static size_t count_numbers(const reader *r, const np_netcdf_request *request) {
  np_netcdf_variable variable;
  np_netcdf_error ignored;
  size_t count = 1;
  if (r->table->describe(r->file, request->number, &variable, &ignored)) return 0;
  for (int d = 0; d < variable.rank; d++) count *= request->counts[d];
  return count;
}

static void read_numbers(const reader *r, const np_netcdf_request *request, np_netcdf_reply *reply, double **out) {
  limit_request(r, request->byte_count);
  reply->byte_count = request->byte_count;
  *out = malloc(request->byte_count);
  if (!*out)
    fail(reply, NEPH_ERROR_OUT_OF_MEMORY, "values cannot be read: out of memory");
  else if (count_numbers(r, request) * sizeof **out != request->byte_count)
    fail(reply, NEPH_ERROR_BAD_FILE, "values cannot be read: a variable has another size than before");
  else
    r->table->read(r->file, request->number, request->starts, request->counts, *out, &reply->error);
}

static void answer(reader *r, const np_netcdf_request *request) {
  union {
    np_netcdf_variable variable;
    char text[NP_NETCDF_TEXT_BYTES];
    double number;
  } small;
  np_netcdf_reply reply = {.error.result = NEPH_OK};
  double *numbers = NULL;
  const int number = request->number;
  memset(&small, 0, sizeof small);
  limit_request(r, 0);
  switch (request->question) {
  case NP_NETCDF_OPEN:
    open_file(r, request, &reply);
    break;
  case NP_NETCDF_DESCRIBE:
    reply.byte_count = sizeof small.variable;
    r->table->describe(r->file, number, &small.variable, &reply.error);
    break;
  case NP_NETCDF_NAME_DIMENSION:
    reply.byte_count = sizeof small.text;
    r->table->name_dimension(r->file, number, small.text, &reply.error);
    break;
  case NP_NETCDF_READ_TEXT:
    reply.byte_count = sizeof small.text;
    reply.value = r->table->read_text(r->file, number, request->name, small.text, sizeof small.text);
    break;
  case NP_NETCDF_READ_NUMBER:
    reply.byte_count = sizeof small.number;
    reply.value = r->table->read_number(r->file, number, request->name, &small.number);
    break;
  case NP_NETCDF_READ:
    read_numbers(r, request, &reply, &numbers);
    break;
  }
  put(&reply, numbers ? (const void *)numbers : (const void *)&small);
  free(numbers);
}

/* ---- The library's end ---- */

/* Ends the program when the library's end of the input closes, also amid a request: HDF5 may be busy for long. */
static void *watch_input(void *unused) {
  struct pollfd input = {.fd = STDIN_FILENO, .events = 0};
  (void)unused;
  while (poll(&input, 1, -1) <= 0) continue;
  _exit(EXIT_SUCCESS);
}

static void start_watch(void) {
  pthread_t ignored;
  (void)pthread_create(&ignored, NULL, watch_input, NULL);
}

int main(int count, char **words) {
  np_netcdf_request request;
  if (count != 2) {
    (void)fprintf(stderr, NP_NETCDF_PROGRAM_FILE ": reads NetCDF for libnephos, and is not run by hand\n");
    return EXIT_FAILURE;
  }
  set_limit(RLIMIT_CORE, 0);
  start_watch();
  reader r = {.path = words[1], .table = nephos_netcdf_module(), .mapped_bytes = np_mapped_bytes_get()};
  while (get(&request, sizeof request)) {
    const int is_first = request.question == NP_NETCDF_OPEN;
    if (request.version != NP_NETCDF_STREAM_VERSION || is_first != !r.file) _exit(EXIT_FAILURE);
    answer(&r, &request);
  }
  _exit(EXIT_SUCCESS);
}

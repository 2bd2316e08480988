/* SPDX-License-Identifier: Apache-2.0 */
/* Share of the machine that this process may use: CPUs by its affinity mask, memory by the machine's and the process's
 * limits, and both by the quotas of its control group, which containers and batch systems set. */
#include <limits.h>
#include <sched.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include "core/context_private.h"
#include "core/parallel.h"
#include "core/text.h"

/* ---- Control groups ---- */

/* Copies the name of the process's control group, such as "/batch/job7", to `group`; empty when there is none. */
static void read_group(char *group, size_t size) {
  group[0] = '\0';
  FILE *file = fopen("/proc/self/cgroup", "r");
  if (!file) return;
  char line[1024];
  while (fgets(line, sizeof line, file)) {
    if (strncmp(line, "0::/", 4)) continue;
    line[strcspn(line, "\n")] = '\0';
    np_print(group, size, "%s", line + 3);
  }
  fclose(file);
}

/* Least value of the file `name` in the group and its ancestors, parsed by `read`. */
static uint64_t read_quota(const char *name, uint64_t (*read)(const char *path)) {
  char group[1024], path[1200];
  read_group(group, sizeof group);
  uint64_t least = UINT64_MAX;
  for (;;) {
    np_print(path, sizeof path, "/sys/fs/cgroup%s/%s", group, name);
    const uint64_t quota = read(path);
    if (quota < least) least = quota;
    char *slash = strrchr(group, '/');
    if (!slash) return least;
    *slash = '\0';
  }
}

/* ---- CPUs ---- */

static unsigned count_by_affinity(void) {
  cpu_set_t set;
  if (!sched_getaffinity(0, sizeof set, &set)) return (unsigned)CPU_COUNT(&set);
  long online = sysconf(_SC_NPROCESSORS_ONLN); /* fallback for more CPUs than a cpu_set_t has bits */
  return online > 0 ? (unsigned)online : 1;
}

/* Number of CPUs in the cgroup-2 file `path`, rounded up; UINT64_MAX: no quota. */
static uint64_t read_cpus(const char *path) {
  FILE *file = fopen(path, "r");
  if (!file) return UINT64_MAX;
  long long quota_us = 0, period_us = 0;
  int fields = fscanf(file, "%lld %lld", &quota_us, &period_us); /* "max 100000" yields no field */
  fclose(file);
  if (fields != 2 || quota_us <= 0 || period_us <= 0) return UINT64_MAX;
  return (uint64_t)(quota_us / period_us + (quota_us % period_us != 0));
}

unsigned np_cpu_count(void) {
  const uint64_t affinity = count_by_affinity(), quota = read_quota("cpu.max", read_cpus);
  return (unsigned)(quota < affinity ? quota : affinity);
}

double np_cpu_time_s(void) {
  struct rusage usage;
  if (getrusage(RUSAGE_SELF, &usage)) return 0.0;
  const struct timeval *user = &usage.ru_utime, *kernel = &usage.ru_stime;
  return (double)(user->tv_sec + kernel->tv_sec) + 1e-6 * (double)(user->tv_usec + kernel->tv_usec);
}

/* Value of a line "key : value" of /proc/cpuinfo; empty for other keys. */
static void read_fact(const char *line, const char *key, char *out, size_t size) {
  const char *value = strchr(line, ':');
  const size_t length = strlen(key);
  if (*out || !value || strncmp(line, key, length) || (line[length] != '\t' && line[length] != ' ')) return;
  value += 1 + strspn(value + 1, " ");
  np_print_short(out, size, value);
}

void np_cpu_name(char *out, size_t size) {
  char line[1024], name[48] = "", model[8] = "", step[8] = "";
  out[0] = '\0';
  FILE *file = fopen("/proc/cpuinfo", "r");
  if (!file) return;
  while (fgets(line, sizeof line, file) && !*step) {
    line[strcspn(line, "\n")] = '\0';
    read_fact(line, "model name", name, sizeof name);
    read_fact(line, "model", model, sizeof model);
    read_fact(line, "stepping", step, sizeof step);
  }
  fclose(file);
  if (*name) np_print(out, size, "%s, model %s.%s", name, model, step);
}

/* ---- Memory ---- */

/* Bytes in the cgroup-2 file `path`; UINT64_MAX: no quota. */
static uint64_t read_bytes(const char *path) {
  FILE *file = fopen(path, "r");
  if (!file) return UINT64_MAX;
  unsigned long long bytes = 0;
  int fields = fscanf(file, "%llu", &bytes); /* "max" yields no field */
  fclose(file);
  return fields == 1 ? bytes : UINT64_MAX;
}

/* Soft limit of a resource; UINT64_MAX: none. */
static uint64_t get_limit(int resource) {
  struct rlimit limit;
  const bool is_limited = !getrlimit(resource, &limit) && limit.rlim_cur != RLIM_INFINITY;
  return is_limited ? limit.rlim_cur : UINT64_MAX;
}

uint64_t np_memory_size(void) {
  const long pages = sysconf(_SC_PHYS_PAGES), page_bytes = sysconf(_SC_PAGESIZE);
  uint64_t size = pages > 0 && page_bytes > 0 ? (uint64_t)pages * (uint64_t)page_bytes : UINT64_MAX;
  const uint64_t quota = read_quota("memory.max", read_bytes);
  const uint64_t limit = get_limit(RLIMIT_AS);
  if (quota < size) size = quota;
  return limit < size ? limit : size;
}

bool np_memory_has_room(uint64_t bytes) {
  void *room = mmap(NULL, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room == MAP_FAILED) return false;
  munmap(room, bytes);
  return true;
}

unsigned np_foreign_thread_count(const neph_context *context) {
  return get_limit(RLIMIT_AS) < UINT64_MAX ? 1 : context->thread_count;
}

/* Stack size of a thread as glibc chooses it on x86-64: the limit on the stack, or 2 MiB without one, and a guard
 * page. */
uint64_t np_thread_stack_bytes(void) {
  const uint64_t limit = get_limit(RLIMIT_STACK), fallback = 2 << 20, guard = 4096;
  return (limit < UINT64_MAX ? limit : fallback) + guard;
}

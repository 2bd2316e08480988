/* SPDX-License-Identifier: Apache-2.0 */
/* How many CPUs this process may keep busy: its affinity mask, and the quota of its control group, which is what a
 * container or a batch system sets. */
#include <limits.h>
#include <sched.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "core/parallel.h"

static unsigned count_by_affinity(void) {
  cpu_set_t set;
  if (!sched_getaffinity(0, sizeof set, &set)) return (unsigned)CPU_COUNT(&set);
  long online = sysconf(_SC_NPROCESSORS_ONLN); /* more CPUs than a cpu_set_t has bits */
  return online > 0 ? (unsigned)online : 1;
}

/* CPUs that the cgroup-2 file `path` grants, rounded up; UINT_MAX when it sets no quota. */
static unsigned read_quota(const char *path) {
  FILE *file = fopen(path, "r");
  if (!file) return UINT_MAX;
  long long quota_us = 0, period_us = 0;
  int fields = fscanf(file, "%lld %lld", &quota_us, &period_us); /* "max 100000" yields no field */
  fclose(file);
  if (fields != 2 || quota_us <= 0 || period_us <= 0) return UINT_MAX;
  long long cpus = quota_us / period_us + (quota_us % period_us != 0);
  return cpus < UINT_MAX ? (unsigned)cpus : UINT_MAX;
}

/* Copies the process's own group, such as "/batch/job7", to `group`; empty when there is none. */
static void read_group(char *group, size_t size) {
  group[0] = '\0';
  FILE *file = fopen("/proc/self/cgroup", "r");
  if (!file) return;
  char line[1024];
  while (fgets(line, sizeof line, file)) {
    if (strncmp(line, "0::/", 4)) continue;
    line[strcspn(line, "\n")] = '\0';
    snprintf(group, size, "%s", line + 3);
  }
  fclose(file);
}

/* The smallest quota of the group and of those that hold it. */
static unsigned count_by_quota(void) {
  char group[1024], path[1200];
  read_group(group, sizeof group);
  unsigned count = UINT_MAX;
  for (;;) {
    snprintf(path, sizeof path, "/sys/fs/cgroup%s/cpu.max", group);
    unsigned quota = read_quota(path);
    if (quota < count) count = quota;
    char *slash = strrchr(group, '/');
    if (!slash) return count;
    *slash = '\0';
  }
}

unsigned np_cpu_count(void) {
  unsigned affinity = count_by_affinity(), quota = count_by_quota();
  return quota < affinity ? quota : affinity;
}

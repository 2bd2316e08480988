/* SPDX-License-Identifier: Apache-2.0 */
/* Address space of this process, for programs that limit what a file may add to it: their own mappings are not counted,
 * since those of a sanitizer are terabytes. */
#ifndef NP_CORE_MAPPED_BYTES_H
#define NP_CORE_MAPPED_BYTES_H

#include <stdint.h>
#include <stdio.h>
#include <unistd.h>

/* 0: unknown. */
static inline uint64_t np_mapped_bytes_get(void) {
  unsigned long long pages = 0;
  FILE *file = fopen("/proc/self/statm", "r");
  if (!file || fscanf(file, "%llu", &pages) != 1) pages = 0;
  if (file) fclose(file);
  return pages * (uint64_t)sysconf(_SC_PAGESIZE);
}

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of a test program that is long, for several cores: "I/N" is the I-th of N. */
#ifndef NP_TEST_SHARDS_H
#define NP_TEST_SHARDS_H

#include <stdio.h>
#include <stdlib.h>

#include "test_support.h"

typedef struct test_shard {
  size_t first, step; /* numbers first, first + step, … belong to it */
} test_shard;

/* False: `text` is no shard. */
static inline bool test_shard_read(const char *text, test_shard *out) {
  size_t number, count;
  char end;
  if (sscanf(text, "%zu/%zu%c", &number, &count, &end) != 2 || number < 1 || number > count) return false;
  *out = (test_shard){number - 1, count};
  return true;
}

/* Runs the tests of a shard; returns the number that failed. */
static inline int test_shard_run(test_shard shard, const struct CMUnitTest *tests, size_t count) {
  struct CMUnitTest *own = calloc(count, sizeof *own);
  size_t own_count = 0;
  if (!own) abort();
  for (size_t n = shard.first; n < count; n += shard.step) own[own_count++] = tests[n];
  const int failed = _cmocka_run_group_tests("shard", own, own_count, NULL, NULL);
  free(own);
  return failed;
}

#endif

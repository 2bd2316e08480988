/* SPDX-License-Identifier: Apache-2.0 */
/* A file of a time zone: offsets before, between and behind its changes, and of local times. */
#include <stdlib.h>

#include "fuzz_support.h"

#include "core/alloc.h"
#include "core/time_zone.h"

enum { OFFSET_MAX_S = 26 * 3600 };

static void expect_offset(int offset_s) {
  if (offset_s < -OFFSET_MAX_S || offset_s > OFFSET_MAX_S) abort();
}

static void look_up(const np_time_zone *zone) {
  static const int64_t times[] = {-62135596800, -2717650800, -1, 0, 1000000000, 1782057600, 4102444800, 253402300799};
  for (size_t i = 0; i < sizeof times / sizeof *times; i++) {
    const int offset_s = np_time_zone_get_offset_s(zone, times[i]);
    expect_offset(offset_s);
    const np_zone_offsets found = np_time_zone_search(zone, times[i] + offset_s);
    if (found.count == 0) abort(); /* a clock shows that time */
    for (unsigned k = 0; k < found.count; k++)
      if (np_time_zone_get_offset_s(zone, times[i] + offset_s - found.offset_s[k]) != found.offset_s[k]) abort();
  }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  neph_context *context = fuzz_get_context();
  np_time_zone *zone;
  char *problem;
  const neph_result result = np_time_zone_parse(context, "Made", data, size, &zone, &problem);
  if ((result == NEPH_ERROR_BAD_FILE) != (problem != NULL)) abort();
  if (!result) look_up(zone);
  np_alloc_free(context, problem);
  np_time_zone_destroy(context, zone);
  return 0;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Time zones: offsets of local clocks over time, from files of the tz database (TZif, RFC 8536), without the C
 * library's zone, which is shared by a whole process. */
#ifndef NP_CORE_TIME_ZONE_H
#define NP_CORE_TIME_ZONE_H

#include "core/context_private.h"

/* Default folder of time zones. */
#define NP_TIME_ZONE_DIR "/usr/share/zoneinfo"

typedef struct np_time_zone np_time_zone;

/* Loads a zone by its name: "America/New_York". For an unknown name or an invalid file the result is
 * NEPH_ERROR_BAD_FILE without a message; `*out_problem` is the reason, which np_alloc_free frees. */
neph_result np_time_zone_load(neph_context *context, const char *name, np_time_zone **out_zone, char **out_problem);

/* Parses a zone from the bytes of its file; `name` is used in messages. */
neph_result np_time_zone_parse(neph_context *context, const char *name, const void *bytes, size_t size,
                               np_time_zone **out_zone, char **out_problem);

void np_time_zone_destroy(neph_context *context, np_time_zone *zone); /* NULL is allowed */

/* Local time minus UTC. */
int np_time_zone_get_offset_s(const np_time_zone *zone, int64_t unix_s);

/* Offsets of a local time: one in general; two, in the order of time, where the clock is set back and repeats it; none
 * where the clock is set forward and skips it: then the offsets are those before and after. */
typedef struct np_zone_offsets {
  unsigned count;
  int offset_s[2];
} np_zone_offsets;

/* `local_s` counts seconds since 1970-01-01T00:00 on the zone's clock. */
np_zone_offsets np_time_zone_search(const np_time_zone *zone, int64_t local_s);

/* Suggestion for a misspelt zone, which the caller frees; NULL: no name is near, or no memory. */
char *np_time_zone_guess(neph_context *context, const char *folder, const char *name);

#endif

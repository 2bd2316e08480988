/* SPDX-License-Identifier: Apache-2.0 */
/* Time zones: offsets of a place's clocks over time, by the files of the tz database (TZif, RFC 8536), without the C
 * library's zone, which a whole process shares. */
#ifndef NP_CORE_TIME_ZONE_H
#define NP_CORE_TIME_ZONE_H

#include "core/context_private.h"

/* The folder of a context that names none. */
#define NP_TIME_ZONE_DIR "/usr/share/zoneinfo"

typedef struct np_time_zone np_time_zone;

/* Loads a zone by its name: "America/New_York". Where the name is none, or its file is no zone's, the result is
 * NEPH_ERROR_BAD_FILE without a message, and the problem a text to be freed with np_alloc_free. */
neph_result np_time_zone_load(neph_context *context, const char *name, np_time_zone **out_zone, char **out_problem);

/* Reads a zone from the bytes of its file; `name` stands for it in problems. */
neph_result np_time_zone_parse(neph_context *context, const char *name, const void *bytes, size_t size,
                               np_time_zone **out_zone, char **out_problem);

void np_time_zone_destroy(neph_context *context, np_time_zone *zone); /* NULL is allowed */

/* Local time less UTC. */
int np_time_zone_get_offset_s(const np_time_zone *zone, int64_t unix_s);

/* Offsets of a local time: one as a rule; two, in the order of time, where the clock is set back and repeats it; none
 * where the clock is set forward and skips it, and then the offsets are those before and after. */
typedef struct np_zone_offsets {
  unsigned count;
  int offset_s[2];
} np_zone_offsets;

/* `local_s` counts seconds since 1970-01-01T00:00 on the zone's clock. */
np_zone_offsets np_time_zone_search(const np_time_zone *zone, int64_t local_s);

/* The name of a zone that `name` may have been meant for, to be freed; NULL: none is near, or no memory. */
char *np_time_zone_guess(neph_context *context, const char *folder, const char *name);

#endif

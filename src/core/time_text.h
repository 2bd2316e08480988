/* SPDX-License-Identifier: Apache-2.0 */
/* Times as text: date, time and zone. */
#ifndef NP_CORE_TIME_TEXT_H
#define NP_CORE_TIME_TEXT_H

#include "core/context_private.h"

typedef struct np_time {
  double unix_s;   /* seconds since 1970-01-01T00:00Z, leap seconds not counted */
  bool has_zone;   /* the text has a zone; otherwise UTC is assumed */
  double offset_s; /* local time minus UTC */
} np_time;

/* Reads YYYY-MM-DD, T or a space, hh:mm, then :ss and a fraction if wanted, then Z, an offset such as +05:30, +0530 or
 * -04, or the name of a time zone; none is UTC.
 *
 * For an invalid text the result is NEPH_ERROR_INVALID_ARGUMENT without a message, `*out_time` stays, and the
 * problem is a text to be freed with np_alloc_free: "the month is 13, must be in [1, 12]". */
neph_result np_time_parse(neph_context *context, const char *text, np_time *out_time, char **out_problem);

/* Length of a moment in UTC to the millisecond: "2026-06-21T04:00:12.345Z". */
enum { NP_TIME_TEXT_SIZE = 96 };
void np_time_format(double unix_s, char out[NP_TIME_TEXT_SIZE]);

/* Prints an offset in the syntax of times: "-04:00", and "-04:56:02" for zones before standard time. */
void np_time_format_offset(int offset_s, char out[NP_TIME_TEXT_SIZE]);

#endif

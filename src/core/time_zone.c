/* SPDX-License-Identifier: Apache-2.0 */
/* Time zones from the bytes of their files (TZif: RFC 8536), of version 1 and above.
 *
 * A file is a header, a block of 4-byte times, and, from version 2 on, a second header, a block of 8-byte times, and a
 * rule between line ends, which holds from the last change on. A block is the changes' times, the type of each, the
 * types (offset, summer time or not, name), the letters of names, and leap seconds and two lists of flags, which
 * offsets do not depend on.
 */
#include "core/time_zone.h"

#include <string.h>

#include "core/alloc.h"
#include "core/calendar.h"
#include "core/time_zone_rule.h"

enum { HEADER_SIZE = 44, TYPE_SIZE = 6, RULE_SIZE = 128, OFFSET_MAX_S = 26 * 3600 };

/* Limit of times in seconds, far from where calendars overflow. */
static const int64_t time_max = INT64_C(1) << 60;

struct np_time_zone {
  int first_s; /* offset before the first change */
  size_t change_count;
  np_clock_change *changes; /* changes in ascending order */
  bool has_rule;            /* a rule follows the last change */
  np_time_rule rule;
};

typedef struct zone_reader {
  neph_context *context;
  const char *name;
  const unsigned char *at, *end;
  char **out_problem;
} zone_reader;

/* Counts in a header, in their order. */
enum { COUNT_UTC, COUNT_STANDARD, COUNT_LEAP, COUNT_TIME, COUNT_TYPE, COUNT_LETTER, COUNT_COUNT };

typedef struct zone_header {
  unsigned char version; /* 0, or a digit */
  uint64_t count[COUNT_COUNT];
} zone_header;

/* ---- Messages ---- */

static neph_result refuse(const zone_reader *r, const char *reason) {
  *r->out_problem = np_alloc_printf(
      r->context,
      "the file of the time zone %s is invalid: %s; reinstall the package tzdata, or write an offset such as +02:00",
      r->name, reason);
  return *r->out_problem ? NEPH_ERROR_BAD_FILE : NEPH_ERROR_OUT_OF_MEMORY;
}

/* ---- Bytes ---- */

static uint64_t get_unsigned(const unsigned char *bytes, int count) {
  uint64_t value = 0;
  for (int i = 0; i < count; i++) value = value << 8 | bytes[i];
  return value;
}

static int64_t get_time(const unsigned char *bytes, unsigned size) {
  const uint64_t value = get_unsigned(bytes, (int)size);
  return size == 4 ? (int32_t)(uint32_t)value : (int64_t)value;
}

static size_t count_left(const zone_reader *r) { return (size_t)(r->end - r->at); }

static neph_result read_header(zone_reader *r, zone_header *out) {
  if (count_left(r) < HEADER_SIZE || memcmp(r->at, "TZif", 4) != 0) return refuse(r, "it has no header of TZif");
  out->version = r->at[4];
  for (int i = 0; i < COUNT_COUNT; i++) out->count[i] = get_unsigned(r->at + 20 + 4 * i, 4);
  r->at += HEADER_SIZE;
  return NEPH_OK;
}

/* Bytes of a block. The sum of 32-bit counts times at most 12 bytes does not overflow. */
static uint64_t count_block_bytes(const zone_header *h, unsigned time_size) {
  const uint64_t *n = h->count;
  return n[COUNT_TIME] * (time_size + 1) + n[COUNT_TYPE] * TYPE_SIZE + n[COUNT_LETTER] +
         n[COUNT_LEAP] * (time_size + 4) + n[COUNT_STANDARD] + n[COUNT_UTC];
}

static neph_result check_header(const zone_reader *r, const zone_header *h, unsigned time_size) {
  const uint64_t *n = h->count;
  if (count_block_bytes(h, time_size) > count_left(r)) return refuse(r, "its header counts more than it holds");
  if (n[COUNT_TYPE] == 0 || n[COUNT_TYPE] > 256) return refuse(r, "it has no offset, or more than 256");
  if (n[COUNT_LEAP] > 0) return refuse(r, "its times count leap seconds, which those of scenes do not");
  return NEPH_OK;
}

/* ---- Block ---- */

static int get_type_offset_s(const unsigned char *types, unsigned index) {
  return (int32_t)(uint32_t)get_unsigned(types + (size_t)TYPE_SIZE * index, 4);
}

static neph_result check_offsets(const zone_reader *r, const unsigned char *types, unsigned count) {
  for (unsigned i = 0; i < count; i++) {
    const int offset_s = get_type_offset_s(types, i);
    if (offset_s < -OFFSET_MAX_S || offset_s > OFFSET_MAX_S) return refuse(r, "an offset is beyond 26 hours");
  }
  return NEPH_OK;
}

static neph_result read_changes(const zone_reader *r, const unsigned char *times, unsigned time_size,
                                const zone_header *h, np_time_zone *zone) {
  const size_t count = (size_t)h->count[COUNT_TIME];
  const unsigned char *indices = times + count * time_size, *types = indices + count;
  neph_result result = check_offsets(r, types, (unsigned)h->count[COUNT_TYPE]);
  if (result) return result;
  zone->first_s = get_type_offset_s(types, 0);
  zone->changes = np_alloc(r->context, count, sizeof *zone->changes);
  if (!zone->changes) return NEPH_ERROR_OUT_OF_MEMORY;
  zone->change_count = count;
  for (size_t i = 0; i < count; i++) {
    const int64_t time = get_time(times + i * time_size, time_size);
    if (time < -time_max || time > time_max) return refuse(r, "a change is beyond 36 thousand million years");
    if (i > 0 && time <= zone->changes[i - 1].unix_s) return refuse(r, "its changes are not in the order of time");
    if (indices[i] >= h->count[COUNT_TYPE]) return refuse(r, "a change has an offset that is not there");
    zone->changes[i] = (np_clock_change){time, get_type_offset_s(types, indices[i])};
  }
  return NEPH_OK;
}

/* Reads the rule for times after the last change, a line at the file's end; an empty line means no rule. */
static neph_result read_rule(const zone_reader *r, np_time_zone *zone) {
  char text[RULE_SIZE];
  const unsigned char *line_end = count_left(r) > 1 ? memchr(r->at + 1, '\n', count_left(r) - 1) : NULL;
  if (!line_end || *r->at != '\n') return refuse(r, "it has no rule behind its changes");
  const size_t length = (size_t)(line_end - r->at) - 1;
  if (length == 0) return NEPH_OK;
  if (length >= sizeof text || memchr(r->at + 1, '\0', length)) return refuse(r, "its rule cannot be read");
  memcpy(text, r->at + 1, length);
  text[length] = '\0';
  if (!np_time_rule_parse(text, &zone->rule)) return refuse(r, "its rule cannot be read");
  zone->has_rule = true;
  if (zone->change_count == 0) return NEPH_OK;
  np_clock_change *last = &zone->changes[zone->change_count - 1];
  last->offset_s = np_time_rule_get_offset_s(&zone->rule, last->unix_s);
  return NEPH_OK;
}

/* Reads a zone from the block of 8-byte times, where there is one. */
static neph_result read_zone(zone_reader *r, np_time_zone *zone) {
  zone_header header;
  unsigned time_size = 4;
  neph_result result = read_header(r, &header);
  if (!result && header.version >= '2') {
    if (count_block_bytes(&header, 4) > count_left(r)) return refuse(r, "its header counts more than it holds");
    r->at += count_block_bytes(&header, 4);
    result = read_header(r, &header);
    time_size = 8;
  }
  if (!result) result = check_header(r, &header, time_size);
  if (!result) result = read_changes(r, r->at, time_size, &header, zone);
  if (result || time_size == 4) return result;
  r->at += count_block_bytes(&header, 8);
  return read_rule(r, zone);
}

neph_result np_time_zone_parse(neph_context *context, const char *name, const void *bytes, size_t size,
                               np_time_zone **out_zone, char **out_problem) {
  const unsigned char *begin = bytes;
  zone_reader r = {context, name, begin, begin + size, out_problem};
  *out_zone = NULL;
  *out_problem = NULL;
  np_time_zone *zone = np_alloc(context, 1, sizeof *zone);
  const neph_result result = zone ? read_zone(&r, zone) : NEPH_ERROR_OUT_OF_MEMORY;
  if (result)
    np_time_zone_destroy(context, zone);
  else
    *out_zone = zone;
  return result;
}

void np_time_zone_destroy(neph_context *context, np_time_zone *zone) {
  if (!zone) return;
  np_alloc_free(context, zone->changes);
  np_alloc_free(context, zone);
}

/* ---- Offsets ---- */

/* Number of changes up to and including a time. */
static size_t count_changes(const np_time_zone *zone, int64_t unix_s) {
  size_t low = 0, high = zone->change_count;
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    if (zone->changes[middle].unix_s <= unix_s)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

int np_time_zone_get_offset_s(const np_time_zone *zone, int64_t unix_s) {
  const size_t count = count_changes(zone, unix_s);
  if (count == zone->change_count && zone->has_rule) return np_time_rule_get_offset_s(&zone->rule, unix_s);
  return count ? zone->changes[count - 1].offset_s : zone->first_s;
}

/* The first change after a time. */
static bool get_next(const np_time_zone *zone, int64_t unix_s, np_clock_change *out) {
  const size_t count = count_changes(zone, unix_s);
  if (count == zone->change_count) return zone->has_rule && np_time_rule_get_next(&zone->rule, unix_s, out);
  *out = zone->changes[count];
  return true;
}

/* Searches the changes near a local time for offsets that give it. */
np_zone_offsets np_time_zone_search(const np_time_zone *zone, int64_t local_s) {
  const int64_t last_s = local_s + 2 * OFFSET_MAX_S;
  np_zone_offsets found = {.count = 0}, gap = {.count = 0};
  int64_t begin_s = local_s - 2 * OFFSET_MAX_S;
  np_clock_change next = {begin_s, np_time_zone_get_offset_s(zone, begin_s)};
  for (bool goes_on = true; goes_on;) {
    const int offset_s = next.offset_s;
    goes_on = get_next(zone, begin_s, &next) && next.unix_s <= last_s;
    const int64_t unix_s = local_s - offset_s;
    const bool is_in = unix_s >= begin_s && (!goes_on || unix_s < next.unix_s);
    if (is_in && found.count < 2) found.offset_s[found.count++] = offset_s;
    if (goes_on && next.unix_s + offset_s <= local_s && local_s < next.unix_s + next.offset_s)
      gap = (np_zone_offsets){0, {offset_s, next.offset_s}};
    begin_s = next.unix_s;
  }
  return found.count ? found : gap;
}

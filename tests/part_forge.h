/* SPDX-License-Identifier: Apache-2.0 */
/* Forged parts: places of the fields in a file, and checksums that are right again after a change. */
#ifndef NP_TESTS_PART_FORGE_H
#define NP_TESTS_PART_FORGE_H

#include <stddef.h>
#include <stdint.h>

#include <nephos/context.h>

enum { PART_FIELDS_MAX = 64 };

/* A field of a part's file: its name as messages have it, the place of its first byte, and its size. */
typedef struct part_field {
  const char *name;
  size_t at, size;
} part_field;

/* Lists the fields of a good part, those of the first channel alone; returns how many. */
unsigned part_forge_list(const uint8_t *bytes, size_t size, part_field out[PART_FIELDS_MAX]);

/* Sets the magic, the format and all checksums that can be reached: of the header, and, where that is one, of the list
 * of tiles and of each tile. */
void part_forge_mend(neph_context *context, uint8_t *bytes, size_t size);

#endif

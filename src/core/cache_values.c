/* SPDX-License-Identifier: Apache-2.0 */
/* Numbers of cache entries, checked before they are used. */
#include <string.h>

#include "core/alloc.h"
#include "core/disk_cache.h"

/* Greatest number of cells along one side of an entry; the total is limited to what memory could hold. */
static const int32_t side_max = 1 << 20;
static const uint64_t cells_max = UINT64_C(1) << 32;

bool np_cache_are_finite(const float *values, size_t count) {
  const uint32_t exponent = 0x7f800000u;
  uint32_t are_not = 0;
  for (size_t i = 0; i < count; i++) {
    uint32_t bits;
    memcpy(&bits, &values[i], sizeof bits);
    are_not |= (bits & exponent) == exponent;
  }
  return !are_not;
}

bool np_cache_are_doubles_finite(const double *values, size_t count) {
  const uint64_t exponent = UINT64_C(0x7ff0000000000000);
  uint64_t are_not = 0;
  for (size_t i = 0; i < count; i++) {
    uint64_t bits;
    memcpy(&bits, &values[i], sizeof bits);
    are_not |= (bits & exponent) == exponent;
  }
  return !are_not;
}

static bool are_halves_finite(const uint16_t *values, size_t count) {
  const unsigned exponent = 0x7c00u;
  unsigned are_not = 0;
  for (size_t i = 0; i < count; i++) are_not |= (values[i] & exponent) == exponent;
  return !are_not;
}

float *np_cache_read_floats(np_cache_entry *e, size_t count) {
  float *block = np_cache_read_block(e, count, sizeof *block);
  if (block && np_cache_read_check(e, np_cache_are_finite(block, count))) return block;
  np_alloc_free(e->context, block);
  return NULL;
}

uint16_t *np_cache_read_halves(np_cache_entry *e, size_t count) {
  uint16_t *block = np_cache_read_block(e, count, sizeof *block);
  if (block && np_cache_read_check(e, are_halves_finite(block, count))) return block;
  np_alloc_free(e->context, block);
  return NULL;
}

size_t np_cache_count_cells(const int32_t size[3]) {
  uint64_t count = 1;
  for (int a = 0; a < 3; a++) {
    if (size[a] < 1 || size[a] > side_max) return 0;
    count *= (uint64_t)size[a];
  }
  return count > cells_max ? 0 : (size_t)count;
}

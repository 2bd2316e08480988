/* SPDX-License-Identifier: Apache-2.0 */
#include "view_enlarge.h"

#include <stddef.h>

/* A place between two pixels of a line, in 256ths of their distance. */
typedef struct pixel_place {
  unsigned first, second, weight;
} pixel_place;

static pixel_place get_place(unsigned index, unsigned from_count, unsigned to_count) {
  const int64_t at = (int64_t)(2 * index + 1) * from_count * 128 / to_count - 128;
  const unsigned first = at < 0 ? 0 : (unsigned)(at >> 8);
  return (pixel_place){first, first + 1 < from_count ? first + 1 : first, at < 0 ? 0 : (unsigned)(at & 255)};
}

static uint8_t mix(unsigned a, unsigned b, unsigned weight) {
  return (uint8_t)((a * (256 - weight) + b * weight) >> 8);
}

void cli_view_enlarge(const uint8_t *from, unsigned from_width, unsigned from_height, uint8_t *to, unsigned to_width,
                      unsigned to_height) {
  const size_t stride = 4 * (size_t)from_width;
  for (unsigned y = 0; y < to_height; y++) {
    const pixel_place row = get_place(y, from_height, to_height);
    const uint8_t *upper = from + row.first * stride, *lower = from + row.second * stride;
    for (unsigned x = 0; x < to_width; x++, to += 4) {
      const pixel_place column = get_place(x, from_width, to_width);
      for (size_t k = 0; k < 4; k++) {
        const size_t left = 4 * (size_t)column.first + k, right = 4 * (size_t)column.second + k;
        to[k] = mix(mix(upper[left], upper[right], column.weight), mix(lower[left], lower[right], column.weight),
                    row.weight);
      }
    }
  }
}

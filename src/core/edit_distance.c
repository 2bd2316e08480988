/* SPDX-License-Identifier: Apache-2.0 */
#include "core/edit_distance.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

enum { NAME_MAX_LENGTH = 40 };

static size_t min3(size_t a, size_t b, size_t c) {
  size_t least = a < b ? a : b;
  return least < c ? least : c;
}

size_t np_edit_distance(const char *a, const char *b) {
  size_t m = strlen(a), n = strlen(b);
  if (m > NAME_MAX_LENGTH || n > NAME_MAX_LENGTH) return SIZE_MAX;
  size_t distance[NAME_MAX_LENGTH + 1][NAME_MAX_LENGTH + 1];
  for (size_t i = 0; i <= m; i++) distance[i][0] = i;
  for (size_t j = 0; j <= n; j++) distance[0][j] = j;
  for (size_t i = 1; i <= m; i++)
    for (size_t j = 1; j <= n; j++) {
      distance[i][j] =
          min3(distance[i - 1][j] + 1, distance[i][j - 1] + 1, distance[i - 1][j - 1] + (a[i - 1] != b[j - 1]));
      bool is_swap = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (is_swap && distance[i - 2][j - 2] + 1 < distance[i][j]) distance[i][j] = distance[i - 2][j - 2] + 1;
    }
  return distance[m][n];
}

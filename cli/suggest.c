/* SPDX-License-Identifier: Apache-2.0 */
#include "suggest.h"

#include <stdint.h>
#include <string.h>

enum { LENGTH_MAX = 32 };

/* Levenshtein distance: letters added, dropped or replaced between `a` and `b`. */
static size_t compute_distance(const char *a, const char *b) {
  size_t m = strlen(a), n = strlen(b), row[LENGTH_MAX + 1];
  if (m > LENGTH_MAX || n > LENGTH_MAX) return SIZE_MAX;
  for (size_t j = 0; j <= n; j++) row[j] = j;
  for (size_t i = 1; i <= m; i++) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= n; j++) {
      size_t best = diagonal + (a[i - 1] != b[j - 1]);
      if (row[j] + 1 < best) best = row[j] + 1;
      if (row[j - 1] + 1 < best) best = row[j - 1] + 1;
      diagonal = row[j];
      row[j] = best;
    }
  }
  return row[n];
}

const char *cli_suggest(const char *text, const char *const *names, size_t count) {
  const char *best = NULL;
  size_t best_distance = strlen(text) / 3 + 1;
  for (size_t i = 0; i < count; i++) {
    size_t distance = compute_distance(text, names[i]);
    if (distance > best_distance || (best && distance == best_distance)) continue;
    best = names[i];
    best_distance = distance;
  }
  return best;
}

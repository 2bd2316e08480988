/* SPDX-License-Identifier: Apache-2.0 */
#include "render/merge_error.h"

#include <stdio.h>
#include <string.h>

static const char *const endings[] = {"", "Min", "Max"};

bool np_merge_error_has(const char *name) {
  static const char *const figures[] = {"nephos:error", "nephos:noise", "nephos:bias"};
  for (size_t f = 0; f < sizeof figures / sizeof *figures; f++)
    for (size_t e = 0; e < sizeof endings / sizeof *endings; e++)
      if (!strncmp(name, figures[f], strlen(figures[f])) && !strcmp(name + strlen(figures[f]), endings[e])) return true;
  return false;
}

/* Share of all samples that a part has of its pixels. */
static double get_share(const np_merge_part *part) {
  return part->header.is_complete
             ? 1.0
             : (double)(part->header.sample_end - part->header.sample_begin) / part->header.sample_count;
}

static double get_pixels(const int min[2], const int max[2]) {
  return (double)(max[0] - min[0]) * (double)(max[1] - min[1]);
}

/* Mean square of a figure, its parts' squares times `share` to a power of 0 or 1; false where a part has none. */
static bool add_squares(const np_merge_part *parts, size_t count, const char *figure, const char *ending,
                        bool falls_with_samples, double *out) {
  char name[32];
  (void)snprintf(name, sizeof name, "nephos:%s%s", figure, ending);
  *out = 0.0;
  for (size_t i = 0; i < count; i++) {
    const np_image_attribute *a = np_image_search_attribute(parts[i].header.image, name);
    const double share = get_share(&parts[i]);
    if (!a) return false;
    *out += share * get_pixels(parts[i].header.min, parts[i].header.max) * a->number * a->number *
            (falls_with_samples ? share : 1.0);
  }
  *out /= get_pixels(parts[0].header.whole_min, parts[0].header.whole_max);
  return true;
}

static neph_result set_root(neph_image *image, const char *figure, const char *ending, double square) {
  char name[32];
  (void)snprintf(name, sizeof name, "nephos:%s%s", figure, ending);
  return np_image_set_real(image, name, sqrt(square));
}

neph_result np_merge_error_write(const np_merge_part *parts, size_t count, neph_image *image) {
  neph_result result = NEPH_OK;
  for (size_t e = 0; e < sizeof endings / sizeof *endings && !result; e++) {
    double noise, bias;
    const bool has_bias = add_squares(parts, count, "bias", endings[e], false, &bias);
    const bool has_noise = add_squares(parts, count, "noise", endings[e], true, &noise);
    if (has_bias) result = set_root(image, "bias", endings[e], bias);
    if (!result && has_noise) result = set_root(image, "noise", endings[e], noise);
    if (!result && has_noise && has_bias) result = set_root(image, "error", endings[e], noise + bias);
  }
  return result;
}

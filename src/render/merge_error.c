/* SPDX-License-Identifier: Apache-2.0 */
#include "render/merge_error.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define NAMES(figure)                                                                                                  \
  { figure, figure "Min", figure "Max" }

enum { ENDINGS = 3 };

/* The error of the whole follows from the other two. */
enum { ERROR, NOISE, BIAS, FIGURES };

static const char *const names[FIGURES][ENDINGS] = {
    [ERROR] = NAMES("nephos:error"), [NOISE] = NAMES("nephos:noise"), [BIAS] = NAMES("nephos:bias")};

static const char source_name[] = "nephos:biasSource";

bool np_merge_error_has(const char *name) {
  for (int f = 0; f < FIGURES; f++)
    for (int e = 0; e < ENDINGS; e++)
      if (!strcmp(name, names[f][e])) return true;
  return !strcmp(name, source_name);
}

bool np_merge_error_check(const neph_image *image, np_part_fault *fault) {
  for (int f = 0; f < FIGURES; f++)
    for (int e = 0; e < ENDINGS; e++) {
      const np_image_attribute *a = np_image_search_attribute(image, names[f][e]);
      if (a && (a->type == NP_IMAGE_TEXT || !(a->number >= 0.0) || !isfinite(a->number)))
        return np_part_fault_set(fault, "its attribute %s is \"%.64s\", must be a number that is not negative", a->name,
                                 a->value);
    }
  return true;
}

/* ---- Figures ---- */

/* Share of all samples that a part has of its pixels. */
static double get_share(const np_merge_part *part) {
  return part->header.is_complete
             ? 1.0
             : (double)(part->header.sample_end - part->header.sample_begin) / part->header.sample_count;
}

static double get_pixels(const np_merge_part *part) {
  const int *min = part->header.min, *max = part->header.max;
  return (double)(max[0] - min[0]) * (double)(max[1] - min[1]);
}

/* Mean square of a figure over the parts that state it, their squares times `share` to a power of 0 or 1; returns how
 * many those are. A part states none where no pixel of it counts, as where all is black. */
static size_t average_squares(const np_merge_part *parts, size_t count, const char *name, bool falls_with_samples,
                              double *out) {
  double sum = 0.0, weights = 0.0;
  size_t stating = 0;
  for (size_t i = 0; i < count; i++) {
    const np_image_attribute *a = np_image_search_attribute(parts[i].header.image, name);
    const double share = get_share(&parts[i]), weight = share * get_pixels(&parts[i]);
    if (!a) continue;
    sum += weight * a->number * a->number * (falls_with_samples ? share : 1.0);
    weights += weight;
    stating++;
  }
  *out = stating ? sum / weights : 0.0;
  return stating;
}

static neph_result write_figures(const np_merge_part *parts, size_t count, int ending, neph_image *image) {
  double noise, bias;
  const size_t with_bias = average_squares(parts, count, names[BIAS][ending], false, &bias),
               with_noise = average_squares(parts, count, names[NOISE][ending], true, &noise);
  neph_result result = NEPH_OK;
  if (with_bias) result = np_image_set_real(image, names[BIAS][ending], sqrt(bias));
  if (!result && with_noise) result = np_image_set_real(image, names[NOISE][ending], sqrt(noise));
  if (!result && with_noise && with_bias) result = np_image_set_real(image, names[ERROR][ending], sqrt(noise + bias));
  if (ending == 0 && with_noise && with_noise < count)
    np_log(image->context, NEPH_LOG_INFO, "the merged error is that of %zu of %zu parts: the others state none",
           with_noise, count);
  return result;
}

/* It was measured where all parts that state a source have measured it. */
static neph_result write_source(const np_merge_part *parts, size_t count, neph_image *image) {
  const char *source = NULL;
  for (size_t i = 0; i < count; i++) {
    const char *own = neph_image_get_attribute(parts[i].header.image, source_name);
    if (own && (!source || strcmp(own, "measured") != 0)) source = own;
  }
  return source ? neph_image_set_attribute(image, source_name, source) : NEPH_OK;
}

neph_result np_merge_error_write(const np_merge_part *parts, size_t count, neph_image *image) {
  neph_result result = NEPH_OK;
  for (int e = 0; e < ENDINGS && !result; e++) result = write_figures(parts, count, e, image);
  return result ? result : write_source(parts, count, image);
}

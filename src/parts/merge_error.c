/* SPDX-License-Identifier: Apache-2.0 */
#include "parts/merge_error.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define NAMES(figure)                                                                                                  \
  { figure, figure "Min", figure "Max" }

enum { ENDINGS = 3 };

/* Figures of an error. The total ERROR is the root of the sum of squares of the other two. */
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

static bool check_number(const np_image_attribute *a, np_part_fault *fault) {
  if (!a || (a->type != NP_IMAGE_TEXT && a->number >= 0.0 && isfinite(a->number))) return true;
  return np_part_fault_set(fault, "its attribute %s is \"%.64s\", must be a number that is not negative", a->name,
                           a->value);
}

/* Whether `low` is at most `high`; true if one of them is missing. */
static bool check_order(const np_image_attribute *low, const np_image_attribute *high, np_part_fault *fault) {
  if (!low || !high || low->number <= high->number) return true;
  return np_part_fault_set(fault, "its attribute %s is %g, must be at most that of %s, %g", low->name, low->number,
                           high->name, high->number);
}

bool np_merge_error_check(const neph_image *image, np_part_fault *fault) {
  for (int f = 0; f < FIGURES; f++) {
    const np_image_attribute *a[ENDINGS];
    for (int e = 0; e < ENDINGS; e++) {
      a[e] = np_image_search_attribute(image, names[f][e]);
      if (!check_number(a[e], fault)) return false;
    }
    const np_image_attribute *value = a[0], *min = a[1], *max = a[2];
    if (!check_order(min, value, fault) || !check_order(value, max, fault) || !check_order(min, max, fault))
      return false;
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

/* Mean square of a figure over the parts that state it, weighted by `share` to a power of 0 or 1; returns the number of
 * these parts. A part whose pixels are all below the luminance threshold states none. */
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

/* Averages a figure over the parts that state it. A bound that one of them lacks is omitted. */
static bool average_figure(const np_merge_part *parts, size_t count, int figure, int ending, double *out) {
  const bool is_noise = figure == NOISE;
  double unused;
  const size_t stating = average_squares(parts, count, names[figure][ending], is_noise, out);
  return stating && stating == average_squares(parts, count, names[figure][0], is_noise, &unused);
}

static void log_silent(const np_merge_part *parts, size_t count, neph_context *context) {
  double noise;
  const size_t stating = average_squares(parts, count, names[NOISE][0], true, &noise);
  if (stating && stating < count)
    np_log(context, NEPH_LOG_INFO, "the merged error is that of %zu of %zu parts: the others state none", stating,
           count);
}

static neph_result write_figures(const np_merge_part *parts, size_t count, int ending, neph_image *image) {
  double noise, bias;
  const bool has_bias = average_figure(parts, count, BIAS, ending, &bias),
             has_noise = average_figure(parts, count, NOISE, ending, &noise);
  neph_result result = NEPH_OK;
  if (has_bias) result = np_image_set_real(image, names[BIAS][ending], sqrt(bias));
  if (!result && has_noise) result = np_image_set_real(image, names[NOISE][ending], sqrt(noise));
  if (!result && has_noise && has_bias) result = np_image_set_real(image, names[ERROR][ending], sqrt(noise + bias));
  return result;
}

/* Writes the source of the bias: "measured" if all parts that name a source have measured it. */
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
  log_silent(parts, count, image->context);
  for (int e = 0; e < ENDINGS && !result; e++) result = write_figures(parts, count, e, image);
  return result ? result : write_source(parts, count, image);
}

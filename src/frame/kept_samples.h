/* SPDX-License-Identifier: Apache-2.0 */
/* Sums over the samples of a picture that a renderer keeps, so that the same picture with more samples takes the
 * further ones alone. A pixel's record is the number of its samples, and the maximal nodes of the film's tree. */
#ifndef NP_FRAME_KEPT_SAMPLES_H
#define NP_FRAME_KEPT_SAMPLES_H

#include "image/film.h"
#include "plan/plan_parts.h"

struct np_frame;

typedef struct np_kept_samples {
  neph_context *context;
  char picture[33];   /* the picture but for its number of samples; empty: none */
  uint64_t results;   /* number of results that the renderer had stored for the picture: more of them are other bits */
  unsigned numbers;   /* numbers of a node */
  size_t pixel_count; /* records, by the places of pixels in the image */
  unsigned node_max;  /* nodes for which a record has room */
  double *records;
} np_kept_samples;

void np_kept_samples_clear(np_kept_samples *kept);

/* Makes room for the samples of a frame, and drops those of another picture, or of one with more samples. Pictures
 * whose pixels have samples of their own number, or are not sampled, are not kept: `kept` is empty afterwards. */
neph_result np_kept_samples_begin(np_kept_samples *kept, const neph_scene *scene, const np_plan *plan,
                                  const struct np_frame *f);

/* The record of a pixel; NULL: none are kept. */
double *np_kept_samples_get(const np_kept_samples *kept, size_t index);

/* Adds the samples of a record to an accumulator that begins at sample 0; returns their number. */
uint32_t np_kept_samples_load(const np_kept_samples *kept, const double *record, np_film_accumulator *accumulator);

/* Fills a record with the `count` samples of an accumulator. */
void np_kept_samples_store(const np_kept_samples *kept, double *record, const np_film_accumulator *accumulator,
                           uint32_t count);

#endif

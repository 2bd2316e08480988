/* SPDX-License-Identifier: Apache-2.0 */
/* The film: per pixel a sum over samples that does not depend on how the work was divided.
 *
 * Samples are summed along a fixed binary tree over the sample index: leaves are aligned blocks of 16 samples summed in
 * order, inner nodes add two children, all in double. A pixel's samples are given in ascending order to an accumulator,
 * which holds at most one pending node per level.
 */
#ifndef NP_IMAGE_FILM_H
#define NP_IMAGE_FILM_H

#include <nephos/image.h>

#include "core/context_private.h"

enum { NP_FILM_LEAF_SAMPLES = 16, NP_FILM_CHANNELS_MAX = 64, NP_FILM_LEVELS = 28 };

/* The sum over one pixel's samples, in progress. Reused from pixel to pixel. */
typedef struct np_film_accumulator {
  unsigned channel_count;
  uint32_t sample_begin, sample_next;
  uint32_t pending; /* bit l: node of level l (16·2ˡ samples) is complete and waits for its sibling */
  double leaf[NP_FILM_CHANNELS_MAX];
  double node[NP_FILM_LEVELS][NP_FILM_CHANNELS_MAX];
} np_film_accumulator;

void np_film_accumulator_begin(np_film_accumulator *accumulator, unsigned channel_count, uint32_t sample_begin);
void np_film_accumulator_add(np_film_accumulator *accumulator, const float *values);

/* The sum of everything added, folded from the smallest pending node to the largest. */
void np_film_accumulator_finish(const np_film_accumulator *accumulator, double *out_sums);

#endif

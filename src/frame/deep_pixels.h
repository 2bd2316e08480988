/* SPDX-License-Identifier: Apache-2.0 */
/* Deep pixels: what a pixel's samples found along their rays, put into few segments.
 *
 * With ΔA the opacity and ΔL the light that a segment adds to a pixel as it is seen, means over its samples, and
 * T = 1 − Σ ΔA what is left before it, a segment by itself has the opacity ΔA/T and the light ΔL/T. So the deep pixel
 * flattens to the pixel's coverage and light, whatever the segments are. They are chosen by opacity and by gaps.
 */
#ifndef NP_FRAME_DEEP_PIXELS_H
#define NP_FRAME_DEEP_PIXELS_H

#include "image/deep.h"
#include "integrate/integrator.h"

enum { NP_DEEP_BINS_MAX = 1024 };

/* Segments of a pixel's rays, with sums over the samples taken so far. */
typedef struct np_deep_bins {
  unsigned count;
  float alpha; /* coverage of the clouds: sum */
  np_depth_record at[NP_DEEP_BINS_MAX];
} np_deep_bins;

/* Segments of a pixel that waits for more samples, as far as they go. */
typedef struct np_deep_stored {
  unsigned count;
  float alpha;
  np_depth_record *at; /* NULL without any */
} np_deep_stored;

void np_deep_bins_load(const np_deep_stored *stored, np_deep_bins *out);
neph_result np_deep_bins_store(neph_context *context, np_deep_bins *bins, np_deep_stored *stored);

/* Adds the segments of one sample. `light` and `alpha` are the sample's totals: light without a position is distributed
 * over the segments by their opacity. */
void np_deep_bins_add(np_deep_bins *bins, const np_integrator_layers *layers, np_spectrum light, float alpha);

/* Sorts segments by depth and joins neighbours until at most `count` remain. */
void np_deep_bins_reduce(np_deep_bins *bins, unsigned count_max);

/* The pixel's samples, of which there is room for NP_DEEP_SAMPLES_MAX; returns how many. Depths are distances times
 * `cosine`. */
unsigned np_deep_bins_finish(np_deep_bins *bins, unsigned sample_count, float scale, double cosine,
                             np_deep_sample *out);

#endif

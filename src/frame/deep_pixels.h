/* SPDX-License-Identifier: Apache-2.0 */
/* Deep pixels: what a pixel's samples found along their rays, put into few stretches.
 *
 * With ΔA the opacity and ΔL the light that a stretch adds to a pixel as it is seen, means over its samples, and
 * T = 1 − Σ ΔA what is left before it, a stretch by itself has the opacity ΔA/T and the light ΔL/T. So the deep pixel
 * flattens to the pixel's coverage and light, whatever the stretches are. They are chosen by opacity and by gaps.
 */
#ifndef NP_FRAME_DEEP_PIXELS_H
#define NP_FRAME_DEEP_PIXELS_H

#include "image/deep.h"
#include "integrate/integrator.h"

enum { NP_DEEP_BINS_MAX = 1024 };

/* Stretches of a pixel as its samples come in: sums over them. */
typedef struct np_deep_bins {
  unsigned count;
  float alpha; /* coverage of the clouds: sum */
  np_depth_record at[NP_DEEP_BINS_MAX];
} np_deep_bins;

/* Stretches of a pixel that waits for more samples, as far as they go. */
typedef struct np_deep_stored {
  unsigned count;
  float alpha;
  np_depth_record *at; /* NULL without any */
} np_deep_stored;

void np_deep_bins_load(const np_deep_stored *stored, np_deep_bins *out);
neph_result np_deep_bins_store(neph_context *context, np_deep_bins *bins, np_deep_stored *stored);

/* Adds what one sample found. `light` and `alpha` are the sample's in all: light that belongs to no place is spread
 * over its stretches by their opacity. */
void np_deep_bins_add(np_deep_bins *bins, const np_integrator_layers *layers, np_spectrum light, float alpha);

/* Sorts stretches by depth and joins neighbours until there are as few as that. */
void np_deep_bins_reduce(np_deep_bins *bins, unsigned count_max);

/* The pixel's samples, of which there is room for NP_DEEP_SAMPLES_MAX; returns how many. Depths are distances times
 * `cosine`. */
unsigned np_deep_bins_finish(np_deep_bins *bins, unsigned sample_count, float scale, double cosine,
                             np_deep_sample *out);

#endif

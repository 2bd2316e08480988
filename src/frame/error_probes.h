/* SPDX-License-Identifier: Apache-2.0 */
/* Pixels of a frame that are sampled again, with other seeds and by the tracer. */
#ifndef NP_FRAME_ERROR_PROBES_H
#define NP_FRAME_ERROR_PROBES_H

#include "frame/frame_state.h"

/* A figure and its standard deviation. */
typedef struct np_uncertain {
  double value, deviation;
} np_uncertain;

enum { NP_SEEDS_MAX = 32 };

/* One pixel; luminances. */
typedef struct np_error_probe {
  int at[2];
  double share;     /* share of all pixels that may count: 1/(K·N·p), p the chance that this one was chosen */
  double count;     /* samples that the frame took */
  double value;     /* the frame's own */
  double around;    /* mean of the frame's pixels around; NaN if there are none */
  double level;     /* `around`, or the mean over seeds if it is more and several have it */
  double variance;  /* variance of the frame's value over seeds */
  double scale;     /* luminance that it is relative to, by all seeds */
  double by_spread; /* relative variance as the spread of one seed's samples states it: mean over seeds */
  double half[2];   /* means over the even and the odd of the seeds */
  double traced[2]; /* the tracer's values, with two seeds */
  bool is_outlier, has_disk; /* chosen for its spread; reached by the disk of sun or moon */
  np_pixel_luminance by_seed[NP_SEEDS_MAX];
} np_error_probe;

typedef struct np_error_probes {
  unsigned count, traced_count; /* numbers of probes, and of the first ones that the path tracer has sampled */
  unsigned outlier_count;       /* pixels of the largest relative variance by their spread, after the probes */
  double dim;                   /* a hundredth of the frame's mean luminance */
  double pixel_count;           /* pixels that may count: the mean of the 3 × 3 is above `dim` */
  double bright_share;          /* share of these whose scale is above `dim` */
  double outlier_least;         /* relative variance by its spread from which a pixel counts as an outlier */
  double sum, squares;          /* over the pixels that may count, of the relative variance that their spread states */
  np_error_probe *probe;
} np_error_probes;

/* Chooses `count` pixels, noisy ones more often, and the `outlier_count` whose spread states most. */
neph_result np_error_probes_choose(const np_frame *f, unsigned count, unsigned outlier_count, np_error_probes *out);
void np_error_probes_clear(const np_frame *f, np_error_probes *probes);

/* Mean over the pixels that may count of the relative variance that their spread states. */
np_uncertain np_error_probes_average_spread(const np_error_probes *probes);

/* Samples the probes again by the frame's own method with `seed_count` further seeds, an even number of at most
 * NP_SEEDS_MAX, and the outliers with so many. */
neph_result np_error_probes_sample(const np_frame *f, unsigned seed_count, np_error_probes *probes);

/* Samples up to `probe_count` of the probes by the path tracer, `sample_count` times for each of two seeds, and moves
 * these probes to the front. */
neph_result np_error_probes_trace(const np_frame *f, unsigned probe_count, unsigned sample_count,
                                  np_error_probes *probes);

#endif

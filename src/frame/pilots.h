/* SPDX-License-Identifier: Apache-2.0 */
/* Pilots over the whole picture: samples at a sparse lattice of its pixels, with seeds of their own, by which the
 * samples of a noise are predicted and the rule of their number is set.
 *
 * Pixels and seeds follow from the view, the scene's seed and the frame's number: each tile and each part of a picture
 * gets the same rule. None of the samples enters the picture. */
#ifndef NP_FRAME_PILOTS_H
#define NP_FRAME_PILOTS_H

#include "frame/frame_state.h"

typedef struct np_pilots {
  np_sample_rule rule;
  double samples; /* mean samples of a pixel by the rule */
  double noise;   /* noise of the picture by the rule: above the given noise where `max` is too few, and below it where
                     `first` is too many */
  double noise_of_one; /* noise of the picture with one sample a pixel */
  double exponent;     /* β: N samples for every pixel leave noise_of_one²·N^-β */
  unsigned point_count;
  uint64_t sample_count; /* samples that the pilots took */
} np_pilots;

/* Samples the lattice of a frame whose channels and integrator are chosen; its tiles and planes may be missing. With a
 * `noise` of infinity it costs four samples a point, and the rule is void. */
neph_result np_pilots_fly(const np_frame *f, double noise, np_pilots *out);

/* Samples that every pixel needs for a noise of the picture, by the exponent. */
double np_pilots_predict_samples(const np_pilots *pilots, double noise);

#endif

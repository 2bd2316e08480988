/* SPDX-License-Identifier: Apache-2.0 */
/* Samples of each pixel for a noise of the whole picture, at the least cost.
 *
 * The picture's noise² is the mean of Var I/T² over its pixels (docs/error.md). A pixel of N samples has the variance
 * σ²·N^-β, so that the sum of all N is least where N is as (σ/T)^(2/(1 + β)): Neyman (1934, "On the Two Different
 * Aspects of the Representative Method") for β = 1. σ/T comes from the pilots of the eight neighbours, not from the
 * pixel's own: its number is independent of its samples, so that their mean has no bias and its pilots, which are the
 * first of them, are kept. */
#ifndef NP_FRAME_SAMPLE_COUNTS_H
#define NP_FRAME_SAMPLE_COUNTS_H

#include <stddef.h>
#include <stdint.h>

/* Luminance of a pixel's first samples. */
typedef struct np_pilot {
  float mean, squares; /* squares: Σ(x − mean)² */
  float count;         /* 0: none were taken */
} np_pilot;

/* Rule for the number of samples of each pixel; one for all pixels of a picture. */
typedef struct np_sample_rule {
  uint32_t first;       /* samples of a pilot, 1 to 16 */
  uint32_t min, max;    /* samples of a pixel; min ≥ first */
  double gain;          /* N = (gain·(σ/T)²)^power; 0: `min` for all */
  double power;         /* 1/(1 + β) */
  double dim;           /* luminance up to which a pixel's error does not count */
  double usual_spread;  /* mean of (σ/T)² over the picture, … */
  double usual_freedom; /* … and its weight, in degrees of freedom, beside the neighbours' estimates */
} np_sample_rule;

/* (σ/T)² of the pixel `at`, by the eight around it in rows of `stride` pilots. */
double np_sample_rule_estimate_spread(const np_sample_rule *rule, const np_pilot *at, size_t stride);

/* Samples for a (σ/T)²: a real number from `min` to `max`. */
double np_sample_rule_count(const np_sample_rule *rule, double spread);

/* One of the two whole numbers about it, so that their mean is it; `u` is drawn from [0, 1). */
uint32_t np_sample_rule_round(double count, double u);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* The film: per pixel a sum over samples that does not depend on how the work was divided.
 *
 * Samples are summed along a fixed binary tree over the sample index: leaves are aligned blocks of 16 samples summed in
 * order, inner nodes add two children, all in double. A pixel's samples are given in ascending order to an accumulator.
 *
 * A range of samples fills whole nodes of that tree, and at most a ragged leaf at its end; the largest of them, its
 * maximal nodes, are all that a part of the work must keep. Given in order to another accumulator, the nodes of parts
 * that cover [0, N) finish the tree with the same additions as one run, and so with the same bits. Parts must begin at
 * a multiple of 16 samples; only the last may end anywhere.
 */
#ifndef NP_IMAGE_FILM_H
#define NP_IMAGE_FILM_H

#include <nephos/image.h>

#include "core/context_private.h"

enum {
  NP_FILM_LEAF_SAMPLES = 16,
  NP_FILM_SAMPLES_MAX = 1 << 24, /* greatest number of samples of a pixel */
  NP_FILM_CHANNELS_MAX = 528,
  NP_FILM_LEVELS = 28,                       /* a node of the last level holds 2³¹ samples */
  NP_FILM_NODES_MAX = 2 * NP_FILM_LEVELS + 1 /* a left and a right node of each level, and a ragged leaf */
};

/* A complete node, or a ragged leaf. */
typedef struct np_film_node {
  uint32_t sample_begin; /* a multiple of sample_count; of 16 for a ragged leaf */
  uint32_t sample_count; /* 16·2ˡ, or below 16 for a ragged leaf */
  const double *sums;    /* channel_count of them */
} np_film_node;

/* Lists the maximal nodes of a range, without their sums, in ascending order; returns their number. */
unsigned np_film_list_nodes(uint32_t sample_begin, uint32_t sample_end, np_film_node out[NP_FILM_NODES_MAX]);

/* Accumulator of one pixel's samples, reused from pixel to pixel. */
typedef struct np_film_accumulator {
  unsigned channel_count; /* numbers of a node: sums, means, sums of squares */
  unsigned moment_count;  /* number of means, and of sums of squares after them, within channel_count */
  uint32_t sample_begin, sample_next;
  uint32_t pending; /* bit l: an even node of level l (16·2ˡ samples) is complete and waits for its sibling */
  uint32_t edge;    /* bit l: an odd node of level l whose sibling lies before sample_begin */
  double leaf[NP_FILM_CHANNELS_MAX];
  double pending_node[NP_FILM_LEVELS][NP_FILM_CHANNELS_MAX];
  double edge_node[NP_FILM_LEVELS][NP_FILM_CHANNELS_MAX];
} np_film_accumulator;

/* Starts a pixel. `sample_begin` is a multiple of 16. */
void np_film_accumulator_begin(np_film_accumulator *accumulator, unsigned channel_count, uint32_t sample_begin);

/* Starts a pixel with moments: the last `moment_count` values of a sample have mean and sum of squares in a node. */
void np_film_accumulator_begin_moments(np_film_accumulator *accumulator, unsigned sum_count, unsigned moment_count,
                                       uint32_t sample_begin);
void np_film_accumulator_add(np_film_accumulator *accumulator, const float *values);

/* Adds a complete node of a part. False, with nothing changed, if its samples do not follow the sum's, or if it is no
 * node of the tree. */
bool np_film_accumulator_add_node(np_film_accumulator *accumulator, const np_film_node *node);

/* Lists the maximal nodes in ascending order, with sums inside the accumulator; the structure depends on the range
 * alone. */
unsigned np_film_accumulator_get_nodes(const np_film_accumulator *accumulator, np_film_node out[NP_FILM_NODES_MAX]);

/* Sums all samples, folded from the last maximal node to the first. */
void np_film_accumulator_finish(const np_film_accumulator *accumulator, double *out_sums);

/* Joins a node of `left_count` samples with its sibling of `right_count` samples, into `right`. */
void np_film_accumulator_join(const np_film_accumulator *accumulator, const double *left, uint32_t left_count,
                              double *right, uint32_t right_count);

#endif

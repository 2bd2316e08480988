/* SPDX-License-Identifier: Apache-2.0 */
/* Directions and weights of the discrete ordinates, and real spherical harmonics at them. */
#ifndef NP_LIGHT_ORDINATES_H
#define NP_LIGHT_ORDINATES_H

#include "core/math.h"

enum {
  NP_OCTANT_COUNT = 8,
  NP_HARMONIC_DEGREES = 4,   /* l = 0 … 3 */
  NP_HARMONIC_COUNT = 16,    /* (l, m) up to l = 3 */
  NP_ORDINATE_LANES = 8,     /* directions of one octant that are swept together */
  NP_ORDINATE_BLOCKS_MAX = 2 /* of lanes; the product set has sixteen directions an octant */
};

/* Degree l of each harmonic. */
static const unsigned char np_harmonic_degree[NP_HARMONIC_COUNT] = {0, 1, 1, 1, 2, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3};

/* Real orthonormal spherical harmonics up to l = 3 at a unit direction. */
void np_harmonics_eval(np_vec3 direction, float out[NP_HARMONIC_COUNT]);

/* A set of directions. Bit a of an octant's number is set where its directions point down axis a. Lanes beyond the
 * set's directions repeat the first with weight 0. */
typedef struct np_ordinates {
  unsigned count, block_count;                                             /* of one octant */
  _Alignas(32) float cosine[3][NP_ORDINATE_BLOCKS_MAX][NP_ORDINATE_LANES]; /* |Ω·a|, the same in every octant */
  float weight[NP_ORDINATE_BLOCKS_MAX][NP_ORDINATE_LANES];                 /* sr */
  float harmonic[NP_OCTANT_COUNT][NP_ORDINATE_BLOCKS_MAX][NP_HARMONIC_COUNT][NP_ORDINATE_LANES];
  float weighted[NP_OCTANT_COUNT][NP_ORDINATE_BLOCKS_MAX][NP_ORDINATE_LANES][NP_HARMONIC_COUNT]; /* weight·harmonic */
} np_ordinates;

/* Instead of an order: a set with many nearly horizontal directions, for layers without end. */
enum { NP_ORDINATES_PRODUCT = 0 };

/* `order` is 4 or 6, the N of S_N, or NP_ORDINATES_PRODUCT. */
void np_ordinates_init(unsigned order, np_ordinates *out);

np_vec3 np_ordinates_direction(const np_ordinates *ordinates, unsigned octant, unsigned block, unsigned lane);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Directions and weights of the discrete ordinates, and real spherical harmonics at them. */
#ifndef NP_TRANSPORT_ORDINATES_H
#define NP_TRANSPORT_ORDINATES_H

#include "core/math.h"

enum {
  NP_OCTANT_COUNT = 8,
  NP_OCTANT_PAIRS = NP_OCTANT_COUNT / 2, /* 2n and 2n + 1 differ in x alone */
  NP_DEGREE_MIN = 3,                     /* least degree of the harmonics for angles: large clouds have it */
  NP_DEGREE_MAX = 11,                    /* highest degree, for grids of few cells */
  NP_HARMONIC_COUNT_MIN = 16,            /* (l, m) up to l = 3 */
  NP_HARMONIC_COUNT_MAX = 144,
  NP_ORDINATE_LANES = 8,     /* directions of one octant that are swept together */
  NP_ORDINATE_BLOCKS_MAX = 9 /* blocks of lanes: 72 directions an octant */
};

/* Number of harmonics (l, m) up to a degree. Harmonic (l, m) is number l·(l + 1) + m. */
static inline unsigned np_harmonics_count(unsigned degree) { return (degree + 1) * (degree + 1); }

/* Real orthonormal spherical harmonics up to a degree at a unit direction. */
void np_harmonics_eval(unsigned degree, np_vec3 direction, float out[NP_HARMONIC_COUNT_MAX]);

/* A set of directions. Bit a of an octant's number is set where its directions point down axis a. Lanes beyond the
 * set's directions repeat the first with weight 0.
 *
 * Harmonics are even or odd in x: those of the one octant of a pair are, but for the sign of the odd ones, those of the
 * other. They are kept for the one that points up x, the even ones first. */
typedef struct np_ordinates {
  unsigned degree;             /* degree of the harmonics */
  unsigned count, block_count; /* directions in one octant, and their blocks */
  _Alignas(32) float cosine[3][NP_ORDINATE_BLOCKS_MAX][NP_ORDINATE_LANES]; /* |Ω·a|, the same in every octant */
  float weight[NP_ORDINATE_BLOCKS_MAX][NP_ORDINATE_LANES];                 /* sr */
  unsigned even_count; /* number of even harmonics, a multiple of two, as is the number of odd ones */
  unsigned char place[NP_HARMONIC_COUNT_MAX]; /* index of each harmonic in the arrays of this set */
  _Alignas(32) float harmonic[NP_OCTANT_PAIRS][NP_ORDINATE_BLOCKS_MAX][NP_HARMONIC_COUNT_MAX][NP_ORDINATE_LANES];
  float weighted[NP_OCTANT_PAIRS][NP_ORDINATE_BLOCKS_MAX][NP_ORDINATE_LANES][NP_HARMONIC_COUNT_MAX]; /* weight·Y */
} np_ordinates;

/* The directions that resolve harmonics of a degree. `is_layered` adds many nearly horizontal ones, as layers
 * without end need; degrees above the least have them in any case. */
void np_ordinates_init(unsigned degree, bool is_layered, np_ordinates *out);

/* Number of directions of np_ordinates_init(), in all octants. */
unsigned np_ordinates_count(unsigned degree, bool is_layered);

np_vec3 np_ordinates_direction(const np_ordinates *ordinates, unsigned octant, unsigned block, unsigned lane);

/* Number of the ordinate nearest to a direction of flight: its octant times the lanes of all blocks, plus its own. */
unsigned np_ordinates_search_nearest(const np_ordinates *ordinates, np_vec3 direction);

#endif

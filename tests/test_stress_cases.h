/* SPDX-License-Identifier: Apache-2.0 */
/* Cases of the stress suite: levels of factors, each pair of levels of two factors in some case.
 *
 * A greedy covering array (Cohen, Dalal, Fredman and Patton 1997, "The AETG System"): of a few candidates for the next
 * case, each filled factor by factor with the level that covers most new pairs, the best is taken. Random numbers are
 * those of one seed, so that the cases are the same on any machine.
 */
#ifndef NP_TEST_STRESS_CASES_H
#define NP_TEST_STRESS_CASES_H

#include "test_support.h"

#include "core/random.h"

typedef enum stress_factor {
  STRESS_DEPTH,
  STRESS_RAY,
  STRESS_ASYMMETRY,
  STRESS_FIELD,
  STRESS_ALBEDO,
  STRESS_LIGHT,
  STRESS_INTEGRATOR,
  STRESS_FACTORS
} stress_factor;

enum { STRESS_LEVELS_MAX = 11, STRESS_CASES_MAX = 160, STRESS_CANDIDATES = 40 };

static const unsigned stress_levels[STRESS_FACTORS] = {11, 7, 6, 6, 4, 4, 2};

typedef struct stress_case {
  unsigned level[STRESS_FACTORS];
} stress_case;

typedef struct stress_cases {
  unsigned count, pairs;
  stress_case at[STRESS_CASES_MAX];
  bool is_covered[STRESS_FACTORS][STRESS_LEVELS_MAX][STRESS_FACTORS][STRESS_LEVELS_MAX];
} stress_cases;

/* Pairs with the levels chosen so far that a level of a factor would cover anew. */
static inline unsigned stress_count_new(const stress_cases *cases, const stress_case *c, unsigned chosen,
                                        unsigned factor, unsigned level) {
  unsigned count = 0;
  for (unsigned f = 0; f < STRESS_FACTORS; f++)
    count += chosen >> f & 1u && !cases->is_covered[factor][level][f][c->level[f]];
  return count;
}

/* Fills a candidate, its factors in a random order; returns the number of new pairs. */
static inline unsigned stress_fill(const stress_cases *cases, np_random *random, stress_case *out) {
  unsigned order[STRESS_FACTORS], chosen = 0, total = 0;
  for (unsigned f = 0; f < STRESS_FACTORS; f++) order[f] = f;
  for (unsigned n = 0; n < STRESS_FACTORS; n++) {
    const unsigned other = n + (unsigned)(np_random_double(random) * (STRESS_FACTORS - n)), factor = order[other];
    order[other] = order[n];
    const unsigned first = (unsigned)(np_random_double(random) * stress_levels[factor]);
    unsigned best = 0;
    out->level[factor] = first;
    for (unsigned k = 0; k < stress_levels[factor]; k++) {
      const unsigned level = (first + k) % stress_levels[factor];
      const unsigned count = stress_count_new(cases, out, chosen, factor, level);
      if (count > best) out->level[factor] = level;
      if (count > best) best = count;
    }
    total += best;
    chosen |= 1u << factor;
  }
  return total;
}

static inline void stress_cover(stress_cases *cases, const stress_case *c) {
  for (unsigned a = 0; a < STRESS_FACTORS; a++)
    for (unsigned b = 0; b < STRESS_FACTORS; b++) {
      bool *is_covered = &cases->is_covered[a][c->level[a]][b][c->level[b]];
      cases->pairs += a < b && !*is_covered;
      *is_covered = true;
    }
}

static inline unsigned stress_count_pairs(void) {
  unsigned count = 0;
  for (unsigned a = 0; a < STRESS_FACTORS; a++)
    for (unsigned b = a + 1; b < STRESS_FACTORS; b++) count += stress_levels[a] * stress_levels[b];
  return count;
}

/* Adds cases until every pair is in one. */
static inline void stress_cases_build(stress_cases *cases) {
  const unsigned pairs = stress_count_pairs();
  np_random random = np_random_start(25, 0, 0, 0, 0);
  while (cases->pairs < pairs && cases->count < STRESS_CASES_MAX) {
    stress_case best = {0};
    unsigned most = 0;
    for (int n = 0; n < STRESS_CANDIDATES || most == 0; n++) {
      stress_case candidate;
      const unsigned count = stress_fill(cases, &random, &candidate);
      if (count > most) best = candidate;
      if (count > most) most = count;
    }
    stress_cover(cases, &best);
    cases->at[cases->count++] = best;
  }
}

#endif

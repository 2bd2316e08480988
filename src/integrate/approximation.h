/* SPDX-License-Identifier: Apache-2.0 */
/* Approximations of multiple scattering: what the march adds to single scattering where it is not solved for.
 *
 * Each answers with up to NP_APPROXIMATION_TERMS_MAX terms, a phase value times a function of the optical depth towards
 * the light. The first is single scattering, p·e^{−τ}; the others are what the approximation adds to it. Rows, sources
 * and equations are in approximation.c, compiled once per instruction-set level; errors against the tracer are in
 * docs/results/approximations.md.
 */
#ifndef NP_INTEGRATE_APPROXIMATION_H
#define NP_INTEGRATE_APPROXIMATION_H

#include "optics/multiple_scattering.h"
#include "world/world.h"

typedef struct np_approximation_row {
  unsigned (*count_terms)(const np_approximation *a);
  /* Share of the optical depth by which the slowest term fades that does fade in any cloud there is. */
  float (*get_fade)(const np_approximation *a);
  /* Phase values at one angle, times the light of each term. */
  void (*fill_phases)(const np_approximation *a, const np_phase *phase, float versine,
                      float out[NP_APPROXIMATION_TERMS_MAX]);
  /* Transmittance of an optical depth, term by term. */
  void (*fill_transmittances)(const np_approximation *a, float depth, float out[NP_APPROXIMATION_TERMS_MAX]);
  /* Factor on all terms in one cloud at one place; NULL: 1. */
  float (*get_weight)(const np_approximation *a, const np_instance *volume, np_dvec3 position);
  /* Share of the sunlight that a place scatters, evenly over a hemisphere, for p·e^{−τ}; NULL: none, and τ is needed.
   */
  float (*get_slope)(const np_approximation *a, const np_world *world, np_dvec3 position, np_vec3 to_sun);
} np_approximation_row;

/* One row a method; a method that is no approximation is single scattering. */
typedef const np_approximation_row np_approximation_rows[NP_MULTIPLE_SCATTERING_COUNT];
extern np_approximation_rows np_approximation_rows_v1, np_approximation_rows_v3, np_approximation_rows_v4;

#endif

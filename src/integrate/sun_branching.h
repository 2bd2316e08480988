/* SPDX-License-Identifier: Apache-2.0 */
/* Branches towards the sun: what tames the light that a forward peak brings.
 *
 * Through a forward peak, a path that happens to fly towards the sun brings rare and blinding light: for droplets of
 * 20 µm, thousands of times what it brings elsewhere. So a scattering that the sun reaches starts a second path, whose
 * direction is drawn about the sun: from the phase function, for the scattering that follows, and where that is very
 * sharp also from a broader lobe, for the one after it. Of directions ω a scattering then draws a(ω) + b(ω) per
 * steradian, a from the phase function about the path's own direction and b by branches. Each path is weighted by
 * a/(a + b) (balance heuristic of several samples; Veach and Guibas 1995, "Optimally Combining Sampling Techniques for
 * Monte Carlo Rendering"), so that it is as weak as the sunlight it will meet is strong. No weight grows by it: to draw
 * from a mixture of both instead would add to all others' weight at every scattering, and spoil paths of hundreds.
 *
 * So would branches in the dark: each hands on weight from one path to another, and of hundreds of scatterings that
 * each do so the paths come out with weights that have nothing to do with what they meet. What blinds is sunlight times
 * the peak, and ends at the depth where that is no longer bright: there are as many branches as this product, at most
 * one, and rays towards the sun are thinned out only beyond that depth. */
#ifndef NP_INTEGRATE_SUN_BRANCHING_H
#define NP_INTEGRATE_SUN_BRANCHING_H

#include "volume/tracking.h"

typedef struct np_sun_branching {
  const np_phase *phase;
  np_vec3 to_sun;
  float peak;        /* peak of the phase function, 1/sr; 0 without a sun */
  float share;       /* expected number of branches that are drawn from the phase function; 0: none */
  float broad_share; /* expected number of branches that are drawn from `broad` */
  np_phase broad;
} np_sun_branching;

/* Henyey-Greenstein with a peak of this value, 1/sr. */
static inline np_phase np_sun_branching_lobe(float peak) {
  return np_phase_henyey_greenstein(1.0f - 4.0f / (1.0f + sqrtf(1.0f + 32.0f * NP_PI_F * peak)));
}

/* The state where no sunlight arrives. */
static inline np_sun_branching np_sun_branching_make(const np_world *world, const np_phase *phase) {
  const bool has_sun = !np_spectrum_is_zero(world->sun_irradiance);
  return (np_sun_branching){
      .phase = phase, .to_sun = world->to_sun, .peak = has_sun ? np_phase_eval(phase, 0.0f) : 0.0f};
}

/* Sun optical depth beyond which even the peak of the phase function scatters little, so that shadow rays undergo
 * Russian roulette. */
static inline double np_sun_branching_faint_depth(const np_sun_branching *branching) {
  return np_track_faint_depth + (double)logf(np_maxf(branching->peak, 1.0f));
}

/* Chooses the branches of a scattering that this share of the sun's light comes to. Their numbers were chosen by
 * variance times time in slabs and on the Disney cloud, at optical depths of 3 to 150. */
static inline void np_sun_branching_choose(np_sun_branching *branching, float sunlight) {
  const float lit = np_minf(sunlight * branching->peak, 1.0f);
  if (branching->peak > 100.0f) {
    branching->share = 0.1f * lit;
    branching->broad_share = 0.6f * lit;
    branching->broad = np_sun_branching_lobe(branching->peak / 7.0f);
  } else if (branching->peak > 1.0f) {
    branching->share = lit;
  }
}

/* Expected number of branches per steradian. `out_expected_gain`: bound of the sunlight that later scatterings may add,
 * relative to isotropic scattering. */
static inline float np_sun_branching_eval(const np_sun_branching *branching, np_vec3 direction,
                                          float *out_expected_gain) {
  *out_expected_gain = 0.0f;
  if (branching->share <= 0.0f) return 0.0f;
  const np_vec3 d = direction, s = branching->to_sun;
  const float versine = np_vec3_versine(d, s);
  const float delta_m_residual = np_phase_eval(branching->phase, versine);
  const float broad = branching->broad_share > 0.0f ? np_phase_eval(&branching->broad, versine) : 0.0f;
  *out_expected_gain = 4.0f * NP_PI_F * fmaxf(delta_m_residual, broad);
  return branching->share * delta_m_residual + branching->broad_share * broad;
}

/* Whether this scattering starts a branch, and where to. */
static inline bool np_sun_branching_sample(const np_sun_branching *branching, np_random *random,
                                           np_vec3 *out_direction) {
  if (branching->share <= 0.0f) return false;
  const float choice = np_random_float(random);
  if (choice >= branching->share + branching->broad_share) return false;
  const float u[3] = {np_random_float(random), np_random_float(random), np_random_float(random)};
  const np_phase *lobe = choice < branching->share ? branching->phase : &branching->broad;
  float value;
  *out_direction = np_phase_sample(lobe, branching->to_sun, u, &value);
  return true;
}

#endif

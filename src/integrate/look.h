/* SPDX-License-Identifier: Apache-2.0 */
/* Artist's lights: what stands for light scattered more than once where it is not solved for.
 *
 * Each answers with up to NP_LOOK_TERMS_MAX terms, a phase value times a function of the optical depth towards the
 * light. The first is single scattering, p·e^{−τ}; the others are what the look adds to it:
 *
 *   octaves        copies with damped light, optical depth and asymmetry (Wrenninge, Kulla and Lundqvist 2013, "Oz: The
 *                  Great and Volumetric")
 *   softened Beer  max(e^{−τ}, a·e^{−bτ}) for e^{−τ} (Schneider 2017, "Nubis: Authoring Real-Time Volumetric
 *                  Cloudscapes with the Decima Engine")
 *   powder         softened Beer, times the probabilities that light reaches this deep and this high (the same source)
 *   derivative     1/π · (1 − σ(x + ℓs)/σ(x)), clamped to [0, 1], for p·e^{−τ}: a white wall that the density's slope
 *                  makes, one look-up towards the sun (after Quilez 2013, "Better Fog" and the shader "Clouds")
 *
 * Their errors against the tracer are in docs/accuracy.md. None knows how much light there is.
 */
#ifndef NP_INTEGRATE_LOOK_H
#define NP_INTEGRATE_LOOK_H

#include "integrate/integrator.h"
#include "core/stable.h"

static inline unsigned np_look_count_terms(const np_look *look) {
  if (look->kind == NP_LOOK_OCTAVES) return look->octave_count;
  return look->kind == NP_LOOK_DERIVATIVE ? 1 : 2;
}

/* Share of the optical depth by which the slowest term fades that does fade in any cloud there is. */
static inline float np_look_fade(const np_look *look) {
  if (look->kind == NP_LOOK_DERIVATIVE) return 1.0f;
  if (look->kind != NP_LOOK_OCTAVES) return look->softened_rate;
  float slowest = 1.0f;
  for (unsigned n = 1; n < look->octave_count && slowest * look->octave_depth > 0.001f; n++)
    slowest *= look->octave_depth;
  return slowest;
}

/* Phase values at one angle, times what light each term has. */
static inline void np_look_fill_phases(const np_look *look, const np_phase *phase, float versine,
                                       float out[NP_LOOK_TERMS_MAX]) {
  const bool is_octaves = look->kind == NP_LOOK_OCTAVES;
  float light = 1.0f, asymmetry = 1.0f;
  for (unsigned n = 0; n < np_look_count_terms(look); n++) {
    const np_phase broad = np_phase_broaden(phase, asymmetry);
    out[n] = light * np_phase_eval(&broad, versine);
    light *= is_octaves ? look->octave_light : 1.0f;
    asymmetry *= is_octaves ? look->octave_asymmetry : 1.0f;
  }
}

/* What comes through an optical depth, term by term. */
static inline void np_look_fill_transmittances(const np_look *look, float depth, float out[NP_LOOK_TERMS_MAX]) {
  out[0] = np_transmittance(depth);
  if (look->kind == NP_LOOK_OCTAVES) {
    for (unsigned n = 1; n < look->octave_count; n++) out[n] = np_transmittance(depth *= look->octave_depth);
  } else if (look->kind != NP_LOOK_DERIVATIVE) {
    out[1] = fmaxf(0.0f, look->softened_share * np_transmittance(look->softened_rate * depth) - out[0]);
  }
}

static inline float np_look_remap(float x, float from, float to, float low, float high) {
  return low + (high - low) * np_clampf((x - from) / (to - from), 0.0f, 1.0f);
}

/* Factor on all terms in one cloud at one place. */
static inline float np_look_weight(const np_look *look, const np_instance *volume, np_dvec3 position) {
  if (look->kind != NP_LOOK_POWDER) return 1.0f;
  const float densest = volume->bricks->value_max * volume->extinction_per_value;
  const float density = densest > 0.0f ? np_instance_extinction(volume, position) / densest : 0.0f;
  const double thickness = volume->top_m - volume->bottom_m;
  const float height = thickness > 0.0 ? (float)((position.z - volume->bottom_m) / thickness) : 1.0f;
  const float depth = 0.05f + powf(np_clampf(density, 0.0f, 1.0f), np_look_remap(height, 0.3f, 0.85f, 0.5f, 2.0f));
  const float vertical = powf(np_look_remap(height, 0.07f, 0.14f, 0.1f, 1.0f), 0.8f);
  return 1.0f + look->powder_strength * (fminf(depth, 1.0f) * vertical - 1.0f);
}

/* How far the density falls from a place to one nearer the sun: 0 where it does not, 1 where nothing is there. */
static inline float np_look_slope(const np_look *look, const np_world *world, np_dvec3 position, np_vec3 to_sun) {
  float here = 0.0f, there = 0.0f;
  for (unsigned v = 0; v < world->clouds.count; v++) {
    here += np_instance_extinction(&world->clouds.at[v], position);
    there += np_instance_extinction(&world->clouds.at[v],
                                    np_dvec3_along(position, to_sun, (double)look->derivative_distance_m));
  }
  return here > 0.0f ? np_clampf(1.0f - there / here, 0.0f, 1.0f) : 0.0f;
}

#endif

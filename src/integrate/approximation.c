/* SPDX-License-Identifier: Apache-2.0 */
/* The approximations of multiple scattering:
 *
 *   octaves        copies with damped light, optical depth and asymmetry (Wrenninge, Kulla and Lundqvist 2013, "Oz: The
 *                  Great and Volumetric")
 *   softened Beer  max(e^{−τ}, a·e^{−bτ}) for e^{−τ} (Schneider 2017, "Nubis: Authoring Real-Time Volumetric
 *                  Cloudscapes with the Decima Engine")
 *   powder         softened Beer, times the probabilities that light reaches this deep and this high (the same source)
 *   derivative     1/π · (1 − σ(x + ℓs)/σ(x)), clamped to [0, 1], for p·e^{−τ}: a white wall that the density's slope
 *                  makes, one look-up towards the sun (after Quilez 2013, "Better Fog" and the shader "Clouds")
 */
#include "integrate/approximation.h"

#include "core/isa.h"
#include "core/stable.h"

/* ---- Single scattering ---- */

static unsigned count_one(const np_approximation *a) { return (void)a, 1; }

static float fade_fully(const np_approximation *a) { return (void)a, 1.0f; }

static void fill_phase(const np_approximation *a, const np_phase *phase, float versine, float *out) {
  (void)a;
  out[0] = np_phase_eval(phase, versine);
}

static void fill_transmittance(const np_approximation *a, float depth, float *out) {
  (void)a;
  out[0] = np_transmittance(depth);
}

/* ---- Octaves ---- */

static unsigned count_octaves(const np_approximation *a) { return a->octave_count; }

static float get_octave_fade(const np_approximation *a) {
  const float factor = (float)a->octave_factors[1];
  float slowest = 1.0f;
  for (unsigned n = 1; n < a->octave_count && slowest * factor > 0.001f; n++) slowest *= factor;
  return slowest;
}

static void fill_octave_phases(const np_approximation *a, const np_phase *phase, float versine, float *out) {
  float light = 1.0f, asymmetry = 1.0f;
  for (unsigned n = 0; n < a->octave_count; n++) {
    const np_phase broad = np_phase_broaden(phase, asymmetry);
    out[n] = light * np_phase_eval(&broad, versine);
    light *= (float)a->octave_factors[0];
    asymmetry *= (float)a->octave_factors[2];
  }
}

static void fill_octave_transmittances(const np_approximation *a, float depth, float *out) {
  const float factor = (float)a->octave_factors[1];
  out[0] = np_transmittance(depth);
  for (unsigned n = 1; n < a->octave_count; n++) out[n] = np_transmittance(depth *= factor);
}

/* ---- Softened Beer ---- */

static unsigned count_two(const np_approximation *a) { return (void)a, 2; }

static float get_softened_fade(const np_approximation *a) { return (float)a->softened_rate; }

static void fill_softened_phases(const np_approximation *a, const np_phase *phase, float versine, float *out) {
  (void)a;
  out[0] = out[1] = np_phase_eval(phase, versine);
}

static void fill_softened_transmittances(const np_approximation *a, float depth, float *out) {
  out[0] = np_transmittance(depth);
  out[1] = fmaxf(0.0f, (float)a->softened_share * np_transmittance((float)a->softened_rate * depth) - out[0]);
}

/* ---- Powder ---- */

static float remap(float x, float from, float to, float low, float high) {
  return low + (high - low) * np_clampf((x - from) / (to - from), 0.0f, 1.0f);
}

static float get_powder_weight(const np_approximation *a, const np_instance *volume, np_dvec3 position) {
  const float densest = volume->bricks->value_max * volume->extinction_per_value;
  const float density = densest > 0.0f ? np_instance_extinction(volume, position) / densest : 0.0f;
  const double thickness = volume->top_m - volume->bottom_m;
  const float height = thickness > 0.0 ? (float)((position.z - volume->bottom_m) / thickness) : 1.0f;
  const float depth = 0.05f + powf(np_clampf(density, 0.0f, 1.0f), remap(height, 0.3f, 0.85f, 0.5f, 2.0f));
  const float vertical = powf(remap(height, 0.07f, 0.14f, 0.1f, 1.0f), 0.8f);
  return 1.0f + (float)a->powder_strength * (fminf(depth, 1.0f) * vertical - 1.0f);
}

/* ---- Derivative ---- */

/* Relative decrease of density over a distance towards the sun, in [0, 1]; 0 if density increases. */
static float get_derivative_slope(const np_approximation *a, const np_world *world, np_dvec3 position, np_vec3 to_sun) {
  const double distance_m = (double)(float)a->derivative_distance_m;
  const float here = np_instances_extinction(&world->clouds, position);
  const float there = np_instances_extinction(&world->clouds, np_dvec3_along(position, to_sun, distance_m));
  return here > 0.0f ? np_clampf(1.0f - there / here, 0.0f, 1.0f) : 0.0f;
}

/* ---- Rows ---- */

extern np_approximation_rows NP_KERNEL(np_approximation_rows);

#define SINGLE                                                                                                         \
  { count_one, fade_fully, fill_phase, fill_transmittance, NULL, NULL }

np_approximation_rows NP_KERNEL(np_approximation_rows) = {
    [NEPH_MULTIPLE_SCATTERING_NONE] = SINGLE,
    [NEPH_MULTIPLE_SCATTERING_ORDINATES] = SINGLE,
    [NEPH_MULTIPLE_SCATTERING_OCTAVES] = {count_octaves, get_octave_fade, fill_octave_phases,
                                          fill_octave_transmittances, NULL, NULL},
    [NEPH_MULTIPLE_SCATTERING_SOFTENED_BEER] = {count_two, get_softened_fade, fill_softened_phases,
                                                fill_softened_transmittances, NULL, NULL},
    [NEPH_MULTIPLE_SCATTERING_POWDER] = {count_two, get_softened_fade, fill_softened_phases,
                                         fill_softened_transmittances, get_powder_weight, NULL},
    [NEPH_MULTIPLE_SCATTERING_DERIVATIVE] = {count_one, fade_fully, fill_phase, fill_transmittance, NULL,
                                             get_derivative_slope},
};

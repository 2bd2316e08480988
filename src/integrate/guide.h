/* SPDX-License-Identifier: Apache-2.0 */
/* Paths guided by the march's solution of the multiple scattering: where to, how far, and how many go on.
 *
 * The solution (light/multi_scatter.h) tells about what light there is where a path collides: φ + J·Ω of it flies along
 * Ω, so that φ·(1 + a·ω) comes against a path of direction ω, a = −J/φ. Were that exact, paths could be drawn so that
 * each of them brings the same (Herholz, Zhao, Elek, Nowrouzezahrai, Lensch and Křivánek 2019, "Volume Path Guiding
 * Based on Zero-Variance Random Walk Theory"). Its mean over cells and its linear part are enough for depths of
 * thousands: far from faces that is all there is.
 *
 * Where to: directions are drawn from p(ω·ω′)·(1 + a·ω′)/(1 + g·a·ω), whose integral is one for any a.
 *
 * How far: flights collide at the rate κ, per depth, instead of 1 (Dwivedi 1982, "A new importance biasing scheme for
 * deep-penetration Monte Carlo"). By Fick's law light grows by β = (1 − ϖg)·a·ω/(1 + g·a·ω) a depth; as e^{βs} where
 * the cloud absorbs, to which κ = 1 − β belongs, and as 1 + βs where it does not: then flights have the mean 1/κ for
 * κ = 1 − β/(1 + 2β). What is between goes by k/β, k = √(3(1 − ϖ)(1 − ϖg)) the rate of diffuse light.
 *
 * How many: a path that is ended leaves what the solution expects of it, K, and one that goes on for others as well has
 * that much taken off: with the probability q of going on, K·(1 − 1/q), whose mean with K for those that end is zero
 * (Lafortune and Willems 1995, "The ambient term as a variance reducing technique for Monte Carlo ray tracing"). To end
 * a path then costs what K is wrong by, not K. Variance times time is least where paths are as many as each one's next
 * step is noisy; so they are ended where that is little against the camera's ray as a whole, and split where it is
 * much. In a deep slab one in thousands goes through the middle, and at the lit face becomes thousands again.
 *
 * What is wrong in the solution costs time, and changes no mean.
 */
#ifndef NP_INTEGRATE_GUIDE_H
#define NP_INTEGRATE_GUIDE_H

#include <float.h>

#include "integrate/tracking.h"
#include "light/multi_scatter.h"

/* About the light where a path collides. */
typedef struct np_guide {
  np_vec3 lean;    /* a, not longer than 0.9 */
  float asymmetry; /* g */
  float fade;      /* 1 − ϖg */
  float diffusion; /* k, per depth */
  float light;     /* K: what a collision throws on at a throughput of 1, but for what comes straight from the sun */
  float noise;     /* likewise, about the standard deviation of what the next step brings */
} np_guide;

/* Means between the cells around a position; false where nothing is known, or all is dark. */
static inline bool np_importance_find(const np_multi_scatter *scatter, np_dvec3 position, np_importance *out) {
  int32_t live[8];
  float weight[8];
  const unsigned count = np_transport_grid_find(&scatter->grid, position, live, weight);
  *out = (np_importance){0};
  for (unsigned c = 0; c < count; c++) {
    const np_importance *cell = &scatter->importance[live[c]];
    out->mean += weight[c] * cell->mean;
    for (int a = 0; a < 3; a++) out->lean[a] += weight[c] * cell->lean[a];
    out->lit += weight[c] * cell->lit;
  }
  return out->mean >= FLT_MIN;
}

/* Light that leans by a changes by a² more than guided paths reckon with, at each of the collisions that it takes to
 * turn it; and a ten thousandth of it is what the solution errs by in white slabs. Sunlight makes noise where it is, or
 * may be come to, the more the sharper the peak that throws it; but where light is dim against it, as at the rim of a
 * cloud before the sun, to split for all of it costs more than it brings. The numbers were chosen by variance times
 * time in slabs of depth 16 to 1024, the last by that of pictures. */
static inline float np_guide_find_noise(const np_importance *here, const np_guide *guide, float tilt, float versine) {
  const np_phase_lobe again = {.asymmetry = guide->asymmetry * guide->asymmetry}; /* of a scattering more */
  const float around = 0.25f / NP_PI_F / sqrtf(1.0f - guide->asymmetry), square = tilt * tilt;
  const float diffuse = sqrtf(guide->fade) * square * (2.0f + 4.0f * square) + 1e-4f;
  const float sunlight = 2.0f * here->lit * np_maxf(np_phase_eval_lobe(again, versine), around);
  return guide->light * diffuse + np_minf(sunlight, 3.0f * guide->light);
}

/* For a path that flies along `direction`, against the light. False where nothing is known. */
static inline bool np_guide_find(const np_scene_view *view, const np_view_volume *volume, np_dvec3 position,
                                 np_vec3 direction, np_guide *out) {
  np_importance here;
  if (!np_importance_find(view->multi_scatter, position, &here)) return false;
  const np_scaled_phase *phase = &view->multi_scatter->phases[volume - view->volumes];
  const float longest = 0.9f, albedo = np_spectrum_max(volume->albedo);
  const np_vec3 d = direction, s = view->to_sun;
  const np_vec3 lean = np_vec3_scale(np_vec3_make(here.lean[0], here.lean[1], here.lean[2]), -1.0f / here.mean);
  const float tilt = sqrtf(np_vec3_dot(lean, lean));
  out->lean = tilt > longest ? np_vec3_scale(lean, longest / tilt) : lean;
  out->asymmetry = phase->moments[1] + phase->forward;
  out->fade = 1.0f - albedo * out->asymmetry;
  out->diffusion = sqrtf(3.0f * (1.0f - albedo) * out->fade);
  out->light = here.mean * (1.0f + out->asymmetry * np_vec3_dot(out->lean, direction));
  out->noise = np_guide_find_noise(&here, out, np_minf(tilt, 1.0f), np_versine(d.x, d.y, d.z, s.x, s.y, s.z));
  return true;
}

/* The same for a camera's ray, in the first cell of a cloud's that it meets. */
static inline bool np_guide_find_entry(const np_scene_view *view, np_dvec3 origin, np_vec3 direction, np_guide *out) {
  const np_view_volume *first = NULL;
  double nearest = INFINITY, middle = 0.0;
  for (unsigned i = 0; i < view->volume_count; i++) {
    np_brick_walk walk;
    np_brick_span span;
    np_track_start(&walk, &view->volumes[i], origin, direction, 0.0, nearest);
    if (!np_brick_walk_next(&walk, &span) || !(span.t_begin < nearest)) continue;
    first = &view->volumes[i];
    nearest = span.t_begin;
    middle = 0.5 * (span.t_begin + span.t_end);
  }
  return first && np_guide_find(view, first, np_dvec3_along(origin, direction, middle), direction, out);
}

/* Density with which a direction is drawn over the phase function there. */
static inline float np_guide_steer(const np_guide *guide, np_vec3 before, np_vec3 after) {
  return (1.0f + np_vec3_dot(guide->lean, after)) / (1.0f + guide->asymmetry * np_vec3_dot(guide->lean, before));
}

static inline np_vec3 np_guide_sample(const np_guide *guide, const np_phase *phase, np_vec3 before, np_random *random) {
  const float most = 1.0f + sqrtf(np_vec3_dot(guide->lean, guide->lean));
  for (;;) {
    const float u[3] = {np_random_float(random), np_random_float(random), np_random_float(random)};
    float value;
    const np_vec3 direction = np_phase_sample(phase, before, u, &value);
    if (np_random_float(random) * most < 1.0f + np_vec3_dot(guide->lean, direction)) return direction;
  }
}

/* 1 − κ of a flight: the share of the extinction that it leaves out, −2 to 0.9; below 0 it is shortened. */
static inline double np_guide_find_spared(const np_guide *guide, np_vec3 direction) {
  const float cosine = np_vec3_dot(guide->lean, direction);
  const float growth = guide->fade * cosine / (1.0f + guide->asymmetry * cosine);
  if (growth <= 0.0f) return (double)np_maxf(growth, -2.0f);
  const float steady = np_minf(guide->diffusion / growth, 1.0f);
  return (double)np_minf(growth / (1.0f + 2.0f * growth * (1.0f - steady)), 0.9f);
}

/* How many paths are to go on for each: a whole number to split it into, or less than one, the probability of going on.
 * `reference`: the light of the ray that it is part of. */
static inline float np_guide_count(const np_guide *guide, float throughput, float reference) {
  const float share = throughput * guide->noise / reference;
  if (share < 0.5f) return np_maxf(share, 1e-5f);
  return share < 2.0f ? 1.0f : floorf(np_minf(share + 0.5f, 16.0f));
}

#endif

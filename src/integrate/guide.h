/* SPDX-License-Identifier: Apache-2.0 */
/* Paths guided by the march's solution of the multiple scattering: where to, how far, and how many go on.
 *
 * The solution (transport/scattering_field.h) estimates the light where a path collides: over its mean,
 * ℓ(ω) = 1 + a·c + b·P₂(c) of it comes against a path of direction ω, c = â·ω, from its parts of degree 1 and 2 about
 * the direction â that most comes from. Were that exact, paths could be drawn so that each of them brings the same
 * (Herholz, Zhao, Elek, Nowrouzezahrai, Lensch and Křivánek 2019, "Volume Path Guiding Based on Zero-Variance Random
 * Walk Theory"). It is enough for depths of thousands: far from faces there is little more.
 *
 * Where to: directions are drawn from p(ω·ω′)·ℓ(ω′)/ℓ′(ω). The integral of p·ℓ has the moments of ℓ times those of p:
 * ℓ′(ω) = 1 + χ₁·a·c + χ₂·b·P₂(c).
 *
 * How far: flights collide at the rate κ, per depth, instead of 1 (Dwivedi 1982, "A new importance biasing scheme for
 * deep-penetration Monte Carlo"). By the equation's first moment the mean grows along â by γ = (1 − ϖg)·a/(1 + 2b/5) a
 * depth. Where the cloud absorbs, what it scatters grows as e^{βs}, β = γ·c, to which κ = 1 − β belongs; where it does
 * not absorb, as 1 + βs, β = γ·c/ℓ′: then flights have the mean 1/κ for κ = 1 − β/(1 + 2β). What is between depends on
 * k/γ, k = √(3(1 − ϖ)(1 − ϖg)) the rate of diffuse light.
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

#include "volume/tracking.h"
#include "transport/scattering_field.h"

/* About the light where a path collides. */
typedef struct np_guide {
  np_vec3 axis;            /* â */
  float linear, quadratic; /* a, b */
  float asymmetry, second; /* χ₁ = g, χ₂ */
  float growth;            /* γ, per depth */
  float steady;            /* how much of it is exponential: 0 to 1 */
  float light; /* K: radiance that a collision scatters at a throughput of 1, without directly scattered sunlight */
  float noise; /* noise at a throughput of 1: about twice the deviation of the next step's light */
} np_guide;

/* The part of degree 2 at a direction. */
static inline float np_importance_get_quadratic(const np_importance *here, np_vec3 d) {
  const float *b = here->quadratic;
  return d.x * d.y * b[0] + d.y * d.z * b[1] + (3.0f * d.z * d.z - 1.0f) * b[2] + d.x * d.z * b[3] +
         (d.x * d.x - d.y * d.y) * b[4];
}

/* ℓ at a cosine to the axis, its degrees times two moments. */
static inline float np_guide_shape(const np_guide *guide, float cosine, float first, float second) {
  return 1.0f + first * guide->linear * cosine + second * guide->quadratic * (1.5f * cosine * cosine - 0.5f);
}

/* ℓ′ */
static inline float np_guide_outgoing(const np_guide *guide, np_vec3 direction) {
  return np_guide_shape(guide, np_vec3_dot(guide->axis, direction), guide->asymmetry, guide->second);
}

/* Sets the shape ℓ, with the quadratic term limited so that ℓ stays above 0.1. */
static inline void np_guide_set_shape(np_guide *guide, const np_importance *here) {
  const float room = 0.9f, longest = 1.3f, inverse = 1.0f / here->mean;
  const np_vec3 linear = np_vec3_scale(np_vec3_make(here->linear[0], here->linear[1], here->linear[2]), -inverse);
  const float length = sqrtf(np_vec3_dot(linear, linear));
  guide->axis = length > 1e-6f ? np_vec3_scale(linear, 1.0f / length) : np_vec3_make(0.0f, 0.0f, 1.0f);
  guide->linear = np_minf(length, longest);
  const float most = room + sqrtf(room * room - guide->linear * guide->linear * (1.0f / 3.0f));
  guide->quadratic = np_clampf(np_importance_get_quadratic(here, guide->axis) * inverse, guide->linear - room, most);
}

static inline void np_guide_set_medium(np_guide *guide, const np_scaled_cloud *cloud, float albedo) {
  guide->asymmetry = cloud->asymmetry;
  guide->second = cloud->second;
  const float fade = 1.0f - albedo * guide->asymmetry;
  guide->growth = fade * guide->linear / (1.0f + 0.4f * guide->quadratic);
  guide->steady = np_minf(sqrtf(3.0f * (1.0f - albedo) * fade) / np_maxf(guide->growth, 1e-6f), 1.0f);
}

/* About twice the standard deviation of what the next step brings, over the light, that directions and flights make
 * which are not quite what they should be; where the light ends nearby, its curvature is not that of steady growth (by
 * the equation's second moment). Fitted to single steps in slabs of depth 64 to 1024, mostly within a factor of two;
 * but for the last two terms, which bound how many paths one may come to represent. */
static inline float np_guide_estimate_noise(const np_guide *guide, float albedo) {
  const float fade = 1.0f - albedo * guide->asymmetry, rise = 1.0f - guide->steady;
  const float square = guide->linear * guide->linear, turn = fade * fade * square / (1.0f + square);
  const float even = guide->steady * (2.0f / 3.0f) * guide->growth * guide->linear / (1.0f - albedo * guide->second);
  return turn * (0.5f + rise) + 0.09f * rise * square * square + fabsf(guide->quadratic - even) +
         0.03f * guide->linear + 2e-5f;
}

/* The same of sunlight that is here, or may be come to: the more the sharper the peak that scatters it, here after a
 * scattering more; but where light is dim against it, as at the rim of a cloud before the sun, to split for all of it
 * costs more than it brings. */
static inline float np_guide_estimate_sun_noise(const np_guide *guide, float lit, float versine) {
  const np_phase_lobe again = {.asymmetry = guide->asymmetry * guide->asymmetry};
  const float around = 0.25f / NP_PI_F / sqrtf(1.0f - guide->asymmetry);
  return np_minf(0.5f * lit * np_maxf(np_phase_eval_lobe(again, versine), around), 2.0f * guide->light);
}

/* Makes the guide of a path that leaves the camera along `direction`; false: the importance is unknown here. */
static inline bool np_guide_make(const np_world *world, const np_scattering_field *scattering,
                                 const np_instance *volume, np_dvec3 position, np_vec3 direction, np_guide *out) {
  np_importance here;
  if (!np_scattering_field_get_importance(scattering, position, &here)) return false;
  const float albedo = np_spectrum_max(volume->albedo);
  const np_vec3 d = direction, s = world->to_sun;
  np_guide_set_shape(out, &here);
  const np_scattering_medium *medium = np_scattering_field_get_medium(scattering);
  np_guide_set_medium(out, &medium->clouds[np_instances_get_index(&world->clouds, volume)], albedo);
  out->light = here.mean * np_guide_outgoing(out, direction);
  out->noise = out->light * np_guide_estimate_noise(out, albedo) +
               np_guide_estimate_sun_noise(out, here.lit, np_vec3_versine(d, s));
  return true;
}

/* Makes the guide of a camera's ray at the first cell with cloud. */
static inline bool np_guide_make_entry(const np_world *world, const np_scattering_field *scattering, np_dvec3 origin,
                                       np_vec3 direction, np_guide *out) {
  const np_instance *first = NULL, *volume;
  double nearest = INFINITY, middle = 0.0;
  np_place_walk places;
  np_place_walk_start(&places, &world->clouds, origin, direction, INFINITY);
  while ((volume = np_place_walk_next(&places, nearest))) {
    np_brick_walk walk;
    np_brick_span span;
    np_track_start(&walk, volume, origin, direction, 0.0, nearest);
    if (!np_brick_walk_next(&walk, &span) || !(span.t_begin < nearest)) continue;
    first = volume;
    nearest = span.t_begin;
    middle = 0.5 * (span.t_begin + span.t_end);
  }
  return first && np_guide_make(world, scattering, first, np_dvec3_along(origin, direction, middle), direction, out);
}

/* Density of a guided direction relative to the density of the phase function. */
static inline float np_guide_steer(const np_guide *guide, np_vec3 before, np_vec3 after) {
  return np_guide_shape(guide, np_vec3_dot(guide->axis, after), 1.0f, 1.0f) / np_guide_outgoing(guide, before);
}

/* The same where paths are drawn by the phase functions of bands: in each band. */
static inline np_spectrum np_guide_steer_bands(const np_guide *guide, const np_phase_bands *bands, np_vec3 before,
                                               np_vec3 after) {
  const float shape = np_guide_shape(guide, np_vec3_dot(guide->axis, after), 1.0f, 1.0f);
  np_spectrum steer;
  for (int b = 0; b < NP_BAND_COUNT; b++)
    steer.band[b] =
        shape / np_guide_shape(guide, np_vec3_dot(guide->axis, before), bands->asymmetry[b], bands->second[b]);
  return steer;
}

static inline np_vec3 np_guide_sample(const np_guide *guide, const np_phase *phase, np_vec3 before, np_random *random) {
  const float ends = 1.0f + guide->linear + guide->quadratic;
  const float most = guide->quadratic < 0.0f ? 1.0f + guide->linear - 0.5f * guide->quadratic : ends;
  for (;;) {
    const float u[3] = {np_random_float(random), np_random_float(random), np_random_float(random)};
    float value;
    const np_vec3 direction = np_phase_sample(phase, before, u, &value);
    const float shape = np_guide_shape(guide, np_vec3_dot(guide->axis, direction), 1.0f, 1.0f);
    if (np_random_float(random) * most < shape) return direction;
  }
}

/* 1 − κ of a flight: the share of the extinction that it leaves out, −2 to 0.9; below 0 it is shortened. */
static inline double np_guide_get_stretch_fraction(const np_guide *guide, np_vec3 direction) {
  const float rise = 1.0f - guide->steady, outgoing = np_guide_outgoing(guide, direction);
  const float growth = guide->growth * np_vec3_dot(guide->axis, direction) / (1.0f + rise * (outgoing - 1.0f));
  if (growth <= 0.0f) return (double)np_maxf(growth, -2.0f);
  return (double)np_minf(growth / (1.0f + 2.0f * growth * rise), 0.9f);
}

/* Number of paths by which one path is continued: it is split above 1, and subject to Russian roulette below.
 * `reference`: radiance of the camera's ray. */
static inline float np_guide_count(const np_guide *guide, float throughput, float reference) {
  const float share = throughput * guide->noise / reference;
  if (share < 0.5f) return np_maxf(share, 1e-5f);
  return share < 2.0f ? 1.0f : floorf(np_minf(share + 0.5f, 16.0f));
}

#endif

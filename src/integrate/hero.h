/* SPDX-License-Identifier: Apache-2.0 */
/* One path for all bands: spectral multiple importance sampling.
 *
 * A band that is drawn once, the hero, makes all choices that differ from band to band (Wilkie et al. 2014, "Hero
 * Wavelength Spectral Sampling"). With f the integrand of a path in a band and p_h the density that the path would have
 * had with the hero h, the balance heuristic weighs it by f/p̄, p̄ the mean of all p_h. Kept from choice to choice are
 * f/p̄, the throughput, and p_h/p̄, whose mean is one: neither over- nor underflows however long the path, and however
 * deep the one band of it and clear the other.
 */
#ifndef NP_INTEGRATE_HERO_H
#define NP_INTEGRATE_HERO_H

#include "core/random.h"
#include "core/spectrum.h"

typedef struct np_hero {
  int band;
  np_spectrum density; /* p_h/p̄ */
} np_hero;

/* Chooses a hero band by a number in [0, 1), and returns the unused part of the number, in [0, 1], for a further
 * choice. */
static inline np_hero np_hero_choose_first(double number, double *out_choice) {
  const int band = (int)(number * NP_BAND_COUNT);
  *out_choice = number * NP_BAND_COUNT - band;
  return (np_hero){band < NP_BAND_COUNT ? band : NP_BAND_COUNT - 1, np_spectrum_grey(1.0f)};
}

static inline np_hero np_hero_draw(np_random *random) {
  double unused;
  return np_hero_choose_first((double)np_random_float(random), &unused);
}

/* Density of a choice averaged over all hero bands, relative to the density of the path before the choice. */
static inline float np_hero_mean(const np_hero *hero, np_spectrum density) {
  return np_spectrum_mean(np_spectrum_multiply(hero->density, density));
}

/* Multiplies the throughput by a choice's value over its density, averaged over the hero bands (balance heuristic). */
static inline void np_hero_choose(np_hero *hero, np_spectrum *throughput, np_spectrum value, np_spectrum density) {
  const float inverse = 1.0f / np_hero_mean(hero, density);
  hero->density = np_spectrum_scale(np_spectrum_multiply(hero->density, density), inverse);
  *throughput = np_spectrum_scale(np_spectrum_multiply(*throughput, value), inverse);
}

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Irradiance of slopes of every orientation, in spherical harmonics to the second degree of their normals, convolved
 * with the cosine (Ramamoorthi and Hanrahan 2001, "An Efficient Representation for Irradiance Environment Maps"). */
#ifndef NP_CACHES_RELIEF_HARMONICS_H
#define NP_CACHES_RELIEF_HARMONICS_H

#include "core/math.h"
#include "core/spectrum.h"
#include "core/units.h"

enum { NP_RELIEF_TERMS = 9 };

typedef struct np_relief_irradiance {
  np_spectrum term[NP_RELIEF_TERMS];
} np_relief_irradiance;

/* Factors of the cosine's convolution by degree, π, 2π/3 and π/4 (Ramamoorthi and Hanrahan 2001, eq. 8). */
static const float np_relief_cosine_factor[NP_RELIEF_TERMS] = {
    NP_PI_F,         2.0f * NP_PI_F / 3.0f, 2.0f * NP_PI_F / 3.0f, 2.0f * NP_PI_F / 3.0f, 0.25f * NP_PI_F,
    0.25f * NP_PI_F, 0.25f * NP_PI_F,       0.25f * NP_PI_F,       0.25f * NP_PI_F};

/* Normalisation of the harmonics of degree 0 and 1. */
static const float np_relief_harmonic_0 = 0.28209479f, np_relief_harmonic_1 = 0.48860251f;

static inline void np_relief_fill_harmonics(np_vec3 d, float out[NP_RELIEF_TERMS]) {
  out[0] = np_relief_harmonic_0;
  out[1] = np_relief_harmonic_1 * d.y;
  out[2] = np_relief_harmonic_1 * d.z;
  out[3] = np_relief_harmonic_1 * d.x;
  out[4] = 1.09254843f * d.x * d.y;
  out[5] = 1.09254843f * d.y * d.z;
  out[6] = 0.31539157f * (3.0f * d.z * d.z - 1.0f);
  out[7] = 1.09254843f * d.x * d.z;
  out[8] = 0.54627422f * (d.x * d.x - d.y * d.y);
}

/* Adds light of a direction, times its solid angle, to the irradiance of all slopes. */
static inline void np_relief_add_light(np_vec3 towards, np_spectrum light, np_relief_irradiance *sum) {
  float harmonics[NP_RELIEF_TERMS];
  np_relief_fill_harmonics(towards, harmonics);
  for (int k = 0; k < NP_RELIEF_TERMS; k++)
    sum->term[k] = np_spectrum_add_scaled(sum->term[k], np_relief_cosine_factor[k] * harmonics[k], light);
}

/* The same of one number in place of a spectrum. */
static inline void np_relief_add_share(np_vec3 towards, float light, float sum[NP_RELIEF_TERMS]) {
  float harmonics[NP_RELIEF_TERMS];
  np_relief_fill_harmonics(towards, harmonics);
  for (int k = 0; k < NP_RELIEF_TERMS; k++) sum[k] += np_relief_cosine_factor[k] * harmonics[k] * light;
}

static inline np_spectrum np_relief_sum_terms(const np_relief_irradiance *light,
                                              const float harmonics[NP_RELIEF_TERMS]) {
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (int k = 0; k < NP_RELIEF_TERMS; k++) sum = np_spectrum_add_scaled(sum, harmonics[k], light->term[k]);
  return sum;
}

static inline float np_relief_sum_shares(const float light[NP_RELIEF_TERMS], const float harmonics[NP_RELIEF_TERMS]) {
  float sum = 0.0f;
  for (int k = 0; k < NP_RELIEF_TERMS; k++) sum += harmonics[k] * light[k];
  return sum;
}

#endif

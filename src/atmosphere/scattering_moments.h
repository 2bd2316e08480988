/* SPDX-License-Identifier: Apache-2.0 */
/* Scattered light as six angular moments over (altitude, sun cosine).
 *
 * At a point, z is up and x horizontal towards the sun's azimuth. Per unit of sun irradiance above the atmosphere the
 * radiance L(ω) of the sky and of the ground below it, the sun's own rays excluded, is kept as
 *
 *   M = ∫L dω,  Fx = ∫L ωx dω,  Fz = ∫L ωz dω,  Kxx = ∫L ωx² dω,  Kzz = ∫L ωz² dω,  Kxz = ∫L ωx ωz dω;
 *
 * Fy and the mixed moments with y vanish by symmetry, Kyy = M − Kxx − Kzz. Rayleigh's phase function is a polynomial of
 * degree 2, so that these six hold its source of the next order exactly:
 *
 *   ∫ p_R(ω·ω′) L(ω′) dω′ = 3/(16π)·(M + ω·Kω).
 */
#ifndef NP_ATMOSPHERE_SCATTERING_MOMENTS_H
#define NP_ATMOSPHERE_SCATTERING_MOMENTS_H

#include "atmosphere/table_sizes.h"

typedef enum np_moment {
  NP_MOMENT_M,
  NP_MOMENT_FX,
  NP_MOMENT_FZ,
  NP_MOMENT_KXX,
  NP_MOMENT_KZZ,
  NP_MOMENT_KXZ,
  NP_MOMENT_COUNT
} np_moment;

enum { NP_ORDERS_ALL = 0x7fffffff };

/* Sun cosine μ_s to column: d/(|d| + spread), d = μ_s − center, is evenly divided between `lowest` and 1, so that
 * columns crowd about the sunset. All three grow with the planet's twilight. */
typedef struct np_sun_scale {
  float lowest, center, spread;
  float first; /* the warped value of `lowest` */
  int columns;
  float columns_per_unit;
} np_sun_scale;

typedef struct np_moment_table {
  const np_medium *medium;
  np_sun_scale sun;
  int rows; /* even in √altitude, of `sun.columns` sets of NP_MOMENT_COUNT */
  np_bands *moments;
  np_bands *hemisphere; /* as many pairs: ∫L over the directions above the true horizon, and over those below */
  np_bands *irradiance; /* a column each: of the sky on the ground */
} np_moment_table;

/* Sums the first `order_max` orders of scattering in `depths`' medium; under a disk or a point; see the file for the
 * method. */
neph_result np_moment_table_build(neph_context *context, const np_depth_table *depths, const np_moment_sizes *sizes,
                                  unsigned order_max, bool has_point_sun, np_moment_table *out_table);

/* Adds, as scattered light from the sun's direction, what sunlight `brighter` air lets through beyond `darker`. */
void np_moment_table_add_beam(np_moment_table *table, const np_depth_table *brighter, const np_depth_table *darker,
                              bool has_point_sun);
void np_moment_table_free(neph_context *context, np_moment_table *table);

/* Column of a sun cosine as a fractional index. */
static inline float np_sun_scale_column(const np_sun_scale *sun, float sun_cosine) {
  const float d = sun_cosine - sun->center;
  const float column = (d / (fabsf(d) + sun->spread) - sun->first) * sun->columns_per_unit;
  return np_clampf(column, 0.0f, (float)(sun->columns - 1));
}

/* Splits a fractional column into a lower neighbour and the weight of the upper one. */
static inline int np_sun_scale_split(const np_sun_scale *sun, float column, float *out_weight) {
  const int i = column < (float)(sun->columns - 2) ? (int)column : sun->columns - 2;
  *out_weight = column - (float)i;
  return i;
}

/* Lower one of the two rows about an altitude, and the weight of the upper. */
static inline int np_moment_table_row(const np_moment_table *table, double altitude_m, float *out_weight) {
  const double y = sqrt(np_clamp(altitude_m / table->medium->top_m, 0.0, 1.0)) * (table->rows - 1);
  const int i = y < table->rows - 2 ? (int)y : table->rows - 2;
  *out_weight = (float)(y - i);
  return i;
}

/* What the phase functions ask of the moments in one direction. */
typedef struct np_moment_sample {
  np_bands total;     /* M */
  np_bands flux;      /* F·ω */
  np_bands quadratic; /* ω·Kω */
} np_moment_sample;

/* A row of the table; its upper neighbour follows it. */
static inline const np_bands *np_moment_table_at_row(const np_moment_table *table, int row) {
  return table->moments + (size_t)row * (size_t)table->sun.columns * NP_MOMENT_COUNT;
}

/* The moments at two rows' blend (`lower_row` and its upper neighbour) seen in the direction (ωx, ·, ωz). */
static inline np_moment_sample np_moment_table_sample(const np_sun_scale *sun, const np_bands *lower_row,
                                                      float upper_weight, float column, float wx, float wz) {
  float f;
  const int i = np_sun_scale_split(sun, column, &f);
  const np_bands *a = lower_row + (size_t)i * NP_MOMENT_COUNT, *b = a + (size_t)sun->columns * NP_MOMENT_COUNT;
  const float wa = (1.0f - upper_weight) * (1.0f - f), wa1 = (1.0f - upper_weight) * f;
  const float wb = upper_weight * (1.0f - f), wb1 = upper_weight * f;
  np_bands m[NP_MOMENT_COUNT];
  for (int k = 0; k < NP_MOMENT_COUNT; k++)
    m[k] = wa * a[k] + wa1 * a[k + NP_MOMENT_COUNT] + wb * b[k] + wb1 * b[k + NP_MOMENT_COUNT];
  const np_bands kyy = m[NP_MOMENT_M] - m[NP_MOMENT_KXX] - m[NP_MOMENT_KZZ];
  return (np_moment_sample){
      .total = m[NP_MOMENT_M],
      .flux = wx * m[NP_MOMENT_FX] + wz * m[NP_MOMENT_FZ],
      .quadratic = wx * wx * m[NP_MOMENT_KXX] + (1.0f - wx * wx - wz * wz) * kyy + wz * wz * m[NP_MOMENT_KZZ] +
                   2.0f * wx * wz * m[NP_MOMENT_KXZ],
  };
}

/* M alone. */
static inline np_bands np_moment_table_total(const np_sun_scale *sun, const np_bands *lower_row, float upper_weight,
                                             float column) {
  float f;
  const int i = np_sun_scale_split(sun, column, &f);
  const np_bands *a = lower_row + (size_t)i * NP_MOMENT_COUNT, *b = a + (size_t)sun->columns * NP_MOMENT_COUNT;
  return np_bands_mix(np_bands_mix(a[0], a[NP_MOMENT_COUNT], f), np_bands_mix(b[0], b[NP_MOMENT_COUNT], f),
                      upper_weight);
}

/* Source of the aerosol's scattering from the moments, exact but for its parts of degree 3 and above: ∫ p(ω·ω′)L dω′ ≈
 * 1/(4π)·((1 − 5χ₂/2)·M + 3χ₁·F·ω + 15χ₂/2·ω·Kω). `aerosol`: coefficients times χ_0 = 1, χ_1 and χ_2. */
static inline np_bands np_moment_aerosol_source(const np_bands aerosol[3], const np_moment_sample *s) {
  return (float)(0.25 / NP_PI) *
         ((aerosol[0] - 2.5f * aerosol[2]) * s->total + 3.0f * aerosol[1] * s->flux + 7.5f * aerosol[2] * s->quadratic);
}

/* Source of Rayleigh's scattering, per unit of its coefficient: exact. */
static inline np_bands np_moment_rayleigh_source(const np_moment_sample *s) {
  return (float)(3.0 / (16.0 * NP_PI)) * (s->total + s->quadratic);
}

/* Sky irradiance on the ground where the sun has this cosine. */
np_bands np_moment_table_irradiance(const np_moment_table *table, float sun_cosine);

/* The local x component ωx of a direction with zenith cosine `wz` whose angle with the sun has cosine `angle_cosine`.
 * Under a sun at the zenith x is undefined, and nothing depends on it. */
static inline float np_direction_x(float angle_cosine, float wz, float sun_cosine) {
  const float x = (angle_cosine - wz * sun_cosine) / sqrtf(np_maxf(1.0f - sun_cosine * sun_cosine, 1e-6f));
  const float limit = sqrtf(np_maxf(1.0f - wz * wz, 0.0f));
  return np_clampf(x, -limit, limit);
}

#endif

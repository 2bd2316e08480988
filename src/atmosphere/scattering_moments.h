/* SPDX-License-Identifier: Apache-2.0 */
/* Scattered light as six angular moments over (altitude, sun cosine).
 *
 * At a point, z is up and x horizontal towards the sun's azimuth. Per unit of solar irradiance above the atmosphere,
 * the radiance L(ω) of the sky and of the ground below, without direct sunlight, is stored as
 *
 * M = ∫L dω, Fx = ∫L ωx dω, Fz = ∫L ωz dω, Kxx = ∫L ωx² dω, Kzz = ∫L ωz² dω, Kxz = ∫L ωx ωz dω;
 *
 * Fy and the mixed moments with y vanish by symmetry, and Kyy = M − Kxx − Kzz. Rayleigh's phase function is a
 * polynomial of degree 2, so that these six give its source of the next order exactly:
 *
 * ∫ p_R(ω·ω′) L(ω′) dω′ = 3/(16π)·(M + ω·Kω). */
#ifndef NP_ATMOSPHERE_SCATTERING_MOMENTS_H
#define NP_ATMOSPHERE_SCATTERING_MOMENTS_H

#include "atmosphere/optical_depth.h"

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

/* Map from the sun cosine μ_s to columns: d/(|d| + spread), d = μ_s − center, is uniform between `lowest` and 1, so
 * that columns concentrate at sunset. All three scale with the planet's twilight. */
typedef struct np_sun_scale {
  float lowest, center, spread;
  float first; /* warped value of `lowest` */
  int columns;
  float columns_per_unit;
} np_sun_scale;

typedef struct np_moment_table {
  const np_medium *medium;
  np_sun_scale sun;
  int rows;             /* uniform in √altitude */
  np_bands *moments;    /* rows × NP_MOMENT_COUNT × columns */
  np_bands *irradiance; /* rows × columns: sky irradiance on level ground */
} np_moment_table;

void np_moment_table_free(neph_context *context, np_moment_table *table);

/* Scale with a given number of columns. */
np_sun_scale np_sun_scale_make(const np_medium *medium, int columns);

/* Sun cosine at a fraction, 0 to 1, of the columns. */
float np_sun_scale_cosine(const np_sun_scale *sun, double fraction);

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

/* Lower of the two rows around an altitude, and the weight of the upper one. */
static inline int np_moment_table_row(const np_moment_table *table, double altitude_m, float *out_weight) {
  const double y = sqrt(np_clamp(altitude_m / table->medium->top_m, 0.0, 1.0)) * (table->rows - 1);
  const int i = y < table->rows - 2 ? (int)y : table->rows - 2;
  *out_weight = (float)(y - i);
  return i;
}

/* A row of the table: NP_MOMENT_COUNT runs of `sun.columns`. The next row follows it in memory. */
static inline const np_bands *np_moment_table_at_row(const np_moment_table *table, int row) {
  return table->moments + (size_t)row * (size_t)table->sun.columns * NP_MOMENT_COUNT;
}

/* M at an altitude, for a sun cosine. */
static inline np_bands np_moment_table_total(const np_moment_table *table, double altitude_m, float sun_cosine) {
  float upper, f;
  const np_bands *low = np_moment_table_at_row(table, np_moment_table_row(table, altitude_m, &upper));
  low += np_sun_scale_split(&table->sun, np_sun_scale_column(&table->sun, sun_cosine), &f);
  const np_bands *high = low + table->sun.columns * NP_MOMENT_COUNT;
  return np_bands_mix(np_bands_mix(low[0], low[1], f), np_bands_mix(high[0], high[1], f), upper);
}

/* Sky irradiance on level ground at an altitude, for a sun cosine there. */
np_bands np_moment_table_irradiance(const np_moment_table *table, double altitude_m, float sun_cosine);

/* Component ωx of a direction with zenith cosine `wz`; `angle_cosine` is between the direction and the sun. Under a sun
 * at the zenith x is undefined, and nothing depends on it. */
static inline float np_direction_x(float angle_cosine, float wz, float sun_cosine) {
  const float x = (angle_cosine - wz * sun_cosine) / sqrtf(np_maxf(1.0f - sun_cosine * sun_cosine, 1e-6f));
  const float limit = sqrtf(np_maxf(1.0f - wz * wz, 0.0f));
  return np_clampf(x, -limit, limit);
}

#endif

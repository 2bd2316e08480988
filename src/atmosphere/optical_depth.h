/* SPDX-License-Identifier: Apache-2.0 */
/* Optical depth: along any stretch of a ray by quadrature, and to the top of the atmosphere from a table.
 *
 * The table holds depths, not transmittances: a depth is smooth where a transmittance has long since fallen to nothing.
 */
#ifndef NP_ATMOSPHERE_OPTICAL_DEPTH_H
#define NP_ATMOSPHERE_OPTICAL_DEPTH_H

#include "atmosphere/atmosphere_physics.h"
#include "core/context_private.h"

/* Depth between two distances, 0 ≤ begin ≤ end, along a ray's part in the air. To 1e-5 of itself for the Earth. */
np_bands np_ray_optical_depth(const np_medium *medium, const np_ray *ray, double begin_m, double end_m);

enum { NP_DEPTH_WIDTH = 192, NP_DEPTH_HEIGHT = 128 };

/* Depths to the top over (distance to the horizon, distance to the top), the mapping of Bruneton and Neyret 2008 as
 * revised in Bruneton's 2017 implementation: both distances are square roots where the depth has its own. */
typedef struct np_depth_table {
  const np_medium *medium;
  np_bands *texels; /* NP_DEPTH_HEIGHT rows of NP_DEPTH_WIDTH */
} np_depth_table;

neph_result np_depth_table_build(neph_context *context, const np_medium *medium, np_depth_table *out_table);
void np_depth_table_free(neph_context *context, np_depth_table *table);

/* The table at one altitude, resolved once for many directions. */
typedef struct np_depth_row {
  const np_bands *lower, *upper;
  float upper_weight;
  float r, exit; /* exit = (r_top − r)(r_top + r) */
  float distance_min, texels_per_m;
  float horizon_cosine;
  float disk_scale; /* 1/(cosine that one radian at the horizon spans) */
} np_depth_row;

np_depth_row np_depth_table_row(const np_depth_table *table, double altitude_m);

static inline np_bands np_depth_row_lookup(const np_depth_row *row, float cosine) {
  const float b = row->r * cosine, s = sqrtf(b * b + row->exit);
  const float distance = b > 0.0f ? row->exit / (b + s) : s - b;
  const float x = np_clampf((distance - row->distance_min) * row->texels_per_m, 0.0f, (float)(NP_DEPTH_WIDTH - 1));
  const int i = x < (float)(NP_DEPTH_WIDTH - 2) ? (int)x : NP_DEPTH_WIDTH - 2;
  const float f = x - (float)i;
  return np_bands_mix(np_bands_mix(row->lower[i], row->lower[i + 1], f),
                      np_bands_mix(row->upper[i], row->upper[i + 1], f), row->upper_weight);
}

/* The part of the sun's disk above the horizon: the disk's edge smoothed into a cubic (Bruneton 2017). */
static inline float np_depth_row_disk(const np_depth_row *row, float sun_cosine, float inverse_diameter) {
  return np_smoothstepf((sun_cosine - row->horizon_cosine) * row->disk_scale * inverse_diameter + 0.5f);
}

/* Transmittance to the sun times the visible part of its disk. `inverse_diameter` is 1 over twice its angular radius.
 */
static inline np_bands np_depth_row_sun(const np_depth_row *row, float sun_cosine, float inverse_diameter) {
  const float disk = np_depth_row_disk(row, sun_cosine, inverse_diameter);
  if (disk <= 0.0f) return np_bands_grey(0.0f);
  return disk * np_bands_exp(-np_depth_row_lookup(row, np_maxf(sun_cosine, row->horizon_cosine)));
}

/* A disk of no width still sets within a step of the float cosine. */
static inline float np_sun_inverse_diameter(double angular_radius_rad) {
  return (float)(0.5 / fmax(angular_radius_rad, 1e-6));
}

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Optical depth: along any segment of a ray by quadrature, and to the top of the atmosphere by a table.
 *
 * The table stores depths, not transmittances: a depth is smooth even where the transmittance is practically 0. */
#ifndef NP_ATMOSPHERE_OPTICAL_DEPTH_H
#define NP_ATMOSPHERE_OPTICAL_DEPTH_H

#include "atmosphere/atmosphere_physics.h"
#include "atmosphere/table_sizes.h"
#include "core/parallel.h"

/* Optical depth between two distances, 0 ≤ begin ≤ end, along a ray's part in the air; accurate to 1e-5 of itself for
 * the Earth. */
np_bands np_ray_optical_depth(const np_medium *medium, const np_ray *ray, double begin_m, double end_m);

/* Optical depth between two distances with a given number of panels of four points each. */
np_bands np_ray_optical_depth_in(const np_medium *medium, const np_ray *ray, double begin_m, double end_m, int panels);

/* Optical depths to the top of the atmosphere along rising and level rays, over (distance to the horizon, distance to
 * the top): the mapping of Bruneton and Neyret 2008 as revised in Bruneton's 2017 implementation, in which both are
 * square roots where the depth behaves as one. A descending ray passes its perigee, where it is level. Its depth is
 * twice the depth from there, less the depth of the ray that rises at the same angle from its start. So the steep part,
 * in which the perigee sinks through scale heights of air, is a function of one altitude alone. */
typedef struct np_depth_table {
  const np_medium *medium;
  int rows, columns, levels;
  np_bands *texels; /* `rows` rows of `columns` */
  np_bands *level;  /* depths of level rays, uniform in √altitude */
} np_depth_table;

neph_result np_depth_table_build(neph_context *context, const np_medium *medium, const np_depth_sizes *sizes,
                                 np_monitor *monitor, np_depth_table *out_table);
void np_depth_table_free(neph_context *context, np_depth_table *table);

/* The table at one altitude, interpolated once for many directions. */
typedef struct np_depth_row {
  np_bands level_offset; /* difference of the two tables in the depth of a level ray, added to `level` */
  const np_bands *lower, *upper, *level;
  float upper_weight;
  float altitude_m, r, exit; /* exit = (r_top − r)(r_top + r) */
  float distance_min, texels_per_m;
  float levels_per_root_m;
  int columns, levels;
  float horizon_cosine;
  float disk_scale; /* 1/(cosine span of one radian at the horizon) */
} np_depth_row;

np_depth_row np_depth_table_row(const np_depth_table *table, double altitude_m);

/* Depth of a level ray. */
static inline np_bands np_depth_row_level(const np_depth_row *row, float altitude_m) {
  const float x = sqrtf(np_maxf(altitude_m, 0.0f)) * row->levels_per_root_m;
  const int i = x < (float)(row->levels - 2) ? (int)x : row->levels - 2;
  return np_bands_mix(row->level[i], row->level[i + 1], x - (float)i);
}

/* Depth of a rising or level ray. */
static inline np_bands np_depth_row_rising(const np_depth_row *row, float cosine) {
  const float b = row->r * cosine, distance = row->exit / (b + sqrtf(b * b + row->exit));
  const float x = np_clampf((distance - row->distance_min) * row->texels_per_m, 0.0f, (float)(row->columns - 1));
  const int i = x < (float)(row->columns - 2) ? (int)x : row->columns - 2;
  const float f = x - (float)i;
  return np_bands_mix(np_bands_mix(row->lower[i], row->lower[i + 1], f),
                      np_bands_mix(row->upper[i], row->upper[i + 1], f), row->upper_weight);
}

/* Depth to the top of the atmosphere; rays that hit the ground count as grazing it. */
static inline np_bands np_depth_row_lookup(const np_depth_row *row, float cosine) {
  const np_bands rising = np_depth_row_rising(row, fabsf(cosine));
  if (cosine >= 0.0f) return rising;
  const float lowest = row->altitude_m - row->r * cosine * cosine / (1.0f + sqrtf(1.0f - cosine * cosine));
  return 2.0f * (np_depth_row_level(row, lowest) + row->level_offset) - rising;
}

/* The sun's disk seen from a point: its size, and whether sunlight comes from the disk or, as in some reference models,
 * from its centre. */
typedef struct np_sun_disk {
  float inverse_diameter; /* 1/(twice the angular radius) */
  bool is_point;
} np_sun_disk;

/* A disk of zero width sets within one step of the float cosine. */
static inline np_sun_disk np_sun_disk_make(double angular_radius_rad, bool is_point) {
  return (np_sun_disk){(float)(0.5 / fmax(angular_radius_rad, 1e-6)), is_point};
}

/* acos to 7e-5 (Abramowitz and Stegun 1964, 4.4.45). */
static inline float np_acos_coarse(float x) {
  const float a = np_minf(fabsf(x), 1.0f);
  const float angle = sqrtf(1.0f - a) * (1.5707288f + a * (-0.2121144f + a * (0.0742610f - a * 0.0187293f)));
  return x < 0.0f ? NP_PI_F - angle : angle;
}

/* Quadrature over a disk cut by the horizon: its visible part, and two heights with the mean and the spread of that
 * part. Heights are in disk radii above the centre. */
typedef struct np_disk_rule {
  float visible, low, high;
} np_disk_rule;

/* `horizon` is the height of the horizon. The mean is y_c = (2/3)·(1 − y²)^1.5/(π·visible); the spread is a quarter of
 * the part's height, exact for the whole disk and 5 % low for a thin part. */
static inline np_disk_rule np_disk_rule_make(float horizon) {
  if (horizon <= -1.0f) return (np_disk_rule){1.0f, -0.5f, 0.5f};
  const float half_chord = sqrtf(np_maxf(1.0f - horizon * horizon, 0.0f));
  const float visible = (np_acos_coarse(horizon) - horizon * half_chord) * (1.0f / NP_PI_F);
  if (!(visible > 1e-4f)) return (np_disk_rule){0.0f, 0.0f, 0.0f};
  const float center = (2.0f / 3.0f) * half_chord * half_chord * half_chord / (NP_PI_F * visible);
  const float spread = 0.25f * (1.0f - horizon);
  return (np_disk_rule){visible, center - spread, center + spread};
}

/* Visible part of a point sun: the disk's edge smoothed into a cubic (Bruneton 2017). */
static inline float np_point_sun_visible(float horizon) { return np_smoothstepf(0.5f - 0.5f * horizon); }

/* Transmittance to the sun times the visible part of its disk. High above the horizon the depth is practically linear
 * over the disk. */
static inline np_bands np_depth_row_sun(const np_depth_row *row, float sun_cosine, np_sun_disk disk) {
  const float above = (sun_cosine - row->horizon_cosine) * row->disk_scale;
  if (above > 0.2f) return np_bands_exp(-np_depth_row_lookup(row, sun_cosine));
  const float horizon = -2.0f * above * disk.inverse_diameter;
  if (horizon >= 1.0f) return np_bands_grey(0.0f);
  if (disk.is_point)
    return np_point_sun_visible(np_maxf(horizon, -1.0f)) *
           np_bands_exp(-np_depth_row_lookup(row, np_maxf(sun_cosine, row->horizon_cosine)));
  const np_disk_rule rule = np_disk_rule_make(horizon);
  const float radius = 0.5f / (disk.inverse_diameter * row->disk_scale);
  const float low = np_maxf(sun_cosine + radius * rule.low, row->horizon_cosine);
  const float high = np_maxf(sun_cosine + radius * rule.high, row->horizon_cosine);
  return 0.5f * rule.visible *
         (np_bands_exp(-np_depth_row_lookup(row, low)) + np_bands_exp(-np_depth_row_lookup(row, high)));
}

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* A fan: rays with one zenith angle and many suns or azimuths.
 *
 * They share one path and the table rows at its points; each ray differs by its sun cosine and its angle with the sun.
 * Kernels for each instruction set look the tables up for the whole fan at each point. */
#ifndef NP_ATMOSPHERE_FAN_H
#define NP_ATMOSPHERE_FAN_H

#include "atmosphere/atmosphere_private.h"
#include "atmosphere/optical_depth.h"
#include "atmosphere/ray_path.h"
#include "atmosphere/scattering_moments.h"

/* Kernels take this many rays per step. */
enum { NP_FAN_STEP = 8, NP_FAN_MAX = 4 * NP_MOMENT_NODE_COLUMNS_MAX };

/* Number of steps for the rays; arrays have whole steps. */
static inline int np_fan_count_steps(int count) { return (count + NP_FAN_STEP - 1) / NP_FAN_STEP; }

typedef struct np_fan {
  int count;
  float r;                        /* value at the start of the rays */
  float sun_cosine[NP_FAN_MAX];   /* value at the start of the rays */
  float angle_cosine[NP_FAN_MAX]; /* cosine between ray and sun */
} np_fan;

/* Pads the fan to a whole step with copies of the last ray. */
static inline void np_fan_pad(np_fan *fan) {
  for (int i = fan->count; i < np_fan_count_steps(fan->count) * NP_FAN_STEP; i++) {
    fan->sun_cosine[i] = fan->sun_cosine[fan->count - 1];
    fan->angle_cosine[i] = fan->angle_cosine[fan->count - 1];
  }
}

/* A fan of one ray. */
static inline np_fan np_fan_make_single(const np_ray *ray, float sun_cosine, float angle_cosine) {
  np_fan fan = {.count = 1, .r = (float)ray->r, .sun_cosine = {sun_cosine}, .angle_cosine = {angle_cosine}};
  np_fan_pad(&fan);
  return fan;
}

/* Coordinates of a fan's rays in the moment table at one point. */
typedef struct np_fan_point {
  int count;
  float sun_cosine[NP_FAN_MAX];
  float x[NP_FAN_MAX]; /* ωx of the ray, towards the sun's azimuth: np_direction_x */
  int32_t column[NP_FAN_MAX];
  float upper[NP_FAN_MAX]; /* np_sun_scale_split */
} np_fan_point;

/* Source of later orders at a point for the rays of a fan, from the moments: a·M + b·F·ω + c·ω·Kω. */
typedef struct np_fan_source {
  const np_moment_table *table;
  float altitude_m, cosine;
  np_bands isotropic, linear, quadratic; /* a, b, c */
} np_fan_source;

/* Makes a source, times a weight. Rayleigh scattering is exact, ∫ p_R(ω·ω′) L dω′ = 3/(16π)·(M + ω·Kω). Aerosol
 * scattering is cut after degree 2, ∫ p(ω·ω′) L dω′ ≈ 1/(4π)·((1 − 5χ₂/2)·M + 3χ₁·F·ω + 15χ₂/2·ω·Kω). */
static inline np_fan_source np_fan_source_make(const np_moment_table *table, const np_path_node *node, np_bands weight,
                                               bool has_aerosol) {
  const np_medium *medium = table->medium;
  np_bands aerosol[3] = {np_bands_grey(0.0f), np_bands_grey(0.0f), np_bands_grey(0.0f)};
  for (int k = 0; has_aerosol && k < 3; k++) aerosol[k] = np_aerosol_sum(medium, &node->air, k);
  const np_bands scale = (float)(0.25 / NP_PI) * weight, rayleigh = 0.75f * node->air.rayleigh;
  return (np_fan_source){.table = table,
                         .altitude_m = node->altitude_m,
                         .cosine = node->cosine,
                         .isotropic = scale * (rayleigh + aerosol[0] - 2.5f * aerosol[2]),
                         .linear = scale * 3.0f * aerosol[1],
                         .quadratic = scale * (rayleigh + 7.5f * aerosol[2])};
}

typedef struct np_fan_kernels {
  /* Computes the sun cosines of all rays at a distance `t` and radius `r`. */
  void (*compute_sun_cosines)(const np_fan *fan, float t, float r, np_fan_point *out_point);
  /* Computes the sunlight of each ray from the row's depths: np_depth_row_sun. */
  void (*compute_sunlight)(const np_depth_row *row, np_sun_disk disk, const np_fan_point *point,
                           np_bands *out_sunlight);
  /* Computes the remaining coordinates of a point whose sun cosines are set. */
  void (*compute_columns)(const np_sun_scale *scale, const np_fan *fan, float cosine, np_fan_point *point);
  /* Adds the source to `sums`, and stores M in `out_totals` if it is not NULL. */
  void (*add_source)(const np_fan_source *source, const np_fan_point *point, np_bands *sums, np_bands *out_totals);
} np_fan_kernels;

const np_fan_kernels *np_fan_get_kernels(neph_isa isa);

#endif

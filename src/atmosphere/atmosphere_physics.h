/* SPDX-License-Identifier: Apache-2.0 */
/* The air: what it is made of at an altitude, how it scatters, and where rays enter and leave it.
 *
 * A spherical planet of radius R under three layers (Bruneton and Neyret 2008, "Precomputed Atmospheric Scattering",
 * section 2; ozone as in Hillaire 2020, "A Scalable and Production Ready Sky and Atmosphere Rendering Technique",
 * section 4): molecules exp(−h/H_R), aerosol exp(−h/H_M), ozone a tent. Below sea level the air stays as it is at it.
 *
 * A ray is given by the altitude h of its start and the cosine μ of its angle with the zenith there. Altitudes are
 * never formed as r − R. With b = r·μ the sphere of radius R + a is met at the roots of t² + 2bt + c = 0, c = (h −
 * a)(2R + h + a); the root that does not cancel is found first and the other is c over it.
 */
#ifndef NP_ATMOSPHERE_ATMOSPHERE_PHYSICS_H
#define NP_ATMOSPHERE_ATMOSPHERE_PHYSICS_H

#include <math.h>
#include <stdbool.h>

#include "atmosphere/bands.h"
#include "core/math.h"
#include "core/units.h"
#include "optics/phase.h"

typedef struct np_medium {
  double planet_radius_m, top_m;
  float rayleigh_height_m, mie_height_m, ozone_center_m, ozone_width_m;
  np_bands rayleigh_scattering, mie_scattering, mie_extinction, ozone_absorption; /* 1/m, where each is densest */
  np_bands ground_albedo;
  np_phase mie_phase;
  float mie_moment[3]; /* χ_0 = 1, χ_1, χ_2 of the aerosol's phase function */
} np_medium;

/* Coefficients at one altitude, 1/m. */
typedef struct np_air {
  np_bands rayleigh, mie; /* scattering */
  np_bands extinction;
} np_air;

static inline np_air np_air_at(const np_medium *medium, double altitude_m) {
  const float h = np_maxf((float)altitude_m, 0.0f);
  const float rayleigh = expf(-h / medium->rayleigh_height_m), mie = expf(-h / medium->mie_height_m);
  const float ozone = np_maxf(0.0f, 1.0f - fabsf(h - medium->ozone_center_m) / medium->ozone_width_m);
  np_air air = {medium->rayleigh_scattering * rayleigh, medium->mie_scattering * mie, np_bands_grey(0.0f)};
  air.extinction = air.rayleigh + medium->mie_extinction * mie + medium->ozone_absorption * ozone;
  return air;
}

/* Rayleigh's phase function, 3/(16π)·(1 + cos²θ). */
static inline float np_phase_rayleigh_eval(float cosine) {
  return (float)(3.0 / (16.0 * NP_PI)) * (1.0f + cosine * cosine);
}

/* Distance from an altitude to the horizon of the sphere at `base_m` below it: √(r² − (R + base)²). */
static inline double np_horizon_distance(const np_medium *medium, double altitude_m, double base_m) {
  return sqrt(fmax((altitude_m - base_m) * (2.0 * medium->planet_radius_m + altitude_m + base_m), 0.0));
}

/* Cosine of the zenith angle of the horizon. Who writes a table and who reads it both split it by this alone. */
static inline double np_horizon_cosine(const np_medium *medium, double altitude_m) {
  return -np_horizon_distance(medium, altitude_m, 0.0) / (medium->planet_radius_m + altitude_m);
}

/* Zenith angle under which the sphere at `base_m` is seen to end: π/2 at its surface, towards π far away. */
static inline double np_horizon_angle(const np_medium *medium, double altitude_m, double base_m) {
  return 0.5 * NP_PI +
         atan2(np_horizon_distance(medium, altitude_m, base_m), medium->planet_radius_m + fmin(base_m, altitude_m));
}

/* Sine of the angle that the horizon of the top of the atmosphere dips, seen from there: the planet's own scale of
 * twilight, 0.175 for the Earth. Everything that is a sun angle in the tables is measured by it. */
static inline double np_twilight_scale(const np_medium *medium) {
  return -np_horizon_cosine(medium, medium->top_m);
}

/* The part of a ray that lies in the air. */
typedef struct np_ray {
  double altitude_m, r, cosine; /* where the air begins: at the ray's start, or at its entry from space */
  double offset_m;              /* from the ray's start to there */
  double length_m;              /* in the air; 0 when the ray misses it */
  bool hits_ground;
} np_ray;

/* Altitude at a distance along a ray, without the difference of two radii. */
static inline double np_ray_altitude(const np_ray *ray, double t) {
  const double gain = t * (2.0 * ray->r * ray->cosine + t);
  return ray->altitude_m + gain / (ray->r + sqrt(fmax(ray->r * ray->r + gain, 0.0)));
}

/* Cosine of the zenith angle of a ray's direction at a distance along it. */
static inline double np_ray_cosine(const np_ray *ray, double t) {
  const double r = ray->r + (np_ray_altitude(ray, t) - ray->altitude_m);
  return np_clamp((ray->r * ray->cosine + t) / r, -1.0, 1.0);
}

/* Distance to the sea-level sphere along a ray known to meet it; 0 when it starts there. */
static inline double np_distance_to_ground(const np_medium *medium, double altitude_m, double cosine) {
  const double b = (medium->planet_radius_m + altitude_m) * cosine;
  const double c = altitude_m * (2.0 * medium->planet_radius_m + altitude_m);
  const double q = -b + sqrt(fmax(b * b - c, 0.0));
  return q > 0.0 ? c / q : 0.0;
}

/* Distance to the top of the atmosphere from inside it. */
static inline double np_distance_to_top(const np_medium *medium, double altitude_m, double cosine) {
  const double b = (medium->planet_radius_m + altitude_m) * cosine;
  const double q =
      fmax((medium->top_m - altitude_m) * (2.0 * medium->planet_radius_m + medium->top_m + altitude_m), 0.0);
  const double s = sqrt(b * b + q);
  return b > 0.0 ? q / (b + s) : s - b;
}

/* Moves a ray that starts in space to where it enters the air. False when it passes by. */
static inline bool np_ray_enter(const np_medium *medium, np_ray *ray) {
  const double b = ray->r * ray->cosine;
  const double c =
      (ray->altitude_m - medium->top_m) * (2.0 * medium->planet_radius_m + ray->altitude_m + medium->top_m);
  if (b >= 0.0 || b * b < c) return false;
  ray->offset_m = c / (-b + sqrt(b * b - c));
  const double r_top = medium->planet_radius_m + medium->top_m;
  ray->cosine = np_clamp((b + ray->offset_m) / r_top, -1.0, 0.0);
  ray->altitude_m = medium->top_m;
  ray->r = r_top;
  return true;
}

/* A ray on a known side of the horizon: the writer of a table knows the side of each row, exactly on it too. */
static inline np_ray np_ray_on_side(const np_medium *medium, double altitude_m, double cosine, bool hits_ground) {
  const double h = fmax(altitude_m, 0.0);
  np_ray ray = {h, medium->planet_radius_m + h, cosine, 0.0, 0.0, hits_ground};
  if (h > medium->top_m && !np_ray_enter(medium, &ray)) return ray;
  ray.length_m = hits_ground ? np_distance_to_ground(medium, ray.altitude_m, ray.cosine)
                             : np_distance_to_top(medium, ray.altitude_m, ray.cosine);
  return ray;
}

static inline np_ray np_ray_make(const np_medium *medium, double altitude_m, double cosine) {
  const double h = fmax(altitude_m, 0.0);
  return np_ray_on_side(medium, h, cosine, cosine < np_horizon_cosine(medium, h));
}

/* Distance at which a ray is nearest to the planet, within its part in the air. */
static inline double np_ray_perigee(const np_ray *ray) {
  return np_clamp(-ray->r * ray->cosine, 0.0, ray->length_m);
}

#endif

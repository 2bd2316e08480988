/* SPDX-License-Identifier: Apache-2.0 */
/* Intersection of rays with the atmosphere, and altitudes along them.
 *
 * A ray is given by the altitude h of its start and the cosine μ of its angle with the zenith there. Altitudes are
 * never formed as r − R. With b = r·μ the ray meets the sphere of radius R + a at the roots of t² + 2bt + c = 0, c = (h
 * − a)(2R + h + a). The root without cancellation is computed first; the other is c over it. */
#ifndef NP_ATMOSPHERE_ATMOSPHERE_PHYSICS_H
#define NP_ATMOSPHERE_ATMOSPHERE_PHYSICS_H

#include "atmosphere/medium.h"

/* Distance from an altitude to the horizon of the sphere at `base_m` below it: √(r² − (R + base)²). */
static inline double np_horizon_distance(const np_medium *medium, double altitude_m, double base_m) {
  return sqrt(fmax((altitude_m - base_m) * (2.0 * medium->planet_radius_m + altitude_m + base_m), 0.0));
}

/* Cosine of the zenith angle of the horizon. Writers and readers of tables both use it to split rows at the horizon. */
static inline double np_horizon_cosine(const np_medium *medium, double altitude_m) {
  return -np_horizon_distance(medium, altitude_m, 0.0) / (medium->planet_radius_m + altitude_m);
}

/* Zenith angle of the horizon of the sphere at `base_m`: π/2 on its surface, towards π far away. */
static inline double np_horizon_angle(const np_medium *medium, double altitude_m, double base_m) {
  return 0.5 * NP_PI +
         atan2(np_horizon_distance(medium, altitude_m, base_m), medium->planet_radius_m + fmin(base_m, altitude_m));
}

/* Sine of the dip of the sea-level horizon seen from the top of the atmosphere, 0.175 for the Earth. It scales all sun
 * angles of the tables with the planet's twilight. */
static inline double np_twilight_scale(const np_medium *medium) { return -np_horizon_cosine(medium, medium->top_m); }

/* Part of a ray inside the atmosphere. */
typedef struct np_ray {
  double altitude_m, r, cosine; /* state where the air begins: the ray's start, or its entry from space */
  double offset_m;              /* distance from the ray's start to the entry */
  double length_m;              /* length inside the air; 0 if the ray misses it */
  bool hits_ground;
} np_ray;

/* Altitude at a distance along a ray, computed without the difference of two radii. */
static inline double np_ray_altitude(const np_ray *ray, double t) {
  const double gain = t * (2.0 * ray->r * ray->cosine + t);
  return ray->altitude_m + gain / (ray->r + sqrt(fmax(ray->r * ray->r + gain, 0.0)));
}

/* Cosine of the zenith angle of a ray's direction at a distance along it. */
static inline double np_ray_cosine(const np_ray *ray, double t) {
  const double r = ray->r + (np_ray_altitude(ray, t) - ray->altitude_m);
  return np_clamp((ray->r * ray->cosine + t) / r, -1.0, 1.0);
}

/* Distance to the sea-level sphere along a ray that hits it; 0 if the ray starts on it. */
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

/* Moves a ray that starts in space to its entry into the air. False if it misses the air. */
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

/* A ray on a given side of the horizon: the writer of a table states the side for each row, also for a row exactly on
 * the horizon. */
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

/* A ray from any position, even below sea level, with its whole length in the air, through the ground too. */
static inline np_ray np_ray_make_free(const np_medium *medium, np_dvec3 position, np_vec3 direction) {
  const double radius = medium->planet_radius_m, h = np_altitude(position, radius);
  const double cosine = np_clamp((double)np_vec3_dot(np_zenith(position, radius), direction), -1.0, 1.0);
  np_ray ray = {h, radius + h, cosine, 0.0, 0.0, false};
  if (h > medium->top_m && !np_ray_enter(medium, &ray)) return ray;
  ray.length_m = np_distance_to_top(medium, ray.altitude_m, ray.cosine);
  return ray;
}

/* Distance of the point nearest to the planet, within the ray's part in the air. */
static inline double np_ray_perigee(const np_ray *ray) { return np_clamp(-ray->r * ray->cosine, 0.0, ray->length_m); }

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Samples of a ray: distances, weights, scattering there, and transmittance up to there.
 *
 * Gauss points in a variable adapted to the air: t = L·u² for a ray to space, which starts in the densest air; half the
 * points on each side of the perigee, squared away from it, for a limb ray; uniform for a ray to the ground from low
 * altitude, t = L·(1 − u²) from high altitude. All of it depends on altitude and zenith angle alone: one path serves
 * every azimuth, every sun and every order of scattering. */
#ifndef NP_ATMOSPHERE_RAY_PATH_H
#define NP_ATMOSPHERE_RAY_PATH_H

#include "atmosphere/atmosphere_physics.h"
#include "atmosphere/quadrature.h"

enum { NP_PATH_MAX = NP_QUADRATURE_MAX };

/* Gauss rules for `count` points along a ray, and for half of them on each side of its perigee. */
typedef struct np_path_rule {
  np_quadrature whole, half;
} np_path_rule;

/* `count` is even and at most NP_PATH_MAX. */
static inline np_path_rule np_path_rule_make(int count) {
  return (np_path_rule){np_quadrature_gauss(count), np_quadrature_gauss(count / 2)};
}

typedef struct np_path_node {
  np_bands transmittance; /* transmittance from the ray's start */
  np_scattering air;
  double t;       /* along the ray's part in the air, m */
  float weight_m; /* length of the segment that the point represents */
  float altitude_m, r, cosine;
} np_path_node;

typedef struct np_path {
  int count;      /* 0 for a ray that misses the air */
  bool is_warped; /* the points are concentrated in layers with kinks */
  np_bands end_transmittance;
  np_path_node node[NP_PATH_MAX];
} np_path;

void np_path_build(const np_medium *medium, const np_ray *ray, const np_path_rule *rule, np_path *out_path);

/* Builds the path of a part of a ray, with points that lie evenly in it. `*depth` is the optical depth up to its begin,
 * and becomes that up to its end. */
void np_path_build_part(const np_medium *medium, const np_ray *ray, double begin_m, double end_m,
                        const np_quadrature *rule, np_bands *depth, np_path *out_path);

/* Optical depth between two points: two-point Gauss rules over short steps. */
np_bands np_ray_gap_depth(const np_medium *medium, const np_ray *ray, double begin_m, double end_m);

#endif

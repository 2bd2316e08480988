/* SPDX-License-Identifier: Apache-2.0 */
/* Light of the clouds along rays, gathered from the solution of the multiple scattering.
 *
 * The equation of transfer is integrated in the scaled medium of transport/scattering_solver.c,
 *
 *     L += T·S·(1 − e^{−σ′h})/σ′,   S = Σ ϖσ·((1−f)·p′·E·e^{−kτ} + Σ (χ_l − f)·φ_lm·Y_lm)
 *
 * and what lies behind is seen through what T is left. The forward peak has no part in S: what it scatters belongs to
 * the sun's beam, which fades with kτ (`fade`), and to what lies behind. Air is left to gather_air.h.
 */
#ifndef NP_CACHES_CLOUD_GATHER_H
#define NP_CACHES_CLOUD_GATHER_H

#include "caches/sun_optical_depth.h"
#include "transport/scattering_field.h"
#include "volume/instance_period.h"

typedef struct np_cloud_gather {
  const np_world *world; /* borrowed, as all that follows */
  const np_sun_optical_depths *depths;
  const np_scattering_field *scattering; /* NULL: there are no clouds */
  np_dvec3 bounds_min, bounds_max;       /* box of all density, of one period or tile where it repeats */
  np_light_period period[2];             /* along x and y, from the box on; a length of 0: light does not repeat */
  np_transport_fold fold;                /* tiles of which the box is one; a period of 0: none */
  bool is_coarse;                        /* fewer points, for a first picture or a draft */
  float fade[NP_INSTANCES_MAX];          /* factor on each cloud's optical depth in the scaled medium */
} np_cloud_gather;

/* Fills `fade` for the rest. */
void np_cloud_gather_init(np_cloud_gather *gather);

/* A direction, and the clouds' phase values for light that arrives against it. */
typedef struct np_cloud_direction {
  np_vec3 towards;
  float harmonics[NP_HARMONIC_COUNT_MAX]; /* spherical harmonics in this direction */
  float broad[NP_INSTANCES_MAX];          /* (1−f)·p′ of each cloud for sunlight */
} np_cloud_direction;

void np_cloud_gather_aim(const np_cloud_gather *gather, np_vec3 towards, np_cloud_direction *out);

/* Steps of at least `length_m` along a ray, and at most `count_max`, to its end; `offset` in [0, 1] shifts them. */
typedef struct np_cloud_steps {
  double length_m, offset, end_m;
  int count_max;
} np_cloud_steps;

/* Clouds along a ray, in the scaled medium. */
typedef struct np_cloud_view {
  np_spectrum light;   /* scattered by the clouds, W m⁻² sr⁻¹ nm⁻¹ */
  np_spectrum emitted; /* radiance of emission, not scattered */
  float transmittance; /* transmittance of the clouds along the ray */
  float middle_m;      /* mean distance of the clouds' opacity; 0 without clouds */
} np_cloud_view;

/* Marches from an origin. */
np_cloud_view np_cloud_gather_follow(const np_cloud_gather *gather, const np_cloud_direction *direction,
                                     np_dvec3 origin, const np_cloud_steps *steps);

/* Distance of the ground along a ray; infinite where there is none. */
double np_cloud_gather_find_ground(const np_cloud_gather *gather, np_dvec3 origin, np_vec3 direction,
                                   np_ground_hit *out_hit);

/* Radiance of a hill under a clear sky and the dimmed sun. */
np_spectrum np_cloud_gather_light_hill(const np_cloud_gather *gather, const np_ground_hit *hill);

/* Clips a ray to the clouds' box, which has no sides where they repeat; false when it misses. */
bool np_cloud_gather_clip(const np_cloud_gather *gather, np_dvec3 origin, np_vec3 direction, double *out_begin,
                          double *out_end);

/* Scaled extinction of all clouds at a place, 1/m, and of each cloud. */
float np_cloud_gather_extinction(const np_cloud_gather *gather, np_dvec3 position, float extinction[NP_INSTANCES_MAX]);

/* The shortest edge of a voxel, m. */
double np_cloud_gather_compute_voxel(const np_world *world);

/* Ground below a place; sea level where there is none. */
np_dvec3 np_cloud_gather_ground(const np_cloud_gather *gather, double x, double y);

#endif

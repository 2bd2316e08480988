/* SPDX-License-Identifier: Apache-2.0 */
/* Reference of the sky's tables: a backward Monte Carlo of the spherical atmosphere, and order 1 by quadrature.
 * Double precision; shares with the tables the description of the air and the geometry of a ray, and takes from them
 * only the importance of directions. */
#ifndef NP_ATMOSPHERE_SKY_REFERENCE_H
#define NP_ATMOSPHERE_SKY_REFERENCE_H

#include "atmosphere/reference_path.h"
#include "core/parallel.h"

typedef enum np_reference_light {
  NP_REFERENCE_DISK,  /* a disk of even radiance */
  NP_REFERENCE_POINT, /* a point that fades over the disk's width at the horizon, as others compute it and the tables do
                       */
  NP_REFERENCE_FURNACE /* radiance 1 from everywhere in space; the sun is not asked for */
} np_reference_light;

typedef struct np_reference_scene {
  const np_medium *medium;
  np_reference_light light;
  np_dvec3 to_sun; /* unit vector */
  double sun_angular_radius_rad;
  unsigned order_min, order_max; /* which are summed, from 1; a bounce on the ground is one */
  const np_depth_table *guide;   /* where to look for sunlight; NULL: everywhere alike */
  bool has_ground;               /* with what the ground at the end of the first ray sends back */
} np_reference_scene;

enum { NP_REFERENCE_ORDERS_ALL = 100000 };

typedef struct np_reference_query {
  np_dvec3 origin, direction; /* world; for irradiance the direction is not used */
  double distance_m;          /* the ray ends here at the latest */
  bool is_irradiance;         /* on a level plane at `origin`, facing up */
} np_reference_query;

typedef struct np_reference_value {
  double mean[NP_REFERENCE_BANDS], error[NP_REFERENCE_BANDS]; /* per unit of sun irradiance; standard error */
} np_reference_value;

/* Traces about `paths` paths (whole batches of them). The same seed gives the same bits for any number of threads. */
neph_result np_reference_trace(neph_context *context, np_monitor *monitor, const np_reference_scene *scene,
                               const np_reference_query *query, unsigned paths, uint64_t seed,
                               np_reference_value *out_value);

/* Order 1 of a ray's in-scatter by quadrature, panels doubled until the result moves by less than `tolerance` of it. */
void np_reference_first_order(const np_reference_scene *scene, const np_reference_query *query, double tolerance,
                              double out_radiance[NP_REFERENCE_BANDS]);

/* All the orders wanted of a ray's radiance: the first by quadrature where it is among them, the rest traced. */
neph_result np_reference_radiance(neph_context *context, np_monitor *monitor, const np_reference_scene *scene,
                                  const np_reference_query *query, unsigned paths, uint64_t seed,
                                  np_reference_value *out_value);

/* Transmittance along a ray to its end; 0, where the ray is to reach space, behind the planet. */
void np_reference_transmittance(const np_medium *medium, const np_reference_query *query, bool is_to_space,
                                double out_transmittance[NP_REFERENCE_BANDS]);

/* Sunlight at a point on a plane across the sun's rays, per unit of irradiance above the air. Not in a furnace. */
void np_reference_sunlight(const np_reference_scene *scene, np_dvec3 position, double out_light[NP_REFERENCE_BANDS]);

#endif

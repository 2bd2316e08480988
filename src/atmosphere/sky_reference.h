/* SPDX-License-Identifier: Apache-2.0 */
/* Reference for the sky's tables: backward Monte Carlo in a spherical atmosphere, and order 1 by quadrature, in double
 * precision. It shares the description of the air and the geometry of rays with the tables, and takes only the
 * importance of directions from them. */
#ifndef NP_ATMOSPHERE_SKY_REFERENCE_H
#define NP_ATMOSPHERE_SKY_REFERENCE_H

#include "atmosphere/reference_path.h"
#include "core/parallel.h"

typedef enum np_reference_light {
  NP_REFERENCE_DISK,   /* a disk of uniform radiance */
  NP_REFERENCE_POINT,  /* a point that fades over the disk's width at the horizon, as in other models and in the tables
                        */
  NP_REFERENCE_FURNACE /* radiance 1 from all of space; no sun */
} np_reference_light;

typedef struct np_reference_scene {
  const np_medium *medium;
  np_reference_light light;
  np_dvec3 to_sun; /* unit vector */
  double sun_angular_radius_rad;
  unsigned order_min, order_max; /* range of orders that are summed, from 1; a bounce on the ground is one */
  const np_depth_table *guide;   /* importance of sunlight; NULL: uniform */
  bool has_ground;               /* includes light reflected by the ground at the end of the first ray */
} np_reference_scene;

enum { NP_REFERENCE_ORDERS_ALL = 100000 };

typedef struct np_reference_query {
  np_dvec3 origin, direction; /* in the world; irradiance does not use the direction */
  double distance_m;          /* upper limit of the ray's length */
  bool is_irradiance;         /* irradiance on a horizontal plane at `origin`, facing up */
} np_reference_query;

typedef struct np_reference_value {
  double mean[NP_REFERENCE_BANDS], error[NP_REFERENCE_BANDS]; /* per unit of solar irradiance; standard error */
} np_reference_value;

/* Traces about `paths` paths (in whole batches). Equal seeds give equal bits for any number of threads. */
neph_result np_reference_trace(neph_context *context, np_monitor *monitor, const np_reference_scene *scene,
                               const np_reference_query *query, unsigned paths, uint64_t seed,
                               np_reference_value *out_value);

/* Order 1 of a ray's in-scatter by quadrature. Panels are doubled until the result changes by less than `tolerance`,
 * relative. */
void np_reference_first_order(const np_reference_scene *scene, const np_reference_query *query, double tolerance,
                              double out_radiance[NP_REFERENCE_BANDS]);

/* The requested orders of a ray's radiance: the first by quadrature if it is among them, the others by tracing. */
neph_result np_reference_radiance(neph_context *context, np_monitor *monitor, const np_reference_scene *scene,
                                  const np_reference_query *query, unsigned paths, uint64_t seed,
                                  np_reference_value *out_value);

/* Transmittance along a ray to its end; 0 for a ray to space that the planet blocks. */
void np_reference_transmittance(const np_medium *medium, const np_reference_query *query, bool is_to_space,
                                double out_transmittance[NP_REFERENCE_BANDS]);

/* Sunlight at a point on a plane that faces the sun, per unit of irradiance above the atmosphere; not for a furnace. */
void np_reference_sunlight(const np_reference_scene *scene, np_dvec3 position, double out_light[NP_REFERENCE_BANDS]);

#endif

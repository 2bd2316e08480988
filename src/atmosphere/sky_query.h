/* SPDX-License-Identifier: Apache-2.0 */
/* Queries of a sky, answered by its tables, by a march over their sources, or by the path tracer. */
#ifndef NP_ATMOSPHERE_SKY_QUERY_H
#define NP_ATMOSPHERE_SKY_QUERY_H

#include "atmosphere/atmosphere_tables.h"
#include "atmosphere/sky_reference.h"

typedef enum np_sky_quantity {
  NP_SKY_TRANSMITTANCE_TOP,
  NP_SKY_SINGLE_SCATTER_RADIANCE,
  NP_SKY_RADIANCE,
  NP_SKY_IRRADIANCE,
  NP_SKY_DIRECT_IRRADIANCE,
  NP_SKY_AP_INSCATTER,
  NP_SKY_AP_TRANSMITTANCE,
  NP_SKY_QUANTITY_COUNT
} np_sky_quantity;

typedef enum np_sky_method {
  NP_SKY_LUT,   /* tables alone, as in pictures */
  NP_SKY_MARCH, /* quadrature along the ray, to 1e-5 for orders up to 1; sources of later orders from the tables */
  NP_SKY_TRACE  /* path tracer of sky_reference.h */
} np_sky_method;

typedef struct np_sky_query {
  np_sky_quantity quantity;
  unsigned order_max; /* NP_ORDERS_ALL: all */
  double altitude_m;
  double view_cosine;                                  /* cosine of the zenith angle, for a transmittance */
  double sun_zenith_rad, view_zenith_rad, azimuth_rad; /* azimuth from the sun's */
  double distance_m;
} np_sky_query;

/* An atmosphere with its sun and the last sky built, to which queries are put; its skies hold the orders of the query.
 */
typedef struct np_sky_subject {
  neph_atmosphere *atmosphere; /* borrowed */
  np_reference_light light;
  double sun_angular_radius_rad;
  double irradiance_w_m2_nm[3];
  np_sky_method method;
  unsigned paths;
  neph_sky *sky; /* owned; for `sky_altitude_m` and `sky_sun_rad` */
  double sky_altitude_m, sky_sun_rad;
} np_sky_subject;

/* Whether a quantity is scattered light, to which limits of order apply. */
bool np_sky_quantity_is_scattered(np_sky_quantity quantity);

neph_result np_sky_query_eval(np_sky_subject *subject, const np_sky_query *query, uint64_t seed, np_monitor *monitor,
                              np_reference_value *out_value);
void np_sky_subject_clear(np_sky_subject *subject);

#endif

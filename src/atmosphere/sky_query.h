/* SPDX-License-Identifier: Apache-2.0 */
/* Queries about a sky, put to the tables, to a march over their sources, or to the tracer. */
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
  NP_SKY_LUT,   /* as pictures have it: every number from a table */
  NP_SKY_MARCH, /* along the ray by quadrature, to 1e-5 where order 1 or less is asked for; later orders' sources from
                 * the tables */
  NP_SKY_TRACE  /* sky_reference.h */
} np_sky_method;

typedef struct np_sky_query {
  np_sky_quantity quantity;
  unsigned order_max; /* NP_ORDERS_ALL: all */
  double altitude_m;
  double view_cosine;                                  /* of a transmittance's zenith angle */
  double sun_zenith_rad, view_zenith_rad, azimuth_rad; /* azimuth from the sun's */
  double distance_m;
} np_sky_query;

/* The subject of queries: an atmosphere (whose skies hold as many orders as the query requires), its sun, and the last
 * sky built.
 */
typedef struct np_sky_witness {
  neph_atmosphere *atmosphere; /* borrowed */
  np_reference_light light;
  double sun_angular_radius_rad;
  double irradiance_w_m2_nm[3];
  np_sky_method method;
  unsigned paths;
  neph_sky *sky; /* owned: of `sky_altitude_m` and `sky_sun_rad` */
  double sky_altitude_m, sky_sun_rad;
} np_sky_witness;

/* Whether a query is about scattered light, which orders are counted for. */
bool np_sky_quantity_is_scattered(np_sky_quantity quantity);

neph_result np_sky_ask(np_sky_witness *witness, const np_sky_query *query, uint64_t seed, np_monitor *monitor,
                       np_reference_value *out_value);
void np_sky_witness_clear(np_sky_witness *witness);

#endif

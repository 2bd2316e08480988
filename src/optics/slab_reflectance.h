/* SPDX-License-Identifier: Apache-2.0 */
/* Reflectance of plane-parallel slabs of cloud over a Lambertian ground, by optical depth.
 *
 * Values are bidirectional reflectance factors, π·L/(μ₀·F₀), of a beam F₀ at μ₀ seen at μ: 1 is a perfect white
 * diffuser's. */
#ifndef NP_OPTICS_SLAB_REFLECTANCE_H
#define NP_OPTICS_SLAB_REFLECTANCE_H

#include <nephos/context.h>

#include "optics/phase.h"

typedef struct np_slab_view {
  const np_phase *phase;
  double albedo;          /* single-scattering albedo, 0 to 1 */
  double ground_albedo;   /* 0 to 1 */
  double mu_sun, mu_view; /* cosines of the zenith angles of sun and viewer, 0.02 to 1 */
  double azimuth_rad;     /* azimuth of the viewer from the sun's, both as seen from the cloud */
} np_slab_view;

enum { NP_SLAB_DEPTHS = 60 };

/* Depths are 0, and rise by a factor of 2^¼ from 0.02 to 0.02·2^14.5, 463. */
typedef struct np_slab_table {
  double depths[NP_SLAB_DEPTHS], reflectances[NP_SLAB_DEPTHS];
} np_slab_table;

/* Computes a table by doubling. Its values are exact to 1e-3 of the true ones. */
neph_result np_slab_table_make(neph_context *context, const np_slab_view *view, np_slab_table *out_table);

/* Reflectance of a depth up to the last; linear in the logarithm of the depth, below the second one in the depth. */
double np_slab_table_eval(const np_slab_table *table, double depth);

/* Depth of a reflectance, between 0 and the last depth, for a table that rises everywhere. */
double np_slab_table_invert(const np_slab_table *table, double reflectance);

#endif

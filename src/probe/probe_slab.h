/* SPDX-License-Identifier: Apache-2.0 */
/* A plane-parallel slab of cloud, rendered by the integrators, and the light that leaves it. */
#ifndef NP_PROBE_PROBE_SLAB_H
#define NP_PROBE_PROBE_SLAB_H

#include <nephos/probe.h>

#include "core/parallel.h"

/* One case, lit by a beam or by a diffuse sky of unit irradiance on the slab's plane. */
typedef struct np_slab_case {
  double asymmetry, albedo, depth;
  bool is_diffuse;
  double mu0; /* the beam's, when not diffuse */
} np_slab_case;

/* One number about it: a flux through a face, or the scattered radiance that leaves a face in one direction. */
typedef struct np_slab_query {
  bool is_flux, is_top;
  double mu_view; /* magnitude */
  double phi_rad; /* between the directions of flight of the beam and of the leaving light */
} np_slab_query;

/* Number of contributions below which a result has no error estimate. */
#define NP_SLAB_CONTRIBUTIONS_MIN 16.0

typedef struct np_slab_answer {
  double value, error; /* standard error; infinite: unknown; 0: exact, as nothing is scattered */
  /* effective number of contributions: that of equally bright ones with the same standard error */
  double contributions;
} np_slab_answer;

typedef struct np_slab np_slab;

neph_result np_slab_create(neph_context *context, const np_slab_case *case_, const neph_probe_desc *desc,
                           np_slab **out_slab);
void np_slab_destroy(np_slab *slab);

/* Measures one quantity. `stream` separates the random numbers of queries. */
neph_result np_slab_ask(const np_slab *slab, const np_slab_query *query, uint32_t stream, np_monitor *monitor,
                        np_slab_answer *out_answer);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* A phase function split in two: a forward peak, and a broad rest of a low degree. */
#ifndef NP_TRANSPORT_SCALED_PHASE_H
#define NP_TRANSPORT_SCALED_PHASE_H

#include "core/context_private.h"
#include "optics/phase.h"
#include "transport/ordinates.h"
#include "transport/peak_column.h"

typedef struct np_scaled_phase {
  neph_context *context; /* borrowed */
  np_phase phase;
  unsigned degree;                  /* N, of the broad rest */
  float forward;                    /* f: share of scattering that counts as unscattered */
  float least_forward;              /* forward share at the least degree; not below f */
  float moments[NP_DEGREE_MAX + 1]; /* χ_l − f, l ≤ N */
  float *peak; /* [angle][depth]: light in the peak after two scatterings and more in it, per unit of e^{−τ} */
} np_scaled_phase;

/* The share f when the rest is of this degree. */
float np_scaled_phase_compute_forward(const np_phase *phase, unsigned degree);

neph_result np_scaled_phase_init(neph_context *context, const np_phase *phase, unsigned degree, np_scaled_phase *out);
void np_scaled_phase_clear(np_scaled_phase *scaled);

void np_scaled_phase_fill_column(const np_scaled_phase *scaled, float versine, np_peak_column *out);

#endif

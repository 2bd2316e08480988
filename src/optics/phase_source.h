/* SPDX-License-Identifier: Apache-2.0 */
/* Phase functions as they are asked for, by kind and parameters, for clouds and air alike: one row of
 * phase_source.c each. It makes an np_phase, which evaluates, samples and has moments. */
#ifndef NP_OPTICS_PHASE_SOURCE_H
#define NP_OPTICS_PHASE_SOURCE_H

#include "optics/phase.h"

typedef enum np_phase_kind {
  NP_PHASE_DROPLETS, /* the default of clouds */
  NP_PHASE_HENYEY_GREENSTEIN,
  NP_PHASE_TWO_LOBE,
  NP_PHASE_RAYLEIGH,
  NP_PHASE_ISOTROPIC,
  NP_PHASE_CORNETTE_SHANKS,
  NP_PHASE_DRAINE,
  NP_PHASE_TABLE, /* isotropic until its file is read */
  NP_PHASE_KIND_COUNT
} np_phase_kind;

typedef struct np_phase_source {
  np_phase_kind kind;
  double asymmetry;                          /* Henyey-Greenstein, Cornette-Shanks */
  double draine_asymmetry, alpha;            /* Draine */
  double forward, backward, backward_weight; /* two lobes */
  double diameter_m;                         /* droplets */
} np_phase_source;

np_phase np_phase_make(const np_phase_source *source);

#endif

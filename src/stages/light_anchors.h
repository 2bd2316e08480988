/* SPDX-License-Identifier: Apache-2.0 */
/* Solutions of the multiple scattering at both ends of a block of frames (plan/light_span.h), kept in the stores, each
 * by an assembly of its own. stage_ordinates.c blends them. */
#ifndef NP_STAGES_LIGHT_ANCHORS_H
#define NP_STAGES_LIGHT_ANCHORS_H

#include "caches/light_key.h"
#include "stages/assembly.h"

/* The light of a frame, solved for when it is an end of a block. */
typedef struct np_light_solution {
  unsigned slot; /* number of the light in its packet */
  np_light_key *key;
  np_scattering_field *field;
} np_light_solution;

/* The light of a frame that is an end of a block. */
typedef struct np_light_anchor {
  char id[33]; /* fingerprint of scene, settings and frame; empty: none */
  unsigned count;
  np_light_solution *solutions;
} np_light_anchor;

typedef struct np_light_anchors {
  np_light_anchor at[2];
} np_light_anchors;

/* Solves for the light at the ends of the job's span, unless the stores have it, and drops other solutions. */
neph_result np_light_anchors_solve(const neph_scene *scene, const np_plan *plan, const np_build_job *job,
                                   np_monitor *monitor);

#endif

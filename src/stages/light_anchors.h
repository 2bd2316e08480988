/* SPDX-License-Identifier: Apache-2.0 */
/* Frames between which the light in clouds is interpolated while the sun moves.
 *
 * Frames are divided into blocks of a power of two, counted from frame 0, as large as the sun and the moon turn by no
 * more than render.light_reuse in. The light is solved for at both ends of a block, and lies between them inside. Which
 * frames these are follows from the scene and the frame's number alone. */
#ifndef NP_STAGES_LIGHT_ANCHORS_H
#define NP_STAGES_LIGHT_ANCHORS_H

#include "caches/light_key.h"
#include "stages/assembly.h"

/* The light of a frame, solved for when it is an end of a block. */
typedef struct np_light_solution {
  unsigned slot; /* of the light of a packet */
  np_light_key *key;
  np_scattering_field *field;
} np_light_solution;

/* Chooses for the frame of a plan. Where light is not interpolated, a span of that frame. */
neph_result np_light_span_choose(const neph_scene *scene, const np_plan *plan, np_light_span *out);

/* Solves for the light at the ends of the plan's span that the stores do not have, and drops others. */
neph_result np_light_anchors_solve(const neph_scene *scene, const np_plan *plan, np_stores *stores,
                                   np_monitor *monitor);

/* The solutions of a light of a packet at both ends; false where either has none. */
bool np_light_anchors_get(const np_plan *plan, const np_stores *stores, unsigned slot, const np_light_solution *out[2]);

#endif

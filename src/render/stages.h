/* SPDX-License-Identifier: Apache-2.0 */
/* The stage table: all between a scene and a picture, one row a stage, in the order in which they are built.
 *
 * Decisions, --explain, the order of building, reuse between pictures, predicted time and memory, progress and cleanup
 * walk these rows; nothing else lists stages. A stage is built once for the picture, or for each light, each packet of
 * bands, or each light of each packet, or for several of these, in that order. It reads scene, plan and the results of
 * the stages that its row names in `needs`, and writes its own.
 */
#ifndef NP_RENDER_STAGES_H
#define NP_RENDER_STAGES_H

#include "render/stage_builders.h"
#include "render/stage_costs.h"
#include "render/stage_decisions.h"

/* A row without builders is a decision that others ask. */
typedef struct np_stage_row {
  const char *name;
  uint32_t needs; /* bits of the stages whose results it reads */
  bool is_of_sky; /* wanted for a sky alone, too */
  np_stage_decide_fn *decide;
  const char *reused_while;     /* the key by which later pictures use it again; NULL: built for each picture */
  double part_seconds;          /* predicted for each time it is built; memory next to nothing */
  np_stage_predict_fn *predict; /* NULL: by the above */
  np_stage_build_once_fn *build_once;
  np_stage_clear_once_fn *clear_once;
  np_stage_build_light_fn *build_light;
  np_stage_clear_light_fn *clear_light;
  np_stage_build_packet_fn *build_packet;
  np_stage_clear_packet_fn *clear_packet;
  np_stage_build_packet_light_fn *build_packet_light;
  np_stage_clear_packet_light_fn *clear_packet_light;
  np_stage_revise_fn *revise; /* NULL: always what was planned */
} np_stage_row;

const np_stage_row *np_stage_get_row(np_stage stage);

/* Times that a stage is built: once, for each light, each packet, each light of each packet. */
unsigned np_stage_count_parts(const np_stage_row *row, unsigned packets, unsigned lights);

/* Decides the stages of a plan that are not decided yet. */
neph_result np_stages_decide(np_plan *plan, const neph_scene *scene, const np_scene_facts *facts);

/* Predicts the costs of the stages that are needed. */
void np_stages_predict(np_plan *plan, const neph_scene *scene);

/* What they all take, as predicted. */
np_stage_cost np_stages_count_cost(const np_plan *plan);

#endif

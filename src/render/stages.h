/* SPDX-License-Identifier: Apache-2.0 */
/* The stage table: all between a scene and a picture, one row a stage, in the order in which they are built.
 *
 * Decisions, --explain, the order of building, reuse between pictures, predicted time and memory, progress and cleanup
 * walk these rows; nothing else lists stages. A stage is built once for the picture, or for each cloud, each light,
 * each packet of bands, or each light of each packet, or for several of these, in that order. It reads scene, plan and
 * the results of the stages that its row names in `needs`, and writes its own.
 */
#ifndef NP_RENDER_STAGES_H
#define NP_RENDER_STAGES_H

#include "render/stage_decisions.h"
#include "render/stage_part.h"

/* A row without builders is a decision that others ask. */
typedef struct np_stage_row {
  const char *name;
  uint32_t needs;    /* bits of the stages whose results it reads */
  bool is_of_sky;    /* wanted for a sky alone, too */
  bool is_of_probes; /* built in the bands that colours are fitted by, too */
  np_stage_decide_fn *decide;
  np_stage_describe_fn *describe; /* of the reason, where it is needed; NULL: as decided */
  neph_work work;               /* by which its time goes */
  double part_seconds;          /* predicted of one core for each time it is built, … */
  double part_bytes;            /* … with the memory that it takes */
  np_stage_predict_fn *predict; /* NULL: by the above */
  np_stage_expect_fn *expect;   /* NULL: it adds no error */
  np_stage_build_fn *build[NP_PART_KINDS];
  np_stage_clear_fn *clear[NP_PART_KINDS];
  const np_stage_reuse *reuse; /* by later pictures; NULL: built for each */
  np_stage_revise_fn *revise;  /* NULL: always what was planned */
} np_stage_row;

const np_stage_row *np_stage_get_row(np_stage stage);

/* The parts of each kind that a picture has. */
typedef struct np_part_counts {
  unsigned of[NP_PART_KINDS];
} np_part_counts;

np_part_counts np_part_counts_make(unsigned clouds, unsigned lights, unsigned packets);

/* Whether a stage has parts of a kind. */
bool np_stage_has_kind(const np_stage_row *row, np_part_kind kind);

/* All parts of a stage. */
unsigned np_stage_count_parts(const np_stage_row *row, const np_part_counts *counts);

/* Decides the stages of a plan that are not decided yet. */
neph_result np_stages_decide(np_plan *plan, const neph_scene *scene, const np_scene_facts *facts);

/* Predicts errors and costs of the stages that are needed, the picture's bias and noise, and its samples. */
void np_stages_predict(np_plan *plan, const neph_scene *scene);

/* Predicted cost of all stages. */
np_stage_cost np_stages_count_cost(const np_plan *plan);

#endif

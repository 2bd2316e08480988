/* SPDX-License-Identifier: Apache-2.0 */
/* The rules of the stages: all between a scene and a picture, one row a stage, in the order in which they are built.
 *
 * Decisions, --explain, predicted time, memory and error walk these rows. The functions that build a stage and clear it
 * are a row of stage_makers.c. A stage is built once for the picture, or for each cloud, each light, each packet of
 * bands, or each light of each packet, or for several of these, in that order. It reads scene, plan and the results of
 * the stages that stage_needs.h names for it, and writes its own.
 */
#ifndef NP_PLAN_STAGE_RULES_H
#define NP_PLAN_STAGE_RULES_H

#include "plan/stage_decisions.h"

/* The parts of a stage: one for the picture, or one for each of these. */
typedef enum np_part_kind {
  NP_PER_PICTURE,
  NP_PER_CLOUD,
  NP_PER_LIGHT,
  NP_PER_PACKET,
  NP_PER_PACKET_LIGHT,
  NP_PART_KINDS
} np_part_kind;

/* A rule without parts is a decision that other rules read. */
typedef struct np_stage_rule {
  const char *name;
  uint32_t needs;    /* bits of the stages whose results it reads */
  bool is_of_sky;    /* needed for a picture of the sky alone, too */
  bool is_of_probes; /* built in the bands that colours are fitted by, too */
  np_stage_decide_fn *decide;
  np_stage_describe_fn *describe; /* adds the reason of a needed stage; NULL: the reason is as decided */
  neph_work work;                 /* kind of its work */
  np_stage_count_fn *count;       /* counts the stage's units of work; NULL: one unit `part_cost` for each part */
  np_cost_unit part_cost;
  np_stage_expect_fn *expect; /* NULL: it adds no error */
  uint32_t parts;             /* bits of np_part_kind */
  const char *reused_while;   /* condition under which later pictures reuse it; NULL: built for each picture */
} np_stage_rule;

const np_stage_rule *np_stage_get_rule(np_stage stage);

/* The parts of each kind that a picture has. */
typedef struct np_part_counts {
  unsigned of[NP_PART_KINDS];
} np_part_counts;

np_part_counts np_part_counts_make(unsigned clouds, unsigned lights, unsigned packets);

/* Whether a stage has parts of a kind. */
static inline bool np_stage_has_kind(const np_stage_rule *rule, np_part_kind kind) { return rule->parts >> kind & 1u; }

/* All parts of a stage. */
unsigned np_stage_count_parts(const np_stage_rule *rule, const np_part_counts *counts);

#endif

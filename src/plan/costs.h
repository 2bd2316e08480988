/* SPDX-License-Identifier: Apache-2.0 */
/* The model of cost: stages count units of work, and one table has the seconds and the bytes of a unit. */
#ifndef NP_PLAN_COSTS_H
#define NP_PLAN_COSTS_H

#include "plan/cost_table.h"

#define NP_COST_UNIT(id, name, seconds, bytes) NP_UNIT_##id,
typedef enum np_cost_unit { NP_COST_ROWS(NP_COST_UNIT) NP_UNIT_COUNT } np_cost_unit;
#undef NP_COST_UNIT

/* Units of each kind. */
typedef struct np_cost_counts {
  double of[NP_UNIT_COUNT];
} np_cost_counts;

/* Predicted cost of a stage: seconds of one core, and bytes that remain allocated during rendering. 0: negligible, or
 * unknown. */
typedef struct np_stage_cost {
  double seconds, bytes;
} np_stage_cost;

/* Name of a unit, in the plural: "voxels in boxes of bakes". */
const char *np_cost_unit_get_name(np_cost_unit unit);

/* Cost of all units by the constants of the table. */
np_stage_cost np_costs_sum(const np_cost_counts *counts);

#endif

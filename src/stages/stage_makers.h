/* SPDX-License-Identifier: Apache-2.0 */
/* The makers of the stages: functions that build, clear, reuse and complete the parts that a stage's rule names. The
 * walk over them is assembly.c. */
#ifndef NP_STAGES_STAGE_MAKERS_H
#define NP_STAGES_STAGE_MAKERS_H

#include "stages/stage_part.h"

/* Empty for a rule without parts. */
typedef struct np_stage_maker {
  np_stage_build_fn *build[NP_PART_KINDS];
  np_stage_clear_fn *clear[NP_PART_KINDS];
  const np_stage_reuse *reuse;     /* reuse by later pictures; NULL: built for each */
  const np_stage_salvage *salvage; /* NULL: nothing of a result serves the next */
  np_stage_finish_fn *finish;      /* NULL: its parts are all of it */
} np_stage_maker;

const np_stage_maker *np_stage_get_maker(np_stage stage);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/stage_part.h"

/* Functions that fill the inputs of each stage. */
#define SET(type, name, source) .name = (source),
#define SET_ALL(STAGE) NP_RESULT_##STAGE(SET)
#define FILL(stage, STAGE)                                                                                             \
  static void fill_##stage(np_stage_task *at) {                                                                        \
    const np_stage_part part = at->in.part;                                                                            \
    at->in.stage = (np_##stage##_inputs){.part = part, NP_NEEDS_##STAGE(SET_ALL) NP_RESULT_##STAGE(SET)};              \
  }

NP_INPUTS_OF_STAGES(FILL)

#define ROW(stage, STAGE) [NP_STAGE_##STAGE] = fill_##stage,

static void (*const fills[NP_STAGE_COUNT])(np_stage_task *at) = {NP_INPUTS_OF_STAGES(ROW)};

void np_stage_inputs_fill(np_stage stage, np_stage_task *at) {
  if (fills[stage]) fills[stage](at);
}

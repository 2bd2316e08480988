/* SPDX-License-Identifier: Apache-2.0 */
/* Reuse of the results of a stage by later pictures. */
#ifndef NP_RENDER_STAGE_REUSE_H
#define NP_RENDER_STAGE_REUSE_H

#include "render/stages.h"

/* Takes from the stores what serves a part of this picture; what is to be rebuilt, and why, is logged. */
neph_result np_stage_take_kept(const np_stage_row *row, const np_stage_part *part);

/* Makes the result of a part unless it was taken. */
neph_result np_stage_make_missing(const np_stage_reuse *reuse, const np_stage_part *part);

/* Gives the result of a part back to the stores, or destroys it where it has no key. */
void np_stage_give(const np_stage_reuse *reuse, const np_stage_part *part);

#endif

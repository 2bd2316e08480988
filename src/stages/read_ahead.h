/* SPDX-License-Identifier: Apache-2.0 */
/* Files of the frame that follows, read by the system while a frame's pixels are rendered.
 *
 * They go to the page cache, which gives way to whoever needs memory: the process holds one frame's clouds. Unpacking
 * them is left to their own frame, and so is whatever is wrong with them. */
#ifndef NP_STAGES_READ_AHEAD_H
#define NP_STAGES_READ_AHEAD_H

#include "plan/plan_parts.h"

void np_read_ahead(const neph_scene *scene, const np_plan *plan);

#endif

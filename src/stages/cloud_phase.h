/* SPDX-License-Identifier: Apache-2.0 */
/* Phase functions of a cloud: of its source, by bands or from a table, and of the ice in its cold part. */
#ifndef NP_STAGES_CLOUD_PHASE_H
#define NP_STAGES_CLOUD_PHASE_H

#include "stages/stage_inputs.h"

/* Fills the phase functions of `parts`, whose volume is loaded, and its placement's own. */
neph_result np_cloud_phase_load(const np_volumes_inputs *in, const np_scene_cloud *cloud, np_cloud_parts *parts);

#endif

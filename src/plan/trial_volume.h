/* SPDX-License-Identifier: Apache-2.0 */
/* One cloud of a trial: a bake of few voxels, or a file of few. */
#ifndef NP_PLAN_TRIAL_VOLUME_H
#define NP_PLAN_TRIAL_VOLUME_H

#include "plan/inputs.h"

/* A volume of a trial. */
typedef struct np_trial_volume {
  neph_volume *volume;   /* owned; NULL: none */
  double share_across;   /* share of the bake's extent that is baked and repeated along x and y; else 1 */
  neph_cloud_desc bake;  /* description of a bake, of the part that was baked */
  neph_terrain *terrain; /* coarse ground under a bake; owned; NULL: the bake does not follow it */
} np_trial_volume;

void np_trial_volume_clear(np_trial_volume *volume);

/* `out->volume` is NULL where a file has too many voxels to be read twice, or is damaged, which the render reports.
 * Messages are not passed on. */
neph_result np_trial_volume_make(const neph_scene *scene, const np_request *request, const np_scene_cloud *cloud,
                                 const np_input_file *file, np_trial_volume *out);

#endif

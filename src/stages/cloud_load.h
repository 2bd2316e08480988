/* SPDX-License-Identifier: Apache-2.0 */
/* The volume of a cloud, read from a file or baked, with the colours and the sizes of droplets that the file has. */
#ifndef NP_STAGES_CLOUD_LOAD_H
#define NP_STAGES_CLOUD_LOAD_H

#include "plan/cloud_source.h"
#include "stages/stage_inputs.h"

/* Describes the bake of a cloud for a picture; progress callbacks are not set. */
neph_bake_desc np_cloud_load_describe_bake(const np_plan *plan, const neph_scene *scene, const np_scene_cloud *cloud);

/* Reading of a cloud's file as a part of a picture. */
neph_volume_load_desc np_cloud_load_describe(const np_volumes_inputs *in, const np_scene_cloud *cloud);

/* Loads the cloud of a frame: from disk if it is there, else by a bake, to disk if the scene names a file; NULL: the
 * cloud is empty. */
neph_result np_cloud_load(const np_volumes_inputs *in, const np_scene_cloud *cloud, const char *path,
                          np_cloud_source source, neph_volume **out_volume);

#endif

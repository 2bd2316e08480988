/* SPDX-License-Identifier: Apache-2.0 */
/* Whether the files that a scene names are there; what is in them is seen by who reads them. */
#ifndef NP_SCENE_SCENE_INPUTS_H
#define NP_SCENE_SCENE_INPUTS_H

#include "scene/scene_node.h"
#include "scene/scene_private.h"

/* Whether a cloud's file of one frame can be opened; fails at the cloud's vdb in the scene. neph_scene_check_files is
 * the same of the files that have one name in all frames. */
neph_result np_scene_check_cloud_file(const neph_scene *scene, unsigned index, const char *path);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds of a scene baked to files. */
#ifndef NP_STAGES_CLOUD_BAKE_H
#define NP_STAGES_CLOUD_BAKE_H

#include "scene/cloud_ground.h"
#include "scene/scene_private.h"

/* Levels of detail that a scene's cloud is baked to a file in. */
typedef enum np_bake_levels {
  NP_BAKE_LEVELS_NONE, /* the whole field in the smallest voxels */
  NP_BAKE_LEVELS_OWN   /* levels of the scene */
} np_bake_levels;

/* Description of a cloud in a frame, on its ground. */
typedef struct np_cloud_in_frame {
  neph_cloud_desc desc;
  np_cloud_ground ground;
  neph_terrain *terrain; /* NULL: it does not affect the cloud */
} np_cloud_in_frame;

/* Describes a baked cloud of a scene that is evaluated in a frame. `out` must stay where it is until it is cleared, in
 * any case. */
neph_result np_cloud_in_frame_make(const neph_scene *scene, unsigned cloud_index, int frame, np_cloud_in_frame *out);
void np_cloud_in_frame_clear(np_cloud_in_frame *cloud);

/* Bakes a cloud of a scene that is evaluated in a frame, on its ground. `desc` may be NULL. */
neph_result np_cloud_bake_to_file(const neph_scene *scene, unsigned cloud_index, int frame, const neph_bake_desc *desc,
                                  np_bake_levels levels, const char *path);

#endif

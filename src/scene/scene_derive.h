/* SPDX-License-Identifier: Apache-2.0 */
/* Derived members of a scene, which may differ from frame to frame. */
#ifndef NP_SCENE_SCENE_DERIVE_H
#define NP_SCENE_SCENE_DERIVE_H

#include "scene/scene_private.h"

/* Derives all dependent values of a scene. Lists that it allocates must be empty before. */
neph_result np_scene_derive(neph_scene *scene);

/* Derives members of a cloud that depend on its own keys alone. */
void np_scene_derive_cloud(np_scene_cloud *cloud);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Makers of textures: each adds those of one kind to a set. */
#ifndef NP_EXPORT_TEXTURE_MAKERS_H
#define NP_EXPORT_TEXTURE_MAKERS_H

#include "export/texture_set.h"
#include "scene/scene_private.h"

/* A scene in its frame. */
typedef struct np_texture_scene {
  const neph_scene *scene;
  int frame;
} np_texture_scene;

/* Cubes of noise, and blue noise. */
neph_result np_texture_noise_add(np_texture_set *set, const np_texture_scene *of);

/* Tables of the air and of the sky from the camera; none where the scene has no air. */
neph_result np_texture_sky_add(np_texture_set *set, const np_texture_scene *of);

/* Textures of each baked cloud. */
neph_result np_texture_clouds_add(np_texture_set *set, const np_texture_scene *of);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Fingerprint of all that determines the bits of a picture, whatever part of it is rendered. */
#ifndef NP_PLAN_SCENE_HASH_H
#define NP_PLAN_SCENE_HASH_H

#include "plan/plan_parts.h"

/* Attribute of a finished picture that holds it. */
#define NP_SCENE_HASH "nephos:sceneHash"

/* Hash of the scene's keys but those of file names and previews, the contents of the files that the frame is rendered
 * from, the checked description and what its plan gave up to stay within its memory, the version of nephos and the
 * instruction-set level. Empty where an object that a call gave to the scene has a part in it. */
neph_result np_scene_hash_compute(const neph_scene *scene, const neph_render_desc *desc, const char *savings,
                                  char out_hex[33]);

#endif

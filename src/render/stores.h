/* SPDX-License-Identifier: Apache-2.0 */
/* All that one picture leaves to the next: skies, light in clouds, reference frames. One picture at a time uses it. */
#ifndef NP_RENDER_STORES_H
#define NP_RENDER_STORES_H

#include "atmosphere/sky_store.h"
#include "caches/light_store.h"
#include "render/reference_store.h"

typedef struct np_stores {
  np_sky_store skies;
  np_light_store lights;
  np_reference_store references;
} np_stores;

/* Those that go with a scene: created when they are first asked for, destroyed with the scene. */
neph_result np_stores_get(const neph_scene *scene, np_stores **out_stores);

/* A zeroed one is empty. */
void np_stores_clear(neph_context *context, np_stores *stores);

#endif

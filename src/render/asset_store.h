/* SPDX-License-Identifier: Apache-2.0 */
/* Volumes and a terrain cached from one picture to the next, and reused while their sources are the same: a file by
 * path, size, time of change and how it is read; what is made from parameters by all of these.
 *
 * Before a picture's volumes are loaded, those that it has no use for are released, so that no picture needs more
 * memory than it would alone.
 */
#ifndef NP_RENDER_ASSET_STORE_H
#define NP_RENDER_ASSET_STORE_H

#include "scene/scene_private.h"
#include "volume/instance.h"

enum { NP_ASSET_KEY_SIZE = 33 };

typedef struct np_stored_volume {
  char key[NP_ASSET_KEY_SIZE]; /* fingerprint of the source; empty: none */
  neph_volume *volume;         /* NULL: none */
} np_stored_volume;

typedef struct np_asset_store {
  np_stored_volume volumes[NP_INSTANCES_MAX]; /* of each cloud */
  char terrain_key[NP_ASSET_KEY_SIZE];
  neph_terrain *terrain; /* NULL: none */
} np_asset_store;

/* Keeps what the clouds of a scene may use again in a frame, each at its place, and releases all else. */
neph_result np_asset_store_select(np_asset_store *store, const neph_scene *scene, int frame);

/* The volume of a cloud, one reference, for the caller; NULL: it is to be made. */
neph_volume *np_asset_store_take_volume(np_asset_store *store, unsigned index);

/* Keeps a volume that was made for a cloud, for a file as it is now. NULL is allowed. */
neph_result np_asset_store_put_volume(np_asset_store *store, const neph_scene *scene, unsigned index, int frame,
                                      neph_volume *volume);

/* The terrain of a scene, one reference, for the caller; NULL: it is to be made, and none is kept any more. */
neph_result np_asset_store_take_terrain(np_asset_store *store, const neph_scene *scene, neph_terrain **out_terrain);

/* Keeps a terrain that was made for the scene that the last was asked for. */
void np_asset_store_put_terrain(np_asset_store *store, neph_terrain *terrain);

void np_asset_store_clear(np_asset_store *store);

#endif

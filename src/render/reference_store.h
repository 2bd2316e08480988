/* SPDX-License-Identifier: Apache-2.0 */
/* The reference frames of a scene's imported sequences: each gives position, scale and optical depth to all frames of
 * its sequence. They are kept from picture to picture, so that the first frame asked for goes on to serve the others,
 * and its file is read once.
 */
#ifndef NP_RENDER_REFERENCE_STORE_H
#define NP_RENDER_REFERENCE_STORE_H

#include "volume/instance.h"
#include "scene/scene_private.h"

/* Placement of a cloud's files in the world, and the meaning of their values. */
typedef struct np_anchor {
  np_affine file_to_world;
  float extinction_per_value; /* 1/m; of optical_depth alone, else 0: then it does not go by any frame */
} np_anchor;

typedef struct np_reference {
  char sequence[33]; /* fingerprint of the files that it is a frame of; empty: none yet */
  bool has_frame;    /* the first asked for that holds anything is known */
  int frame;
  char key[33]; /* fingerprint of all that the anchor depends on; empty: not computed yet */
  np_anchor anchor;
} np_reference;

typedef struct np_reference_store {
  np_reference list[NP_INSTANCES_MAX]; /* of each cloud */
} np_reference_store;

/* The reference of a cloud that is a sequence; begun anew where the cloud's files have become others. */
neph_result np_reference_store_get(np_reference_store *store, const neph_scene *scene, unsigned index,
                                   np_reference **out_reference);

/* The frame that the scene names, else the one that was chosen; false where there is neither yet. */
bool np_reference_get_frame(const np_scene_cloud *cloud, const np_reference *reference, int *out_frame);

#endif

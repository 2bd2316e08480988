/* SPDX-License-Identifier: Apache-2.0 */
/* All that one picture leaves to the next: results of stages by their keys, and reference frames. One picture at a time
 * uses it; a zeroed one is empty.
 *
 * A reference frame of an imported sequence gives position, scale and optical depth to all its frames: the first frame
 * asked for goes on to serve the others, and its file is read once. */
#ifndef NP_RENDER_STORES_H
#define NP_RENDER_STORES_H

#include "scene/scene_private.h"
#include "volume/instance.h"

/* Placement of a cloud's files in the world, and the meaning of their values. */
typedef struct np_anchor {
  np_affine file_to_world;
  float extinction_per_value; /* 1/m; of optical_depth alone, else 0: then it does not go by any frame */
} np_anchor;

typedef struct np_reference {
  struct np_reference *next;
  unsigned index;    /* of the cloud in its scene */
  char sequence[33]; /* fingerprint of the files that it is a frame of */
  bool has_frame;    /* the first asked for that holds anything is known */
  double number;     /* of its file */
  bool is_told;      /* that it was chosen so, in a warning */
  char key[33];      /* fingerprint of all that the anchor depends on; empty: not computed yet */
  np_anchor anchor;
} np_reference;

/* The reference of a cloud that is a sequence, added to a list where it is not yet there. */
neph_result np_references_get(np_reference **references, const neph_scene *scene, unsigned index,
                              np_reference **out_reference);

/* The file that the scene names, infinite for all of them, else the one that was chosen; false where there is neither
 * yet. */
bool np_reference_get_number(const np_scene_cloud *cloud, const np_reference *reference, double *out_number);

/* A result of a part of a stage. It is lent: who takes it owns it, and gives it back for the next picture. */
typedef struct np_stored_result {
  struct np_stored_result *next;
  const void *stage;             /* by which it is told from those of others */
  unsigned slot;                 /* of the part */
  void *key;                     /* one block; owned */
  void *result;                  /* NULL: lent, or not made yet */
  void (*destroy)(void *result); /* NULL changes nothing */
} np_stored_result;

/* The share of their boxes that baked clouds fill, as it was measured last. */
typedef struct np_stored_fill {
  char key[33]; /* of the clouds; empty: none was measured */
  double share;
} np_stored_fill;

typedef struct np_stores {
  np_stored_result *results;
  np_reference *references;
  np_stored_fill fill;
  void *light; /* solutions between which a sequence is interpolated (light_anchors.h); NULL: none */
  void (*destroy_light)(neph_context *context, void *light);
  void *history; /* the frame rendered last, from which the next takes pixels (history.h); NULL: none */
  void (*destroy_history)(neph_context *context, void *history);
} np_stores;

void np_stores_clear(neph_context *context, np_stores *stores);

/* The result of a part; NULL: none. */
np_stored_result *np_stores_search(const np_stores *stores, const void *stage, unsigned slot);

/* Adds a result that is still to be made, and owns its key: on failure that is freed. */
neph_result np_stores_add(neph_context *context, np_stores *stores, np_stored_result added);

/* Destroys those results of a stage that are lent and never came back, or those that were not taken. */
void np_stores_drop(neph_context *context, np_stores *stores, const void *stage, bool is_lent);

#endif

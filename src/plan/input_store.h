/* SPDX-License-Identifier: Apache-2.0 */
/* Facts about the inputs of a scene that plans and pictures leave to later ones. A zeroed store is empty.
 *
 * A reference frame of an imported sequence gives position, scale and optical depth to all its frames: the first frame
 * that is rendered goes on to serve the others, and its file is read once. */
#ifndef NP_PLAN_INPUT_STORE_H
#define NP_PLAN_INPUT_STORE_H

#include "plan/placement.h"

typedef struct np_reference {
  struct np_reference *next;
  unsigned index;    /* number of the cloud in its scene */
  char sequence[33]; /* fingerprint of the files that it is a frame of */
  bool has_frame;    /* the first rendered frame that is not empty is known */
  double number;     /* number of its file */
  bool is_told;      /* a warning has named it */
  char key[33];      /* fingerprint of all that the anchor depends on; empty: not computed yet */
  np_anchor anchor;
} np_reference;

/* The latest trial of clouds. */
typedef struct np_stored_trial {
  char key[33];           /* fingerprint of the clouds; empty: there is none */
  struct np_trial *trial; /* retained trial; NULL: no cloud has a place */
} np_stored_trial;

typedef struct np_input_store {
  np_reference *references;
  np_stored_trial trial;
} np_input_store;

void np_input_store_clear(neph_context *context, np_input_store *store);

/* The reference of a cloud that is a sequence, added to a list where it is not yet there. */
neph_result np_references_get(np_reference **references, const neph_scene *scene, unsigned index,
                              np_reference **out_reference);

/* Whether a file of its sequence gives a cloud's files place or scale. */
bool np_reference_is_used(const np_scene_cloud *cloud);

/* The reference of a cloud that is a sequence; NULL: the store is NULL or has none. */
neph_result np_references_search(const np_input_store *store, const neph_scene *scene, unsigned index,
                                 const np_reference **out_reference);

/* Number of the reference file: the scene's, or infinite for all files, else the chosen one; false if neither is known
 * yet. */
bool np_reference_get_number(const np_scene_cloud *cloud, const np_reference *reference, double *out_number);

#endif

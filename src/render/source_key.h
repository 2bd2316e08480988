/* SPDX-License-Identifier: Apache-2.0 */
/* The keys of volumes and terrains, which stay while their sources do: a file by path, size, time of change and how it
 * is read; what is made from parameters by all of these. */
#ifndef NP_RENDER_SOURCE_KEY_H
#define NP_RENDER_SOURCE_KEY_H

#include "render/stage_decisions.h"

typedef struct np_source_key {
  char hash[33]; /* fingerprint; empty: a file that is still to be written */
  np_cloud_source source;
} np_source_key;

/* Create a key, on failure too unless there is no memory for it. */
neph_result np_source_key_make_volume(const neph_scene *scene, unsigned index, int frame, np_cloud_source source,
                                      void **out_key);
neph_result np_source_key_make_terrain(const neph_scene *scene, void **out_key);

/* The fingerprint of a cloud that is made, or of its file as it is now. */
neph_result np_source_key_compute(const neph_scene *scene, unsigned index, int frame, np_source_key *out_key);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Macros for rows of the key table, and the tables of separate files. */
#ifndef NP_SCENE_SCENE_KEY_ROWS_H
#define NP_SCENE_SCENE_KEY_ROWS_H

#include "scene/scene_key.h"

#define SCENE(member)                                                                                                  \
  { offsetof(neph_scene, member), sizeof(((neph_scene *)0)->member) }

/* Lengths stay below 1e9 m, so that no square overflows a float. */
#define WITHIN(a, b)                                                                                                   \
  { a, b }
#define ANYWHERE                                                                                                       \
  { -1e9, 1e9 }
#define SIZE                                                                                                           \
  { 1e-6, 1e9 }

#define ASYMMETRY                                                                                                      \
  { -0.999999, 0.999999 }

/* Groups of mutually exclusive keys. */
enum {
  GROUP_SUN = 1,
  GROUP_DENSITY,
  GROUP_PHASE,
  GROUP_TERRAIN,
  GROUP_PROFILE,
  GROUP_TOP,
  GROUP_ALBEDO,
  GROUP_PLACE,
  GROUP_SHAPE,
  GROUP_MAP,
  GROUP_FILE
};

extern const np_choice np_booleans[]; /* false, true */
extern const np_choice np_mesh_ups[];

extern const np_key_table np_keys_first, np_keys_sky, np_keys_last; /* scene_keys.c */
extern const np_key_table np_keys_camera;
extern const np_key_table np_keys_clouds;
extern const np_key_table np_keys_shape;
extern const np_key_table np_keys_quality;
extern const np_key_table np_keys_output;
extern const np_key_table np_keys_frames;

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Kinds of terrain, one row each, and their creation from a scene's description (terrain_private.h intersects rays with
 * them). */
#ifndef NP_TERRAIN_TERRAIN_SOURCE_H
#define NP_TERRAIN_TERRAIN_SOURCE_H

#include <nephos/terrain.h>

#include "core/parallel.h"
#include "terrain/heightfield.h"

typedef enum np_terrain_kind {
  NP_TERRAIN_NONE,
  NP_TERRAIN_HEIGHTFIELD, /* height field of a file */
  NP_TERRAIN_RIDGES,      /* mountains from noise, eroded */
  NP_TERRAIN_MESH,        /* triangles of a file alone; with other kinds a mesh is part of the description */
  NP_TERRAIN_GIVEN,       /* set by a call, which has created it */
  NP_TERRAIN_KIND_COUNT
} np_terrain_kind;

/* Source of a terrain; each kind reads its own members. */
typedef struct np_terrain_source {
  np_terrain_kind kind;
  const char *file;               /* height field */
  const neph_ridges_desc *ridges; /* NULL: the default */
} np_terrain_source;

typedef struct np_terrain_row {
  const char *description; /* description for --explain; the file's name is added, where there is one */
  /* Checks the input by size and header alone, and computes its samples along x and y; NULL: no input. */
  neph_result (*check)(neph_context *context, const np_terrain_source *source, const neph_terrain_desc *desc,
                       unsigned out_size[2]);
  neph_result (*make_field)(neph_context *context, np_monitor *monitor, const np_terrain_source *source,
                            const neph_terrain_desc *desc, np_heightfield *out_field);
} np_terrain_row;

extern const np_terrain_row np_terrain_rows[NP_TERRAIN_KIND_COUNT];

/* Creates the ground of any kind but NP_TERRAIN_NONE. */
neph_result np_terrain_create(neph_context *context, const np_terrain_source *source, const neph_terrain_desc *desc,
                              neph_terrain **out_terrain);

/* Checks a description's mesh: its values, that its file exists and, by its header, is complete. */
neph_result np_terrain_check_mesh(neph_context *context, const neph_terrain_desc *desc);

/* Ground of heights saved on disk (np_heightfield_save_to_cache); NULL where the entry is too short. */
neph_result np_terrain_load_from_cache(neph_context *context, np_cache_entry *entry, const neph_terrain_desc *desc,
                                       neph_terrain **out_terrain);

#endif

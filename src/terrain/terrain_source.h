/* SPDX-License-Identifier: Apache-2.0 */
/* Kinds of terrain: one row each, from what a scene asks for to the ground behind the ray door (terrain_private.h). */
#ifndef NP_TERRAIN_TERRAIN_SOURCE_H
#define NP_TERRAIN_TERRAIN_SOURCE_H

#include <nephos/terrain.h>

#include "core/parallel.h"
#include "terrain/heightfield.h"

typedef enum np_terrain_kind {
  NP_TERRAIN_NONE,
  NP_TERRAIN_HEIGHTFIELD, /* of a file */
  NP_TERRAIN_RIDGES,      /* from noise, eroded */
  NP_TERRAIN_MESH,        /* triangles of a file alone; beside the others they are a part of the description */
  NP_TERRAIN_GIVEN,       /* made by a call: no field is made of it */
  NP_TERRAIN_KIND_COUNT
} np_terrain_kind;

/* A terrain as it is asked for; each kind reads its own members. */
typedef struct np_terrain_source {
  np_terrain_kind kind;
  const char *file;               /* height field */
  const neph_ridges_desc *ridges; /* NULL: the default */
} np_terrain_source;

typedef struct np_terrain_row {
  const char *description; /* for --explain; the file's name follows, where there is one */
  /* Whether its input is there and can be read, by size and header alone, and its samples along x and y; NULL: it reads
   * none. */
  neph_result (*check)(neph_context *context, const np_terrain_source *source, const neph_terrain_desc *desc,
                       unsigned out_size[2]);
  neph_result (*make_field)(neph_context *context, np_monitor *monitor, const np_terrain_source *source,
                            const neph_terrain_desc *desc, np_heightfield *out_field);
} np_terrain_row;

extern const np_terrain_row np_terrain_rows[NP_TERRAIN_KIND_COUNT];

/* Makes the ground of any kind but NP_TERRAIN_NONE. */
neph_result np_terrain_create(neph_context *context, const np_terrain_source *source, const neph_terrain_desc *desc,
                              neph_terrain **out_terrain);

/* Whether a description's mesh is sound, and its file there and, by its header, whole. */
neph_result np_terrain_check_mesh(neph_context *context, const neph_terrain_desc *desc);

/* The ground of heights that were kept on disk (np_heightfield_save_to_cache); NULL where the entry holds less. */
neph_result np_terrain_load_from_cache(neph_context *context, np_cache_entry *entry, const neph_terrain_desc *desc,
                                       neph_terrain **out_terrain);

#endif

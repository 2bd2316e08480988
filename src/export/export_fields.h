/* SPDX-License-Identifier: Apache-2.0 */
/* Grids of a cloud's file beside its density, as they are exported: in the world, in the units of the keys' defaults.
 *
 * The module stands above render, whose stores and bakes it uses; nothing of the library calls it. Entry points:
 * cloud_export.c (nephos/render.h), volumes_usd.c and scene_usd.c.
 */
#ifndef NP_EXPORT_EXPORT_FIELDS_H
#define NP_EXPORT_EXPORT_FIELDS_H

#include <nephos/render.h>

#include "scene/scene_private.h"
#include "volume/volume_private.h"

enum { NP_EXPORT_FIELDS_MAX = 6 };

/* One grid, or a vector's three. */
typedef struct np_export_field {
  neph_export_fields kind;
  unsigned component_count;
  np_sparse_grid components[3];
} np_export_field;

typedef struct np_export_fields {
  unsigned count;
  np_export_field list[NP_EXPORT_FIELDS_MAX];
} np_export_fields;

/* A cloud's file, and where it is. */
typedef struct np_export_source {
  const np_scene_cloud *cloud;
  const char *path;
  const np_affine *file_to_world;
  np_monitor *monitor;
} np_export_source;

/* Reads those that the scene renders: velocities, colours and sizes that the file has, and, of a cloud with emission,
 * its temperature, flame and emitted light. The caller clears them, whatever the outcome. */
neph_result np_export_fields_load(neph_context *context, const np_export_source *source, np_export_fields *out);
void np_export_fields_clear(np_export_fields *fields);

/* Adds the grids to write; returns their number, at most NP_EXPORT_FIELDS_MAX. */
size_t np_export_fields_list(const np_export_fields *fields, bool is_half, np_vdb_write_grid *out);

/* Bit mask of the kinds of all fields. */
unsigned np_export_fields_get_kinds(const np_export_fields *fields);

#endif

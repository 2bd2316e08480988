/* SPDX-License-Identifier: Apache-2.0 */
/* Meshes as ground: triangles in their places in the world, and exact meetings of rays with them.
 *
 * A mesh that is placed once has its vertices about the terrain's anchor; one that is placed more often has them about
 * its own middle, so that a place is as exact as its vertices are. Placements are rigid: a mesh does not bend with the
 * planet. */
#ifndef NP_TERRAIN_MESH_GROUND_H
#define NP_TERRAIN_MESH_GROUND_H

#include "mesh/mesh_file.h"
#include "terrain/terrain_private.h"

typedef struct np_mesh_ground {
  np_mesh_file file;               /* places are maps to the world, later to the anchor */
  np_dvec3 bounds_min, bounds_max; /* box in the world */
} np_mesh_ground;

/* Checks a description, and that its file exists; it is not read. */
neph_result np_mesh_ground_check(neph_context *context, const neph_terrain_desc *desc);

/* Loads desc->mesh_file and places it. On failure `*out` is empty. */
neph_result np_mesh_ground_load(neph_context *context, const neph_terrain_desc *desc, np_monitor *monitor,
                                np_mesh_ground *out);

/* Moves vertices and places from the world's origin to an anchor, to which rays are then relative. */
void np_mesh_ground_set_anchor(np_mesh_ground *ground, np_dvec3 anchor);
void np_mesh_ground_clear(np_mesh_ground *ground);

static inline bool np_mesh_ground_is_shared(const np_mesh *mesh) { return mesh->place_count > 1; }

/* Intersection of a ray with a triangle that Embree hits near `distance`. */
void np_mesh_ground_intersect(const np_mesh_ground *ground, size_t place, size_t triangle, np_dvec3 origin,
                              np_vec3 direction, double distance, np_terrain_hit *out_hit);

#endif

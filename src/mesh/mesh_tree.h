/* SPDX-License-Identifier: Apache-2.0 */
/* Triangles in a tree of boxes, for the distance to the nearest triangle and for the winding number. */
#ifndef NP_MESH_MESH_TREE_H
#define NP_MESH_MESH_TREE_H

#include "mesh/mesh_file.h"

typedef struct np_mesh_triangle {
  np_vec3 corners[3];
} np_mesh_triangle;

/* A leaf holds `count` triangles from `first` on; other nodes have their children at `first` and after it. The sum of
 * the area vectors approximates far triangles. */
typedef struct np_mesh_node {
  np_vec3 low, high, center, area;
  float radius; /* radius of a sphere about the centre that holds all triangles */
  uint32_t first, count;
} np_mesh_node;

typedef struct np_mesh_tree {
  neph_context *context; /* borrowed */
  size_t triangle_count, node_count;
  np_mesh_triangle *triangles;
  np_mesh_node *nodes;
} np_mesh_tree;

/* Collects triangles at their places, mapped by `turn`; triangles inverted by a mirrored place are turned back. */
neph_result np_mesh_tree_collect(const np_mesh_file *file, const np_affine *turn, np_mesh_tree *out_tree);

/* Builds the tree over the triangles, which it sorts. */
neph_result np_mesh_tree_build(np_mesh_tree *tree);
void np_mesh_tree_clear(np_mesh_tree *tree); /* a zeroed tree is allowed */

double np_mesh_tree_count_bytes(const np_mesh_tree *tree);

/* Distance to the nearest triangle, or `limit` where all are farther. */
float np_mesh_tree_compute_distance(const np_mesh_tree *tree, np_vec3 point, float limit);

/* Winding number: 1 inside a closed surface whose triangles turn counter-clockwise seen from outside, 0 outside, a
 * fraction near a hole. */
float np_mesh_tree_compute_winding(const np_mesh_tree *tree, np_vec3 point);

/* Number of edges that do not join two triangles of the same orientation, and the middle of the first; vertices at one
 * position are one. */
neph_result np_mesh_tree_count_open_edges(const np_mesh_tree *tree, size_t *out_count, np_vec3 *out_first);

#endif

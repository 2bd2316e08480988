/* SPDX-License-Identifier: Apache-2.0 */
/* The door to Assimp, in the program nephos_assimp: cameras, meshes and places of a file. */
#ifndef NP_MESH_ASSIMP_READER_H
#define NP_MESH_ASSIMP_READER_H

#include <stdbool.h>
#include <stddef.h>

#include "mesh/assimp_stream.h"

typedef struct np_assimp_scene np_assimp_scene; /* an open file; it is never closed */

/* Reads a file of any kind. `note_bytes` receives the size of each file opened for it. NULL, with a line of text, on
 * failure. */
const np_assimp_scene *np_assimp_open(const char *path, void (*note_bytes)(uint64_t bytes), const char **out_message);

size_t np_assimp_count_cameras(const np_assimp_scene *scene);
void np_assimp_describe_camera(const np_assimp_scene *scene, size_t index, np_assimp_camera *out_camera);
void np_assimp_get_pose(const np_assimp_scene *scene, size_t index, double seconds, np_assimp_pose *out_pose);

size_t np_assimp_count_meshes(const np_assimp_scene *scene);
void np_assimp_describe_mesh(const np_assimp_scene *scene, size_t index, np_assimp_mesh *out_mesh);

/* Vertices of a mesh with triangles: x, y, z of positions, and of normals. */
const float *np_assimp_get_positions(const np_assimp_scene *scene, size_t index);
const float *np_assimp_get_normals(const np_assimp_scene *scene, size_t index);

/* Receives some of the triangles, `count` vertices in all. */
typedef void (*np_assimp_visit_triangles)(void *user, const uint32_t *vertices, size_t count);
void np_assimp_visit_faces(const np_assimp_scene *scene, size_t index, np_assimp_visit_triangles visit, void *user);

typedef void (*np_assimp_visit_place)(void *user, const np_assimp_place *place);
void np_assimp_visit_places(const np_assimp_scene *scene, np_assimp_visit_place visit, void *user);

#endif

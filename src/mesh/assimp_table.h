/* SPDX-License-Identifier: Apache-2.0 */
/* The door to Assimp: a module of C functions, loaded on first need. assimp_reader.c alone includes its headers. */
#ifndef NP_MESH_ASSIMP_TABLE_H
#define NP_MESH_ASSIMP_TABLE_H

#include <stddef.h>
#include <stdint.h>

#include <nephos/base.h>

#define NP_ASSIMP_MODULE_VERSION 2u

/* Name of the module's file and of the function in it. */
#define NP_ASSIMP_MODULE_FILE "nephos_assimp.so"
#define NP_ASSIMP_MODULE_FUNCTION "nephos_assimp_module"

typedef struct np_assimp_scene np_assimp_scene; /* a file that was read */

typedef struct np_assimp_camera {
  const char *name;        /* valid while the scene is open */
  double vertical_fov_rad; /* 0: it has none */
  double begin_s, end_s;   /* of the keys by which it, or what holds it, moves; equal: it stands still */
} np_assimp_camera;

/* A camera in the world of its file. The axes are unit vectors. */
typedef struct np_assimp_pose {
  double at[3], forward[3], up[3];
} np_assimp_pose;

/* Vertices of a mesh in its own coordinates, valid while the scene is open. `normals` NULL: none. */
typedef struct np_assimp_mesh {
  const float *positions, *normals;    /* x, y, z of each */
  size_t vertex_count, triangle_count; /* polygons are cut into triangles */
} np_assimp_mesh;

typedef struct np_assimp_module {
  uint32_t version; /* NP_ASSIMP_MODULE_VERSION, checked before anything else is used */

  /* Reads a file, whatever its kind. NULL, with a line of text, on failure. */
  np_assimp_scene *(*open)(const char *path, char *out_message, size_t message_size);
  void (*close)(np_assimp_scene *scene); /* NULL is allowed */

  size_t (*count_cameras)(const np_assimp_scene *scene);
  void (*describe_camera)(const np_assimp_scene *scene, size_t index, np_assimp_camera *out_camera);

  /* False where it has no direction. */
  int (*get_pose)(const np_assimp_scene *scene, size_t index, double seconds, np_assimp_pose *out_pose);

  size_t (*count_meshes)(const np_assimp_scene *scene);
  void (*describe_mesh)(const np_assimp_scene *scene, size_t index, np_assimp_mesh *out_mesh);
  /* Its vertices, three a triangle. */
  void (*fill_triangles)(const np_assimp_scene *scene, size_t index, uint32_t *out_vertices);

  /* Nodes place meshes, each as often as it likes: `visit` is given a mesh and the rows of its map to the file. */
  void (*visit_places)(const np_assimp_scene *scene, void (*visit)(void *user, size_t mesh, const double map[3][4]),
                       void *user);
} np_assimp_module;

/* The only exported symbol of nephos_assimp.so. */
NEPH_API const np_assimp_module *nephos_assimp_module(void);

#endif

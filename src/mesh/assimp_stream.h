/* SPDX-License-Identifier: Apache-2.0 */
/* The program nephos_assimp, which reads a file by Assimp, and the stream that it answers with: records of this
 * machine, one behind the other. A request is the file's path and one of these words:
 *
 *   meshes                              np_assimp_counts; of each mesh np_assimp_mesh, positions, normals, triangles;
 *                                       of each place np_assimp_place
 *   cameras                             uint64_t, their number; of each np_assimp_camera
 *   poses CAMERA FIRST COUNT RATE       np_assimp_pose at the times (FIRST + i)/RATE
 */
#ifndef NP_MESH_ASSIMP_STREAM_H
#define NP_MESH_ASSIMP_STREAM_H

#include <stdint.h>

#define NP_ASSIMP_PROGRAM_FILE "nephos_assimp"
#define NP_ASSIMP_STREAM_VERSION 3u

/* Limits of the program: a constant for every file, and a factor on the bytes of the files that it opens. */
#define NP_ASSIMP_ROOM_BYTES UINT64_C(250000000)
#define NP_ASSIMP_ROOM_FACTOR 200u
#define NP_ASSIMP_TIME_S 10u
#define NP_ASSIMP_TIME_BYTES_PER_S 1000000u

/* First record. If the file could not be read, message_length characters of an error follow, and nothing else. */
typedef struct np_assimp_start {
  uint32_t version, message_length;
} np_assimp_start;

enum { NP_ASSIMP_NAME_BYTES = 1024, NP_ASSIMP_MESSAGE_BYTES = 256 };

typedef struct np_assimp_counts {
  uint64_t mesh_count, place_count;
} np_assimp_counts;

/* A mesh in its own coordinates; polygons are triangulated. Then follow x, y, z of each position, and of each normal if
 * present; three uint32_t of each triangle. Without triangles there are no vertices. */
typedef struct np_assimp_mesh {
  uint64_t vertex_count, triangle_count, has_normals;
} np_assimp_mesh;

/* Place of a mesh at a node: the rows of its map to the file. */
typedef struct np_assimp_place {
  uint64_t mesh;
  double map[3][4];
} np_assimp_place;

typedef struct np_assimp_camera {
  double vertical_fov_rad; /* 0: not given */
  double begin_s, end_s;   /* first and last time of the keys that move it or its ancestors; equal: it stands still */
  char name[NP_ASSIMP_NAME_BYTES];
} np_assimp_camera;

/* A camera in the world of its file. The axes are unit vectors, or all zero where it has no direction. */
typedef struct np_assimp_pose {
  double at[3], forward[3], up[3];
} np_assimp_pose;

#endif

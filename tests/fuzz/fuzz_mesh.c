/* SPDX-License-Identifier: Apache-2.0 */
/* A mesh that Assimp reads, of the format that the first byte chooses: loaded as terrain, and its cameras. */
#include "fuzz_support.h"

#include <nephos/terrain.h>

#include "mesh/camera_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static const char *const names[] = {"mesh.obj", "mesh.ply", "mesh.stl", "mesh.gltf",
                                      "mesh.glb", "mesh.dae", "mesh.fbx"};
  if (size == 0) return 0;
  neph_context *context = fuzz_get_context();
  const char *path = fuzz_write_file(names[data[0] % (sizeof names / sizeof *names)], data + 1, size - 1);
  neph_mesh_desc mesh = NEPH_MESH_DESC_DEFAULT;
  neph_terrain_desc desc = NEPH_TERRAIN_DESC_DEFAULT;
  neph_terrain *terrain;
  np_camera_file camera;
  mesh.up = NEPH_MESH_UP_Y;
  desc.mesh_file = path;
  desc.mesh = &mesh;
  fuzz_expect(neph_terrain_load_mesh(context, &desc, &terrain));
  neph_terrain_release(terrain);
  fuzz_expect(np_camera_file_load(context, path, NULL, 24.0, &camera));
  np_camera_file_clear(&camera);
  return 0;
}

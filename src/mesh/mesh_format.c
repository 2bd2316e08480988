/* SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_format.h"

#include <string.h>
#include <strings.h>

static const char *get_ending(const char *path) {
  const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
  return dot ? dot : "";
}

static bool is_gltf(const char *path) {
  const char *ending = get_ending(path);
  return !strcasecmp(ending, ".gltf") || !strcasecmp(ending, ".glb");
}

neph_result np_mesh_format_check(neph_context *context, const char *path) {
  static const char *const endings[] = {".gltf", ".glb", ".obj", ".ply", ".stl", ".fbx", ".dae"};
  const char *ending = get_ending(path);
  for (size_t i = 0; i < sizeof endings / sizeof *endings; i++)
    if (!strcasecmp(ending, endings[i])) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_UNSUPPORTED,
                 "%s: a mesh must be .gltf, .glb, .obj, .ply, .stl, .fbx or .dae: convert it", path);
}

neph_result np_mesh_format_check_up(neph_context *context, const char *path, neph_mesh_up up, const char *key) {
  if (up != NEPH_MESH_UP_FILE || is_gltf(path)) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                 "%s: the format does not say which axis points up: set %s to y or z", path, key);
}

np_affine np_mesh_format_make_turn(const char *path, neph_mesh_up up, double unit_m, double rotation_rad) {
  const double c = unit_m * cos(rotation_rad), s = unit_m * sin(rotation_rad);
  const np_affine turn = {{{c, -s, 0, 0}, {s, c, 0, 0}, {0, 0, unit_m, 0}}};
  const np_affine y_to_z = {{{1, 0, 0, 0}, {0, 0, -1, 0}, {0, 1, 0, 0}}};
  const bool is_y = up == NEPH_MESH_UP_Y || (up == NEPH_MESH_UP_FILE && is_gltf(path));
  return is_y ? np_affine_compose(&turn, &y_to_z) : turn;
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_file.h"

#include "core/alloc.h"
#include "mesh/assimp_module.h"
#include "mesh/mesh_shape.h"

/* Indices are of 32 bits, and Embree's buffers of fewer bytes than that counts. */
static const size_t vertices_max = (size_t)1 << 28, places_max = (size_t)1 << 20;

typedef struct mesh_load {
  neph_context *context;
  const char *path;
  const np_assimp_module *module;
  np_assimp_scene *scene;
  np_mesh_file *out;
  bool is_smooth;
  size_t visited; /* places */
} mesh_load;

/* ---- Checks ---- */

static neph_result check_size(const mesh_load *l, size_t index, const np_assimp_mesh *mesh) {
  if (mesh->vertex_count <= vertices_max && mesh->triangle_count <= vertices_max) return NEPH_OK;
  return np_fail(l->context, NEPH_ERROR_BAD_FILE,
                 "%s: mesh %zu has %zu vertices and %zu triangles, may have %zu: thin it out, or part it", l->path,
                 index, mesh->vertex_count, mesh->triangle_count, vertices_max);
}

/* Far smaller than the largest float, so that squares of lengths stay finite. */
static const float coordinate_max = 1e15f;

static neph_result check_positions(const mesh_load *l, size_t index, const np_mesh *mesh) {
  for (size_t i = 0; i < 3 * (size_t)mesh->vertex_count; i++)
    if (!(fabsf(mesh->positions[i]) <= coordinate_max))
      return np_fail(l->context, NEPH_ERROR_BAD_FILE,
                     "%s: mesh %zu: vertex %zu is at [%g, %g, %g], must be finite and within 1e15: repair the file",
                     l->path, index, i / 3, (double)mesh->positions[i - i % 3], (double)mesh->positions[i - i % 3 + 1],
                     (double)mesh->positions[i - i % 3 + 2]);
  return NEPH_OK;
}

static neph_result check_triangles(const mesh_load *l, size_t index, const np_mesh *mesh) {
  for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++)
    if (mesh->triangles[i] >= mesh->vertex_count)
      return np_fail(l->context, NEPH_ERROR_BAD_FILE,
                     "%s: mesh %zu: triangle %zu has vertex %u, must be below %u: repair the file", l->path, index,
                     i / 3, mesh->triangles[i], mesh->vertex_count);
  return NEPH_OK;
}

/* ---- Meshes ---- */

static neph_result copy_mesh(mesh_load *l, size_t index) {
  np_assimp_mesh mesh;
  np_mesh *out = &l->out->meshes[index];
  l->module->describe_mesh(l->scene, index, &mesh);
  if (!l->is_smooth) mesh.normals = NULL;
  if (mesh.triangle_count == 0) return NEPH_OK;
  neph_result result = check_size(l, index, &mesh);
  if (result) return result;
  const size_t values = 3 * mesh.vertex_count;
  out->positions = np_alloc(l->context, values + 1, sizeof(float));
  out->triangles = np_alloc(l->context, 3 * mesh.triangle_count, sizeof(uint32_t));
  if (mesh.normals) out->normals = np_alloc(l->context, values, sizeof(float));
  if (!out->positions || !out->triangles || (mesh.normals && !out->normals)) return NEPH_ERROR_OUT_OF_MEMORY;
  out->vertex_count = (uint32_t)mesh.vertex_count;
  out->triangle_count = (uint32_t)mesh.triangle_count;
  memcpy(out->positions, mesh.positions, values * sizeof(float));
  if (mesh.normals) memcpy(out->normals, mesh.normals, values * sizeof(float));
  l->module->fill_triangles(l->scene, index, out->triangles);
  result = check_positions(l, index, out);
  if (!result) result = check_triangles(l, index, out);
  if (!result) result = np_mesh_join(l->context, out);
  return result || !l->is_smooth || out->normals ? result : np_mesh_smooth(l->context, out);
}

static neph_result copy_meshes(mesh_load *l) {
  l->out->mesh_count = l->module->count_meshes(l->scene);
  l->out->meshes = np_alloc(l->context, l->out->mesh_count + 1, sizeof *l->out->meshes);
  if (!l->out->meshes) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = NEPH_OK;
  for (size_t i = 0; i < l->out->mesh_count && !result; i++) result = copy_mesh(l, i);
  return result;
}

/* ---- Places ---- */

static bool is_usable(const mesh_load *l, size_t mesh) {
  return mesh < l->out->mesh_count && l->out->meshes[mesh].triangle_count > 0;
}

static void count_place(void *user, size_t mesh, const double map[3][4]) {
  (void)map;
  mesh_load *l = user;
  if (is_usable(l, mesh)) l->out->place_count++;
}

static void add_place(void *user, size_t mesh, const double map[3][4]) {
  mesh_load *l = user;
  if (!is_usable(l, mesh)) return;
  np_mesh_place *place = &l->out->places[l->visited++];
  place->mesh = (uint32_t)mesh;
  memcpy(place->to_file.m, map, sizeof place->to_file.m);
  l->out->meshes[mesh].place_count++;
}

static neph_result copy_places(mesh_load *l) {
  l->module->visit_places(l->scene, count_place, l);
  if (l->out->place_count == 0)
    return np_fail(l->context, NEPH_ERROR_BAD_FILE, "%s: no triangle is in it, must have at least one", l->path);
  if (l->out->place_count > places_max)
    return np_fail(l->context, NEPH_ERROR_BAD_FILE, "%s: its nodes place %zu meshes, may place %zu", l->path,
                   l->out->place_count, places_max);
  l->out->places = np_alloc(l->context, l->out->place_count, sizeof *l->out->places);
  if (!l->out->places) return NEPH_ERROR_OUT_OF_MEMORY;
  l->module->visit_places(l->scene, add_place, l);
  return NEPH_OK;
}

neph_result np_mesh_file_load(neph_context *context, const char *path, bool is_smooth, np_mesh_file *out_file) {
  *out_file = (np_mesh_file){.context = context};
  mesh_load l = {.context = context, .path = path, .out = out_file, .is_smooth = is_smooth};
  neph_result result = np_assimp_module_open(context, path, &l.module, &l.scene);
  if (result) return result;
  result = copy_meshes(&l);
  if (!result) result = copy_places(&l);
  l.module->close(l.scene);
  if (result) np_mesh_file_clear(out_file);
  return result;
}

void np_mesh_file_clear(np_mesh_file *file) {
  for (size_t i = 0; file->meshes && i < file->mesh_count; i++) {
    np_alloc_free(file->context, file->meshes[i].positions);
    np_alloc_free(file->context, file->meshes[i].normals);
    np_alloc_free(file->context, file->meshes[i].triangles);
  }
  np_alloc_free(file->context, file->meshes);
  np_alloc_free(file->context, file->places);
  *file = (np_mesh_file){.context = file->context};
}

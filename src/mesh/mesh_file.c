/* SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_file.h"

#include <inttypes.h>

#include "core/alloc.h"
#include "mesh/assimp_process.h"
#include "mesh/mesh_shape.h"

/* Limits: indices have 32 bits, and Embree's buffers fewer bytes than 32 bits count. */
static const size_t vertices_max = (size_t)1 << 28, places_max = (size_t)1 << 20;

typedef struct mesh_load {
  neph_context *context;
  const char *path;
  np_monitor *monitor;
  np_assimp_process process;
  np_mesh_file *out;
  bool is_smooth;
} mesh_load;

/* ---- Checks ---- */

static neph_result check_size(const mesh_load *l, size_t index, const np_assimp_mesh *mesh) {
  if (mesh->vertex_count <= vertices_max && mesh->triangle_count <= vertices_max) return NEPH_OK;
  return np_fail(l->context, NEPH_ERROR_BAD_FILE,
                 "%s: mesh %zu has %" PRIu64 " vertices and %" PRIu64
                 " triangles, may have %zu: thin it out, or part it",
                 l->path, index, mesh->vertex_count, mesh->triangle_count, vertices_max);
}

/* Limit of coordinates, far below the largest float, so that squares of lengths stay finite. */
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

static neph_result read_triangles(mesh_load *l, const np_assimp_mesh *mesh, np_mesh *out) {
  const size_t values = 3 * mesh->vertex_count, indices = 3 * mesh->triangle_count;
  out->positions = np_alloc(l->context, values + 1, sizeof(float));
  out->triangles = np_alloc(l->context, indices, sizeof(uint32_t));
  if (mesh->has_normals) out->normals = np_alloc(l->context, values, sizeof(float));
  if (!out->positions || !out->triangles || (mesh->has_normals && !out->normals)) return NEPH_ERROR_OUT_OF_MEMORY;
  out->vertex_count = (uint32_t)mesh->vertex_count;
  out->triangle_count = (uint32_t)mesh->triangle_count;
  neph_result result = np_assimp_read(&l->process, out->positions, values * sizeof(float));
  if (!result && mesh->has_normals) result = np_assimp_read(&l->process, out->normals, values * sizeof(float));
  return result ? result : np_assimp_read(&l->process, out->triangles, indices * sizeof(uint32_t));
}

static void drop_normals(const mesh_load *l, np_mesh *mesh) {
  np_alloc_free(l->context, mesh->normals);
  mesh->normals = NULL;
}

static neph_result read_mesh(mesh_load *l, size_t index) {
  np_assimp_mesh mesh;
  np_mesh *out = &l->out->meshes[index];
  neph_result result = np_assimp_read(&l->process, &mesh, sizeof mesh);
  if (result || mesh.triangle_count == 0) return result;
  result = check_size(l, index, &mesh);
  if (!result) result = read_triangles(l, &mesh, out);
  if (!l->is_smooth) drop_normals(l, out);
  if (!result) result = check_positions(l, index, out);
  if (!result) result = check_triangles(l, index, out);
  if (!result) result = np_mesh_join(l->context, out);
  return result || !l->is_smooth || out->normals ? result : np_mesh_smooth(l->context, out);
}

static neph_result read_meshes(mesh_load *l, size_t count) {
  l->out->meshes = np_alloc(l->context, count + 1, sizeof *l->out->meshes);
  if (!l->out->meshes) return NEPH_ERROR_OUT_OF_MEMORY;
  l->out->mesh_count = count;
  neph_result result = NEPH_OK;
  for (size_t i = 0; i < count && !result; i++) result = read_mesh(l, i);
  return result;
}

/* ---- Places ---- */

static void add_place(np_mesh_file *file, const np_assimp_place *place) {
  if (place->mesh >= file->mesh_count || file->meshes[place->mesh].triangle_count == 0) return;
  np_mesh_place *out = &file->places[file->place_count++];
  out->mesh = (uint32_t)place->mesh;
  memcpy(out->to_file.m, place->map, sizeof out->to_file.m);
  file->meshes[place->mesh].place_count++;
}

static neph_result read_places(mesh_load *l, uint64_t count) {
  if (count > places_max)
    return np_fail(l->context, NEPH_ERROR_BAD_FILE, "%s: its nodes place %" PRIu64 " meshes, may place %zu", l->path,
                   count, places_max);
  l->out->places = np_alloc(l->context, count + 1, sizeof *l->out->places);
  if (!l->out->places) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = NEPH_OK;
  for (uint64_t i = 0; i < count && !result; i++) {
    np_assimp_place place;
    result = np_assimp_read(&l->process, &place, sizeof place);
    if (!result) add_place(l->out, &place);
  }
  if (result || l->out->place_count > 0) return result;
  return np_fail(l->context, NEPH_ERROR_BAD_FILE, "%s: it has no triangle, must have at least one", l->path);
}

static neph_result read_file(mesh_load *l) {
  np_assimp_counts counts;
  neph_result result = np_assimp_read(&l->process, &counts, sizeof counts);
  if (!result) result = read_meshes(l, counts.mesh_count);
  return result ? result : read_places(l, counts.place_count);
}

static neph_result load(void *user) {
  mesh_load *l = user;
  neph_result result = np_assimp_begin(l->context, l->path, (const char *[]){"meshes", NULL}, l->monitor, &l->process);
  if (result) return result;
  result = read_file(l);
  np_assimp_end(&l->process);
  return result;
}

neph_result np_mesh_file_load(neph_context *context, const char *path, bool is_smooth, np_monitor *monitor,
                              np_mesh_file *out_file) {
  *out_file = (np_mesh_file){.context = context};
  mesh_load l = {.context = context, .path = path, .monitor = monitor, .out = out_file, .is_smooth = is_smooth};
  np_monitor_set_stage(monitor, "reading meshes");
  const neph_result result = np_parallel_run(context, monitor, load, &l);
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

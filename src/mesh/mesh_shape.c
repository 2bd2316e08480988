/* SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_shape.h"

#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"

/* ---- Joining ---- */

/* A vertex as a sort key. */
typedef struct vertex_key {
  float values[6];
  uint32_t index;
} vertex_key;

static int compare_values(const vertex_key *a, const vertex_key *b) {
  return memcmp(a->values, b->values, sizeof a->values);
}

/* Orders equal vertices by their index, so that the order of the file decides. */
static int compare_keys(const void *a, const void *b) {
  const vertex_key *x = a, *y = b;
  const int order = compare_values(x, y);
  return order ? order : (x->index > y->index) - (x->index < y->index);
}

/* Fills the keys; adding 0 turns −0 into 0. */
static void fill_keys(const np_mesh *mesh, vertex_key *keys) {
  for (uint32_t v = 0; v < mesh->vertex_count; v++) {
    keys[v] = (vertex_key){.index = v};
    for (int a = 0; a < 3; a++) {
      keys[v].values[a] = mesh->positions[3 * (size_t)v + a] + 0.0f;
      if (mesh->normals) keys[v].values[3 + a] = mesh->normals[3 * (size_t)v + a] + 0.0f;
    }
  }
}

/* Fills the index of each vertex's first equal one. */
static void fill_first(const vertex_key *keys, uint32_t count, uint32_t *out) {
  uint32_t first = 0;
  for (uint32_t i = 0; i < count; i++) {
    if (i == 0 || compare_values(&keys[i - 1], &keys[i])) first = keys[i].index;
    out[keys[i].index] = first;
  }
}

/* Compacts the array to first vertices; `first` becomes the new index of each vertex. */
static void join_vertices(np_mesh *mesh, uint32_t *first) {
  uint32_t kept = 0;
  for (uint32_t v = 0; v < mesh->vertex_count; v++) {
    if (first[v] != v) {
      first[v] = first[first[v]];
      continue;
    }
    memmove(mesh->positions + 3 * (size_t)kept, mesh->positions + 3 * (size_t)v, 3 * sizeof(float));
    if (mesh->normals) memmove(mesh->normals + 3 * (size_t)kept, mesh->normals + 3 * (size_t)v, 3 * sizeof(float));
    first[v] = kept++;
  }
  for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; i++) mesh->triangles[i] = first[mesh->triangles[i]];
  mesh->vertex_count = kept;
}

neph_result np_mesh_join(neph_context *context, np_mesh *mesh) {
  vertex_key *keys = np_alloc(context, mesh->vertex_count, sizeof *keys);
  uint32_t *first = np_alloc(context, mesh->vertex_count, sizeof *first);
  const neph_result result = keys && first ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) {
    fill_keys(mesh, keys);
    qsort(keys, mesh->vertex_count, sizeof *keys, compare_keys);
    fill_first(keys, mesh->vertex_count, first);
    join_vertices(mesh, first);
  }
  np_alloc_free(context, keys);
  np_alloc_free(context, first);
  return result;
}

/* ---- Smoothing ---- */

static np_dvec3 get_position(const np_mesh *mesh, uint32_t vertex) {
  const float *p = mesh->positions + 3 * (size_t)vertex;
  return np_dvec3_make((double)p[0], (double)p[1], (double)p[2]);
}

neph_result np_mesh_smooth(neph_context *context, np_mesh *mesh) {
  np_dvec3 *sums = np_alloc(context, mesh->vertex_count, sizeof *sums);
  mesh->normals = np_alloc(context, 3 * (size_t)mesh->vertex_count, sizeof(float));
  if (!sums || !mesh->normals) return np_alloc_free(context, sums), NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t t = 0; t < mesh->triangle_count; t++) {
    const uint32_t *v = mesh->triangles + 3 * t;
    const np_dvec3 a = get_position(mesh, v[0]);
    const np_dvec3 normal =
        np_dvec3_cross(np_dvec3_subtract(get_position(mesh, v[1]), a), np_dvec3_subtract(get_position(mesh, v[2]), a));
    for (int k = 0; k < 3; k++) sums[v[k]] = np_dvec3_add(sums[v[k]], normal);
  }
  for (uint32_t v = 0; v < mesh->vertex_count; v++) {
    const double length = np_dvec3_length(sums[v]);
    const np_vec3 normal =
        length > 0.0 ? np_dvec3_to_float(np_dvec3_scale(sums[v], 1.0 / length)) : np_vec3_make(0.0f, 0.0f, 0.0f);
    memcpy(mesh->normals + 3 * (size_t)v, &normal, sizeof normal);
  }
  np_alloc_free(context, sums);
  return NEPH_OK;
}

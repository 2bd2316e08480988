/* SPDX-License-Identifier: Apache-2.0 */
#include "check/check_mesh.h"

#include <float.h>
#include <math.h>

#include "mesh/mesh_file.h"

typedef np_finding_draft draft;

/* Number of triangles without an area, and the box of all places. */
typedef struct mesh_facts {
  size_t triangle_count, flat_count;
  np_dvec3 low, high;
  const neph_mesh_desc *desc; /* NULL: none */
} mesh_facts;

static np_dvec3 get_vertex(const np_mesh *mesh, uint32_t index) {
  const float *p = mesh->positions + 3 * (size_t)index;
  return np_dvec3_make((double)p[0], (double)p[1], (double)p[2]);
}

static bool is_flat(const np_mesh *mesh, size_t triangle) {
  const uint32_t *corners = mesh->triangles + 3 * triangle;
  const np_dvec3 a = get_vertex(mesh, corners[0]);
  const np_dvec3 b = np_dvec3_subtract(get_vertex(mesh, corners[1]), a);
  const np_dvec3 c = np_dvec3_subtract(get_vertex(mesh, corners[2]), a);
  return !(np_dvec3_length(np_dvec3_cross(b, c)) > 0.0);
}

static void add_place(const np_mesh *mesh, const np_affine *to_file, mesh_facts *facts) {
  for (uint32_t i = 0; i < mesh->vertex_count; i++) {
    const np_dvec3 at = np_affine_point(to_file, np_dvec3_add(get_vertex(mesh, i), mesh->middle));
    facts->low = np_dvec3_make(fmin(facts->low.x, at.x), fmin(facts->low.y, at.y), fmin(facts->low.z, at.z));
    facts->high = np_dvec3_make(fmax(facts->high.x, at.x), fmax(facts->high.y, at.y), fmax(facts->high.z, at.z));
  }
}

static mesh_facts measure_mesh(const np_mesh_file *file) {
  mesh_facts facts = {.low = {DBL_MAX, DBL_MAX, DBL_MAX}, .high = {-DBL_MAX, -DBL_MAX, -DBL_MAX}};
  for (size_t i = 0; i < file->mesh_count; i++) {
    facts.triangle_count += file->meshes[i].triangle_count;
    for (size_t t = 0; t < file->meshes[i].triangle_count; t++) facts.flat_count += is_flat(&file->meshes[i], t);
  }
  for (size_t i = 0; i < file->place_count; i++)
    add_place(&file->meshes[file->places[i].mesh], &file->places[i].to_file, &facts);
  return facts;
}

static bool has_flat(const mesh_facts *facts, draft *out) {
  return facts->flat_count > 0 && np_draft_set(out, "%zu of %zu triangles have no area, and are never hit",
                                               facts->flat_count, facts->triangle_count);
}

static bool has_odd_size(const mesh_facts *facts, draft *out) {
  const np_dvec3 size = np_dvec3_subtract(facts->high, facts->low);
  const double unit_m = facts->desc ? facts->desc->unit_m : 1.0;
  const double size_m = unit_m * fmax(fmax(size.x, size.y), size.z);
  return (size_m < 10.0 || size_m > 1e6) &&
         np_draft_set(out, "it is %.4g m across where a unit of the file is %g m", size_m, unit_m);
}

static const struct {
  np_rule rule;
  bool (*is_broken)(const mesh_facts *facts, draft *out);
} mesh_rules[] = {
    {{"mesh.flat", NEPH_SEVERITY_NOTE, NULL}, has_flat},
    {{"mesh.size", NEPH_SEVERITY_WARNING, "terrain.mesh.unit"}, has_odd_size},
};

static neph_result load_mesh(neph_check *check, const char *path, const neph_mesh_desc *desc) {
  np_mesh_file file;
  np_monitor monitor;
  np_check_start_monitor(check, &monitor);
  neph_result result = np_mesh_file_load(check->context, path, false, &monitor, &file);
  if (result) return result;
  mesh_facts facts = measure_mesh(&file);
  facts.desc = desc;
  for (size_t i = 0; i < sizeof mesh_rules / sizeof *mesh_rules; i++) {
    draft out = {{0}, {0}};
    if (mesh_rules[i].is_broken(&facts, &out)) np_check_add(check, &mesh_rules[i].rule, &out);
  }
  np_mesh_file_clear(&file);
  return NEPH_OK;
}

neph_result np_check_mesh(neph_check *check, const char *path, const neph_mesh_desc *desc) {
  const neph_result result = neph_check_set_file(check, path);
  return result ? result : np_check_pass(load_mesh(check, path, desc));
}

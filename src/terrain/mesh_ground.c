/* SPDX-License-Identifier: Apache-2.0 */
#include "terrain/mesh_ground.h"

#include <float.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/units.h"
#include "mesh/mesh_format.h"
#include "mesh/mesh_header.h"

/* Distance from the world's origin beyond which a mesh would be invisible. */
static const double distance_max_m = 1e6;

/* ---- Description ---- */

static neph_result check_desc(neph_context *context, const char *path, const neph_mesh_desc *desc) {
  if (!(desc->unit_m > 0.0 && desc->unit_m <= 1e9))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "terrain.mesh.unit is %g m, must be above 0 and at most 1e9",
                   desc->unit_m);
  if (!isfinite(desc->rotation_rad) || (unsigned)desc->up > NEPH_MESH_UP_Z ||
      (unsigned)desc->pivot > NEPH_MESH_PIVOT_ORIGIN || (unsigned)desc->normals > NEPH_MESH_NORMALS_FLAT)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "terrain.mesh: rotation %g, up %u, pivot %u or normals %u is not one that neph_mesh_desc has",
                   desc->rotation_rad, (unsigned)desc->up, (unsigned)desc->pivot, (unsigned)desc->normals);
  for (int axis = 0; axis < 3; axis++)
    if (!(fabs(desc->position_m[axis]) <= 1e9))
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "terrain.mesh.position[%d] is %g m, must be within 1e9",
                     axis, desc->position_m[axis]);
  return np_mesh_format_check_up(context, path, desc->up, "terrain.mesh.up");
}

static neph_result read_desc(neph_context *context, const neph_terrain_desc *desc, neph_mesh_desc *out) {
  const neph_mesh_desc defaults = NEPH_MESH_DESC_DEFAULT;
  if (!desc->mesh_file)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "terrain mesh_file is NULL, must name a file");
  neph_result result = np_desc_read(context, "neph_mesh_desc", &defaults, sizeof defaults, desc->mesh, out);
  if (!result) result = np_mesh_format_check(context, desc->mesh_file);
  return result ? result : check_desc(context, desc->mesh_file, out);
}

neph_result np_mesh_ground_check(neph_context *context, const neph_terrain_desc *desc) {
  neph_mesh_desc read;
  const char *reason;
  neph_result result = read_desc(context, desc, &read);
  if (result) return result;
  result = np_file_probe(desc->mesh_file, &reason);
  if (result) return np_fail(context, result, "%s: %s", desc->mesh_file, reason);
  return np_mesh_header_check(context, desc->mesh_file);
}

/* ---- Places ---- */

static np_dvec3 get_vertex(const np_mesh *mesh, size_t vertex) {
  const float *p = mesh->positions + 3 * vertex;
  return np_dvec3_make((double)p[0], (double)p[1], (double)p[2]);
}

static void set_vertex(np_mesh *mesh, size_t vertex, np_dvec3 position) {
  const np_vec3 p = np_dvec3_to_float(position);
  memcpy(mesh->positions + 3 * vertex, &p, sizeof p);
}

static void include_point(np_dvec3 p, np_dvec3 *low, np_dvec3 *high) {
  *low = np_dvec3_min(*low, p);
  *high = np_dvec3_max(*high, p);
}

static void compute_bounds(np_mesh_ground *ground) {
  np_dvec3 low = {DBL_MAX, DBL_MAX, DBL_MAX}, high = {-DBL_MAX, -DBL_MAX, -DBL_MAX};
  for (size_t i = 0; i < ground->file.place_count; i++) {
    const np_mesh_place *place = &ground->file.places[i];
    const np_mesh *mesh = &ground->file.meshes[place->mesh];
    for (size_t v = 0; v < mesh->vertex_count; v++)
      include_point(np_affine_point(&place->to_file, get_vertex(mesh, v)), &low, &high);
  }
  ground->bounds_min = low;
  ground->bounds_max = high;
}

/* Adds an offset to a map, after it. */
static void shift(np_affine *map, np_dvec3 by) {
  map->m[0][3] += by.x;
  map->m[1][3] += by.y;
  map->m[2][3] += by.z;
}

static np_dvec3 get_pivot(const np_mesh_ground *ground, neph_mesh_pivot pivot) {
  const np_dvec3 low = ground->bounds_min, high = ground->bounds_max;
  if (pivot == NEPH_MESH_PIVOT_ORIGIN) return np_dvec3_make(0, 0, 0);
  return np_dvec3_make(0.5 * (low.x + high.x), 0.5 * (low.y + high.y),
                       pivot == NEPH_MESH_PIVOT_BASE ? low.z : 0.5 * (low.z + high.z));
}

static void move_ground(np_mesh_ground *ground, const neph_mesh_desc *desc) {
  if (!desc->has_position) return;
  const np_dvec3 position = np_dvec3_make(desc->position_m[0], desc->position_m[1], desc->position_m[2]);
  const np_dvec3 by = np_dvec3_subtract(position, get_pivot(ground, desc->pivot));
  for (size_t i = 0; i < ground->file.place_count; i++) shift(&ground->file.places[i].to_file, by);
  ground->bounds_min = np_dvec3_add(ground->bounds_min, by);
  ground->bounds_max = np_dvec3_add(ground->bounds_max, by);
}

/* Refuses maps without an inverse: flat or not finite. */
static neph_result check_places(const np_mesh_ground *ground, const char *path) {
  for (size_t i = 0; i < ground->file.place_count; i++) {
    np_affine inverse;
    if (!np_affine_invert(&ground->file.places[i].to_file, &inverse))
      return np_fail(ground->file.context, NEPH_ERROR_BAD_FILE,
                     "%s: place %zu of its meshes is flat or not finite, must have an inverse: repair the file", path,
                     i);
  }
  return NEPH_OK;
}

static neph_result check_bounds(const np_mesh_ground *ground, const char *path) {
  const np_dvec3 low = ground->bounds_min, high = ground->bounds_max;
  const double farthest =
      fmax(fmax(fmax(fabs(low.x), fabs(high.x)), fmax(fabs(low.y), fabs(high.y))), fmax(fabs(low.z), fabs(high.z)));
  const double width = fmax(fmax(high.x - low.x, high.y - low.y), high.z - low.z);
  neph_context *context = ground->file.context;
  if (!(farthest <= distance_max_m))
    return np_fail(context, NEPH_ERROR_BAD_FILE,
                   "%s: reaches %.4g km from the world's origin and is %.4g km wide, must be within %.0f km: set "
                   "terrain.mesh.position, or terrain.mesh.unit",
                   path, farthest / NP_KILOMETRE, width / NP_KILOMETRE, distance_max_m / NP_KILOMETRE);
  if (!(width > 0.0))
    return np_fail(context, NEPH_ERROR_BAD_FILE, "%s: its triangles are all in one point, must have an extent", path);
  np_log(context, NEPH_LOG_INFO, "%s: %.6g x %.6g x %.6g m, from [%.6g, %.6g, %.6g] m", path, high.x - low.x,
         high.y - low.y, high.z - low.z, low.x, low.y, low.z);
  if (width < 1.0)
    np_log(context, NEPH_LOG_WARNING, "%s: is %.3g m wide: set terrain.mesh.unit if its unit is not the metre", path,
           width);
  return NEPH_OK;
}

neph_result np_mesh_ground_load(neph_context *context, const neph_terrain_desc *desc, np_monitor *monitor,
                                np_mesh_ground *out) {
  neph_mesh_desc read;
  neph_result result = read_desc(context, desc, &read);
  if (result) return result;
  result = np_mesh_file_load(context, desc->mesh_file, read.normals == NEPH_MESH_NORMALS_SMOOTH, monitor, &out->file);
  if (result) return result;
  const np_affine turn = np_mesh_format_make_turn(desc->mesh_file, read.up, read.unit_m, read.rotation_rad);
  for (size_t i = 0; i < out->file.place_count; i++)
    out->file.places[i].to_file = np_affine_compose(&turn, &out->file.places[i].to_file);
  result = check_places(out, desc->mesh_file);
  if (!result) compute_bounds(out);
  if (!result) move_ground(out, &read);
  if (!result) result = check_bounds(out, desc->mesh_file);
  if (result) np_mesh_ground_clear(out);
  return result;
}

/* ---- Anchor ---- */

/* Maps a normal by the cofactors of a map; the length is arbitrary. */
static np_vec3 turn_normal(const np_affine *map, np_vec3 normal) {
  const np_dvec3 x = np_dvec3_make(map->m[0][0], map->m[1][0], map->m[2][0]),
                 y = np_dvec3_make(map->m[0][1], map->m[1][1], map->m[2][1]),
                 z = np_dvec3_make(map->m[0][2], map->m[1][2], map->m[2][2]);
  const np_dvec3 out = np_dvec3_add(np_dvec3_add(np_dvec3_scale(np_dvec3_cross(y, z), (double)normal.x),
                                                 np_dvec3_scale(np_dvec3_cross(z, x), (double)normal.y)),
                                    np_dvec3_scale(np_dvec3_cross(x, y), (double)normal.z));
  const double length = np_dvec3_length(out);
  return length > 0.0 ? np_dvec3_to_float(np_dvec3_scale(out, 1.0 / length)) : np_vec3_make(0, 0, 0);
}

static np_vec3 get_normal(const np_mesh *mesh, size_t vertex) {
  np_vec3 normal;
  memcpy(&normal, mesh->normals + 3 * vertex, sizeof normal);
  return normal;
}

/* Applies a place to the vertices of a mesh that has no other place. */
static void flatten(np_mesh *mesh, np_mesh_place *place) {
  for (size_t v = 0; v < mesh->vertex_count; v++) {
    set_vertex(mesh, v, np_affine_point(&place->to_file, get_vertex(mesh, v)));
    if (!mesh->normals) continue;
    const np_vec3 normal = turn_normal(&place->to_file, get_normal(mesh, v));
    memcpy(mesh->normals + 3 * v, &normal, sizeof normal);
  }
  place->to_file = np_affine_identity();
}

static void center(np_mesh *mesh) {
  np_dvec3 low = get_vertex(mesh, 0), high = low;
  for (size_t v = 1; v < mesh->vertex_count; v++) include_point(get_vertex(mesh, v), &low, &high);
  mesh->middle = np_vec3_to_double(np_dvec3_to_float(np_dvec3_scale(np_dvec3_add(low, high), 0.5)));
  for (size_t v = 0; v < mesh->vertex_count; v++)
    set_vertex(mesh, v, np_dvec3_subtract(get_vertex(mesh, v), mesh->middle));
}

void np_mesh_ground_set_anchor(np_mesh_ground *ground, np_dvec3 anchor) {
  np_mesh_file *file = &ground->file;
  for (size_t m = 0; m < file->mesh_count; m++)
    if (np_mesh_ground_is_shared(&file->meshes[m])) center(&file->meshes[m]);
  for (size_t i = 0; i < file->place_count; i++) {
    np_mesh_place *place = &file->places[i];
    np_mesh *mesh = &file->meshes[place->mesh];
    shift(&place->to_file, np_dvec3_subtract(np_affine_vector(&place->to_file, mesh->middle), anchor));
    if (!np_mesh_ground_is_shared(mesh)) flatten(mesh, place);
  }
}

void np_mesh_ground_clear(np_mesh_ground *ground) { np_mesh_file_clear(&ground->file); }

/* ---- Rays ---- */

/* A triangle in its place, and barycentric coordinates of a point. */
typedef struct facet {
  np_dvec3 corner[3], normal; /* normal: not of unit length, towards the ray's origin */
  double share[3];
} facet;

static double compute_share(const facet *f, np_dvec3 at, int opposite) {
  const np_dvec3 a = f->corner[(opposite + 1) % 3], b = f->corner[(opposite + 2) % 3];
  const np_dvec3 area = np_dvec3_cross(np_dvec3_subtract(b, a), np_dvec3_subtract(at, a));
  return np_dvec3_dot(area, f->normal) / np_dvec3_dot(f->normal, f->normal);
}

/* Exact distance to the triangle's plane, where the point is still on it: Embree's has the error of floats. */
static double refine_distance(facet *f, np_dvec3 origin, np_vec3 direction, double distance) {
  const np_dvec3 along = np_vec3_to_double(direction);
  const double descent = np_dvec3_dot(f->normal, along);
  const double exact = np_dvec3_dot(f->normal, np_dvec3_subtract(f->corner[0], origin)) / descent;
  const double slack = 1e-3;
  double best = distance;
  for (int attempt = 0; attempt < 2; attempt++) {
    const double tried = attempt ? distance : exact;
    if (!isfinite(tried)) continue;
    bool is_inside = true;
    for (int k = 0; k < 3; k++) {
      f->share[k] = compute_share(f, np_dvec3_along(origin, direction, tried), k);
      is_inside = is_inside && f->share[k] > -slack;
    }
    best = tried;
    if (is_inside) break;
  }
  return best;
}

/* Sets the smooth normal, and the offset to its curved surface (see field_facets.c), on the side of the ray. */
static void set_smooth(const np_mesh *mesh, const np_affine *to_anchor, const uint32_t *vertices, const facet *f,
                       np_dvec3 at, np_terrain_hit *out) {
  np_vec3 sum = {0.0f, 0.0f, 0.0f}, rise = {0.0f, 0.0f, 0.0f};
  for (int k = 0; k < 3; k++) {
    np_vec3 normal = get_normal(mesh, vertices[k]);
    if (np_mesh_ground_is_shared(mesh)) normal = turn_normal(to_anchor, normal);
    if (np_vec3_dot(normal, out->facet) < 0.0f) normal = np_vec3_scale(normal, -1.0f);
    const float share = (float)np_clamp(f->share[k], 0.0, 1.0);
    const np_vec3 offset = np_dvec3_to_float(np_dvec3_subtract(at, f->corner[k]));
    sum = np_vec3_add(sum, np_vec3_scale(normal, share));
    rise = np_vec3_subtract(rise, np_vec3_scale(normal, share * np_minf(np_vec3_dot(offset, normal), 0.0f)));
  }
  const float length = np_vec3_length(sum);
  if (!(length > 1e-6f) || !isfinite(length)) return;
  out->normal = np_vec3_scale(sum, 1.0f / length);
  out->rise = rise;
}

void np_mesh_ground_intersect(const np_mesh_ground *ground, size_t place, size_t triangle, np_dvec3 origin,
                              np_vec3 direction, double distance, np_terrain_hit *out_hit) {
  const np_affine *to_anchor = &ground->file.places[place].to_file;
  const np_mesh *mesh = &ground->file.meshes[ground->file.places[place].mesh];
  const uint32_t *vertices = mesh->triangles + 3 * triangle;
  facet f;
  for (int k = 0; k < 3; k++) f.corner[k] = np_affine_point(to_anchor, get_vertex(mesh, vertices[k]));
  f.normal = np_dvec3_cross(np_dvec3_subtract(f.corner[1], f.corner[0]), np_dvec3_subtract(f.corner[2], f.corner[0]));
  *out_hit = (np_terrain_hit){.is_of_mesh = true, .distance = refine_distance(&f, origin, direction, distance)};
  const bool is_behind = np_dvec3_dot(f.normal, np_vec3_to_double(direction)) > 0.0;
  out_hit->facet = np_dvec3_to_float(np_dvec3_scale(np_dvec3_normalize(f.normal), is_behind ? -1.0 : 1.0));
  out_hit->normal = out_hit->facet;
  if (mesh->normals)
    set_smooth(mesh, to_anchor, vertices, &f, np_dvec3_along(origin, direction, out_hit->distance), out_hit);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* A tree of boxes over triangles in the order of a Morton curve, halved down to a few triangles.
 *
 * The winding number is Σ Ω/4π over the solid angles Ω of all triangles (Jacobson, Kavan and Sorkine-Hornung 2013,
 * "Robust Inside-Outside Segmentation Using Generalized Winding Numbers"), nodes beyond twice their radius as dipoles
 * (Barill, Dickson, Schmidt, Levin and Jacobson 2018, "Fast Winding Numbers for Soups and Clouds", eq. 5). Ω is that of
 * van Oosterom and Strackee 1983, the arc tangent that of Abramowitz and Stegun 4.4.49, within 1e-5: no function of the
 * machine's library decides a sign.
 */
#include "mesh/mesh_tree.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/units.h"

enum { LEAF_TRIANGLES = 4, STACK = 64, MORTON_BITS = 20 };

static const float dipole_radii = 2.0f;

/* ---- Triangles ---- */

static np_dvec3 get_vertex(const np_mesh *mesh, uint32_t vertex) {
  const float *p = mesh->positions + 3 * (size_t)vertex;
  return np_dvec3_make((double)p[0], (double)p[1], (double)p[2]);
}

static void add_place(const np_mesh_file *file, const np_mesh_place *place, const np_affine *turn, np_mesh_tree *tree) {
  const np_mesh *mesh = &file->meshes[place->mesh];
  const np_affine map = np_affine_compose(turn, &place->to_file);
  const bool is_mirrored = np_affine_determinant(&map) < 0;
  for (uint32_t t = 0; t < mesh->triangle_count; t++) {
    np_mesh_triangle *triangle = &tree->triangles[tree->triangle_count++];
    for (int k = 0; k < 3; k++) {
      const np_dvec3 p = np_affine_point(&map, get_vertex(mesh, mesh->triangles[3 * (size_t)t + (size_t)k]));
      triangle->corners[is_mirrored ? 2 - k : k] = np_dvec3_to_float(p);
    }
  }
}

neph_result np_mesh_tree_collect(const np_mesh_file *file, const np_affine *turn, np_mesh_tree *out_tree) {
  size_t count = 0;
  *out_tree = (np_mesh_tree){.context = file->context};
  for (size_t i = 0; i < file->place_count; i++) count += file->meshes[file->places[i].mesh].triangle_count;
  out_tree->triangles = np_alloc(file->context, count, sizeof *out_tree->triangles);
  if (!out_tree->triangles) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < file->place_count; i++) add_place(file, &file->places[i], turn, out_tree);
  return NEPH_OK;
}

void np_mesh_tree_clear(np_mesh_tree *tree) {
  if (tree->context) {
    np_alloc_free(tree->context, tree->triangles);
    np_alloc_free(tree->context, tree->nodes);
  }
  *tree = (np_mesh_tree){0};
}

double np_mesh_tree_count_bytes(const np_mesh_tree *tree) {
  return (double)tree->triangle_count * sizeof *tree->triangles + (double)tree->node_count * sizeof *tree->nodes;
}

/* ---- Order ---- */

static void include(np_vec3 p, np_vec3 *low, np_vec3 *high) {
  *low = np_vec3_make(np_minf(low->x, p.x), np_minf(low->y, p.y), np_minf(low->z, p.z));
  *high = np_vec3_make(np_maxf(high->x, p.x), np_maxf(high->y, p.y), np_maxf(high->z, p.z));
}

static np_vec3 compute_middle(const np_mesh_triangle *t) {
  return np_vec3_scale(np_vec3_add(np_vec3_add(t->corners[0], t->corners[1]), t->corners[2]), 1.0f / 3.0f);
}

typedef struct morton_key {
  uint64_t code;
  size_t index;
} morton_key;

static int compare_keys(const void *a, const void *b) {
  const morton_key *x = a, *y = b;
  if (x->code != y->code) return x->code < y->code ? -1 : 1;
  return (x->index > y->index) - (x->index < y->index);
}

static uint64_t compute_code(np_vec3 p, np_vec3 low, float scale) {
  const float at[3] = {(p.x - low.x) * scale, (p.y - low.y) * scale, (p.z - low.z) * scale};
  uint64_t code = 0;
  for (int bit = MORTON_BITS - 1; bit >= 0; bit--)
    for (int a = 0; a < 3; a++) code = code << 1 | ((uint64_t)at[a] >> bit & 1u);
  return code;
}

static neph_result sort_triangles(np_mesh_tree *tree) {
  const size_t count = tree->triangle_count;
  np_vec3 low = np_vec3_make(INFINITY, INFINITY, INFINITY), high = np_vec3_make(-INFINITY, -INFINITY, -INFINITY);
  morton_key *keys = np_alloc(tree->context, count, sizeof *keys);
  np_mesh_triangle *sorted = np_alloc(tree->context, count, sizeof *sorted);
  if (!keys || !sorted) {
    np_alloc_free(tree->context, keys);
    np_alloc_free(tree->context, sorted);
    return NEPH_ERROR_OUT_OF_MEMORY;
  }
  for (size_t i = 0; i < count; i++) include(compute_middle(&tree->triangles[i]), &low, &high);
  const np_vec3 size = np_vec3_subtract(high, low);
  const float widest = np_maxf(np_maxf(size.x, size.y), size.z);
  const float scale = widest > 0.0f ? ((1 << MORTON_BITS) - 1) / widest : 0.0f;
  for (size_t i = 0; i < count; i++)
    keys[i] = (morton_key){compute_code(compute_middle(&tree->triangles[i]), low, scale), i};
  qsort(keys, count, sizeof *keys, compare_keys);
  for (size_t i = 0; i < count; i++) sorted[i] = tree->triangles[keys[i].index];
  np_alloc_free(tree->context, keys);
  np_alloc_free(tree->context, tree->triangles);
  tree->triangles = sorted;
  return NEPH_OK;
}

/* ---- Nodes ---- */

static np_vec3 compute_area(const np_mesh_triangle *t) {
  return np_vec3_scale(
      np_vec3_cross(np_vec3_subtract(t->corners[1], t->corners[0]), np_vec3_subtract(t->corners[2], t->corners[0])),
      0.5f);
}

/* Computes the box, the area vector and the area-weighted centre of a node's triangles. */
static void measure_node(const np_mesh_tree *tree, size_t first, size_t count, np_mesh_node *node) {
  np_dvec3 center = {0, 0, 0}, area = {0, 0, 0};
  double weights = 0;
  node->low = np_vec3_make(INFINITY, INFINITY, INFINITY);
  node->high = np_vec3_make(-INFINITY, -INFINITY, -INFINITY);
  for (size_t i = first; i < first + count; i++) {
    const np_mesh_triangle *t = &tree->triangles[i];
    const np_dvec3 own = np_vec3_to_double(compute_area(t));
    const double weight = np_dvec3_length(own) + 1e-30;
    for (int k = 0; k < 3; k++) include(t->corners[k], &node->low, &node->high);
    area = np_dvec3_add(area, own);
    center = np_dvec3_add(center, np_dvec3_scale(np_vec3_to_double(compute_middle(t)), weight));
    weights += weight;
  }
  node->area = np_dvec3_to_float(area);
  node->center = np_dvec3_to_float(np_dvec3_scale(center, 1.0 / weights));
  for (size_t i = first; i < first + count; i++)
    for (int k = 0; k < 3; k++) {
      const np_vec3 off = np_vec3_subtract(tree->triangles[i].corners[k], node->center);
      node->radius = np_maxf(node->radius, np_vec3_length(off));
    }
}

/* Triangles of a node that remains to be split. */
typedef struct node_range {
  size_t node, first, count;
} node_range;

static void cut_nodes(np_mesh_tree *tree) {
  node_range stack[STACK] = {{0, 0, tree->triangle_count}};
  int depth = 1;
  tree->node_count = 1;
  while (depth > 0) {
    const node_range r = stack[--depth];
    np_mesh_node *node = &tree->nodes[r.node];
    measure_node(tree, r.first, r.count, node);
    if (r.count <= LEAF_TRIANGLES) {
      node->first = (uint32_t)r.first;
      node->count = (uint32_t)r.count;
      continue;
    }
    const size_t half = r.count / 2, child = tree->node_count;
    assert(depth + 2 <= STACK && child + 2 <= 2 * tree->triangle_count);
    node->first = (uint32_t)child;
    tree->node_count += 2;
    stack[depth++] = (node_range){child, r.first, half};
    stack[depth++] = (node_range){child + 1, r.first + half, r.count - half};
  }
}

neph_result np_mesh_tree_build(np_mesh_tree *tree) {
  neph_result result = sort_triangles(tree);
  if (result) return result;
  tree->nodes = np_alloc(tree->context, 2 * tree->triangle_count, sizeof *tree->nodes);
  if (!tree->nodes) return NEPH_ERROR_OUT_OF_MEMORY;
  cut_nodes(tree);
  return NEPH_OK;
}

/* ---- Distance ---- */

static float compute_box_distance2(const np_mesh_node *n, np_vec3 p) {
  const float x = np_maxf(np_maxf(n->low.x - p.x, p.x - n->high.x), 0.0f);
  const float y = np_maxf(np_maxf(n->low.y - p.y, p.y - n->high.y), 0.0f);
  const float z = np_maxf(np_maxf(n->low.z - p.z, p.z - n->high.z), 0.0f);
  return x * x + y * y + z * z;
}

static float compute_segment_distance2(np_vec3 p, np_vec3 a, np_vec3 b) {
  const np_vec3 ab = np_vec3_subtract(b, a), ap = np_vec3_subtract(p, a);
  const float length2 = np_vec3_dot(ab, ab);
  const float t = length2 > 0.0f ? np_clampf(np_vec3_dot(ap, ab) / length2, 0.0f, 1.0f) : 0.0f;
  const np_vec3 off = np_vec3_subtract(ap, np_vec3_scale(ab, t));
  return np_vec3_dot(off, off);
}

/* Squared distance to a triangle: to its plane where the foot lies inside, else to the nearest edge. */
static float compute_triangle_distance2(const np_mesh_triangle *t, np_vec3 p) {
  const np_vec3 normal = compute_area(t);
  const float area2 = np_vec3_dot(normal, normal);
  bool is_inside = area2 > 0.0f;
  float nearest = INFINITY;
  for (int k = 0; k < 3; k++) {
    const np_vec3 a = t->corners[k], b = t->corners[(k + 1) % 3];
    const np_vec3 side = np_vec3_cross(normal, np_vec3_subtract(b, a));
    is_inside = is_inside && np_vec3_dot(side, np_vec3_subtract(p, a)) >= 0.0f;
    nearest = np_minf(nearest, compute_segment_distance2(p, a, b));
  }
  if (!is_inside) return nearest;
  const float height = np_vec3_dot(normal, np_vec3_subtract(p, t->corners[0]));
  return height * height / area2;
}

float np_mesh_tree_compute_distance(const np_mesh_tree *tree, np_vec3 point, float limit) {
  uint32_t stack[STACK] = {0};
  int depth = 1;
  float nearest = limit * limit;
  while (depth > 0) {
    const np_mesh_node *node = &tree->nodes[stack[--depth]];
    if (compute_box_distance2(node, point) >= nearest) continue;
    for (uint32_t i = 0; i < node->count; i++)
      nearest = np_minf(nearest, compute_triangle_distance2(&tree->triangles[node->first + i], point));
    if (node->count) continue;
    const bool is_second = compute_box_distance2(&tree->nodes[node->first + 1], point) <
                           compute_box_distance2(&tree->nodes[node->first], point);
    stack[depth++] = node->first + !is_second;
    stack[depth++] = node->first + is_second;
  }
  return sqrtf(nearest);
}

/* ---- Winding number ---- */

/* Arc tangent of x in [0, 1]. */
static double compute_arc_tangent(double x) {
  const double s = x * x;
  return x * (0.9998660 + s * (-0.3302995 + s * (0.1801410 + s * (-0.0851330 + s * 0.0208351))));
}

static double compute_angle(double y, double x) {
  const double ay = fabs(y), ax = fabs(x);
  if (!(ay + ax > 0)) return 0;
  double angle = ay < ax ? compute_arc_tangent(ay / ax) : 0.5 * NP_PI - compute_arc_tangent(ax / ay);
  if (x < 0) angle = NP_PI - angle;
  return y < 0 ? -angle : angle;
}

static double compute_solid_angle(const np_mesh_triangle *t, np_vec3 point) {
  np_dvec3 c[3];
  double r[3];
  for (int k = 0; k < 3; k++) {
    c[k] = np_vec3_to_double(np_vec3_subtract(t->corners[k], point));
    r[k] = np_dvec3_length(c[k]);
  }
  const double volume = np_dvec3_dot(c[0], np_dvec3_cross(c[1], c[2]));
  const double across = r[0] * r[1] * r[2] + np_dvec3_dot(c[0], c[1]) * r[2] + np_dvec3_dot(c[1], c[2]) * r[0] +
                        np_dvec3_dot(c[2], c[0]) * r[1];
  return 2 * compute_angle(volume, across);
}

float np_mesh_tree_compute_winding(const np_mesh_tree *tree, np_vec3 point) {
  uint32_t stack[STACK] = {0};
  int depth = 1;
  double sum = 0;
  while (depth > 0) {
    const np_mesh_node *node = &tree->nodes[stack[--depth]];
    const np_vec3 off = np_vec3_subtract(node->center, point);
    const float away = np_vec3_length(off);
    if (away > dipole_radii * node->radius) {
      sum += (double)(np_vec3_dot(node->area, off) / (away * away * away));
      continue;
    }
    for (uint32_t i = 0; i < node->count; i++) sum += compute_solid_angle(&tree->triangles[node->first + i], point);
    if (node->count) continue;
    stack[depth++] = node->first;
    stack[depth++] = node->first + 1;
  }
  return (float)(sum / (4 * NP_PI));
}

/* ---- Edges ---- */

/* An edge from its lower vertex; `sense` is −1 where the triangle traverses it the other way. */
typedef struct edge {
  float ends[6];
  int sense;
} edge;

static int compare_edges(const void *a, const void *b) {
  return memcmp(((const edge *)a)->ends, ((const edge *)b)->ends, sizeof((const edge *)a)->ends);
}

static void fill_edge(const np_mesh_triangle *t, int k, edge *out) {
  const np_vec3 zero = np_vec3_make(0.0f, 0.0f, 0.0f); /* adding 0 turns −0 into 0 */
  np_vec3 a = np_vec3_add(t->corners[k], zero), b = np_vec3_add(t->corners[(k + 1) % 3], zero);
  const bool is_turned = memcmp(&a, &b, sizeof a) > 0;
  memcpy(out->ends, is_turned ? &b : &a, sizeof a);
  memcpy(out->ends + 3, is_turned ? &a : &b, sizeof b);
  out->sense = is_turned ? -1 : 1;
}

neph_result np_mesh_tree_count_open_edges(const np_mesh_tree *tree, size_t *out_count, np_vec3 *out_first) {
  const size_t count = 3 * tree->triangle_count;
  edge *edges = np_alloc(tree->context, count, sizeof *edges);
  *out_count = 0;
  *out_first = np_vec3_make(0, 0, 0);
  if (!edges) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < count; i++) fill_edge(&tree->triangles[i / 3], (int)(i % 3), &edges[i]);
  qsort(edges, count, sizeof *edges, compare_edges);
  for (size_t i = 0; i < count;) {
    const edge *e = &edges[i];
    const bool is_point = !memcmp(e->ends, e->ends + 3, 3 * sizeof *e->ends);
    int sum = 0;
    for (; i < count && !compare_edges(e, &edges[i]); i++) sum += edges[i].sense;
    if (sum == 0 || is_point) continue;
    for (int a = 0; a < 3 && *out_count == 0; a++) (&out_first->x)[a] = 0.5f * (e->ends[a] + e->ends[3 + a]);
    ++*out_count;
  }
  np_alloc_free(tree->context, edges);
  return NEPH_OK;
}

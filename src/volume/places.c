/* SPDX-License-Identifier: Apache-2.0 */
/* Bounding volume hierarchy over the places of clouds: a median split of the centres of their boxes, along the axis of
 * their largest extent, down to single places. */
#include "volume/places.h"

#include <assert.h>
#include <stdlib.h>

#include "core/alloc.h"

/* ---- Boxes ---- */

typedef struct place_box {
  double low[3], high[3];
  uint32_t place;
} place_box;

/* Half size of endless clouds; no ray goes farther. */
static const double far_m = 1e9;

/* Relative enlargement of boxes, against rounding. */
static const double margin = 1e-9;

static void include_point(place_box *box, np_dvec3 point) {
  const double p[3] = {point.x, point.y, point.z};
  for (int a = 0; a < 3; a++) {
    box->low[a] = fmin(box->low[a], p[a]);
    box->high[a] = fmax(box->high[a], p[a]);
  }
}

/* World box of the cells that a walk through the bricks can visit. */
static place_box compute_box(const np_instance *volume, uint32_t place) {
  const np_bricks *bricks = volume->bricks;
  place_box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, place};
  np_affine index_to_world;
  if (!np_affine_invert(&volume->world_to_index, &index_to_world)) index_to_world = np_affine_identity();
  for (int corner = 0; corner < 8; corner++) {
    double at[3];
    for (int a = 0; a < 3; a++)
      at[a] = (double)NP_BRICK_EDGE * (corner >> a & 1 ? bricks->reach_high[a] : bricks->reach_low[a]);
    include_point(&box, np_affine_point(&index_to_world, np_dvec3_make(at[0], at[1], at[2])));
  }
  for (int a = 0; a < 3; a++) {
    const double pad = margin * (fabs(box.low[a]) + fabs(box.high[a]) + 1.0);
    box.low[a] = fmax(box.low[a] - pad, -far_m);
    box.high[a] = fmin(box.high[a] + pad, far_m);
  }
  return box;
}

static int compare_along(const place_box *a, const place_box *b, int axis) {
  const double x = a->low[axis] + a->high[axis], y = b->low[axis] + b->high[axis];
  if (x != y) return x < y ? -1 : 1;
  return a->place < b->place ? -1 : 1;
}
static int compare_x(const void *a, const void *b) { return compare_along(a, b, 0); }
static int compare_y(const void *a, const void *b) { return compare_along(a, b, 1); }
static int compare_z(const void *a, const void *b) { return compare_along(a, b, 2); }

/* ---- Building ---- */

typedef struct tree_build {
  place_box *boxes;
  np_place_node *nodes;
  uint32_t count; /* nodes built so far */
} tree_build;

static void bound_boxes(const place_box *boxes, uint32_t count, np_place_node *out) {
  for (int a = 0; a < 3; a++) {
    out->low[a] = INFINITY;
    out->high[a] = -INFINITY;
    for (uint32_t i = 0; i < count; i++) {
      out->low[a] = fmin(out->low[a], boxes[i].low[a]);
      out->high[a] = fmax(out->high[a], boxes[i].high[a]);
    }
  }
}

/* Axis along which the centres of the boxes have the largest extent. */
static int choose_axis(const place_box *boxes, uint32_t count) {
  int axis = 0;
  double widest = -1.0;
  for (int a = 0; a < 3; a++) {
    double low = INFINITY, high = -INFINITY;
    for (uint32_t i = 0; i < count; i++) {
      low = fmin(low, boxes[i].low[a] + boxes[i].high[a]);
      high = fmax(high, boxes[i].low[a] + boxes[i].high[a]);
    }
    if (high - low > widest) widest = high - low, axis = a;
  }
  return axis;
}

/* Builds the node of a range of places; the tree is balanced. */
static uint32_t build_node(tree_build *b, uint32_t first, uint32_t count) {
  static int (*const compare[3])(const void *, const void *) = {compare_x, compare_y, compare_z};
  const uint32_t number = b->count++;
  assert(count >= 1);
  np_place_node *node = &b->nodes[number];
  bound_boxes(b->boxes + first, count, node);
  node->place = first;
  if (count == 1) return number;
  qsort(b->boxes + first, count, sizeof *b->boxes, compare[choose_axis(b->boxes + first, count)]);
  node->place = NP_PLACE_NONE;
  build_node(b, first, count / 2);
  node->second = build_node(b, first + count / 2, count - count / 2);
  return number;
}

static neph_result allocate(neph_context *context, uint32_t count, tree_build *b, np_places *out) {
  b->boxes = np_alloc(context, count, sizeof *b->boxes);
  b->nodes = out->nodes = np_alloc(context, 2 * (size_t)count, sizeof *b->nodes);
  out->at = np_alloc(context, count, sizeof *out->at);
  return b->boxes && b->nodes && out->at ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

neph_result np_places_build(neph_context *context, np_instance *at, uint32_t count, np_places *out) {
  tree_build b = {0};
  *out = (np_places){.count = count};
  neph_result result = allocate(context, count, &b, out);
  if (!result) {
    for (uint32_t i = 0; i < count; i++) b.boxes[i] = compute_box(&at[i], i);
    build_node(&b, 0, count);
    assert(b.count == 2 * count - 1);
    for (uint32_t i = 0; i < count; i++) out->at[i] = at[b.boxes[i].place];
  }
  np_alloc_free(context, b.boxes);
  np_alloc_free(context, at);
  if (result) np_places_clear(context, out);
  return result;
}

void np_places_clear(neph_context *context, np_places *places) {
  np_alloc_free(context, places->at);
  np_alloc_free(context, places->nodes);
  *places = (np_places){0};
}

/* ---- Points ---- */

static bool contains_point(const np_place_node *node, const double p[3]) {
  return p[0] >= node->low[0] && p[0] <= node->high[0] && p[1] >= node->low[1] && p[1] <= node->high[1] &&
         p[2] >= node->low[2] && p[2] <= node->high[2];
}

/* Walk over the nodes that may contain a point, in the order of the places. */
typedef struct point_walk {
  const np_places *places;
  double point[3];
  unsigned depth;
  uint32_t stack[NP_PLACE_STACK];
} point_walk;

static point_walk start_point(const np_places *places, np_dvec3 p) {
  return (point_walk){.places = places, .point = {p.x, p.y, p.z}, .depth = 1};
}

static const np_place_node *search_point(point_walk *w) {
  while (w->depth > 0) {
    const uint32_t number = w->stack[--w->depth];
    const np_place_node *node = &w->places->nodes[number];
    if (!contains_point(node, w->point)) continue;
    if (node->place != NP_PLACE_NONE) return node;
    w->stack[w->depth++] = node->second;
    w->stack[w->depth++] = number + 1;
  }
  return NULL;
}

void np_places_add_extinction(const np_places *places, np_dvec3 position, float weight, float *out) {
  point_walk w = start_point(places, position);
  const np_place_node *node;
  while ((node = search_point(&w))) {
    const np_instance *volume = &places->at[node->place];
    out[volume->index] += weight * fmaxf(0.0f, np_instance_extinction(volume, position));
  }
}

float np_places_sum_extinction(const np_places *places, np_dvec3 position) {
  point_walk w = start_point(places, position);
  const np_place_node *node;
  float sum = 0.0f;
  while ((node = search_point(&w))) sum += np_instance_extinction(&places->at[node->place], position);
  return sum;
}

/* ---- Boxes in boxes ---- */

static bool is_apart(const np_place_node *node, const double low[3], const double high[3]) {
  for (int axis = 0; axis < 3; axis++)
    if (node->low[axis] > high[axis] || low[axis] > node->high[axis]) return true;
  return false;
}

/* Walk over the places whose boxes overlap a box. */
typedef struct box_walk {
  const np_places *places;
  const double *low, *high;
  unsigned depth;
  uint32_t stack[NP_PLACE_STACK];
} box_walk;

static const np_place_node *search_box(box_walk *w) {
  while (w->depth > 0) {
    const uint32_t number = w->stack[--w->depth];
    const np_place_node *node = &w->places->nodes[number];
    if (is_apart(node, w->low, w->high)) continue;
    if (node->place != NP_PLACE_NONE) return node;
    w->stack[w->depth++] = node->second;
    w->stack[w->depth++] = number + 1;
  }
  return NULL;
}

unsigned np_places_list_in_box(const np_places *places, const double low[3], const double high[3], unsigned room,
                               const np_instance **out) {
  box_walk w = {.places = places, .low = low, .high = high, .depth = 1};
  const np_place_node *node;
  unsigned count = 0;
  for (; (node = search_box(&w)); count++)
    if (count < room) out[count] = &places->at[node->place];
  return count;
}

/* ---- Overlap ---- */

/* Search for the largest number of boxes that overlap at a point. The largest number occurs at the low side of some box
 * along each axis. `lists` has room for three lists of all places, each with an end. */
typedef struct crowd_search {
  const np_places *places;
  unsigned limit;
  const np_place_node **lists[3];
  double point[3];
} crowd_search;

/* Selects the boxes of a list that contain the low side of each along an axis, and recurses to the next axis. */
static bool search_along(crowd_search *s, int axis, uint32_t count) {
  const np_place_node **from = s->lists[axis];
  for (uint32_t j = 0; j < count; j++) {
    const double at = s->point[axis] = from[j]->low[axis];
    uint32_t met = 0;
    for (uint32_t i = 0; i < count; i++) {
      if (at < from[i]->low[axis] || at > from[i]->high[axis]) continue;
      if (axis < 2) s->lists[axis + 1][met] = from[i];
      met++;
    }
    if (met > s->limit && (axis == 2 || search_along(s, axis + 1, met))) return true;
  }
  return false;
}

/* Selects the boxes that contain the low x side of a box and overlap it. */
static bool search_beside(crowd_search *s, const np_place_node *of) {
  box_walk w = {.places = s->places, .low = of->low, .high = of->high, .depth = 1};
  uint32_t count = 0, met = 0;
  while ((s->lists[0][count] = search_box(&w))) count++;
  const double at = s->point[0] = of->low[0];
  for (uint32_t i = 0; i < count && count > s->limit; i++)
    if (s->lists[0][i]->low[0] <= at) s->lists[1][met++] = s->lists[0][i];
  return met > s->limit && search_along(s, 1, met);
}

neph_result np_places_search_crowd(neph_context *context, const np_places *places, unsigned limit, bool *out_is_crowded,
                                   np_dvec3 *out_point) {
  const size_t count = (size_t)places->count + 1;
  const np_place_node **lists = np_alloc(context, 3 * count, sizeof *lists);
  *out_is_crowded = false;
  if (!lists) return NEPH_ERROR_OUT_OF_MEMORY;
  crowd_search s = {.places = places, .limit = limit, .lists = {lists, lists + count, lists + 2 * count}};
  for (uint32_t n = 0; n < 2 * places->count - 1 && !*out_is_crowded; n++)
    if (places->nodes[n].place != NP_PLACE_NONE) *out_is_crowded = search_beside(&s, &places->nodes[n]);
  *out_point = np_dvec3_make(s.point[0], s.point[1], s.point[2]);
  np_alloc_free(context, lists);
  return NEPH_OK;
}

np_dvec3 np_instances_compute_voxel_extent(const np_instances *clouds) {
  const np_instance *places = np_instances_get_places(clouds);
  double extent[3] = {0.0, 0.0, 0.0};
  for (unsigned i = 0; i < np_instances_count_places(clouds); i++) {
    np_affine index_to_world;
    if (!np_affine_invert(&places[i].world_to_index, &index_to_world)) continue;
    for (int a = 0; a < 3; a++) {
      const double *row = index_to_world.m[a];
      extent[a] = fmax(extent[a], fabs(row[0]) + fabs(row[1]) + fabs(row[2]));
    }
  }
  return np_dvec3_make(extent[0], extent[1], extent[2]);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Rays through the bounding volume hierarchy of places. */
#include "volume/places.h"

#include <assert.h>

static np_place_ray make_ray(np_dvec3 origin, np_vec3 direction, double end) {
  return (np_place_ray){.origin = {origin.x, origin.y, origin.z},
                        .inverse = {1.0 / (double)direction.x, 1.0 / (double)direction.y, 1.0 / (double)direction.z},
                        .end = end};
}

static double get_lesser(double a, double b) { return a < b ? a : b; }
static double get_greater(double a, double b) { return a > b ? a : b; }

/* Distance at which a ray enters a box; 0 from inside, infinite if it misses. For an axis without motion the distances
 * to the sides are infinite, with signs that distinguish inside and outside. */
static double enter_box(const np_place_ray *ray, const np_place_node *node) {
  double enter = 0.0, leave = ray->end;
  for (int a = 0; a < 3; a++) {
    const double low = (node->low[a] - ray->origin[a]) * ray->inverse[a];
    const double high = (node->high[a] - ray->origin[a]) * ray->inverse[a];
    enter = get_greater(get_lesser(low, high), enter);
    leave = get_lesser(get_greater(low, high), leave);
  }
  return enter <= leave ? enter : (double)INFINITY;
}

/* ---- In any order ---- */

static void push(np_place_walk *walk, uint32_t node, double enter) {
  walk->stack[walk->depth].node = node;
  walk->stack[walk->depth++].enter = enter;
}

void np_place_walk_enter(np_place_walk *walk, np_dvec3 origin, np_vec3 direction, double distance_end) {
  walk->depth = 0;
  walk->ray = make_ray(origin, direction, distance_end);
  push(walk, 0, enter_box(&walk->ray, &walk->clouds->places->nodes[0]));
}

const np_instance *np_place_walk_search(np_place_walk *walk, double distance_end) {
  const np_places *places = walk->clouds->places;
  while (walk->depth > 0) {
    const uint32_t number = walk->stack[--walk->depth].node;
    if (!(walk->stack[walk->depth].enter < distance_end)) continue;
    const np_place_node *node = &places->nodes[number];
    if (node->place != NP_PLACE_NONE) return &places->at[node->place];
    const double first = enter_box(&walk->ray, node + 1), second = enter_box(&walk->ray, &places->nodes[node->second]);
    const bool is_second_near = second < first;
    const double near = is_second_near ? second : first, far = is_second_near ? first : second;
    if (far < distance_end) push(walk, is_second_near ? number + 1 : node->second, far);
    if (near < distance_end) push(walk, is_second_near ? node->second : number + 1, near);
  }
  return NULL;
}

/* ---- In the order of entry ---- */

static bool is_before(np_place_hit a, np_place_hit b) {
  return a.enter != b.enter ? a.enter < b.enter : a.place < b.place;
}

/* Inserts a hit into the sorted batch; the last hit drops out of a full batch. */
static void insert(np_place_queue *queue, np_place_hit hit) {
  if (queue->count == NP_PLACE_BATCH) {
    queue->has_more = true;
    if (!is_before(hit, queue->hits[NP_PLACE_BATCH - 1])) return;
    queue->count--;
  }
  unsigned i = queue->count++;
  assert(queue->count <= NP_PLACE_BATCH);
  for (; i > 0 && is_before(hit, queue->hits[i - 1]); i--) queue->hits[i] = queue->hits[i - 1];
  queue->hits[i] = hit;
}

/* Whether a hit at this distance can enter the batch. */
static bool is_accepted(const np_place_queue *queue, double enter) {
  if (isinf(enter)) return false;
  return queue->count < NP_PLACE_BATCH || !queue->has_more || enter <= queue->hits[NP_PLACE_BATCH - 1].enter;
}

/* Collects the first hits after `last`. */
static void gather(np_place_queue *queue, np_place_hit last) {
  const np_places *places = queue->places;
  uint32_t stack[NP_PLACE_STACK] = {0};
  unsigned depth = 1;
  queue->count = queue->next = 0;
  queue->has_more = false;
  while (depth > 0) {
    const uint32_t number = stack[--depth];
    const np_place_node *node = &places->nodes[number];
    const double enter = enter_box(&queue->ray, node);
    if (!is_accepted(queue, enter)) continue;
    if (node->place != NP_PLACE_NONE) {
      const np_place_hit hit = {enter, node->place};
      if (is_before(last, hit)) insert(queue, hit);
      continue;
    }
    const bool is_second_near = enter_box(&queue->ray, &places->nodes[node->second]) < enter_box(&queue->ray, node + 1);
    assert(depth + 2 <= NP_PLACE_STACK && node->second > number);
    stack[depth++] = is_second_near ? number + 1 : node->second;
    stack[depth++] = is_second_near ? node->second : number + 1;
  }
}

void np_place_queue_enter(np_place_queue *queue, np_dvec3 origin, np_vec3 direction, double distance_end) {
  queue->ray = make_ray(origin, direction, distance_end);
  gather(queue, (np_place_hit){.enter = -1.0});
}

void np_place_queue_refill(np_place_queue *queue) { gather(queue, queue->hits[queue->count - 1]); }

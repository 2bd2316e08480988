/* SPDX-License-Identifier: Apache-2.0 */
#include "field_statistics.h"

#include <stdlib.h>

/* ---- Components: union of neighbours ---- */

typedef struct forest {
  int32_t *parents; /* 1 … count; 0 is outside */
  int32_t count, capacity;
} forest;

static int32_t get_root(const forest *f, int32_t node) {
  while (f->parents[node] != node) node = f->parents[node] = f->parents[f->parents[node]];
  return node;
}

/* 0: out of memory. */
static int32_t add_node(forest *f) {
  if (f->count + 1 >= f->capacity) {
    const int32_t capacity = f->capacity ? 2 * f->capacity : 1024;
    int32_t *parents = realloc(f->parents, (size_t)capacity * sizeof *parents);
    if (!parents) return 0;
    f->parents = parents;
    f->capacity = capacity;
  }
  f->count++;
  f->parents[f->count] = f->count;
  return f->count;
}

/* The lower root stays one. */
static int32_t join(forest *f, int32_t a, int32_t b) {
  if (!a || !b) return a ? a : b;
  const int32_t p = get_root(f, a), q = get_root(f, b), low = p < q ? p : q;
  f->parents[p < q ? q : p] = low;
  return low;
}

/* Numbers roots from 1 in their order: parents, which come first, become numbers. */
static size_t number_roots(forest *f) {
  int32_t count = 0;
  for (int32_t n = 1; n <= f->count; n++) f->parents[n] = f->parents[n] == n ? ++count : f->parents[f->parents[n]];
  return (size_t)count;
}

/* ---- Regions ---- */

/* False: out of memory. */
static bool label_cells(int32_t width, int32_t height, const uint8_t *is_inside, forest *f, int32_t *labels) {
  for (int32_t j = 0; j < height; j++)
    for (int32_t i = 0; i < width; i++) {
      const size_t n = (size_t)j * (size_t)width + (size_t)i;
      labels[n] = 0;
      if (!is_inside[n]) continue;
      labels[n] = join(f, i ? labels[n - 1] : 0, j ? labels[n - (size_t)width] : 0);
      if (!labels[n] && !(labels[n] = add_node(f))) return false;
    }
  return true;
}

static void add_cell(int32_t width, int32_t height, const int32_t *labels, size_t n, field_region *regions) {
  const int32_t i = (int32_t)(n % (size_t)width), j = (int32_t)(n / (size_t)width);
  field_region *r = &regions[labels[n] - 1];
  r->area++;
  r->perimeter += (i == 0 || !labels[n - 1]) + (i == width - 1 || !labels[n + 1]) +
                  (j == 0 || !labels[n - (size_t)width]) + (j == height - 1 || !labels[n + (size_t)width]);
}

field_region *field_label_regions(int32_t width, int32_t height, const uint8_t *is_inside, int32_t *labels,
                                  size_t *out_count) {
  const size_t cell_count = (size_t)width * (size_t)height;
  forest f = {0};
  field_region *regions = NULL;
  int32_t *own = labels ? labels : malloc(cell_count * sizeof *own);
  if (own && label_cells(width, height, is_inside, &f, own)) {
    *out_count = number_roots(&f);
    for (size_t n = 0; n < cell_count; n++) own[n] = own[n] ? f.parents[own[n]] : 0;
    regions = calloc(*out_count + 1, sizeof *regions);
    for (size_t n = 0; n < cell_count && regions; n++)
      if (own[n]) add_cell(width, height, own, n, regions);
  }
  free(f.parents);
  if (!labels) free(own);
  return regions;
}

/* ---- Components of a volume ---- */

/* Labels of a plane of fixed x, from those of the one before. False: out of memory. */
static bool label_plane(const int32_t size[3], const uint8_t *is_inside, const int32_t *before, forest *f,
                        int32_t *labels) {
  for (int32_t j = 0; j < size[1]; j++)
    for (int32_t k = 0; k < size[2]; k++) {
      const size_t n = (size_t)j * (size_t)size[2] + (size_t)k;
      labels[n] = 0;
      if (!is_inside[n]) continue;
      labels[n] = join(f, join(f, k ? labels[n - 1] : 0, j ? labels[n - (size_t)size[2]] : 0), before[n]);
      if (!labels[n] && !(labels[n] = add_node(f))) return false;
    }
  return true;
}

/* Components of the nodes of a forest; one more for each node that is new. False: out of memory. */
static bool add_plane(const int32_t size[3], const int32_t *labels, const forest *f, field_component **nodes,
                      size_t *capacity) {
  if (*capacity < (size_t)f->capacity) {
    field_component *grown = realloc(*nodes, (size_t)f->capacity * sizeof *grown);
    if (!grown) return false;
    for (size_t n = *capacity; n < (size_t)f->capacity; n++) grown[n] = (field_component){0, size[2]};
    *nodes = grown;
    *capacity = (size_t)f->capacity;
  }
  for (size_t n = 0; n < (size_t)size[1] * (size_t)size[2]; n++) {
    if (!labels[n]) continue;
    field_component *c = &(*nodes)[labels[n]];
    const int32_t k = (int32_t)(n % (size_t)size[2]);
    c->volume++;
    if (k < c->lowest) c->lowest = k;
  }
  return true;
}

static field_component *merge_nodes(forest *f, const field_component *nodes, size_t *out_count) {
  *out_count = number_roots(f);
  field_component *components = calloc(*out_count + 1, sizeof *components);
  if (!components) return NULL;
  for (size_t c = 0; c < *out_count; c++) components[c].lowest = INT32_MAX;
  for (int32_t n = 1; n <= f->count; n++) {
    field_component *c = &components[f->parents[n] - 1];
    c->volume += nodes[n].volume;
    if (nodes[n].lowest < c->lowest) c->lowest = nodes[n].lowest;
  }
  return components;
}

field_component *field_label_components(const int32_t size[3], const uint8_t *is_inside, size_t *out_count) {
  const size_t plane = (size_t)size[1] * (size_t)size[2];
  forest f = {0};
  size_t capacity = 0;
  field_component *nodes = NULL, *components = NULL;
  int32_t *labels = calloc(2 * plane, sizeof *labels);
  bool is_done = labels != NULL;
  for (int32_t i = 0; i < size[0] && is_done; i++) {
    int32_t *now = labels + (size_t)(i & 1) * plane, *before = labels + (size_t)(1 - (i & 1)) * plane;
    is_done = label_plane(size, is_inside + (size_t)i * plane, before, &f, now) &&
              add_plane(size, now, &f, &nodes, &capacity);
  }
  if (is_done) components = merge_nodes(&f, nodes, out_count);
  free(labels);
  free(nodes);
  free(f.parents);
  return components;
}

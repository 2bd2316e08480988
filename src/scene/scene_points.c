/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_points.h"

#include <string.h>

#include "core/alloc.h"
#include "core/text.h"

static neph_result read_point(np_scene_problems *problems, const char *path, const np_node *node,
                              neph_cloud_point *out) {
  double values[4];
  const np_node *item = node->kind == NP_NODE_SEQUENCE && np_node_count(node) == 4 ? node->first : NULL;
  int i = 0;
  for (; item && item->kind == NP_NODE_SCALAR && np_value_parse_real(item->text, NP_UNIT_METRE, &values[i]); i++)
    item = item->next;
  if (i < 4)
    return np_scene_fail_at(problems, node, "%s must be a list of x, y, height above the base and radius, lengths in m",
                            path);
  for (i = 0; i < 3; i++)
    if (!(fabs(values[i]) <= 1e6))
      return np_scene_fail_at(problems, node, "%s has a coordinate of %g m, must be within 1000 km", path, values[i]);
  *out = (neph_cloud_point){values[0], values[1], values[2], values[3]};
  if (values[3] > 0 && values[3] <= 1e6) return NEPH_OK;
  return np_scene_fail_at(problems, node, "%s has a radius of %g m, must be above 0 and at most 1000 km", path,
                          values[3]);
}

static neph_result read_list(np_scene_problems *problems, const char *path, const np_node *list,
                             neph_cloud_point *points, size_t *count) {
  neph_result result = NEPH_OK;
  unsigned index = 0;
  for (const np_node *item = list->first; item && !result; item = item->next, index++) {
    char name[160];
    np_print(name, sizeof name, "%s[%u]", path, index);
    result = read_point(problems, name, item, &points[(*count)++]);
  }
  return result;
}

static neph_result read_curves(np_scene_problems *problems, const char *path, const np_node *node,
                               neph_cloud_point *points, neph_cloud_points *out) {
  size_t *ends = np_alloc(problems->context, np_node_count(node), sizeof *ends);
  if (!ends) return NEPH_ERROR_OUT_OF_MEMORY;
  out->ends = ends;
  neph_result result = NEPH_OK;
  for (const np_node *curve = node->first; curve && !result; curve = curve->next) {
    char name[128];
    np_print(name, sizeof name, "%s[%zu]", path, out->curve_count);
    result = read_list(problems, name, curve, points, &out->count);
    ends[out->curve_count++] = out->count;
  }
  return result;
}

/* Number of points; 0: the node does not have the form of the key. */
static size_t count_points(const np_key *key, const np_node *node) {
  size_t count = 0;
  if (node->kind != NP_NODE_SEQUENCE) return 0;
  if (key->type == NP_KEY_POINTS) return np_node_count(node);
  for (const np_node *curve = node->first; curve; curve = curve->next) {
    if (curve->kind != NP_NODE_SEQUENCE || np_node_count(curve) < 2) return 0;
    count += np_node_count(curve);
  }
  return count;
}

neph_result np_scene_points_read(np_scene_problems *problems, const char *path, const np_key *key, const np_node *node,
                                 neph_cloud_points *out_points) {
  const bool is_curves = key->type == NP_KEY_CURVES;
  const size_t count = count_points(key, node);
  if (count == 0 || count > NEPH_CLOUD_POINTS_MAX)
    return np_scene_fail_at(problems, node,
                            "%s has %zu points, must be a list of %s[x, y, height, radius], of 1 to %d points in all",
                            path, count, is_curves ? "curves, each a list of at least 2 " : "", NEPH_CLOUD_POINTS_MAX);
  neph_cloud_point *points = np_alloc(problems->context, count, sizeof *points);
  if (!points) return NEPH_ERROR_OUT_OF_MEMORY;
  out_points->points = points;
  return is_curves ? read_curves(problems, path, node, points, out_points)
                   : read_list(problems, path, node, points, &out_points->count);
}

static void add_list(np_text *out, const neph_cloud_points *points, size_t first, size_t end) {
  for (size_t i = first; i < end; i++) {
    np_text_add(out, i > first ? ", [" : "[[");
    const neph_cloud_point *p = &points->points[i];
    const double values[4] = {p->x_m, p->y_m, p->z_m, p->radius_m};
    for (int a = 0; a < 4; a++) {
      char number[64];
      np_value_format_real(values[a], NP_UNIT_METRE, number, sizeof number);
      np_text_add(out, "%s%s", a ? ", " : "", number);
    }
    np_text_add(out, "]");
  }
  np_text_add(out, "]");
}

void np_scene_points_add(np_text *out, const neph_cloud_points *points) {
  if (points->curve_count == 0) {
    add_list(out, points, 0, points->count);
    return;
  }
  for (size_t c = 0; c < points->curve_count; c++) {
    np_text_add(out, c ? ", " : "[");
    add_list(out, points, c ? points->ends[c - 1] : 0, points->ends[c]);
  }
  np_text_add(out, "]");
}

void np_scene_points_clear(neph_context *context, neph_cloud_points *points) {
  np_alloc_free(context, (void *)(uintptr_t)points->points);
  np_alloc_free(context, (void *)(uintptr_t)points->ends);
  *points = (neph_cloud_points){.count = 0};
}

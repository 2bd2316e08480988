/* SPDX-License-Identifier: Apache-2.0 */
/* Runs of close points that are evaluated together: searches of balls work on neighbours. */
#include "cloud/thermal_runs.h"

#include <math.h>
#include <string.h>

#include "cloud/thermal_density.h"
#include "core/math.h"

static const float run_edge = 1.25f; /* in largest billows */

static np_ball_box compute_box(const np_cloud_points *points, const uint16_t *numbers, size_t count) {
  np_ball_box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  for (size_t i = 0; i < count; i++) {
    const float at_m[3] = {points->x_m[numbers[i]], points->y_m[numbers[i]], points->height_m[numbers[i]]};
    for (int a = 0; a < 3; a++) {
      box.min_m[a] = np_minf(box.min_m[a], at_m[a]);
      box.max_m[a] = np_maxf(box.max_m[a], at_m[a]);
    }
  }
  return box;
}

static bool is_wider(const np_ball_box *box, float edge_m) {
  return box->max_m[0] - box->min_m[0] > edge_m || box->max_m[1] - box->min_m[1] > edge_m ||
         box->max_m[2] - box->min_m[2] > edge_m;
}

enum { OCTANTS = 8 };

/* Sorts points by octant of their box; out_begin has one more element than there are octants. */
static void sort_by_octant(const np_cloud_points *points, const np_ball_box *box, uint16_t *numbers, size_t count,
                           size_t *out_begin) {
  uint16_t from[NP_CLOUD_BLOCK], end[OCTANTS] = {0};
  uint8_t octants[NP_CLOUD_BLOCK];
  float middle_m[3];
  for (int a = 0; a < 3; a++) middle_m[a] = 0.5f * (box->min_m[a] + box->max_m[a]);
  memcpy(from, numbers, count * sizeof *from);
  for (size_t i = 0; i < count; i++) {
    const uint16_t n = from[i];
    octants[i] = (uint8_t)((points->x_m[n] > middle_m[0]) << 2 | (points->y_m[n] > middle_m[1]) << 1 |
                           (points->height_m[n] > middle_m[2]));
    end[octants[i]]++;
  }
  out_begin[0] = 0;
  for (int o = 0; o < OCTANTS; o++) {
    out_begin[o + 1] = out_begin[o] + end[o];
    end[o] = (uint16_t)out_begin[o];
  }
  for (size_t i = 0; i < count; i++) numbers[end[octants[i]]++] = from[i];
}

/* Evaluates the points of a box in runs. Points too far apart for one run are sorted by octant, and each octant is
 * evaluated on its own. */
static void eval_box(const np_cloud_model *model, const np_cloud_points *points, uint16_t *numbers, size_t count,
                     float *out_extinction_per_m) {
  const float edge_max_m = np_maxf(9.0f * (float)model->desc.voxel_m, run_edge * model->thermals.billow_m);
  const np_ball_box box = compute_box(points, numbers, count);
  size_t begin[OCTANTS + 1];
  sort_by_octant(points, &box, numbers, count, begin);
  if (!is_wider(&box, edge_max_m)) {
    np_thermals_eval_run(model, points, numbers, count, out_extinction_per_m);
    return;
  }
  for (int o = 0; o < OCTANTS; o++)
    if (begin[o + 1] > begin[o])
      eval_box(model, points, numbers + begin[o], begin[o + 1] - begin[o], out_extinction_per_m);
}

void np_thermals_eval(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  uint16_t numbers[NP_CLOUD_BLOCK];
  size_t count = 0;
  for (size_t n = 0; n < points->count; n++)
    if (points->height_m[n] > 0.0f && points->height_m[n] < (float)model->desc.thickness_m)
      numbers[count++] = (uint16_t)n;
  if (count) eval_box(model, points, numbers, count, out_extinction_per_m);
}

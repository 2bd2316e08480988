/* SPDX-License-Identifier: Apache-2.0 */
/* Kinds of clouds that consist of stacks of thermals: fields of them, and a hero, one large cloud. */
#include "cloud/anvil.h"
#include "cloud/billows.h"
#include "cloud/cloud_kinds.h"
#include "cloud/shape.h"
#include "cloud/shape_desc.h"
#include "cloud/thermal_density.h"
#include "cloud/thermal_heap.h"
#include "cloud/thermal_runs.h"
#include "core/alloc.h"

static neph_result build_thermals(np_cloud_model *model, np_monitor *monitor) {
  const neph_result result = np_thermals_build(model, monitor, np_thermals_count_levels(model));
  if (!result && np_cloud_desc_has_shape(&model->desc)) np_shape_check_billows(model);
  return result;
}

static void clear_thermals(np_cloud_model *model) {
  np_ball_heap_cut(&model->balls, 0);
  if (!model->shape) return;
  np_shape_grid_clear(model->shape);
  np_alloc_free(model->context, model->shape);
}

static void eval_thermals(const np_cloud_model *model, const np_cloud_points *points, float *out_extinction_per_m) {
  np_thermals_eval(model, points, out_extinction_per_m);
  np_anvil_eval(model, points, out_extinction_per_m);
}

static bool is_thermals_empty(const np_cloud_model *model, const np_cloud_box *box) {
  return np_thermals_is_empty(model, box) && np_anvil_is_empty(model, box);
}

/* A census evaluates all heights of a column together, because searches of balls work on neighbours. Heights are a
 * sixth of a billow apart, to find tops that protrude between two. */
const np_cloud_kind np_thermals_kind = {
    .name = "thermals",
    .landscape = {.form = NP_LANDSCAPE_CELLS,
                  .swirl_size = 1.3f,
                  .group_height = 1.3f, /* factor on Perlin noise of many octaves */
                  .group_gain = 0.55f,
                  .group_octaves = 7,
                  .has_anvils = true,
                  .has_patterns = true},
    .more_cover = NP_GAPS_STAY_CLEAR,
    .less_cover = NP_CLOUDS_COVER_NO_LESS,
    .has_thermals = true,
    .billow_grains = 11,
    .census_per_billow = 6,
    .census_passes = 1,
    .prepare = np_thermals_prepare,
    .search_waterline = np_thermals_search_waterline,
    .build = build_thermals,
    .clear = clear_thermals,
    .eval = eval_thermals,
    .is_empty = is_thermals_empty,
};

const np_cloud_kind np_hero_kind = {
    .name = "hero",
    .landscape = {.form = NP_LANDSCAPE_HERO, .swirl_size = 1.3f},
    .more_cover = NP_GAPS_STAY_CLEAR,
    .less_cover = NP_CLOUDS_COVER_NO_LESS,
    .repeat_obstacle = "one cloud in the middle",
    .has_thermals = true,
    .is_single = true,
    .billow_grains = 11,
    .census_per_billow = 6,
    .census_passes = 1,
    .prepare = np_thermals_prepare,
    .search_waterline = np_thermals_search_waterline,
    .build = build_thermals,
    .clear = clear_thermals,
    .eval = eval_thermals,
    .is_empty = is_thermals_empty,
};

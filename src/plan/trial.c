/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/trial.h"

#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "plan/georeference.h"
#include "plan/placement.h"
#include "plan/trial_volume.h"
#include "scene/cloud_places.h"

/* Cells of the map, their least and largest number in height, and the most along a side. */
static const double map_cells = 2.6e5;
enum { HEIGHTS_MIN = 16, HEIGHTS_MAX = 96, SIDE_MAX = 512 };

void np_trial_release(np_trial *trial) {
  if (!trial || --trial->references > 0) return;
  np_alloc_free(trial->context, trial->extinction);
  np_alloc_free(trial->context, trial->sums);
  np_alloc_free(trial->context, trial->ground_m);
  np_alloc_free(trial->context, trial);
}

/* ---- Clouds in their places ---- */

/* A cloud of the trial: a volume, or a box of uniform extinction. */
typedef struct trial_source {
  np_trial_volume own;        /* without a volume: the box alone is known */
  np_instance world;          /* placement of the volume */
  np_dvec3 low, high;         /* world box with the cloud's pivot at its position */
  double first[2], period[2]; /* along x and y in index space: the part that is repeated to fill a field or the map;
                                 0: the part is the whole */
  float even_per_m;           /* extinction within the box, where there is no volume */
  bool is_known;
} trial_source;

/* Lays a part of a field beside itself until it fills the field's extent. */
static void repeat_part(trial_source *out) {
  const neph_cloud_desc *part = &out->own.bake;
  const np_affine *to_index = &out->own.volume->world_to_index;
  const double low_m[2] = {part->center_m[0] - 0.5 * part->extent_m[0], part->center_m[1] - 0.5 * part->extent_m[1]};
  const double more = 0.5 * (1.0 / out->own.share_across - 1.0);
  for (int a = 0; a < 2; a++) {
    out->first[a] = to_index->m[a][a] * low_m[a] + to_index->m[a][3];
    out->period[a] = to_index->m[a][a] * part->extent_m[a];
  }
  const double east_m = more * (out->high.x - out->low.x), north_m = more * (out->high.y - out->low.y);
  out->low = np_dvec3_subtract(out->low, np_dvec3_make(east_m, north_m, 0.0));
  out->high = np_dvec3_add(out->high, np_dvec3_make(east_m, north_m, 0.0));
}

/* Lays a file that repeats beside itself over the map. */
static void lay_over(const np_trial *t, const np_scene_cloud *cloud, const np_input_file *file, trial_source *out) {
  if (!out->is_known || !out->own.volume || cloud->repeat == NP_REPEAT_NONE) return;
  const np_affine *to_index = &out->world.world_to_index;
  const double low_m[2] = {out->low.x, out->low.y}, high_m[2] = {out->high.x, out->high.y};
  for (int a = 0; a < 2; a++) {
    const double per_m = to_index->m[a][a];
    out->first[a] = (per_m > 0.0 ? low_m[a] : high_m[a]) * per_m + to_index->m[a][3];
    out->period[a] = fabs(per_m) * np_input_file_get_period_m(cloud, file, a);
  }
  out->low = np_dvec3_make(t->low.x, t->low.y, out->low.z);
  out->high = np_dvec3_make(t->high.x, t->high.y, out->high.z);
}

static double fold(double x, double first, double period) {
  return period > 0.0 ? x - floor((x - first) / period) * period : x;
}

/* Extinction of a copy of a cloud at a world position, 1/m. */
static float sample(const trial_source *source, const np_affine *world_to_index, np_dvec3 position) {
  if (!source->own.volume) return source->even_per_m;
  np_dvec3 index = np_affine_point(world_to_index, position);
  index.x = fold(index.x, source->first[0], source->period[0]);
  index.y = fold(index.y, source->first[1], source->period[1]);
  return fmaxf(source->world.extinction_per_value * np_bricks_sample(source->world.bricks, index), 0.0f);
}

static neph_result place_volume(const neph_scene *scene, const np_scene_cloud *cloud, trial_source *out) {
  np_monitor monitor;
  np_anchor anchor;
  np_georeference georeference;
  np_placement placement;
  np_monitor_start(&monitor, scene->context, NULL, NULL);
  neph_result result = np_placement_anchor(cloud, out->own.volume, &monitor, &anchor);
  if (!result && !cloud->is_baked)
    result = np_georeference_apply(scene, cloud, out->own.volume, &anchor.file_to_world, &georeference);
  if (!result) result = np_placement_make(cloud, &anchor, out->own.volume, &monitor, &placement);
  if (result) return result;
  out->world = placement.world;
  out->low = placement.bounds_min;
  out->high = placement.bounds_max;
  out->is_known = out->own.volume->active_voxel_count > 0;
  if (out->own.share_across < 1.0) repeat_part(out);
  return NEPH_OK;
}

/* The middle of a file's box, as much of it as has voxels with cloud. */
static void place_header(const np_scene_cloud *cloud, const np_input_file *file, trial_source *out) {
  const double share = np_input_file_get_share(file), side = cbrt(share);
  const np_dvec3 middle = np_dvec3_scale(np_dvec3_add(file->low, file->high), 0.5),
                 half = np_dvec3_scale(np_dvec3_subtract(file->high, file->low), 0.5 * side);
  out->low = np_dvec3_subtract(middle, half);
  out->high = np_dvec3_add(middle, half);
  out->even_per_m = (float)np_input_file_guess_extinction(cloud, file);
  out->is_known = file->is_known;
}

static neph_result make_source(const neph_scene *scene, const np_request *request, const np_inputs *inputs,
                               unsigned number, trial_source *out) {
  const np_scene_cloud *cloud = &scene->clouds[number];
  const np_input_file *file = np_inputs_get_file(inputs, number);
  *out = (trial_source){.is_known = false};
  neph_result result = np_trial_volume_make(scene, request, cloud, file, &out->own);
  if (!result && out->own.volume) result = place_volume(scene, cloud, out);
  if (!result && !out->own.volume && file->is_known) place_header(cloud, file, out);
  if (result != NEPH_ERROR_OUT_OF_MEMORY && result != NEPH_ERROR_CANCELLED) return NEPH_OK;
  return result;
}

/* Calls `visit` with the placement of each copy of a cloud, and its world box. */
typedef void visit_copy_fn(void *user, const trial_source *source, const np_affine *world_to_index, np_dvec3 low,
                           np_dvec3 high);

static void visit_copies(const np_scene_cloud *cloud, const trial_source *source, visit_copy_fn *visit, void *user) {
  if (!source->is_known) return;
  if (cloud->place_count == 0) visit(user, source, &source->world.world_to_index, source->low, source->high);
  for (unsigned k = 0; k < cloud->place_count; k++) {
    const np_affine way = np_cloud_place_get_affine(&cloud->place[k]);
    np_affine back, world_to_index;
    np_dvec3 low, high;
    if (!np_affine_invert(&way, &back)) continue;
    world_to_index = np_affine_compose(&source->world.world_to_index, &back);
    np_cloud_place_move_box(&cloud->place[k], source->low, source->high, &low, &high);
    visit(user, source, &world_to_index, low, high);
  }
}

/* ---- The map ---- */

static void include_copy(void *user, const trial_source *source, const np_affine *world_to_index, np_dvec3 low,
                         np_dvec3 high) {
  (void)source, (void)world_to_index;
  np_trial *t = user;
  t->low = np_dvec3_min(t->low, low);
  t->high = np_dvec3_max(t->high, high);
}

/* Chooses cubic cells, except in a flat field, whose height needs several cells. */
static void choose_size(np_trial *t) {
  const np_dvec3 extent = np_dvec3_subtract(t->high, t->low);
  const double edge = cbrt(extent.x * extent.y * extent.z / map_cells);
  t->size[2] = (int32_t)np_clamp(ceil(extent.z / edge), HEIGHTS_MIN, HEIGHTS_MAX);
  const double across = sqrt(extent.x * extent.y / (map_cells / t->size[2]));
  t->size[0] = (int32_t)np_clamp(ceil(extent.x / across), 1.0, SIDE_MAX);
  t->size[1] = (int32_t)np_clamp(ceil(extent.y / across), 1.0, SIDE_MAX);
}

static void get_steps(const np_trial *t, double out[3]) {
  const np_dvec3 extent = np_dvec3_subtract(t->high, t->low);
  out[0] = extent.x / t->size[0];
  out[1] = extent.y / t->size[1];
  out[2] = extent.z / t->size[2];
}

static size_t join(const np_trial *t, int32_t x, int32_t y, int32_t z) {
  return ((size_t)z * (size_t)t->size[1] + (size_t)y) * (size_t)t->size[0] + (size_t)x;
}

/* Cells whose middles lie in a world box: [first, end) along each axis. */
static void list_cells(const np_trial *t, np_dvec3 low, np_dvec3 high, int32_t first[3], int32_t end[3]) {
  const double from[3] = {low.x - t->low.x, low.y - t->low.y, low.z - t->low.z},
               to[3] = {high.x - t->low.x, high.y - t->low.y, high.z - t->low.z};
  double step[3];
  get_steps(t, step);
  for (int a = 0; a < 3; a++) {
    first[a] = (int32_t)np_clamp(ceil(from[a] / step[a] - 0.5), 0.0, t->size[a]);
    end[a] = (int32_t)np_clamp(floor(to[a] / step[a] - 0.5) + 1.0, 0.0, t->size[a]);
  }
}

static np_dvec3 get_middle(const np_trial *t, int32_t x, int32_t y, int32_t z) {
  double step[3];
  get_steps(t, step);
  return np_dvec3_make(t->low.x + (x + 0.5) * step[0], t->low.y + (y + 0.5) * step[1], t->low.z + (z + 0.5) * step[2]);
}

static float *get_ground(const np_trial *t, int32_t x, int32_t y) { return &t->ground_m[y * t->size[0] + x]; }

/* Heights of the ground at the middles of columns. */
static void raise_ground(np_trial *t, const neph_terrain *terrain, const int32_t first[3], const int32_t end[3]) {
  for (int32_t y = first[1]; y < end[1]; y++)
    for (int32_t x = first[0]; x < end[0]; x++) {
      const np_dvec3 at = get_middle(t, x, y, 0);
      *get_ground(t, x, y) = (float)neph_terrain_get_elevation_m(terrain, at.x, at.y);
    }
}

static void add_copy(void *user, const trial_source *source, const np_affine *world_to_index, np_dvec3 low,
                     np_dvec3 high) {
  np_trial *t = user;
  int32_t first[3], end[3];
  list_cells(t, low, high, first, end);
  if (source->own.terrain) raise_ground(t, source->own.terrain, first, end);
  for (int32_t z = first[2]; z < end[2]; z++)
    for (int32_t y = first[1]; y < end[1]; y++)
      for (int32_t x = first[0]; x < end[0]; x++) {
        const np_dvec3 at = get_middle(t, x, y, z);
        if (at.z >= (double)*get_ground(t, x, y)) t->extinction[join(t, x, y, z)] += sample(source, world_to_index, at);
      }
}

static uint32_t *get_sum(const np_trial *t, int32_t x, int32_t y, int32_t z) {
  const size_t row = (size_t)t->size[0] + 1, plane = row * ((size_t)t->size[1] + 1);
  return &t->sums[(size_t)z * plane + (size_t)y * row + (size_t)x];
}

/* Sums of a box between two corners. */
static uint32_t count_between(const np_trial *t, const int32_t a[3], const int32_t b[3]) {
  const uint32_t top = *get_sum(t, b[0], b[1], b[2]) - *get_sum(t, a[0], b[1], b[2]) - *get_sum(t, b[0], a[1], b[2]) +
                       *get_sum(t, a[0], a[1], b[2]);
  const uint32_t bottom = *get_sum(t, b[0], b[1], a[2]) - *get_sum(t, a[0], b[1], a[2]) -
                          *get_sum(t, b[0], a[1], a[2]) + *get_sum(t, a[0], a[1], a[2]);
  return top - bottom;
}

static void sum_map(np_trial *t) {
  for (int32_t z = 0; z < t->size[2]; z++)
    for (int32_t y = 0; y < t->size[1]; y++) {
      uint32_t row = 0;
      for (int32_t x = 0; x < t->size[0]; x++) {
        row += t->extinction[join(t, x, y, z)] > 0.0f;
        *get_sum(t, x + 1, y + 1, z + 1) =
            row + *get_sum(t, x + 1, y, z + 1) + *get_sum(t, x + 1, y + 1, z) - *get_sum(t, x + 1, y, z);
      }
    }
}

/* Mean thickness of cloud layers over columns, weighted by thickness as in np_thickness_measure. */
static double measure_thickness(const np_trial *t) {
  double lengths = 0.0, squares = 0.0, step[3];
  get_steps(t, step);
  for (int32_t y = 0; y < t->size[1]; y++)
    for (int32_t x = 0; x < t->size[0]; x++) {
      int layer = 0;
      for (int32_t z = 0; z <= t->size[2]; z++) {
        if (z < t->size[2] && t->extinction[join(t, x, y, z)] > 0.0f) {
          layer++;
          continue;
        }
        lengths += layer;
        squares += (double)layer * layer;
        layer = 0;
      }
    }
  return lengths > 0.0 ? squares / lengths * step[2] : HUGE_VAL;
}

bool np_trial_has_cloud(const np_trial *t, np_dvec3 low, np_dvec3 high) {
  const double from[3] = {low.x - t->low.x, low.y - t->low.y, low.z - t->low.z},
               to[3] = {high.x - t->low.x, high.y - t->low.y, high.z - t->low.z};
  int32_t first[3], end[3];
  double step[3];
  get_steps(t, step);
  for (int a = 0; a < 3; a++) {
    first[a] = (int32_t)np_clamp(floor(from[a] / step[a] + 0.01), 0.0, t->size[a]);
    end[a] = (int32_t)np_clamp(ceil(to[a] / step[a] - 0.01), 0.0, t->size[a]);
    if (first[a] >= end[a]) return false;
  }
  const float ground_m = *get_ground(t, (first[0] + end[0]) / 2, (first[1] + end[1]) / 2);
  return 0.5 * (low.z + high.z) >= (double)ground_m && count_between(t, first, end) > 0;
}

/* ---- Bricks ---- */

/* Limit on the bricks examined along each side. */
enum { BRICKS_MAX = 64 };

/* Whether any of the samples in and around a brick holds cloud. */
static bool holds_cloud(const np_bricks *bricks, const double low[3], const double edge[3]) {
  int32_t count[3];
  for (int a = 0; a < 3; a++) count[a] = (int32_t)np_clamp(ceil(edge[a]) + 1.0, 2.0, 9.0);
  for (int32_t k = 0; k < count[2]; k++)
    for (int32_t j = 0; j < count[1]; j++)
      for (int32_t i = 0; i < count[0]; i++) {
        const np_dvec3 at = np_dvec3_make(low[0] + edge[0] * i / (count[0] - 1), low[1] + edge[1] * j / (count[1] - 1),
                                          low[2] + edge[2] * k / (count[2] - 1));
        if (np_bricks_sample(bricks, at) > 0.0f) return true;
      }
  return false;
}

/* Share of the bricks in a bake's box, with voxels of length `voxel_m`, that hold cloud in the trial. */
static double count_brick_share(const neph_cloud_desc *bake, double voxel_m, const neph_volume *volume) {
  const double low_m[3] = {bake->center_m[0] - 0.5 * bake->extent_m[0], bake->center_m[1] - 0.5 * bake->extent_m[1],
                           bake->base_altitude_m};
  const double size_m[3] = {bake->extent_m[0], bake->extent_m[1], bake->thickness_m};
  const np_dvec3 low = np_affine_point(&volume->world_to_index, np_dvec3_make(low_m[0], low_m[1], low_m[2]));
  const double first[3] = {low.x, low.y, low.z};
  double edge[3], held = 0.0, all = 1.0;
  int32_t count[3];
  for (int a = 0; a < 3; a++) {
    const double exact = size_m[a] / (NP_BRICK_EDGE * voxel_m);
    count[a] = (int32_t)np_clamp(ceil(exact), 1.0, BRICKS_MAX);
    edge[a] = size_m[a] * volume->world_to_index.m[a][a] / (exact > BRICKS_MAX ? BRICKS_MAX : fmax(exact, 1.0));
    all *= count[a];
  }
  for (int32_t n = 0; n < (int32_t)all; n++) {
    const int32_t at[3] = {n % count[0], n / count[0] % count[1], n / count[0] / count[1]};
    const double corner[3] = {first[0] + at[0] * edge[0], first[1] + at[1] * edge[1], first[2] + at[2] * edge[2]};
    held += holds_cloud(&volume->bricks, corner, edge);
  }
  return held / all;
}

double np_trial_cloud_get_share(const np_trial_cloud *cloud, double factor) {
  const double at = np_clamp(log2(factor), 0.0, NP_TRIAL_SHARES - 1.0);
  const int below = (int)fmin(at, NP_TRIAL_SHARES - 2.0);
  return cloud->brick_share[below] + (at - below) * (cloud->brick_share[below + 1] - cloud->brick_share[below]);
}

static double compute_shortest_edge(const np_affine *world_to_index) {
  double shortest_m = HUGE_VAL;
  for (int a = 0; a < 3; a++) {
    const double *row = world_to_index->m[a];
    shortest_m = fmin(shortest_m, 1.0 / np_dvec3_length(np_dvec3_make(row[0], row[1], row[2])));
  }
  return shortest_m;
}

static void describe_cloud(const np_scene_cloud *cloud, const trial_source *source, np_trial_cloud *out) {
  out->densest_per_m = (double)source->even_per_m;
  if (!source->own.volume) return;
  out->densest_per_m = (double)(source->own.volume->bricks.value_max * source->world.extinction_per_value);
  if (cloud->is_baked) {
    for (int k = 0; k < NP_TRIAL_SHARES; k++)
      out->brick_share[k] =
          count_brick_share(&source->own.bake, source->own.bake.voxel_m * (1 << k), source->own.volume);
  } else {
    out->voxel_m = compute_shortest_edge(&source->world.world_to_index);
    out->brick_voxels = pow(NP_BRICK_EDGE, 3.0) * (double)source->own.volume->bricks.brick_count;
  }
}

/* ---- All of it ---- */

static neph_result fill(const neph_scene *scene, const np_inputs *inputs, trial_source *sources, np_trial *t) {
  choose_size(t);
  const size_t cells = (size_t)t->size[0] * (size_t)t->size[1] * (size_t)t->size[2];
  const size_t corners = ((size_t)t->size[0] + 1) * ((size_t)t->size[1] + 1) * ((size_t)t->size[2] + 1);
  t->extinction = np_alloc(t->context, cells, sizeof *t->extinction);
  t->sums = np_alloc(t->context, corners, sizeof *t->sums);
  const size_t columns = (size_t)t->size[0] * (size_t)t->size[1];
  t->ground_m = np_alloc(t->context, columns, sizeof *t->ground_m);
  if (!t->extinction || !t->sums || !t->ground_m) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < columns; i++) t->ground_m[i] = -HUGE_VALF;
  for (unsigned i = 0; i < scene->cloud_count; i++) {
    lay_over(t, &scene->clouds[i], np_inputs_get_file(inputs, i), &sources[i]);
    visit_copies(&scene->clouds[i], &sources[i], add_copy, t);
  }
  sum_map(t);
  t->thickness_m = measure_thickness(t);
  return NEPH_OK;
}

static neph_result make(const neph_scene *scene, const np_request *request, const np_inputs *inputs,
                        trial_source *sources, np_trial *t) {
  neph_result result = NEPH_OK;
  for (unsigned i = 0; i < scene->cloud_count && !result; i++) {
    result = make_source(scene, request, inputs, i, &sources[i]);
    if (result) break;
    describe_cloud(&scene->clouds[i], &sources[i], &t->clouds[i]);
    visit_copies(&scene->clouds[i], &sources[i], include_copy, t);
    t->is_endless = t->is_endless || scene->clouds[i].repeat != NP_REPEAT_NONE;
  }
  t->is_mixed = t->is_endless && scene->cloud_count > 1;
  const np_dvec3 extent = np_dvec3_subtract(t->high, t->low);
  const bool has_box = extent.x > 0.0 && extent.y > 0.0 && extent.z > 0.0;
  return !result && has_box ? fill(scene, inputs, sources, t) : result;
}

neph_result np_trial_make(const neph_scene *scene, const np_request *request, const np_inputs *inputs,
                          np_trial **out_trial) {
  *out_trial = NULL;
  if (scene->cloud_count == 0 || scene->cloud_count > NP_INSTANCES_MAX) return NEPH_OK;
  np_trial *t = np_alloc(scene->context, 1, sizeof *t);
  trial_source *sources = t ? np_alloc(scene->context, scene->cloud_count, sizeof *sources) : NULL;
  if (t)
    *t = (np_trial){.context = scene->context,
                    .references = 1,
                    .low = {HUGE_VAL, HUGE_VAL, HUGE_VAL},
                    .high = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
  neph_result result = sources ? make(scene, request, inputs, sources, t) : NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; sources && i < scene->cloud_count; i++) np_trial_volume_clear(&sources[i].own);
  np_alloc_free(scene->context, sources);
  if (!result && t->sums)
    *out_trial = t;
  else
    np_trial_release(t);
  return result;
}

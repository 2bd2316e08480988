/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/volume_private.h"

#include <assert.h>
#include <string.h>

#include "core/alloc.h"
#include "core/given.h"
#include "volume/volume_tint.h"

enum { DENSE_EDGE_MAX = 1 << 24 };

/* ---- Life ---- */

/* Destroys a tint, whose parts are volumes. */
void np_tint_destroy(np_tint *tint) {
  if (!tint) return;
  for (unsigned i = 0; i < tint->count; i++) neph_volume_release(tint->parts[i].volume);
  np_alloc_free(tint->context, tint);
}

static void destroy(neph_volume *volume) {
  neph_context *context = volume->context;
  np_tint_destroy(volume->tint);
  np_bricks_clear(&volume->bricks);
  np_alloc_free(context, volume->name);
  np_alloc_free(context, volume);
  np_context_release(context);
}

neph_volume *neph_volume_retain(neph_volume *volume) {
  if (volume) atomic_fetch_add(&volume->references, 1);
  return volume;
}

void neph_volume_release(neph_volume *volume) {
  if (volume && atomic_fetch_sub(&volume->references, 1) == 1) destroy(volume);
}

neph_context *np_volume_get_context(const neph_volume *volume) { return volume->context; }

static neph_result set_transform(neph_volume *volume, const np_sparse_grid *grid) {
  volume->index_to_world = grid->index_to_world;
  if (np_affine_invert(&grid->index_to_world, &volume->world_to_index)) return NEPH_OK;
  return np_fail(
      volume->context, NEPH_ERROR_INVALID_ARGUMENT,
      "%s%sgrid '%s': the transform from index to world has determinant %g: it must be finite and invertible",
      NP_SPARSE_GRID_LABEL(grid), np_affine_determinant(&grid->index_to_world));
}

/* Creates a volume from a grid; `measure` adds the value range. */
static neph_result create(neph_context *context, const np_sparse_grid *grid, neph_precision precision,
                          const int32_t period[2], np_monitor *monitor, neph_volume **out_volume) {
  *out_volume = NULL;
  neph_volume *volume = np_alloc(context, 1, sizeof *volume);
  if (!volume) return NEPH_ERROR_OUT_OF_MEMORY;
  np_context_retain(context);
  volume->context = context;
  volume->extinction_per_value = grid->extinction_per_value;
  atomic_init(&volume->references, 1);
  volume->name = np_alloc_text(context, grid->name);
  neph_result result = volume->name ? set_transform(volume, grid) : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = np_bricks_build(context, grid, precision, period, monitor, &volume->bricks);
  if (result)
    destroy(volume);
  else
    *out_volume = volume;
  return result;
}

static void set_extent(neph_volume *volume, const np_grid_extent *extent) {
  memcpy(volume->active_min, extent->min, sizeof extent->min);
  memcpy(volume->active_max, extent->max, sizeof extent->max);
  volume->value_min = extent->value_min;
  volume->value_max = extent->value_max;
}

neph_result np_volume_create_from_grid(neph_context *context, const np_sparse_grid *grid, neph_precision precision,
                                       np_monitor *monitor, neph_volume **out_volume) {
  np_grid_extent extent;
  (void)np_sparse_grid_measure(grid, &extent); /* measured before the grid frees its leaves */
  const uint64_t active_voxel_count = np_sparse_grid_count_active(grid);
  neph_result result = create(context, grid, precision, NULL, monitor, out_volume);
  if (result) return result;
  set_extent(*out_volume, &extent);
  (*out_volume)->active_voxel_count = active_voxel_count;
  (*out_volume)->grid_bytes = grid->leaf_count * sizeof *grid->leaves + grid->tile_count * sizeof *grid->tiles;
  return NEPH_OK;
}

neph_result np_volume_create_periodic(neph_context *context, const np_sparse_grid *grid, neph_precision precision,
                                      const int32_t period[2], const np_grid_extent *extent, np_monitor *monitor,
                                      neph_volume **out_volume) {
  const neph_result result = create(context, grid, precision, period, monitor, out_volume);
  if (!result) set_extent(*out_volume, extent);
  return result;
}

void np_volume_set_interpolation(neph_volume *volume, neph_interpolation interpolation) {
  const bool is_nearest = interpolation == NEPH_INTERPOLATION_NEAREST;
  if (!volume) return;
  volume->bricks.is_nearest = volume->bricks.is_indirect = is_nearest;
  for (unsigned k = 0; volume->tint && k < volume->tint->count; k++) {
    neph_volume *part = volume->tint->parts[k].volume;
    if (part) part->bricks.is_nearest = part->bricks.is_indirect = is_nearest;
  }
}

/* ---- Dense arrays ---- */

static neph_result check_dense_values(neph_context *context, const neph_volume_dense_desc *desc,
                                      np_grid_extent *extent) {
  size_t count = (size_t)desc->size[0] * desc->size[1] * desc->size[2];
  *extent = (np_grid_extent){{0, 0, 0}, {0, 0, 0}, INFINITY, 0.0f};
  for (int a = 0; a < 3; a++) extent->max[a] = (int32_t)desc->size[a] - 1;
  for (size_t i = 0; i < count; i++) {
    float value = desc->values[i];
    if (!isfinite(value) || value < 0.0f)
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                     "neph_volume_dense_desc.values: %g at (%zu, %zu, %zu), must be finite and not negative",
                     (double)value, i % desc->size[0], i / desc->size[0] % desc->size[1],
                     i / desc->size[0] / desc->size[1]);
    extent->value_min = fminf(extent->value_min, value);
    extent->value_max = fmaxf(extent->value_max, value);
  }
  return NEPH_OK;
}

static neph_result check_dense(neph_context *context, const neph_volume_dense_desc *desc) {
  for (int a = 0; a < 3; a++)
    if (desc->size[a] < 1 || desc->size[a] > DENSE_EDGE_MAX)
      return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "neph_volume_dense_desc.size[%d] is %u, must be in [1, %d]",
                     a, desc->size[a], DENSE_EDGE_MAX);
  if (!desc->values || !desc->name)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "neph_volume_dense_desc.%s is NULL",
                   desc->name ? "values" : "name");
  if (desc->precision != NEPH_PRECISION_HALF && desc->precision != NEPH_PRECISION_FLOAT)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "neph_volume_dense_desc.precision is %d, not a neph_precision",
                   (int)desc->precision);
  if (desc->interpolation != NEPH_INTERPOLATION_LINEAR && desc->interpolation != NEPH_INTERPOLATION_NEAREST)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "neph_volume_dense_desc.interpolation is %d, not a neph_interpolation", (int)desc->interpolation);
  return NEPH_OK;
}

/* Least common multiple of the size and 8. */
static int32_t compute_period(unsigned size) {
  unsigned period = size;
  while (period % NP_BRICK_EDGE) period += size;
  assert(size > 0 && period % size == 0);
  return (int32_t)period;
}

static bool fill_leaf(const neph_volume_dense_desc *desc, const bool is_periodic[3], np_leaf *leaf) {
  bool is_filled = false;
  for (int n = 0; n < NP_LEAF_SIZE; n++) {
    const int offset[3] = {n >> 6, n >> 3 & 7, n & 7};
    size_t at[3];
    bool is_inside = true;
    for (int a = 0; a < 3; a++) {
      at[a] = (size_t)(leaf->origin[a] + offset[a]);
      if (is_periodic[a]) at[a] %= desc->size[a];
      is_inside = is_inside && at[a] < desc->size[a];
    }
    if (!is_inside) continue;
    leaf->values[n] = desc->values[(at[2] * desc->size[1] + at[1]) * desc->size[0] + at[0]];
    leaf->active[n >> 6] |= UINT64_C(1) << (n & 63);
    is_filled = is_filled || leaf->values[n] != 0.0f;
  }
  return is_filled;
}

/* Fills leaves with the values that are not 0. Periods that are not a multiple of 8 are repeated until they are. */
static neph_result fill_grid(const neph_volume_dense_desc *desc, const int32_t period[2], np_sparse_grid *grid) {
  const bool is_periodic[3] = {desc->is_periodic_x, desc->is_periodic_y, false};
  int32_t extent[3], origin[3];
  for (int a = 0; a < 3; a++) extent[a] = is_periodic[a] ? period[a] : (int32_t)desc->size[a];
  for (origin[0] = 0; origin[0] < extent[0]; origin[0] += NP_LEAF_EDGE)
    for (origin[1] = 0; origin[1] < extent[1]; origin[1] += NP_LEAF_EDGE)
      for (origin[2] = 0; origin[2] < extent[2]; origin[2] += NP_LEAF_EDGE) {
        np_leaf *leaf = np_sparse_grid_add_leaf(grid, origin);
        if (!leaf) return NEPH_ERROR_OUT_OF_MEMORY;
        if (!fill_leaf(desc, is_periodic, leaf)) grid->leaf_count--;
      }
  return NEPH_OK;
}

static neph_result create_dense(neph_context *context, const neph_volume_dense_desc *desc, neph_volume **out_volume) {
  np_grid_extent extent;
  np_sparse_grid grid = {0};
  const int32_t period[2] = {desc->is_periodic_x ? compute_period(desc->size[0]) : 0,
                             desc->is_periodic_y ? compute_period(desc->size[1]) : 0};
  neph_result result = check_dense_values(context, desc, &extent);
  if (!result) result = np_sparse_grid_init(context, desc->name, &grid);
  memcpy(grid.index_to_world.m, desc->index_to_world, sizeof desc->index_to_world);
  if (!result) result = fill_grid(desc, period, &grid);
  if (!result) result = create(context, &grid, desc->precision, period, NULL, out_volume);
  np_sparse_grid_clear(&grid);
  if (result) return result;
  for (int a = 0; a < 2; a++) (*out_volume)->bricks.field_period[a] = period[a] ? desc->size[a] : 0.0;
  set_extent(*out_volume, &extent);
  (*out_volume)->active_voxel_count = (uint64_t)desc->size[0] * desc->size[1] * desc->size[2];
  (*out_volume)->grid_bytes = (*out_volume)->active_voxel_count * sizeof *desc->values;
  np_volume_set_interpolation(*out_volume, desc->interpolation);
  return NEPH_OK;
}

neph_result neph_volume_create_dense(neph_context *context, const neph_volume_dense_desc *desc,
                                     neph_volume **out_volume) {
  if (NP_LACKS_OUT(context, out_volume, desc)) return NEPH_ERROR_INVALID_ARGUMENT;
  static const neph_volume_dense_desc defaults = NEPH_VOLUME_DENSE_DESC_DEFAULT;
  neph_volume_dense_desc d;
  *out_volume = NULL;
  neph_result result = np_desc_read(context, "neph_volume_dense_desc", &defaults, sizeof d, desc, &d);
  if (!result) result = check_dense(context, &d);
  if (result) return result;
  unsigned float_mode = np_float_mode_enter();
  result = create_dense(context, &d, out_volume);
  np_float_mode_leave(float_mode);
  return result;
}

/* ---- Getters ---- */

void np_volume_bound_box(const np_affine *affine, const int32_t low[3], const int32_t high[3], double out_min[3],
                         double out_max[3]) {
  for (int a = 0; a < 3; a++) {
    out_min[a] = out_max[a] = affine->m[a][3];
    for (int b = 0; b < 3; b++) {
      double at_low = affine->m[a][b] * low[b], at_high = affine->m[a][b] * high[b];
      out_min[a] += fmin(at_low, at_high);
      out_max[a] += fmax(at_low, at_high);
    }
  }
}

neph_result neph_volume_get_info(const neph_volume *volume, neph_volume_info *out_info) {
  if (NP_LACKS(NP_CONTEXT_OF(volume), out_info)) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_volume_info info = {.struct_size = sizeof info,
                           .name = volume->name,
                           .active_voxel_count = volume->active_voxel_count,
                           .value_min = volume->value_min,
                           .value_max = volume->value_max,
                           .grid_bytes = volume->grid_bytes,
                           .brick_bytes = np_bricks_get_bytes(&volume->bricks),
                           .brick_count = volume->bricks.brick_count};
  memcpy(info.index_to_world, volume->index_to_world.m, sizeof info.index_to_world);
  np_volume_bound_box(&volume->index_to_world, volume->active_min, volume->active_max, info.bounds_min_m,
                      info.bounds_max_m);
  return np_desc_write(volume->context, "neph_volume_info", &info, sizeof info, out_info);
}

static float sample(const neph_volume *volume, np_dvec3 position) {
  return np_bricks_sample(&volume->bricks, np_affine_point(&volume->world_to_index, position));
}

void neph_volume_sample(const neph_volume *volume, size_t count, const double *positions_m, float *out_values) {
  if (!positions_m || !out_values) return;
  if (!volume) memset(out_values, 0, count * sizeof *out_values);
  if (!volume) return;
  unsigned float_mode = np_float_mode_enter();
  const unsigned level_count = np_volume_has_parts(volume, NP_PARTS_OF_CELLS) ? volume->tint->count : 1;
  for (size_t i = 0; i < count; i++, positions_m += 3) {
    const np_dvec3 position = np_dvec3_make(positions_m[0], positions_m[1], positions_m[2]);
    out_values[i] = sample(volume, position);
    for (unsigned k = 1; k < level_count; k++) out_values[i] += sample(np_volume_get_part(volume, k), position);
  }
  np_float_mode_leave(float_mode);
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/brick_velocity.h"

#include <string.h>

#include "core/alloc.h"

/* ---- The grids ---- */

neph_result np_velocity_field_make(neph_context *context, const np_brick_motion_desc *desc, np_velocity_field *out) {
  *out = (np_velocity_field){.grids = desc->velocity, .grid_count = 3 * desc->level_count};
  np_affine file_to_index = np_affine_identity(), file_to_grid = np_affine_identity();
  bool is_sound = np_affine_invert(&desc->index_to_file, &file_to_index);
  for (unsigned g = 0; g < out->grid_count && is_sound; g++) {
    is_sound = np_affine_invert(&desc->velocity[g].index_to_world, &file_to_grid);
    out->index_to_grid[g] = np_affine_compose(&file_to_grid, &desc->index_to_file);
  }
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) out->to_index[a][b] = desc->scale * file_to_index.m[a][b];
  if (is_sound) return NEPH_OK;
  return np_fail(context, NEPH_ERROR_BAD_FILE, "%s%sgrid '%s': its transform cannot be inverted",
                 NP_SPARSE_GRID_LABEL(&desc->velocity[0]));
}

static float get_largest(const np_sparse_grid *grid) {
  float largest = fabsf(grid->background);
  for (size_t i = 0; i < grid->leaf_count; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) largest = fmaxf(largest, fabsf(grid->leaves[i].values[n]));
  for (size_t i = 0; i < grid->tile_count; i++) largest = fmaxf(largest, fabsf(grid->tiles[i].value));
  return largest;
}

void np_velocity_field_get_bound(const np_velocity_field *field, double out[3]) {
  for (int a = 0; a < 3; a++) out[a] = 0.0;
  for (unsigned b = 0; b < 3; b++) {
    double largest = 0.0;
    for (unsigned g = b; g < field->grid_count; g += 3) largest = fmax(largest, (double)get_largest(&field->grids[g]));
    for (int a = 0; a < 3; a++) out[a] += fabs(field->to_index[a][b]) * largest;
  }
}

/* ---- One voxel ---- */

/* Velocity of one level in file lengths a second; false if it is not active there. */
static bool read_level(const np_velocity_field *field, np_grid_reader *readers, unsigned first, np_dvec3 index,
                       float out[3]) {
  bool is_active = true;
  for (unsigned a = 0; a < 3; a++) {
    const np_dvec3 at = np_affine_point(&field->index_to_grid[first + a], index);
    is_active = np_grid_read_between(&readers[first + a], at, &out[a]) && is_active;
  }
  return is_active;
}

/* Velocity of the finest active level, so that all levels of a cloud move alike; else the background. */
static bool read_voxel(const np_velocity_field *field, np_grid_reader *readers, const int32_t voxel[3], float out[3]) {
  const np_dvec3 index = np_dvec3_make(voxel[0], voxel[1], voxel[2]);
  float file[3] = {0.0f, 0.0f, 0.0f};
  bool is_active = false;
  for (unsigned first = 0; first < field->grid_count && !is_active; first += 3)
    is_active = read_level(field, readers, first, index, file);
  for (int a = 0; a < 3; a++) {
    double sum = 0.0;
    for (int b = 0; b < 3; b++) sum += field->to_index[a][b] * (double)file[b];
    out[a] = (float)sum;
  }
  return is_active;
}

/* ---- Blocks ---- */

bool np_velocity_field_fill(const np_velocity_field *field, const int32_t cell[3], np_velocity_block *out) {
  np_grid_reader readers[NP_VELOCITY_GRIDS_MAX];
  for (unsigned g = 0; g < field->grid_count; g++) readers[g] = (np_grid_reader){.grid = &field->grids[g]};
  bool are_active = true;
  for (int n = 0; n < NP_LEAF_SIZE; n++) {
    const int32_t voxel[3] = {cell[0] * NP_LEAF_EDGE + (n >> 6), cell[1] * NP_LEAF_EDGE + (n >> 3 & 7),
                              cell[2] * NP_LEAF_EDGE + (n & 7)};
    float velocity[3];
    out->layer[n] = read_voxel(field, readers, voxel, velocity);
    out->is_new[n] = false;
    for (int a = 0; a < 3; a++) out->at[a][n] = velocity[a];
    are_active = are_active && out->layer[n];
  }
  return are_active;
}

/* Block and index of a voxel next to a voxel; NULL: there is no block. */
static const np_velocity_block *get_neighbour(const np_velocity_block *block, const np_velocity_block *const near[6],
                                              int n, int side, int *out_n) {
  static const int strides[3] = {64, 8, 1};
  const int stride = strides[side / 2], at = n / stride % NP_LEAF_EDGE, step = side % 2 ? 1 : -1;
  const bool is_inside = at + step >= 0 && at + step < NP_LEAF_EDGE;
  *out_n = is_inside ? n + step * stride : n - step * (NP_LEAF_EDGE - 1) * stride;
  return is_inside ? block : near[side];
}

static bool continue_voxel(np_velocity_block *block, const np_velocity_block *const near[6], int n) {
  float sum[3] = {0.0f, 0.0f, 0.0f};
  int count = 0;
  for (int side = 0; side < 6; side++) {
    int m;
    const np_velocity_block *other = get_neighbour(block, near, n, side, &m);
    if (!other || !other->layer[m]) continue;
    for (int a = 0; a < 3; a++) sum[a] += other->at[a][m];
    count++;
  }
  if (!count) return false;
  for (int a = 0; a < 3; a++) block->at[a][n] = sum[a] / (float)count;
  return block->is_new[n] = true;
}

bool np_velocity_block_continue(np_velocity_block *block, const np_velocity_block *const near[6]) {
  bool has_grown = false;
  for (int n = 0; n < NP_LEAF_SIZE; n++)
    if (!block->layer[n] && continue_voxel(block, near, n)) has_grown = true;
  return has_grown;
}

void np_velocity_block_end_layer(np_velocity_block *block, uint8_t layer) {
  for (int n = 0; n < NP_LEAF_SIZE; n++) {
    if (block->is_new[n]) block->layer[n] = layer;
    block->is_new[n] = false;
  }
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/brick_velocity.h"

#include <string.h>

#include "core/alloc.h"

enum { EDGE_MAX = NP_BRICK_SAMPLES + 2 * NP_VELOCITY_LAYERS_MAX };

/* A cell's samples with the layers around them. */
struct np_velocity_scratch {
  int edge; /* voxels along each axis */
  size_t count;
  uint8_t *layer; /* of each voxel: 1 is active, 0 not known */
  float (*at)[3];
};

/* ---- The grids ---- */

neph_result np_velocity_field_make(neph_context *context, const np_brick_motion_desc *desc, np_velocity_field *out) {
  *out = (np_velocity_field){.grids = desc->velocity};
  np_affine file_to_index = np_affine_identity(), file_to_grid = np_affine_identity();
  bool is_sound = np_affine_invert(&desc->index_to_file, &file_to_index);
  for (int a = 0; a < 3 && is_sound; a++) {
    is_sound = np_affine_invert(&desc->velocity[a].index_to_world, &file_to_grid);
    out->index_to_grid[a] = np_affine_compose(&file_to_grid, &desc->index_to_file);
    for (int b = 0; b < 3; b++) out->to_index[a][b] = desc->scale * file_to_index.m[a][b];
  }
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
  for (int b = 0; b < 3; b++) {
    const double largest = (double)get_largest(&field->grids[b]);
    for (int a = 0; a < 3; a++) out[a] += fabs(field->to_index[a][b]) * largest;
  }
}

/* ---- One voxel ---- */

/* Active corners alone count; false where there are none, and the value is then the background. */
static bool read_between(np_grid_reader *reader, np_dvec3 at, float *out) {
  const double position[3] = {at.x, at.y, at.z};
  int32_t low[3];
  double fraction[3], sum = 0.0, weight = 0.0;
  for (int a = 0; a < 3; a++) {
    const double nearest = round(position[a]);
    const double whole = fabs(position[a] - nearest) < 1e-4 ? nearest : floor(position[a]);
    low[a] = (int32_t)whole;
    fraction[a] = fabs(position[a] - whole) < 1e-4 ? 0.0 : position[a] - whole;
  }
  for (int corner = 0; corner < 8; corner++) {
    double share = 1.0;
    int32_t voxel[3];
    for (int a = 0; a < 3; a++) {
      share *= corner >> a & 1 ? fraction[a] : 1.0 - fraction[a];
      voxel[a] = low[a] + (corner >> a & 1);
    }
    float value;
    if (!(share > 0.0) || !np_grid_read(reader, voxel, &value)) continue;
    sum += share * (double)value;
    weight += share;
  }
  *out = weight > 0.0 ? (float)(sum / weight) : reader->grid->background;
  return weight > 0.0;
}

static bool read_voxel(const np_velocity_field *field, np_grid_reader readers[3], const int32_t voxel[3],
                       float out[3]) {
  const np_dvec3 index = np_dvec3_make(voxel[0], voxel[1], voxel[2]);
  float file[3];
  bool is_active = true;
  for (int a = 0; a < 3; a++)
    is_active = read_between(&readers[a], np_affine_point(&field->index_to_grid[a], index), &file[a]) && is_active;
  for (int a = 0; a < 3; a++) {
    double sum = 0.0;
    for (int b = 0; b < 3; b++) sum += field->to_index[a][b] * (double)file[b];
    out[a] = (float)sum;
  }
  return is_active;
}

/* ---- Windows ---- */

np_velocity_scratch *np_velocity_scratch_create(neph_context *context, const np_velocity_field *field) {
  const int edge = NP_BRICK_SAMPLES + 2 * field->layers;
  const size_t count = (size_t)edge * (size_t)edge * (size_t)edge;
  const size_t head = (sizeof(np_velocity_scratch) + 15) / 16 * 16, values = 3 * count * sizeof(float);
  char *block = np_alloc(context, 1, head + values + count);
  np_velocity_scratch *scratch = (np_velocity_scratch *)(void *)block;
  if (!scratch) return NULL;
  *scratch =
      (np_velocity_scratch){edge, count, (uint8_t *)(block + head + values), (float(*)[3])(void *)(block + head)};
  return scratch;
}

/* Voxels along each axis of a part of the scratch, `margin` voxels inside it, in order. */
static size_t get_place(const np_velocity_scratch *s, int x, int y, int z) {
  return ((size_t)x * (size_t)s->edge + (size_t)y) * (size_t)s->edge + (size_t)z;
}

/* Fills the scratch `margin` voxels inside its edge; returns whether all there are active. */
static bool gather(const np_velocity_field *field, const int32_t cell[3], int margin, np_velocity_scratch *s) {
  np_grid_reader readers[3] = {{.grid = &field->grids[0]}, {.grid = &field->grids[1]}, {.grid = &field->grids[2]}};
  bool are_active = true;
  for (int x = margin; x < s->edge - margin; x++)
    for (int y = margin; y < s->edge - margin; y++)
      for (int z = margin; z < s->edge - margin; z++) {
        const int32_t voxel[3] = {cell[0] * NP_BRICK_EDGE + x - field->layers,
                                  cell[1] * NP_BRICK_EDGE + y - field->layers,
                                  cell[2] * NP_BRICK_EDGE + z - field->layers};
        const size_t place = get_place(s, x, y, z);
        s->layer[place] = read_voxel(field, readers, voxel, s->at[place]);
        are_active = are_active && s->layer[place];
      }
  return are_active;
}

/* The mean of the neighbours that are known by an earlier layer; false: none is. */
static bool continue_voxel(np_velocity_scratch *s, const int at[3], uint8_t layer) {
  float sum[3] = {0.0f, 0.0f, 0.0f};
  int count = 0;
  for (int k = 0; k < 6; k++) {
    int near[3] = {at[0], at[1], at[2]};
    near[k / 2] += k % 2 ? 1 : -1;
    if (near[k / 2] < 0 || near[k / 2] >= s->edge) continue;
    const size_t place = get_place(s, near[0], near[1], near[2]);
    if (!s->layer[place] || s->layer[place] >= layer) continue;
    for (int a = 0; a < 3; a++) sum[a] += s->at[place][a];
    count++;
  }
  if (!count) return false;
  const size_t place = get_place(s, at[0], at[1], at[2]);
  for (int a = 0; a < 3; a++) s->at[place][a] = sum[a] / (float)count;
  s->layer[place] = layer;
  return true;
}

static bool continue_layer(np_velocity_scratch *s, uint8_t layer) {
  bool has_grown = false;
  for (int x = 0; x < s->edge; x++)
    for (int y = 0; y < s->edge; y++)
      for (int z = 0; z < s->edge; z++)
        if (!s->layer[get_place(s, x, y, z)] && continue_voxel(s, (const int[3]){x, y, z}, layer)) has_grown = true;
  return has_grown;
}

void np_velocity_field_fill(const np_velocity_field *field, const int32_t cell[3], np_velocity_scratch *scratch,
                            np_velocity_window *out) {
  const int margin = field->layers;
  if (!gather(field, cell, margin, scratch) && margin > 0) {
    (void)gather(field, cell, 0, scratch);
    for (int k = 0; k < margin && continue_layer(scratch, (uint8_t)(k + 2)); k++) continue;
  }
  for (int n = 0; n < NP_BRICK_VOLUME; n++) {
    const size_t place = get_place(scratch, n / NP_BRICK_STRIDE_X + margin,
                                   n / NP_BRICK_SAMPLES % NP_BRICK_SAMPLES + margin, n % NP_BRICK_SAMPLES + margin);
    for (int a = 0; a < 3; a++) out->at[a][n] = scratch->at[place][a];
  }
}

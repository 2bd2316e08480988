/* SPDX-License-Identifier: Apache-2.0 */
/* Upper bound and estimate of the memory of a bake, computed once its leaves are marked and before it allocates.
 *
 * Leaves and their parent nodes are counted as if all marked leaves held cloud; a sample gives the actual share. Memory
 * at the peak: the grid's leaves, together with the buffers of the bake, or the bricks for measuring the error, or the
 * output (as leaves of nephos and as OpenVDB's tree). */
#include "cloud/bake_memory.h"

#include "cloud/bake_error.h"
#include "cloud/bake_field.h"
#include "cloud/cloud_name.h"
#include "core/alloc.h"
#include "volume/bricks.h"

/* OpenVDB 10: a leaf's buffer, mask and origin, with malloc's overhead; nodes of 16³ and 32³ children, each a pointer
 * or a value, with two bit masks; the library, its tables and its threads' stacks. */
enum {
  VDB_LEAF_BYTES = 200,
  VDB_LOWER_CHILDREN = 16 * 16 * 16,
  VDB_UPPER_CHILDREN = 32 * 32 * 32,
  VDB_LOWER_LEAVES = 16, /* leaves along the edge of a node */
  VDB_UPPER_LEAVES = 512,
  VDB_CHILD_BYTES = 8,
  VDB_VECTOR_CHILD_BYTES = 16
};
static const double vdb_library_bytes = 45e6;

enum { BATCH_BYTES = 2048 * (sizeof(np_leaf) + 12) }; /* buffer of leaves and their origins */

typedef struct memory_need {
  double leaves, tree, bricks, work;
  double meter; /* allocated all the time */
} memory_need;

static double count_model_bytes(const np_cloud_model *model) {
  return np_weather_map_count_bytes(&model->map) + np_measured_columns_count_bytes(&model->columns) +
         np_ball_heap_count_bytes(&model->balls) + (model->shape ? np_shape_grid_count_bytes(model->shape) : 0);
}

/* Number of cells of `edge` leaves with a marked leaf; cells are aligned to leaf 0. Negative: out of memory. */
static double count_cells(const np_bake *bake, const np_bake_marks *marks, int32_t edge) {
  if (edge == 1) return (double)marks->cloudy_count;
  int32_t low[3], size[3];
  for (int a = 0; a < 3; a++) {
    low[a] = (int32_t)floor((double)bake->leaf_begin[a] / edge);
    size[a] = (int32_t)floor((double)(bake->leaf_begin[a] + bake->leaf_count[a] - 1) / edge) - low[a] + 1;
  }
  const size_t cell_count = (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
  uint8_t *cells = np_alloc(bake->context, cell_count, 1);
  if (!cells) return -1;
  const uint8_t *mark = marks->is_cloudy;
  size_t count = 0;
  for (int32_t i = 0; i < bake->leaf_count[0]; i++)
    for (int32_t j = 0; j < bake->leaf_count[1]; j++)
      for (int32_t k = 0; k < bake->leaf_count[2]; k++) {
        if (!*mark++) continue;
        const int32_t at[3] = {i, j, k};
        size_t cell = 0;
        for (int a = 0; a < 3; a++)
          cell = cell * (size_t)size[a] + (size_t)((bake->leaf_begin[a] - low[a] * edge + at[a]) / edge);
        count += !cells[cell];
        cells[cell] = 1;
      }
  np_alloc_free(bake->context, cells);
  return (double)count;
}

static bool is_marked(const np_bake *bake, const np_bake_marks *marks, const int32_t at[3]) {
  size_t leaf = 0;
  for (int a = 0; a < 3; a++) {
    if (at[a] < 0 || at[a] >= bake->leaf_count[a]) return false;
    leaf = leaf * (size_t)bake->leaf_count[a] + (size_t)at[a];
  }
  return marks->is_cloudy[leaf];
}

/* Whether a cell needs a brick: bricks reach one sample into the leaves beyond their own. */
static bool has_brick(const np_bake *bake, const np_bake_marks *marks, int32_t i, int32_t j, int32_t k) {
  for (int corner = 0; corner < 8; corner++) {
    const int32_t at[3] = {i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2)};
    if (is_marked(bake, marks, at)) return true;
  }
  return false;
}

static double count_brick_bytes(const np_bake *bake, const np_bake_marks *marks, neph_precision precision) {
  const int32_t *count = bake->leaf_count;
  size_t bricks = 0;
  for (int32_t i = -1; i < count[0]; i++)
    for (int32_t j = -1; j < count[1]; j++)
      for (int32_t k = -1; k < count[2]; k++) bricks += has_brick(bake, marks, i, j, k);
  const double cells = (count[0] + 1.0) * (count[1] + 1.0) * (count[2] + 1.0);
  const double sample_bytes = precision == NEPH_PRECISION_HALF ? 2 : 4;
  return (double)bricks * NP_BRICK_STRIDE * sample_bytes +
         cells * (2 * sizeof(uint32_t) + 1.02 * sizeof(np_brick_range)); /* 4⁻³ + 16⁻³ for the coarser levels */
}

static double count_tree_bytes(double leaves, double lower, double upper, double value_bytes, double child_bytes) {
  return leaves * (NP_LEAF_SIZE * value_bytes + VDB_LEAF_BYTES) + lower * VDB_LOWER_CHILDREN * (child_bytes + 0.25) +
         upper * VDB_UPPER_CHILDREN * (child_bytes + 0.25);
}

/* Adds a level of detail, or the grid itself for 0, and, with the grid, its velocity. False: out of memory. */
static bool add_level(const np_bake *bake, const np_bake_marks *marks, int level, memory_need *need) {
  const double leaves = count_cells(bake, marks, 1 << level);
  const double lower = count_cells(bake, marks, VDB_LOWER_LEAVES << level);
  const double upper = count_cells(bake, marks, VDB_UPPER_LEAVES << level);
  if (leaves < 0 || lower < 0 || upper < 0) return false;
  need->leaves += leaves * sizeof(np_leaf);
  need->tree += count_tree_bytes(leaves, lower, upper, sizeof(float), VDB_CHILD_BYTES);
  if (level) need->leaves += 3.0 * sizeof(int32_t) * leaves * 8; /* origins to be sorted */
  if (level || !bake->desc.has_velocity) return true;
  need->leaves += 3 * leaves * sizeof(np_leaf);
  need->tree += count_tree_bytes(leaves, lower, upper, 3 * sizeof(float), VDB_VECTOR_CHILD_BYTES);
  return true;
}

static bool compute_need(const np_bake *bake, const np_bake_marks *marks, memory_need *need) {
  const double model_bytes = count_model_bytes(&bake->model);
  *need = (memory_need){.leaves = (double)marks->cloudy_count * sizeof(np_leaf),
                        .work = (double)np_bake_count_box(bake) + BATCH_BYTES + model_bytes};
  const bool has_bricks = bake->use == NP_BAKE_FOR_BRICKS || bake->use == NP_BAKE_FOR_SKETCH;
  if (has_bricks) need->bricks = count_brick_bytes(bake, marks, bake->desc.precision);
  if (bake->use != NP_BAKE_FOR_FILE) return true;
  need->leaves = 0;
  need->tree = vdb_library_bytes;
  if (bake->desc.error) need->bricks = count_brick_bytes(bake, marks, NEPH_PRECISION_FLOAT);
  if (bake->meter) need->meter = count_model_bytes(&bake->meter->detailed) + np_bake_meter_count_bytes();
  if (bake->desc.has_velocity) need->work += 2 * model_bytes;
  for (unsigned level = 0; level < bake->desc.level_count; level++)
    if (!add_level(bake, marks, (int)level, need)) return false;
  return true;
}

/* Memory in bytes below which a bake does not log its need. */
static const double logged_bytes = 1e7;

neph_result np_bake_check_memory(const np_bake *bake, const np_bake_marks *marks) {
  memory_need need;
  if (!compute_need(bake, marks, &need)) return NEPH_ERROR_OUT_OF_MEMORY;
  const double at_a_time = fmax(need.work, fmax(need.tree, need.bricks)), bytes = need.meter + need.leaves + at_a_time;
  const double library = fmin(need.tree, vdb_library_bytes), share = marks->share;
  const double likely = need.meter + share * need.leaves +
                        fmax(need.work, fmax(library + share * (need.tree - library), share * need.bricks));
  const neph_cloud_desc *cloud = &bake->model.desc;
  if (bytes > logged_bytes)
    np_log(bake->context, NEPH_LOG_INFO, "%s: needs about %.2g GB of memory, at most %.2g GB",
           np_cloud_desc_name(cloud), likely * 1e-9, bytes * 1e-9);
  const double machine = (double)np_memory_size(), asked = (double)bake->desc.memory_max_bytes;
  if (bytes <= fmin(machine, asked)) return NEPH_OK;
  return np_fail(bake->context, NEPH_ERROR_LIMIT,
                 "%s: the bake may need %.3g GB, must be at most %.3g GB%s: enlarge voxel, which is %g m, reduce "
                 "extent, or bake a region",
                 np_cloud_desc_name(cloud), bytes * 1e-9, fmin(machine, asked) * 1e-9,
                 machine < asked ? ", which this machine has" : "", bake->voxel_m);
}

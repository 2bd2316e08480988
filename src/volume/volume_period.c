/* SPDX-License-Identifier: Apache-2.0 */
/* Volumes of files that repeat along x and y without end. The box of the active voxels, or of the domain that the file
 * states, is moved to the start of its period, so that look-ups beyond wrap into it (volume/brick_periods.h). Bricks
 * are 8 voxels wide: a period that is no multiple of 8 is stored as often as it takes to be one. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "core/alloc.h"
#include "core/text.h"
#include "volume/volume_private.h"

/* A grid and its copies in one period of the bricks. */
typedef struct tiling {
  const np_sparse_grid *source;
  np_sparse_grid *grid;
  np_grid_extent box;                 /* active voxels of the source */
  int32_t start[2], width[2];         /* first voxels and sizes along x and y of all that the file has */
  int32_t period[2], stored[2];       /* voxels of a period, and of all that is stored; 0: the axis does not repeat */
  int32_t shift[3];                   /* added to the source's indices */
  int32_t first_leaf[3], leaf_end[3]; /* leaves of the result */
  uint32_t *leaves;                   /* number of each leaf plus 1; 0: none */
} tiling;

/* ---- Periods ---- */

static const char axis_names[] = "xy";

static double get_edge(const np_affine *map, int axis) {
  return np_dvec3_length(np_dvec3_make(map->m[0][axis], map->m[1][axis], map->m[2][axis]));
}

/* Length of a voxel along an axis, as clouds[].voxel scales it. */
static double get_scaled_edge(const np_sparse_grid *grid, const neph_volume_load_desc *desc, int axis) {
  const np_affine *map = &grid->index_to_world;
  const double largest = fmax(fmax(get_edge(map, 0), get_edge(map, 1)), get_edge(map, 2));
  return get_edge(map, axis) * (desc->repeat_voxel_m > 0.0 ? desc->repeat_voxel_m / largest : 1.0);
}

/* Refuses grids whose x and y are turned against the world's: periods run along both. */
static neph_result check_turn(const np_sparse_grid *grid) {
  static const double least = 1e-6;
  for (int a = 0; a < 2; a++)
    for (int b = 0; b < 3; b++)
      if (b != a && fabs(grid->index_to_world.m[b][a]) > least * get_edge(&grid->index_to_world, a))
        return np_fail(grid->context, NEPH_ERROR_BAD_FILE,
                       "%s%sgrid '%s' is turned in its file: a cloud that repeats must lie along x and y, with z up",
                       NP_SPARSE_GRID_LABEL(grid));
  return NEPH_OK;
}

static neph_result refuse_fraction(const np_sparse_grid *grid, int axis, double voxels, double edge_m) {
  return np_fail(grid->context, NEPH_ERROR_BAD_SCENE,
                 "%s%sgrid '%s': clouds[].repeat is %.6g m along %c, %.6g voxels of %.6g m, must be a whole number of "
                 "them: %.6g m or %.6g m",
                 NP_SPARSE_GRID_LABEL(grid), voxels * edge_m, axis_names[axis], voxels, edge_m, floor(voxels) * edge_m,
                 ceil(voxels) * edge_m);
}

static neph_result refuse_small(const np_sparse_grid *grid, int axis, double voxels, double edge_m, int32_t box) {
  return np_fail(grid->context, NEPH_ERROR_BAD_SCENE,
                 "%s%sgrid '%s': clouds[].repeat is %.6g m along %c, %.6g voxels, less than its box of %" PRId32
                 " voxels, %.6g m: must be at least that, or file",
                 NP_SPARSE_GRID_LABEL(grid), voxels * edge_m, axis_names[axis], voxels, box, box * edge_m);
}

static neph_result compute_period(tiling *t, const neph_volume_load_desc *desc, int axis) {
  static const double tolerance = 1e-3, most = 1 << 20;
  const int32_t box = t->width[axis];
  const double edge_m = get_scaled_edge(t->source, desc, axis), voxels = desc->repeat_m[axis] / edge_m;
  if (desc->repeat_m[axis] == NEPH_REPEAT_FILE) return t->period[axis] = box, NEPH_OK;
  if (voxels == 0.0) return NEPH_OK;
  if (fabs(voxels - round(voxels)) > tolerance) return refuse_fraction(t->source, axis, voxels, edge_m);
  if (round(voxels) < box) return refuse_small(t->source, axis, voxels, edge_m, box);
  if (voxels > most)
    return np_fail(t->source->context, NEPH_ERROR_BAD_SCENE,
                   "%s%sgrid '%s': clouds[].repeat is %.6g voxels along %c, must be at most %.6g",
                   NP_SPARSE_GRID_LABEL(t->source), voxels, axis_names[axis], most);
  t->period[axis] = (int32_t)round(voxels);
  return NEPH_OK;
}

/* Sets what is stored: the least common multiple of the period and of a brick, or of two where voxels are halved. */
static void set_stored(tiling *t, bool is_halved) {
  const int32_t edge = is_halved ? 2 * NP_LEAF_EDGE : NP_LEAF_EDGE;
  for (int a = 0; a < 2; a++) {
    t->stored[a] = t->period[a];
    while (t->stored[a] % edge) t->stored[a] += t->period[a];
  }
}

static int32_t count_copies(const tiling *t, int axis) {
  return t->period[axis] ? t->stored[axis] / t->period[axis] : 1;
}

static void describe_stored(const tiling *t) {
  if (count_copies(t, 0) * count_copies(t, 1) < 2) return;
  np_log(t->source->context, NEPH_LOG_INFO,
         "%s%sgrid '%s': its period of %" PRId32 " by %" PRId32 " voxels is stored %" PRId32 " by %" PRId32
         " times: multiples of 8 need it once",
         NP_SPARSE_GRID_LABEL(t->source), t->period[0], t->period[1], count_copies(t, 0), count_copies(t, 1));
}

/* ---- Voxels that count: active ones, and inactive ones with a value ---- */

static bool has_voxel(const np_leaf *leaf, int n) {
  return (leaf->active[n >> 6] >> (n & 63) & 1u) || leaf->values[n] != 0.0f;
}

static bool has_tile(const np_tile *tile) { return tile->is_active || tile->value != 0.0f; }

static void include(const int32_t low[3], int32_t edge, np_grid_extent *box) {
  for (int a = 0; a < 3; a++) {
    box->min[a] = low[a] < box->min[a] ? low[a] : box->min[a];
    box->max[a] = low[a] + edge - 1 > box->max[a] ? low[a] + edge - 1 : box->max[a];
  }
}

/* Adds inactive voxels with a value to the box of the active ones. */
static void include_values(const np_sparse_grid *grid, np_grid_extent *box) {
  for (size_t i = 0; i < grid->leaf_count; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const int32_t *o = grid->leaves[i].origin;
      if (has_voxel(&grid->leaves[i], n))
        include((const int32_t[3]){o[0] + (n >> 6), o[1] + (n >> 3 & 7), o[2] + (n & 7)}, 1, box);
    }
  for (size_t i = 0; i < grid->tile_count; i++)
    if (has_tile(&grid->tiles[i])) include(grid->tiles[i].origin, grid->tiles[i].edge, box);
}

/* Sets the box of all that the file has: its domain, where it states one that holds all voxels that count. */
static void set_box(tiling *t, const np_grid_domain *domain) {
  bool has_domain = domain->is_known;
  for (int a = 0; a < 2; a++)
    has_domain = has_domain && domain->min[a] <= t->box.min[a] && domain->max[a] >= t->box.max[a];
  for (int a = 0; a < 2; a++) {
    t->start[a] = has_domain ? domain->min[a] : t->box.min[a];
    t->width[a] = (has_domain ? domain->max[a] : t->box.max[a]) - t->start[a] + 1;
  }
}

/* ---- Copies ---- */

static neph_result allocate_leaves(tiling *t) {
  size_t count = 1;
  for (int a = 0; a < 3; a++) {
    const bool is_repeating = a < 2 && t->period[a];
    t->shift[a] = is_repeating ? -t->start[a] : 0;
    t->first_leaf[a] = is_repeating ? 0 : t->box.min[a] >> 3;
    t->leaf_end[a] = is_repeating ? t->stored[a] >> 3 : (t->box.max[a] >> 3) + 1;
    count *= (size_t)(t->leaf_end[a] - t->first_leaf[a]);
  }
  t->leaves = np_alloc(t->source->context, count, sizeof *t->leaves);
  return t->leaves ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static np_leaf *get_leaf(tiling *t, const int32_t at[3]) {
  int32_t origin[3];
  size_t n = 0;
  for (int a = 0; a < 3; a++) {
    origin[a] = at[a] & ~(NP_LEAF_EDGE - 1);
    n = n * (size_t)(t->leaf_end[a] - t->first_leaf[a]) + (size_t)((at[a] >> 3) - t->first_leaf[a]);
  }
  if (t->leaves[n]) return &t->grid->leaves[t->leaves[n] - 1];
  np_leaf *leaf = np_sparse_grid_add_leaf(t->grid, origin);
  if (leaf) t->leaves[n] = (uint32_t)t->grid->leaf_count;
  return leaf;
}

static neph_result put(tiling *t, const int32_t at[3], float value) {
  np_leaf *leaf = get_leaf(t, at);
  if (!leaf) return NEPH_ERROR_OUT_OF_MEMORY;
  const int n = (at[0] & 7) << 6 | (at[1] & 7) << 3 | (at[2] & 7);
  leaf->values[n] = value;
  leaf->active[n >> 6] |= UINT64_C(1) << (n & 63);
  return NEPH_OK;
}

/* Puts a sample into every copy of the period. */
static neph_result put_copies(tiling *t, const int32_t source[3], float value) {
  neph_result result = NEPH_OK;
  int32_t at[3];
  for (int a = 0; a < 3; a++) at[a] = source[a] + t->shift[a];
  for (int32_t x = 0; x < count_copies(t, 0); x++)
    for (int32_t y = 0; y < count_copies(t, 1) && !result; y++)
      result = put(t, (const int32_t[3]){at[0] + x * t->period[0], at[1] + y * t->period[1], at[2]}, value);
  return result;
}

static neph_result copy_leaf(tiling *t, const np_leaf *leaf) {
  neph_result result = NEPH_OK;
  for (int n = 0; n < NP_LEAF_SIZE && !result; n++)
    if (has_voxel(leaf, n))
      result = put_copies(
          t, (const int32_t[3]){leaf->origin[0] + (n >> 6), leaf->origin[1] + (n >> 3 & 7), leaf->origin[2] + (n & 7)},
          leaf->values[n]);
  return result;
}

static neph_result copy_tile(tiling *t, const np_tile *tile) {
  neph_result result = NEPH_OK;
  for (int32_t i = 0; i < tile->edge && has_tile(tile); i++)
    for (int32_t j = 0; j < tile->edge; j++)
      for (int32_t k = 0; k < tile->edge && !result; k++)
        result = put_copies(t, (const int32_t[3]){tile->origin[0] + i, tile->origin[1] + j, tile->origin[2] + k},
                            tile->value);
  return result;
}

static neph_result copy_all(tiling *t, np_monitor *monitor) {
  neph_result result = NEPH_OK;
  for (size_t i = 0; i < t->source->leaf_count && !result; i++)
    result = np_monitor_is_cancelled(monitor) ? NEPH_ERROR_CANCELLED : copy_leaf(t, &t->source->leaves[i]);
  for (size_t i = 0; i < t->source->tile_count && !result; i++)
    result = np_monitor_is_cancelled(monitor) ? NEPH_ERROR_CANCELLED : copy_tile(t, &t->source->tiles[i]);
  np_sparse_grid_sort(t->grid);
  return result;
}

/* ---- Volumes ---- */

/* Moves the transform with the indices, so that every sample stays where it was. */
static void set_transform(const tiling *t) {
  np_affine *map = &t->grid->index_to_world;
  *map = t->source->index_to_world;
  for (int b = 0; b < 3; b++)
    for (int a = 0; a < 3; a++) map->m[b][3] -= map->m[b][a] * t->shift[a];
}

static neph_result tile_grid(tiling *t, np_monitor *monitor) {
  neph_result result = np_sparse_grid_init(t->source->context, t->source->name, t->grid);
  if (!result) result = allocate_leaves(t);
  if (!result) result = copy_all(t, monitor);
  if (!result) set_transform(t);
  t->grid->file = t->source->file;
  t->grid->extinction_per_value = t->source->extinction_per_value;
  t->grid->brick_bytes_max = t->source->brick_bytes_max;
  np_alloc_free(t->source->context, t->leaves);
  return result;
}

/* Box of one period's active samples in the result. */
static np_grid_extent get_extent(const tiling *t, bool is_halved) {
  np_grid_extent out = t->box;
  for (int a = 0; a < 3; a++) {
    out.min[a] = (out.min[a] + t->shift[a]) >> is_halved;
    out.max[a] = (out.max[a] + t->shift[a]) >> is_halved;
  }
  return out;
}

static neph_result create(tiling *t, const neph_volume_load_desc *desc, np_monitor *monitor, neph_volume **out_volume) {
  const np_grid_extent extent = get_extent(t, desc->is_halved);
  int32_t period[2];
  for (int a = 0; a < 2; a++) period[a] = desc->is_halved ? t->stored[a] / 2 : t->stored[a];
  neph_result result = desc->is_halved ? np_sparse_grid_halve_in_place(t->grid) : NEPH_OK;
  if (!result)
    result =
        np_volume_create_periodic(t->grid->context, t->grid, desc->precision, period, &extent, monitor, out_volume);
  for (int a = 0; a < 2 && !result; a++)
    (*out_volume)->bricks.field_period[a] = t->period[a] * (desc->is_halved ? 0.5 : 1.0);
  return result;
}

/* Ends the field at the reach: bricks that rays walk through. */
static void limit_reach(const tiling *t, const neph_volume_load_desc *desc, np_bricks *bricks) {
  for (int a = 0; a < 2; a++) {
    if (!bricks->is_periodic[a] || !(desc->repeat_reach_m[a] > 0.0)) continue;
    const double edge_m = (desc->is_halved ? 2.0 : 1.0) * NP_BRICK_EDGE * get_scaled_edge(t->source, desc, a);
    const double count = fmax(ceil(desc->repeat_reach_m[a] / edge_m), bricks->size[a]);
    if (count < bricks->reach_high[a]) bricks->reach_high[a] = (int32_t)count;
    bricks->reach_low[a] = -bricks->reach_high[a];
  }
}

neph_result np_volume_create_repeating(const np_sparse_grid *grid, const neph_volume_load_desc *desc,
                                       const np_grid_domain *domain, np_monitor *monitor, neph_volume **out_volume) {
  np_sparse_grid made = {0};
  tiling t = {.source = grid, .grid = &made};
  (void)np_sparse_grid_measure(grid, &t.box);
  include_values(grid, &t.box);
  set_box(&t, domain);
  neph_result result = check_turn(grid);
  for (int a = 0; a < 2 && !result; a++) result = compute_period(&t, desc, a);
  if (result) return result;
  set_stored(&t, desc->is_halved);
  describe_stored(&t);
  result = tile_grid(&t, monitor);
  if (!result) result = create(&t, desc, monitor, out_volume);
  if (!result) {
    limit_reach(&t, desc, &(*out_volume)->bricks);
    (*out_volume)->active_voxel_count = np_sparse_grid_count_active(grid);
  }
  np_sparse_grid_clear(&made);
  return result;
}

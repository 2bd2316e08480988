/* SPDX-License-Identifier: Apache-2.0 */
/* Resamples a frustum grid to grids of the levels of its lattice.
 *
 * A sample is the trilinear field of the frustum at its position if two voxels of the lattice fit into one of the
 * frustum. If only one fits, it is the mean of eight positions a quarter of a voxel around, so that no voxel falls
 * between samples. The first plane beyond a level is interpolated between the samples of the next, which makes the
 * cloud continuous there. If the mass, the integral of the field, errs by more than half a percent, all values are
 * scaled to the mass of the frustum. It is known exactly: the volume of a voxel is a quadratic in depth, so that the
 * integral over the hat function of plane k is v·(J(k) + J″/12). */
#include "volume/frustum.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "volume/grid_reader.h"
#include "volume/volume_levels.h"
#include "volume/volume_tint.h"

_Static_assert((int)NP_FRUSTUM_LEVELS_MAX == (int)NP_TINT_PARTS_MAX, "a level is a part");

enum { CANDIDATES_MAX = 1 << 22 };

/* Memory of a leaf and of its brick. */
static const double bytes_per_leaf = sizeof(np_leaf) + 2.0 * NP_BRICK_STRIDE;

/* Memory in bytes up to which one lattice replaces several levels, if the levels have at least half as many voxels. */
static const double bytes_free = 48e6;

/* A cell of a level that may not be empty. */
typedef struct candidate {
  int32_t at[3];
  unsigned level;
} candidate;

typedef struct resampling {
  neph_context *context;
  np_monitor *monitor;
  const np_sparse_grid *grid; /* leaves only, no tiles */
  np_frustum_block *blocks;
  size_t block_count;
  np_frustum_block box;
  np_frustum_lattice lattice;
  double refinement;
  bool is_density;       /* a density: its mass is preserved */
  candidate *candidates; /* sorted by level, then by position */
  size_t candidate_count;
  np_leaf *leaves; /* one for each candidate */
} resampling;

/* ---- Blocks ---- */

/* Replaces a tile by leaves, up to the limit on the memory of leaves. */
static neph_result expand_tile(np_sparse_grid *grid, const np_tile *tile) {
  int32_t at[3];
  if (tile->value == grid->background) return NEPH_OK;
  for (at[0] = 0; at[0] < tile->edge; at[0] += NP_LEAF_EDGE)
    for (at[1] = 0; at[1] < tile->edge; at[1] += NP_LEAF_EDGE)
      for (at[2] = 0; at[2] < tile->edge; at[2] += NP_LEAF_EDGE) {
        const int32_t origin[3] = {tile->origin[0] + at[0], tile->origin[1] + at[1], tile->origin[2] + at[2]};
        np_leaf *leaf = np_sparse_grid_add_leaf(grid, origin);
        if (!leaf) return NEPH_ERROR_OUT_OF_MEMORY;
        for (int n = 0; n < NP_LEAF_SIZE; n++) leaf->values[n] = tile->value;
        if (tile->is_active) memset(leaf->active, 0xff, sizeof leaf->active);
      }
  return NEPH_OK;
}

static double count_tile_leaves(const np_sparse_grid *grid) {
  double count = 0.0;
  for (size_t i = 0; i < grid->tile_count; i++)
    if (grid->tiles[i].value != grid->background) count += pow(grid->tiles[i].edge / NP_LEAF_EDGE, 3.0);
  return count;
}

static double get_bytes_max(const np_sparse_grid *grid) {
  return grid->brick_bytes_max ? (double)grid->brick_bytes_max : HUGE_VAL;
}

static neph_result fail_size(const np_sparse_grid *grid, double bytes) {
  return np_fail(
      grid->context, NEPH_ERROR_LIMIT,
      "%s%sgrid '%s': regular voxels no larger than its frustum's would take %.3g MB, more than the %.3g MB allowed "
      "for a file of its size: clip the part nearest to its camera, or resample it to a regular grid first",
      NP_SPARSE_GRID_LABEL(grid), 1e-6 * bytes, 1e-6 * get_bytes_max(grid));
}

static neph_result expand_tiles(np_sparse_grid *grid) {
  const double bytes = count_tile_leaves(grid) * sizeof(np_leaf);
  neph_result result = bytes <= get_bytes_max(grid) ? NEPH_OK : fail_size(grid, bytes);
  for (size_t i = 0; i < grid->tile_count && !result; i++) result = expand_tile(grid, &grid->tiles[i]);
  if (result) return result;
  grid->tile_count = 0;
  np_sparse_grid_sort(grid);
  return NEPH_OK;
}

/* Box of the voxels of a leaf that differ from the background, and one more voxel on each side; false if there are
 * none. */
static bool bound_leaf(const np_leaf *leaf, float background, np_frustum_block *out) {
  int32_t low[3] = {8, 8, 8}, high[3] = {-1, -1, -1};
  for (int n = 0; n < NP_LEAF_SIZE; n++) {
    const int32_t at[3] = {n >> 6, n >> 3 & 7, n & 7};
    if (leaf->values[n] == background) continue;
    for (int a = 0; a < 3; a++) {
      low[a] = at[a] < low[a] ? at[a] : low[a];
      high[a] = at[a] > high[a] ? at[a] : high[a];
    }
  }
  for (int a = 0; a < 3; a++) {
    out->low[a] = (double)leaf->origin[a] + low[a] - 1.0;
    out->high[a] = (double)leaf->origin[a] + high[a] + 1.0;
  }
  return high[0] >= 0;
}

static neph_result list_blocks(resampling *r) {
  const np_sparse_grid *grid = r->grid;
  r->blocks = np_alloc(r->context, grid->leaf_count, sizeof *r->blocks);
  if (!r->blocks && grid->leaf_count) return NEPH_ERROR_OUT_OF_MEMORY;
  for (int a = 0; a < 3; a++) r->box.low[a] = DBL_MAX, r->box.high[a] = -DBL_MAX;
  for (size_t i = 0; i < grid->leaf_count; i++) {
    np_frustum_block *block = &r->blocks[r->block_count];
    if (!bound_leaf(&grid->leaves[i], grid->background, block)) continue;
    r->block_count++;
    for (int a = 0; a < 3; a++) {
      r->box.low[a] = fmin(r->box.low[a], block->low[a]);
      r->box.high[a] = fmax(r->box.high[a], block->high[a]);
    }
  }
  return NEPH_OK;
}

/* ---- Cells ---- */

/* Upper bound of the number of cells: a cell that several blocks reach counts several times. */
static double count_cells(const resampling *r) {
  double count = 0.0;
  int32_t first[3], last[3];
  for (size_t i = 0; i < r->block_count; i++)
    for (unsigned k = 0; k < r->lattice.level_count; k++)
      if (np_frustum_lattice_get_cells(&r->lattice, k, &r->blocks[i], first, last))
        count += ((double)last[0] - first[0] + 1.0) * ((double)last[1] - first[1] + 1.0) *
                 ((double)last[2] - first[2] + 1.0);
  return count;
}

static void add_cells(resampling *r, unsigned level, const np_frustum_block *block) {
  int32_t first[3], last[3], at[3];
  if (!np_frustum_lattice_get_cells(&r->lattice, level, block, first, last)) return;
  for (at[0] = first[0]; at[0] <= last[0]; at[0]++)
    for (at[1] = first[1]; at[1] <= last[1]; at[1]++)
      for (at[2] = first[2]; at[2] <= last[2]; at[2]++)
        r->candidates[r->candidate_count++] = (candidate){{at[0], at[1], at[2]}, level};
}

static int compare_candidates(const void *a, const void *b) {
  const candidate *one = a, *other = b;
  if (one->level != other->level) return one->level < other->level ? -1 : 1;
  return np_grid_compare(one->at, other->at);
}

static neph_result list_cells(resampling *r, double count) {
  r->candidates = np_alloc(r->context, (size_t)count, sizeof *r->candidates);
  if (!r->candidates) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < r->block_count; i++)
    for (unsigned k = 0; k < r->lattice.level_count; k++) add_cells(r, k, &r->blocks[i]);
  qsort(r->candidates, r->candidate_count, sizeof *r->candidates, compare_candidates);
  size_t kept = 0;
  for (size_t i = 0; i < r->candidate_count; i++)
    if (kept == 0 || compare_candidates(&r->candidates[kept - 1], &r->candidates[i]))
      r->candidates[kept++] = r->candidates[i];
  r->candidate_count = kept;
  return NEPH_OK;
}

/* ---- Choice of the lattice ---- */

/* Sets a lattice and its largest number of cells; false if the frustum is degenerate. */
static bool try_lattice(resampling *r, double refinement, unsigned level_max, double *out_count) {
  r->refinement = refinement;
  if (!np_frustum_lattice_make(&r->grid->frustum, &r->box, refinement, level_max, &r->lattice)) return false;
  *out_count = count_cells(r);
  return true;
}

/* Chooses the finest affordable lattice with the fewest levels, or else the one with the fewest cells. `coarseness` is
 * 2 for voxels twice as long. */
static bool choose_lattice(resampling *r, double coarseness, unsigned level_max, double *out_count) {
  double least = HUGE_VAL, count;
  unsigned best = 1;
  for (int refinement = 2; refinement > 0; refinement--)
    for (unsigned levels = 1; levels <= level_max; levels++) {
      if (!try_lattice(r, refinement / coarseness, levels, &count)) return false;
      if (count * bytes_per_leaf <= bytes_free) return *out_count = count, true;
      if (refinement == 1 && count < least) least = count, best = levels;
      if (r->lattice.level_count < levels) break;
    }
  return try_lattice(r, 1.0 / coarseness, best, out_count);
}

static neph_result fail_map(const np_sparse_grid *grid) {
  return np_fail(grid->context, NEPH_ERROR_BAD_FILE,
                 "%s%sgrid '%s': the voxels of its frustum narrow to a point or widen by more than a factor of 1e6 "
                 "within its contents: clip the part nearest to its camera, or resample it to a regular grid first",
                 NP_SPARSE_GRID_LABEL(grid));
}

static neph_result prepare(resampling *r, double coarseness, unsigned level_max, double *out_count) {
  neph_result result = list_blocks(r);
  if (result) return result;
  if (!r->block_count) return *out_count = 0.0, NEPH_OK;
  return choose_lattice(r, coarseness, level_max, out_count) ? NEPH_OK : fail_map(r->grid);
}

/* Lists the cells of a lattice and computes their memory, unless there are too many to list. */
static neph_result list_if_few(resampling *r, double count, double *out_bytes) {
  *out_bytes = count * bytes_per_leaf;
  if (!(count > 0.0) || count > CANDIDATES_MAX) return NEPH_OK;
  const neph_result result = list_cells(r, count);
  *out_bytes = (double)r->candidate_count * bytes_per_leaf;
  return result;
}

static bool has_room(const resampling *r, double bytes) {
  return bytes <= get_bytes_max(r->grid) && bytes <= CANDIDATES_MAX * bytes_per_leaf;
}

/* ---- Samples ---- */

static double interpolate(np_grid_reader *reader, const double at[3]) {
  int32_t low[3];
  double fraction[3], sum = 0.0;
  for (int a = 0; a < 3; a++) {
    const double whole = floor(at[a]);
    if (!(fabs(whole) < 1e9)) return (double)reader->grid->background;
    low[a] = (int32_t)whole;
    fraction[a] = at[a] - whole;
  }
  for (int n = 0; n < 8; n++) {
    const int32_t voxel[3] = {low[0] + (n & 1), low[1] + (n >> 1 & 1), low[2] + (n >> 2)};
    double share = 1.0;
    float value;
    for (int a = 0; a < 3; a++) share *= n >> a & 1 ? fraction[a] : 1.0 - fraction[a];
    if (!(share > 0.0)) continue;
    (void)np_grid_read(reader, voxel, &value);
    sum += share * (double)value;
  }
  return sum;
}

static double sample_at(const resampling *r, np_grid_reader *reader, unsigned level, const double at[3]) {
  double index[3];
  if (!np_frustum_lattice_locate(&r->lattice, level, at, index)) return (double)r->grid->background;
  return interpolate(reader, index);
}

static double sample_around(const resampling *r, np_grid_reader *reader, unsigned level, const double at[3]) {
  double sum = 0.0;
  if (r->refinement >= 2.0) return sample_at(r, reader, level, at);
  for (int n = 0; n < 8; n++) {
    const double near[3] = {at[0] + (n & 1 ? 0.25 : -0.25), at[1] + (n & 2 ? 0.25 : -0.25),
                            at[2] + (n & 4 ? 0.25 : -0.25)};
    sum += sample_at(r, reader, level, near);
  }
  return 0.125 * sum;
}

/* Sample on the plane that a level shares with the next, interpolated between samples of the next. */
static double sample_border(const resampling *r, np_grid_reader *reader, unsigned level, const int32_t at[3]) {
  double sum = 0.0;
  for (int n = 0; n < 4; n++) {
    const int32_t corner[2] = {at[0] + (n & at[0] & 1), at[1] + (n >> 1 & at[1] & 1)};
    const double coarse[3] = {floor(0.5 * corner[0]), floor(0.5 * corner[1]), 0.5 * at[2]};
    sum += sample_around(r, reader, level + 1, coarse);
  }
  return 0.25 * sum;
}

static bool is_border(const resampling *r, const candidate *cell) {
  return cell->at[2] == r->lattice.slabs[cell->level].end;
}

static void fill_leaf(const resampling *r, np_grid_reader *reader, const candidate *cell, np_leaf *leaf) {
  const bool is_beyond = is_border(r, cell);
  for (int a = 0; a < 3; a++) leaf->origin[a] = cell->at[a] * NP_LEAF_EDGE;
  for (int n = 0; n < NP_LEAF_SIZE; n++) {
    const int32_t at[3] = {leaf->origin[0] + (n >> 6), leaf->origin[1] + (n >> 3 & 7), leaf->origin[2] + (n & 7)};
    const double place[3] = {at[0], at[1], at[2]};
    leaf->values[n] = r->grid->background;
    if (is_beyond && (n & 7)) continue;
    leaf->values[n] =
        (float)(is_beyond ? sample_border(r, reader, cell->level, at) : sample_around(r, reader, cell->level, place));
    if (!is_beyond && leaf->values[n] != r->grid->background) leaf->active[n >> 6] |= UINT64_C(1) << (n & 63);
  }
}

static neph_result fill_leaves(void *user, size_t begin, size_t end, unsigned thread) {
  const resampling *r = user;
  np_grid_reader reader = {.grid = r->grid};
  (void)thread;
  for (size_t i = begin; i < end; i++) fill_leaf(r, &reader, &r->candidates[i], &r->leaves[i]);
  return NEPH_OK;
}

/* ---- Mass ---- */

/* Integral of the field over the frustum, in its local lengths. */
static double sum_frustum(const np_sparse_grid *grid) {
  const np_frustum *map = &grid->frustum;
  const double slope = map->scale * map->growth * map->step; /* slope of a voxel's width, per plane */
  double sum = 0.0;
  for (size_t i = 0; i < grid->leaf_count; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const double k = grid->leaves[i].origin[2] + (n & 7) - map->origin[2];
      const double width = map->scale + slope * k, area = width * width + slope * slope / 6.0;
      sum += ((double)grid->leaves[i].values[n] - (double)grid->background) * area * fabs(map->step);
    }
  return sum;
}

/* Mass of the levels; planes between two levels count half in each. */
static double sum_levels(const resampling *r) {
  double sum = 0.0;
  for (size_t i = 0; i < r->candidate_count; i++) {
    const candidate *cell = &r->candidates[i];
    const double volume = ldexp(r->lattice.edge * r->lattice.edge * r->lattice.depth, 3 * (int)cell->level);
    const bool has_shared = cell->at[2] == r->lattice.slabs[cell->level].first || is_border(r, cell);
    double of_leaf = 0.0;
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const double value = (double)r->leaves[i].values[n] - (double)r->grid->background;
      of_leaf += has_shared && !(n & 7) ? 0.5 * value : value;
    }
    sum += volume * of_leaf;
  }
  return sum;
}

/* Scales a density to the mass of the frustum, unless it errs by less than half a percent: a field of ones stays one.
 * Returns the mass before, relative to the frustum. */
static double scale_to_mass(const resampling *r) {
  static const double error_max = 0.005, change_max = 0.5;
  const double wanted = sum_frustum(r->grid), share = wanted > 0.0 ? sum_levels(r) / wanted : 1.0;
  if (!(fabs(share - 1.0) > error_max && fabs(share - 1.0) < change_max)) return share;
  for (size_t i = 0; i < r->candidate_count; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) r->leaves[i].values[n] /= (float)share;
  return share;
}

/* ---- Grids of the levels ---- */

static bool has_values(const np_leaf *leaf, float background) {
  for (int n = 0; n < NP_LEAF_SIZE; n++)
    if (leaf->values[n] != background) return true;
  return false;
}

static neph_result make_grid(const resampling *r, unsigned level, np_sparse_grid *out) {
  neph_result result = np_sparse_grid_init(r->context, r->grid->name, out);
  out->file = r->grid->file;
  out->brick_bytes_max = r->grid->brick_bytes_max;
  out->background = r->grid->background;
  out->extinction_per_value = r->grid->extinction_per_value;
  out->level_set_voxels = r->grid->level_set_voxels;
  if (r->block_count) out->index_to_world = np_frustum_lattice_get_affine(&r->lattice, level);
  for (size_t i = 0; i < r->candidate_count && !result; i++) {
    if (r->candidates[i].level != level || !has_values(&r->leaves[i], out->background)) continue;
    np_leaf *leaf = np_sparse_grid_add_leaf(out, r->leaves[i].origin);
    if (leaf)
      *leaf = r->leaves[i];
    else
      result = NEPH_ERROR_OUT_OF_MEMORY;
  }
  if (!result) np_sparse_grid_sort(out);
  return result;
}

static neph_result fill(resampling *r) {
  np_monitor_set_stage(r->monitor, "resampling");
  r->leaves = np_alloc(r->context, r->candidate_count, sizeof *r->leaves);
  if (!r->leaves && r->candidate_count) return NEPH_ERROR_OUT_OF_MEMORY;
  return np_parallel_for(r->context, r->monitor, r->candidate_count, 4, fill_leaves, r);
}

static void describe(const resampling *r, double mass_share) {
  const np_frustum_lattice *l = &r->lattice;
  const np_affine finest = np_frustum_lattice_get_affine(l, 0);
  const double edge = np_dvec3_length(np_dvec3_make(finest.m[0][0], finest.m[1][0], finest.m[2][0]));
  np_log(
      r->context, NEPH_LOG_INFO,
      "%s%sgrid '%s': a frustum, resampled to %u level%s of regular voxels, %.3g to %.3g across, with at most %.3g MB; "
      "their mass is %.4f of the frustum's, corrected if it errs by more than 0.5 %%",
      NP_SPARSE_GRID_LABEL(r->grid), l->level_count, l->level_count > 1 ? "s" : "", edge,
      ldexp(edge, (int)l->level_count - 1), 1e-6 * (double)r->candidate_count * bytes_per_leaf, mass_share);
}

static void clear(resampling *r) {
  np_alloc_free(r->context, r->blocks);
  np_alloc_free(r->context, r->candidates);
  np_alloc_free(r->context, r->leaves);
}

/* Resamples to the grids of the levels. The caller clears them, whatever the outcome. */
static neph_result resample(resampling *r, np_sparse_grid *grid, double coarseness, unsigned level_max,
                            np_sparse_grid *out_levels) {
  double count = 0.0, bytes = 0.0;
  neph_result result = expand_tiles(grid);
  if (!result) result = prepare(r, coarseness, level_max, &count);
  if (!result) result = list_if_few(r, count, &bytes);
  if (!result && !has_room(r, bytes)) result = fail_size(grid, bytes);
  if (!result) result = fill(r);
  if (!result && r->block_count) describe(r, r->is_density ? scale_to_mass(r) : 1.0);
  const unsigned level_count = r->block_count ? r->lattice.level_count : 1;
  for (unsigned k = 0; k < level_count && !result; k++) result = make_grid(r, k, &out_levels[k]);
  r->lattice.level_count = level_count;
  return result;
}

neph_result np_frustum_flatten(np_sparse_grid *grid, bool is_density, np_monitor *monitor) {
  resampling r = {.context = grid->context, .monitor = monitor, .grid = grid, .is_density = is_density};
  np_sparse_grid flat = {0};
  const neph_result result = resample(&r, grid, 1.0, 1, &flat);
  np_sparse_grid_clear(result ? &flat : grid);
  if (!result) *grid = flat;
  clear(&r);
  return result;
}

neph_result np_frustum_measure(np_sparse_grid *grid, np_frustum_facts *out_facts) {
  resampling r = {.context = grid->context, .grid = grid};
  double count = 0.0, bytes = count_tile_leaves(grid) * sizeof(np_leaf);
  *out_facts = (np_frustum_facts){.is_sound = true, .bytes = bytes, .bytes_max = get_bytes_max(grid)};
  if (!has_room(&r, bytes)) return NEPH_OK;
  neph_result result = expand_tiles(grid);
  if (!result) result = list_blocks(&r);
  out_facts->is_sound = r.block_count == 0 || choose_lattice(&r, 1.0, NP_FRUSTUM_LEVELS_MAX, &count);
  if (!result && out_facts->is_sound) result = list_if_few(&r, count, &out_facts->bytes);
  out_facts->fits = out_facts->is_sound && has_room(&r, out_facts->bytes);
  out_facts->level_count = r.lattice.level_count;
  np_frustum_get_voxel(&grid->frustum, r.box.low[2] + 1.0, out_facts->edges[0]);
  np_frustum_get_voxel(&grid->frustum, r.box.high[2] - 1.0, out_facts->edges[1]);
  clear(&r);
  return result;
}

/* ---- Volumes ---- */

static bool has_cell(const void *user, const int32_t cell[3]) {
  const np_frustum_slab *slab = user;
  return cell[2] >= slab->first && cell[2] < slab->end;
}

static neph_result make_level(const resampling *r, unsigned level, np_sparse_grid *grid, neph_precision precision,
                              neph_volume **out_volume) {
  if (r->lattice.level_count > 1) grid->region = (np_cell_region){has_cell, &r->lattice.slabs[level]};
  grid->is_consumed = true;
  const neph_result result = np_volume_create_from_grid(r->context, grid, precision, r->monitor, out_volume);
  np_sparse_grid_clear(grid);
  return result;
}

static neph_result make_volume(const resampling *r, np_sparse_grid *levels, neph_precision precision,
                               neph_volume **out_volume) {
  neph_volume *whole = NULL;
  neph_result result = make_level(r, 0, &levels[0], precision, &whole);
  if (!result && r->lattice.level_count > 1)
    result = np_tint_create_levels(r->context, NP_PARTS_OF_CELLS, &whole->tint);
  for (unsigned k = 1; k < r->lattice.level_count && !result; k++) {
    neph_volume *level;
    result = make_level(r, k, &levels[k], precision, &level);
    if (!result) np_volume_add_level(whole, level);
  }
  if (result)
    neph_volume_release(whole);
  else
    *out_volume = whole;
  return result;
}

neph_result np_volume_create_from_frustum(neph_context *context, np_sparse_grid *grid, bool is_halved,
                                          neph_precision precision, np_monitor *monitor, neph_volume **out_volume) {
  resampling r = {.context = context, .monitor = monitor, .grid = grid, .is_density = true};
  np_sparse_grid levels[NP_FRUSTUM_LEVELS_MAX] = {{0}};
  neph_result result = resample(&r, grid, is_halved ? 2.0 : 1.0, NP_FRUSTUM_LEVELS_MAX, levels);
  np_alloc_free(context, r.leaves);
  r.leaves = NULL;
  if (!result) result = make_volume(&r, levels, precision, out_volume);
  for (int k = 0; k < NP_FRUSTUM_LEVELS_MAX; k++) np_sparse_grid_clear(&levels[k]);
  clear(&r);
  return result;
}

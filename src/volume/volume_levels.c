/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/volume_levels.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "volume/volume_tint.h"

/* ---- Cells ---- */

/* A cell, in units of its edge, and the level that owns it. */
typedef struct level_cell {
  int32_t at[3];
  unsigned level;
} level_cell;

typedef struct level_build {
  neph_context *context;
  np_monitor *monitor;
  np_sparse_grid *grids;
  unsigned count;
  level_cell *cells; /* sorted */
  size_t cell_count;
} level_build;

static int compare_places(const int32_t a[3], const int32_t b[3]) {
  for (int i = 0; i < 3; i++)
    if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
  return 0;
}

static int compare_cells(const void *a, const void *b) {
  const level_cell *one = a, *other = b;
  const int order = compare_places(one->at, other->at);
  return order ? order : (one->level > other->level) - (one->level < other->level);
}

/* Searches the first `count` cells, which are sorted. */
static const level_cell *search_cell(const level_build *b, size_t count, const int32_t at[3]) {
  assert(count <= b->cell_count);
  size_t low = 0, high = count;
  while (low < high) {
    const size_t middle = (low + high) / 2;
    if (compare_places(b->cells[middle].at, at) < 0)
      low = middle + 1;
    else
      high = middle;
  }
  return low < count && !compare_places(b->cells[low].at, at) ? &b->cells[low] : NULL;
}

/* A cell has 1 << get_shift leaves of a level along an edge. */
static int get_shift(const level_build *b, unsigned level) {
  assert(level < b->count);
  return (int)(b->count - 1 - level);
}

/* The cell that contains a leaf, given by its number along each axis. */
static level_cell locate_leaf(const level_build *b, unsigned level, const int32_t leaf[3]) {
  level_cell cell = {.level = level};
  for (int a = 0; a < 3; a++) cell.at[a] = leaf[a] >> get_shift(b, level);
  return cell;
}

static bool has_voxels(const np_leaf *leaf) {
  uint64_t any = 0;
  for (int i = 0; i < NP_LEAF_EDGE; i++) any |= leaf->active[i];
  return any != 0;
}

/* Sorts the cells and removes duplicates; the finest level comes first. */
static void sort_cells(level_build *b) {
  size_t kept = 0;
  if (b->cell_count > 1) qsort(b->cells, b->cell_count, sizeof *b->cells, compare_cells);
  for (size_t i = 0; i < b->cell_count; i++)
    if (kept == 0 || compare_places(b->cells[kept - 1].at, b->cells[i].at)) b->cells[kept++] = b->cells[i];
  b->cell_count = kept;
}

/* Lists the cells with voxels of a level: one for each leaf. */
static void list_cells(level_build *b, unsigned level) {
  const np_sparse_grid *grid = &b->grids[level];
  for (size_t i = 0; i < grid->leaf_count; i++) {
    const int32_t *origin = grid->leaves[i].origin;
    if (!has_voxels(&grid->leaves[i])) continue;
    const int32_t leaf[3] = {origin[0] >> 3, origin[1] >> 3, origin[2] >> 3};
    const level_cell cell = locate_leaf(b, level, leaf);
    const level_cell *last = b->cell_count ? &b->cells[b->cell_count - 1] : NULL;
    if (!last || compare_cells(last, &cell)) b->cells[b->cell_count++] = cell;
  }
}

static neph_result check_disjoint(const level_build *b) {
  for (size_t i = 1; i < b->cell_count; i++) {
    const level_cell *one = &b->cells[i - 1], *other = &b->cells[i];
    const int32_t edge = NP_LEAF_EDGE << get_shift(b, other->level);
    if (compare_places(one->at, other->at) || one->level == other->level) continue;
    return np_fail(b->context, NEPH_ERROR_BAD_FILE,
                   "%s%sgrid '%s': levels of detail %u and %u both have voxels in the cell from voxel (%d, %d, %d) of "
                   "the latter on: each cell must be in one of them",
                   NP_SPARSE_GRID_LABEL(&b->grids[other->level]), one->level, other->level, other->at[0] * edge,
                   other->at[1] * edge, other->at[2] * edge);
  }
  return NEPH_OK;
}

/* Adds the empty cells before cells with voxels. */
static void add_empty_cells(level_build *b) {
  const size_t count = b->cell_count;
  for (size_t i = 0; i < count; i++)
    for (int n = 1; n < 8; n++) {
      const int32_t *at = b->cells[i].at;
      const level_cell before = {{at[0] - (n >> 2), at[1] - (n >> 1 & 1), at[2] - (n & 1)}, b->cells[i].level};
      if (!search_cell(b, count, before.at)) b->cells[b->cell_count++] = before;
    }
  sort_cells(b);
}

static neph_result make_cells(level_build *b) {
  size_t leaf_count = 0;
  for (unsigned k = 0; k < b->count; k++) leaf_count += b->grids[k].leaf_count;
  b->cells = np_alloc(b->context, 8 * leaf_count, sizeof *b->cells);
  if (leaf_count && !b->cells) return NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned k = 0; k < b->count; k++) list_cells(b, k);
  if (b->cell_count > 1) qsort(b->cells, b->cell_count, sizeof *b->cells, compare_cells);
  neph_result result = check_disjoint(b);
  if (result) return result;
  sort_cells(b);
  add_empty_cells(b);
  return NEPH_OK;
}

/* ---- Samples beyond a level's cells ---- */

static int compare_leaf_to_origin(const void *origin, const void *leaf) {
  return compare_places(origin, ((const np_leaf *)leaf)->origin);
}

/* A sample of a grid; `last` caches the leaf of the last query. */
static double get_sample(const np_sparse_grid *grid, const int32_t at[3], const np_leaf **last) {
  const int32_t origin[3] = {at[0] & ~7, at[1] & ~7, at[2] & ~7};
  if (!*last || compare_places(origin, (*last)->origin))
    *last = bsearch(origin, grid->leaves, grid->leaf_count, sizeof *grid->leaves, compare_leaf_to_origin);
  return *last ? (double)(*last)->values[(at[0] & 7) * 64 + (at[1] & 7) * 8 + (at[2] & 7)] : 0.0;
}

/* Weight of one of the eight lattice samples around a sample of the finest level, for voxels of length `edge`, and its
 * position in the finest level. */
static double weigh_corner(const int32_t at[3], int32_t edge, int n, int32_t out_corner[3]) {
  double weight = 1.0;
  for (int a = 0; a < 3; a++) {
    const int is_next = n >> a & 1;
    const double part = (double)(at[a] & (edge - 1)) / edge;
    out_corner[a] = (at[a] & -edge) + is_next * edge;
    weight *= is_next ? part : 1.0 - part;
  }
  return weight;
}

static double get_level_sample(const level_build *b, unsigned level, const int32_t at[3], const np_leaf **last) {
  const int32_t index[3] = {at[0] >> level, at[1] >> level, at[2] >> level};
  return get_sample(&b->grids[level], index, last);
}

/* Value of a level at a sample of the finest lattice, interpolated between its own samples. */
static double interpolate(const level_build *b, unsigned level, const int32_t at[3], const np_leaf **last) {
  const int32_t edge = INT32_C(1) << level;
  double sum = 0.0;
  for (int n = 0; n < 8; n++) {
    int32_t corner[3];
    const double weight = weigh_corner(at, edge, n, corner);
    if (weight > 0.0) sum += weight * get_level_sample(b, level, corner, last);
  }
  return sum;
}

typedef struct border_job {
  const level_build *b;
  unsigned level;
  np_leaf *leaves; /* leaves beyond the level's cells, to be filled */
  size_t count, capacity;
} border_job;

/* Fills the samples of a leaf that the cells before it share: its first planes. They are inactive. */
static void fill_border(const border_job *job, np_leaf *leaf) {
  const int32_t *origin = leaf->origin, edge = INT32_C(1) << job->level;
  const np_leaf *last = NULL;
  const int32_t number[3] = {origin[0] >> 3, origin[1] >> 3, origin[2] >> 3};
  const level_cell place = locate_leaf(job->b, job->level, number);
  const level_cell *cell = search_cell(job->b, job->b->cell_count, place.at);
  for (int n = 0; n < NP_LEAF_SIZE && cell; n++) {
    if (n / 64 != 0 && n / 8 % 8 != 0 && n % 8 != 0) continue;
    const int32_t at[3] = {(origin[0] + n / 64) * edge, (origin[1] + n / 8 % 8) * edge, (origin[2] + n % 8) * edge};
    leaf->values[n] = (float)interpolate(job->b, cell->level, at, &last);
  }
}

static neph_result fill_borders(void *user, size_t begin, size_t end, unsigned thread) {
  const border_job *job = user;
  (void)thread;
  for (size_t i = begin; i < end; i++) fill_border(job, &job->leaves[i]);
  return NEPH_OK;
}

static bool add_border(border_job *job, const int32_t leaf[3]) {
  if (job->count == job->capacity) {
    const size_t capacity = job->capacity ? 2 * job->capacity : 256;
    np_leaf *grown = np_alloc_resize(job->b->context, job->leaves, capacity, sizeof *grown);
    if (!grown) return false;
    job->leaves = grown;
    job->capacity = capacity;
  }
  np_leaf *added = &job->leaves[job->count++];
  memset(added, 0, sizeof *added);
  for (int a = 0; a < 3; a++) added->origin[a] = leaf[a] * NP_LEAF_EDGE;
  return true;
}

/* Lists the leaves right after a cell of the level that another level owns. */
static bool list_borders(border_job *job, const level_cell *cell) {
  const level_build *b = job->b;
  const int32_t edge = INT32_C(1) << get_shift(b, job->level);
  int32_t n[3];
  for (n[0] = 0; n[0] <= edge; n[0]++)
    for (n[1] = 0; n[1] <= edge; n[1]++)
      for (n[2] = n[0] == edge || n[1] == edge ? 0 : edge; n[2] <= edge; n[2]++) {
        const int32_t leaf[3] = {cell->at[0] * edge + n[0], cell->at[1] * edge + n[1], cell->at[2] * edge + n[2]};
        const level_cell place = locate_leaf(b, job->level, leaf), *owner = search_cell(b, b->cell_count, place.at);
        if (owner && owner->level != job->level && !add_border(job, leaf)) return false;
      }
  return true;
}

static int compare_leaves(const void *a, const void *b) {
  return compare_places(((const np_leaf *)a)->origin, ((const np_leaf *)b)->origin);
}

static bool has_values(const np_leaf *leaf) {
  for (int n = 0; n < NP_LEAF_SIZE; n++)
    if (leaf->values[n] > 0.0f) return true;
  return false;
}

/* Appends the border leaves, without duplicates and without empty ones. */
static neph_result append_borders(const border_job *job, np_sparse_grid *grid) {
  for (size_t i = 0; i < job->count; i++) {
    const np_leaf *border = &job->leaves[i];
    if ((i && !compare_leaves(border - 1, border)) || !has_values(border)) continue;
    np_leaf *leaf = np_sparse_grid_add_leaf(grid, border->origin);
    if (!leaf) return NEPH_ERROR_OUT_OF_MEMORY;
    *leaf = *border;
  }
  np_sparse_grid_sort(grid);
  return NEPH_OK;
}

static neph_result extend_level(const level_build *b, unsigned level) {
  border_job job = {.b = b, .level = level};
  neph_result result = NEPH_OK;
  for (size_t i = 0; i < b->cell_count && !result; i++)
    if (b->cells[i].level == level && !list_borders(&job, &b->cells[i])) result = NEPH_ERROR_OUT_OF_MEMORY;
  if (!result && job.count > 1) qsort(job.leaves, job.count, sizeof *job.leaves, compare_leaves);
  if (!result) result = np_parallel_for(b->context, b->monitor, job.count, 16, fill_borders, &job);
  if (!result) result = append_borders(&job, &b->grids[level]);
  np_alloc_free(b->context, job.leaves);
  return result;
}

/* ---- The finest level, joined to the next ---- */

typedef struct join_job {
  const level_build *b;
  np_leaf *leaves; /* leaves of the next level in the cells of the finest */
} join_job;

/* Cell and leaves of the last look-up. */
typedef struct level_lookup {
  const level_build *b;
  const level_cell *cell;
  const np_leaf *leaf[NP_TINT_PARTS_MAX];
} level_lookup;

static const level_cell *get_cell(level_lookup *l, const int32_t at[3]) {
  const int32_t leaf[3] = {at[0] >> 3, at[1] >> 3, at[2] >> 3};
  const level_cell place = locate_leaf(l->b, 0, leaf);
  if (!l->cell || compare_places(l->cell->at, place.at)) l->cell = search_cell(l->b, l->b->cell_count, place.at);
  return l->cell;
}

/* Value of the cloud at a sample of the finest lattice: the level that owns the cell, interpolated between its samples;
 * beyond the cell, a coarser level that owns it. */
static double get_value(level_lookup *l, const int32_t at[3]) {
  const level_cell *cell = get_cell(l, at);
  if (!cell) return 0.0;
  const unsigned level = cell->level;
  const int32_t edge = INT32_C(1) << level;
  double sum = 0.0;
  for (int n = 0; n < 8; n++) {
    int32_t corner[3];
    const double weight = weigh_corner(at, edge, n, corner);
    if (weight == 1.0) return get_level_sample(l->b, level, at, &l->leaf[level]);
    if (weight > 0.0) sum += weight * get_value(l, corner);
  }
  return sum;
}

/* Mean around every second sample, with weights of 1/4, 1/2 and 1/4 along each axis. */
static double average(level_lookup *l, const int32_t at[3]) {
  double sum = 0.0;
  for (int n = 0; n < 27; n++) {
    const int32_t step[3] = {n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1};
    const int32_t near[3] = {2 * at[0] + step[0], 2 * at[1] + step[1], 2 * at[2] + step[2]};
    const int away = (step[0] != 0) + (step[1] != 0) + (step[2] != 0);
    sum += ldexp(get_value(l, near), -3 - away);
  }
  return sum;
}

static neph_result fill_joined(void *user, size_t begin, size_t end, unsigned thread) {
  const join_job *job = user;
  (void)thread;
  for (size_t i = begin; i < end; i++) {
    np_leaf *leaf = &job->leaves[i];
    level_lookup l = {.b = job->b};
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const int32_t at[3] = {leaf->origin[0] + n / 64, leaf->origin[1] + n / 8 % 8, leaf->origin[2] + n % 8};
      leaf->values[n] = (float)average(&l, at);
      leaf->active[n / 64] |= (uint64_t)(leaf->values[n] > 0.0f) << n % 64;
    }
  }
  return NEPH_OK;
}

/* Adds leaves of the next level in the cells of the finest: one for each voxel along an edge of a leaf. */
static neph_result add_joined(const level_build *b) {
  const int32_t along = INT32_C(1) << get_shift(b, 1);
  for (size_t i = 0; i < b->cell_count; i++)
    for (int32_t n = 0; n < along * along * along && b->cells[i].level == 0; n++) {
      const int32_t in[3] = {n / along / along, n / along % along, n % along};
      int32_t origin[3];
      for (int a = 0; a < 3; a++) origin[a] = (b->cells[i].at[a] * along + in[a]) * NP_LEAF_EDGE;
      if (!np_sparse_grid_add_leaf(&b->grids[1], origin)) return NEPH_ERROR_OUT_OF_MEMORY;
    }
  return NEPH_OK;
}

/* Removes leaves without voxels. */
static void drop_clear_leaves(np_sparse_grid *grid, size_t first) {
  size_t kept = first;
  for (size_t i = first; i < grid->leaf_count; i++)
    if (has_voxels(&grid->leaves[i])) memmove(&grid->leaves[kept++], &grid->leaves[i], sizeof *grid->leaves);
  grid->leaf_count = kept;
}

static neph_result join_finest(level_build *b) {
  np_sparse_grid *next = &b->grids[1];
  const size_t first = next->leaf_count;
  neph_result result = add_joined(b);
  join_job job = {b, next->leaves + first};
  const size_t count = next->leaf_count - first;
  next->leaf_count = first; /* hides the new leaves from look-ups while they are filled */
  if (!result) result = np_parallel_for(b->context, b->monitor, count, 16, fill_joined, &job);
  next->leaf_count = first + count;
  drop_clear_leaves(next, first);
  np_sparse_grid_sort(next);
  for (size_t i = 0; i < b->cell_count; i++) b->cells[i].level -= b->cells[i].level > 0;
  np_sparse_grid_clear(b->grids);
  b->grids++;
  b->count--;
  return result;
}

/* ---- Volumes ---- */

void np_volume_add_level(neph_volume *whole, neph_volume *level) {
  if (level->active_voxel_count == 0) {
    neph_volume_release(level);
    return;
  }
  const np_affine to_whole = np_affine_compose(&whole->world_to_index, &level->index_to_world);
  double low[3], high[3];
  np_volume_bound_box(&to_whole, level->active_min, level->active_max, low, high);
  const bool is_first = whole->active_voxel_count == 0;
  for (int a = 0; a < 3; a++) {
    const int32_t from = (int32_t)floor(low[a]), to = (int32_t)ceil(high[a]);
    whole->active_min[a] = is_first || from < whole->active_min[a] ? from : whole->active_min[a];
    whole->active_max[a] = is_first || to > whole->active_max[a] ? to : whole->active_max[a];
  }
  whole->value_min = is_first ? level->value_min : fminf(whole->value_min, level->value_min);
  whole->value_max = fmaxf(whole->value_max, level->value_max);
  whole->active_voxel_count += level->active_voxel_count;
  whole->grid_bytes += level->grid_bytes;
  np_tint_add_level(whole->tint, level);
}

/* Region of a level while its bricks are built. */
typedef struct level_region {
  const level_build *b;
  unsigned level;
} level_region;

static bool has_cell(const void *user, const int32_t leaf[3]) {
  const level_region *region = user;
  const level_cell place = locate_leaf(region->b, region->level, leaf);
  const level_cell *cell = search_cell(region->b, region->b->cell_count, place.at);
  return cell && cell->level == region->level;
}

static neph_result make_level(const level_build *b, unsigned level, neph_precision precision,
                              neph_volume **out_volume) {
  const level_region region = {b, level};
  np_sparse_grid *grid = &b->grids[level];
  grid->region = (np_cell_region){has_cell, &region};
  grid->is_consumed = true;
  const neph_result result = np_volume_create_from_grid(b->context, grid, precision, b->monitor, out_volume);
  np_sparse_grid_clear(grid);
  return result;
}

static neph_result make_volume(const level_build *b, neph_precision precision, neph_volume **out_volume) {
  neph_volume *whole = NULL;
  neph_result result = make_level(b, 0, precision, &whole);
  if (!result) result = np_tint_create_levels(b->context, NP_PARTS_OF_CELLS, &whole->tint);
  for (unsigned k = 1; k < b->count && !result; k++) {
    neph_volume *level;
    result = make_level(b, k, precision, &level);
    if (!result) np_volume_add_level(whole, level);
  }
  if (result)
    neph_volume_release(whole);
  else
    *out_volume = whole;
  return result;
}

/* ---- Checks ---- */

/* Checks that the lattice of a level aligns with the finest, to a thousandth of its voxel for the rounding of other
 * programs. */
static neph_result check_lattice(const level_build *b, unsigned level) {
  const np_affine *finest = &b->grids[0].index_to_world, *own = &b->grids[level].index_to_world;
  const double edge = ldexp(1.0, (int)level);
  for (int a = 0; a < 3; a++) {
    const double voxel = hypot(hypot(finest->m[a][0], finest->m[a][1]), finest->m[a][2]);
    double away = fabs(own->m[a][3] - finest->m[a][3]);
    for (int i = 0; i < 3; i++) away = fmax(away, 1e3 * fabs(own->m[a][i] - edge * finest->m[a][i]));
    if (away <= 1e-3 * voxel) continue;
    return np_fail(b->context, NEPH_ERROR_BAD_FILE,
                   "%s%sgrid '%s': its transform is not that of the finest level with voxels %g times as long",
                   NP_SPARSE_GRID_LABEL(&b->grids[level]), edge);
  }
  return NEPH_OK;
}

static neph_result check_level(const level_build *b, unsigned level) {
  const np_sparse_grid *grid = &b->grids[level];
  if (grid->tile_count > 0)
    return np_fail(b->context, NEPH_ERROR_BAD_FILE,
                   "%s%sgrid '%s': a level of detail holds %zu constant tiles, must hold voxels alone, as it was baked",
                   NP_SPARSE_GRID_LABEL(grid), grid->tile_count);
  return check_lattice(b, level);
}

neph_result np_volume_create_from_levels(neph_context *context, np_sparse_grid *levels, unsigned count, bool is_halved,
                                         neph_precision precision, np_monitor *monitor, neph_volume **out_volume) {
  level_build b = {.context = context, .monitor = monitor, .grids = levels, .count = count};
  neph_result result = NEPH_OK;
  for (unsigned k = 0; k < count && !result; k++) result = check_level(&b, k);
  if (!result) result = make_cells(&b);
  if (!result && is_halved && count > 1) result = join_finest(&b);
  for (unsigned k = b.count; k-- > 0 && !result;) result = extend_level(&b, k); /* coarser levels are looked up */
  if (!result) result = make_volume(&b, precision, out_volume);
  np_alloc_free(context, b.cells);
  return result;
}

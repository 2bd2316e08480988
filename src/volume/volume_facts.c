/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/volume_facts.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "core/alloc.h"
#include "volume/volume_choice.h"

static const float half_max = 65504.0f;

/* ---- Values ---- */

/* Largest finite active sample so far. */
typedef struct largest_value {
  bool is_known;
  float value;
  uint64_t number;
} largest_value;

/* Adds an active value. The largest value is not part of the second sum: subtracting a value of 1e30 later would leave
 * nothing of the others. */
static void add_active(np_grid_facts *facts, float value, uint64_t number, double weight, largest_value *largest) {
  facts->sum += weight * (double)value;
  if (largest->is_known && value <= largest->value) {
    facts->sum_of_others += weight * (double)value;
    return;
  }
  facts->sum_of_others += (weight - 1.0) * (double)value + (largest->is_known ? (double)largest->value : 0.0);
  *largest = (largest_value){true, value, number};
}

static void add_value(np_grid_facts *facts, const np_sparse_grid *grid, float value, bool is_active, uint64_t number,
                      double weight, largest_value *largest) {
  if (!isfinite(value)) return;
  if (is_active) add_active(facts, value, number, weight, largest);
  if (fabsf(value) <= half_max || facts->beyond_half.count++) return;
  facts->beyond_half.first_value = (double)value;
  np_value_tally_locate(grid, number, &facts->beyond_half.first);
}

static void add_values(np_grid_facts *facts, const np_sparse_grid *grid) {
  largest_value largest = {.is_known = false};
  for (size_t i = 0; i < grid->leaf_count; i++)
    for (size_t n = 0; n < NP_LEAF_SIZE; n++)
      add_value(facts, grid, grid->leaves[i].values[n], grid->leaves[i].active[n / 64] >> (n % 64) & 1u,
                i * NP_LEAF_SIZE + n, 1.0, &largest);
  for (size_t i = 0; i < grid->tile_count; i++)
    add_value(facts, grid, grid->tiles[i].value, grid->tiles[i].is_active, grid->leaf_count * NP_LEAF_SIZE + i,
              pow(grid->tiles[i].edge, 3), &largest);
  if (largest.is_known) np_value_tally_locate(grid, largest.number, &facts->largest);
}

/* ---- Stray voxels ---- */

/* Active voxels of a leaf or a tile. */
typedef struct block {
  int32_t origin[3], edge;
  uint64_t count;
} block;

/* Coordinate of a block, and its number of voxels. */
typedef struct step {
  int64_t at;
  uint64_t count;
} step;

static int compare_steps(const void *a, const void *b) {
  const step *first = a, *second = b;
  return (first->at > second->at) - (first->at < second->at);
}

static void list_blocks(const np_sparse_grid *grid, block *blocks) {
  for (size_t i = 0; i < grid->leaf_count; i++, blocks++) {
    memcpy(blocks->origin, grid->leaves[i].origin, sizeof blocks->origin);
    blocks->edge = NP_LEAF_EDGE;
    for (int word = 0; word < 8; word++) blocks->count += (uint64_t)__builtin_popcountll(grid->leaves[i].active[word]);
  }
  for (size_t i = 0; i < grid->tile_count; i++, blocks++) {
    memcpy(blocks->origin, grid->tiles[i].origin, sizeof blocks->origin);
    blocks->edge = grid->tiles[i].edge;
    blocks->count = grid->tiles[i].is_active ? (uint64_t)pow(grid->tiles[i].edge, 3) : 0;
  }
}

/* End of the core along an axis: a thousandth of the voxels lies outside. High ends are counted downwards. */
static int64_t get_core_end(const block *blocks, size_t count, uint64_t all, int axis, bool is_high, step *steps) {
  uint64_t before = 0;
  size_t i;
  for (i = 0; i < count; i++) {
    const int64_t low = blocks[i].origin[axis], high = low + blocks[i].edge;
    steps[i] = (step){is_high ? -high : low, blocks[i].count};
  }
  qsort(steps, count, sizeof *steps, compare_steps);
  for (i = 0; i + 1 < count && (before += steps[i].count) * 1000 <= all;) i++;
  return is_high ? -steps[i].at : steps[i].at;
}

/* Number of the block farthest from the core. */
static size_t search_farthest(const block *blocks, size_t count, int axis, const int64_t core[2]) {
  int64_t farthest = 0;
  size_t at = 0;
  for (size_t i = 0; i < count; i++) {
    const int64_t low = core[0] - blocks[i].origin[axis], high = blocks[i].origin[axis] + blocks[i].edge - core[1];
    const int64_t distance = low > high ? low : high;
    if (blocks[i].count && distance > farthest) farthest = distance, at = i;
  }
  return at;
}

/* Measures one axis; the axis along which most of the box is nearly empty counts. */
static void measure_axis(const np_sparse_grid *grid, const block *blocks, size_t count, int axis, step *steps,
                         np_grid_facts *facts) {
  const int64_t core[2] = {get_core_end(blocks, count, facts->active_count, axis, false, steps),
                           get_core_end(blocks, count, facts->active_count, axis, true, steps)};
  const double box = (double)facts->active_max[axis] - facts->active_min[axis] + 1.0;
  const double ratio = box / fmax((double)(core[1] - core[0]), NP_LEAF_EDGE);
  if (ratio <= facts->stray_ratio) return;
  const size_t at = search_farthest(blocks, count, axis, core), leaf_count = grid->leaf_count;
  facts->stray_ratio = ratio;
  np_value_tally_locate(grid, at < leaf_count ? at * NP_LEAF_SIZE : leaf_count * NP_LEAF_SIZE + at - leaf_count,
                        &facts->stray);
}

static neph_result measure_stray(const np_sparse_grid *grid, np_grid_facts *facts) {
  const size_t count = grid->leaf_count + grid->tile_count;
  block *blocks = np_alloc(grid->context, count, sizeof *blocks);
  step *steps = blocks ? np_alloc(grid->context, count, sizeof *steps) : NULL;
  if (steps) list_blocks(grid, blocks);
  for (int axis = 0; steps && axis < 3; axis++) measure_axis(grid, blocks, count, axis, steps, facts);
  np_alloc_free(grid->context, steps);
  np_alloc_free(grid->context, blocks);
  return steps ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* ---- Grids ---- */

/* Converts a float to double; subnormals by their bits, because this thread reads them as 0. */
static double widen(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  if (bits & 0x7f800000u) return (double)value;
  const double size = ldexp((double)(bits & 0x7fffffu), -149);
  return bits >> 31 ? -size : size;
}

/* Adds the counts of a grid, or of a component. */
static void set_kinds(np_grid_facts *facts, const np_sparse_grid *grid, const np_value_tally *tally) {
  for (int k = 0; k < NP_VALUE_KINDS; k++) {
    np_value_count *kind = &facts->kinds[k];
    if (tally->counts[k] && !kind->count) {
      kind->first_value = widen(tally->first_value[k]);
      np_value_tally_locate(grid, tally->first[k], &kind->first);
    }
    kind->count += tally->counts[k];
  }
}

static neph_result measure_values(np_sparse_grid *grid, np_monitor *monitor, np_grid_facts *facts) {
  const np_value_rule rule = facts->role == NP_GRID_VECTOR ? NP_VALUES_OF_VECTOR : NP_VALUES_OF_CLOUD;
  np_grid_extent extent;
  np_value_tally tally;
  const neph_result result = np_value_tally_count(grid, rule, false, monitor, &tally);
  if (result) return result;
  set_kinds(facts, grid, &tally);
  add_values(facts, grid);
  facts->has_values = true;
  facts->background = grid->background;
  facts->active_count = np_sparse_grid_count_active(grid);
  if (!np_sparse_grid_measure(grid, &extent)) return NEPH_OK;
  memcpy(facts->active_min, extent.min, sizeof extent.min);
  memcpy(facts->active_max, extent.max, sizeof extent.max);
  facts->value_min = extent.value_min;
  facts->value_max = extent.value_max;
  return measure_stray(grid, facts);
}

typedef struct measure_job {
  np_volume_file *file;
  const np_file_use *use; /* NULL: roles by name */
  np_monitor *monitor;
  np_file_facts *facts;
  double level_set_voxels;
} measure_job;

typedef struct diagnosis_list {
  neph_context *context;
  np_grid_facts *facts;
} diagnosis_list;

static void add_diagnosis(void *user, const char *text) {
  const diagnosis_list *list = user;
  np_grid_facts *facts = list->facts;
  char *copy = facts->diagnosis_count < NP_DIAGNOSES_MAX ? np_alloc_text(list->context, text) : NULL;
  if (copy) facts->diagnoses[facts->diagnosis_count++] = copy;
}

/* Reads a scalar. Frustums of densities are resampled, integers and masks become floats, level sets become fog. */
static neph_result read_scalar(const measure_job *job, size_t index, np_grid_role role, np_sparse_grid *out_grid) {
  const np_volume_choice choice = {{index}, 1, job->level_set_voxels};
  uint64_t tree_bytes;
  return role == NP_GRID_DENSITY ? np_volume_file_read_density(job->file, &choice, out_grid, &tree_bytes)
                                 : np_volume_file_read(job->file, index, out_grid, &tree_bytes);
}

/* Measures a frustum. Values that are not finite are repaired before resampling. */
static neph_result measure_frustum(np_sparse_grid *grid, np_grid_facts *facts) {
  facts->is_frustum = facts->role == NP_GRID_DENSITY;
  if (!facts->is_frustum || !facts->active_count) return NEPH_OK;
  np_frustum_bound_box(&grid->frustum, facts->active_min, facts->active_max, facts->world_min, facts->world_max);
  return np_frustum_measure(grid, &facts->frustum);
}

static neph_result measure_scalar(const measure_job *job, size_t index, np_grid_facts *facts) {
  np_sparse_grid grid = {0};
  neph_result result = read_scalar(job, index, facts->role, &grid);
  if (!result) result = measure_values(&grid, job->monitor, facts);
  if (!result && grid.frustum.is_enabled) result = measure_frustum(&grid, facts);
  np_sparse_grid_clear(&grid);
  if (result || (facts->role != NP_GRID_DENSITY && facts->role != NP_GRID_FIELD)) return result;
  diagnosis_list list = {job->file->context, facts};
  return np_volume_file_diagnose(job->file, index, add_diagnosis, &list);
}

static neph_result measure_size(const measure_job *job, size_t index, np_grid_facts *facts) {
  np_vdb_grid_size size;
  const neph_result result = np_volume_file_measure(job->file, index, &size);
  if (result) return result;
  facts->active_count = size.active_voxel_count;
  memcpy(facts->active_min, size.active_min, sizeof size.active_min);
  memcpy(facts->active_max, size.active_max, sizeof size.active_max);
  return NEPH_OK;
}

static neph_result add_component(const measure_job *job, size_t index, int component, np_grid_facts *facts) {
  np_sparse_grid grid = {0};
  np_value_tally tally;
  uint64_t tree_bytes;
  neph_result result = np_volume_file_read_component(job->file, index, component, &grid, &tree_bytes);
  if (!result) result = np_value_tally_count(&grid, NP_VALUES_OF_VECTOR, false, job->monitor, &tally);
  if (!result) set_kinds(facts, &grid, &tally);
  if (!isfinite(grid.background)) facts->background = grid.background;
  np_sparse_grid_clear(&grid);
  return result;
}

static neph_result measure_vector(const measure_job *job, size_t index, np_grid_facts *facts) {
  neph_result result = measure_size(job, index, facts);
  for (int component = 0; component < 3 && !result; component++) result = add_component(job, index, component, facts);
  return result;
}

static void set_transform(np_grid_facts *facts, const np_vdb_grid_info *info) {
  np_affine affine, inverse;
  facts->is_affine = info->is_affine;
  if (!info->is_affine) return;
  memcpy(affine.m, info->index_to_world, sizeof affine.m);
  memcpy(facts->index_to_world, affine.m, sizeof affine.m);
  facts->is_invertible = np_affine_invert(&affine, &inverse);
  for (int a = 0; a < 3; a++)
    facts->voxel_m[a] = np_dvec3_length(np_dvec3_make(affine.m[0][a], affine.m[1][a], affine.m[2][a]));
}

static void clear_grid(neph_context *context, np_grid_facts *grid) {
  np_alloc_free(context, grid->name);
  np_alloc_free(context, grid->value_type);
  np_alloc_free(context, grid->grid_class);
  np_alloc_free(context, grid->creator);
  for (unsigned d = 0; d < grid->diagnosis_count; d++) np_alloc_free(context, grid->diagnoses[d]);
  *grid = (np_grid_facts){0};
}

static neph_result set_texts(neph_context *context, np_grid_facts *facts, const np_vdb_grid_info *info) {
  facts->name = np_alloc_text(context, info->name);
  facts->value_type = np_alloc_text(context, info->value_type);
  facts->grid_class = np_alloc_text(context, info->grid_class);
  facts->creator = np_alloc_text(context, info->creator);
  return facts->name && facts->value_type && facts->grid_class && facts->creator ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result measure_content(const measure_job *job, size_t index, const np_vdb_grid_info *info,
                                   np_grid_facts *facts) {
  facts->is_unread = job->use && facts->role == NP_GRID_OTHER;
  if (facts->is_unread) return NEPH_OK;
  if (facts->role == NP_GRID_OTHER) return measure_size(job, index, facts);
  return info->is_vector ? measure_vector(job, index, facts) : measure_scalar(job, index, facts);
}

static neph_result measure_grid(const measure_job *job, size_t index, np_grid_facts *facts) {
  const np_vdb_grid_info info = np_volume_file_describe(job->file, index);
  facts->is_scalar = info.is_scalar;
  facts->is_count = info.is_count;
  facts->is_vector = info.is_vector;
  facts->is_level_set = info.is_level_set;
  facts->is_half_on_disk = info.is_half_on_disk;
  facts->is_instance = info.owner != index;
  set_transform(facts, &info);
  neph_result result = set_texts(job->file->context, facts, &info);
  if (!result) result = measure_content(job, index, &info, facts);
  if (result || !facts->active_count || !facts->is_affine) return result;
  np_affine affine;
  memcpy(affine.m, facts->index_to_world, sizeof affine.m);
  np_volume_bound_box(&affine, facts->active_min, facts->active_max, facts->world_min, facts->world_max);
  return NEPH_OK;
}

/* ---- Roles ---- */

/* Sets roles by name. A scalar that could be the density, but is not chosen, is a field. */
static void set_named_roles(const measure_job *job, bool has_density) {
  for (size_t i = 0; i < job->facts->count; i++) {
    const np_vdb_grid_info info = np_volume_file_describe(job->file, i);
    const np_grid_role role = np_volume_get_role(job->file, &info);
    job->facts->grids[i].role = role == NP_GRID_DENSITY && has_density ? NP_GRID_FIELD : role;
  }
}

/* Sets the role of a field, if the file has it. */
static neph_result set_field_role(const measure_job *job, const char *name) {
  const np_grid_query wish = {.grid = name, .is_field = true};
  np_volume_choice choice;
  char *refusal = NULL;
  const neph_result result = np_volume_choose(job->file, &wish, &choice, &refusal);
  if (!result && !refusal) job->facts->grids[choice.indices[0]].role = NP_GRID_FIELD;
  np_alloc_free(job->file->context, refusal);
  return result;
}

static neph_result set_used_roles(const measure_job *job) {
  enum { FIELDS = sizeof job->use->fields / sizeof *job->use->fields };
  const np_file_use *use = job->use;
  np_grid_facts *grids = job->facts->grids;
  size_t parts[3];
  neph_result result = NEPH_OK;
  for (size_t i = 0; i < job->facts->count; i++) grids[i].role = NP_GRID_OTHER;
  for (size_t f = 0; f < FIELDS && !result; f++)
    if (use->fields[f]) result = set_field_role(job, use->fields[f]);
  for (unsigned v = 0; v < use->vector_count; v++)
    if (np_volume_file_search_vector(job->file, use->vectors[v].role, use->vectors[v].name, parts))
      for (int a = 0; a < 3; a++) grids[parts[a]].role = NP_GRID_VECTOR;
  return result;
}

static neph_result set_roles(measure_job *job) {
  const np_grid_query wish = {.grid = job->use ? job->use->load.grid : NULL,
                              .level_set_voxels = job->level_set_voxels,
                              .sequence = job->use ? job->use->sequence : NULL};
  np_volume_choice choice;
  np_file_facts *facts = job->facts;
  neph_result result = np_volume_choose(job->file, &wish, &choice, &facts->refusal);
  if (!result && !facts->refusal && !choice.count) {
    facts->absence = np_volume_describe_absence(job->file, &wish);
    result = facts->absence ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  }
  if (!result && job->use) result = set_used_roles(job);
  if (result) return result;
  if (!job->use) set_named_roles(job, !facts->refusal);
  for (size_t i = 0; i < choice.count && !facts->refusal; i++) facts->grids[choice.indices[i]].role = NP_GRID_DENSITY;
  return NEPH_OK;
}

static neph_result run_measure(void *user) {
  measure_job *job = user;
  const size_t count = np_volume_file_count(job->file);
  job->facts->grids = np_alloc(job->file->context, count, sizeof *job->facts->grids);
  if (!job->facts->grids && count) return NEPH_ERROR_OUT_OF_MEMORY;
  job->facts->count = count;
  neph_result result = set_roles(job);
  size_t measured = 0;
  while (!result && measured < count) {
    result = measure_grid(job, measured, &job->facts->grids[measured]);
    measured += !result;
  }
  for (size_t i = measured; i < count; i++) clear_grid(job->file->context, &job->facts->grids[i]);
  job->facts->count = measured;
  return result;
}

neph_result np_file_facts_measure(neph_context *context, const char *path, const np_file_use *use, np_monitor *monitor,
                                  np_file_facts *out_facts) {
  np_volume_file file;
  *out_facts = (np_file_facts){.context = context};
  neph_result result = np_volume_file_open(context, path, use ? &use->load : NULL, monitor, &file);
  if (result) return result;
  measure_job job = {&file, use, monitor, out_facts, use ? use->load.level_set_voxels : 0.0};
  result = np_parallel_run(context, monitor, run_measure, &job);
  np_volume_file_close(&file);
  return result;
}

void np_file_facts_clear(np_file_facts *facts) {
  for (size_t i = 0; i < facts->count; i++) clear_grid(facts->context, &facts->grids[i]);
  np_alloc_free(facts->context, facts->grids);
  np_alloc_free(facts->context, facts->refusal);
  np_alloc_free(facts->context, facts->absence);
  *facts = (np_file_facts){0};
}

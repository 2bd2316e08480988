/* SPDX-License-Identifier: Apache-2.0 */
/* Method: the rules of vdb_mending.h on grids in C, which the module then converts to NanoVDB. */
#include "volume/nvdb_mend.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "volume/volume_format.h"

static const float half_max = 65504.0f;

/* A grid that is copied: a scalar, or the three components of a vector, with the same leaves in the same order. */
typedef struct copy {
  np_sparse_grid components[3];
  int component_count;
  bool is_half;
  np_vdb_attribute *attributes; /* owned, with their texts */
  size_t attribute_count, attribute_capacity;
  neph_result result; /* outcome of listing the attributes */
} copy;

typedef struct copy_job {
  const np_volume_file *file;
  np_vdb_mending *mendings;
  copy *copies;
  np_vdb_write_grid *outputs;
  size_t count;
} copy_job;

/* ---- Values ---- */

/* The test is of bits, since comparisons take subnormals as 0. */
static bool is_good(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return bits == 0 || (bits >= 0x00800000u && bits < 0x7f800000u);
}

static bool is_active(const np_leaf *leaf, int n) { return leaf->active[n / 64] >> (n % 64) & 1; }

/* Largest valid value; 0 if there is none. Nodes hold the background where nothing else is. */
static float get_good_max(const np_sparse_grid *grid) {
  float largest = is_good(grid->background) ? grid->background : 0.0f;
  for (size_t i = 0; i < grid->leaf_count; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      const float value = grid->leaves[i].values[n];
      if (is_good(value) && value > largest) largest = value;
    }
  for (size_t i = 0; i < grid->tile_count; i++)
    if (is_good(grid->tiles[i].value) && grid->tiles[i].value > largest) largest = grid->tiles[i].value;
  return largest;
}

static uint64_t repair_value(float *value, bool is_on, float largest) {
  if (is_good(*value)) return 0;
  *value = *value > FLT_MAX && is_on ? largest : 0.0f;
  return 1;
}

static uint64_t repair_values(np_sparse_grid *grid, float largest) {
  uint64_t count = 0;
  for (size_t i = 0; i < grid->leaf_count; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++)
      count += repair_value(&grid->leaves[i].values[n], is_active(&grid->leaves[i], n), largest);
  for (size_t i = 0; i < grid->tile_count; i++)
    count += repair_value(&grid->tiles[i].value, grid->tiles[i].is_active, largest);
  return count;
}

/* Sets the background to 0, and with it the inactive values that equal it. */
static bool repair_background(np_sparse_grid *grid) {
  const float old = grid->background;
  if (old == 0.0f) return false;
  grid->background = 0.0f;
  for (size_t i = 0; i < grid->leaf_count; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++)
      if (grid->leaves[i].values[n] == old && !is_active(&grid->leaves[i], n)) grid->leaves[i].values[n] = 0.0f;
  return true;
}

static uint64_t make_finite(copy *c) {
  uint64_t count = 0;
  for (size_t i = 0; i < c->components[0].leaf_count; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++) {
      bool is_mended = false;
      for (int k = 0; k < c->component_count; k++) {
        float *value = &c->components[k].leaves[i].values[n];
        if (isfinite(*value)) continue;
        *value = 0.0f;
        is_mended = true;
      }
      count += is_mended;
    }
  for (size_t i = 0; i < c->components[0].tile_count; i++) {
    bool is_mended = false;
    for (int k = 0; k < c->component_count; k++) {
      if (isfinite(c->components[k].tiles[i].value)) continue;
      c->components[k].tiles[i].value = 0.0f;
      is_mended = true;
    }
    count += is_mended;
  }
  return count;
}

static void repair_grid(copy *c, np_vdb_mending *mending) {
  np_sparse_grid *grid = &c->components[0];
  if (mending->mark == NP_VDB_MAKE_FINITE) mending->value_count = make_finite(c);
  if (mending->mark != NP_VDB_MEND_DENSITY && mending->mark != NP_VDB_MEND_VALUES) return;
  if (mending->mark == NP_VDB_MEND_DENSITY) mending->has_new_background = repair_background(grid);
  const float largest = get_good_max(grid);
  mending->value_count = repair_values(grid, largest);
  c->is_half = c->is_half && largest <= half_max;
}

/* ---- Grids ---- */

static neph_result check_type(const np_volume_file *file, const np_vdb_grid_info *info) {
  const bool is_float = info->is_scalar && strcmp(info->value_type, "double") != 0,
             is_vector = info->is_vector && !strcmp(info->value_type, "vec3s");
  if (!is_float && !is_vector)
    return np_fail(file->context, NEPH_ERROR_UNSUPPORTED,
                   "%s: grid '%s' is of type %s, a mended copy of a .nvdb holds floats and vectors of three floats "
                   "alone: convert the file with OpenVDB's tool, nanovdb_convert, and mend the .vdb",
                   file->path, info->name, info->value_type);
  if (!info->is_affine)
    return np_fail(file->context, NEPH_ERROR_UNSUPPORTED,
                   "%s: grid '%s' has a transform that cannot be inverted, and is not copied", file->path, info->name);
  return NEPH_OK;
}

/* Removes inactive tiles, which components list where they differ from their backgrounds: a vector grid has active
 * tiles alone. */
static void remove_inactive_tiles(np_sparse_grid *grid) {
  size_t count = 0;
  for (size_t i = 0; i < grid->tile_count; i++)
    if (grid->tiles[i].is_active) grid->tiles[count++] = grid->tiles[i];
  grid->tile_count = count;
}

static np_vdb_grid_info describe(const np_volume_file *file, size_t index) {
  np_vdb_grid_info info;
  file->format->describe(file->reader, index, &info);
  return info;
}

static neph_result read_component(const np_volume_file *file, size_t index, int component, np_sparse_grid *out_grid) {
  const np_vdb_request request = {.indices = &index, .count = 1, .component = component};
  uint64_t tree_bytes;
  neph_result result = np_sparse_grid_init(file->context, describe(file, index).name, out_grid);
  if (!result) result = file->format->read(file, &request, out_grid, &tree_bytes);
  if (!result) np_sparse_grid_sort(out_grid);
  return result;
}

static neph_result read_copy(const np_volume_file *file, size_t index, copy *c) {
  const np_vdb_grid_info info = describe(file, index);
  neph_result result = check_type(file, &info);
  c->component_count = info.is_vector ? 3 : 1;
  c->is_half = info.is_half_on_disk;
  for (int k = 0; k < c->component_count && !result; k++) {
    result = read_component(file, index, k, &c->components[k]);
    if (info.is_vector) remove_inactive_tiles(&c->components[k]);
  }
  return result;
}

/* ---- Metadata ---- */

/* Whether the writer sets a name itself, or the head of the grid states it. */
static bool is_set_by_writer(const char *name) {
  static const char *const names[] = {"class", "name", "is_saved_as_half_float", "is_local_space"};
  if (!strncmp(name, "file_", 5)) return true;
  for (size_t i = 0; i < sizeof names / sizeof *names; i++)
    if (!strcmp(name, names[i])) return true;
  return false;
}

static void add_attribute(void *user, const char *name, const char *text) {
  copy *c = user;
  neph_context *context = c->components[0].context;
  if (c->result || is_set_by_writer(name)) return;
  if (c->attribute_count == c->attribute_capacity) {
    const size_t capacity = 2 * c->attribute_capacity + 8;
    void *grown = np_alloc_resize(context, c->attributes, capacity, sizeof *c->attributes);
    c->result = grown ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
    if (!grown) return;
    c->attributes = grown;
    c->attribute_capacity = capacity;
  }
  np_vdb_attribute *attribute = &c->attributes[c->attribute_count++];
  *attribute = (np_vdb_attribute){.name = np_alloc_text(context, name), .text = np_alloc_text(context, text)};
  if (!attribute->name || !attribute->text) c->result = NEPH_ERROR_OUT_OF_MEMORY;
}

static neph_result read_attributes(const np_volume_file *file, size_t index, copy *c) {
  const neph_result result = file->format->visit_metadata(file, index, add_attribute, c);
  return result ? result : c->result;
}

static void clear_copy(neph_context *context, copy *c) {
  for (size_t i = 0; i < c->attribute_count; i++) {
    np_alloc_free(context, (void *)(uintptr_t)c->attributes[i].name);
    np_alloc_free(context, (void *)(uintptr_t)c->attributes[i].text);
  }
  np_alloc_free(context, c->attributes);
  for (int k = 0; k < 3; k++) np_sparse_grid_clear(&c->components[k]);
}

/* ---- The file ---- */

static np_vdb_write_grid make_output(const copy *c, const char *grid_class, np_vdb_mending *mending) {
  static const char fog[] = "fog volume";
  const bool is_density = mending->mark == NP_VDB_MEND_DENSITY, is_vector = c->component_count == 3;
  mending->has_new_class = is_density && strcmp(grid_class, fog) != 0;
  return (np_vdb_write_grid){.grid = &c->components[0],
                             .y = is_vector ? &c->components[1] : NULL,
                             .z = is_vector ? &c->components[2] : NULL,
                             .is_half = c->is_half,
                             .grid_class = is_density ? fog : grid_class,
                             .attributes = c->attributes,
                             .attribute_count = c->attribute_count};
}

static neph_result repair_one(const copy_job *job, size_t index) {
  copy *c = &job->copies[index];
  const np_vdb_grid_info info = describe(job->file, index);
  neph_result result = read_copy(job->file, index, c);
  if (!result) result = read_attributes(job->file, index, c);
  if (result) return result;
  repair_grid(c, &job->mendings[index]);
  job->outputs[index] = make_output(c, info.grid_class, &job->mendings[index]);
  if (info.is_scalar && strcmp(info.value_type, "float") != 0)
    np_log(job->file->context, NEPH_LOG_WARNING, "%s: grid '%s' is of type %s, and its copy of floats", job->file->path,
           info.name, info.value_type);
  return NEPH_OK;
}

static neph_result write_copies(const copy_job *job, const char *path) {
  const np_vdb_module *module;
  np_vdb_error error;
  neph_result result = np_vdb_module_get(job->file->context, &module);
  if (result) return result;
  result = module->write(path, job->outputs, job->count, /*is_nano=*/1, np_foreign_thread_count(job->file->context),
                         NULL, NULL, &error);
  return result ? np_fail(job->file->context, result, "%s: its mended copy: %s", job->file->path, error.message)
                : NEPH_OK;
}

neph_result np_nvdb_mend(const np_volume_file *file, np_vdb_mending *mendings, const char *path) {
  neph_context *context = file->context;
  copy_job job = {.file = file, .mendings = mendings, .count = file->format->count(file->reader)};
  job.copies = np_alloc(context, job.count + 1, sizeof *job.copies);
  job.outputs = np_alloc(context, job.count + 1, sizeof *job.outputs);
  neph_result result = job.copies && job.outputs ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < job.count && !result; i++) result = repair_one(&job, i);
  if (!result) result = write_copies(&job, path);
  for (size_t i = 0; i < job.count && job.copies; i++) clear_copy(context, &job.copies[i]);
  np_alloc_free(context, job.copies);
  np_alloc_free(context, job.outputs);
  return result;
}

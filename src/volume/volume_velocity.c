/* SPDX-License-Identifier: Apache-2.0 */
/* Velocities of a file: by the names that Houdini (vel, v), Blender and EmberGen (velocity) give them. */
#include <stdio.h>
#include <string.h>

#include "core/alloc.h"
#include "volume/volume_file.h"

static const char *const usual_names[] = {"vel", "v", "velocity"};
static const char *const separators[] = {"", ".", "_"};

enum { NAMES = sizeof usual_names / sizeof *usual_names, SEPARATORS = sizeof separators / sizeof *separators };

/* The grids of one velocity, and the component of each. */
typedef struct velocity_choice {
  bool is_found;
  size_t grid[3];
  int component[3];
} velocity_choice;

typedef struct velocity_load {
  neph_context *context;
  const char *path, *name;
  np_monitor *monitor;
  velocity_choice choice;
  np_sparse_grid *out;
} velocity_load;

/* ---- Choice ---- */

static bool search_grid(const np_volume_file *file, const char *name, bool is_vector, size_t *out_index) {
  const size_t count = file->module->count(file->vdb);
  for (size_t i = 0; i < count; i++) {
    np_vdb_grid_info info;
    file->module->describe(file->vdb, i, &info);
    if ((is_vector ? info.is_vector : info.is_scalar) && !strcmp(info.name, name)) return *out_index = i, true;
  }
  return false;
}

static bool choose_vector(const np_volume_file *file, const char *name, velocity_choice *out) {
  if (!search_grid(file, name, true, &out->grid[0])) return false;
  for (int a = 0; a < 3; a++) {
    out->grid[a] = out->grid[0];
    out->component[a] = a;
  }
  return true;
}

static bool choose_floats(const np_volume_file *file, const char *name, velocity_choice *out) {
  for (int s = 0; s < SEPARATORS; s++) {
    int found = 0;
    for (int a = 0; a < 3; a++) {
      char component[128];
      (void)snprintf(component, sizeof component, "%s%s%c", name, separators[s], "xyz"[a]);
      found += search_grid(file, component, false, &out->grid[a]);
      out->component[a] = 0;
    }
    if (found == 3) return true;
  }
  return false;
}

static neph_result choose(velocity_load *job, const np_volume_file *file) {
  velocity_choice *choice = &job->choice;
  if (job->name) choice->is_found = choose_vector(file, job->name, choice) || choose_floats(file, job->name, choice);
  for (int n = 0; !job->name && n < NAMES && !choice->is_found; n++)
    choice->is_found = choose_vector(file, usual_names[n], choice) || choose_floats(file, usual_names[n], choice);
  if (choice->is_found || !job->name) return NEPH_OK;
  return np_fail(
      job->context, NEPH_ERROR_BAD_FILE,
      "%s: no grid '%s' of vectors, and no three of floats, '%s.x', '%s.y' and '%s.z': it is the velocity that "
      "the scene names",
      job->path, job->name, job->name, job->name, job->name);
}

/* ---- Values ---- */

/* NaN and infinity become 0; returns how many there are. */
static uint64_t repair(float *values, size_t count) {
  uint64_t broken = 0;
  for (size_t n = 0; n < count; n++) {
    if (isfinite(values[n])) continue;
    values[n] = 0.0f;
    broken++;
  }
  return broken;
}

static neph_result check_values(const velocity_load *job, np_sparse_grid *grid, neph_import_policy policy) {
  uint64_t broken = repair(&grid->background, 1);
  for (size_t i = 0; i < grid->leaf_count; i++) broken += repair(grid->leaves[i].values, NP_LEAF_SIZE);
  for (size_t i = 0; i < grid->tile_count; i++) broken += repair(&grid->tiles[i].value, 1);
  if (!broken) return NEPH_OK;
  if (policy == NEPH_IMPORT_REFUSE)
    return np_fail(job->context, NEPH_ERROR_BAD_FILE,
                   "%s: grid '%s': %llu values are NaN or infinite, must be finite, or be imported with repair",
                   job->path, grid->name, (unsigned long long)broken);
  np_log(job->context, NEPH_LOG_WARNING, "%s: grid '%s': %llu values are NaN or infinite; taken as 0", job->path,
         grid->name, (unsigned long long)broken);
  return NEPH_OK;
}

/* ---- Load ---- */

/* The components of a staggered grid are on the low faces of its voxels. */
static void place_staggered(int axis, np_sparse_grid *grid) {
  for (int row = 0; row < 3; row++) grid->index_to_world.m[row][3] -= 0.5 * grid->index_to_world.m[row][axis];
}

static neph_result read_component(const velocity_load *job, const np_volume_file *file, int axis) {
  np_vdb_grid_info info;
  uint64_t bytes;
  const size_t index = job->choice.grid[axis];
  file->module->describe(file->vdb, index, &info);
  if (!info.is_affine)
    return np_fail(job->context, NEPH_ERROR_UNSUPPORTED,
                   "%s: grid '%s' has a frustum transform: resample it to one that is affine", job->path, info.name);
  const bool is_staggered = info.is_vector && !strcmp(info.grid_class, "staggered");
  const neph_result result =
      np_volume_file_read_component(file, index, job->choice.component[axis], &job->out[axis], &bytes);
  if (!result && is_staggered) place_staggered(axis, &job->out[axis]);
  return result;
}

static neph_result run(void *user) {
  velocity_load *job = user;
  np_volume_file file;
  neph_result result = np_volume_file_open(job->context, job->path, job->monitor, &file);
  if (result) return result;
  result = choose(job, &file);
  for (int a = 0; a < 3 && job->choice.is_found && !result; a++) result = read_component(job, &file, a);
  np_volume_file_close(&file);
  return result;
}

neph_result np_volume_load_velocity(neph_context *context, const char *path, const char *name,
                                    neph_import_policy policy, np_monitor *monitor, np_sparse_grid out_velocity[3],
                                    bool *out_is_found) {
  velocity_load job = {.context = context, .path = path, .name = name, .monitor = monitor, .out = out_velocity};
  for (int a = 0; a < 3; a++) out_velocity[a] = (np_sparse_grid){.context = NULL};
  neph_result result = np_parallel_run(context, monitor, run, &job);
  for (int a = 0; a < 3 && job.choice.is_found && !result; a++) {
    result = check_values(&job, &out_velocity[a], policy);
    out_velocity[a].file = path;
  }
  *out_is_found = job.choice.is_found;
  return result;
}

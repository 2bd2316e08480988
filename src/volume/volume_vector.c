/* SPDX-License-Identifier: Apache-2.0 */
/* Velocities and colours of a file, in a vector grid or three scalar grids, by the names of Houdini (vel, v, Cd, Ce),
 * Blender and EmberGen (velocity, color, emission). */
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"
#include "volume/volume_file.h"
#include "volume/volume_levels.h"
#include "volume/volume_tint.h"

enum { USUAL_NAMES_MAX = 3, ENDINGS_MAX = 3 };

/* Role of a vector: its usual names, and the suffixes of the names of its components, as one word each. */
typedef struct vector_row {
  const char *purpose;
  const char *names[USUAL_NAMES_MAX];
  const char *endings[ENDINGS_MAX];
} vector_row;

static const vector_row rows[] = {
    [NP_VECTOR_VELOCITY] = {"velocity", {"vel", "v", "velocity"}, {"xyz"}},
    [NP_VECTOR_COLOR] = {"color", {"Cd", "color", "albedo"}, {"rgb", "RGB", "xyz"}},
    [NP_VECTOR_EMISSION] = {"emission.color", {"Ce", "emission", "emit"}, {"rgb", "RGB", "xyz"}},
};

static const char *const separators[] = {"", ".", "_"};

enum { SEPARATORS = sizeof separators / sizeof *separators };

/* Grids of one vector, and the component that each holds. */
typedef struct vector_choice {
  const char *name; /* borrowed; NULL: not found */
  size_t grid[3];
  int component[3];
} vector_choice;

typedef struct vector_load {
  neph_context *context;
  const char *path, *name;
  const vector_row *row;
  np_monitor *monitor;
  vector_choice choice;
  np_sparse_grid *out;
  unsigned level, level_count; /* level of detail in the file; 0: not stated */
} vector_load;

/* ---- Choice ---- */

static bool search_grid(const np_volume_file *file, const char *name, bool is_vector, size_t *out_index) {
  const size_t count = np_volume_file_count(file);
  for (size_t i = 0; i < count; i++) {
    const np_vdb_grid_info info = np_volume_file_describe(file, i);
    if ((is_vector ? info.is_vector : info.is_scalar) && !strcmp(info.name, name)) return *out_index = i, true;
  }
  return false;
}

static bool choose_vector(const np_volume_file *file, const char *name, vector_choice *out) {
  if (!search_grid(file, name, true, &out->grid[0])) return false;
  for (int a = 0; a < 3; a++) {
    out->grid[a] = out->grid[0];
    out->component[a] = a;
  }
  return true;
}

static bool choose_components(const np_volume_file *file, const char *name, const char *separator, const char *endings,
                              vector_choice *out) {
  bool is_whole = true;
  for (int a = 0; a < 3 && is_whole; a++) {
    char component[128];
    if (strlen(name) + strlen(separator) + 2 > sizeof component) return false;
    np_print(component, sizeof component, "%s%s%c", name, separator, endings[a]);
    is_whole = search_grid(file, component, false, &out->grid[a]);
    out->component[a] = 0;
  }
  return is_whole;
}

static bool choose_by_name(const np_volume_file *file, const vector_row *row, const char *name, vector_choice *out) {
  out->name = name;
  if (choose_vector(file, name, out)) return true;
  for (int e = 0; e < ENDINGS_MAX && row->endings[e]; e++)
    for (int s = 0; s < SEPARATORS; s++)
      if (choose_components(file, name, separators[s], row->endings[e], out)) return true;
  out->name = NULL;
  return false;
}

static bool search(const np_volume_file *file, const vector_row *row, const char *name, vector_choice *out) {
  out->name = NULL;
  if (name) return choose_by_name(file, row, name, out);
  for (int n = 0; n < USUAL_NAMES_MAX; n++)
    if (choose_by_name(file, row, row->names[n], out)) return true;
  return false;
}

bool np_volume_file_search_vector(const np_volume_file *file, np_vector_role role, const char *name,
                                  size_t out_grids[3]) {
  vector_choice choice;
  const bool is_found = search(file, &rows[role], name, &choice);
  for (int a = 0; a < 3 && is_found; a++) out_grids[a] = choice.grid[a];
  return is_found;
}

static neph_result choose(const np_volume_file *file, const vector_row *row, const char *name, vector_choice *out) {
  const char *ends = row->endings[0];
  if (search(file, row, name, out) || !name) return NEPH_OK;
  return np_fail(file->context, NEPH_ERROR_BAD_FILE,
                 "%s: no grid '%s' of vectors, and no three of floats, '%s.%c', '%s.%c' and '%s.%c': it is the %s that "
                 "the scene names",
                 file->path, name, name, ends[0], name, ends[1], name, ends[2], row->purpose);
}

neph_result np_volume_search_vector(neph_context *context, const char *path, np_vector_role role, const char *name,
                                    bool *out_is_found) {
  np_volume_file file;
  vector_choice choice = {.name = NULL};
  *out_is_found = false;
  neph_result result = np_volume_file_open(context, path, NULL, NULL, &file);
  if (result) return result;
  result = choose(&file, &rows[role], name, &choice);
  *out_is_found = choice.name != NULL;
  np_volume_file_close(&file);
  return result;
}

/* ---- Load ---- */

/* Moves the transform of a staggered component to the low faces of voxels. */
static void place_staggered(int axis, np_sparse_grid *grid) {
  for (int row = 0; row < 3; row++) grid->index_to_world.m[row][3] -= 0.5 * grid->index_to_world.m[row][axis];
}

static neph_result read_component(const vector_load *job, const np_volume_file *file, int axis) {
  uint64_t bytes;
  const size_t index = job->choice.grid[axis];
  const np_vdb_grid_info info = np_volume_file_describe(file, index);
  if (!info.is_affine)
    return np_fail(job->context, NEPH_ERROR_UNSUPPORTED,
                   "%s: grid '%s' has a frustum transform: resample it to one that is affine", job->path, info.name);
  const bool is_staggered =
      job->row == &rows[NP_VECTOR_VELOCITY] && info.is_vector && !strcmp(info.grid_class, "staggered");
  const neph_result result =
      np_volume_file_read_component(file, index, job->choice.component[axis], &job->out[axis], &bytes);
  if (!result && is_staggered) place_staggered(axis, &job->out[axis]);
  return result;
}

static void read_mark(void *user, const char *name, const char *text) {
  vector_load *job = user;
  if (!strcmp(name, "nephos:level")) job->level = (unsigned)strtoul(text, NULL, 10);
  if (!strcmp(name, "nephos:level_count")) job->level_count = (unsigned)strtoul(text, NULL, 10);
}

static neph_result read_level(vector_load *job, const np_volume_file *file) {
  return np_volume_file_visit_metadata(file, job->choice.grid[0], read_mark, job);
}

static neph_result run(void *user) {
  vector_load *job = user;
  np_volume_file file;
  neph_result result = np_volume_file_open(job->context, job->path, NULL, job->monitor, &file);
  if (result) return result;
  result = choose(&file, job->row, job->name, &job->choice);
  if (!result && job->choice.name) result = read_level(job, &file);
  for (int a = 0; a < 3 && job->choice.name && !result; a++) result = read_component(job, &file, a);
  np_volume_file_close(&file);
  return result;
}

/* Logs the choice. The message names the role of a colour, whatever the file calls it. */
static void log_choice(const vector_load *job) {
  if (job->row != &rows[NP_VECTOR_VELOCITY] && !job->name)
    np_log(job->context, NEPH_LOG_INFO, "%s: its grid '%s' is taken as clouds[].%s (none: it is not)", job->path,
           job->choice.name, job->row->purpose);
}

static neph_result load(vector_load *job, neph_import_policy policy) {
  for (int a = 0; a < 3; a++) job->out[a] = (np_sparse_grid){.context = NULL};
  neph_result result = np_parallel_run(job->context, job->monitor, run, job);
  const bool is_found = !result && job->choice.name;
  for (int a = 0; a < 3 && is_found && !result; a++) {
    np_sparse_grid *grid = &job->out[a];
    result = np_volume_import_finite_background(job->context, job->path, grid, policy);
    if (!result)
      result = np_volume_import_values(job->context, job->path, grid, NP_VALUES_OF_VECTOR, policy, job->monitor);
    grid->file = job->path;
  }
  if (is_found && !result) log_choice(job);
  return result;
}

static vector_load make_load(neph_context *context, const char *path, const np_vector_request *request,
                             np_monitor *monitor, np_sparse_grid *out) {
  return (vector_load){.context = context,
                       .path = path,
                       .name = request->name,
                       .row = &rows[request->role],
                       .monitor = monitor,
                       .out = out};
}

neph_result np_volume_load_vector(neph_context *context, const char *path, const np_vector_request *request,
                                  np_monitor *monitor, np_sparse_grid out_vector[3], bool *out_is_found) {
  vector_load job = make_load(context, path, request, monitor, out_vector);
  const neph_result result = load(&job, request->policy);
  *out_is_found = !result && job.choice.name;
  return result;
}

/* ---- Levels of detail ---- */

/* Reads the velocity of a coarser level; it is required if the finest has one. */
static neph_result load_level(const vector_load *finest, const np_vector_request *request, unsigned number,
                              np_sparse_grid *out) {
  char *path = np_volume_name_level(finest->context, finest->path, number);
  if (!path) return NEPH_ERROR_OUT_OF_MEMORY;
  vector_load job = make_load(finest->context, path, request, finest->monitor, out);
  neph_result result = load(&job, request->policy);
  for (int a = 0; a < 3; a++) out[a].file = NULL;
  if (!result && !job.choice.name)
    result = np_fail(finest->context, NEPH_ERROR_BAD_FILE,
                     "%s: has no velocity, but %s has, which is the first of %u levels of detail: bake all of them "
                     "again, or set clouds[].velocity: none",
                     path, finest->path, finest->level_count);
  np_alloc_free(finest->context, path);
  return result;
}

neph_result np_volume_load_velocities(neph_context *context, const char *path, const np_vector_request *request,
                                      np_monitor *monitor, np_sparse_grid *out_vectors, unsigned *out_level_count) {
  vector_load finest = make_load(context, path, request, monitor, out_vectors);
  neph_result result = load(&finest, request->policy);
  *out_level_count = !result && finest.choice.name;
  if (!*out_level_count || finest.level > 0) return result;
  for (unsigned k = 1; k < finest.level_count && k < NP_TINT_PARTS_MAX && !result; k++) {
    result = load_level(&finest, request, k, &out_vectors[3 * (size_t)k]);
    *out_level_count = k + 1;
  }
  return result;
}

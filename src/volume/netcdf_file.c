/* SPDX-License-Identifier: Apache-2.0 */
/* The format of NetCDF: the water of an atmospheric model as grids of extinction and of water content. */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"
#include "volume/model.h"
#include "volume/netcdf_classic.h"
#include "volume/netcdf_module.h"
#include "volume/netcdf_process.h"
#include "volume/volume_format.h"
#include "volume/volume_sizes.h"

typedef struct netcdf_reader {
  np_model model;
  np_monitor *monitor;
  size_t grid_count;
  np_model_grid grids[NP_MODEL_GRIDS];
} netcdf_reader;

/* The first eight bytes of a file of the classic format or of HDF5. */
static bool has_magic(uint64_t magic) {
  return np_netcdf_classic_has_magic(magic) || !memcmp(&magic, "\211HDF\r\n\032\n", sizeof magic);
}

static bool is_classic(const np_volume_file *file) {
  np_vdb_bytes_seek(file->bytes, 0);
  return np_netcdf_classic_has_magic((uint64_t)np_vdb_bytes_read_i64(file->bytes));
}

/* Opens a file of the classic format, whose header is checked, in this process. */
static neph_result open_classic(const np_volume_file *file, np_model *model, np_netcdf_error *error) {
  neph_result result = np_netcdf_classic_check(file->bytes);
  if (!result) result = np_netcdf_module_get(file->context, &model->module);
  if (result) return result;
  return model->module->open(file->path, file->bytes->memory, (size_t)file->bytes->size, &model->file, error);
}

/* Describes all variables once: a reader that such a call ends is a fault of the file, and not a missing variable. */
static neph_result open_hdf5(const np_volume_file *file, const np_monitor *monitor, np_model *model,
                             np_netcdf_error *error) {
  np_netcdf_variable ignored;
  model->module = &np_netcdf_process_table;
  if (file->bytes->result) return file->bytes->result;
  const neph_result result = np_netcdf_process_open(file->context, monitor, file->path, file->bytes->memory,
                                                    (size_t)file->bytes->size, &model->file, error);
  if (result) return result;
  for (int i = 0; i < model->module->count(model->file); i++)
    if (model->module->describe(model->file, i, &ignored, error) && np_netcdf_process_has_ended(model->file))
      return error->result;
  error->message[0] = '\0';
  return NEPH_OK;
}

/* ---- Opening ---- */

static void close_file(void *pointer) {
  netcdf_reader *reader = pointer;
  np_model_clear_levels(&reader->model);
  if (reader->model.file) reader->model.module->close(reader->model.file);
  np_alloc_free(reader->model.context, reader);
}

static neph_result open_model(const np_volume_file *file, const np_monitor *monitor, np_model *model) {
  static const neph_volume_load_desc defaults = NEPH_VOLUME_LOAD_DESC_DEFAULT;
  const neph_volume_load_desc *desc = file->desc ? file->desc : &defaults;
  np_netcdf_error error = {.result = NEPH_OK};
  model->path = file->path;
  model->settings = desc->model;
  model->policy = desc->policy;
  model->file_bytes = (uint64_t)file->bytes->size;
  neph_result result = is_classic(file) ? open_classic(file, model, &error) : open_hdf5(file, monitor, model, &error);
  if (error.message[0] && result != NEPH_ERROR_CANCELLED)
    return np_fail(file->context, error.result, "%s: %s", file->path, error.message);
  if (result) return result;
  result = np_model_choose_fields(model);
  return result ? result : np_model_place_axes(model);
}

static void list_grids(netcdf_reader *reader) {
  const np_model_field *fields = reader->model.fields;
  reader->grids[reader->grid_count++] = NP_MODEL_EXTINCTION;
  if (fields[NP_MODEL_LIQUID].count) reader->grids[reader->grid_count++] = NP_MODEL_LIQUID_WATER;
  if (fields[NP_MODEL_ICE].count) reader->grids[reader->grid_count++] = NP_MODEL_ICE_WATER;
  if (np_model_has_radii(&reader->model)) reader->grids[reader->grid_count++] = NP_MODEL_RADIUS;
}

static void describe_sources(const np_model *model) {
  char air[40], liquid[80], ice[80];
  np_model_describe_air(model, air, sizeof air);
  np_model_describe_radius(model, NP_MODEL_LIQUID, liquid, sizeof liquid);
  np_model_describe_radius(model, NP_MODEL_ICE, ice, sizeof ice);
  np_log(model->context, NEPH_LOG_INFO,
         "%s: %s: step %zu of %zu, density of air: %s, effective radius of droplets: %s, of ice: %s", model->path,
         model->convention->model, model->step + 1, model->sizes[NP_MODEL_T], air, liquid, ice);
}

static neph_result open_file(np_volume_file *file, np_monitor *monitor) {
  netcdf_reader *reader = np_alloc(file->context, 1, sizeof *reader);
  if (!reader) return NEPH_ERROR_OUT_OF_MEMORY;
  reader->model.context = file->context;
  reader->monitor = monitor;
  reader->model.is_quiet = !monitor;
  neph_result result = open_model(file, monitor, &reader->model);
  if (!result) result = np_model_place_levels(&reader->model, monitor);
  if (result) return close_file(reader), result;
  list_grids(reader);
  file->reader = reader;
  return NEPH_OK;
}

/* ---- Descriptions ---- */

static const char *const grid_names[NP_MODEL_GRIDS] = {"density", "liquid_water", "ice_water", NP_SIZES_USUAL_NAME};
static const char *const grid_units[NP_MODEL_GRIDS] = {"1/m", "g/m3", "g/m3", "um"};

static size_t count_grids(const void *reader) { return ((const netcdf_reader *)reader)->grid_count; }

/* Samples sit at the middles of voxels. */
static np_affine get_transform(const np_model *model) {
  np_affine affine = {.m = {{0}}};
  affine.m[0][0] = model->lines[1].spacing_m;
  affine.m[1][1] = model->lines[0].spacing_m;
  affine.m[2][2] = model->step_m;
  affine.m[0][3] = model->lines[1].first_m;
  affine.m[1][3] = model->lines[0].first_m;
  affine.m[2][3] = model->bottom_m + 0.5 * model->step_m;
  return affine;
}

static void describe(const void *pointer, size_t index, np_vdb_grid_info *out_info) {
  const netcdf_reader *reader = pointer;
  const np_model_grid grid = reader->grids[index];
  const np_affine transform = get_transform(&reader->model);
  *out_info = (np_vdb_grid_info){.name = grid_names[grid],
                                 .value_type = "float",
                                 .grid_class = grid == NP_MODEL_EXTINCTION ? "fog volume" : "unknown",
                                 .creator = reader->model.convention->model,
                                 .owner = index,
                                 .is_scalar = true,
                                 .is_affine = true};
  memcpy(out_info->index_to_world, transform.m, sizeof transform.m);
}

static void visit_field(const np_model *model, np_model_role role, const char *name, np_metadata_visit_fn visit,
                        void *user) {
  char text[2 * 80];
  const np_model_field *field = &model->fields[role];
  size_t length = 0;
  text[0] = 0;
  for (int i = 0; i < field->count; i++) {
    char part[64];
    np_print_short(part, sizeof part, field->parts[i].info.name);
    length += np_print(text + length, sizeof text - length, "%s%s", i ? "+" : "", part);
  }
  if (field->count) visit(user, name, text);
}

static neph_result visit_metadata(const np_volume_file *file, size_t index, np_metadata_visit_fn visit, void *user) {
  const netcdf_reader *reader = file->reader;
  const np_model *model = &reader->model;
  char text[80];
  visit(user, "units", grid_units[reader->grids[index]]);
  if (reader->grids[index] == NP_MODEL_EXTINCTION) visit(user, "nephos:extinction_per_value", "1");
  visit(user, "model", model->convention->model);
  visit_field(model, NP_MODEL_LIQUID, "liquid", visit, user);
  visit_field(model, NP_MODEL_ICE, "ice", visit, user);
  np_model_describe_air(model, text, sizeof text);
  visit(user, "air_density", text);
  np_model_describe_radius(model, NP_MODEL_LIQUID, text, sizeof text);
  if (model->fields[NP_MODEL_LIQUID].count) visit(user, "effective_radius", text);
  np_model_describe_radius(model, NP_MODEL_ICE, text, sizeof text);
  if (model->fields[NP_MODEL_ICE].count) visit(user, "ice_effective_radius", text);
  np_print(text, sizeof text, "%zu of %zu", model->step + 1, model->sizes[NP_MODEL_T]);
  visit(user, "step", text);
  np_print(text, sizeof text, "%zu %s", model->sizes[NP_MODEL_Z], model->is_even ? "even" : "resampled");
  visit(user, "levels", text);
  visit(user, "nephos:domain_min", "[0, 0]");
  np_print(text, sizeof text, "[%zu, %zu]", model->sizes[NP_MODEL_X] - 1, model->sizes[NP_MODEL_Y] - 1);
  visit(user, "nephos:domain_max", text);
  return NEPH_OK;
}

/* ---- Reading ---- */

/* Buffers of some rows: faces and values of levels, two columns of voxels, and the voxels of eight rows. */
typedef struct read_job {
  const netcdf_reader *reader;
  np_sparse_grid *grid;
  bool is_mean; /* values are means by extinction: their sum is divided by that of the extinction */
  double *faces_m, *values, *sum, *weight, *columns[2];
  float *voxels; /* (row of 8, x, voxel) */
  double largest;
  np_water_tally tally;
} read_job;

static neph_result allocate(read_job *job) {
  const np_model *model = &job->reader->model;
  const size_t columns = model->sizes[NP_MODEL_X], levels = model->sizes[NP_MODEL_Z];
  const size_t rows = np_model_get_slab(model) * columns;
  job->faces_m = np_alloc(model->context, rows * (levels + 1), sizeof *job->faces_m);
  job->values = np_alloc(model->context, rows * levels, sizeof *job->values);
  job->sum = np_alloc(model->context, rows * levels, sizeof *job->sum);
  if (job->is_mean) job->weight = np_alloc(model->context, rows * levels, sizeof *job->weight);
  for (int k = 0; k < 2; k++) {
    job->columns[k] = np_alloc(model->context, model->level_count, sizeof *job->columns[k]);
    if (!job->columns[k]) return NEPH_ERROR_OUT_OF_MEMORY;
  }
  job->voxels = np_alloc(model->context, NP_LEAF_EDGE * columns * model->level_count, sizeof *job->voxels);
  const bool has_weight = job->weight || !job->is_mean;
  return job->faces_m && job->values && job->sum && has_weight && job->voxels ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

static void release(read_job *job) {
  neph_context *context = job->reader->model.context;
  np_alloc_free(context, job->faces_m);
  np_alloc_free(context, job->values);
  np_alloc_free(context, job->sum);
  np_alloc_free(context, job->weight);
  for (int k = 0; k < 2; k++) np_alloc_free(context, job->columns[k]);
  np_alloc_free(context, job->voxels);
}

/* Values of one column of voxels, from one of levels; `room` is used where levels are uneven. */
static const double *resample(const read_job *job, size_t source, const double *levels_of_all, double *room) {
  const np_model *model = &job->reader->model;
  const size_t levels = model->sizes[NP_MODEL_Z];
  const double *values = levels_of_all + source * levels;
  if (model->is_even) return values;
  np_model_resample_column(levels, job->faces_m + source * (levels + 1), values, model->bottom_m, model->step_m,
                           model->level_count, room);
  return room;
}

/* Fills one column of voxels from one of levels. */
static void fill_column(read_job *job, size_t source, size_t target) {
  const size_t count = job->reader->model.level_count;
  const double *values = resample(job, source, job->sum, job->columns[0]);
  const double *weights = job->is_mean ? resample(job, source, job->weight, job->columns[1]) : NULL;
  float *voxels = job->voxels + target * count;
  for (size_t k = 0; k < count; k++) {
    const double value = !weights ? values[k] : weights[k] > 0.0 ? values[k] / weights[k] : 0.0;
    voxels[k] = (float)value;
    job->largest = fmax(job->largest, value);
  }
}

/* Box of voxels of a leaf within the eight rows. */
typedef struct leaf_box {
  size_t x, z, rows, columns, levels;
} leaf_box;

static bool has_water(const read_job *job, const leaf_box *box) {
  const size_t count = job->reader->model.level_count, columns = job->reader->model.sizes[NP_MODEL_X];
  for (size_t j = 0; j < box->rows; j++)
    for (size_t i = 0; i < box->columns; i++)
      for (size_t k = 0; k < box->levels; k++)
        if (job->voxels[(j * columns + box->x + i) * count + box->z + k] > 0.0f) return true;
  return false;
}

static neph_result add_leaf(read_job *job, const leaf_box *box, size_t row) {
  const size_t count = job->reader->model.level_count, columns = job->reader->model.sizes[NP_MODEL_X];
  const int32_t origin[3] = {(int32_t)box->x, (int32_t)row, (int32_t)box->z};
  np_leaf *leaf = np_sparse_grid_add_leaf(job->grid, origin);
  if (!leaf) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t j = 0; j < box->rows; j++)
    for (size_t i = 0; i < box->columns; i++)
      for (size_t k = 0; k < box->levels; k++) {
        const float value = job->voxels[(j * columns + box->x + i) * count + box->z + k];
        leaf->values[i * 64 + j * 8 + k] = value;
        if (value > 0.0f) leaf->active[i] |= UINT64_C(1) << (j * 8 + k);
      }
  return NEPH_OK;
}

static size_t least(size_t a, size_t b) { return a < b ? a : b; }

/* Adds leaves of eight rows, or of fewer at the end. */
static neph_result add_leaves(read_job *job, size_t row, size_t row_count) {
  const np_model *model = &job->reader->model;
  neph_result result = NEPH_OK;
  for (size_t x = 0; x < model->sizes[NP_MODEL_X] && !result; x += NP_LEAF_EDGE)
    for (size_t z = 0; z < model->level_count && !result; z += NP_LEAF_EDGE) {
      const leaf_box box = {x, z, row_count, least(NP_LEAF_EDGE, model->sizes[NP_MODEL_X] - x),
                            least(NP_LEAF_EDGE, model->level_count - z)};
      if (has_water(job, &box)) result = add_leaf(job, &box, row);
    }
  return result;
}

/* Sums the requested grids on the levels of some rows. */
static neph_result read_levels(read_job *job, const np_vdb_request *request, np_model_rows rows) {
  const np_model *model = &job->reader->model;
  const size_t count = rows.count * model->sizes[NP_MODEL_X] * model->sizes[NP_MODEL_Z];
  neph_result result = np_model_read_faces(model, rows, job->faces_m);
  for (size_t i = 0; i < count; i++) job->sum[i] = 0.0;
  for (size_t g = 0; g < request->count && !result; g++) {
    const np_model_grid grid = job->reader->grids[request->indices[g]];
    result = np_model_read_water(model, grid, rows, job->faces_m, job->values, &job->tally);
    for (size_t i = 0; i < count && !result; i++) job->sum[i] += job->values[i];
  }
  np_water_tally again = {.count = 0}; /* the same water is counted once */
  if (!result && job->is_mean)
    result = np_model_read_water(model, NP_MODEL_EXTINCTION, rows, job->faces_m, job->weight, &again);
  return result;
}

static neph_result read_rows(read_job *job, const np_vdb_request *request, np_model_rows rows) {
  const size_t columns = job->reader->model.sizes[NP_MODEL_X];
  neph_result result = read_levels(job, request, rows);
  for (size_t y = 0; y < rows.count && !result; y += NP_LEAF_EDGE) {
    const size_t row_count = least(NP_LEAF_EDGE, rows.count - y);
    for (size_t i = 0; i < row_count * columns; i++) fill_column(job, y * columns + i, i);
    result = add_leaves(job, rows.begin + y, row_count);
  }
  return result;
}

static neph_result read_all(read_job *job, const np_vdb_request *request) {
  const np_model *model = &job->reader->model;
  const size_t slab = np_model_get_slab(model), rows = model->sizes[NP_MODEL_Y];
  neph_result result = allocate(job);
  for (size_t y = 0; y < rows && !result; y += slab) {
    result = read_rows(job, request, (np_model_rows){y, least(slab, rows - y)});
    if (!result && np_monitor_is_cancelled(job->reader->monitor)) result = NEPH_ERROR_CANCELLED;
  }
  return result || job->is_mean ? result : np_water_tally_report(&job->tally, model);
}

static neph_result read(const np_volume_file *file, const np_vdb_request *request, np_sparse_grid *grid,
                        uint64_t *out_tree_bytes) {
  const netcdf_reader *reader = file->reader;
  read_job job = {.reader = reader, .grid = grid, .is_mean = reader->grids[request->indices[0]] == NP_MODEL_RADIUS};
  grid->index_to_world = get_transform(&reader->model);
  grid->brick_bytes_max = 0; /* the number of values is checked */
  if (request->is_density) describe_sources(&reader->model);
  neph_result result = reader->model.is_empty ? NEPH_OK : read_all(&job, request);
  release(&job);
  *out_tree_bytes = grid->leaf_count * sizeof(np_leaf);
  if (result || job.largest <= 65504.0) return result;
  return np_fail(file->context, NEPH_ERROR_BAD_FILE, "%s: grid '%s' reaches %g %s, must stay below 65504", file->path,
                 grid->name, job.largest, grid_units[reader->grids[request->indices[0]]]);
}

static neph_result measure(const np_volume_file *file, size_t index, np_vdb_grid_size *out_size) {
  const np_vdb_request request = {.indices = &index, .count = 1};
  np_sparse_grid grid = {0};
  np_grid_extent extent;
  neph_result result = np_sparse_grid_init(file->context, "size", &grid);
  if (!result) result = read(file, &request, &grid, &out_size->tree_bytes);
  if (!result && !np_sparse_grid_measure(&grid, &extent))
    extent = (np_grid_extent){.min = {0, 0, 0}, .max = {-1, -1, -1}};
  if (!result) {
    memcpy(out_size->active_min, extent.min, sizeof extent.min);
    memcpy(out_size->active_max, extent.max, sizeof extent.max);
    out_size->active_voxel_count = np_sparse_grid_count_active(&grid);
  }
  np_sparse_grid_clear(&grid);
  return result;
}

/* OpenVDB's checks are for its own files. */
static neph_result diagnose(const np_volume_file *file, size_t index, void (*visit)(void *user, const char *text),
                            void *user) {
  (void)file, (void)index, (void)visit, (void)user;
  return NEPH_OK;
}

static neph_result mend(const np_volume_file *file, np_vdb_mending *mendings, const char *path) {
  (void)mendings, (void)path;
  return np_fail(file->context, NEPH_ERROR_UNSUPPORTED,
                 "%s: a NetCDF file is not repaired: nephos export writes a .vdb", file->path);
}

const np_volume_format np_netcdf_format = {
    .ending = ".nc",
    .has_magic = has_magic,
    .open = open_file,
    .close = close_file,
    .count = count_grids,
    .describe = describe,
    .visit_metadata = visit_metadata,
    .read = read,
    .measure = measure,
    .diagnose = diagnose,
    .mend = mend,
};

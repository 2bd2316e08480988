/* SPDX-License-Identifier: Apache-2.0 */
/* Variables of a model: packing, fill values, and reads of boxes. */
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"
#include "volume/model.h"

static neph_result fail(const np_model *model, const char *name, const np_netcdf_error *error) {
  if (error->result == NEPH_ERROR_CANCELLED) return error->result;
  if (!name) return np_fail(model->context, error->result, "%s: %s", model->path, error->message);
  return np_fail(model->context, error->result, "%s: variable '%s': %s", model->path, name, error->message);
}

void np_model_note(const np_model *model, neph_log_level level, const char *format, ...) {
  np_text text = {.context = model->context};
  va_list arguments;
  if (model->is_quiet) return;
  va_start(arguments, format);
  np_text_add_list(&text, format, arguments);
  va_end(arguments);
  np_log(model->context, level, "%s", np_text_get(&text));
  (void)np_text_end(&text, NEPH_OK);
}

/* ---- Descriptions ---- */

int np_model_search_variable(const np_model *model, const char *name) {
  np_netcdf_variable info;
  np_netcdf_error error;
  const int count = model->module->count(model->file);
  for (int i = 0; i < count; i++)
    if (!model->module->describe(model->file, i, &info, &error) && !strcmp(info.name, name)) return i;
  return -1;
}

static void read_fills(const np_model *model, np_model_variable *variable) {
  static const double never_written = 9.9692099683868690e+36; /* the library's own fill value of floats */
  static const char *const names[] = {"_FillValue", "missing_value"};
  for (size_t i = 0; i < sizeof names / sizeof *names; i++)
    if (model->module->read_number(model->file, variable->index, names[i], &variable->fills[variable->fill_count]))
      variable->fill_count++;
  variable->fills[variable->fill_count++] = never_written;
}

/* Reads a number by which values are packed, which stays where the file has none. */
static neph_result read_packing(const np_model *model, const np_model_variable *variable, const char *name,
                                double *number) {
  double read;
  char text[16] = "";
  if (model->module->read_number(model->file, variable->index, name, &read)) return *number = read, NEPH_OK;
  if (!model->module->read_text(model->file, variable->index, name, text, sizeof text)) return NEPH_OK;
  return np_fail(model->context, NEPH_ERROR_BAD_FILE, "%s: variable '%s' has the text '%s' as %s, must be a number",
                 model->path, variable->info.name, text, name);
}

/* Classic files mark integers without a sign by an attribute. */
static neph_result check_sign(const np_model *model, const np_model_variable *variable) {
  char text[8] = "";
  model->module->read_text(model->file, variable->index, "_Unsigned", text, sizeof text);
  if (strcmp(text, "true") != 0) return NEPH_OK;
  return np_fail(
      model->context, NEPH_ERROR_BAD_FILE,
      "%s: variable '%s' holds integers without a sign (_Unsigned is \"true\"), which are not read: store it "
      "as ushort or ubyte of NetCDF-4, or as float",
      model->path, variable->info.name);
}

neph_result np_model_describe_variable(const np_model *model, int index, np_model_variable *out) {
  np_netcdf_error error;
  neph_result result;
  *out = (np_model_variable){.index = index, .factor = 1.0};
  if (model->module->describe(model->file, index, &out->info, &error)) return fail(model, NULL, &error);
  if (!out->info.is_number)
    return np_fail(model->context, NEPH_ERROR_BAD_FILE, "%s: variable '%s' holds no numbers", model->path,
                   out->info.name);
  if (out->info.rank < 0)
    return np_fail(model->context, NEPH_ERROR_BAD_FILE, "%s: variable '%s' has more than %d dimensions", model->path,
                   out->info.name, (int)NP_NETCDF_RANK_MAX);
  model->module->read_text(model->file, index, "units", out->unit, sizeof out->unit);
  read_fills(model, out);
  result = read_packing(model, out, "scale_factor", &out->factor);
  if (!result) result = read_packing(model, out, "add_offset", &out->offset);
  if (result) return result;
  for (int d = 0; d < out->info.rank; d++) out->axes[d] = -1;
  if (isfinite(out->factor) && isfinite(out->offset) && out->factor != 0.0) return check_sign(model, out);
  return np_fail(model->context, NEPH_ERROR_BAD_FILE,
                 "%s: variable '%s' has scale_factor %g and add_offset %g, must have finite ones, and a factor other "
                 "than 0",
                 model->path, out->info.name, out->factor, out->offset);
}

neph_result np_model_name_dimension(const np_model *model, int dimension, char out_name[NP_NETCDF_NAME_BYTES]) {
  np_netcdf_error error;
  const neph_result result = model->module->name_dimension(model->file, dimension, out_name, &error);
  return result ? fail(model, NULL, &error) : NEPH_OK;
}

int np_model_search_dimension(const np_model *model, const np_model_variable *variable, const char *name) {
  char own[NP_NETCDF_NAME_BYTES];
  np_netcdf_error error;
  for (int d = 0; d < variable->info.rank; d++)
    if (!model->module->name_dimension(model->file, variable->info.dimensions[d], own, &error) && !strcmp(own, name))
      return variable->info.dimensions[d];
  return -1;
}

/* ---- Reading ---- */

static bool is_fill(const np_model_variable *variable, double stored) {
  for (int i = 0; i < variable->fill_count; i++) {
    const double fill = variable->fills[i];
    if (stored == fill || fabs(stored - fill) < 1e-6 * fabs(fill) || (isnan(stored) && isnan(fill))) return true;
  }
  return false;
}

/* A NaN that is no fill value becomes negative infinity. */
static double convert(const np_model_variable *variable, double stored) {
  if (is_fill(variable, stored)) return (double)NAN;
  return isnan(stored) ? -HUGE_VAL : variable->factor * stored + variable->offset;
}

neph_result np_model_read_line(const np_model *model, const np_model_variable *variable, double *out_values) {
  const size_t starts[1] = {0}, *counts = variable->info.sizes, count = counts[0];
  np_netcdf_error error;
  if (model->module->read(model->file, variable->index, starts, counts, out_values, &error))
    return fail(model, variable->info.name, &error);
  for (size_t i = 0; i < count; i++) out_values[i] = convert(variable, out_values[i]);
  return NEPH_OK;
}

/* Part of a variable that a box needs, and the distance between neighbours along each axis. */
typedef struct box_part {
  size_t starts[NP_NETCDF_RANK_MAX], counts[NP_NETCDF_RANK_MAX], count;
  ptrdiff_t strides[NP_MODEL_AXES], base;
} box_part;

/* Range of an axis in the file's order. */
static void get_range(const np_model *model, np_model_axis axis, np_model_rows rows, size_t level_count,
                      size_t *out_start, size_t *out_count) {
  *out_start = axis == NP_MODEL_T ? model->step : 0;
  *out_count = axis == NP_MODEL_Z ? level_count : axis == NP_MODEL_X ? model->sizes[NP_MODEL_X] : 1;
  if (axis != NP_MODEL_Y) return;
  *out_count = rows.count;
  *out_start = model->lines[0].is_reversed ? model->sizes[NP_MODEL_Y] - rows.begin - rows.count : rows.begin;
}

static bool is_reversed(const np_model *model, np_model_axis axis) {
  if (axis == NP_MODEL_Z) return model->are_levels_reversed;
  return (axis == NP_MODEL_Y && model->lines[0].is_reversed) || (axis == NP_MODEL_X && model->lines[1].is_reversed);
}

static box_part describe_part(const np_model *model, const np_model_variable *variable, np_model_rows rows,
                              size_t level_count) {
  box_part part = {.count = 1};
  for (int d = variable->info.rank - 1; d >= 0; d--) {
    part.starts[d] = 0;
    part.counts[d] = 1;
    if (variable->axes[d] < 0) continue;
    const np_model_axis axis = (np_model_axis)variable->axes[d];
    get_range(model, axis, rows, level_count, &part.starts[d], &part.counts[d]);
    part.strides[axis] = (ptrdiff_t)part.count;
    if (is_reversed(model, axis)) {
      part.base += (ptrdiff_t)(part.counts[d] - 1) * part.strides[axis];
      part.strides[axis] = -part.strides[axis];
    }
    part.count *= part.counts[d];
  }
  return part;
}

/* Adds what is read to the box, repeated along the axes that it lacks. */
static void add_part(const np_model *model, const np_model_variable *variable, const box_part *part,
                     const double *stored, np_model_rows rows, size_t level_count, double *out_values) {
  for (size_t y = 0; y < rows.count; y++)
    for (size_t x = 0; x < model->sizes[NP_MODEL_X]; x++) {
      const ptrdiff_t column =
          part->base + (ptrdiff_t)y * part->strides[NP_MODEL_Y] + (ptrdiff_t)x * part->strides[NP_MODEL_X];
      for (size_t z = 0; z < level_count; z++)
        *out_values++ += convert(variable, stored[column + (ptrdiff_t)z * part->strides[NP_MODEL_Z]]);
    }
}

static neph_result add_variable(const np_model *model, const np_model_variable *variable, np_model_rows rows,
                                size_t level_count, double *out_values) {
  const box_part part = describe_part(model, variable, rows, level_count);
  np_netcdf_error error;
  double *stored = np_alloc(model->context, part.count, sizeof *stored);
  if (!stored) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = model->module->read(model->file, variable->index, part.starts, part.counts, stored, &error);
  if (result)
    result = fail(model, variable->info.name, &error);
  else
    add_part(model, variable, &part, stored, rows, level_count, out_values);
  np_alloc_free(model->context, stored);
  return result;
}

neph_result np_model_read_field(const np_model *model, np_model_role role, np_model_rows rows, size_t level_count,
                                double *out_values) {
  const np_model_field *field = &model->fields[role];
  const size_t count = rows.count * model->sizes[NP_MODEL_X] * level_count;
  neph_result result = NEPH_OK;
  for (size_t i = 0; i < count; i++) out_values[i] = 0.0;
  for (int i = 0; i < field->count && !result; i++)
    result = add_variable(model, &field->parts[i], rows, level_count, out_values);
  return result;
}

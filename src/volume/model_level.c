/* SPDX-License-Identifier: Apache-2.0 */
/* Heights of a model's levels, column by column where they follow the terrain, and the lattice of voxels around them.
 */
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "volume/model.h"

enum { VOXELS_MAX = 1024 }; /* in a column, unless the settings state the spacing */

static size_t get_levels(const np_model *model) { return model->sizes[NP_MODEL_Z]; }

size_t np_model_get_slab(const np_model *model) {
  static const size_t values = (size_t)1 << 22, least = 8;
  const size_t row = (get_levels(model) + 1) * model->sizes[NP_MODEL_X], rows = values / row / least * least;
  const size_t whole = (model->sizes[NP_MODEL_Y] + least - 1) / least * least;
  if (rows > whole) return whole;
  return rows < least ? least : rows;
}

/* ---- Kinds of heights ---- */

static bool has_axis(const np_model_field *field, np_model_axis axis) {
  for (int i = 0; i < field->count; i++)
    for (int d = 0; d < field->parts[i].info.rank; d++)
      if (field->parts[i].axes[d] == (int)axis) return true;
  return false;
}

static size_t count_levels(const np_model_field *field) {
  for (int d = 0; d < field->parts[0].info.rank && field->count; d++)
    if (field->parts[0].axes[d] == NP_MODEL_Z) return field->parts[0].info.sizes[d];
  return 0;
}

/* Whether a field has all faces: one more than there are levels. */
static bool has_all_faces(const np_model *model) {
  return count_levels(&model->fields[NP_MODEL_FACE]) == get_levels(model) + 1;
}

static bool varies(const np_model_field *field) { return has_axis(field, NP_MODEL_X) || has_axis(field, NP_MODEL_Y); }

/* ---- One column ---- */

/* Heights of a column's levels, or of their faces. */
static neph_result check_ascending(const np_model *model, size_t count, const double *heights_m, size_t row,
                                   size_t column) {
  for (size_t k = 0; k < count; k++) {
    const bool is_finite = isfinite(heights_m[k]) && fabs(heights_m[k]) < 1e7;
    if (is_finite && (k == 0 || heights_m[k] > heights_m[k - 1])) continue;
    return np_fail(model->context, NEPH_ERROR_BAD_FILE,
                   "%s: heights of levels do not ascend: %.9g m is followed by %.9g m above level %zu at row %zu, "
                   "column %zu",
                   model->path, k ? heights_m[k - 1] : 0.0, heights_m[k], k ? k - 1 : 0, row, column);
  }
  return NEPH_OK;
}

/* Faces halfway between the levels; those at the ends as far from the level as the next. `faces_m` may begin at
 * `levels_m`. */
static void place_faces(size_t count, const double *levels_m, double *faces_m) {
  double below = levels_m[0] - 0.5 * (levels_m[1] - levels_m[0]);
  for (size_t k = 0; k < count; k++) {
    const double level = levels_m[k], next = k + 1 < count ? 0.5 * (level + levels_m[k + 1]) : 2.0 * level - below;
    faces_m[k] = below;
    below = next;
  }
  faces_m[count] = below;
}

/* Replaces faces by those that the file states below (or above) each level, where they lie between the levels. */
static void take_stated_faces(size_t count, const double *levels_m, const double *stated_m, double *faces_m) {
  bool are_below = true, are_above = true;
  for (size_t k = 0; k < count; k++) {
    are_below = are_below && stated_m[k] < levels_m[k] && (k == 0 || stated_m[k] > levels_m[k - 1]);
    are_above = are_above && stated_m[k] > levels_m[k] && (k + 1 == count || stated_m[k] < levels_m[k + 1]);
  }
  for (size_t k = 0; k < count && (are_below || are_above); k++) faces_m[k + !are_below] = stated_m[k];
  if (are_below)
    faces_m[count] = 2.0 * levels_m[count - 1] - stated_m[count - 1];
  else if (are_above)
    faces_m[0] = 2.0 * levels_m[0] - stated_m[0];
}

/* ---- Levels common to all columns ---- */

/* Reads the levels' own variable: heights, or pressures of the standard atmosphere. */
static neph_result read_level_variable(np_model *model, double *out_levels_m) {
  np_model_variable *variable = &model->level_variable;
  const np_model_unit length = {.length = 1}, pressure = {.mass = 1, .length = -1, .time = -2};
  np_model_unit unit = {.length = 0};
  char text[16];
  const char *otherwise = model->convention->length_unit;
  const bool is_known = np_model_apply_unit(variable, otherwise ? otherwise : "m", &unit);
  const bool is_pressure = is_known && np_model_unit_is_alike(&unit, &pressure);
  if (!is_pressure && !(is_known && np_model_unit_is_alike(&unit, &length)))
    return np_fail(model->context, NEPH_ERROR_BAD_FILE,
                   "%s: axis '%s' has units '%s', must be a length (m, km) or a pressure (Pa, hPa), unless a variable "
                   "of the heights of levels is there (standard_name altitude)",
                   model->path, variable->info.name, variable->unit);
  if (!variable->unit[0] && !otherwise)
    np_model_note(model, NEPH_LOG_WARNING, "%s: axis '%s' states no units: metres are assumed", model->path,
                  variable->info.name);
  const neph_result result = np_model_read_line(model, variable, out_levels_m);
  const bool is_down = !is_pressure &&
                       model->module->read_text(model->file, variable->index, "positive", text, sizeof text) &&
                       !strcmp(text, "down");
  for (size_t k = 0; k < get_levels(model) && !result; k++) {
    if (is_pressure) out_levels_m[k] = np_standard_altitude(out_levels_m[k]);
    if (is_down) out_levels_m[k] = -out_levels_m[k];
  }
  if (is_pressure)
    np_model_note(model, NEPH_LOG_WARNING,
                  "%s: levels are pressures: their heights are those of the standard atmosphere", model->path);
  return result;
}

static void reverse(double *values, size_t count) {
  for (size_t k = 0; k < count / 2; k++) {
    const double value = values[k];
    values[k] = values[count - 1 - k];
    values[count - 1 - k] = value;
  }
}

/* Sets the order of levels from those of one column, which then ascend. */
static void set_order(np_model *model, double *levels_m, size_t count) {
  model->are_levels_reversed = levels_m[count - 1] < levels_m[0];
  if (model->are_levels_reversed) reverse(levels_m, count);
}

/* Reads heights of the first column in the file's order. */
static neph_result read_first_column(const np_model *model, np_model_role role, size_t count, double *out_m) {
  const size_t columns = model->sizes[NP_MODEL_X];
  double *row = np_alloc(model->context, count * columns, sizeof *row);
  if (!row) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result = np_model_read_field(model, role, (np_model_rows){0, 1}, count, row);
  if (!result) memcpy(out_m, row, count * sizeof *row);
  np_alloc_free(model->context, row);
  return result;
}

static neph_result refuse_levels(const np_model *model) {
  return np_fail(model->context, NEPH_ERROR_BAD_FILE,
                 "%s: has no heights of the %zu levels of variable '%s': neither a variable by a known name nor a "
                 "standard_name altitude or height, nor two levels or more",
                 model->path, get_levels(model), model->fields[model->water].parts[0].info.name);
}

/* Sets the order of levels, and the faces of a column if all have the same. `scratch` has room for all faces twice. */
static neph_result place_common_faces(np_model *model, double *scratch, double *faces_m, bool *out_are_common) {
  const np_model_field *face = &model->fields[NP_MODEL_FACE], *height = &model->fields[NP_MODEL_HEIGHT];
  const size_t count = get_levels(model);
  const bool has_faces = has_all_faces(model);
  neph_result result;
  *out_are_common = !varies(has_faces ? face : height);
  if (has_faces) {
    result = read_first_column(model, NP_MODEL_FACE, count + 1, faces_m);
    if (!result) set_order(model, faces_m, count + 1);
    return result;
  }
  if (count < 2 || (!height->count && model->level_variable.index < 0)) return refuse_levels(model);
  result =
      height->count ? read_first_column(model, NP_MODEL_HEIGHT, count, scratch) : read_level_variable(model, scratch);
  if (result) return result;
  set_order(model, scratch, count);
  result = check_ascending(model, count, scratch, 0, 0);
  if (result) return result;
  place_faces(count, scratch, faces_m);
  if (!*out_are_common || varies(face) || count_levels(face) != count) return NEPH_OK;
  result = read_first_column(model, NP_MODEL_FACE, count, scratch + count + 1);
  if (!result) take_stated_faces(count, scratch, scratch + count + 1, faces_m);
  return result;
}

/* ---- Any column ---- */

neph_result np_model_read_faces(const np_model *model, np_model_rows rows, double *out_faces_m) {
  const size_t columns = model->sizes[NP_MODEL_X], levels = get_levels(model), faces = levels + 1;
  const bool has_faces = has_all_faces(model);
  neph_result result = NEPH_OK;
  if (!model->column_faces_m)
    result = np_model_read_field(model, has_faces ? NP_MODEL_FACE : NP_MODEL_HEIGHT, rows, has_faces ? faces : levels,
                                 out_faces_m);
  for (size_t i = rows.count * columns; i-- > 0 && !result;) {
    double *column = out_faces_m + i * faces;
    if (model->column_faces_m)
      memcpy(column, model->column_faces_m, faces * sizeof *column);
    else if (!has_faces) {
      memmove(column, out_faces_m + i * levels, levels * sizeof *column);
      result = check_ascending(model, levels, column, rows.begin + i / columns, i % columns);
      place_faces(levels, column, column);
    }
    if (!model->column_faces_m && !result)
      result = check_ascending(model, faces, column, rows.begin + i / columns, i % columns);
  }
  return result;
}

/* ---- Lattice ---- */

typedef struct height_range {
  double low_m, high_m, thinnest_m, thickest_m;
} height_range;

static void include_column(height_range *range, const double *faces_m, size_t levels) {
  range->low_m = fmin(range->low_m, faces_m[0]);
  range->high_m = fmax(range->high_m, faces_m[levels]);
  for (size_t k = 0; k < levels; k++) {
    range->thinnest_m = fmin(range->thinnest_m, faces_m[k + 1] - faces_m[k]);
    range->thickest_m = fmax(range->thickest_m, faces_m[k + 1] - faces_m[k]);
  }
}

static neph_result include_rows(const np_model *model, np_monitor *monitor, height_range *range) {
  const size_t faces = get_levels(model) + 1, columns = model->sizes[NP_MODEL_X], row_count = model->sizes[NP_MODEL_Y];
  const size_t slab = np_model_get_slab(model);
  double *heights_m = np_alloc(model->context, slab * faces * columns, sizeof *heights_m);
  neph_result result = heights_m ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t y = 0; y < row_count && !result; y += slab) {
    const np_model_rows rows = {y, row_count - y < slab ? row_count - y : slab};
    result = np_model_read_faces(model, rows, heights_m);
    for (size_t i = 0; i < rows.count * columns && !result; i++)
      include_column(range, heights_m + i * faces, faces - 1);
    if (!result && np_monitor_is_cancelled(monitor)) result = NEPH_ERROR_CANCELLED;
  }
  np_alloc_free(model->context, heights_m);
  return result;
}

static void place_lattice(np_model *model, const height_range *range) {
  const double spacing_m = model->settings.spacing_m, height_m = range->high_m - range->low_m;
  const bool is_even = model->column_faces_m && range->thickest_m - range->thinnest_m < 2e-3 * range->thickest_m;
  model->bottom_m = range->low_m;
  model->is_even = is_even && !(spacing_m > 0.0);
  model->level_count = get_levels(model);
  model->step_m = height_m / (double)model->level_count;
  if (model->is_even) return;
  model->step_m = spacing_m > 0.0 ? spacing_m : fmax(range->thinnest_m, height_m / VOXELS_MAX);
  model->level_count = (size_t)fmax(ceil(height_m / model->step_m - 1e-6), 1.0);
}

static neph_result check_lattice(const np_model *model) {
  if (model->level_count <= 1u << 16) return NEPH_OK;
  return np_fail(model->context, NEPH_ERROR_INVALID_ARGUMENT,
                 "%s: levels span %.4g m, which voxels of %.4g m divide into %zu, must be at most 65536: raise "
                 "clouds[].netcdf.spacing",
                 model->path, (double)model->level_count * model->step_m, model->step_m, model->level_count);
}

neph_result np_model_place_levels(np_model *model, np_monitor *monitor) {
  const size_t faces = get_levels(model) + 1;
  height_range range = {HUGE_VAL, -HUGE_VAL, HUGE_VAL, 0.0};
  bool are_common = false;
  double *scratch = np_alloc(model->context, 3 * faces, sizeof *scratch), *faces_m = scratch + 2 * faces;
  if (!scratch) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = place_common_faces(model, scratch, faces_m, &are_common);
  if (!result && are_common) {
    result = check_ascending(model, faces, faces_m, 0, 0);
    model->column_faces_m = np_alloc(model->context, faces, sizeof *faces_m);
    if (!result && !model->column_faces_m) result = NEPH_ERROR_OUT_OF_MEMORY;
    if (!result) memcpy(model->column_faces_m, faces_m, faces * sizeof *faces_m);
    include_column(&range, faces_m, faces - 1);
  } else if (!result)
    result = include_rows(model, monitor, &range);
  np_alloc_free(model->context, scratch);
  if (result) return result;
  place_lattice(model, &range);
  return check_lattice(model);
}

void np_model_clear_levels(np_model *model) {
  np_alloc_free(model->context, model->column_faces_m);
  model->column_faces_m = NULL;
}

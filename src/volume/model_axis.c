/* SPDX-License-Identifier: Apache-2.0 */
/* Axes of a model: what each dimension is along, and the positions along x and y. */
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"
#include "core/units.h"
#include "volume/model.h"

static const double planet_radius_m = 6371000.0;
static const char *const axis_names[NP_MODEL_AXES] = {"height", "y", "x", "time"};

/* ---- Which axis ---- */

typedef struct axis_mark {
  const char *attribute, *text;
  bool is_part; /* the text stands anywhere in the attribute */
  np_model_axis axis;
} axis_mark;

static const axis_mark marks[] = {
    {"axis", "X", false, NP_MODEL_X},
    {"axis", "Y", false, NP_MODEL_Y},
    {"axis", "Z", false, NP_MODEL_Z},
    {"axis", "T", false, NP_MODEL_T},
    {"positive", "up", false, NP_MODEL_Z},
    {"positive", "down", false, NP_MODEL_Z},
    {"standard_name", "projection_x_coordinate", false, NP_MODEL_X},
    {"standard_name", "longitude", true, NP_MODEL_X},
    {"standard_name", "projection_y_coordinate", false, NP_MODEL_Y},
    {"standard_name", "latitude", true, NP_MODEL_Y},
    {"standard_name", "height", true, NP_MODEL_Z},
    {"standard_name", "altitude", false, NP_MODEL_Z},
    {"standard_name", "air_pressure", false, NP_MODEL_Z},
    {"standard_name", "time", false, NP_MODEL_T},
    {"units", " since ", true, NP_MODEL_T},
    {"units", "degrees_east", false, NP_MODEL_X},
    {"units", "degrees_north", false, NP_MODEL_Y},
};

/* Axis that the attributes of a variable state; -1: none. */
static int get_stated_axis(const np_model *model, int variable) {
  char text[NP_NETCDF_NAME_BYTES];
  for (size_t i = 0; i < sizeof marks / sizeof *marks; i++) {
    if (!model->module->read_text(model->file, variable, marks[i].attribute, text, sizeof text)) continue;
    if (marks[i].is_part ? strstr(text, marks[i].text) != NULL : !strcmp(text, marks[i].text)) return marks[i].axis;
  }
  return -1;
}

/* Searches a variable of positions along a dimension alone: by a name, or, where it is NULL, by its attributes. */
static int search_positions(const np_model *model, int dimension, const char *name, int *out_axis) {
  np_netcdf_variable info;
  np_netcdf_error error;
  const int count = model->module->count(model->file);
  for (int i = 0; i < count; i++) {
    if (model->module->describe(model->file, i, &info, &error) || info.rank != 1 || !info.is_number) continue;
    if (info.dimensions[0] != dimension || (name && strcmp(info.name, name) != 0)) continue;
    if (!name) *out_axis = get_stated_axis(model, i);
    if (name || *out_axis >= 0) return i;
  }
  return -1;
}

/* Axis of a dimension, and the variable of its positions; -1: none. */
static int search_axis(const np_model *model, int dimension, const char *dimension_name, int *out_positions) {
  char name[NP_NETCDF_NAME_BYTES];
  for (int axis = 0; axis < NP_MODEL_AXES; axis++) {
    const char *names = model->convention->axes[axis];
    while (np_model_names_next(&names, name, sizeof name)) {
      *out_positions = search_positions(model, dimension, name, NULL);
      if (*out_positions >= 0) return axis;
    }
  }
  int axis = -1;
  *out_positions = search_positions(model, dimension, NULL, &axis);
  if (*out_positions >= 0) return axis;
  for (axis = 0; axis < NP_MODEL_AXES; axis++) {
    const char *names = model->convention->axes[axis];
    while (np_model_names_next(&names, name, sizeof name))
      if (!strcmp(name, dimension_name)) return axis;
  }
  return -1;
}

/* ---- Dimensions of the water ---- */

static neph_result refuse_dimension(const np_model *model, const np_model_variable *water, const char *dimension) {
  return np_fail(model->context, NEPH_ERROR_BAD_FILE,
                 "%s: dimension '%s' of variable '%s' is along neither height, y, x nor time: it needs a variable of "
                 "positions by a known name, or with an attribute axis, standard_name or positive",
                 model->path, dimension, water->info.name);
}

static neph_result place_dimension(np_model *model, np_model_variable *water, int d, int positions[NP_MODEL_AXES]) {
  char name[NP_NETCDF_NAME_BYTES];
  int variable = -1;
  const int dimension = water->info.dimensions[d];
  neph_result result = np_model_name_dimension(model, dimension, name);
  if (result) return result;
  const int axis = search_axis(model, dimension, name, &variable);
  if (axis < 0) return water->info.sizes[d] == 1 ? NEPH_OK : refuse_dimension(model, water, name);
  if (model->dimensions[axis] >= 0)
    return np_fail(model->context, NEPH_ERROR_BAD_FILE,
                   "%s: variable '%s' has two dimensions along %s, the second '%s'", model->path, water->info.name,
                   axis_names[axis], name);
  if (water->info.sizes[d] == 0)
    return np_fail(model->context, NEPH_ERROR_BAD_FILE, "%s: dimension '%s' of variable '%s' has length 0", model->path,
                   name, water->info.name);
  model->dimensions[axis] = dimension;
  model->sizes[axis] = water->info.sizes[d];
  water->axes[d] = axis;
  positions[axis] = variable;
  return NEPH_OK;
}

/* A damaged file may claim any size: what is stored unpacked or packed is far below the limit. */
static neph_result check_sizes(const np_model *model) {
  static const double edge_max = 1 << 20, values_free = 1 << 24, values_per_byte = 4096, values_max = 8e9;
  const double z = (double)model->sizes[NP_MODEL_Z], y = (double)model->sizes[NP_MODEL_Y],
               x = (double)model->sizes[NP_MODEL_X];
  const double limit = fmin(values_free + values_per_byte * (double)model->file_bytes, values_max);
  if (fmax(fmax(x, y), z) <= edge_max && x * y * z <= limit) return NEPH_OK;
  return np_fail(model->context, NEPH_ERROR_BAD_FILE,
                 "%s: variable '%s' is of %g x %g x %g values, more than a file of %.3g MB can hold or than 8e9",
                 model->path, model->fields[model->water].parts[0].info.name, x, y, z,
                 1e-6 * (double)model->file_bytes);
}

/* Sets the axes of the dimensions of a variable other than the water. Returns the first dimension that the water has
 * not; -1: it has all. */
static int match_axes(const np_model *model, np_model_role role, np_model_variable *variable) {
  const size_t levels = model->sizes[NP_MODEL_Z];
  for (int d = 0; d < variable->info.rank; d++) {
    for (int axis = 0; axis < NP_MODEL_AXES; axis++)
      if (variable->info.dimensions[d] == model->dimensions[axis]) variable->axes[d] = axis;
    const size_t size = variable->info.sizes[d];
    const bool may_be_face = role == NP_MODEL_FACE && (size == levels || size == levels + 1);
    if (variable->axes[d] < 0 && may_be_face) variable->axes[d] = NP_MODEL_Z;
    if (variable->axes[d] < 0 && size != 1) return variable->info.dimensions[d];
  }
  return -1;
}

static bool has_height(const np_model_variable *variable) {
  for (int d = 0; d < variable->info.rank; d++)
    if (variable->axes[d] == NP_MODEL_Z) return true;
  return false;
}

/* A field that is not on the levels of the water is left out, unless it is water itself. */
static neph_result match_part(np_model *model, np_model_role role, np_model_variable *variable) {
  const int stranger = match_axes(model, role, variable);
  if (stranger < 0 && has_height(variable)) return NEPH_OK;
  char name[NP_NETCDF_NAME_BYTES] = "";
  const neph_result result = stranger < 0 ? NEPH_OK : np_model_name_dimension(model, stranger, name);
  if (result) return result;
  const char *water = model->fields[model->water].parts[0].info.name, *meaning = np_model_role_rows[role].meaning;
  model->fields[role].count = 0;
  if (role == NP_MODEL_LIQUID || role == NP_MODEL_ICE)
    return np_fail(model->context, NEPH_ERROR_BAD_FILE,
                   "%s: variable '%s', the %s, must have the dimensions of '%s', which has no '%s'", model->path,
                   variable->info.name, meaning, water, name);
  if (stranger >= 0)
    np_model_note(model, NEPH_LOG_WARNING, "%s: variable '%s', the %s, is left out: its dimension '%s' is none of '%s'",
                  model->path, variable->info.name, meaning, name, water);
  return NEPH_OK;
}

/* ---- Positions ---- */

static double *read_positions(const np_model *model, const np_model_variable *variable, neph_result *out_result) {
  double *values = np_alloc(model->context, variable->info.sizes[0], sizeof *values);
  *out_result = values ? np_model_read_line(model, variable, values) : NEPH_ERROR_OUT_OF_MEMORY;
  return values;
}

/* Spacing of even positions. A float in kilometres has errors of centimetres. */
static neph_result measure_spacing(const np_model *model, const np_model_variable *variable, const double *values,
                                   bool is_angle, np_model_line *out) {
  const char *unit = is_angle ? "rad" : "m";
  const size_t count = variable->info.sizes[0];
  const double spacing = count > 1 ? (values[count - 1] - values[0]) / (double)(count - 1) : 0.0;
  for (size_t i = 0; i < count; i++)
    if (!isfinite(values[i]) || fabs(values[i]) > 1e9)
      return np_fail(model->context, NEPH_ERROR_BAD_FILE,
                     "%s: axis '%s' is %g at index %zu, must be a finite %s below 1e9 %s", model->path,
                     variable->info.name, values[i], i, is_angle ? "angle" : "length", unit);
  for (size_t i = 1; i < count; i++) {
    const double step = values[i] - values[i - 1];
    if (!(step * spacing > 0.0))
      return np_fail(model->context, NEPH_ERROR_BAD_FILE,
                     "%s: axis '%s' is not monotonic: %.9g %s at index %zu is followed by %.9g %s", model->path,
                     variable->info.name, values[i - 1], unit, i - 1, values[i], unit);
    if (fabs(step - spacing) > 0.02 * fabs(spacing))
      return np_fail(model->context, NEPH_ERROR_BAD_FILE,
                     "%s: axis '%s' is uneven: %.4g %s between indices %zu and %zu, %.4g %s in the mean; horizontal "
                     "spacing must be even",
                     model->path, variable->info.name, fabs(step), unit, i - 1, i, fabs(spacing), unit);
  }
  *out = (np_model_line){.spacing_m = fabs(spacing), .is_reversed = spacing < 0.0};
  out->first_m = spacing < 0.0 ? values[count - 1] : values[0];
  return NEPH_OK;
}

/* Longitudes across a meridian where they begin anew go on. */
static void unwrap_angles(double *values, size_t count) {
  for (size_t i = 1; i < count; i++) {
    const double turns = round((values[i] - values[i - 1]) / (2.0 * NP_PI));
    if (isfinite(turns)) values[i] -= 2.0 * NP_PI * turns;
  }
}

/* Reads an axis of lengths, or of angles, which stay radians. */
static neph_result read_axis(const np_model *model, int positions, np_model_line *out, bool *out_is_angle) {
  np_model_variable variable;
  np_model_unit unit = {.length = 1};
  neph_result result = np_model_describe_variable(model, positions, &variable);
  if (result) return result;
  const char *otherwise = model->convention->length_unit;
  const bool is_known = np_model_apply_unit(&variable, otherwise ? otherwise : "m", &unit);
  if (!variable.unit[0] && !otherwise)
    np_model_note(model, NEPH_LOG_WARNING, "%s: axis '%s' states no units: metres are assumed", model->path,
                  variable.info.name);
  const np_model_unit length = {.length = 1}, angle = {.angle = 1};
  *out_is_angle = is_known && np_model_unit_is_alike(&unit, &angle);
  if (!*out_is_angle && !(is_known && np_model_unit_is_alike(&unit, &length)))
    return np_fail(model->context, NEPH_ERROR_BAD_FILE,
                   "%s: axis '%s' has units '%s', must be a length (m, km) or an angle (degrees_east, degrees_north)",
                   model->path, variable.info.name, variable.unit);
  double *values = read_positions(model, &variable, &result);
  if (!result && *out_is_angle) unwrap_angles(values, variable.info.sizes[0]);
  if (!result) result = measure_spacing(model, &variable, values, *out_is_angle, out);
  np_alloc_free(model->context, values);
  return result;
}

/* A line without positions: the spacing is an attribute of the file. */
static neph_result read_spacing(const np_model *model, int line, np_model_line *out) {
  const char *attribute = model->convention->spacings[line];
  double spacing = 0.0;
  const bool has_spacing = attribute && model->module->read_number(model->file, -1, attribute, &spacing);
  if (has_spacing && spacing > 0.0 && spacing < 1e7) return *out = (np_model_line){.spacing_m = spacing}, NEPH_OK;
  return np_fail(model->context, NEPH_ERROR_BAD_FILE, "%s: has no positions along %s: neither a variable%s%s",
                 model->path, line == 0 ? "y" : "x",
                 attribute ? " nor a positive attribute " : " by a known name nor by its attributes",
                 attribute ? attribute : "");
}

/* Turns degrees into metres around the middle of the box. */
static void place_angles(np_model *model) {
  np_model_line *y = &model->lines[0], *x = &model->lines[1];
  const double rows = (double)(model->sizes[NP_MODEL_Y] - 1), columns = (double)(model->sizes[NP_MODEL_X] - 1);
  const double middle_rad = y->first_m + 0.5 * rows * y->spacing_m;
  y->spacing_m *= planet_radius_m;
  x->spacing_m *= planet_radius_m * cos(middle_rad);
  y->first_m = -0.5 * rows * y->spacing_m;
  x->first_m = -0.5 * columns * x->spacing_m;
  np_model_note(model, NEPH_LOG_INFO,
                "%s: degrees become metres around the middle of the box: %.4g m along x, %.4g m along y", model->path,
                x->spacing_m, y->spacing_m);
}

static neph_result place_lines(np_model *model, const int positions[NP_MODEL_AXES]) {
  static const np_model_axis axes[2] = {NP_MODEL_Y, NP_MODEL_X};
  bool are_angles[2] = {false, false};
  neph_result result = NEPH_OK;
  for (int i = 0; i < 2 && !result; i++) {
    if (model->dimensions[axes[i]] < 0) continue;
    result = positions[axes[i]] < 0 ? read_spacing(model, i, &model->lines[i])
                                    : read_axis(model, positions[axes[i]], &model->lines[i], &are_angles[i]);
  }
  if (result) return result;
  if (are_angles[0] != are_angles[1])
    return np_fail(model->context, NEPH_ERROR_BAD_FILE, "%s: one of x and y is in degrees, must be both or neither",
                   model->path);
  if (are_angles[0]) place_angles(model);
  for (int i = 0; i < 2; i++) /* a model of two dimensions is as deep as its cells are wide */
    if (!(model->lines[i].spacing_m > 0.0)) model->lines[i].spacing_m = model->lines[1 - i].spacing_m;
  if (model->lines[0].spacing_m > 0.0) return NEPH_OK;
  return np_fail(model->context, NEPH_ERROR_BAD_FILE, "%s: is one column of air, must have several along x or y",
                 model->path);
}

/* ---- Time ---- */

/* Step of the settings, from 1, held to those of the file. */
static neph_result choose_step(np_model *model) {
  const double count = (double)model->sizes[NP_MODEL_T], asked = nearbyint(model->settings.step);
  double step = asked;
  if (model->settings.beyond == NEPH_STEP_LOOP) step -= floor((asked - 1.0) / count) * count;
  if (model->settings.beyond == NEPH_STEP_HOLD) step = fmin(fmax(asked, 1.0), count);
  model->is_empty = (step < 1.0 || step > count) && model->settings.beyond == NEPH_STEP_EMPTY;
  if (model->is_empty)
    return np_model_note(model, NEPH_LOG_WARNING,
                         "%s: step %g is empty: the file has %g (clouds[].missing: hold or loop shows another)",
                         model->path, asked, count),
           NEPH_OK;
  if (!(step >= 1.0 && step <= count))
    return np_fail(model->context, NEPH_ERROR_INVALID_ARGUMENT, "%s: step %g is not there, must be within 1 to %g",
                   model->path, asked, count);
  model->step = (size_t)step - 1;
  return NEPH_OK;
}

/* ---- All ---- */

static neph_result match_fields(np_model *model) {
  neph_result result = NEPH_OK;
  for (int role = 0; role < NP_MODEL_ROLES; role++)
    for (int i = 0; i < model->fields[role].count && !result; i++)
      result = match_part(model, (np_model_role)role, &model->fields[role].parts[i]);
  return result;
}

neph_result np_model_place_axes(np_model *model) {
  np_model_variable *water = &model->fields[model->water].parts[0];
  int positions[NP_MODEL_AXES];
  neph_result result = NEPH_OK;
  for (int axis = 0; axis < NP_MODEL_AXES; axis++)
    model->dimensions[axis] = positions[axis] = -1, model->sizes[axis] = 1;
  for (int d = 0; d < water->info.rank && !result; d++) result = place_dimension(model, water, d, positions);
  if (!result && model->dimensions[NP_MODEL_Z] < 0)
    result = np_fail(model->context, NEPH_ERROR_BAD_FILE, "%s: variable '%s' has no dimension along height",
                     model->path, water->info.name);
  if (!result) result = check_sizes(model);
  if (!result) result = match_fields(model);
  if (!result) result = place_lines(model, positions);
  if (!result) result = choose_step(model);
  if (!result && positions[NP_MODEL_Z] >= 0)
    result = np_model_describe_variable(model, positions[NP_MODEL_Z], &model->level_variable);
  else
    model->level_variable.index = -1;
  return result;
}

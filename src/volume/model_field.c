/* SPDX-License-Identifier: Apache-2.0 */
/* Variables of each quantity: those that the settings name, those of a model's convention, or those whose standard name
 * of the CF conventions says so. */
#include <string.h>

#include "core/text.h"
#include "volume/model.h"

/* ---- Units ---- */

bool np_model_apply_unit(np_model_variable *variable, const char *otherwise, np_model_unit *out_unit) {
  const char *text = variable->unit[0] ? variable->unit : otherwise;
  if (!text || !np_model_unit_parse(text, out_unit)) return false;
  variable->factor *= out_unit->factor;
  variable->offset = out_unit->factor * variable->offset + out_unit->offset;
  return true;
}

/* Row of the role's units that a unit is alike to; -1: none. */
static int search_unit(np_model_role role, const np_model_unit *unit) {
  const np_model_role_unit *rows = np_model_role_rows[role].units;
  np_model_unit allowed;
  for (int i = 0; i < NP_MODEL_UNITS_MAX && rows[i].text; i++)
    if (np_model_unit_parse(rows[i].text, &allowed) && np_model_unit_is_alike(&allowed, unit)) return i;
  return -1;
}

static bool is_water(np_model_role role) { return role == NP_MODEL_LIQUID || role == NP_MODEL_ICE; }

/* Refuses a unit of water, or of what the settings name; warns of any other, which is left out. */
static neph_result refuse_unit(const np_model *model, np_model_role role, const np_model_variable *variable,
                               bool is_named) {
  const np_model_role_row *row = &np_model_role_rows[role];
  const char *unit = variable->unit[0] ? variable->unit : "no unit", *second = row->units[1].meaning;
  char short_unit[NP_MODEL_UNIT_BYTES];
  np_print_short(short_unit, sizeof short_unit, unit);
  if (is_water(role) || is_named)
    return np_fail(model->context, NEPH_ERROR_BAD_FILE, "%s: variable '%s', the %s, has units '%s', must be a %s%s%s",
                   model->path, variable->info.name, row->meaning, short_unit, row->units[0].meaning,
                   second ? " or a " : "", second ? second : "");
  np_model_note(model, NEPH_LOG_WARNING, "%s: variable '%s' is left out: its units '%s' are not a %s%s%s", model->path,
                variable->info.name, short_unit, row->units[0].meaning, second ? " or a " : "", second ? second : "");
  return NEPH_OK;
}

/* Brings a part of a field to SI; a field in an unknown unit becomes absent. */
static neph_result apply_role_unit(const np_model *model, np_model_role role, bool is_named, np_model_field *field) {
  const np_model_convention *convention = model->convention;
  np_model_variable *variable = &field->parts[field->count - 1];
  np_model_unit unit;
  const bool is_known = np_model_apply_unit(variable, is_named ? NULL : convention->units[role], &unit);
  field->unit = is_known ? search_unit(role, &unit) : -1;
  if (field->unit < 0) {
    const neph_result result = refuse_unit(model, role, variable, is_named);
    return field->count = 0, result;
  }
  if (!variable->unit[0] && (role == NP_MODEL_LIQUID || role == NP_MODEL_ICE))
    np_model_note(model, NEPH_LOG_WARNING, "%s: variable '%s', the %s, states no units: %s is assumed", model->path,
                  variable->info.name, np_model_role_rows[role].meaning, convention->units[role]);
  if (field->unit == 1 && (role == NP_MODEL_HEIGHT || role == NP_MODEL_FACE)) { /* geopotential */
    const double gravity_m_s2 = convention->gravity_m_s2 > 0.0 ? convention->gravity_m_s2 : 9.80665;
    variable->factor /= gravity_m_s2;
    variable->offset /= gravity_m_s2;
  }
  if (role == NP_MODEL_POTENTIAL_TEMPERATURE && !is_named)
    variable->offset += convention->potential_temperature_offset_k;
  return NEPH_OK;
}

/* ---- Search ---- */

static neph_result add_part(const np_model *model, np_model_role role, int index, bool is_named,
                            np_model_field *field) {
  const neph_result result = np_model_describe_variable(model, index, &field->parts[field->count]);
  if (result) return result;
  field->count++;
  return apply_role_unit(model, role, is_named, field);
}

/* Takes a variable, or the sum of two, "P+PB", if all of them are there. */
static neph_result take_name(const np_model *model, np_model_role role, char *name, np_model_field *field) {
  int indices[NP_MODEL_PARTS_MAX], count = 0;
  for (char *at = name; at && count < NP_MODEL_PARTS_MAX; count++) {
    char *plus = strchr(at, '+');
    if (plus) *plus = 0;
    indices[count] = np_model_search_variable(model, at);
    if (indices[count] < 0) return NEPH_OK;
    at = plus ? plus + 1 : NULL;
  }
  neph_result result = NEPH_OK;
  for (int i = 0; i < count && !result && field->count == i; i++)
    result = add_part(model, role, indices[i], false, field);
  return result;
}

static bool is_in_list(const char *list, const char *name) {
  char word[NP_NETCDF_NAME_BYTES];
  while (np_model_names_next(&list, word, sizeof word))
    if (!strcmp(word, name)) return true;
  return false;
}

/* Searches the variable of a standard name that has most dimensions; -1: none. */
static int search_standard_name(const np_model *model, np_model_role role) {
  const int count = model->module->count(model->file);
  int best = -1, best_rank = 0;
  char name[NP_NETCDF_NAME_BYTES];
  np_netcdf_variable info;
  np_netcdf_error error;
  for (int i = 0; i < count; i++) {
    if (!model->module->read_text(model->file, i, "standard_name", name, sizeof name)) continue;
    if (!is_in_list(np_model_role_rows[role].standard_names, name)) continue;
    if (model->module->describe(model->file, i, &info, &error) || info.rank <= best_rank) continue;
    best = i;
    best_rank = info.rank;
  }
  return best;
}

/* Name that the settings have for a role; NULL: none. */
static const char *get_setting(const np_model *model, np_model_role role) {
  const neph_volume_model *settings = &model->settings;
  if (role == NP_MODEL_LIQUID) return settings->variable;
  if (role == NP_MODEL_ICE) return settings->ice;
  if (role == NP_MODEL_LIQUID_RADIUS) return settings->radius;
  return role == NP_MODEL_NUMBER ? settings->number : NULL;
}

static neph_result take_setting(np_model *model, np_model_role role, const char *name) {
  const int index = np_model_search_variable(model, name);
  if (index >= 0) return add_part(model, role, index, true, &model->fields[role]);
  char short_name[80];
  np_print_short(short_name, sizeof short_name, name);
  return np_fail(model->context, NEPH_ERROR_BAD_FILE, "%s: has no variable '%s', which clouds[].netcdf names for %s",
                 model->path, short_name, np_model_role_rows[role].meaning);
}

static neph_result choose_role(np_model *model, np_model_role role) {
  np_model_field *field = &model->fields[role];
  const char *setting = get_setting(model, role), *names = model->convention->names[role];
  if (setting && !strcmp(setting, "none")) return NEPH_OK;
  if (setting) return take_setting(model, role, setting);
  char name[NP_NETCDF_NAME_BYTES];
  neph_result result = NEPH_OK;
  while (!result && !field->count && np_model_names_next(&names, name, sizeof name))
    result = take_name(model, role, name, field);
  if (result || field->count) return result;
  const int index = search_standard_name(model, role);
  return index < 0 ? NEPH_OK : add_part(model, role, index, false, field);
}

/* ---- Convention ---- */

static int search_names(const np_model *model, const char *names) {
  char name[NP_NETCDF_NAME_BYTES];
  int index = -1;
  while (index < 0 && np_model_names_next(&names, name, sizeof name)) index = np_model_search_variable(model, name);
  return index;
}

/* Whether an axis is there, as a variable or as a dimension of the water. */
static bool has_axis(const np_model *model, const np_model_variable *water, const char *names) {
  char name[NP_NETCDF_NAME_BYTES];
  while (np_model_names_next(&names, name, sizeof name))
    if (np_model_search_variable(model, name) >= 0 || np_model_search_dimension(model, water, name) >= 0) return true;
  return false;
}

static bool is_of_convention(const np_model *model, const np_model_convention *row) {
  np_model_variable water = {.index = search_names(model, row->names[NP_MODEL_LIQUID])};
  np_netcdf_error error;
  if (water.index < 0) water.index = search_names(model, row->names[NP_MODEL_ICE]);
  if (water.index < 0 || model->module->describe(model->file, water.index, &water.info, &error)) return false;
  return has_axis(model, &water, row->axes[NP_MODEL_Z]) && has_axis(model, &water, row->axes[NP_MODEL_Y]) &&
         has_axis(model, &water, row->axes[NP_MODEL_X]);
}

/* The last row holds for every file. */
static const np_model_convention *choose_convention(const np_model *model) {
  const size_t last = np_model_convention_count - 1;
  for (size_t i = 0; i < last; i++)
    if (is_of_convention(model, &np_model_conventions[i])) return &np_model_conventions[i];
  return &np_model_conventions[last];
}

static neph_result refuse_dry_file(const np_model *model) {
  np_text names = {.context = model->context};
  np_netcdf_variable info;
  np_netcdf_error error;
  const int count = model->module->count(model->file), shown = count < 24 ? count : 24;
  for (int i = 0; i < shown; i++)
    if (!model->module->describe(model->file, i, &info, &error))
      np_text_add(&names, "%s%.40s", i ? ", " : "", info.name);
  const neph_result result =
      np_fail(model->context, NEPH_ERROR_BAD_FILE,
              "%s: has no variable of liquid water or ice by the names of a known model or by a standard_name: "
              "clouds[].netcdf.variable names one of its variables (%s%s)",
              model->path, np_text_get(&names), count > shown ? ", …" : "");
  return np_text_end(&names, result);
}

neph_result np_model_choose_fields(np_model *model) {
  neph_result result = NEPH_OK;
  model->convention = choose_convention(model);
  for (int role = 0; role < NP_MODEL_ROLES && !result; role++) result = choose_role(model, (np_model_role)role);
  if (result) return result;
  model->water = model->fields[NP_MODEL_LIQUID].count ? NP_MODEL_LIQUID : NP_MODEL_ICE;
  return model->fields[model->water].count ? NEPH_OK : refuse_dry_file(model);
}

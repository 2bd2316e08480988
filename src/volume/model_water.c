/* SPDX-License-Identifier: Apache-2.0 */
/* Water and extinction of a model's levels: extinction = 3/2 · content / (density of water · effective radius), of
 * droplets and of ice alike. */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"
#include "core/units.h"
#include "volume/model.h"

static const double water_kg_m3 = 1000.0, ice_kg_m3 = 917.0;
static const double default_radius_m = 10e-6, default_ice_radius_m = 30e-6;
static const double radius_min_m = 2e-6, radius_max_m = 50e-6, ice_radius_max_m = 200e-6;
static const double reference_pa = 1e5, exponent_of_air = 0.2857; /* R/c_p */

enum { CONTENT_UNIT = 1, PER_MASS_UNIT = 1 };

/* Values of the fields of some rows; NULL: the file has none, or it is not needed. */
typedef struct level_values {
  const np_model *model;
  const double *faces_m;
  size_t count;
  double *fields[NP_MODEL_ROLES];
} level_values;

/* ---- Air ---- */

static bool has(const np_model *model, np_model_role role) { return model->fields[role].count > 0; }

static bool has_temperature(const np_model *model) {
  return has(model, NP_MODEL_TEMPERATURE) || has(model, NP_MODEL_POTENTIAL_TEMPERATURE);
}

static double get(const level_values *v, np_model_role role, size_t i) {
  return v->fields[role] ? v->fields[role][i] : (double)NAN;
}

static double get_altitude(const level_values *v, size_t i) {
  const size_t levels = v->model->sizes[NP_MODEL_Z], column = i / levels, k = i % levels;
  const double *faces_m = v->faces_m + column * (levels + 1);
  return 0.5 * (faces_m[k] + faces_m[k + 1]);
}

static double compute_temperature(const level_values *v, size_t i, double pressure_pa) {
  const double temperature = get(v, NP_MODEL_TEMPERATURE, i), potential = get(v, NP_MODEL_POTENTIAL_TEMPERATURE, i);
  if (temperature > 0.0 && isfinite(temperature)) return temperature;
  if (potential > 0.0 && isfinite(potential)) return potential * pow(pressure_pa / reference_pa, exponent_of_air);
  return np_standard_temperature(get_altitude(v, i));
}

static bool has_density(const level_values *v, size_t i) {
  const double density = get(v, NP_MODEL_DENSITY, i);
  return density > 0.0 && isfinite(density);
}

/* Density of the air that mixing ratios refer to: dry, or moist. */
static double compute_air_density(const level_values *v, size_t i) {
  static const double dry_to_vapour = 1.6078; /* gas constant of vapour to that of dry air */
  const double pressure = get(v, NP_MODEL_PRESSURE, i);
  const double vapour = get(v, NP_MODEL_VAPOUR, i), moisture = vapour > 0.0 && vapour < 0.2 ? vapour : 0.0;
  if (has_density(v, i)) return get(v, NP_MODEL_DENSITY, i);
  const double altitude_m = get_altitude(v, i),
               pressure_pa = pressure > 0.0 && isfinite(pressure) ? pressure : np_standard_pressure(altitude_m);
  const double dry = np_air_density(pressure_pa, compute_temperature(v, i, pressure_pa));
  const double share = v->model->convention->is_dry ? dry_to_vapour : dry_to_vapour - 1.0;
  return dry / (1.0 + share * moisture);
}

void np_model_describe_air(const np_model *model, char *out, size_t size) {
  const np_model_field *water = &model->fields[model->water];
  const char *source = "standard atmosphere";
  if (has(model, NP_MODEL_PRESSURE)) source = has_temperature(model) ? "pressure and temperature" : "pressure";
  if (has(model, NP_MODEL_DENSITY)) source = "density of air";
  if (water->unit == CONTENT_UNIT) source = "none needed";
  np_print(out, size, "%s", source);
}

/* ---- Size of particles ---- */

/* Martin, Johnson and Spice (1994): the cube of the volume radius is a share of the cube of the effective radius. */
static double compute_radius_of_number(const level_values *v, double content_kg_m3, double number_per_m3) {
  const double share = v->model->settings.dispersion;
  return cbrt(3.0 * content_kg_m3 / (4.0 * NP_PI * water_kg_m3 * share * number_per_m3));
}

static double get_number(const level_values *v, size_t i, double air_kg_m3) {
  const double constant = v->model->settings.number_per_m3, number = get(v, NP_MODEL_NUMBER, i);
  if (constant > 0.0) return constant;
  return v->model->fields[NP_MODEL_NUMBER].unit == PER_MASS_UNIT ? number * air_kg_m3 : number;
}

static double limit(double radius_m, double radius_max_m_here) {
  return fmin(fmax(radius_m, radius_min_m), radius_max_m_here);
}

static double compute_liquid_radius(const level_values *v, size_t i, double content_kg_m3, double air_kg_m3) {
  const double constant = v->model->settings.r_eff_m, radius = get(v, NP_MODEL_LIQUID_RADIUS, i);
  if (constant > 0.0) return constant;
  if (radius > 0.0) return limit(radius, radius_max_m);
  const double number = get_number(v, i, air_kg_m3);
  return number > 0.0 ? limit(compute_radius_of_number(v, content_kg_m3, number), radius_max_m) : default_radius_m;
}

static double compute_ice_radius(const level_values *v, size_t i) {
  const double constant = v->model->settings.ice_r_eff_m, radius = get(v, NP_MODEL_ICE_RADIUS, i);
  if (constant > 0.0) return constant;
  return radius > 0.0 ? limit(radius, ice_radius_max_m) : default_ice_radius_m;
}

void np_model_describe_radius(const np_model *model, np_model_role water, char *out, size_t size) {
  const bool is_ice = water == NP_MODEL_ICE;
  const double constant = is_ice ? model->settings.ice_r_eff_m : model->settings.r_eff_m;
  const np_model_role role = is_ice ? NP_MODEL_ICE_RADIUS : NP_MODEL_LIQUID_RADIUS;
  const double fallback = is_ice ? default_ice_radius_m : default_radius_m;
  if (!(constant > 0.0) && has(model, role))
    np_print_short(out, size, model->fields[role].parts[0].info.name);
  else if (!(constant > 0.0) && !is_ice && model->settings.number_per_m3 > 0.0)
    np_print(out, size, "%.4g droplets in a cm3", 1e-6 * model->settings.number_per_m3);
  else if (!(constant > 0.0) && !is_ice && has(model, NP_MODEL_NUMBER))
    np_print_short(out, size, model->fields[NP_MODEL_NUMBER].parts[0].info.name);
  else
    np_print(out, size, "%.4g um", 1e6 * (constant > 0.0 ? constant : fallback));
}

bool np_model_has_radii(const np_model *model) {
  const neph_volume_model *settings = &model->settings;
  const bool is_liquid_usual = !(settings->r_eff_m > 0.0) && !has(model, NP_MODEL_LIQUID_RADIUS) &&
                               !(settings->number_per_m3 > 0.0) && !has(model, NP_MODEL_NUMBER);
  return has(model, NP_MODEL_ICE) || (has(model, NP_MODEL_LIQUID) && !is_liquid_usual);
}

/* ---- Water ---- */

static double compute_content(const level_values *v, np_model_role water, size_t i, double air_kg_m3) {
  const double value = v->fields[water] ? v->fields[water][i] : 0.0;
  if (!(value > 0.0)) return 0.0;
  return v->model->fields[water].unit == CONTENT_UNIT ? value : value * air_kg_m3;
}

static double compute_value(const level_values *v, np_model_grid grid, size_t i) {
  const double liquid = get(v, NP_MODEL_LIQUID, i), ice = get(v, NP_MODEL_ICE, i);
  if (!(liquid > 0.0) && !(ice > 0.0)) return 0.0;
  const double air = compute_air_density(v, i);
  const double liquid_kg_m3 = compute_content(v, NP_MODEL_LIQUID, i, air);
  const double ice_kg_m3_here = compute_content(v, NP_MODEL_ICE, i, air);
  if (grid == NP_MODEL_LIQUID_WATER) return 1000.0 * liquid_kg_m3;
  if (grid == NP_MODEL_ICE_WATER) return 1000.0 * ice_kg_m3_here;
  if (grid == NP_MODEL_RADIUS) return 1e6 * 1.5 * (liquid_kg_m3 / water_kg_m3 + ice_kg_m3_here / ice_kg_m3);
  double sum = 0.0;
  if (liquid_kg_m3 > 0.0) sum += 1.5 * liquid_kg_m3 / (water_kg_m3 * compute_liquid_radius(v, i, liquid_kg_m3, air));
  if (ice_kg_m3_here > 0.0) sum += 1.5 * ice_kg_m3_here / (ice_kg_m3 * compute_ice_radius(v, i));
  return sum;
}

/* Counts a value of water whose stored radius is none, or beyond the limits. */
static void tally_radius(const level_values *v, np_model_role water, size_t i, np_water_tally *tally) {
  const bool is_ice = water == NP_MODEL_ICE;
  const np_model_role role = is_ice ? NP_MODEL_ICE_RADIUS : NP_MODEL_LIQUID_RADIUS;
  const double constant = is_ice ? v->model->settings.ice_r_eff_m : v->model->settings.r_eff_m;
  if (constant > 0.0 || !v->fields[role] || !v->fields[water] || !(v->fields[water][i] > 0.0)) return;
  const double radius = v->fields[role][i], content = v->fields[water][i];
  if (!(radius > 0.0))
    tally->sizeless_sum += content;
  else if (limit(radius, is_ice ? ice_radius_max_m : radius_max_m) != radius)
    tally->limited_sum += content;
}

/* ---- Fill values and NaN ---- */

typedef struct cell_place {
  size_t level, row, column;
} cell_place;

static cell_place get_place(const np_model *model, np_model_rows rows, size_t i) {
  const size_t levels = model->sizes[NP_MODEL_Z], columns = model->sizes[NP_MODEL_X];
  return (cell_place){i % levels, rows.begin + i / levels / columns, i / levels % columns};
}

static neph_result refuse_value(const level_values *v, np_model_role water, np_model_rows rows, size_t i) {
  const np_model *model = v->model;
  const cell_place at = get_place(model, rows, i);
  const double value = v->fields[water][i];
  char text[32];
  np_print(text, sizeof text, "%g", value);
  return np_fail(model->context, NEPH_ERROR_BAD_FILE,
                 "%s: variable '%s' is %s at level %zu, row %zu, column %zu, must be finite and below 1000 kg/kg or "
                 "kg/m3 (clouds[].import: repair takes it as 0)",
                 model->path, model->fields[water].parts[0].info.name, value < 0.0 ? "NaN or infinite" : text, at.level,
                 at.row, at.column);
}

/* Counts values, and takes fill values and negative ones as no water. Others that cannot be are refused or repaired. */
static neph_result tally_water(const level_values *v, np_model_role water, np_model_rows rows, np_water_tally *tally) {
  static const double largest = 1e3;
  double *values = v->fields[water];
  for (size_t i = 0; i < v->count && values; i++) {
    const bool is_invalid = isinf(values[i]) || values[i] > largest;
    if (is_invalid && v->model->policy != NEPH_IMPORT_REPAIR) return refuse_value(v, water, rows, i);
    tally->count++;
    tally->fill_count += isnan(values[i]);
    if (is_invalid) values[i] = 0.0;
    if (values[i] > 0.0) tally->sum += values[i];
    if (values[i] < 0.0) tally->negative_count++, tally->negative_sum -= values[i];
    if (!(values[i] > 0.0)) values[i] = 0.0;
  }
  return NEPH_OK;
}

/* A share of the water that is worth a warning. */
static const double share_to_warn_of = 1e-3;

static neph_log_level get_level(double sum, double all) {
  return sum > share_to_warn_of * all ? NEPH_LOG_WARNING : NEPH_LOG_INFO;
}

static void report_radii(const np_water_tally *tally, const np_model *model) {
  if (tally->sizeless_sum > 0.0)
    np_log(model->context, get_level(tally->sizeless_sum, tally->sum),
           "%s: %.2g of the water has no effective radius above 0: its droplets have that of their number, or %g um, "
           "and its ice %g um",
           model->path, tally->sizeless_sum / tally->sum, 1e6 * default_radius_m, 1e6 * default_ice_radius_m);
  if (tally->limited_sum > 0.0)
    np_log(model->context, get_level(tally->limited_sum, tally->sum),
           "%s: %.2g of the water has an effective radius beyond %g to %g um, of ice to %g um: it gets the nearest",
           model->path, tally->limited_sum / tally->sum, 1e6 * radius_min_m, 1e6 * radius_max_m,
           1e6 * ice_radius_max_m);
}

neph_result np_water_tally_report(const np_water_tally *tally, const np_model *model) {
  const char *name = model->fields[model->water].parts[0].info.name;
  if (tally->count && tally->fill_count == tally->count)
    return np_fail(model->context, NEPH_ERROR_BAD_FILE, "%s: variable '%s' holds fill values alone at step %zu",
                   model->path, name, model->step + 1);
  if (tally->fill_count)
    np_log(model->context, NEPH_LOG_INFO, "%s: %" PRIu64 " of %" PRIu64 " values of water are fill values: no water",
           model->path, tally->fill_count, tally->count);
  if (tally->negative_count)
    np_log(model->context, get_level(tally->negative_sum, tally->sum),
           "%s: %" PRIu64 " negative values of water, %.2g of its sum, are taken as 0", model->path,
           tally->negative_count, tally->sum > 0.0 ? tally->negative_sum / tally->sum : 1.0);
  if (tally->airless_count)
    np_log(model->context, NEPH_LOG_WARNING,
           "%s: variable '%s', the density of air, is not above 0 in %" PRIu64 " values with water: pressure and "
           "temperature, or else the standard atmosphere, are taken there",
           model->path, model->fields[NP_MODEL_DENSITY].parts[0].info.name, tally->airless_count);
  report_radii(tally, model);
  return NEPH_OK;
}

/* ---- Reading ---- */

/* Whether a grid needs a field. */
static bool needs(const np_model *model, np_model_grid grid, np_model_role role) {
  if (!has(model, role) || role == NP_MODEL_HEIGHT || role == NP_MODEL_FACE) return false;
  if (role == NP_MODEL_LIQUID) return grid != NP_MODEL_ICE_WATER;
  if (role == NP_MODEL_ICE) return grid != NP_MODEL_LIQUID_WATER;
  if (role == NP_MODEL_LIQUID_RADIUS || role == NP_MODEL_ICE_RADIUS || role == NP_MODEL_NUMBER)
    return grid == NP_MODEL_EXTINCTION;
  return true;
}

static neph_result read_fields(level_values *v, np_model_grid grid, np_model_rows rows) {
  neph_result result = NEPH_OK;
  for (int role = 0; role < NP_MODEL_ROLES && !result; role++) {
    if (!needs(v->model, grid, (np_model_role)role)) continue;
    v->fields[role] = np_alloc(v->model->context, v->count, sizeof **v->fields);
    result = v->fields[role] ? np_model_read_field(v->model, (np_model_role)role, rows, v->model->sizes[NP_MODEL_Z],
                                                   v->fields[role])
                             : NEPH_ERROR_OUT_OF_MEMORY;
  }
  return result;
}

neph_result np_model_read_water(const np_model *model, np_model_grid grid, np_model_rows rows, const double *faces_m,
                                double *out_values, np_water_tally *tally) {
  level_values v = {.model = model, .faces_m = faces_m};
  v.count = rows.count * model->sizes[NP_MODEL_X] * model->sizes[NP_MODEL_Z];
  neph_result result = read_fields(&v, grid, rows);
  if (!result) result = tally_water(&v, NP_MODEL_LIQUID, rows, tally);
  if (!result) result = tally_water(&v, NP_MODEL_ICE, rows, tally);
  for (size_t i = 0; i < v.count && !result; i++) {
    out_values[i] = compute_value(&v, grid, i);
    tally->airless_count += v.fields[NP_MODEL_DENSITY] && out_values[i] > 0.0 && !has_density(&v, i);
    tally_radius(&v, NP_MODEL_LIQUID, i, tally);
    tally_radius(&v, NP_MODEL_ICE, i, tally);
  }
  for (int role = 0; role < NP_MODEL_ROLES; role++) np_alloc_free(model->context, v.fields[role]);
  return result;
}

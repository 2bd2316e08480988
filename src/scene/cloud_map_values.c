/* SPDX-License-Identifier: Apache-2.0 */
/* Values of measured maps. A reflectance becomes the optical depth of the plane-parallel cloud that has it, over a
 * Lambertian ground and without air above: light that flows sideways, and shadows, are taken for depth. Tops that are
 * given by their temperature are those of a black body in a standard profile. */
#include "scene/cloud_map.h"

#include <math.h>

#include "core/units.h"
#include "optics/phase_bands.h"
#include "optics/slab_reflectance.h"

/* Tolerated noise of a reflectance around 0; a larger value than 2 is a percentage, or a count. */
static const double reflectance_low = -0.1, reflectance_high = 2.0;
static const double lapse_k_per_m = 0.0065, troposphere_m = 11000.0;
static const double mu_min = 0.02;
static const double contrast_min = 0.1; /* reflectance of the deepest cloud above the ground's */

typedef struct value_range {
  const char *quantity;
  double low, high;
  const char *hint;
} value_range;

static neph_result check_values(const np_map_conversion *c, const np_map_raster *raster, const value_range *range) {
  const size_t count = (size_t)raster->width * raster->height;
  size_t valid = 0;
  for (size_t i = 0; i < count; i++) {
    const double value = (double)raster->values[i];
    if (isnan(value)) continue;
    valid++;
    if (!(value >= range->low && value <= range->high))
      return np_fail(c->context, NEPH_ERROR_BAD_FILE, "%s: %s is %g in a pixel of the field, must be in [%g, %g]: %s",
                     c->path, range->quantity, value, range->low, range->high, range->hint);
  }
  if (valid > 0) return NEPH_OK;
  return np_fail(c->context, NEPH_ERROR_BAD_FILE, "%s: has no data in any of the %zu pixels of the field", c->path,
                 count);
}

/* ---- Reflectance ---- */

static neph_result get_sun(const np_map_conversion *c, const np_map_raster *raster, double out_rad[2]) {
  const bool is_given[2] = {c->map->has_elevation, c->map->has_azimuth};
  for (int i = 0; i < 2; i++)
    out_rad[i] = is_given[i] ? c->map->sun_rad[i] : raster->has_sun[i] ? raster->sun_rad[i] : (double)NAN;
  const bool needs_azimuth = c->map->view_rad[0] < 90 * NP_DEGREE - 1e-6;
  if (isnan(out_rad[0]) || (needs_azimuth && isnan(out_rad[1])))
    return np_fail(c->context, NEPH_ERROR_BAD_SCENE,
                   "%s.sun.%s is missing, and %s has no SUN_%s in its metadata: a reflectance needs the sun's place "
                   "when it was measured",
                   c->key, isnan(out_rad[0]) ? "elevation" : "azimuth", c->path,
                   isnan(out_rad[0]) ? "ELEVATION" : "AZIMUTH");
  if (sin(out_rad[0]) >= mu_min) return NEPH_OK;
  return np_fail(c->context, NEPH_ERROR_BAD_FILE, "%s: the sun's elevation is %g deg, must be at least 2 deg", c->path,
                 out_rad[0] / NP_DEGREE);
}

static neph_result make_table(const np_map_conversion *c, const double sun_rad[2], np_slab_table *out_table) {
  static const double reference_nm[NP_BAND_COUNT] = {680.0, 550.0, 440.0};
  const bool has_bands = np_phase_kind_has_bands(c->phase_source.kind);
  np_phase_table tabulated;
  np_phase_bands bands;
  np_phase phase = np_phase_make(&c->phase_source);
  neph_result result = NEPH_OK;
  if (c->phase_table) result = np_phase_table_load(c->context, c->phase_table, &tabulated);
  if (has_bands) result = np_phase_bands_build(c->context, NULL, &c->phase_source, reference_nm, &bands);
  if (result) return result;
  if (c->phase_table) phase = np_phase_tabulated(&tabulated);
  if (has_bands) phase = np_phase_of_bands(&bands);
  const double azimuth_rad = isnan(sun_rad[1]) ? 0.0 : c->map->view_rad[1] - sun_rad[1];
  const np_slab_view view = {.phase = &phase,
                             .albedo = c->albedo,
                             .ground_albedo = c->ground_albedo,
                             .mu_sun = sin(sun_rad[0]),
                             .mu_view = sin(c->map->view_rad[0]),
                             .azimuth_rad = azimuth_rad};
  result = np_slab_table_make(c->context, &view, out_table);
  if (c->phase_table) np_phase_table_clear(&tabulated);
  if (has_bands) np_phase_bands_clear(&bands);
  return result;
}

/* Checks the table. Over bright ground a thin cloud may reduce the reflectance, which has then two solutions: the
 * deeper cloud is used. */
static neph_result check_table(const np_map_conversion *c, const np_slab_table *table) {
  const double ground = table->reflectances[0], white = np_slab_table_eval(table, c->map->depth_max);
  double hidden = 0;
  for (int k = 1; k < NP_SLAB_DEPTHS; k++)
    if (table->reflectances[k] <= ground) hidden = table->depths[k];
  if (!(white >= ground + contrast_min) || hidden >= c->map->depth_max)
    return np_fail(c->context, NEPH_ERROR_BAD_SCENE,
                   "%s.ground_albedo is %g, and a cloud of optical depth %g has a reflectance of %.3g, which must be "
                   "higher by %g: over so bright a ground reflectances give no optical depth",
                   c->key, c->ground_albedo, c->map->depth_max, white, contrast_min);
  if (hidden > c->map->threshold)
    np_log(
        c->context, NEPH_LOG_WARNING,
        "%s: over a ground albedo of %g clouds of optical depths up to %.2g are no brighter than the ground, and are "
        "left clear",
        c->path, c->ground_albedo, hidden);
  return NEPH_OK;
}

static void warn_of_saturation(const np_map_conversion *c, const np_slab_table *table, size_t bright, size_t count,
                               double brightest) {
  const double limit = np_slab_table_eval(table, c->map->depth_max);
  const double sharp = np_slab_table_invert(table, limit - 0.02);
  if (bright == 0) return;
  np_log(c->context, NEPH_LOG_WARNING,
         "%s: %zu of %zu pixels, %.3g %%, are brighter than a plane cloud of optical depth %g, which has a reflectance "
         "of %.3g (the brightest %.3g): they get that depth; a reflectance lower by 0.02 is already a depth of %.3g",
         c->path, bright, count, 100.0 * (double)bright / (double)count, c->map->depth_max, limit, brightest, sharp);
}

static void convert_reflectances(const np_map_conversion *c, const np_slab_table *table, double factor,
                                 np_map_raster *raster) {
  const size_t count = (size_t)raster->width * raster->height;
  const double limit = np_slab_table_eval(table, c->map->depth_max);
  size_t bright = 0;
  double brightest = 0;
  for (size_t i = 0; i < count; i++) {
    const double value = factor * (double)raster->values[i];
    if (isnan(value)) continue;
    bright += value > limit;
    brightest = fmax(brightest, value);
    raster->values[i] = (float)fmin(np_slab_table_invert(table, value), c->map->depth_max);
  }
  warn_of_saturation(c, table, bright, count, brightest);
}

neph_result np_map_convert_depths(const np_map_conversion *c, np_map_raster *raster) {
  static const value_range depths = {"optical depth", 0.0, 1000.0, "check map.quantity and map.band"};
  const bool is_factor = c->map->quantity == NP_MAP_RADIANCE_FACTOR;
  const value_range reflectances = {is_factor ? "radiance factor" : "reflectance", reflectance_low, reflectance_high,
                                    "check map.quantity and map.band; percentages and counts need the file's scale and "
                                    "offset"};
  double sun_rad[2];
  np_slab_table table;
  if (c->map->quantity == NP_MAP_OPTICAL_DEPTH) return check_values(c, raster, &depths);
  neph_result result = check_values(c, raster, &reflectances);
  if (!result) result = get_sun(c, raster, sun_rad);
  if (!result) result = make_table(c, sun_rad, &table);
  if (!result) result = check_table(c, &table);
  if (!result) convert_reflectances(c, &table, is_factor ? 1.0 / sin(sun_rad[0]) : 1.0, raster);
  return result;
}

/* ---- Displacement ---- */

/* The sunlit flank of a deep cloud is its brightest: a picture of the cloud is moved towards the sun by the depth to
 * which light falls, the mean free path of transport H/x with x = (1 − g)·τ, times the tangent of the sun's zenith
 * angle; a thin cloud has no flanks, hence the factor (1 − e^{−x})². The sun is known: depths have been converted. */
void np_map_compute_displacement(const np_map_conversion *c, const np_map_raster *raster, double thickness_m,
                                 double out_m[2]) {
  static const double asymmetry = 0.85;
  const size_t count = (size_t)raster->width * raster->height;
  double sun_rad[2], sum = 0, cloudy = 0;
  out_m[0] = out_m[1] = 0;
  if (!np_map_is_displaced(c->map) || get_sun(c, raster, sun_rad)) return;
  for (size_t i = 0; i < count; i++) {
    const bool is_cloudy = (double)raster->values[i] >= c->map->threshold && raster->values[i] > 0;
    sum += is_cloudy ? (double)raster->values[i] : 0;
    cloudy += is_cloudy;
  }
  if (!(sum > 0)) return;
  const double x = (1 - asymmetry) * sum / cloudy, share = 1 - exp(-x);
  const double length_m = thickness_m * fmin(share * share / (x * tan(sun_rad[0])), NP_MAP_DISPLACEMENT_MAX);
  out_m[0] = length_m * sin(sun_rad[1]);
  out_m[1] = length_m * cos(sun_rad[1]);
}

/* ---- Tops ---- */

neph_result np_map_convert_tops(const np_map_conversion *c, np_map_raster *raster) {
  static const value_range heights = {"cloud-top height", -1000.0, 40000.0,
                                      "heights are in metres; check top.quantity"};
  static const value_range temperatures = {"brightness temperature", 150.0, 350.0,
                                           "temperatures are in kelvins; check top.quantity"};
  const bool is_height = c->map->top_quantity == NP_MAP_TOP_HEIGHT;
  const size_t count = (size_t)raster->width * raster->height;
  const neph_result result = check_values(c, raster, is_height ? &heights : &temperatures);
  size_t cold = 0;
  if (result || is_height) return result;
  for (size_t i = 0; i < count; i++) {
    const double height_m = (c->map->ground_temperature_k - (double)raster->values[i]) / lapse_k_per_m;
    cold += height_m > troposphere_m;
    raster->values[i] = isnan(height_m) ? NAN : (float)fmin(height_m, troposphere_m);
  }
  if (cold > 0)
    np_log(c->context, NEPH_LOG_WARNING,
           "%s: %zu of %zu pixels are colder than the standard profile's tropopause, %.1f K, and get its height, %g m",
           c->path, cold, count, c->map->ground_temperature_k - lapse_k_per_m * troposphere_m, troposphere_m);
  return NEPH_OK;
}

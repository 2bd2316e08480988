/* SPDX-License-Identifier: Apache-2.0 */
/* Tables of bands. Rows are finest where phase functions are: at the forward peak, whose rings are λ/2r wide, and at
 * the glory. Each kind is a row of `kinds`. */
#include "optics/phase_bands.h"

#include <assert.h>
#include <string.h>

#include "core/alloc.h"
#include "core/disk_cache.h"
#include "optics/ice_prism.h"
#include "optics/mie.h"
#include "optics/raindrop.h"
#include "optics/refraction.h"

enum { ROWS_MAX = 1 << 16 };

/* Angles of the rows, and values of each band at them. */
typedef struct phase_rows {
  unsigned count;
  double *angle_rad;
  double *value[NP_BAND_COUNT];
} phase_rows;

typedef struct phase_kind {
  bool has_bands;
  /* Size parameter, by which rows are spaced. */
  double (*get_size_parameter)(const np_phase_source *source, double wavelength_nm);
  neph_result (*fill)(neph_context *context, np_monitor *monitor, const np_phase_source *source, double wavelength_nm,
                      const phase_rows *rows, double *out_values);
} phase_kind;

/* ---- Kinds ---- */

static double get_mie_size(const np_phase_source *source, double wavelength_nm) {
  return 2.0 * NP_PI * source->effective_radius_m / (wavelength_nm * 1e-9);
}

static neph_result fill_mie(neph_context *context, np_monitor *monitor, const np_phase_source *source,
                            double wavelength_nm, const phase_rows *rows, double *out_values) {
  const np_mie_sizes sizes = {source->effective_radius_m, source->effective_variance};
  const np_refractive_index water = {np_refraction_get_water(wavelength_nm), 0.0};
  np_mie_efficiency mean;
  return np_mie_compute_phase(context, monitor, &sizes, wavelength_nm * 1e-9, water, rows->count, rows->angle_rad,
                              out_values, &mean);
}

static double get_rain_size(const np_phase_source *source, double wavelength_nm) {
  return NP_PI * source->mode_diameter_m / (wavelength_nm * 1e-9);
}

static neph_result fill_rain(neph_context *context, np_monitor *monitor, const np_phase_source *source,
                             double wavelength_nm, const phase_rows *rows, double *out_values) {
  (void)monitor;
  return np_raindrop_compute_phase(context, source->mode_diameter_m, wavelength_nm * 1e-9,
                                   np_refraction_get_water(wavelength_nm), rows->count, rows->angle_rad, out_values);
}

static double get_ice_size(const np_phase_source *source, double wavelength_nm) {
  (void)source;
  return 2.0 * NP_PI * np_ice_core_radius_m / (wavelength_nm * 1e-9);
}

static neph_result fill_ice(neph_context *context, np_monitor *monitor, const np_phase_source *source,
                            double wavelength_nm, const phase_rows *rows, double *out_values) {
  return np_ice_prism_compute_phase(context, monitor, source->habit, wavelength_nm * 1e-9,
                                    np_refraction_get_ice(wavelength_nm), rows->count, rows->angle_rad, out_values);
}

static const phase_kind kinds[NP_PHASE_COUNT] = {
    [NEPH_PHASE_MIE] = {true, get_mie_size, fill_mie},
    [NEPH_PHASE_RAIN] = {true, get_rain_size, fill_rain},
    [NEPH_PHASE_ICE] = {true, get_ice_size, fill_ice},
};

bool np_phase_kind_has_bands(neph_phase kind) { return kinds[kind].has_bands; }

/* ---- Rows ---- */

/* Step at an angle: a fraction of the rings there, never more than a fraction of the ripples between. */
static double compute_step(double angle_rad, double size_parameter) {
  const double end = fmin(angle_rad, NP_PI - angle_rad), most = fmin(0.1 * NP_DEGREE, 0.25 / size_parameter);
  const double least = angle_rad < 0.5 * NP_PI ? 0.1 / size_parameter : 0.25 / size_parameter;
  return fmin(fmax(least, 0.02 * end), fmax(most, 0.03 * NP_DEGREE));
}

/* Fills the angles, unless NULL; returns their number. */
static unsigned fill_angles(double size_parameter, double *out_rad) {
  unsigned count = 0;
  double angle = 0.0;
  for (; angle < NP_PI && count + 1 < ROWS_MAX; angle += compute_step(angle, size_parameter), count++)
    if (out_rad) out_rad[count] = angle;
  if (out_rad) out_rad[count] = NP_PI;
  return count + 1;
}

static neph_result allocate_rows(neph_context *context, double size_parameter, phase_rows *out) {
  out->count = fill_angles(size_parameter, NULL);
  out->angle_rad = np_alloc(context, (NP_BAND_COUNT + 1) * (size_t)out->count, sizeof *out->angle_rad);
  if (!out->angle_rad) return NEPH_ERROR_OUT_OF_MEMORY;
  for (int b = 0; b < NP_BAND_COUNT; b++) out->value[b] = out->angle_rad + (b + 1) * (size_t)out->count;
  fill_angles(size_parameter, out->angle_rad);
  return NEPH_OK;
}

static neph_result fill_rows(neph_context *context, np_monitor *monitor, const np_phase_source *source,
                             const double wavelength_nm[NP_BAND_COUNT], const phase_rows *rows) {
  neph_result result = NEPH_OK;
  for (int b = 0; b < NP_BAND_COUNT && !result; b++)
    result = kinds[source->kind].fill(context, monitor, source, wavelength_nm[b], rows, rows->value[b]);
  return result;
}

/* ---- Tables ---- */

/* Rows of a table: those whose versines differ in floats. */
typedef struct float_rows {
  unsigned count;
  float *versine, *value[NP_BAND_COUNT], *mean;
} float_rows;

static void round_rows(const phase_rows *rows, float_rows *out) {
  for (unsigned i = 0; i < rows->count; i++) {
    const double sine = sin(0.5 * rows->angle_rad[i]);
    const float versine = i + 1 == rows->count ? 2.0f : (float)(2.0 * sine * sine);
    const bool is_new = out->count == 0 || versine > out->versine[out->count - 1];
    if (!is_new) continue;
    out->versine[out->count] = versine;
    for (int b = 0; b < NP_BAND_COUNT; b++) out->value[b][out->count] = (float)rows->value[b][i];
    out->count++;
  }
}

static neph_result make_tables(neph_context *context, const float_rows *rows, np_phase_bands *out) {
  neph_result result = NEPH_OK;
  for (unsigned i = 0; i < rows->count; i++) rows->mean[i] = 0.0f;
  for (int b = 0; b < NP_BAND_COUNT && !result; b++) {
    double moments[3];
    result = np_phase_table_make(context, rows->count, rows->versine, rows->value[b], &out->band[b]);
    if (result) return result;
    np_phase_table_get_moments(&out->band[b], 3, moments);
    out->asymmetry[b] = (float)moments[1];
    out->second[b] = (float)moments[2];
    for (unsigned i = 0; i < rows->count; i++) rows->mean[i] += out->band[b].value[i] / (float)NP_BAND_COUNT;
  }
  return np_phase_table_make(context, rows->count, rows->versine, rows->mean, &out->mean);
}

static neph_result make_bands(neph_context *context, const phase_rows *rows, np_phase_bands *out) {
  float *block = np_alloc(context, (NP_BAND_COUNT + 2) * (size_t)rows->count, sizeof *block);
  if (!block) return NEPH_ERROR_OUT_OF_MEMORY;
  float_rows rounded = {.versine = block, .mean = block + rows->count};
  for (int b = 0; b < NP_BAND_COUNT; b++) rounded.value[b] = block + (b + 2) * (size_t)rows->count;
  round_rows(rows, &rounded);
  const neph_result result = make_tables(context, &rounded, out);
  np_alloc_free(context, block);
  return result;
}

/* ---- The disk cache ---- */

static const char cache_kind[] = "phase";

/* False: there is no cache. */
static bool compute_key(neph_context *context, const np_phase_source *source, const double wavelength_nm[NP_BAND_COUNT],
                        char out_key[33]) {
  if (!np_disk_cache_is_wanted(context)) return false;
  np_hash *key = np_hash_create(context);
  if (key) {
    np_cache_key_begin(context, cache_kind, false, key);
    NP_HASH_ADD(key, source->kind);
    NP_HASH_ADD(key, source->effective_radius_m);
    NP_HASH_ADD(key, source->effective_variance);
    NP_HASH_ADD(key, source->mode_diameter_m);
    NP_HASH_ADD(key, source->habit);
    np_hash_add(key, wavelength_nm, NP_BAND_COUNT * sizeof *wavelength_nm);
  }
  return !np_hash_finish(key, out_key);
}

static bool are_sound(const phase_rows *rows) {
  const size_t count = NP_BAND_COUNT * (size_t)rows->count;
  if (!np_cache_are_doubles_finite(rows->value[0], count)) return false;
  for (size_t i = 0; i < count; i++)
    if (!(rows->value[0][i] >= 0.0 && rows->value[0][i] <= 1e30)) return false;
  return true;
}

static bool load_rows(neph_context *context, const char *key, const phase_rows *rows) {
  np_cache_entry entry;
  uint32_t count;
  if (!np_cache_read_begin(context, cache_kind, key, &entry)) return false;
  if (NP_CACHE_READ(&entry, count) && np_cache_read_check(&entry, count == rows->count) &&
      np_cache_read(&entry, rows->value[0], NP_BAND_COUNT * (size_t)count * sizeof **rows->value))
    (void)np_cache_read_check(&entry, are_sound(rows));
  return np_cache_read_end(&entry);
}

static void save_rows(neph_context *context, const char *key, const phase_rows *rows) {
  np_cache_entry entry;
  const uint32_t count = rows->count;
  np_cache_write_begin(context, cache_kind, key, &entry);
  NP_CACHE_WRITE(&entry, count);
  np_cache_write(&entry, rows->value[0], NP_BAND_COUNT * (size_t)count * sizeof **rows->value);
  np_cache_write_commit(&entry);
}

static neph_result get_rows(neph_context *context, np_monitor *monitor, const np_phase_source *source,
                            const double wavelength_nm[NP_BAND_COUNT], const phase_rows *rows) {
  char key[33];
  const bool has_key = compute_key(context, source, wavelength_nm, key);
  if (has_key && load_rows(context, key, rows)) return NEPH_OK;
  const neph_result result = fill_rows(context, monitor, source, wavelength_nm, rows);
  if (!result && has_key) save_rows(context, key, rows);
  return result;
}

neph_result np_phase_bands_build(neph_context *context, np_monitor *monitor, const np_phase_source *source,
                                 const double wavelength_nm[NP_BAND_COUNT], np_phase_bands *out_bands) {
  assert(np_phase_kind_has_bands(source->kind));
  phase_rows rows;
  *out_bands = (np_phase_bands){.mean.context = context};
  for (int b = 0; b < NP_BAND_COUNT; b++) out_bands->band[b].context = context;
  memcpy(out_bands->wavelength_nm, wavelength_nm, sizeof out_bands->wavelength_nm);
  double shortest_nm = wavelength_nm[0];
  for (int b = 1; b < NP_BAND_COUNT; b++) shortest_nm = fmin(shortest_nm, wavelength_nm[b]);
  neph_result result = allocate_rows(context, kinds[source->kind].get_size_parameter(source, shortest_nm), &rows);
  if (result) return result;
  result = get_rows(context, monitor, source, wavelength_nm, &rows);
  if (!result) result = make_bands(context, &rows, out_bands);
  np_alloc_free(context, rows.angle_rad);
  if (result) np_phase_bands_clear(out_bands);
  return result;
}

void np_phase_bands_clear(np_phase_bands *bands) {
  np_phase_table_clear(&bands->mean);
  for (int b = 0; b < NP_BAND_COUNT; b++) np_phase_table_clear(&bands->band[b]);
}

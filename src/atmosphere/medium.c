/* SPDX-License-Identifier: Apache-2.0 */
/* Conversion of a description to a medium: layers, their phase functions, and the kinks of their profiles. */
#include "atmosphere/medium.h"

#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "optics/phase.h"

/* ---- Layers ---- */

static np_phase make_phase(const neph_atmosphere_layer *layer, int band) {
  return np_phase_make(&(np_phase_source){.kind = layer->phase,
                                          .asymmetry = layer->asymmetry[band],
                                          .forward = layer->asymmetry[band],
                                          .backward = layer->second_asymmetry[band],
                                          .backward_weight = layer->second_weight[band]});
}

/* Index of the aerosol with a phase function, added if it is new; −1: too many aerosols. */
static int get_aerosol(np_medium *medium, const np_phase *phase) {
  for (int i = 0; i < medium->aerosol_count; i++)
    if (np_phase_is_equal(&medium->aerosol[i].phase, phase)) return i;
  if (medium->aerosol_count == NP_AEROSOLS_MAX) return -1;
  np_aerosol *aerosol = &medium->aerosol[medium->aerosol_count];
  double moment[4];
  np_phase_get_moments(phase, 4, moment);
  *aerosol = (np_aerosol){.phase = *phase};
  for (int i = 0; i < 4; i++) aerosol->moment[i] = (float)moment[i];
  return medium->aerosol_count++;
}

static np_layer_part *get_part(np_layer *layer, int aerosol) {
  for (int i = 0; i < layer->part_count; i++)
    if (layer->part[i].aerosol == aerosol) return &layer->part[i];
  layer->part[layer->part_count] = (np_layer_part){aerosol, np_bands_grey(0.0f)};
  return &layer->part[layer->part_count++];
}

/* Assigns the scattering of each band to the aerosol with its phase function. False: too many aerosols. */
static bool assign_aerosols(np_medium *medium, np_layer *layer, const neph_atmosphere_layer *desc) {
  for (int band = 0; band < NP_BAND_COUNT; band++) {
    if (!(desc->scattering_per_m[band] > 0.0)) continue;
    const np_phase phase = make_phase(desc, band);
    const int aerosol = get_aerosol(medium, &phase);
    if (aerosol < 0) return false;
    get_part(layer, aerosol)->scattering[band] = (float)desc->scattering_per_m[band];
  }
  return true;
}

/* Altitude range of a layer: the feet of a tent, the rows of a table; all end at the top of the atmosphere. */
static void set_range(np_layer *layer, const neph_atmosphere_layer *desc, double top_m) {
  double low = -INFINITY, high = INFINITY;
  if (desc->profile == NEPH_LAYER_TENT) {
    low = desc->center_m - desc->width_m;
    high = desc->center_m + desc->width_m;
  } else if (desc->profile == NEPH_LAYER_TABLE) {
    low = desc->table_altitude_m[0];
    high = desc->table_altitude_m[desc->table_rows - 1];
  }
  layer->bottom_m = fmax(desc->bottom_m, low);
  layer->top_m = fmin(desc->top_m, high);
  if (layer->top_m >= top_m) layer->top_m = INFINITY;
  layer->bottom = (float)layer->bottom_m;
  layer->top = (float)layer->top_m;
}

/* Copies the rows of a table. */
static neph_result copy_rows(neph_context *context, np_layer *layer, const neph_atmosphere_layer *desc) {
  const size_t count = desc->table_rows;
  double *rows = np_alloc(context, 2 * count, sizeof *rows);
  if (!rows) return NEPH_ERROR_OUT_OF_MEMORY;
  memcpy(rows, desc->table_altitude_m, count * sizeof *rows);
  memcpy(rows + count, desc->table_density, count * sizeof *rows);
  layer->row_count = (int)count;
  layer->altitude_m = rows;
  layer->density = rows + count;
  return NEPH_OK;
}

static neph_result fill_layer(neph_context *context, np_medium *medium, const neph_atmosphere_layer *desc,
                              np_layer *out) {
  double extinction[NP_BAND_COUNT];
  for (int b = 0; b < NP_BAND_COUNT; b++) extinction[b] = desc->scattering_per_m[b] + desc->absorption_per_m[b];
  *out = (np_layer){.profile = desc->profile,
                    .height_m = desc->height_m,
                    .center_m = desc->center_m,
                    .width_m = desc->width_m,
                    .inverse_height = (float)(1.0 / desc->height_m),
                    .center = (float)desc->center_m,
                    .inverse_width = (float)(1.0 / desc->width_m),
                    .extinction = np_bands_from_doubles(extinction)};
  set_range(out, desc, medium->top_m);
  if (desc->phase == NEPH_PHASE_RAYLEIGH)
    out->rayleigh = np_bands_from_doubles(desc->scattering_per_m);
  else if (!assign_aerosols(medium, out, desc))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "atmosphere: the layers scatter by more than %d phase functions (each band of a layer may have its "
                   "own), must be at most that many besides Rayleigh's",
                   (int)NP_AEROSOLS_MAX);
  return desc->profile == NEPH_LAYER_TABLE ? copy_rows(context, out, desc) : NEPH_OK;
}

/* ---- Kinks ---- */

/* Adds an altitude at which a layer may have a kink, if there is air on both sides of it. */
static void add_kink(np_medium *medium, const np_layer *layer, double altitude_m) {
  if (!(altitude_m >= layer->bottom_m && altitude_m <= layer->top_m)) return;
  if (altitude_m > 0.0 && altitude_m < medium->top_m) medium->kink_m[medium->kink_count++] = altitude_m;
}

static void add_kinks(np_medium *medium, const np_layer *layer) {
  add_kink(medium, layer, layer->bottom_m);
  add_kink(medium, layer, layer->top_m);
  if (layer->profile == NEPH_LAYER_TENT) add_kink(medium, layer, layer->center_m);
  for (int i = 0; i < layer->row_count; i++) add_kink(medium, layer, layer->altitude_m[i]);
}

static int compare_altitudes(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static neph_result collect_kinks(neph_context *context, np_medium *medium) {
  size_t count = 0;
  for (int i = 0; i < medium->layer_count; i++) count += 3 + (size_t)medium->layers[i].row_count;
  medium->kink_m = np_alloc(context, count + 1, sizeof *medium->kink_m);
  if (!medium->kink_m) return NEPH_ERROR_OUT_OF_MEMORY;
  for (int i = 0; i < medium->layer_count; i++) add_kinks(medium, &medium->layers[i]);
  if (!medium->kink_count) return NEPH_OK;
  qsort(medium->kink_m, (size_t)medium->kink_count, sizeof *medium->kink_m, compare_altitudes);
  int kept = 1;
  for (int i = 1; i < medium->kink_count; i++)
    if (medium->kink_m[i] > medium->kink_m[kept - 1]) medium->kink_m[kept++] = medium->kink_m[i];
  medium->kink_count = kept;
  return NEPH_OK;
}

/* ---- Columns ---- */

/* Integral of an exponential's density between two altitudes within its range. */
static double integrate_exponential(const np_layer *layer, double low, double high) {
  const double begin = np_clamp(low, layer->bottom_m, layer->top_m),
               end = np_clamp(high, layer->bottom_m, layer->top_m);
  const double base = exp(-(begin - layer->bottom_m) / layer->height_m);
  return -layer->height_m * base * expm1(-(end - begin) / layer->height_m);
}

/* Integral of a layer's density from an altitude to the top, m. */
static double compute_column(const np_medium *medium, const np_layer *layer, double altitude_m) {
  if (layer->profile == NEPH_LAYER_EXPONENTIAL) return integrate_exponential(layer, altitude_m, medium->top_m);
  double column = 0.0, low = altitude_m;
  for (int i = 0; i <= medium->kink_count; i++) {
    const double high = i < medium->kink_count ? medium->kink_m[i] : medium->top_m;
    if (high <= low) continue;
    column += (high - low) * np_layer_density_exact(layer, 0.5 * (low + high));
    low = high;
  }
  return column;
}

np_bands np_aerosol_column(const np_medium *medium, int aerosol, double altitude_m) {
  np_bands column = np_bands_grey(0.0f);
  for (int i = 0; i < medium->layer_count; i++)
    for (int k = 0; k < medium->layers[i].part_count; k++)
      if (medium->layers[i].part[k].aerosol == aerosol)
        column += (float)compute_column(medium, &medium->layers[i], altitude_m) * medium->layers[i].part[k].scattering;
  return column;
}

/* Share of each aerosol in the vertical depth; equal shares in a band without aerosol scattering. */
static void share_depth(np_medium *medium) {
  np_bands total = np_bands_grey(0.0f);
  for (int i = 0; i < medium->aerosol_count; i++) {
    medium->aerosol[i].share = np_aerosol_column(medium, i, 0.0);
    total += medium->aerosol[i].share;
  }
  for (int i = 0; i < medium->aerosol_count; i++)
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      float *share = (float *)&medium->aerosol[i].share + b;
      *share = total[b] > 0.0f ? *share / total[b] : 1.0f / (float)medium->aerosol_count;
    }
}

/* ---- Media that need more accuracy ---- */

/* Vertical depth, and share of all scattering, from which forward scattering matters. */
static const float thick_depth = 0.02f, thick_part = 0.25f;

static float compute_maximum(np_bands value) { return np_maxf(value[0], np_maxf(value[1], value[2])); }

bool np_layer_has_profile_kinks(const np_layer *layer) {
  return compute_maximum(np_layer_scattering(layer)) > 0.0f &&
         (layer->profile != NEPH_LAYER_EXPONENTIAL || layer->bottom_m > 0.0 || isfinite(layer->top_m));
}

static void classify(np_medium *medium) {
  np_bands forward = np_bands_grey(0.0f), scattering = forward, depth = forward;
  for (int i = 0; i < medium->aerosol_count; i++)
    forward += np_maxf(medium->aerosol[i].moment[3], 0.0f) * np_aerosol_column(medium, i, 0.0);
  for (int i = 0; i < medium->layer_count; i++) {
    const np_layer *layer = &medium->layers[i];
    const float column = (float)compute_column(medium, layer, 0.0);
    depth += column * layer->extinction;
    scattering += column * np_layer_scattering(layer);
    medium->has_profile_kinks |= np_layer_has_profile_kinks(layer);
  }
  medium->needs_delta_scaling =
      compute_maximum(forward) > thick_depth || compute_maximum(forward - thick_part * scattering) > 0.0f;
  medium->is_opaque = compute_maximum(depth) > 1.0f;
}

/* ---- Creation ---- */

static neph_result fill(neph_context *context, np_medium *medium, const neph_atmosphere_desc *desc) {
  neph_result result = NEPH_OK;
  for (unsigned i = 0; !result && i < desc->layer_count; i++) {
    medium->layer_count = (int)i + 1;
    result = fill_layer(context, medium, &desc->layers[i], &medium->layers[i]);
  }
  if (!result) result = collect_kinks(context, medium);
  if (result) return result;
  share_depth(medium);
  classify(medium);
  return NEPH_OK;
}

neph_result np_medium_init(neph_context *context, const neph_atmosphere_desc *desc, np_medium *out_medium) {
  *out_medium = (np_medium){.planet_radius_m = desc->planet_radius_m,
                            .top_m = desc->top_altitude_m,
                            .ground_albedo = np_bands_from_doubles(desc->ground_albedo)};
  neph_result result = np_medium_check(context, desc);
  if (result) return result;
  out_medium->layers = np_alloc(context, (size_t)desc->layer_count + 1, sizeof *out_medium->layers);
  result = out_medium->layers ? fill(context, out_medium, desc) : NEPH_ERROR_OUT_OF_MEMORY;
  if (result) np_medium_free(context, out_medium);
  return result;
}

/* ---- Comparison ---- */

typedef struct medium_comparison {
  double worst;
  const char *what;
} medium_comparison;

static void compare_number(medium_comparison *c, const char *what, double a, double b) {
  if (a == b) return;
  const double size = fmax(fabs(a), fabs(b)), difference = isfinite(size) ? fabs(a - b) / size : (double)INFINITY;
  if (!(difference <= c->worst)) *c = (medium_comparison){difference, what};
}

static void compare_bands(medium_comparison *c, const char *what, np_bands a, np_bands b) {
  for (int i = 0; i < NP_BAND_COUNT; i++) compare_number(c, what, (double)a[i], (double)b[i]);
}

static void compare_layers(medium_comparison *c, const np_layer *a, const np_layer *b) {
  if (a->profile != b->profile || a->row_count != b->row_count || a->part_count != b->part_count) {
    *c = (medium_comparison){INFINITY, "the kind of a layer"};
    return;
  }
  const double heights[][2] = {{a->bottom_m, b->bottom_m},
                               {a->top_m, b->top_m},
                               {a->height_m, b->height_m},
                               {a->center_m, b->center_m},
                               {a->width_m, b->width_m}};
  for (size_t i = 0; i < sizeof heights / sizeof *heights; i++)
    compare_number(c, "the height of a layer", heights[i][0], heights[i][1]);
  for (int i = 0; i < a->row_count; i++) {
    compare_number(c, "the table of a layer", a->altitude_m[i], b->altitude_m[i]);
    compare_number(c, "the table of a layer", a->density[i], b->density[i]);
  }
  compare_bands(c, "the extinction of a layer", a->extinction, b->extinction);
  compare_bands(c, "the scattering of a layer", a->rayleigh, b->rayleigh);
  for (int i = 0; i < a->part_count; i++)
    compare_bands(c, "the scattering of a layer", a->part[i].scattering, b->part[i].scattering);
}

double np_medium_compare(const np_medium *a, const np_medium *b, const char **out_what) {
  medium_comparison c = {0.0, "nothing"};
  compare_number(&c, "the planet's radius", a->planet_radius_m, b->planet_radius_m);
  compare_number(&c, "the top of the air", a->top_m, b->top_m);
  compare_bands(&c, "the ground's albedo", a->ground_albedo, b->ground_albedo);
  if (a->layer_count != b->layer_count || a->aerosol_count != b->aerosol_count)
    c = (medium_comparison){INFINITY, "the number of layers"};
  else
    for (int i = 0; i < a->layer_count; i++) compare_layers(&c, &a->layers[i], &b->layers[i]);
  for (int i = 0; isfinite(c.worst) && i < a->aerosol_count; i++)
    if (memcmp(&a->aerosol[i].phase, &b->aerosol[i].phase, sizeof a->aerosol[i].phase) != 0)
      c = (medium_comparison){INFINITY, "an aerosol's phase function"};
  *out_what = c.what;
  return c.worst;
}

void np_medium_free(neph_context *context, np_medium *medium) {
  for (int i = 0; i < medium->layer_count; i++) np_alloc_free(context, medium->layers[i].altitude_m);
  np_alloc_free(context, medium->layers);
  np_alloc_free(context, medium->kink_m);
  *medium = (np_medium){0};
}

/* ---- Shells ---- */

/* Largest density of a layer between two altitudes. */
static double bound_density(const np_layer *layer, double low, double high) {
  low = fmax(low, layer->bottom_m);
  high = fmin(high, layer->top_m);
  if (low > high) return 0.0;
  double most = fmax(np_layer_density_exact(layer, low), np_layer_density_exact(layer, high));
  if (layer->profile == NEPH_LAYER_TENT && layer->center_m > low && layer->center_m < high) most = 1.0;
  for (int i = 0; i < layer->row_count; i++)
    if (layer->altitude_m[i] > low && layer->altitude_m[i] < high) most = fmax(most, layer->density[i]);
  return most;
}

/* Altitude of a shell's floor. Floors are at 0, 1, 2, 3, 4, 6, 8, 12, … 384 and 512 (the top) parts of 512 of the
 * atmosphere's height: fine at low altitude, for aerosol with a small scale height. */
static double floor_of_shell(const np_medium *medium, int shell) {
  const double step = medium->top_m / 512.0;
  if (shell < 4) return shell * step;
  return ldexp(shell % 2 ? 6.0 : 4.0, shell / 2 - 2) * step;
}

void np_air_shells_build(const np_medium *medium, np_air_shells *out) {
  for (int k = 0; k <= NP_AIR_SHELLS; k++) out->floor_m[k] = floor_of_shell(medium, k);
  for (int k = 0; k < NP_AIR_SHELLS; k++) {
    double extinction[NP_BAND_COUNT] = {0};
    for (int i = 0; i < medium->layer_count; i++) {
      const double density = bound_density(&medium->layers[i], out->floor_m[k], out->floor_m[k + 1]);
      for (int b = 0; b < NP_BAND_COUNT; b++) extinction[b] += density * (double)medium->layers[i].extinction[b];
    }
    /* Margin for the rounding of altitudes. */
    out->bound_per_m[k] = 1.000001 * fmax(extinction[0], fmax(extinction[1], extinction[2]));
  }
}

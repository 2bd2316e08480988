/* SPDX-License-Identifier: Apache-2.0 */
/* The air: its constituents by altitude, and their scattering.
 *
 * Layers of molecules, aerosol and absorbers: each is a density profile over altitude (Bruneton and Neyret 2008,
 * "Precomputed Atmospheric Scattering", section 2; ozone as a tent as in Hillaire 2020, "A Scalable and Production
 * Ready Sky and Atmosphere Rendering Technique", section 4) times coefficients in each band. Below sea level the air is
 * the same as at sea level.
 *
 * Molecules scatter by Rayleigh's phase function. Everything else is aerosol: layers, and bands of a layer, with equal
 * phase functions are one aerosol. With several, first-order light from a direction at an angle Θ with the sun is Σ
 * p_s(Θ)·I_s. Tables store one number in place of all I_s: the sum divided by a mean phase function p̄(Θ) = Σ w_s
 * p_s(Θ), with w_s the aerosol's share in the vertical depth. The quotient is I for one aerosol, and smooth in Θ for
 * several; the reader multiplies by p̄ again. */
#ifndef NP_ATMOSPHERE_MEDIUM_H
#define NP_ATMOSPHERE_MEDIUM_H

#include <math.h>
#include <nephos/atmosphere.h>
#include <stdbool.h>

#include "atmosphere/bands.h"
#include "core/context_private.h"
#include "core/math.h"
#include "core/units.h"
#include "optics/phase.h"

enum { NP_AEROSOLS_MAX = 6 };

/* Rayleigh's phase function, 3/(16π)·(1 + cos²θ). */
static inline float np_phase_rayleigh_eval(float cosine) {
  return (float)(3.0 / (16.0 * NP_PI)) * (1.0f + cosine * cosine);
}

/* Constituents with one phase function other than Rayleigh's. */
typedef struct np_aerosol {
  np_phase phase;
  float moment[4]; /* χ_0 = 1, χ_1, χ_2, χ_3 */
  np_bands share;  /* share in the vertical scattering depth of all aerosols; sums to 1 in every band */
} np_aerosol;

/* Bands of a layer that scatter by one aerosol's phase function. */
typedef struct np_layer_part {
  int aerosol;
  np_bands scattering;
} np_layer_part;

typedef struct np_layer {
  neph_layer_profile profile;
  double bottom_m, top_m, height_m, center_m, width_m;
  float bottom, top, inverse_height, center, inverse_width; /* density profile in single precision, for tables */
  int row_count;
  double *altitude_m, *density;
  np_bands extinction, rayleigh; /* 1/m at density 1 */
  int part_count;
  np_layer_part part[NP_BAND_COUNT];
} np_layer;

typedef struct np_medium {
  double planet_radius_m, top_m;
  np_bands ground_albedo;
  int layer_count, kink_count, aerosol_count;
  np_layer *layers; /* owned, with their tables */
  double *kink_m;   /* ascending altitudes of kinks and steps of profiles, without sea level and the top */
  np_aerosol aerosol[NP_AEROSOLS_MAX];
  bool has_profile_kinks;   /* layers with kinks scatter: a quadrature that ignores the kinks may miss them */
  bool needs_delta_scaling; /* forward scattering is too strong for moments of degree 2 */
  bool is_opaque;           /* vertical depth above 1 in some band */
} np_medium;

/* Checks a description and creates its medium. On failure there is nothing to free. */
neph_result np_medium_init(neph_context *context, const neph_atmosphere_desc *desc, np_medium *out_medium);
void np_medium_free(neph_context *context, np_medium *medium);

/* Largest relative difference of a parameter of two media, with its name; infinite if they differ in structure. */
double np_medium_compare(const np_medium *a, const np_medium *b, const char **out_what);

/* Whether a layer scatters and its profile is not a plain exponential. */
bool np_layer_has_profile_kinks(const np_layer *layer);

/* Scattering depth of one aerosol above an altitude. */
np_bands np_aerosol_column(const np_medium *medium, int aerosol, double altitude_m);

/* Density of a tabulated profile at an altitude within its rows. */
static inline double np_layer_table_density(const np_layer *layer, double altitude_m) {
  int low = 0, high = layer->row_count - 1;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    *(altitude_m < layer->altitude_m[middle] ? &high : &low) = middle;
  }
  const double step = layer->altitude_m[high] - layer->altitude_m[low];
  return layer->density[low] +
         (altitude_m - layer->altitude_m[low]) / step * (layer->density[high] - layer->density[low]);
}

/* Density at an altitude h ≥ 0. */
static inline float np_layer_density(const np_layer *layer, float h) {
  if (!(h >= layer->bottom && h <= layer->top)) return 0.0f;
  switch (layer->profile) {
  case NEPH_LAYER_EXPONENTIAL:
    return expf(-(h - layer->bottom) * layer->inverse_height);
  case NEPH_LAYER_TENT:
    return np_maxf(0.0f, 1.0f - fabsf(h - layer->center) * layer->inverse_width);
  case NEPH_LAYER_TABLE:
    return (float)np_layer_table_density(layer, (double)h);
  }
  return 0.0f;
}

/* Density at an altitude h ≥ 0, in double precision. */
static inline double np_layer_density_exact(const np_layer *layer, double h) {
  if (!(h >= layer->bottom_m && h <= layer->top_m)) return 0.0;
  switch (layer->profile) {
  case NEPH_LAYER_EXPONENTIAL:
    return exp(-(h - layer->bottom_m) / layer->height_m);
  case NEPH_LAYER_TENT:
    return fmax(0.0, 1.0 - fabs(h - layer->center_m) / layer->width_m);
  case NEPH_LAYER_TABLE:
    return np_layer_table_density(layer, h);
  }
  return 0.0;
}

/* Extinction at one altitude, 1/m. */
static inline np_bands np_extinction_at(const np_medium *medium, double altitude_m) {
  const float h = np_maxf((float)altitude_m, 0.0f);
  np_bands extinction = np_bands_grey(0.0f);
  for (int i = 0; i < medium->layer_count; i++)
    extinction += np_layer_density(&medium->layers[i], h) * medium->layers[i].extinction;
  return extinction;
}

/* np_layer_density at four altitudes, one in each lane. */
static inline np_bands np_layer_densities(const np_layer *layer, np_bands h) {
  np_bands density = np_bands_grey(0.0f);
  switch (layer->profile) {
  case NEPH_LAYER_EXPONENTIAL:
    density = np_bands_exp((layer->bottom - h) * layer->inverse_height);
    break;
  case NEPH_LAYER_TENT:
    density = 1.0f - np_bands_max(h - layer->center, layer->center - h) * layer->inverse_width;
    density = np_bands_max(density, np_bands_grey(0.0f));
    break;
  case NEPH_LAYER_TABLE:
    for (int i = 0; i < 4; i++) density[i] = np_layer_density(layer, h[i]);
    break;
  }
  return np_bands_select((h >= layer->bottom) & (h <= layer->top), density, np_bands_grey(0.0f));
}

/* Extinction at four altitudes, 1/m. */
static inline void np_extinction_at_four(const np_medium *medium, np_bands altitude_m, np_bands out[4]) {
  const np_bands h = np_bands_max(altitude_m, np_bands_grey(0.0f));
  for (int k = 0; k < 4; k++) out[k] = np_bands_grey(0.0f);
  for (int i = 0; i < medium->layer_count; i++) {
    const np_bands density = np_layer_densities(&medium->layers[i], h);
    for (int k = 0; k < 4; k++) out[k] += density[k] * medium->layers[i].extinction;
  }
}

/* Scattering coefficient of a layer at density 1. */
static inline np_bands np_layer_scattering(const np_layer *layer) {
  np_bands scattering = layer->rayleigh;
  for (int k = 0; k < layer->part_count; k++) scattering += layer->part[k].scattering;
  return scattering;
}

/* Scattering coefficients at one altitude, 1/m; entries of `aerosol` beyond the medium's are not set. */
typedef struct np_scattering {
  np_bands rayleigh, aerosol[NP_AEROSOLS_MAX];
} np_scattering;

static inline void np_scattering_at(const np_medium *medium, double altitude_m, np_scattering *out) {
  const float h = np_maxf((float)altitude_m, 0.0f);
  out->rayleigh = np_bands_grey(0.0f);
  for (int i = 0; i < medium->aerosol_count; i++) out->aerosol[i] = np_bands_grey(0.0f);
  for (int i = 0; i < medium->layer_count; i++) {
    const np_layer *layer = &medium->layers[i];
    const float density = np_layer_density(layer, h);
    out->rayleigh += density * layer->rayleigh;
    for (int k = 0; k < layer->part_count; k++)
      out->aerosol[layer->part[k].aerosol] += density * layer->part[k].scattering;
  }
}

/* Scattering of all aerosols, weighted by the moment χ_k; k = 0 is the plain sum. */
static inline np_bands np_aerosol_sum(const np_medium *medium, const np_scattering *air, int k) {
  np_bands sum = np_bands_grey(0.0f);
  for (int i = 0; i < medium->aerosol_count; i++) sum += medium->aerosol[i].moment[k] * air->aerosol[i];
  return sum;
}

/* Mean phase function p̄ of the aerosols, the divisor of their first-order light in tables. */
static inline np_bands np_aerosol_phase(const np_medium *medium, float versine) {
  np_bands sum = np_bands_grey(0.0f);
  for (int i = 0; i < medium->aerosol_count; i++)
    sum += np_phase_eval(&medium->aerosol[i].phase, versine) * medium->aerosol[i].share;
  return sum;
}

/* Σ p_s(Θ)·σ_s / p̄(Θ): first-order scattering of the aerosols per unit of p̄. */
static inline np_bands np_aerosol_peak(const np_medium *medium, const np_scattering *air, float versine) {
  if (medium->aerosol_count == 1) return air->aerosol[0];
  np_bands light = np_bands_grey(0.0f), mean = np_bands_grey(1e-20f);
  for (int i = 0; i < medium->aerosol_count; i++) {
    const float phase = np_phase_eval(&medium->aerosol[i].phase, versine);
    light += phase * air->aerosol[i];
    mean += phase * medium->aerosol[i].share;
  }
  return light / mean;
}

/* Relative rms error of the tables: default and allowed range. */
#define NP_SKY_TOLERANCE_DEFAULT 0.007
#define NP_SKY_TOLERANCE_MIN 0.003
#define NP_SKY_TOLERANCE_MAX 0.1

/* Checks that every parameter of a description is in range; if not, the message names the parameter and its range. */
neph_result np_medium_check(neph_context *context, const neph_atmosphere_desc *desc);

/* ---- Bounds of the extinction, for tracking paths through the air (air_flight.h) ---- */

enum { NP_AIR_SHELLS = 18 };

/* Shells of altitude, the lowest from sea level down, with the largest extinction of any band in each, 1/m. */
typedef struct np_air_shells {
  double floor_m[NP_AIR_SHELLS + 1], bound_per_m[NP_AIR_SHELLS];
} np_air_shells;

void np_air_shells_build(const np_medium *medium, np_air_shells *out_shells);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Phase functions: eval, sample, pdf, moments. In 1/sr, with the integral one over the sphere. */
#ifndef NP_OPTICS_PHASE_H
#define NP_OPTICS_PHASE_H

#include <math.h>

#include <nephos/phase.h>

#include "core/math.h"
#include "core/spectrum.h"
#include "core/units.h"
#include "optics/phase_table.h"

/* All phase functions but tables are mixtures of up to three Draine lobes (Draine 2003, "Scattering by Interstellar
 * Dust Grains", eq. 4): α = 0 is Henyey-Greenstein, g = 0 and α = 1 is Rayleigh, α = 1 is Cornette-Shanks. */
typedef struct np_phase_lobe {
  float asymmetry; /* g, −1 < g < 1 */
  float alpha;     /* ≥ 0 */
} np_phase_lobe;

/* Tables of three bands at the same angles, and of their mean (optics/phase_bands.h). */
typedef struct np_phase_bands {
  double wavelength_nm[NP_BAND_COUNT];
  np_phase_table mean, band[NP_BAND_COUNT];
  float asymmetry[NP_BAND_COUNT], second[NP_BAND_COUNT]; /* Legendre moments χ₁ and χ₂ of each band */
} np_phase_bands;

enum { NP_PHASE_LOBES = 3 };

typedef struct np_phase {
  np_phase_lobe lobe[NP_PHASE_LOBES];
  float weight;                /* weight of lobe[1] against lobe[0], 0 to 1; 0 for a single lobe */
  float third_weight;          /* weight of lobe[2] against the others, 0 to 1; 0: two lobes at most */
  const np_phase_table *table; /* borrowed; NULL: lobes alone */
  float table_weight;          /* weight of the table against the lobes, 0 to 1 */
  const np_phase_bands *bands; /* borrowed; tables of each band, whose mean is `table`; NULL: all bands have one */
} np_phase;

np_phase np_phase_isotropic(void);
np_phase np_phase_rayleigh(void);
np_phase np_phase_henyey_greenstein(float g);
np_phase np_phase_two_lobe(float g_forward, float g_backward, float weight_backward);
np_phase np_phase_cornette_shanks(float g);

/* Haze: three Henyey-Greenstein lobes whose mean cosine is g, 0.5 to 0.95. The narrow ones, of g 0.93 and 0.985 in
 * shares of 48 and 5 %, are the aureole of particles from half a micrometre up; the broad one takes the rest of g. */
#define NP_PHASE_HAZE_MIN 0.5
#define NP_PHASE_HAZE_MAX 0.95
np_phase np_phase_haze(double g);

np_phase np_phase_draine(float g, float alpha);

/* Phase function of a table, which must outlive it. */
np_phase np_phase_tabulated(const np_phase_table *table);

/* Water droplets by diameter, 5e-6 ≤ diameter_m ≤ 50e-6: HG + Draine fit to Mie theory (Jendersie and d'Eon 2023,
 * "An Approximate Mie Scattering Function for Fog and Cloud Rendering", eqs. 4 to 7). */
np_phase np_phase_droplets(double diameter_m);

/* D(μ) = (1/4π)·(1−g²)/(1+g²−2gμ)^1.5·(1+αμ²)/(1+α(1+2g²)/3), with 1+g²−2gμ written as (1−g)² + 2g·versine, which
 * cancels nowhere for g > 0. A lobe with g < 0 is the mirror image of its positive twin; a versine rounded above 2
 * is 2. */
static inline float np_phase_eval_lobe(np_phase_lobe lobe, float versine) {
  float g = fabsf(lobe.asymmetry), v = lobe.asymmetry < 0 ? np_maxf(2.0f - versine, 0.0f) : versine, mu = 1.0f - v;
  float distance2 = (1.0f - g) * (1.0f - g) + 2.0f * g * v;
  float norm = 4.0f * NP_PI_F * (1.0f + lobe.alpha * (1.0f + 2.0f * g * g) * (1.0f / 3.0f));
  return (1.0f - g) * (1.0f + g) * (1.0f + lobe.alpha * mu * mu) / (norm * distance2 * sqrtf(distance2));
}

/* Value at an angle given by its versine, 1 − cosθ in [0, 2], which stays exact in a narrow forward peak. A backward
 * peak is resolved as far as a float near 2 can be: down to g = −0.999. */
static inline float np_phase_eval(const np_phase *phase, float versine) {
  float value = np_phase_eval_lobe(phase->lobe[0], versine);
  if (phase->weight > 0) value += phase->weight * (np_phase_eval_lobe(phase->lobe[1], versine) - value);
  if (phase->third_weight > 0) value += phase->third_weight * (np_phase_eval_lobe(phase->lobe[2], versine) - value);
  if (phase->table) value += phase->table_weight * (np_phase_table_eval(phase->table, versine) - value);
  return value;
}

/* Share of a lobe among the lobes. */
static inline float np_phase_get_share(const np_phase *phase, int lobe) {
  const float others = 1.0f - phase->third_weight;
  return lobe == 2 ? phase->third_weight : others * (lobe == 1 ? phase->weight : 1.0f - phase->weight);
}

/* Values in each band; all of them np_phase_eval where bands have one phase function. */
np_spectrum np_phase_eval_bands(const np_phase *phase, float versine);

/* The phase function of one band. */
np_phase np_phase_get_band(const np_phase *phase, int band);

/* Phase function of tables of bands, which must outlive it. */
np_phase np_phase_of_bands(const np_phase_bands *bands);

bool np_phase_is_equal(const np_phase *a, const np_phase *b);

/* Samples a direction after scattering, distributed as the phase function: its pdf is its value.
 *
 * forward   unit direction of flight before.
 * u         three numbers in [0, 1).
 * out_value phase function value there.
 */
np_vec3 np_phase_sample(const np_phase *phase, np_vec3 forward, const float u[3], float *out_value);

/* Mean cosine, exact for lobes, to 1e-9 for tables. */
double np_phase_mean_cosine(const np_phase *phase);

/* Legendre moments χ_0 … χ_{count−1}. */
void np_phase_get_moments(const np_phase *phase, unsigned count, double *out_moments);

/* Broadened phase function: every lobe's g and α times `factor`, so that a factor of 0 is isotropic (octaves of
 * multiple scattering). A table is mixed with isotropy instead, which scales its mean cosine as well. */
np_phase np_phase_broaden(const np_phase *phase, float factor);

/* ---- Sources ---- */

enum { NP_PHASE_COUNT = NEPH_PHASE_ICE + 1 };

/* A phase function by kind and parameters, for clouds and air alike; its maker is a row of phase.c. */
typedef struct np_phase_source {
  neph_phase kind;                               /* tables are isotropic until they are read or computed */
  double asymmetry;                              /* Henyey-Greenstein, Cornette-Shanks, haze */
  double draine_asymmetry, alpha;                /* Draine */
  double forward, backward, backward_weight;     /* two lobes */
  double diameter_m;                             /* droplets */
  double effective_radius_m, effective_variance; /* Mie theory (optics/mie.h) */
  double mode_diameter_m;                        /* rain */
  neph_ice_habit habit;                          /* ice */
} np_phase_source;

np_phase np_phase_make(const np_phase_source *source);

#endif

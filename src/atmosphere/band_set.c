/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/band_set.h"

#include <math.h>
#include <string.h>

#include "atmosphere/spectra.h"

static const double reference_nm[NP_BAND_COUNT] = {680.0, 550.0, 440.0};

static double get_flat(double wavelength_nm) {
  (void)wavelength_nm;
  return 1.0;
}

static double (*const spectra[NP_BAND_RULE_COUNT])(double wavelength_nm) = {
    [NP_BAND_LINEAR] = get_flat,
    [NP_BAND_POWER] = get_flat,
    [NP_BAND_SUN] = np_spectra_sun,
    [NP_BAND_OZONE] = np_spectra_ozone,
    [NP_BAND_MOLECULES] = np_spectra_molecules,
};

np_band_set np_band_set_reference(void) {
  np_band_set bands = {.is_reference = true};
  memcpy(bands.nm, reference_nm, sizeof bands.nm);
  for (int rule = 0; rule < NP_BAND_RULE_COUNT; rule++)
    for (int b = 0; b < NP_BAND_COUNT; b++) bands.shape[rule][b] = spectra[rule](bands.nm[b]);
  return bands;
}

unsigned np_band_set_get_index(const np_wavelengths *wavelengths, unsigned packet, unsigned band) {
  return wavelengths->count - 1 - packet - band * (wavelengths->count / NP_BAND_COUNT);
}

np_band_set np_band_set_choose_cells(const np_wavelengths *wavelengths, const unsigned index[NP_BAND_COUNT]) {
  np_band_set bands = {.is_reference = false};
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
    bands.nm[b] = wavelengths->nm[index[b]];
    for (int rule = 0; rule < NP_BAND_RULE_COUNT; rule++)
      bands.shape[rule][b] = np_wavelengths_mean(wavelengths, index[b], spectra[rule]);
  }
  return bands;
}

np_band_set np_band_set_choose(const np_wavelengths *wavelengths, unsigned packet) {
  unsigned index[NP_BAND_COUNT];
  for (unsigned b = 0; b < NP_BAND_COUNT; b++) index[b] = np_band_set_get_index(wavelengths, packet, b);
  return np_band_set_choose_cells(wavelengths, index);
}

/* Pair of reference bands around, or nearest to, a wavelength: index of the longer one. */
static int choose_segment(double nm) { return nm >= reference_nm[1] ? 0 : 1; }

static double interpolate_linear(const double values[NP_BAND_COUNT], double nm) {
  const int i = choose_segment(nm);
  const double place = (reference_nm[i] - nm) / (reference_nm[i] - reference_nm[i + 1]);
  return values[i] + fmin(fmax(place, 0.0), 1.0) * (values[i + 1] - values[i]);
}

/* A power law needs two positive values; otherwise the result is linear. */
static double interpolate_power(const double values[NP_BAND_COUNT], double nm) {
  const int i = choose_segment(nm);
  if (!(values[i] > 0.0 && values[i + 1] > 0.0)) return interpolate_linear(values, nm);
  const double place = log(reference_nm[i] / nm) / log(reference_nm[i] / reference_nm[i + 1]);
  return values[i] * pow(values[i + 1] / values[i], place);
}

void np_band_set_convert(const np_band_set *bands, np_band_rule rule, const double reference[NP_BAND_COUNT],
                         double out[NP_BAND_COUNT]) {
  if (bands->is_reference) {
    memcpy(out, reference, NP_BAND_COUNT * sizeof *out);
    return;
  }
  const bool is_power = rule == NP_BAND_POWER || rule == NP_BAND_MOLECULES;
  double ratio[NP_BAND_COUNT];
  for (int b = 0; b < NP_BAND_COUNT; b++) ratio[b] = reference[b] / spectra[rule](reference_nm[b]);
  for (int b = 0; b < NP_BAND_COUNT; b++)
    out[b] = bands->shape[rule][b] *
             (is_power ? interpolate_power(ratio, bands->nm[b]) : interpolate_linear(ratio, bands->nm[b]));
}

void np_band_set_compute_xyz(const np_wavelengths *wavelengths, np_band_rule rule,
                             const double reference[NP_BAND_COUNT], double out_xyz[3]) {
  for (int c = 0; c < 3; c++) out_xyz[c] = 0.0;
  for (unsigned packet = 0; packet < wavelengths->count / NP_BAND_COUNT; packet++) {
    const np_band_set bands = np_band_set_choose(wavelengths, packet);
    double value[NP_BAND_COUNT];
    np_band_set_convert(&bands, rule, reference, value);
    for (unsigned b = 0; b < NP_BAND_COUNT; b++) {
      const double *weight = wavelengths->xyz_nm[np_band_set_get_index(wavelengths, packet, b)];
      for (int c = 0; c < 3; c++) out_xyz[c] += value[b] * weight[c];
    }
  }
}

neph_atmosphere_layer np_band_set_convert_layer(const np_band_set *bands, const neph_atmosphere_layer *reference) {
  const np_band_rule scattering = reference->phase == NEPH_PHASE_RAYLEIGH ? NP_BAND_MOLECULES : NP_BAND_POWER;
  const np_band_rule absorption = reference->absorber == NEPH_LAYER_OZONE ? NP_BAND_OZONE : NP_BAND_POWER;
  neph_atmosphere_layer layer = *reference;
  np_band_set_convert(bands, scattering, reference->scattering_per_m, layer.scattering_per_m);
  np_band_set_convert(bands, absorption, reference->absorption_per_m, layer.absorption_per_m);
  np_band_set_convert(bands, NP_BAND_LINEAR, reference->asymmetry, layer.asymmetry);
  np_band_set_convert(bands, NP_BAND_LINEAR, reference->second_asymmetry, layer.second_asymmetry);
  np_band_set_convert(bands, NP_BAND_LINEAR, reference->second_weight, layer.second_weight);
  return layer;
}

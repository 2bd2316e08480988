/* SPDX-License-Identifier: Apache-2.0 */
/* Hess, Koepke and Schult 1998, "Optical Properties of Aerosols and Clouds", table 4, at a relative humidity of 80 %:
 * visual range, single-scattering albedo and asymmetry at 550 nm and Ångström's exponents of the extinction on either
 * side of it, for continental clean and polluted air, maritime clean air and the desert. The albedo is grey, but in
 * the desert, whose dust absorbs blue light. Scale heights give their vertical optical depths. */
#include "atmosphere/haze.h"

#include <assert.h>
#include <math.h>

/* ln 50: the contrast at the visual range is 2 %. */
static const double koschmieder = 3.912;

typedef struct haze_row {
  double visibility_m, height_m, asymmetry;
  double albedo[3];             /* single scattering, at 680, 550 and 440 nm */
  double red_power, blue_power; /* extinction goes as the wavelength to minus this power */
} haze_row;

static const haze_row rows[] = {
    [NP_HAZE_CLEAR] = {100e3, 1800, 0.709, {0.972, 0.972, 0.972}, 1.42, 1.10},
    [NP_HAZE_HAZY] = {20e3, 1800, 0.698, {0.892, 0.892, 0.892}, 1.45, 1.13},
    [NP_HAZE_MARITIME] = {40e3, 1000, 0.772, {0.997, 0.997, 0.997}, 0.08, 0.12},
    [NP_HAZE_DUSTY] = {25e3, 2000, 0.729, {0.93, 0.888, 0.83}, 0.17, 0.20},
};

double np_haze_compute_extinction(double visibility_m, double air_per_m) {
  return koschmieder / visibility_m - air_per_m;
}

double np_haze_compute_range(double air_per_m) { return air_per_m > 0.0 ? koschmieder / air_per_m : (double)INFINITY; }

neph_atmosphere_layer np_haze_make(np_haze kind, double air_per_m) {
  assert(kind > NP_HAZE_PRESET && (size_t)kind < sizeof rows / sizeof *rows);
  const haze_row *row = &rows[kind];
  const double middle = np_haze_compute_extinction(row->visibility_m, air_per_m);
  const double extinction[3] = {middle * pow(680.0 / 550.0, -row->red_power), middle,
                                middle * pow(440.0 / 550.0, -row->blue_power)};
  neph_atmosphere_layer layer = {.profile = NEPH_LAYER_EXPONENTIAL,
                                 .top_m = (double)INFINITY,
                                 .height_m = row->height_m,
                                 .phase = NEPH_PHASE_HAZE};
  for (int b = 0; b < 3; b++) {
    layer.scattering_per_m[b] = row->albedo[b] * extinction[b];
    layer.absorption_per_m[b] = extinction[b] - layer.scattering_per_m[b];
    layer.asymmetry[b] = row->asymmetry;
  }
  return layer;
}

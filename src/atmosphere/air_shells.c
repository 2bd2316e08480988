/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/air_shells.h"

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

/* Floors go up as 0, 1, 2, 3, 4, 6, 8, 12, … 384 and, the top, 512 parts of 512 of the air's height, for aerosol of a
 * small scale height lies low. */
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
    /* A hair above, for altitudes are rounded. */
    out->bound_per_m[k] = 1.000001 * fmax(extinction[0], fmax(extinction[1], extinction[2]));
  }
}

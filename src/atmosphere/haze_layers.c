/* SPDX-License-Identifier: Apache-2.0 */
#include "atmosphere/haze_layers.h"

#include <math.h>

#include "optics/phase.h"

unsigned np_haze_split(np_haze kind, const neph_atmosphere_layer *haze, neph_atmosphere_layer *out_layers) {
  neph_atmosphere_layer *fine = &out_layers[0], *coarse = &out_layers[1];
  *fine = *haze;
  if (haze->phase != NEPH_PHASE_HAZE || kind != NP_HAZE_HAZY) return 1;
  *coarse = *haze;
  coarse->phase = NEPH_PHASE_TWO_LOBE;
  fine->phase = NEPH_PHASE_HENYEY_GREENSTEIN;
  const np_phase lobes = np_phase_haze(haze->asymmetry[1]);
  const double narrow = (double)np_phase_get_share(&lobes, 1), narrowest = (double)np_phase_get_share(&lobes, 2);
  for (int b = 0; b < 3; b++) {
    coarse->scattering_per_m[b] = fmin((narrow + narrowest) * haze->scattering_per_m[1], haze->scattering_per_m[b]);
    fine->scattering_per_m[b] -= coarse->scattering_per_m[b];
    coarse->absorption_per_m[b] = 0.0;
    fine->asymmetry[b] = (double)lobes.lobe[0].asymmetry;
    coarse->asymmetry[b] = (double)lobes.lobe[1].asymmetry;
    coarse->second_asymmetry[b] = (double)lobes.lobe[2].asymmetry;
    coarse->second_weight[b] = narrowest / (narrow + narrowest);
  }
  return 2;
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/sky_harmonics.h"

#include <string.h>

#include "core/units.h"

enum { ROWS = 256, COLUMNS = 256 };

void np_sky_harmonics_eval(np_vec3 direction, double out[NP_SKY_HARMONICS]) {
  const double x = (double)direction.x, y = (double)direction.y, z = (double)direction.z;
  const double c1 = sqrt(3.0 / (4.0 * NP_PI)), c2 = sqrt(15.0 / (4.0 * NP_PI));
  const double all[NP_SKY_HARMONICS] = {0.5 / sqrt(NP_PI),
                                        c1 * y,
                                        c1 * z,
                                        c1 * x,
                                        c2 * x * y,
                                        c2 * y * z,
                                        0.5 * c2 / sqrt(3.0) * (3.0 * z * z - 1.0),
                                        c2 * x * z,
                                        0.5 * c2 * (x * x - y * y)};
  memcpy(out, all, sizeof all);
}

void np_sky_harmonics_project(np_radiance_fn radiance, const void *user, double out[NP_SKY_HARMONICS][NP_BAND_COUNT]) {
  memset(out, 0, NP_SKY_HARMONICS * sizeof *out);
  for (int row = 0; row < ROWS; row++) {
    const double top = NP_PI * row / ROWS, bottom = NP_PI * (row + 1) / ROWS, zenith = 0.5 * (top + bottom);
    const double solid_angle = (cos(top) - cos(bottom)) * 2.0 * NP_PI / COLUMNS;
    for (int column = 0; column < COLUMNS; column++) {
      const double azimuth = 2.0 * NP_PI * (column + 0.5) / COLUMNS;
      const np_vec3 d =
          np_vec3_make((float)(sin(zenith) * sin(azimuth)), (float)(sin(zenith) * cos(azimuth)), (float)cos(zenith));
      const np_spectrum light = radiance(user, d);
      double harmonic[NP_SKY_HARMONICS];
      np_sky_harmonics_eval(d, harmonic);
      for (int k = 0; k < NP_SKY_HARMONICS; k++)
        for (int b = 0; b < NP_BAND_COUNT; b++) out[k][b] += solid_angle * harmonic[k] * (double)light.band[b];
    }
  }
}

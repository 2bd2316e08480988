/* SPDX-License-Identifier: Apache-2.0 */
/* Look-ups in the table of the aerosol's source. */
#include "atmosphere/mie_gather.h"

/* Lower of the two kernel altitudes around an altitude, and the weight of the upper one. */
static int search_altitude(const np_gather_kernel *kernel, double altitude_m, float *out_upper) {
  int i = 0;
  while (i + 2 < kernel->altitude_count && altitude_m > kernel->altitude_m[i + 1]) i++;
  const double low = kernel->altitude_m[i], high = kernel->altitude_m[i + 1];
  *out_upper = high > low ? (float)np_clamp((altitude_m - low) / (high - low), 0.0, 1.0) : 0.0f;
  return i;
}

static np_gather_source mix_sources(const np_gather_source *a, const np_gather_source *b, float t) {
  return (np_gather_source){np_bands_mix(a->smooth, b->smooth, t), np_bands_mix(a->peak, b->peak, t)};
}

void np_gather_table_row(const np_gather_table *table, double altitude_m, float view_cosine, np_gather_row *out_row) {
  const np_gather_kernel *kernel = table->kernel;
  float upper;
  const int i = search_altitude(kernel, altitude_m, &upper);
  const float elevation = 1.0f - np_acos_coarse(view_cosine) * (2.0f / NP_PI_F);
  const float x = 0.5f * (copysignf(sqrtf(fabsf(elevation)), elevation) + 1.0f) * (float)(kernel->cosines - 1);
  const int j = x < (float)(kernel->cosines - 2) ? (int)np_maxf(x, 0.0f) : kernel->cosines - 2;
  const float f = x - (float)j;
  for (int s = 0; s < table->sun_count; s++)
    for (int k = 0; k < kernel->azimuths; k++) {
      const np_gather_source low = mix_sources(&table->source[s][i][j][k], &table->source[s][i][j + 1][k], f);
      const np_gather_source high = mix_sources(&table->source[s][i + 1][j][k], &table->source[s][i + 1][j + 1][k], f);
      out_row->source[s][k] = mix_sources(&low, &high, upper);
    }
}

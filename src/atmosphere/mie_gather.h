/* SPDX-License-Identifier: Apache-2.0 */
/* Multiple scattering by aerosol: its phase function convolved with the whole sky and ground.
 *
 * The aerosol's lobe is far narrower than the degree 2 of the moments; near the horizon it spans bright sky and dark
 * ground. So its source is gathered directly, for a few sun angles, at four altitudes with aerosol, into a small table
 * over view directions. The table stores the source divided by M (scattering_moments.h) at the same point, which
 * removes most variation of brightness along a ray. */
#ifndef NP_ATMOSPHERE_MIE_GATHER_H
#define NP_ATMOSPHERE_MIE_GATHER_H

#include "atmosphere/gather_kernel.h"
#include "atmosphere/scattering_moments.h"

/* Source in one direction, divided by M. */
typedef struct np_gather_source {
  np_bands smooth;
  np_bands
      peak; /* multiply by np_gather_kernel_convolve_lobe at the angle between ray and sun; 0 unless the air is thick */
} np_gather_source;

typedef struct np_gather_table {
  const np_gather_kernel *kernel;
  int sun_count;
  float sun_cosine[NP_GATHER_SUNS_MAX]; /* descending */
  np_gather_source source[NP_GATHER_SUNS_MAX][NP_GATHER_ALTITUDES_MAX][NP_GATHER_COSINES_MAX][NP_GATHER_AZIMUTHS_MAX];
} np_gather_table;

/* The table at one altitude and zenith cosine of view, interpolated once for many azimuths and suns. */
typedef struct np_gather_row {
  np_gather_source source[NP_GATHER_SUNS_MAX][NP_GATHER_AZIMUTHS_MAX];
} np_gather_row;

void np_gather_table_row(const np_gather_table *table, double altitude_m, float view_cosine, np_gather_row *out_row);

/* Interpolates one part of a row's source between two azimuths and two suns. */
static inline np_bands np_gather_mix(const np_bands *near, const np_bands *far, float azimuth, float sun) {
  const int next = sizeof(np_gather_source) / sizeof(np_bands);
  return np_bands_mix(np_bands_mix(near[0], near[next], azimuth), np_bands_mix(far[0], far[next], azimuth), sun);
}

/* Source per unit of scattering coefficient, divided by M, along a ray; `angle_cosine` is between ray and sun. */
static inline np_bands np_gather_row_lookup(const np_gather_table *table, const np_gather_row *row, float cos_azimuth,
                                            float sun_cosine, float angle_cosine) {
  const np_gather_kernel *kernel = table->kernel;
  const float x = np_acos_coarse(cos_azimuth) * (float)((double)(kernel->azimuths - 1) / NP_PI);
  const int i = x < (float)(kernel->azimuths - 2) ? (int)x : kernel->azimuths - 2;
  int s = 0;
  while (s + 2 < table->sun_count && sun_cosine < table->sun_cosine[s + 1]) s++;
  const float span = table->sun_cosine[s] - table->sun_cosine[s + 1];
  const float g = np_clampf((table->sun_cosine[s] - sun_cosine) / span, 0.0f, 1.0f), f = x - (float)i;
  const np_gather_source *near = &row->source[s][i], *far = &row->source[s + 1][i];
  const np_bands smooth = np_gather_mix(&near->smooth, &far->smooth, f, g);
  if (!kernel->needs_delta_scaling) return smooth;
  return smooth +
         np_gather_kernel_convolve_lobe(kernel, 1.0f - angle_cosine) * np_gather_mix(&near->peak, &far->peak, f, g);
}

#endif

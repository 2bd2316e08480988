/* SPDX-License-Identifier: Apache-2.0 */
/* The aerosol's share of multiple scattering: its phase function convolved with the whole sky and ground.
 *
 * The aerosol's lobe is far narrower than the degree 2 that the moments hold; near the horizon it spans bright sky and
 * dark ground. So its source is gathered outright, for a few sun angles, at four altitudes where the aerosol is, into a
 * small table over the direction of view. What is stored is the source over M (scattering_moments.h) at the same place,
 * which takes the change of brightness along a ray out of the interpolation.
 */
#ifndef NP_ATMOSPHERE_MIE_GATHER_H
#define NP_ATMOSPHERE_MIE_GATHER_H

#include "atmosphere/ray_path.h"
#include "atmosphere/scattering_moments.h"

enum {
  NP_GATHER_ALTITUDES_MAX = 8,
  NP_GATHER_COSINES = 13,
  NP_GATHER_AZIMUTHS = 9, /* on the half circle, both ends included */
  NP_GATHER_SUNS_MAX = 17,
  NP_GATHER_OUTPUTS = NP_GATHER_COSINES * NP_GATHER_AZIMUTHS,
  NP_GATHER_UP = 8,
  NP_GATHER_DOWN = 4,
  NP_GATHER_TURNS = 8,
  NP_GATHER_INPUTS = (NP_GATHER_UP + NP_GATHER_DOWN) * NP_GATHER_TURNS
};

/* What depends on the medium alone: the directions gathered from at each altitude, their paths, and the phase functions
 * between each of them and each direction of the table. */
typedef struct np_gather_kernel {
  const np_medium *medium;
  int altitude_count;
  double altitude_m[NP_GATHER_ALTITUDES_MAX];
  np_bands part[NP_GATHER_ALTITUDES_MAX][NP_AEROSOLS_MAX]; /* of each aerosol in the scattering there */
  float input_cosine[NP_GATHER_ALTITUDES_MAX][NP_GATHER_UP + NP_GATHER_DOWN];
  np_ray ray[NP_GATHER_ALTITUDES_MAX][NP_GATHER_UP + NP_GATHER_DOWN];
  np_path path[NP_GATHER_ALTITUDES_MAX][NP_GATHER_UP + NP_GATHER_DOWN];
  float *weight; /* of altitudes × aerosols × outputs × inputs: quadrature × phase function */
  float *twice;  /* of pairs of aerosols: one phase function convolved with the other, over √(Θ/π) */
} np_gather_kernel;

neph_result np_gather_kernel_build(neph_context *context, const np_medium *medium, np_gather_kernel *out_kernel);
void np_gather_kernel_free(neph_context *context, np_gather_kernel *kernel);

typedef struct np_gather_table {
  const np_gather_kernel *kernel;
  int sun_count;
  float sun_cosine[NP_GATHER_SUNS_MAX]; /* descending */
  np_bands source[NP_GATHER_SUNS_MAX][NP_GATHER_ALTITUDES_MAX][NP_GATHER_COSINES][NP_GATHER_AZIMUTHS];
} np_gather_table;

/* Gathers for suns evenly spread over zenith angles `sun_zenith_rad` ± `spread_rad`: twice, so that the second pass
 * sees the aerosol's light as the first found it. `dome_moments` are those of the sky that is gathered: `moments`
 * themselves or, where orders are limited, one order less, NULL for none. `disk` is the sun's. */
neph_result np_gather_table_build(neph_context *context, const np_depth_table *depths, const np_moment_table *moments,
                                  const np_moment_table *dome_moments, const np_gather_kernel *kernel,
                                  double sun_zenith_rad, double spread_rad, np_sun_disk disk,
                                  np_gather_table *out_table);

/* The table at one altitude and zenith cosine of view, resolved once for many azimuths and local suns. */
typedef struct np_gather_row {
  np_bands source[NP_GATHER_SUNS_MAX][NP_GATHER_AZIMUTHS];
} np_gather_row;

void np_gather_table_row(const np_gather_table *table, double altitude_m, float view_cosine, np_gather_row *out_row);

/* Source per unit of scattering coefficient, over M. */
static inline np_bands np_gather_row_lookup(const np_gather_table *table, const np_gather_row *row, float cos_azimuth,
                                            float sun_cosine) {
  const float x = np_acos_coarse(cos_azimuth) * (float)((NP_GATHER_AZIMUTHS - 1) / NP_PI);
  const int i = x < (float)(NP_GATHER_AZIMUTHS - 2) ? (int)x : NP_GATHER_AZIMUTHS - 2;
  const float f = x - (float)i;
  int s = 0;
  while (s + 2 < table->sun_count && sun_cosine < table->sun_cosine[s + 1]) s++;
  const np_bands near = np_bands_mix(row->source[s][i], row->source[s][i + 1], f);
  if (table->sun_count == 1) return near;
  const np_bands far = np_bands_mix(row->source[s + 1][i], row->source[s + 1][i + 1], f);
  const float g = (table->sun_cosine[s] - sun_cosine) / (table->sun_cosine[s] - table->sun_cosine[s + 1]);
  return np_bands_mix(near, far, np_clampf(g, 0.0f, 1.0f));
}

#endif

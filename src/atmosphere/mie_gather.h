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
  NP_GATHER_COSINES_MAX = 25,
  NP_GATHER_AZIMUTHS_MAX = 17, /* on the half circle, both ends included */
  NP_GATHER_SUNS_MAX = 17,
  NP_GATHER_ROWS_MAX = 24, /* of the dome */
  NP_GATHER_INPUTS_MAX = NP_GATHER_ROWS_MAX * 16
};

/* What depends on the medium alone: the directions gathered from at each altitude, their paths, and the phase functions
 * between each of them and each direction of the table. */
typedef struct np_gather_kernel {
  const np_medium *medium;
  int altitude_count;
  int cosines, azimuths; /* of the directions that are gathered for */
  int up, down, turns;   /* of the dome of those gathered from: rows above and below the horizon, azimuths of each */
  bool is_thick;         /* enough aerosol for its peak to count in later orders */
  int passes;            /* of gathering: each sees the aerosol's light as the one before found it */
  double altitude_m[NP_GATHER_ALTITUDES_MAX];
  np_bands part[NP_GATHER_ALTITUDES_MAX][NP_AEROSOLS_MAX]; /* of each aerosol in the scattering there */
  float input_cosine[NP_GATHER_ALTITUDES_MAX][NP_GATHER_ROWS_MAX];
  np_ray ray[NP_GATHER_ALTITUDES_MAX][NP_GATHER_ROWS_MAX];
  np_path path[NP_GATHER_ALTITUDES_MAX][NP_GATHER_ROWS_MAX];
  float *weight; /* of altitudes × aerosols × outputs × inputs: quadrature × phase function */
  float *twice;  /* of pairs of aerosols: one phase function convolved with the other, over √(Θ/π) */
} np_gather_kernel;

neph_result np_gather_kernel_build(neph_context *context, const np_medium *medium, np_gather_kernel *out_kernel);
void np_gather_kernel_free(neph_context *context, np_gather_kernel *kernel);

/* The source in one direction, over M. */
typedef struct np_gather_source {
  np_bands smooth;
  np_bands peak; /* to be multiplied by np_gather_kernel_twice at the angle between ray and sun; 0 unless it is thick */
} np_gather_source;

/* The mean phase function of the aerosols convolved with itself: how sharply the sun is seen after two scatterings. */
np_bands np_gather_kernel_twice(const np_gather_kernel *kernel, float versine);

typedef struct np_gather_table {
  const np_gather_kernel *kernel;
  int sun_count;
  float sun_cosine[NP_GATHER_SUNS_MAX]; /* descending */
  np_gather_source source[NP_GATHER_SUNS_MAX][NP_GATHER_ALTITUDES_MAX][NP_GATHER_COSINES_MAX][NP_GATHER_AZIMUTHS_MAX];
} np_gather_table;

/* Gathers for suns evenly spread over zenith angles `sun_zenith_rad` ± `spread_rad`: in passes, so that each
 * sees the aerosol's light as the one before found it. `dome_moments` are those of the sky that is gathered: `moments`
 * themselves or, where orders are limited, one order less, NULL for none. `disk` is the sun's. */
neph_result np_gather_table_build(neph_context *context, const np_depth_table *depths, const np_moment_table *moments,
                                  const np_moment_table *dome_moments, const np_gather_kernel *kernel,
                                  double sun_zenith_rad, double spread_rad, np_sun_disk disk, np_monitor *monitor,
                                  np_gather_table *out_table);

/* The table at one altitude and zenith cosine of view, resolved once for many azimuths and local suns. */
typedef struct np_gather_row {
  np_gather_source source[NP_GATHER_SUNS_MAX][NP_GATHER_AZIMUTHS_MAX];
} np_gather_row;

void np_gather_table_row(const np_gather_table *table, double altitude_m, float view_cosine, np_gather_row *out_row);

/* One of the two parts of a row's source between two azimuths and two suns. */
static inline np_bands np_gather_mix(const np_bands *near, const np_bands *far, float azimuth, float sun) {
  const int next = sizeof(np_gather_source) / sizeof(np_bands);
  return np_bands_mix(np_bands_mix(near[0], near[next], azimuth), np_bands_mix(far[0], far[next], azimuth), sun);
}

/* Source per unit of scattering coefficient, over M, along a ray at an angle of `angle_cosine` with the sun. */
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
  if (!kernel->is_thick) return smooth;
  return smooth + np_gather_kernel_twice(kernel, 1.0f - angle_cosine) * np_gather_mix(&near->peak, &far->peak, f, g);
}

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Sunlight that came as if straight and is scattered by one cloud: the direct term (transport/scaled_phase.c). */
#ifndef NP_TRANSPORT_PEAK_COLUMN_H
#define NP_TRANSPORT_PEAK_COLUMN_H

#include "core/spectrum.h"
#include "core/stable.h"

enum { NP_PEAK_ANGLES = 256, NP_PEAK_DEPTHS = 96 };

/* The table's nodes: angle π·(i/255)², depth 0.05·(e^{0.1053·k} − 1), which ends at 1100. */
#define NP_PEAK_DEPTH_SCALE 0.05f
#define NP_PEAK_DEPTH_RATE 0.1053f

/* The direct term at one angle, for any depths. */
typedef struct np_peak_column {
  float broad;       /* (1−f)·p′ */
  np_spectrum sharp; /* p − (1−f)·p′ of each band */
  float peak[NP_PEAK_DEPTHS];
} np_peak_column;

/* Place between the nodes of a column's peak. */
typedef struct np_peak_place {
  unsigned lower;
  float share; /* share of the next node */
} np_peak_place;

static inline np_peak_place np_peak_place_get(float sun_optical_depth) {
  const float end = (float)(NP_PEAK_DEPTHS - 1);
  const float x =
      np_minf(logf(1.0f + sun_optical_depth * (1.0f / NP_PEAK_DEPTH_SCALE)) * (1.0f / NP_PEAK_DEPTH_RATE), end);
  const unsigned lower = x < end - 1.0f ? (unsigned)x : NP_PEAK_DEPTHS - 2;
  return (np_peak_place){lower, x - (float)lower};
}

/* Phase value in a band for sunlight of which a depth of peak scattering w·f·τ, that of the place, lets `arriving`
 * through, and that through which it leaves, `leaving`; to be multiplied by what the scaled medium lets through on both
 * legs. */
static inline float np_peak_column_mix(const np_peak_column *column, int band, np_peak_place place, float arriving,
                                       float leaving) {
  const float *node = column->peak + place.lower;
  const float peak = node[0] + place.share * (node[1] - node[0]);
  return np_maxf(column->broad + leaving * (arriving * column->sharp.band[band] + peak), 0.0f);
}

#endif

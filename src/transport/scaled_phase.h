/* SPDX-License-Identifier: Apache-2.0 */
/* A phase function split in two: a forward peak, and a broad rest of a low degree. */
#ifndef NP_TRANSPORT_SCALED_PHASE_H
#define NP_TRANSPORT_SCALED_PHASE_H

#include "core/context_private.h"
#include "core/stable.h"
#include "transport/ordinates.h"
#include "optics/phase.h"

enum { NP_PEAK_ANGLES = 256, NP_PEAK_DEPTHS = 96 };

/* The table's nodes: angle π·(i/255)², depth 0.05·(e^{0.1053·k} − 1), which ends at 1100. */
#define NP_PEAK_DEPTH_SCALE 0.05f
#define NP_PEAK_DEPTH_RATE 0.1053f

typedef struct np_scaled_phase {
  neph_context *context; /* borrowed */
  np_phase phase;
  unsigned degree;                  /* N, of the broad rest */
  float forward;                    /* f: the share of scattering that counts as going straight on */
  float least_forward;              /* the same where the rest is of the least degree; not below f */
  float moments[NP_DEGREE_MAX + 1]; /* χ_l − f, l ≤ N */
  float *peak; /* [angle][depth]: light in the peak after two scatterings and more in it, per unit of e^{−τ} */
} np_scaled_phase;

/* The share f when the rest is of this degree. */
float np_scaled_phase_compute_forward(const np_phase *phase, unsigned degree);

neph_result np_scaled_phase_init(neph_context *context, const np_phase *phase, unsigned degree, np_scaled_phase *out);
void np_scaled_phase_clear(np_scaled_phase *scaled);

/* The direct term at one angle, for any depths. */
typedef struct np_peak_column {
  float broad, sharp; /* (1−f)·p′, p − (1−f)·p′ */
  float peak[NP_PEAK_DEPTHS];
} np_peak_column;

void np_scaled_phase_fill_column(const np_scaled_phase *scaled, float versine, np_peak_column *out);

/* Where between the nodes of its peak a column is asked for. */
typedef struct np_peak_place {
  unsigned lower;
  float share; /* of the next node */
} np_peak_place;

static inline np_peak_place np_peak_place_get(float sun_depth) {
  const float end = (float)(NP_PEAK_DEPTHS - 1);
  const float x = np_minf(logf(1.0f + sun_depth * (1.0f / NP_PEAK_DEPTH_SCALE)) * (1.0f / NP_PEAK_DEPTH_RATE), end);
  const unsigned lower = x < end - 1.0f ? (unsigned)x : NP_PEAK_DEPTHS - 2;
  return (np_peak_place){lower, x - (float)lower};
}

/* Phase value for sunlight of which a depth of peak scattering w·f·τ, that of the place, lets `arriving` through, and
 * that through which it leaves, `leaving`; to be multiplied by what the scaled medium lets through on both legs. */
static inline float np_peak_column_mix(const np_peak_column *column, np_peak_place place, float arriving,
                                       float leaving) {
  const float *node = column->peak + place.lower;
  const float peak = node[0] + place.share * (node[1] - node[0]);
  return np_maxf(column->broad + leaving * (arriving * column->sharp + peak), 0.0f);
}

static inline float np_peak_column_eval(const np_peak_column *column, float sun_depth, float view_depth) {
  return np_peak_column_mix(column, np_peak_place_get(sun_depth), np_transmittance(sun_depth),
                            np_transmittance(view_depth));
}

#endif

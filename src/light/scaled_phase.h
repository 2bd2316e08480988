/* SPDX-License-Identifier: Apache-2.0 */
/* A phase function split in two: a forward peak, and a broad rest of a low degree. */
#ifndef NP_LIGHT_SCALED_PHASE_H
#define NP_LIGHT_SCALED_PHASE_H

#include "core/context_private.h"
#include "core/stable.h"
#include "light/ordinates.h"
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
  float moments[NP_DEGREE_MAX + 1]; /* χ_l − f, l ≤ N */
  float *peak; /* [angle][depth]: light in the peak after two scatterings and more in it, per unit of e^{−τ} */
} np_scaled_phase;

/* The share f when the rest is of this degree. */
float np_scaled_phase_find_forward(const np_phase *phase, unsigned degree);

neph_result np_scaled_phase_init(neph_context *context, const np_phase *phase, unsigned degree, np_scaled_phase *out);
void np_scaled_phase_clear(np_scaled_phase *scaled);

/* The direct term at one angle, for any depths. */
typedef struct np_peak_column {
  float broad, sharp; /* (1−f)·p′, p − (1−f)·p′ */
  float peak[NP_PEAK_DEPTHS];
} np_peak_column;

void np_scaled_phase_fill_column(const np_scaled_phase *scaled, float versine, np_peak_column *out);

/* Phase value for sunlight that came through a depth of peak scattering `sun_depth` = w·f·τ and leaves through
 * `view_depth`; to be multiplied by what the scaled medium lets through on both legs. */
static inline float np_peak_column_eval(const np_peak_column *column, float sun_depth, float view_depth) {
  const float x = fminf(logf(1.0f + sun_depth * (1.0f / NP_PEAK_DEPTH_SCALE)) * (1.0f / NP_PEAK_DEPTH_RATE),
                        (float)(NP_PEAK_DEPTHS - 1));
  const int lower = x < (float)(NP_PEAK_DEPTHS - 2) ? (int)x : NP_PEAK_DEPTHS - 2;
  const float peak = column->peak[lower] + (x - (float)lower) * (column->peak[lower + 1] - column->peak[lower]);
  const float leave = np_transmittance(view_depth);
  return fmaxf(0.0f, column->broad + leave * (np_transmittance(sun_depth) * column->sharp + peak));
}

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* The light at the camera in six bands: sky in a dozen directions, direct light, and light from everywhere. */
#ifndef NP_STAGES_COLOR_PROBES_H
#define NP_STAGES_COLOR_PROBES_H

#include "stages/stage_part.h"

enum { NP_COLOR_PROBE_PACKETS = NP_COLOR_PROBE_BAND_COUNT / NP_BAND_COUNT };

/* Inputs for each light of the fit of colours: skies in the picture's bands, and in the further bands of probes. */
typedef struct np_color_probes {
  unsigned light_count;
  np_color_fit_inputs at[NP_COLOR_PROBE_PACKETS][NP_LIGHTS_MAX];
} np_color_probes;

/* Adds probes of a scene's light to a fit, and fills the probes' wavelengths and the total irradiance at the camera. */
neph_result np_color_probes_add(const np_stage_part *in, const np_color_probes *probes, np_color_fit *fit,
                                np_picture_color *out);

#endif

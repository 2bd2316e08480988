/* SPDX-License-Identifier: Apache-2.0 */
/* The light at the camera in six bands: sky in a dozen directions, direct light, and light from everywhere. */
#ifndef NP_STAGES_COLOR_PROBES_H
#define NP_STAGES_COLOR_PROBES_H

#include "stages/stage_part.h"

/* Adds probes of a scene's light to a fit. The total irradiance at the camera comes out in the bands of probes, over
 * the default sun's; 0 in the dark. */
neph_result np_color_probes_add(const np_stage_part *in, np_color_fit *fit,
                                double out_light_x[NP_COLOR_PROBE_BAND_COUNT]);

#endif

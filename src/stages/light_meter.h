/* SPDX-License-Identifier: Apache-2.0 */
/* Incident light of a scene, by which a preview may be exposed. */
#ifndef NP_STAGES_LIGHT_METER_H
#define NP_STAGES_LIGHT_METER_H

#include "stages/packet.h"

/* Writes the luminance of a white diffuser in the open that faces the sun into the header, in the picture's units and
 * in cd/m², and its chromaticity (image/exposure.h). The header has its colours already. */
neph_result np_light_meter_write(const np_assembly *assembly, double scale, neph_image *image);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Haze as layers of one phase function each: in polluted air the particles that make the aureole are grey, and those
 * below half a micrometre have all of the colour. Without that the aureole is cyan. */
#ifndef NP_ATMOSPHERE_HAZE_LAYERS_H
#define NP_ATMOSPHERE_HAZE_LAYERS_H

#include "atmosphere/haze.h"

enum { NP_HAZE_LAYERS = 2 };

/* Splits haze of a kind into out_layers[NP_HAZE_LAYERS]. NP_HAZE_HAZY that scatters by NEPH_PHASE_HAZE becomes fine
 * particles of its broad lobe, which have the colour and the absorption, and grey coarse ones of its narrow lobes;
 * together they scatter at 550 nm as `haze`. Other haze is one layer. Returns the number of layers. */
unsigned np_haze_split(np_haze kind, const neph_atmosphere_layer *haze, neph_atmosphere_layer *out_layers);

#endif

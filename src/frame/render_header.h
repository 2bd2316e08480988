/* SPDX-License-Identifier: Apache-2.0 */
/* Header of a picture, as far as it is known before its samples. */
#ifndef NP_FRAME_RENDER_HEADER_H
#define NP_FRAME_RENDER_HEADER_H

#include "image/exposure.h"
#include "stages/assembly.h"

/* Attributes of a picture that is one tile, or one range of samples, of the whole. */
#define NP_HEADER_TILE "nephos:tile"
#define NP_HEADER_WHOLE "nephos:wholeWindow"
#define NP_HEADER_RANGE "nephos:sampleRange"

/* Degrees: above the horizontal at the world's origin, airless, and clockwise from north. */
#define NP_HEADER_SUN_ELEVATION NP_EXPOSURE_SUN_ELEVATION
#define NP_HEADER_MOON_ELEVATION NP_EXPOSURE_MOON_ELEVATION
#define NP_HEADER_SUN_AZIMUTH "nephos:sunAzimuth"

neph_result np_render_header_write(const neph_scene *scene, const np_plan *plan, const np_assembly *assembly,
                                   neph_image *image);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Results of a frame beside the sums of its channels: coverage by cloud, and deep pixels. */
#ifndef NP_FRAME_FRAME_LAYERS_H
#define NP_FRAME_FRAME_LAYERS_H

#include "frame/frame_state.h"

/* Clears and returns the layers of a sample; NULL if no output needs layers. */
np_integrator_layers *np_frame_start_layers(const np_frame *f, np_integrator_layers *layers);

/* Light by depth, from a packet's bands to colours of the picture. */
void np_frame_convert_layers(const np_packet *packet, np_integrator_layers *layers);

/* Adds the light of a group to the layers of a ray. */
void np_frame_add_group(const np_frame *f, const np_camera_ray *ray, unsigned group,
                        const np_integrator_sample *sample);

/* Adds the depth records of a sample to a pixel's segments. */
void np_frame_add_deep(const np_frame *f, const np_integrator_sample *sample, const np_integrator_layers *layers,
                       np_deep_bins *bins);

/* Finishes the deep pixel at an index. `cosine` is the cosine of the angle between the pixel's ray and the camera's
 * axis. */
neph_result np_frame_set_deep(const np_frame *f, const np_pixel_state *p, size_t index, double cosine);

#endif

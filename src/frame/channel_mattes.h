/* SPDX-License-Identifier: Apache-2.0 */
/* Channels of the clouds' and the ground's coverage: mattes by name, and Cryptomatte. */
#ifndef NP_FRAME_CHANNEL_MATTES_H
#define NP_FRAME_CHANNEL_MATTES_H

#include "frame/channels.h"

/* A channel for each cloud of the scene and for the ground, which add up to the coverage of both. */
void np_channels_add_mattes(np_channels *channels, const neph_scene *scene);

/* Adds channels of ranked pairs of identifier and coverage. */
void np_channels_add_cryptomatte(np_channels *channels);
void np_channels_add_cryptomatte_sums(np_channels *channels, const neph_scene *scene);

/* Writes the Cryptomatte manifest, names and identifiers of clouds, into a picture with such channels. */
neph_result np_channels_write_manifest(const neph_scene *scene, neph_image *image);

/* Identifier or coverage of the matte of a rank, by the channel's part. */
double np_channel_finish_rank(const np_channels *c, const np_channel *channel, const double *sums,
                              const np_pixel_facts *facts);

#endif

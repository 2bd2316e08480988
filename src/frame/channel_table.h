/* SPDX-License-Identifier: Apache-2.0 */
/* All channels that a picture may have, and the choice of a picture's channels. */
#ifndef NP_FRAME_CHANNEL_TABLE_H
#define NP_FRAME_CHANNEL_TABLE_H

#include "frame/channels.h"

/* The picture's own channels and the plan's AOVs. */
void np_channels_choose(const np_plan *plan, const neph_scene *scene, np_channels *out);

/* Finishing rules of channels, by the names that parts of pictures store; NULL: unknown name. */
typedef double (*np_channel_finish_fn)(const np_channels *channels, const np_channel *channel, const double *sums,
                                       const np_pixel_facts *facts);
np_channel_finish_fn np_channel_finish_get(const char *name);
const char *np_channel_finish_get_name(np_channel_finish_fn finish);

/* Numbers that a rule reads beside the channel's own sum. */
typedef struct np_channel_finish_needs {
  unsigned part_count; /* parts that a channel may be: below it */
  bool opacity, mattes;
} np_channel_finish_needs;

/* Requirements of a finishing rule. */
np_channel_finish_needs np_channel_finish_get_needs(np_channel_finish_fn finish);

#endif

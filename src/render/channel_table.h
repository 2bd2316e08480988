/* SPDX-License-Identifier: Apache-2.0 */
/* The channels that a picture may have, and those that it has. */
#ifndef NP_RENDER_CHANNEL_TABLE_H
#define NP_RENDER_CHANNEL_TABLE_H

#include "render/channels.h"

/* The picture's own channels and the plan's AOVs. */
void np_channels_choose(const np_plan *plan, const neph_scene *scene, np_channels *out);

#endif

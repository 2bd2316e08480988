/* SPDX-License-Identifier: Apache-2.0 */
/* Clouds that stand in many places: one volume, and its copies under a hierarchy. */
#ifndef NP_STAGES_COPIES_H
#define NP_STAGES_COPIES_H

#include "cloud/lod.h"
#include "plan/placement.h"
#include "stages/packet.h"

/* Puts a cloud that is placed with its pivot at the origin into each of its places, and includes their boxes. Where it
 * has levels for its copies, each has one by its distance from the viewers. */
neph_result np_copies_make(neph_context *context, const np_scene_cloud *cloud, const np_placement *origin,
                           const np_lod_viewers *viewers, np_cloud_parts *out, np_dvec3 *low, np_dvec3 *high);
void np_copies_clear(neph_context *context, np_cloud_parts *parts);

/* Builds the hierarchy over a packet's clouds, if some stand in several places. NEPH_ERROR_BAD_SCENE where too many lie
 * over each other. */
neph_result np_copies_build_places(neph_context *context, const np_frame_clouds *clouds, np_placed_clouds *placed);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/stage_makers.h"

/* Functions by the names of the results that they build and clear. */
#define BUILD(kind, what) .build[NP_PER_##kind] = np_stage_build_##what
#define BUILD_CLEAR(kind, what) BUILD(kind, what), .clear[NP_PER_##kind] = np_stage_clear_##what
#define REUSE(what) .reuse = &np_stage_reuse_##what

/* clang-format off */
static const np_stage_maker makers[NP_STAGE_COUNT] = {
  [NP_STAGE_COLOR] = {BUILD_CLEAR(PICTURE, packets)},
  [NP_STAGE_TERRAIN] = {REUSE(terrain)},
  [NP_STAGE_LIGHTS] = {BUILD_CLEAR(PICTURE, lights), BUILD(PACKET, packet_lights)},
  [NP_STAGE_VOLUMES] = {REUSE(volumes), BUILD_CLEAR(CLOUD, cloud), .finish = np_stage_finish_volumes},
  [NP_STAGE_MOTION] = {BUILD_CLEAR(PICTURE, motion)},
  [NP_STAGE_ATMOSPHERE] = {REUSE(atmosphere)},
  [NP_STAGE_CAMERA_SKY] = {REUSE(camera_sky)},
  [NP_STAGE_COLOR_FIT] = {BUILD(PICTURE, color_fit)},
  [NP_STAGE_EMISSION] = {BUILD_CLEAR(PACKET, emission)},
  [NP_STAGE_CLOUD_SKY] = {REUSE(cloud_sky)},
  [NP_STAGE_WATER_SKY] = {REUSE(water_sky)},
  [NP_STAGE_AIRGLOW] = {BUILD_CLEAR(PICTURE, star_map), BUILD(PACKET, airglow)},
  [NP_STAGE_WORLD] = {BUILD_CLEAR(PACKET, instances), BUILD(PACKET_LIGHT, world)},
  [NP_STAGE_SKY_GUIDE] = {BUILD(PACKET_LIGHT, sky_guide)},
  [NP_STAGE_SUN_OPTICAL_DEPTH] = {REUSE(sun_optical_depth)},
  [NP_STAGE_ORDINATES] = {REUSE(ordinates), .salvage = &np_stage_salvage_ordinates},
  [NP_STAGE_VIEWER_LIGHT] = {REUSE(viewer_light)},
  [NP_STAGE_GROUND_CLOUDS] = {REUSE(ground_clouds)},
  [NP_STAGE_RELIEF_LIGHT] = {REUSE(relief_light)},
  [NP_STAGE_AIR_SHADOWS] = {BUILD_CLEAR(LIGHT, visibility), BUILD_CLEAR(PACKET_LIGHT, air_shadow)},
  [NP_STAGE_APPROXIMATION] = {BUILD_CLEAR(PACKET, approximation)},
  [NP_STAGE_STARS] = {BUILD_CLEAR(PICTURE, catalogue), BUILD_CLEAR(PACKET, stars)},
  [NP_STAGE_LIGHTING] = {BUILD(PACKET_LIGHT, lighting)},
};
/* clang-format on */

const np_stage_maker *np_stage_get_maker(np_stage stage) { return &makers[stage]; }

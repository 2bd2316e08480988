/* SPDX-License-Identifier: Apache-2.0 */
/* What builds and clears the stages: functions for the rows of the stage table. */
#ifndef NP_RENDER_STAGE_BUILDERS_H
#define NP_RENDER_STAGE_BUILDERS_H

#include "render/packet.h"

/* Given to who builds. */
typedef struct np_stage_inputs {
  const neph_scene *scene;
  const np_plan *plan;
  const np_assembly *made; /* by the stages before */
  np_stores *stores;       /* with what was kept of earlier pictures */
  np_schedule *schedule;
  np_monitor *monitor;
} np_stage_inputs;

/* Results are cleared whether they were built whole, in part or not at all. What the next picture may use is not freed
 * but given back to the assembly's stores. */
typedef neph_result np_stage_build_once_fn(const np_stage_inputs *in, np_assembly *out);
typedef neph_result np_stage_build_light_fn(const np_stage_inputs *in, unsigned light, np_light_caches *out);
typedef neph_result np_stage_build_packet_fn(const np_stage_inputs *in, np_packet *out);
typedef neph_result np_stage_build_packet_light_fn(const np_stage_inputs *in, const np_packet *packet,
                                                   np_packet_light *out);
typedef void np_stage_clear_once_fn(np_assembly *assembly);
typedef void np_stage_clear_light_fn(np_assembly *assembly, np_light_caches *light);
typedef void np_stage_clear_packet_fn(np_assembly *assembly, np_packet *packet);
typedef void np_stage_clear_packet_light_fn(np_assembly *assembly, const np_packet *packet, np_packet_light *light);

/* Decides anew for a stage that has turned out to be less than planned. */
typedef neph_result np_stage_revise_fn(const np_assembly *made, const neph_scene *scene, np_plan *plan);

np_stage_build_once_fn np_stage_build_packets, np_stage_build_terrain, np_stage_build_lights, np_stage_build_volumes,
    np_stage_build_star_map, np_stage_build_catalogue;
np_stage_clear_once_fn np_stage_clear_packets, np_stage_clear_terrain, np_stage_clear_lights, np_stage_clear_volumes,
    np_stage_clear_star_map, np_stage_clear_catalogue;
np_stage_revise_fn np_stage_revise_volumes;

np_stage_build_light_fn np_stage_build_sun_optical_depth, np_stage_build_visibility;
np_stage_clear_light_fn np_stage_clear_sun_optical_depth, np_stage_clear_visibility;

np_stage_build_packet_fn np_stage_build_packet_lights, np_stage_build_emission, np_stage_build_atmosphere,
    np_stage_build_airglow, np_stage_build_stars;
np_stage_clear_packet_fn np_stage_clear_packet_lights, np_stage_clear_emission, np_stage_clear_atmosphere,
    np_stage_clear_airglow, np_stage_clear_stars;

np_stage_build_packet_light_fn np_stage_build_camera_sky, np_stage_build_cloud_sky, np_stage_build_world,
    np_stage_build_sky_guide, np_stage_build_ordinates, np_stage_build_viewer_light, np_stage_build_ground_clouds,
    np_stage_build_air_shadow, np_stage_build_lighting;
np_stage_clear_packet_light_fn np_stage_clear_camera_sky, np_stage_clear_cloud_sky, np_stage_clear_world,
    np_stage_clear_sky_guide, np_stage_clear_ordinates, np_stage_clear_viewer_light, np_stage_clear_ground_clouds,
    np_stage_clear_air_shadow, np_stage_clear_lighting;

#endif

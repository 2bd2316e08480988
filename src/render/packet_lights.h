/* SPDX-License-Identifier: Apache-2.0 */
/* A packet's lights: sun and moon each with its skies, and what else shines at night. */
#ifndef NP_RENDER_PACKET_LIGHTS_H
#define NP_RENDER_PACKET_LIGHTS_H

#include "render/packet.h"

typedef struct np_packet_lights_desc {
  const neph_scene *scene;
  const np_plan *plan;
  np_assembly *assembly;
  const np_scene_lights *lights;
  np_monitor *monitor;
} np_packet_lights_desc;

/* Albedo of the sphere: the terrain's, unless it was given. */
const double *np_packet_lights_ground_albedo(const neph_scene *scene);

/* A scene's three values in a packet's bands. */
np_spectrum np_packet_convert(const np_packet *packet, np_band_rule rule, const double reference[NP_BAND_COUNT]);

/* Builds what the plan needs of a packet that has its atmosphere and its clouds, and fills the views. What was built
 * before a failure stays in the packet. */
neph_result np_packet_lights_build(const np_packet_lights_desc *desc, np_packet *packet);

/* Gives back the light in clouds, and hands out the skies, for the next picture; NULL where there is none. */
void np_packet_lights_clear(const np_assembly *assembly, np_packet *packet, neph_sky *out_skies[NP_SKY_ROLES]);

#endif

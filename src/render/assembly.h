/* SPDX-License-Identifier: Apache-2.0 */
/* Everything a picture is rendered from, built as the plan says: volumes, terrain, atmosphere, skies, camera. */
#ifndef NP_RENDER_ASSEMBLY_H
#define NP_RENDER_ASSEMBLY_H

#include "light/multi_scatter.h"
#include "render/placement.h"
#include "scene/plan.h"

/* What depends on wavelength: air, skies, light in the clouds, and the scene in three bands that is made of them. */
typedef struct np_packet {
  neph_atmosphere *atmosphere;
  neph_sky *camera_sky, *cloud_sky;
  np_view_volume *placed;
  np_multi_scatter multi_scatter; /* empty when not needed */
  np_scene_view view;
} np_packet;

typedef struct np_assembly {
  neph_context *context; /* borrowed from the scene */
  np_camera camera;
  unsigned volume_count;
  neph_volume **volumes;
  np_view_volume *placed;          /* as the scene has them; each packet has its own copy */
  np_phase_table *phase_tables;    /* one a volume, empty where its phase function is none */
  np_dvec3 clouds_min, clouds_max; /* world box of all clouds */
  neph_terrain *terrain;
  unsigned packet_count;
  np_packet *packets;
} np_assembly;

/* Builds what `plan` needs for its frame; on failure nothing is left. */
neph_result np_assembly_build(const neph_scene *scene, const np_plan *plan, np_monitor *monitor,
                              np_assembly *out_assembly);
void np_assembly_clear(np_assembly *assembly);

#endif

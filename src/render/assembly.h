/* SPDX-License-Identifier: Apache-2.0 */
/* Everything a picture is rendered from, built as the plan says: volumes, terrain, atmosphere, skies, camera. */
#ifndef NP_RENDER_ASSEMBLY_H
#define NP_RENDER_ASSEMBLY_H

#include "atmosphere/band_set.h"
#include "light/multi_scatter.h"
#include "render/placement.h"
#include "scene/plan.h"

/* What depends on wavelength: air, skies, light in the clouds, and the scene in three bands that is made of them. */
typedef struct np_packet {
  np_band_set bands;
  float color_weight[3][NP_BAND_COUNT]; /* by which each band adds to the picture's R, G and B */
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

/* Adds what a packet's three bands are to a colour of the picture. */
static inline np_spectrum np_packet_add_color(const np_packet *packet, np_spectrum color, np_spectrum bands) {
  for (int c = 0; c < 3; c++)
    for (int b = 0; b < NP_BAND_COUNT; b++) color.band[c] += packet->color_weight[c][b] * bands.band[b];
  return color;
}

/* Builds what `plan` needs for its frame; on failure nothing is left. */
neph_result np_assembly_build(const neph_scene *scene, const np_plan *plan, np_monitor *monitor,
                              np_assembly *out_assembly);
void np_assembly_clear(np_assembly *assembly);

#endif

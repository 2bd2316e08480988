/* SPDX-License-Identifier: Apache-2.0 */
/* Emission of one cloud of a scene: its grids, placed with the cloud, and the unit of their values. */
#ifndef NP_RENDER_CLOUD_EMISSION_H
#define NP_RENDER_CLOUD_EMISSION_H

#include "world/emission.h"
#include "render/placement.h"

typedef struct np_cloud_emission {
  bool is_enabled;
  neph_volume *temperature, *flame; /* NULL: none */
  np_emitter emitter;               /* but for what it absorbs, which depends on the band */
  float flame_absorption_per_m;     /* of a value of 1; 0: the cloud itself emits */
  float strength;
} np_cloud_emission;

/* Source of the grids of a cloud's emission, and the volume beside them. */
typedef struct np_cloud_emission_source {
  neph_context *context;
  const np_scene_cloud *cloud;
  const char *path;
  const np_affine *file_to_world;
  const neph_volume *density; /* NULL: it holds nothing, and flames alone can emit */
  const neph_volume_load_desc *load;
} np_cloud_emission_source;

/* Reads the grids beside a cloud's density from the same file. On failure nothing is left. */
neph_result np_cloud_emission_load(const np_cloud_emission_source *source, np_cloud_emission *out_emission);
void np_cloud_emission_clear(np_cloud_emission *emission);

/* The emitter for one packet's albedo of the cloud, which may be NULL for a flame. */
np_emitter np_cloud_emission_get(const np_cloud_emission *emission, const np_instance *cloud);

#endif

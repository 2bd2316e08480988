/* SPDX-License-Identifier: Apache-2.0 */
/* What glows in one cloud of a scene: its grids, placed with the cloud, and what one value of them means. */
#ifndef NP_RENDER_CLOUD_GLOW_H
#define NP_RENDER_CLOUD_GLOW_H

#include "world/emission.h"
#include "render/placement.h"

typedef struct np_cloud_glow {
  bool is_there;
  neph_volume *temperature, *flame; /* NULL: none */
  np_glow glow;                     /* but for what it absorbs, which depends on the band */
  float flame_absorption_per_m;     /* of a value of 1; 0: the cloud itself glows */
  float strength;
} np_cloud_glow;

/* Where the grids of a cloud's emission are read from, and what they stand beside. */
typedef struct np_cloud_glow_source {
  neph_context *context;
  const np_scene_cloud *cloud;
  const char *path;
  const np_affine *file_to_world;
  const neph_volume *density; /* NULL: it holds nothing, and flames alone can glow */
  const neph_volume_load_desc *load;
} np_cloud_glow_source;

/* Reads the grids beside a cloud's density from the same file. On failure nothing is left. */
neph_result np_cloud_glow_load(const np_cloud_glow_source *source, np_cloud_glow *out_glow);
void np_cloud_glow_clear(np_cloud_glow *glow);

/* The glow for one packet's albedo of the cloud, which may be NULL for a flame. */
np_glow np_cloud_glow_get(const np_cloud_glow *glow, const np_instance *cloud);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Emission of one cloud of a scene: its grids, placed with the cloud, and the unit of their values. */
#ifndef NP_STAGES_CLOUD_EMISSION_H
#define NP_STAGES_CLOUD_EMISSION_H

#include "plan/placement.h"
#include "world/emission.h"

typedef struct np_cloud_emission {
  bool is_enabled;
  bool has_body;                    /* the cloud or its flames emit as a black body */
  neph_volume *temperature, *flame; /* NULL: none */
  neph_volume *color[3];            /* grids of red, green and blue light; NULL: none */
  np_emitter emitter;               /* the black body; its absorption depends on the band and is missing */
  np_emitter color_emitter[3];
  float flame_absorption_per_m; /* absorption at a value of 1; 0: the cloud itself emits */
  float strength;
} np_cloud_emission;

/* Files and volume from which the grids of a cloud's emission are read. */
typedef struct np_cloud_emission_source {
  neph_context *context;
  const np_scene_cloud *cloud;
  const char *path;
  const np_affine *file_to_world;
  const neph_volume *density; /* NULL: the cloud is empty, and only flames may emit */
  const neph_volume_load_desc *load;
} np_cloud_emission_source;

/* Reads the emission grids of a cloud's file. On failure nothing needs to be freed. */
neph_result np_cloud_emission_load(const np_cloud_emission_source *source, np_cloud_emission *out_emission);
void np_cloud_emission_clear(np_cloud_emission *emission);

/* Parts of a cloud with the albedo of a packet of bands, and the emission of one unit of each colour component. */
typedef struct np_emission_matter {
  const np_instance *parts; /* one at least */
  unsigned part_count;
  np_spectrum color[3];
} np_emission_matter;

/* Lists the emitters of a cloud in one packet; returns how many, at most NP_CLOUD_EMITTERS_MAX. */
unsigned np_cloud_emission_list(const np_cloud_emission *emission, const np_emission_matter *matter,
                                np_emitter out[NP_CLOUD_EMITTERS_MAX]);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/cloud_phase.h"

#include "core/alloc.h"
#include "optics/phase_bands.h"
#include "plan/plan.h"
#include "volume/volume_ice.h"
#include "volume/volume_private.h"

/* A cloud whose phase functions are loaded. */
typedef struct phase_load {
  const np_volumes_inputs *in;
  const np_scene_cloud *cloud;
  np_cloud_parts *parts;
} phase_load;

/* Tables for the bands of each packet. */
static neph_result build_phase_bands(const phase_load *c, const np_phase_source *source, np_phase_bands **out,
                                     unsigned *out_count) {
  const unsigned count = np_packet_count(c->in->plan);
  np_monitor_set_stage(c->in->monitor, "computing phase functions");
  *out = np_alloc(c->in->context, count, sizeof **out);
  neph_result result = *out ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned i = 0; i < count && !result; i++) {
    const np_band_set bands = np_packet_choose_bands(c->in->plan, i);
    result = np_phase_bands_build(c->in->context, c->in->monitor, source, bands.nm, &(*out)[i]);
    *out_count += !result;
  }
  return result;
}

static bool has_ice(const neph_volume *volume) {
  const np_tint *tint = volume ? volume->tint : NULL;
  for (unsigned k = 0; tint && k < tint->count; k++)
    if (tint->parts[k].is_ice) return true;
  return false;
}

/* The crystals of a cloud's cold part. */
static neph_result load_ice(const phase_load *c) {
  if (!has_ice(c->parts->volume)) return NEPH_OK;
  np_phase_source ice = c->cloud->phase_source;
  ice.kind = NEPH_PHASE_ICE;
  np_log(c->in->context, NEPH_LOG_INFO,
         "cloud %s: ice from %.2g km up, ice alone from %.2g km; phase: {droplets: {}} has none", c->cloud->name,
         1e-3 * NP_ICE_FROM_M, 1e-3 * NP_ICE_ALONE_M);
  return build_phase_bands(c, &ice, &c->parts->ice_bands, &c->parts->ice_bands_count);
}

static neph_result load_bands(const phase_load *c) {
  np_cloud_parts *parts = c->parts;
  const neph_result result =
      build_phase_bands(c, &c->cloud->phase_source, &parts->phase_bands, &parts->phase_bands_count);
  if (!result) parts->placed.phase = np_phase_of_bands(&parts->phase_bands[0]);
  return result;
}

neph_result np_cloud_phase_load(const np_volumes_inputs *in, const np_scene_cloud *cloud, np_cloud_parts *parts) {
  const phase_load c = {in, cloud, parts};
  neph_result result = load_ice(&c);
  if (result) return result;
  if (np_phase_kind_has_bands(cloud->phase_source.kind)) return load_bands(&c);
  if (cloud->phase_source.kind != NEPH_PHASE_TABLE) return NEPH_OK;
  np_phase_table *table = &parts->phase_table;
  result = np_phase_table_load(in->context, cloud->phase_table, table);
  if (!result) parts->placed.phase = np_phase_tabulated(table);
  return result;
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "stages/packet.h"

#include <assert.h>
#include <string.h>

#include "volume/brick_detail.h"

const np_bricks *np_cloud_parts_get_bricks(const np_cloud_parts *parts, unsigned k) {
  return parts->details[k] ? &parts->details[k]->bricks : &np_volume_get_part(parts->volume, k)->bricks;
}

/* Levels of detail have different voxel sizes. */
np_affine np_cloud_parts_get_world_to_index(const np_cloud_parts *parts, unsigned k, const np_affine *world_to_cloud) {
  const neph_volume *level = parts->volume ? np_volume_get_part(parts->volume, k) : NULL;
  if (level == parts->volume || np_volume_has_shares(parts->volume)) return *world_to_cloud;
  const np_affine between = np_affine_compose(&level->world_to_index, &parts->volume->index_to_world);
  return np_affine_compose(&between, world_to_cloud);
}

/* The table of a packet's bands; NULL: none. */
static const np_phase_bands *search_bands(const np_phase_bands *tables, unsigned count, const np_band_set *bands) {
  for (unsigned i = 0; i < count; i++)
    if (memcmp(tables[i].wavelength_nm, bands->nm, sizeof bands->nm) == 0) return &tables[i];
  assert(!tables);
  return NULL;
}

/* The phase function of a part in a packet's bands. */
static np_phase get_phase(const np_cloud_parts *parts, const np_tint_part *part, const np_band_set *bands) {
  const bool is_ice = part && part->is_ice && parts->ice_bands;
  const np_phase_bands *table = is_ice ? search_bands(parts->ice_bands, parts->ice_bands_count, bands)
                                       : search_bands(parts->phase_bands, parts->phase_bands_count, bands);
  if (table) return np_phase_of_bands(table);
  return part && part->diameter_m > 0.0 ? np_phase_droplets(part->diameter_m) : parts->placed.phase;
}

unsigned np_cloud_parts_place(const np_cloud_parts *parts, const np_scene_cloud *cloud, unsigned number,
                              const np_picture_color *color, const np_band_set *bands,
                              np_instance out[NP_TINT_PARTS_MAX]) {
  const np_tint *tint = parts->volume ? parts->volume->tint : NULL;
  const unsigned count = tint ? tint->count : 1;
  for (unsigned k = 0; k < count; k++) {
    double albedo[NP_BAND_COUNT];
    for (int b = 0; b < NP_BAND_COUNT; b++) albedo[b] = cloud->albedo[b] * (tint ? tint->parts[k].color[b] : 1.0);
    out[k] = parts->placed;
    out[k].phase = get_phase(parts, tint ? &tint->parts[k] : NULL, bands);
    out[k].number = number;
    out[k].part = k;
    if (parts->volume) out[k].bricks = np_cloud_parts_get_bricks(parts, k);
    out[k].world_to_index = np_cloud_parts_get_world_to_index(parts, k, &parts->placed.world_to_index);
    out[k].is_held_out = cloud->is_held_out;
    out[k].albedo = np_picture_color_convert_albedo(color, bands, albedo);
  }
  return count;
}

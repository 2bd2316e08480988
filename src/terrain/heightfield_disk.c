/* SPDX-License-Identifier: Apache-2.0 */
/* Height fields kept on disk, as a terrain has them: joined to the sphere. Those of files, with charts, are not kept.
 */
#include "core/alloc.h"
#include "terrain/heightfield.h"

/* All but the heights. */
typedef struct heights_header {
  double west_rad, south_rad, step_east_rad, step_north_rad;
  uint64_t void_count;
  uint32_t width, height, has_place;
  float elevation_min_m, elevation_max_m;
  uint32_t padding;
  np_field_margin margin;
} heights_header;

void np_heightfield_save_to_cache(const np_heightfield *field, np_cache_entry *entry) {
  const heights_header h = {.west_rad = field->west_rad,
                            .south_rad = field->south_rad,
                            .step_east_rad = field->step_east_rad,
                            .step_north_rad = field->step_north_rad,
                            .void_count = field->void_count,
                            .width = field->width,
                            .height = field->height,
                            .has_place = field->has_place,
                            .elevation_min_m = field->elevation_min_m,
                            .elevation_max_m = field->elevation_max_m,
                            .margin = field->margin};
  NP_CACHE_WRITE(entry, h);
  np_cache_write(entry, field->elevation_m, (size_t)field->width * field->height * sizeof *field->elevation_m);
}

bool np_heightfield_load_from_cache(np_cache_entry *entry, np_heightfield *out_field) {
  heights_header h;
  *out_field = (np_heightfield){.width = 0};
  if (!NP_CACHE_READ(entry, h)) return false;
  const uint32_t most = NP_HEIGHTFIELD_SAMPLES_MAX + 2 * NP_FIELD_MARGIN_MAX, least = 2 + 2 * h.margin.count;
  if (h.margin.count > NP_FIELD_MARGIN_MAX) return false;
  if (h.width < least || h.height < least || h.width > most || h.height > most) return false;
  *out_field = (np_heightfield){.width = h.width,
                                .height = h.height,
                                .west_rad = h.west_rad,
                                .south_rad = h.south_rad,
                                .step_east_rad = h.step_east_rad,
                                .step_north_rad = h.step_north_rad,
                                .has_place = h.has_place != 0,
                                .void_count = (size_t)h.void_count,
                                .elevation_min_m = h.elevation_min_m,
                                .elevation_max_m = h.elevation_max_m,
                                .margin = h.margin};
  out_field->elevation_m = np_cache_read_block(entry, (size_t)h.width * h.height, sizeof *out_field->elevation_m);
  return out_field->elevation_m;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Height fields on disk, already joined to the sphere. Fields from files, with charts, are not saved. */
#include "core/alloc.h"
#include "core/units.h"
#include "terrain/heightfield.h"

/* Bounds of any field. */
static const double angle_max_rad = 4.0 * NP_PI, margin_max_m = 1e8;
static const float elevation_max_m = 1e6f;

/* All members but the heights. */
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

/* Whether samples and margins lie on a planet, in ascending order. */
static bool is_sound(const heights_header *h) {
  const double angles[] = {h->west_rad, h->south_rad, h->step_east_rad, h->step_north_rad};
  const float elevations[] = {h->elevation_min_m, h->elevation_max_m};
  const np_field_margin *m = &h->margin;
  const uint32_t most = NP_HEIGHTFIELD_SAMPLES_MAX + 2 * NP_FIELD_MARGIN_MAX, least = 2 + 2 * m->count;
  if (m->count > NP_FIELD_MARGIN_MAX || h->width < least || h->height < least || h->width > most || h->height > most)
    return false;
  if (!np_cache_are_doubles_finite(angles, 4) || !np_cache_are_finite(elevations, 2)) return false;
  if (!(h->step_east_rad > 0.0 && h->step_east_rad * h->width < angle_max_rad)) return false;
  if (!(h->step_north_rad > 0.0 && h->step_north_rad * h->height < angle_max_rad)) return false;
  if (fabs(h->west_rad) > angle_max_rad || fabs(h->south_rad) > angle_max_rad) return false;
  if (m->count > 0 && !(m->cell_east_m > 0.0 && m->cell_north_m > 0.0)) return false;
  for (unsigned k = 0; k < m->count; k++)
    if (!(m->offset_m[k + 1] > m->offset_m[k] && m->offset_m[k + 1] < margin_max_m)) return false;
  return m->count == 0 || m->offset_m[0] == 0.0;
}

/* Whether heights are valid, in the file and beyond it. */
static bool are_elevations(const float *elevation_m, size_t count) {
  float most = 0.0f;
  for (size_t i = 0; i < count; i++) most = fabsf(elevation_m[i]) > most ? fabsf(elevation_m[i]) : most;
  return most <= elevation_max_m;
}

bool np_heightfield_load_from_cache(np_cache_entry *entry, np_heightfield *out_field) {
  heights_header h;
  *out_field = (np_heightfield){.width = 0};
  if (!NP_CACHE_READ(entry, h)) return false;
  if (!np_cache_read_check(entry, is_sound(&h))) return false;
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
  const size_t count = (size_t)h.width * h.height;
  float *elevation_m = np_cache_read_floats(entry, count);
  if (elevation_m && np_cache_read_check(entry, are_elevations(elevation_m, count))) {
    out_field->elevation_m = elevation_m;
    return true;
  }
  np_alloc_free(entry->context, elevation_m);
  *out_field = (np_heightfield){.width = 0};
  return false;
}

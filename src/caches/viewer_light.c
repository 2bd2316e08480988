/* SPDX-License-Identifier: Apache-2.0 */
#include "caches/viewer_light.h"

#include <assert.h>

#include "core/alloc.h"

/* Least ratio of distance over width of the cells in queries. */
static const double distance_over_width = 32.0;

static double compute_distance_min(const np_scattering_field *field, np_dvec3 viewer) {
  double least = 0.0;
  for (size_t cell = 0; cell < np_scattering_field_count_cells(field); cell++) {
    double width;
    const np_dvec3 centre = np_scattering_field_get_cell(field, cell, &width);
    const double distance = np_dvec3_length(np_dvec3_subtract(centre, viewer));
    if (distance < distance_over_width * width) least = fmax(least, distance + 2.0 * width);
  }
  return least;
}

typedef struct viewer_build {
  const np_scattering_field *field;
  np_viewer_light *light;
} viewer_build;

static neph_result fill_cells(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const viewer_build *b = user;
  const np_viewer_light *l = b->light;
  const size_t stride = (size_t)l->phase_count * l->band_count;
  for (size_t cell = begin; cell < end; cell++) {
    double width;
    const np_dvec3 way = np_dvec3_subtract(l->viewer, np_scattering_field_get_cell(b->field, cell, &width));
    if (!(np_dvec3_length(way) > 0.0)) continue;
    np_scattering_field_fill_cell(b->field, cell, np_dvec3_to_float(np_dvec3_normalize(way)),
                                  l->outgoing + cell * stride);
  }
  return NEPH_OK;
}

/* A viewer light without values. */
static np_viewer_light make_empty(neph_context *context, const np_scattering_field *field, np_dvec3 viewer) {
  const np_scattering_medium *medium = np_scattering_field_get_medium(field);
  return (np_viewer_light){.context = context,
                           .viewer = viewer,
                           .phase_count = medium->phase_count,
                           .band_count = medium->band_count,
                           .colour = medium->colour};
}

neph_result np_viewer_light_build(neph_context *context, const np_scattering_field *field, np_dvec3 viewer,
                                  np_monitor *monitor, np_viewer_light *out) {
  const size_t cells = np_scattering_field_count_cells(field);
  *out = make_empty(context, field, viewer);
  out->distance_min = compute_distance_min(field, viewer);
  out->outgoing = np_alloc(context, cells * out->phase_count, out->band_count * sizeof *out->outgoing);
  if (!out->outgoing) return NEPH_ERROR_OUT_OF_MEMORY;
  viewer_build b = {field, out};
  const neph_result result = np_parallel_for(context, monitor, cells, 256, fill_cells, &b);
  if (result) np_viewer_light_clear(out);
  return result;
}

static size_t count_values(const np_viewer_light *light, const np_scattering_field *field) {
  assert(light->phase_count >= 1 && light->band_count >= 1 && light->band_count <= NP_BAND_COUNT);
  return np_scattering_field_count_cells(field) * light->phase_count * light->band_count;
}

void np_viewer_light_save(const np_viewer_light *light, const np_scattering_field *field, np_cache_entry *entry) {
  NP_CACHE_WRITE(entry, light->distance_min);
  np_cache_write(entry, light->outgoing, count_values(light, field) * sizeof *light->outgoing);
}

bool np_viewer_light_load(neph_context *context, const np_scattering_field *field, np_dvec3 viewer,
                          np_cache_entry *entry, np_viewer_light *out) {
  *out = make_empty(context, field, viewer);
  if (!NP_CACHE_READ(entry, out->distance_min)) return false;
  if (!np_cache_read_check(entry, isfinite(out->distance_min))) return false;
  out->outgoing = np_cache_read_block(entry, count_values(out, field), sizeof *out->outgoing);
  return out->outgoing;
}

void np_viewer_light_clear(np_viewer_light *light) {
  np_alloc_free(light->context, light->outgoing);
  *light = (np_viewer_light){0};
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "caches/viewer_light.h"

#include "core/alloc.h"

/* Distance over width of the nearest cells that are asked for. */
static const double distance_over_width = 32.0;

/* Clouds of one phase function share its table, and all that is thrown. */
static void find_kinds(const np_scattering_field *scatter, np_viewer_light *light) {
  for (unsigned v = 0; v < scatter->volume_count; v++) {
    unsigned same = 0;
    while (same < v && scatter->phases[same].peak != scatter->phases[v].peak) same++;
    light->kind[v] = same < v ? light->kind[same] : (unsigned char)light->kind_count++;
  }
}

static double find_width(const np_transport_grid *g, int32_t cell) {
  int32_t at[3];
  np_transport_grid_split(g, cell, at);
  double width = 0.0;
  for (int a = 0; a < 3; a++) width = fmax(width, np_transport_grid_width(g, a, at[a]));
  return width;
}

static void find_distance_min(const np_transport_grid *g, np_viewer_light *light) {
  for (size_t active = 0; active < g->active_count; active++) {
    const np_dvec3 centre = np_transport_grid_centre(g, g->cell[active]);
    const double distance = np_dvec3_length(np_dvec3_subtract(centre, light->viewer));
    const double width = find_width(g, g->cell[active]);
    if (distance < distance_over_width * width) light->distance_min = fmax(light->distance_min, distance + 2.0 * width);
  }
}

typedef struct viewer_build {
  const np_scattering_field *scatter;
  np_viewer_light *light;
} viewer_build;

static void unpack(const np_scattering_field *scatter, size_t active, np_light_moments *out) {
  const unsigned count = np_harmonics_count(scatter->grid.degree), width = scatter->band_count * count;
  for (unsigned i = 0; i < width; i++) out->value[i] = 0.0f;
  for (unsigned i = 0; i < width; i += NP_MOMENT_LANES)
    np_moments_add(scatter->moments + active * width + i, scatter->scale[i / count], out->value + i);
}

/* What clouds of one phase function throw; before it is known to be positive, as interpolants are. */
static void throw_moments(const np_scattering_field *scatter, const np_light_moments *moments,
                          const float outgoing[NP_HARMONIC_COUNT_MAX], float *out) {
  const unsigned count = np_harmonics_count(scatter->grid.degree);
  for (unsigned b = 0; b < scatter->band_count; b++)
    out[b] = np_scattering_field_sum(moments->value + b * count, outgoing, count);
}

static neph_result fill_cells(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const viewer_build *b = user;
  const np_scattering_field *s = b->scatter;
  np_viewer_light *l = b->light;
  for (size_t active = begin; active < end; active++) {
    const np_dvec3 centre = np_transport_grid_centre(&s->grid, s->grid.cell[active]);
    const np_dvec3 way = np_dvec3_subtract(l->viewer, centre);
    if (!(np_dvec3_length(way) > 0.0)) continue;
    float harmonics[NP_HARMONIC_COUNT_MAX], outgoing[NP_HARMONIC_COUNT_MAX];
    np_light_moments moments;
    np_harmonics_eval(s->grid.degree, np_dvec3_to_float(np_dvec3_normalize(way)), harmonics);
    unpack(s, active, &moments);
    for (unsigned v = 0, known = 0; v < s->volume_count; v++) {
      if (l->kind[v] < known) continue;
      np_scattering_field_fill_outgoing(&s->phases[v], harmonics, outgoing);
      throw_moments(s, &moments, outgoing, l->outgoing + (active * l->kind_count + known++) * s->band_count);
    }
  }
  return NEPH_OK;
}

neph_result np_viewer_light_build(neph_context *context, const np_scattering_field *scatter, np_dvec3 viewer,
                                  np_monitor *monitor, np_viewer_light *out) {
  *out = (np_viewer_light){.context = context, .viewer = viewer};
  find_kinds(scatter, out);
  find_distance_min(&scatter->grid, out);
  const size_t cells = scatter->grid.active_count;
  out->outgoing = np_alloc(context, cells * out->kind_count, scatter->band_count * sizeof *out->outgoing);
  if (!out->outgoing) return NEPH_ERROR_OUT_OF_MEMORY;
  viewer_build b = {scatter, out};
  const neph_result result = np_parallel_for(context, monitor, cells, 256, fill_cells, &b);
  if (result) np_viewer_light_clear(out);
  return result;
}

void np_viewer_light_clear(np_viewer_light *light) {
  np_alloc_free(light->context, light->outgoing);
  *light = (np_viewer_light){0};
}

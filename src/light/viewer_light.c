/* SPDX-License-Identifier: Apache-2.0 */
#include "light/viewer_light.h"

#include "core/alloc.h"

/* Distance over width of the nearest cells that are asked for. */
static const double distance_over_width = 32.0;

/* Clouds of one phase function share its table, and all that is thrown. */
static void find_kinds(const np_multi_scatter *scatter, np_viewer_light *light) {
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
  for (size_t live = 0; live < g->live_count; live++) {
    const np_dvec3 centre = np_transport_grid_centre(g, g->cell[live]);
    const double distance = np_dvec3_length(np_dvec3_subtract(centre, light->viewer));
    const double width = find_width(g, g->cell[live]);
    if (distance < distance_over_width * width) light->distance_min = fmax(light->distance_min, distance + 2.0 * width);
  }
}

typedef struct build {
  const np_multi_scatter *scatter;
  np_viewer_light *light;
} build;

static void unpack(const np_multi_scatter *scatter, size_t live, np_light_moments *out) {
  const unsigned count = np_harmonics_count(scatter->grid.degree), width = scatter->band_count * count;
  for (unsigned i = 0; i < width; i++) out->value[i] = 0.0f;
  for (unsigned i = 0; i < width; i += NP_MOMENT_LANES)
    np_moments_add(scatter->moments + live * width + i, scatter->scale[i / count], out->value + i);
}

/* What clouds of one phase function throw; before it is known to be positive, as interpolants are. */
static void throw_moments(const np_multi_scatter *scatter, const np_light_moments *moments,
                          const float thrown[NP_HARMONIC_COUNT_MAX], float *out) {
  const unsigned count = np_harmonics_count(scatter->grid.degree);
  for (unsigned b = 0; b < scatter->band_count; b++)
    out[b] = np_multi_scatter_sum(moments->value + b * count, thrown, count);
}

static neph_result fill_cells(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const build *b = user;
  const np_multi_scatter *s = b->scatter;
  np_viewer_light *l = b->light;
  for (size_t live = begin; live < end; live++) {
    const np_dvec3 centre = np_transport_grid_centre(&s->grid, s->grid.cell[live]);
    const np_dvec3 way = np_dvec3_subtract(l->viewer, centre);
    if (!(np_dvec3_length(way) > 0.0)) continue;
    float harmonics[NP_HARMONIC_COUNT_MAX], thrown[NP_HARMONIC_COUNT_MAX];
    np_light_moments moments;
    np_harmonics_eval(s->grid.degree, np_dvec3_to_float(np_dvec3_normalize(way)), harmonics);
    unpack(s, live, &moments);
    for (unsigned v = 0, known = 0; v < s->volume_count; v++) {
      if (l->kind[v] < known) continue;
      np_multi_scatter_fill_thrown(&s->phases[v], harmonics, thrown);
      throw_moments(s, &moments, thrown, l->thrown + (live * l->kind_count + known++) * s->band_count);
    }
  }
  return NEPH_OK;
}

neph_result np_viewer_light_build(neph_context *context, const np_multi_scatter *scatter, np_dvec3 viewer,
                                  np_monitor *monitor, np_viewer_light *out) {
  *out = (np_viewer_light){.context = context, .viewer = viewer};
  find_kinds(scatter, out);
  find_distance_min(&scatter->grid, out);
  const size_t cells = scatter->grid.live_count;
  out->thrown = np_alloc(context, cells * out->kind_count, scatter->band_count * sizeof *out->thrown);
  if (!out->thrown) return NEPH_ERROR_OUT_OF_MEMORY;
  build b = {scatter, out};
  const neph_result result = np_parallel_for(context, monitor, cells, 256, fill_cells, &b);
  if (result) np_viewer_light_clear(out);
  return result;
}

void np_viewer_light_clear(np_viewer_light *light) {
  np_alloc_free(light->context, light->thrown);
  *light = (np_viewer_light){0};
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "light/emission.h"

#include <string.h>

#include "core/alloc.h"

/* Points along each edge of a cell at which its power is measured: every second sample. */
enum { POINTS = 4 };

static np_spectrum eval_glow(const np_emission *emission, const np_glow *glow, np_dvec3 position) {
  const float value = np_bricks_sample(glow->bricks, np_affine_point(&glow->world_to_index, position));
  return np_glow_eval(emission, glow, position, value);
}

np_spectrum np_emission_eval(const np_emission *emission, np_dvec3 position) {
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (unsigned g = 0; g < emission->glow_count; g++)
    sum = np_spectrum_add(sum, eval_glow(emission, &emission->glows[g], position));
  return sum;
}

static int count_points(const np_glow *glow, np_vec3 edge) {
  const np_dvec3 voxels = np_affine_vector(&glow->world_to_index, np_vec3_to_double(edge));
  return (int)np_clamp(ceil(2.0 * np_dvec3_length(voxels) - 0.01), 1.0, 6.0);
}

static np_spectrum average_glow(const np_emission *emission, const np_glow *glow, np_dvec3 low, np_dvec3 size) {
  const int nx = count_points(glow, np_vec3_make((float)size.x, 0.0f, 0.0f)),
            ny = count_points(glow, np_vec3_make(0.0f, (float)size.y, 0.0f)),
            nz = count_points(glow, np_vec3_make(0.0f, 0.0f, (float)size.z));
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (int n = 0; n < nx * ny * nz; n++) {
    const np_dvec3 position =
        np_dvec3_make(low.x + (n % nx + 0.5) / nx * size.x, low.y + (n / nx % ny + 0.5) / ny * size.y,
                      low.z + (n / nx / ny + 0.5) / nz * size.z);
    sum = np_spectrum_add(sum, eval_glow(emission, glow, position));
  }
  return np_spectrum_scale(sum, 1.0f / (float)(nx * ny * nz));
}

np_spectrum np_emission_average(const np_emission *emission, np_dvec3 low, np_dvec3 size) {
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (unsigned g = 0; g < emission->glow_count; g++)
    sum = np_spectrum_add(sum, average_glow(emission, &emission->glows[g], low, size));
  return sum;
}

/* ---- The list of cells ---- */

typedef struct survey {
  np_emission *emission;
  np_glow *glow;
  np_monitor *monitor;
  np_spectrum *power; /* of each cell of the glow's table, W sr⁻¹ nm⁻¹ */
} survey;

static void get_cell(const np_bricks *bricks, size_t offset, int32_t out_cell[3]) {
  const size_t ny = (size_t)bricks->size[0][1], nz = (size_t)bricks->size[0][2];
  out_cell[0] = bricks->origin[0] + (int32_t)(offset / (ny * nz));
  out_cell[1] = bricks->origin[1] + (int32_t)(offset / nz % ny);
  out_cell[2] = bricks->origin[2] + (int32_t)(offset % nz);
}

static double get_cell_volume(const np_glow *glow) {
  const double edge = NP_BRICK_EDGE;
  return fabs(np_affine_determinant(&glow->index_to_world)) * edge * edge * edge;
}

/* A place in a cell, `place` in [0, 1]³. */
static np_dvec3 find_index(const int32_t cell[3], const double place[3]) {
  return np_dvec3_make(NP_BRICK_EDGE * (cell[0] + place[0]), NP_BRICK_EDGE * (cell[1] + place[1]),
                       NP_BRICK_EDGE * (cell[2] + place[2]));
}

static np_spectrum measure_cell(const survey *s, size_t offset) {
  const np_bricks *bricks = s->glow->bricks;
  np_spectrum sum = np_spectrum_grey(0.0f);
  if (np_brick_range_is_zero(bricks->ranges[0][offset])) return sum;
  int32_t cell[3];
  get_cell(bricks, offset, cell);
  for (int n = 0; n < POINTS * POINTS * POINTS; n++) {
    const double place[3] = {(n % POINTS + 0.5) / POINTS, (n / POINTS % POINTS + 0.5) / POINTS,
                             (n / POINTS / POINTS + 0.5) / POINTS};
    const np_dvec3 index = find_index(cell, place);
    const np_dvec3 position = np_affine_point(&s->glow->index_to_world, index);
    sum = np_spectrum_add(sum, np_glow_eval(s->emission, s->glow, position, np_bricks_sample(bricks, index)));
  }
  return np_spectrum_scale(sum, (float)(get_cell_volume(s->glow) / (POINTS * POINTS * POINTS)));
}

static neph_result measure_cells(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const survey *s = user;
  if (np_monitor_is_cancelled(s->monitor)) return NEPH_ERROR_CANCELLED;
  for (size_t offset = begin; offset < end; offset++) s->power[offset] = measure_cell(s, offset);
  return NEPH_OK;
}

static neph_result list_cells(np_emission *e, unsigned g, const np_spectrum *power) {
  const np_glow *glow = &e->glows[g];
  const size_t count = np_bricks_count_cells(glow->bricks, 0);
  size_t bright = e->cell_count;
  for (size_t offset = 0; offset < count; offset++) bright += np_spectrum_max(power[offset]) > 0.0f;
  np_glow_cell *cells = np_alloc_resize(e->context, e->cells, bright, sizeof *cells);
  if (!cells) return NEPH_ERROR_OUT_OF_MEMORY;
  e->cells = cells;
  for (size_t offset = 0; offset < count; offset++) {
    e->power_w_sr_nm = np_spectrum_add(e->power_w_sr_nm, power[offset]);
    if (!(np_spectrum_max(power[offset]) > 0.0f)) continue;
    np_glow_cell *cell = &e->cells[e->cell_count++];
    *cell = (np_glow_cell){.glow = g, .cumulative = (double)np_spectrum_mean(power[offset])};
    get_cell(glow->bricks, offset, cell->cell);
  }
  return NEPH_OK;
}

/* A glow without end has no power to draw by. */
static neph_result survey_glow(np_emission *e, unsigned g, np_monitor *monitor) {
  np_glow *glow = &e->glows[g];
  if (glow->bricks->is_periodic[0] || glow->bricks->is_periodic[1]) return NEPH_OK;
  const size_t count = np_bricks_count_cells(glow->bricks, 0);
  survey s = {e, glow, monitor, np_alloc(e->context, count, sizeof *s.power)};
  glow->cell_density = np_alloc(e->context, count, sizeof *glow->cell_density);
  neph_result result = s.power && glow->cell_density ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = np_parallel_for(e->context, monitor, count, 256, measure_cells, &s);
  if (!result) result = list_cells(e, g, s.power);
  np_alloc_free(e->context, s.power);
  return result;
}

/* From powers to shares, and to densities of a point. */
static void normalize(np_emission *e) {
  double total = 0.0, sum = 0.0;
  for (size_t i = 0; i < e->cell_count; i++) total += e->cells[i].cumulative;
  for (size_t i = 0; i < e->cell_count; i++) {
    np_glow_cell *c = &e->cells[i];
    const np_glow *glow = &e->glows[c->glow];
    const double share = c->cumulative / total;
    int32_t inside[3];
    for (int a = 0; a < 3; a++) inside[a] = c->cell[a] - glow->bricks->origin[a];
    glow->cell_density[np_bricks_get_offset(glow->bricks, 0, inside)] = (float)(share / get_cell_volume(glow));
    c->cumulative = sum += share;
  }
}

neph_result np_emission_build(neph_context *context, const np_glow *glows, unsigned count,
                              const double wavelength_nm[NP_BAND_COUNT], np_monitor *monitor, np_emission *out) {
  *out = (np_emission){.context = context, .black_body = np_black_body_make(wavelength_nm)};
  out->glows = np_alloc(context, count, sizeof *out->glows);
  neph_result result = out->glows ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (unsigned g = 0; g < count && !result; g++) {
    out->glows[out->glow_count++] = glows[g];
    result = survey_glow(out, g, monitor);
  }
  if (!result) normalize(out);
  if (result) np_emission_clear(out);
  return result;
}

void np_emission_clear(np_emission *emission) {
  for (unsigned g = 0; g < emission->glow_count; g++) np_alloc_free(emission->context, emission->glows[g].cell_density);
  np_alloc_free(emission->context, emission->glows);
  np_alloc_free(emission->context, emission->cells);
  *emission = (np_emission){0};
}

/* ---- Drawing ---- */

bool np_emission_draw(const np_emission *emission, np_random *random, np_dvec3 *out_position) {
  if (emission->cell_count == 0) return false;
  const double u = np_random_double(random);
  const double place[3] = {np_random_double(random), np_random_double(random), np_random_double(random)};
  size_t low = 0, high = emission->cell_count - 1;
  while (low < high) {
    const size_t middle = (low + high) / 2;
    if (emission->cells[middle].cumulative > u)
      high = middle;
    else
      low = middle + 1;
  }
  const np_glow_cell *cell = &emission->cells[low];
  *out_position = np_affine_point(&emission->glows[cell->glow].index_to_world, find_index(cell->cell, place));
  return true;
}

float np_emission_direction_density(const np_emission *emission, np_dvec3 origin, np_vec3 direction) {
  double sum = 0.0;
  for (unsigned g = 0; g < emission->glow_count; g++) {
    const np_glow *glow = &emission->glows[g];
    if (!glow->cell_density) continue;
    np_brick_walk walk;
    np_brick_span span;
    np_brick_walk_start(&walk, glow->bricks, np_affine_point(&glow->world_to_index, origin),
                        np_affine_vector(&glow->world_to_index, np_vec3_to_double(direction)), 0.0, INFINITY);
    while (np_brick_walk_next(&walk, &span)) {
      int32_t inside[3];
      for (int a = 0; a < 3; a++) inside[a] = span.cell[a] - glow->bricks->origin[a];
      const double from = span.t_begin, to = span.t_end;
      sum += (double)glow->cell_density[np_bricks_get_offset(glow->bricks, 0, inside)] *
             (to * to * to - from * from * from) * (1.0 / 3.0);
    }
  }
  return (float)sum;
}

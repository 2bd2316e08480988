/* SPDX-License-Identifier: Apache-2.0 */
#include "world/emission.h"

#include <assert.h>
#include <string.h>

#include "core/alloc.h"

enum { PROBES = 4, LAMPS_MAX = 1 << 20 };

static np_spectrum eval_emitter(const np_emission *emission, const np_emitter *emitter, np_dvec3 position) {
  const float value = np_bricks_sample(emitter->bricks, np_affine_point(&emitter->world_to_index, position));
  return np_emitter_eval(emission, emitter, position, value);
}

np_spectrum np_emission_eval(const np_emission *emission, np_dvec3 position) {
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (unsigned g = 0; g < emission->emitter_count; g++)
    sum = np_spectrum_add(sum, eval_emitter(emission, &emission->emitters[g], position));
  return sum;
}

static int count_points(const np_emitter *emitter, np_vec3 edge) {
  const np_dvec3 voxels = np_affine_vector(&emitter->world_to_index, np_vec3_to_double(edge));
  return (int)np_clamp(ceil(2.0 * np_dvec3_length(voxels) - 0.01), 1.0, 6.0);
}

static np_spectrum average_emitter(const np_emission *emission, const np_emitter *emitter, np_dvec3 low,
                                   np_dvec3 size) {
  const int nx = count_points(emitter, np_vec3_make((float)size.x, 0.0f, 0.0f)),
            ny = count_points(emitter, np_vec3_make(0.0f, (float)size.y, 0.0f)),
            nz = count_points(emitter, np_vec3_make(0.0f, 0.0f, (float)size.z));
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (int n = 0; n < nx * ny * nz; n++) {
    const np_dvec3 position =
        np_dvec3_make(low.x + (n % nx + 0.5) / nx * size.x, low.y + (n / nx % ny + 0.5) / ny * size.y,
                      low.z + (n / nx / ny + 0.5) / nz * size.z);
    sum = np_spectrum_add(sum, eval_emitter(emission, emitter, position));
  }
  return np_spectrum_scale(sum, 1.0f / (float)(nx * ny * nz));
}

np_spectrum np_emission_average(const np_emission *emission, np_dvec3 low, np_dvec3 size) {
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (unsigned g = 0; g < emission->emitter_count; g++)
    sum = np_spectrum_add(sum, average_emitter(emission, &emission->emitters[g], low, size));
  return sum;
}

/* ---- Sampled cells ---- */

static np_dvec3 get_index(const np_emitter_grid *grid, size_t cell, const double place[3]) {
  const size_t ny = (size_t)grid->size[1], nz = (size_t)grid->size[2];
  return np_dvec3_make(grid->low[0] + grid->edge * ((double)(cell / (ny * nz)) + place[0]),
                       grid->low[1] + grid->edge * ((double)(cell / nz % ny) + place[1]),
                       grid->low[2] + grid->edge * ((double)(cell % nz) + place[2]));
}

/* Mean of j in a box of index space, over n³ points of it. */
static np_spectrum probe_box(const np_emission *e, const np_emitter *emitter, np_dvec3 low, double edge, int n) {
  np_spectrum sum = np_spectrum_grey(0.0f);
  for (int i = 0; i < n * n * n; i++) {
    const np_dvec3 index = np_dvec3_make(low.x + edge * (i % n + 0.5) / n, low.y + edge * (i / n % n + 0.5) / n,
                                         low.z + edge * (i / n / n + 0.5) / n);
    const float value = np_bricks_sample(emitter->bricks, index);
    if (value > 0.0f)
      sum = np_spectrum_add(sum, np_emitter_eval(e, emitter, np_affine_point(&emitter->index_to_world, index), value));
  }
  return np_spectrum_scale(sum, 1.0f / (float)(n * n * n));
}

/* Narrows [low, high), in cells of the bricks' table, to the cells with emission. */
static bool compute_emitting_box(const np_emission *e, const np_emitter *emitter, int32_t low[3], int32_t high[3]) {
  const np_bricks *bricks = emitter->bricks;
  const int32_t *size = bricks->size;
  bool is_bright = false;
  int32_t cell[3];
  for (cell[0] = 0; cell[0] < size[0]; cell[0]++)
    for (cell[1] = 0; cell[1] < size[1]; cell[1]++)
      for (cell[2] = 0; cell[2] < size[2]; cell[2]++) {
        const np_brick_place at = np_bricks_get_place(bricks, cell);
        if (np_brick_range_is_zero(np_bricks_get_range(bricks, &at, 0))) continue;
        const np_dvec3 corner = np_dvec3_make((double)(bricks->origin[0] + cell[0]) * NP_BRICK_EDGE,
                                              (double)(bricks->origin[1] + cell[1]) * NP_BRICK_EDGE,
                                              (double)(bricks->origin[2] + cell[2]) * NP_BRICK_EDGE);
        if (!(np_spectrum_max(probe_box(e, emitter, corner, NP_BRICK_EDGE, PROBES)) > 0.0f)) continue;
        for (int a = 0; a < 3; a++) {
          low[a] = is_bright && low[a] < cell[a] ? low[a] : cell[a];
          high[a] = is_bright && high[a] > cell[a] + 1 ? high[a] : cell[a] + 1;
        }
        is_bright = true;
      }
  return is_bright;
}

/* Places a grid of cells of two voxels, or larger where their number would exceed the limit. */
static void place_grid(const np_bricks *bricks, const int32_t low[3], const int32_t high[3], np_emitter_grid *out) {
  double count;
  out->edge = 1.0;
  do {
    out->edge *= 2.0;
    count = 1.0;
    for (int a = 0; a < 3; a++) {
      out->low[a] = (double)(bricks->origin[a] + low[a]) * NP_BRICK_EDGE;
      out->size[a] = (int32_t)ceil((double)(high[a] - low[a]) * NP_BRICK_EDGE / out->edge);
      count *= out->size[a];
    }
  } while (count > LAMPS_MAX);
}

static size_t count_cells(const np_emitter_grid *grid) {
  return (size_t)grid->size[0] * (size_t)grid->size[1] * (size_t)grid->size[2];
}

static double get_cell_volume(const np_emitter *emitter, const np_emitter_grid *grid) {
  return fabs(np_affine_determinant(&emitter->index_to_world)) * pow(grid->edge, 3.0);
}

typedef struct survey {
  const np_emission *emission;
  const np_emitter *emitter;
  const np_emitter_grid *grid;
  np_monitor *monitor;
  np_spectrum *power; /* power of each cell, W sr⁻¹ nm⁻¹ */
} survey;

static neph_result measure_cells(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const survey *s = user;
  const double corner[3] = {0.0, 0.0, 0.0};
  const float volume = (float)get_cell_volume(s->emitter, s->grid);
  const int n = s->grid->edge < 8.0 ? 2 : PROBES;
  if (np_monitor_is_cancelled(s->monitor)) return NEPH_ERROR_CANCELLED;
  for (size_t cell = begin; cell < end; cell++) {
    const np_dvec3 low = get_index(s->grid, cell, corner);
    s->power[cell] = np_spectrum_scale(probe_box(s->emission, s->emitter, low, s->grid->edge, n), volume);
  }
  return NEPH_OK;
}

static neph_result list_cells(np_emission *e, unsigned emitter, const np_spectrum *power) {
  const size_t count = count_cells(&e->grids[emitter]);
  size_t bright = e->cell_count;
  for (size_t cell = 0; cell < count; cell++) bright += np_spectrum_max(power[cell]) > 0.0f;
  np_emitter_cell *list = np_alloc_resize(e->context, e->list, bright, sizeof *list);
  if (!list) return NEPH_ERROR_OUT_OF_MEMORY;
  e->list = list;
  for (size_t cell = 0; cell < count; cell++) {
    e->power_w_sr_nm = np_spectrum_add(e->power_w_sr_nm, power[cell]);
    if (np_spectrum_max(power[cell]) > 0.0f)
      e->list[e->cell_count++] = (np_emitter_cell){emitter, (uint32_t)cell, (double)np_spectrum_mean(power[cell])};
  }
  return NEPH_OK;
}

/* Builds the grid of an emitter. An unbounded emitter has no finite power, so that it is not sampled. */
static neph_result build_grid(np_emission *e, unsigned index, np_monitor *monitor) {
  const np_emitter *emitter = &e->emitters[index];
  np_emitter_grid *grid = &e->grids[index];
  int32_t low[3], high[3];
  if (emitter->bricks->is_periodic[0] || emitter->bricks->is_periodic[1] ||
      !compute_emitting_box(e, emitter, low, high))
    return NEPH_OK;
  place_grid(emitter->bricks, low, high, grid);
  const size_t count = count_cells(grid);
  assert(count > 0 && count <= LAMPS_MAX);
  survey s = {e, emitter, grid, monitor, np_alloc(e->context, count, sizeof *s.power)};
  grid->density = np_alloc(e->context, count, sizeof *grid->density);
  neph_result result = s.power && grid->density ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result) result = np_parallel_for(e->context, monitor, count, 1024, measure_cells, &s);
  if (!result) result = list_cells(e, index, s.power);
  np_alloc_free(e->context, s.power);
  return result;
}

/* Converts powers to shares, and to densities of points. */
static void normalize(np_emission *e) {
  double total = 0.0, sum = 0.0;
  for (size_t i = 0; i < e->cell_count; i++) total += e->list[i].cumulative;
  for (size_t i = 0; i < e->cell_count; i++) {
    np_emitter_cell *source = &e->list[i];
    const double share = source->cumulative / total;
    np_emitter_grid *grid = &e->grids[source->emitter];
    grid->density[source->cell] = (float)(share / get_cell_volume(&e->emitters[source->emitter], grid));
    source->cumulative = sum += share;
    assert(share >= 0.0 && sum <= 1.0 + 1e-6);
  }
}

neph_result np_emission_build(neph_context *context, const np_emitter *emitters, unsigned count,
                              const np_black_body *body, np_monitor *monitor, np_emission *out) {
  *out = (np_emission){.context = context, .black_body = *body};
  out->emitters = np_alloc(context, count, sizeof *out->emitters);
  out->grids = np_alloc(context, count, sizeof *out->grids);
  neph_result result = out->emitters && out->grids ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  for (; out->emitter_count < count && !result; out->emitter_count++) {
    out->emitters[out->emitter_count] = emitters[out->emitter_count];
    result = build_grid(out, out->emitter_count, monitor);
  }
  if (!result) normalize(out);
  if (result) np_emission_clear(out);
  return result;
}

void np_emission_clear(np_emission *emission) {
  for (unsigned g = 0; g < emission->emitter_count; g++) np_alloc_free(emission->context, emission->grids[g].density);
  np_alloc_free(emission->context, emission->grids);
  np_alloc_free(emission->context, emission->emitters);
  np_alloc_free(emission->context, emission->list);
  *emission = (np_emission){0};
}

/* ---- Sampling ---- */

bool np_emission_draw(const np_emission *emission, double u, np_random *random, np_dvec3 *out_position) {
  if (emission->cell_count == 0) return false;
  assert(u >= 0.0 && u < 1.0);
  const double place[3] = {np_random_double(random), np_random_double(random), np_random_double(random)};
  size_t low = 0, high = emission->cell_count - 1;
  while (low < high) {
    const size_t middle = (low + high) / 2;
    if (emission->list[middle].cumulative > u)
      high = middle;
    else
      low = middle + 1;
  }
  const np_emitter_cell *source = &emission->list[low];
  *out_position = np_affine_point(&emission->emitters[source->emitter].index_to_world,
                                  get_index(&emission->grids[source->emitter], source->cell, place));
  return true;
}

/* Interval of a ray inside an emitter's grid; in units of a cell, from its first corner. */
typedef struct grid_passage {
  double origin[3], inverse[3], begin, end; /* inverse: 0 where the ray stays in one layer */
} grid_passage;

static bool enter(const np_emitter *emitter, const np_emitter_grid *grid, np_dvec3 origin, np_vec3 direction,
                  grid_passage *out) {
  const np_dvec3 o = np_affine_point(&emitter->world_to_index, origin);
  const np_dvec3 d = np_affine_vector(&emitter->world_to_index, np_vec3_to_double(direction));
  const double from[3] = {o.x, o.y, o.z}, along[3] = {d.x, d.y, d.z};
  out->begin = 0.0;
  out->end = HUGE_VAL;
  for (int a = 0; a < 3; a++) {
    out->origin[a] = (from[a] - grid->low[a]) / grid->edge;
    const double inverse = grid->edge / along[a];
    out->inverse[a] = fabs(inverse) <= 1e30 ? inverse : 0.0;
    if (out->inverse[a] == 0.0) {
      if (!(out->origin[a] >= 0.0 && out->origin[a] < grid->size[a])) return false;
      continue;
    }
    const double near = -out->origin[a] * inverse, far = (grid->size[a] - out->origin[a]) * inverse;
    out->begin = fmax(out->begin, fmin(near, far));
    out->end = fmin(out->end, fmax(near, far));
  }
  return out->begin < out->end;
}

/* Integral of density times distance²: Σ p·(s₁³ − s₀³)/3 through one lattice, from cell to cell (Amanatides and Woo
 * 1987), each face's distance computed from the ray. */
static double sum_cells(const np_emitter_grid *grid, const grid_passage *p) {
  int32_t cell[3];
  double sum = 0.0;
  for (int a = 0; a < 3; a++) {
    const double at = p->origin[a] + (p->inverse[a] == 0.0 ? 0.0 : p->begin / p->inverse[a]);
    cell[a] = (int32_t)np_clamp(floor(at), 0.0, grid->size[a] - 1.0);
  }
  for (double from = p->begin; from < p->end;) {
    double to = p->end;
    int axis = -1;
    for (int a = 0; a < 3; a++) {
      if (p->inverse[a] == 0.0) continue;
      const double leave = (cell[a] + (p->inverse[a] > 0.0) - p->origin[a]) * p->inverse[a];
      if (leave >= to) continue;
      to = leave;
      axis = a;
    }
    to = fmax(to, from);
    const float density = grid->density[(cell[0] * grid->size[1] + cell[1]) * grid->size[2] + cell[2]];
    sum += (double)density * (to * to * to - from * from * from) * (1.0 / 3.0);
    if (axis < 0) break;
    cell[axis] += p->inverse[axis] > 0.0 ? 1 : -1;
    if (cell[axis] < 0 || cell[axis] >= grid->size[axis]) break;
    from = to;
  }
  return sum;
}

float np_emission_direction_density(const np_emission *emission, np_dvec3 origin, np_vec3 direction) {
  double sum = 0.0;
  for (unsigned g = 0; g < emission->emitter_count; g++) {
    grid_passage p;
    const np_emitter_grid *grid = &emission->grids[g];
    if (grid->density && enter(&emission->emitters[g], grid, origin, direction, &p)) sum += sum_cells(grid, &p);
  }
  return (float)sum;
}

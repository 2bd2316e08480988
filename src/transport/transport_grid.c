/* SPDX-License-Identifier: Apache-2.0 */
/* Cells of the multiple scattering, and coarser ones of several of them. */
#include "transport/transport_grid.h"

#include <assert.h>
#include <string.h>

#include "core/alloc.h"
#include "transport/ground_columns.h"
#include "volume/brick_box.h"
#include "world/emission.h"

/* ---- Averages ---- */

/* Places of a hierarchy that reach into a cell. */
typedef struct cell_places {
  unsigned count; /* number of places, of which `at` holds as many as it can */
  const np_instance *at[NP_INSTANCES_MAX];
} cell_places;

enum { CELLS_PER_PIECE = 2048, PARENTS_PER_PIECE = 512 };

typedef struct grid_fill {
  const np_world *world;
  const np_scaled_phase *phases;
  unsigned band;
  np_monitor *monitor;
  np_transport_grid *grid;
  double voxel_m[3];
  bool has_detail;   /* a cloud has detail finer than its voxels */
  float *extinction; /* [cell][cloud], active or not, of no scaled medium */
  bool *holds;       /* marks of cells that hold cloud or an emitter; later also of cells that touch one */
} grid_fill;

float np_transport_grid_average_emission(const np_transport_grid *grid, const struct np_emission *emission,
                                         const int32_t at[3], unsigned band) {
  double low[3], width[3];
  for (int a = 0; a < 3; a++) {
    low[a] = grid->edge_m[a][at[a]];
    width[a] = np_transport_grid_width(grid, a, at[a]);
  }
  return np_emission_average(emission, np_dvec3_make(low[0], low[1], low[2]),
                             np_dvec3_make(width[0], width[1], width[2]))
      .band[band];
}

static unsigned list_places(const grid_fill *f, const double low[3], const double width[3], cell_places *out) {
  const double high[3] = {low[0] + width[0], low[1] + width[1], low[2] + width[2]};
  return out->count = np_places_list_in_box(f->world->clouds.places, low, high, NP_INSTANCES_MAX, out->at);
}

/* Adds the extinction of all clouds at a point of a cell: of `count` places of a hierarchy that reach into the cell, or
 * of as many as there are where that is too many to list. */
static void add_extinction(const grid_fill *f, const cell_places *in, np_dvec3 position, float weight,
                           float *extinction) {
  const np_instances *clouds = &f->world->clouds;
  if (!clouds->places) {
    for (unsigned v = 0; v < clouds->count; v++)
      extinction[v] += weight * fmaxf(0.0f, np_instance_extinction(&clouds->at[v], position));
  } else if (in->count > NP_INSTANCES_MAX) {
    np_places_add_extinction(clouds->places, position, weight, extinction);
  } else {
    for (unsigned i = 0; i < in->count; i++)
      extinction[in->at[i]->index] += weight * fmaxf(0.0f, np_instance_extinction(in->at[i], position));
  }
}

/* Whether no cloud can hold anything in a box. */
static bool is_empty(const np_instances *clouds, const double low[3], const double width[3]) {
  for (unsigned v = 0; v < clouds->count; v++) {
    const np_affine *to_index = &clouds->at[v].world_to_index;
    const np_dvec3 middle = np_affine_point(
        to_index, np_dvec3_make(low[0] + 0.5 * width[0], low[1] + 0.5 * width[1], low[2] + 0.5 * width[2]));
    const double at[3] = {middle.x, middle.y, middle.z};
    double from[3], to[3];
    for (int a = 0; a < 3; a++) {
      const double *row = to_index->m[a];
      const double half = 0.5 * (fabs(row[0]) * width[0] + fabs(row[1]) * width[1] + fabs(row[2]) * width[2]);
      from[a] = at[a] - half, to[a] = at[a] + half;
    }
    if (!np_bricks_are_empty(clouds->at[v].bricks, from, to)) return false;
  }
  return true;
}

/* Mean over a cell by the midpoint rule on the pieces between samples, where the interpolant is trilinear and the rule
 * exact; over large cells on a coarser lattice. Clouds with detail vary within a piece. */
static void average_cell(const grid_fill *f, const int32_t at[3]) {
  const np_transport_grid *g = f->grid;
  const unsigned clouds = f->world->clouds.count;
  const size_t cell = np_transport_grid_join(g, at);
  float *extinction = f->extinction + cell * clouds;
  double low[3], width[3];
  int32_t points[3];
  const double least = f->has_detail ? 2.0 : 1.0;
  cell_places in;
  for (int a = 0; a < 3; a++) {
    low[a] = g->edge_m[a][at[a]];
    width[a] = np_transport_grid_width(g, a, at[a]);
    points[a] = (int32_t)np_clamp(ceil(width[a] / f->voxel_m[a] - 0.01), least, 4.0);
  }
  const float weight = 1.0f / (float)(points[0] * points[1] * points[2]);
  const np_dvec3 middle = np_transport_grid_centre(g, (int32_t)cell);
  if (g->fold.period_m > 0.0 && !np_transport_fold_is_within(&g->fold, middle, g->fold.margin_m)) return;
  const bool is_clear =
      f->world->clouds.places ? list_places(f, low, width, &in) == 0 : is_empty(&f->world->clouds, low, width);
  for (int32_t k = 0; k < points[2] && !is_clear; k++)
    for (int32_t j = 0; j < points[1]; j++)
      for (int32_t i = 0; i < points[0]; i++) {
        const np_dvec3 position = np_dvec3_make(g->edge_m[0][at[0]] + (i + 0.5) / points[0] * width[0],
                                                g->edge_m[1][at[1]] + (j + 0.5) / points[1] * width[1],
                                                g->edge_m[2][at[2]] + (k + 0.5) / points[2] * width[2]);
        add_extinction(f, &in, position, weight, extinction);
      }
  for (unsigned v = 0; v < clouds; v++) f->holds[cell] = f->holds[cell] || extinction[v] > 0.0f;
  if (f->world->emission)
    f->holds[cell] = f->holds[cell] || np_transport_grid_average_emission(g, f->world->emission, at, f->band) > 0.0f;
}

static neph_result average_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const grid_fill *f = user;
  const int32_t *size = f->grid->size;
  for (size_t row = begin; row < end; row++) {
    if (np_monitor_is_cancelled(f->monitor)) return NEPH_ERROR_CANCELLED;
    for (int32_t i = 0; i < size[0]; i++)
      average_cell(f, (const int32_t[3]){i, (int32_t)(row % (size_t)size[1]), (int32_t)(row / (size_t)size[1])});
  }
  return NEPH_OK;
}

/* ---- Active cells ---- */

/* Marks the neighbours along an axis of the marked cells of one line. */
static void spread_line(const np_transport_grid *g, int axis, const int32_t first[3], bool *holds) {
  const int32_t size = g->size[axis];
  const size_t stride = axis == 0 ? 1 : axis == 1 ? (size_t)g->size[0] : (size_t)g->size[0] * (size_t)g->size[1];
  bool *line = holds + np_transport_grid_join(g, first), begin = line[0];
  bool before = g->is_wrapped[axis] && line[(size_t)(size - 1) * stride];
  for (int32_t i = 0; i < size; i++) {
    const bool own = line[(size_t)i * stride];
    const bool next = i + 1 < size ? line[(size_t)(i + 1) * stride] : g->is_wrapped[axis] && begin;
    line[(size_t)i * stride] = before || own || next;
    before = own;
  }
}

/* Spreads marks to the cells that touch a marked one, by an edge or a corner too. */
static void spread_marks(const np_transport_grid *g, bool *holds) {
  for (int axis = 0; axis < 3; axis++) {
    const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    int32_t first[3] = {0};
    for (first[v] = 0; first[v] < g->size[v]; first[v]++)
      for (first[u] = 0; first[u] < g->size[u]; first[u]++) spread_line(g, axis, first, holds);
  }
}

static neph_result allocate_live(np_transport_grid *g) {
  g->cell = np_alloc(g->context, g->active_count, sizeof *g->cell);
  g->extinction = np_alloc(g->context, g->active_count, sizeof *g->extinction);
  g->ratio = np_alloc(g->context, g->active_count, (g->degree + 1) * sizeof *g->ratio);
  return g->cell && g->extinction && g->ratio ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* Depth of a cell in transport mean free paths, 1/(σ′ − Σ ϖσ(χ₁ − f)), beyond which it is a wall, which reflects the
 * same whatever its depth: there its extinction is limited, and albedo and first collisions stay as they are. The layer
 * that reflects is thinner than such a cell, whose mean is of light that has gone as far as its middle: too bright by
 * its depth, where that is not limited. */
static const double cell_depth_max = 4.0;

/* Depth of a cell along its shortest edge, by which light leaves it. */
static double compute_depth(const np_transport_grid *g, size_t cell, float transport) {
  int32_t at[3];
  double shortest = INFINITY;
  np_transport_grid_split(g, (int32_t)cell, at);
  for (int a = 0; a < 3; a++)
    if (g->size[a] > 1) shortest = fmin(shortest, np_transport_grid_width(g, a, at[a]));
  return isfinite(shortest) ? (double)transport * shortest : 0.0;
}

/* Columns are not limited: their balance is exact. */
static float limit_extinction(const np_transport_grid *g, float extinction, double depth) {
  if (g->size[0] == 1 && g->size[1] == 1) return extinction;
  return depth > cell_depth_max ? (float)((double)extinction * (cell_depth_max / depth)) : extinction;
}

/* Stores extinction and scattering ratios of a cell. A cell without cloud gets the ratios of the first cloud, which are
 * multiplied by 0. */
static void store_material(const grid_fill *f, size_t active, size_t cell) {
  np_transport_grid *g = f->grid;
  const unsigned count = g->degree + 1, clouds = f->world->clouds.count;
  const float *own = &f->extinction[cell * clouds];
  float extinction = 0.0f, scattering[NP_DEGREE_MAX + 1] = {0.0f};
  for (unsigned v = 0; v < clouds; v++) {
    extinction += own[v] * g->scale[v];
    for (unsigned l = 0; l < count; l++)
      scattering[l] += own[v] * f->world->clouds.at[v].albedo.band[f->band] * f->phases[v].moments[l];
  }
  const float albedo = f->world->clouds.at[0].albedo.band[f->band];
  const double depth = compute_depth(g, cell, extinction - scattering[1]);
  g->extinction[active] = limit_extinction(g, extinction, depth);
  g->transport_depth[active] = (float)depth;
  for (unsigned l = 0; l < count; l++)
    g->ratio[active * count + l] =
        extinction > 0.0f ? scattering[l] / extinction : albedo * f->phases[0].moments[l] / g->scale[0];
}

static neph_result store_materials(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const grid_fill *f = user;
  for (size_t cell = begin; cell < end; cell++) {
    const int32_t active = f->grid->active[cell];
    if (active < 0) continue;
    f->grid->cell[active] = (int32_t)cell;
    store_material(f, (size_t)active, cell);
  }
  return NEPH_OK;
}

static neph_result store_active(grid_fill *f) {
  np_transport_grid *g = f->grid;
  const int32_t cells = (int32_t)np_transport_grid_count(g);
  spread_marks(g, f->holds);
  for (int32_t c = 0; c < cells; c++) g->active[c] = NP_TRANSPORT_CELL_NONE;
  neph_result result = np_ground_columns_bury(f->world, f->monitor, g, f->holds);
  for (int32_t c = 0; c < cells; c++)
    if (f->holds[c]) g->active[c] = (int32_t)g->active_count++;
  if (!result) result = allocate_live(g);
  g->transport_depth = np_alloc(g->context, g->active_count, sizeof *g->transport_depth);
  if (!result && !g->transport_depth) result = NEPH_ERROR_OUT_OF_MEMORY;
  return result ? result : np_parallel_for(g->context, f->monitor, (size_t)cells, CELLS_PER_PIECE, store_materials, f);
}

neph_result np_transport_grid_fill(const np_world *world, const np_scaled_phase *phases, unsigned band,
                                   np_monitor *monitor, np_transport_grid *grid) {
  grid_fill f = {.world = world, .phases = phases, .band = band, .monitor = monitor, .grid = grid};
  const size_t cells = np_transport_grid_count(grid);
  for (int a = 0; a < 3; a++) f.voxel_m[a] = np_transport_get_voxel(world, a);
  for (unsigned v = 0; v < world->clouds.count; v++) {
    grid->scale[v] = np_transport_scale(&world->clouds.at[v], phases[v].forward, band);
    f.has_detail = f.has_detail || world->clouds.at[v].bricks->detail;
  }
  f.extinction = np_alloc(grid->context, cells, world->clouds.count * sizeof *f.extinction);
  grid->active = np_alloc(grid->context, cells, sizeof *grid->active);
  f.holds = np_alloc(grid->context, cells, sizeof *f.holds);
  neph_result result = f.extinction && f.holds && grid->active ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  const size_t rows = (size_t)grid->size[1] * (size_t)grid->size[2];
  if (!result) result = np_parallel_for(grid->context, monitor, rows, 4, average_rows, &f);
  if (!result) result = store_active(&f);
  np_alloc_free(grid->context, f.holds);
  np_alloc_free(grid->context, f.extinction);
  return result;
}

/* ---- Coarser ---- */

bool np_transport_grid_can_coarsen(const np_transport_grid *grid) {
  bool is_even = true, has_many = false;
  for (int a = 0; a < 3; a++) {
    is_even = is_even && (grid->size[a] == 1 || grid->size[a] % 2 == 0);
    has_many = has_many || grid->size[a] >= 4;
  }
  return is_even && has_many;
}

/* Cells that a coarse cell consists of, in ascending order, and their shares of its volume. */
typedef struct children {
  unsigned count;
  int32_t cell[8];
  float share[8];
} children;

static void list_children(const np_transport_grid *fine, const np_transport_grid *coarse, size_t parent,
                          children *out) {
  int32_t at[3], child[3], begin[3], end[3];
  double share[3][2];
  out->count = 0;
  np_transport_grid_split(coarse, (int32_t)parent, at);
  for (int a = 0; a < 3; a++) {
    const int32_t count = fine->size[a] == 1 ? 1 : 2;
    begin[a] = count * at[a];
    end[a] = begin[a] + count;
    for (int32_t n = 0; n < count; n++)
      share[a][n] = np_transport_grid_width(fine, a, begin[a] + n) / np_transport_grid_width(coarse, a, at[a]);
  }
  for (child[2] = begin[2]; child[2] < end[2]; child[2]++)
    for (child[1] = begin[1]; child[1] < end[1]; child[1]++)
      for (child[0] = begin[0]; child[0] < end[0]; child[0]++) {
        const double *const x = share[0], *const y = share[1], *const z = share[2];
        out->cell[out->count] = (int32_t)np_transport_grid_join(fine, child);
        out->share[out->count++] = (float)(x[child[0] - begin[0]] * y[child[1] - begin[1]] * z[child[2] - begin[2]]);
      }
}

/* Values of active cells, averaged over those of a coarser grid. */
typedef struct restriction {
  const np_transport_grid *fine, *coarse;
  const float *values;
  float *out;
} restriction;

static neph_result restrict_cells(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const restriction *r = user;
  for (size_t parent = begin; parent < end; parent++) {
    children list;
    float sum = 0.0f;
    list_children(r->fine, r->coarse, (size_t)r->coarse->cell[parent], &list);
    for (unsigned n = 0; n < list.count; n++) {
      const int32_t active = r->fine->active[list.cell[n]];
      if (active >= 0) sum += list.share[n] * r->values[active];
    }
    r->out[parent] = sum;
  }
  return NEPH_OK;
}

void np_transport_grid_restrict(const np_transport_grid *fine, const float *values, const np_transport_grid *coarse,
                                float *out) {
  restriction r = {fine, coarse, values, out};
  (void)np_parallel_for(fine->context, NULL, coarse->active_count, PARENTS_PER_PIECE, restrict_cells, &r);
}

/* A grid and its next coarser one. */
typedef struct grid_coarsening {
  const np_transport_grid *fine;
  np_transport_grid *coarse;
} grid_coarsening;

/* Marks coarse cells by 0 where a child is active, and as ground where none is and at least half are ground. */
static neph_result mark_parents(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const grid_coarsening *c = user;
  for (size_t parent = begin; parent < end; parent++) {
    children list;
    unsigned solid = 0, active = 0;
    list_children(c->fine, c->coarse, parent, &list);
    for (unsigned n = 0; n < list.count; n++) {
      solid += c->fine->active[list.cell[n]] == NP_TRANSPORT_CELL_SOLID;
      active += c->fine->active[list.cell[n]] >= 0;
    }
    const bool is_solid = solid && 2 * solid >= list.count;
    c->coarse->active[parent] = active ? 0 : is_solid ? NP_TRANSPORT_CELL_SOLID : NP_TRANSPORT_CELL_NONE;
  }
  return NEPH_OK;
}

static void number_parents(grid_coarsening *c) {
  np_transport_grid *coarse = c->coarse;
  const size_t cells = np_transport_grid_count(coarse);
  coarse->has_ground = c->fine->has_ground;
  (void)np_parallel_for(coarse->context, NULL, cells, PARENTS_PER_PIECE, mark_parents, c);
  for (size_t n = 0; n < cells; n++)
    if (coarse->active[n] == 0) coarse->active[n] = (int32_t)coarse->active_count++;
}

/* Averages extinction and scattering; their ratio follows. */
static void average_parent(const np_transport_grid *fine, np_transport_grid *out, int32_t cell) {
  const size_t parent = (size_t)out->active[cell];
  const unsigned count = fine->degree + 1;
  children list;
  list_children(fine, out, (size_t)cell, &list);
  out->cell[parent] = cell;
  for (unsigned n = 0; n < list.count; n++) {
    const int32_t active = fine->active[list.cell[n]];
    if (active < 0) continue;
    const float before = out->extinction[parent], added = list.share[n] * fine->extinction[active];
    const float t = added > 0.0f ? added / (before + added) : before > 0.0f ? 0.0f : 1.0f;
    for (unsigned l = 0; l < count; l++)
      out->ratio[parent * count + l] += t * (fine->ratio[(size_t)active * count + l] - out->ratio[parent * count + l]);
    out->extinction[parent] = before + added;
  }
}

static neph_result average_parents(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const grid_coarsening *c = user;
  for (size_t cell = begin; cell < end; cell++)
    if (c->coarse->active[cell] >= 0) average_parent(c->fine, c->coarse, (int32_t)cell);
  return NEPH_OK;
}

/* One plane of each `stride`. */
static neph_result thin_planes(const np_transport_grid *fine, int axis, int32_t stride, np_transport_grid *out) {
  assert(fine->size[axis] % stride == 0);
  out->size[axis] = fine->size[axis] / stride;
  out->used[axis] = (fine->used[axis] + stride - 1) / stride;
  out->even_m[axis] = stride * fine->even_m[axis];
  out->is_wrapped[axis] = fine->is_wrapped[axis];
  out->repeat_m[axis] = fine->repeat_m[axis];
  out->edge_m[axis] = np_alloc(out->context, (size_t)out->size[axis] + 1, sizeof *out->edge_m[axis]);
  if (!out->edge_m[axis]) return NEPH_ERROR_OUT_OF_MEMORY;
  for (int32_t i = 0; i <= out->size[axis]; i++) out->edge_m[axis][i] = fine->edge_m[axis][stride * i];
  return NEPH_OK;
}

neph_result np_transport_grid_coarsen(const np_transport_grid *fine, np_transport_grid *out) {
  assert(np_transport_grid_can_coarsen(fine));
  *out = (np_transport_grid){.context = fine->context, .degree = fine->degree};
  neph_result result = NEPH_OK;
  for (int a = 0; a < 3 && !result; a++) result = thin_planes(fine, a, fine->size[a] == 1 ? 1 : 2, out);
  if (result) return result;
  out->active = np_alloc(out->context, np_transport_grid_count(out), sizeof *out->active);
  if (!out->active) return NEPH_ERROR_OUT_OF_MEMORY;
  grid_coarsening c = {.fine = fine, .coarse = out};
  number_parents(&c);
  result = allocate_live(out);
  if (result) return result;
  return np_parallel_for(out->context, NULL, np_transport_grid_count(out), PARENTS_PER_PIECE, average_parents, &c);
}

/* Scales a cell that is scaled for degree N again, for the lower degree n: the ratio of degree n + 1 is the share of
 * the peak that then counts as unscattered. */
static void broaden_cell(const np_transport_grid *fine, size_t active, np_transport_grid *out) {
  const float *ratio = fine->ratio + active * (fine->degree + 1);
  const float peak = ratio[1] > 0.0f ? np_clampf(ratio[out->degree + 1], 0.0f, 0.999f) : 0.0f;
  out->cell[active] = fine->cell[active];
  out->extinction[active] = fine->extinction[active] * (1.0f - peak);
  for (unsigned l = 0; l <= out->degree; l++)
    out->ratio[active * (out->degree + 1) + l] = (ratio[l] - peak) / (1.0f - peak);
}

neph_result np_transport_grid_reduce_degree(const np_world *world, unsigned band, unsigned degree,
                                            const np_transport_grid *fine, np_transport_grid *out) {
  assert(degree < fine->degree);
  *out = (np_transport_grid){
      .context = fine->context, .degree = degree, .active_count = fine->active_count, .has_ground = fine->has_ground};
  neph_result result = NEPH_OK;
  for (int a = 0; a < 3 && !result; a++) result = thin_planes(fine, a, 1, out);
  if (result) return result;
  for (unsigned v = 0; v < world->clouds.count; v++)
    out->scale[v] = np_transport_scale(&world->clouds.at[v],
                                       np_scaled_phase_compute_forward(&world->clouds.at[v].phase, degree), band);
  out->active = np_alloc(out->context, np_transport_grid_count(out), sizeof *out->active);
  if (!out->active) return NEPH_ERROR_OUT_OF_MEMORY;
  memcpy(out->active, fine->active, np_transport_grid_count(out) * sizeof *out->active);
  result = allocate_live(out);
  for (size_t active = 0; active < fine->active_count && !result; active++) broaden_cell(fine, active, out);
  return result;
}

void np_transport_grid_clear(np_transport_grid *grid) {
  for (int a = 0; a < 3; a++) np_alloc_free(grid->context, grid->edge_m[a]);
  np_alloc_free(grid->context, grid->active);
  np_alloc_free(grid->context, grid->cell);
  np_alloc_free(grid->context, grid->extinction);
  np_alloc_free(grid->context, grid->transport_depth);
  np_alloc_free(grid->context, grid->ratio);
  np_alloc_free(grid->context, grid->first_collision_source);
  np_alloc_free(grid->context, grid->low_order_source);
  np_alloc_free(grid->context, grid->delta_m_residual);
  *grid = (np_transport_grid){0};
}

double np_transport_get_voxel(const np_world *world, int axis) {
  double finest = INFINITY;
  const np_instance *places = np_instances_get_places(&world->clouds);
  for (unsigned v = 0; v < np_instances_count_places(&world->clouds); v++) {
    const double(*m)[4] = places[v].world_to_index.m;
    const double per_m = sqrt(m[0][axis] * m[0][axis] + m[1][axis] * m[1][axis] + m[2][axis] * m[2][axis]);
    finest = fmin(finest, np_bricks_count_joined(places[v].bricks) / per_m);
  }
  return finest;
}

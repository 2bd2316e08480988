/* SPDX-License-Identifier: Apache-2.0 */
/* The order in which tiles of rows are swept. Light of a pair of octants moves from one corner of the plane of rows to
 * the opposite: a tile waits for its two neighbours towards the light, not for others on its diagonal (the wavefront of
 * Koch, Baker and Alcouffe 1992), so that there is work for many threads, and every face has one writer. The pairs
 * start at the four corners and share one sum: a pair that comes to a tile waits for the pair that came there before.
 */
#include "transport/sweep.h"

#include "core/alloc.h"
#include "core/isa.h"

typedef void (*tile_fn)(const np_sweep *sweep, const np_sweep_tile *tile, unsigned thread);

void np_sweep_cross_tile_v1(const np_sweep *, const np_sweep_tile *, unsigned);
void np_sweep_cross_tile_v3(const np_sweep *, const np_sweep_tile *, unsigned);
void np_sweep_cross_tile_v4(const np_sweep *, const np_sweep_tile *, unsigned);

static neph_result allocate_faces(np_sweep *s, unsigned pair) {
  const size_t lanes = 2 * (size_t)s->ordinates->block_count * NP_ORDINATE_LANES;
  const size_t x = (size_t)s->grid->size[0], y = (size_t)s->grid->size[1], z = (size_t)s->grid->size[2];
  np_sweep_faces *f = &s->faces[pair];
  f->x = np_alloc(s->context, y * z, lanes * sizeof *f->x);
  f->y = np_alloc(s->context, x * z, lanes * sizeof *f->y);
  f->z = np_alloc(s->context, x * y, lanes * sizeof *f->z);
  return f->x && f->y && f->z ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* Fills the reciprocal widths along an axis; 0 for a period of a single cell, where light that leaves enters again. */
static neph_result fill_widths(np_sweep *s, int axis) {
  const np_transport_grid *g = s->grid;
  const bool is_endless = g->is_wrapped[axis] && g->size[axis] == 1;
  s->inverse_m[axis] = np_alloc(s->context, (size_t)g->size[axis], sizeof *s->inverse_m[axis]);
  if (!s->inverse_m[axis]) return NEPH_ERROR_OUT_OF_MEMORY;
  for (int32_t i = 0; i < g->size[axis]; i++)
    s->inverse_m[axis][i] = is_endless ? 0.0f : (float)(1.0 / np_transport_grid_width(g, axis, i));
  return NEPH_OK;
}

/* Number of cells of each row up to the last active one, in the order of light up x, and down x. */
static void fill_ends(const np_transport_grid *g, int32_t (*ends)[2]) {
  const int32_t width = g->size[0];
  const bool is_wrapped = g->is_wrapped[0] || g->is_wrapped[1] || g->is_wrapped[2];
  for (int32_t row = 0; row < g->size[1] * g->size[2]; row++) {
    const int32_t *active = g->active + (size_t)row * (size_t)width;
    int32_t first = 0, end = width;
    while (!is_wrapped && end > 0 && active[end - 1] < 0) end--;
    while (!is_wrapped && first < end && active[first] < 0) first++;
    ends[row][0] = end;
    ends[row][1] = end > first ? width - first : 0;
  }
}

/* Fills the reach of rows. Light travels in the positive direction of all three axes of its octant: cells of a row
 * beyond all cloud in this and the following rows are skipped. With a wrapped side, no cell is skipped. */
static neph_result fill_reach(np_sweep *s, int32_t (*ends)[2], unsigned octant) {
  const int32_t rows = s->grid->size[1], layers = s->grid->size[2];
  int32_t *reach = s->reach[octant] = np_alloc(s->context, (size_t)rows * (size_t)layers, sizeof *reach);
  if (!reach) return NEPH_ERROR_OUT_OF_MEMORY;
  const int32_t next_row = octant & 2u ? -1 : 1, next_layer = octant & 4u ? -rows : rows;
  for (int32_t m = layers; m-- > 0;)
    for (int32_t n = rows; n-- > 0;) {
      const int32_t row = (octant & 4u ? layers - 1 - m : m) * rows + (octant & 2u ? rows - 1 - n : n);
      int32_t most = ends[row][octant & 1u];
      if (n + 1 < rows && reach[row + next_row] > most) most = reach[row + next_row];
      if (m + 1 < layers && reach[row + next_layer] > most) most = reach[row + next_layer];
      reach[row] = most;
    }
  return NEPH_OK;
}

static neph_result fill_reaches(np_sweep *s) {
  int32_t(*ends)[2] = np_alloc(s->context, (size_t)s->grid->size[1] * (size_t)s->grid->size[2], sizeof *ends);
  if (!ends) return NEPH_ERROR_OUT_OF_MEMORY;
  fill_ends(s->grid, ends);
  neph_result result = NEPH_OK;
  for (unsigned octant = 0; octant < NP_OCTANT_COUNT && !result; octant++) result = fill_reach(s, ends, octant);
  np_alloc_free(s->context, ends);
  return result;
}

/* ---- Tiles ---- */

typedef struct tile_plan {
  int32_t tiles_y, tiles_z;
  uint32_t *index; /* [pair][tile_z][tile_y]: place in the order, tiles numbered as in np_sweep_tile */
  uint32_t *last;  /* [tile_z][tile_y], numbered up both axes: place of the pair that came last; NP_WAITS_NONE: none */
} tile_plan;

static uint32_t *get_index(const tile_plan *plan, unsigned pair, int32_t y, int32_t z) {
  return &plan->index[((size_t)pair * (size_t)plan->tiles_z + (size_t)z) * (size_t)plan->tiles_y + (size_t)y];
}

/* Bits of the pair are set where light goes down y, and down z. */
static uint32_t *get_last(const tile_plan *plan, unsigned pair, int32_t y, int32_t z) {
  const int32_t up_y = pair & 1u ? plan->tiles_y - 1 - y : y, up_z = pair & 2u ? plan->tiles_z - 1 - z : z;
  return &plan->last[(size_t)up_z * (size_t)plan->tiles_y + (size_t)up_y];
}

static void append_tile(np_sweep *s, const tile_plan *plan, unsigned pair, int32_t y, int32_t z) {
  const uint32_t own = (uint32_t)s->tile_count++;
  uint32_t *last = get_last(plan, pair, y, z);
  s->tiles[own] = (np_sweep_tile){(uint8_t)pair, *last == NP_WAITS_NONE, y, z};
  s->waits[own] = (np_waits){{y ? *get_index(plan, pair, y - 1, z) : NP_WAITS_NONE,
                              z ? *get_index(plan, pair, y, z - 1) : NP_WAITS_NONE, *last}};
  *get_index(plan, pair, y, z) = *last = own;
}

/* Appends tiles by diagonals, y + z. Pairs that come to a tile on the same diagonal add to it in their order. */
static void append_tiles(np_sweep *s, const tile_plan *plan) {
  for (int32_t d = 0; d < plan->tiles_y + plan->tiles_z - 1; d++) {
    const int32_t first_y = d < plan->tiles_z ? 0 : d - plan->tiles_z + 1;
    for (unsigned pair = 0; pair < NP_OCTANT_PAIRS; pair++)
      for (int32_t y = first_y; y < plan->tiles_y && y <= d; y++) append_tile(s, plan, pair, y, d - y);
  }
}

static neph_result fill_tiles(np_sweep *s) {
  tile_plan plan = {.tiles_y = (s->grid->size[1] - 1) / NP_SWEEP_TILE_Y + 1,
                    .tiles_z = (s->grid->size[2] - 1) / NP_SWEEP_TILE_Z + 1};
  const size_t tiles = (size_t)plan.tiles_y * (size_t)plan.tiles_z, count = NP_OCTANT_PAIRS * tiles;
  plan.index = np_alloc(s->context, count, sizeof *plan.index);
  plan.last = np_alloc(s->context, tiles, sizeof *plan.last);
  s->tiles = np_alloc(s->context, count, sizeof *s->tiles);
  s->waits = np_alloc(s->context, count, sizeof *s->waits);
  const bool has_memory = plan.index && plan.last && s->tiles && s->waits;
  if (has_memory) {
    for (size_t i = 0; i < tiles; i++) plan.last[i] = NP_WAITS_NONE;
    append_tiles(s, &plan);
  }
  np_alloc_free(s->context, plan.index);
  np_alloc_free(s->context, plan.last);
  return has_memory ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* ---- Sweeps ---- */

neph_result np_sweep_init(neph_context *context, np_monitor *monitor, const np_transport_grid *grid,
                          const np_ordinates *ordinates, const np_cell_air *air, np_sweep *out) {
  *out = (np_sweep){.context = context, .monitor = monitor, .grid = grid, .ordinates = ordinates, .air = *air};
  neph_result result = NEPH_OK;
  for (int axis = 0; axis < 3 && !result; axis++) result = fill_widths(out, axis);
  if (!result) result = fill_reaches(out);
  if (!result) result = fill_tiles(out);
  for (unsigned pair = 0; pair < NP_OCTANT_PAIRS && !result; pair++) result = allocate_faces(out, pair);
  const size_t lanes = 2 * (size_t)grid->size[0] * neph_context_get_thread_count(context);
  out->rows = result ? NULL : np_alloc(context, lanes, NP_ORDINATE_LANES * sizeof *out->rows);
  if (!result && !out->rows) result = NEPH_ERROR_OUT_OF_MEMORY;
  if (result) np_sweep_clear(out);
  return result;
}

void np_sweep_clear(np_sweep *s) {
  for (unsigned pair = 0; pair < NP_OCTANT_PAIRS; pair++) {
    np_alloc_free(s->context, s->faces[pair].x);
    np_alloc_free(s->context, s->faces[pair].y);
    np_alloc_free(s->context, s->faces[pair].z);
  }
  np_alloc_free(s->context, s->rows);
  np_alloc_free(s->context, s->tiles);
  np_alloc_free(s->context, s->waits);
  for (unsigned octant = 0; octant < NP_OCTANT_COUNT; octant++) np_alloc_free(s->context, s->reach[octant]);
  for (int axis = 0; axis < 3; axis++) np_alloc_free(s->context, s->inverse_m[axis]);
  *s = (np_sweep){0};
}

typedef struct sweep_job {
  const np_sweep *sweep;
  tile_fn cross_tile;
} sweep_job;

static neph_result cross_tiles(void *user, size_t begin, size_t end, unsigned thread) {
  const sweep_job *job = user;
  for (size_t i = begin; i < end; i++) job->cross_tile(job->sweep, &job->sweep->tiles[i], thread);
  return np_monitor_is_cancelled(job->sweep->monitor) ? NEPH_ERROR_CANCELLED : NEPH_OK;
}

neph_result np_sweep_run(np_sweep *s) {
  static const tile_fn kernels[NP_ISA_COUNT] = {np_sweep_cross_tile_v1, np_sweep_cross_tile_v3, np_sweep_cross_tile_v4};
  sweep_job job = {s, kernels[neph_context_get_isa(s->context)]};
  return np_parallel_sequence(s->context, s->monitor, s->tile_count, s->waits, cross_tiles, &job);
}

static double sum_column(const np_sweep *s, np_border_way way, size_t column) {
  const np_ordinates *o = s->ordinates;
  const size_t columns = (size_t)s->grid->size[0] * (size_t)s->grid->size[1];
  const unsigned first = way == NP_BORDER_DOWN ? NP_OCTANT_PAIRS / 2 : 0; /* pairs of octants in this direction */
  double sum = 0.0;
  for (unsigned pair = first; pair < first + NP_OCTANT_PAIRS / 2; pair++)
    for (unsigned part = 0; part < 2 * o->block_count; part++) {
      const float *light = s->faces[pair].z + ((size_t)part * columns + column) * NP_ORDINATE_LANES;
      const unsigned block = part % o->block_count;
      for (unsigned lane = 0; lane < NP_ORDINATE_LANES; lane++)
        sum += (double)(o->weight[block][lane] * o->cosine[2][block][lane] * light[lane]);
    }
  return sum;
}

static void measure_way(const np_sweep *s, np_border_way way, float out[NP_BORDER_PLAN][NP_BORDER_PLAN]) {
  const int32_t *size = s->grid->size;
  for (int32_t square = 0; square < NP_BORDER_PLAN * NP_BORDER_PLAN; square++) {
    const int32_t at[2] = {square % NP_BORDER_PLAN, square / NP_BORDER_PLAN};
    int32_t begin[2], end[2];
    double sum = 0.0;
    for (int a = 0; a < 2; a++) {
      begin[a] = at[a] * size[a] / NP_BORDER_PLAN;
      end[a] = (at[a] + 1) * size[a] / NP_BORDER_PLAN;
      if (end[a] <= begin[a]) end[a] = begin[a] + 1;
    }
    for (int32_t j = begin[1]; j < end[1]; j++)
      for (int32_t i = begin[0]; i < end[0]; i++) sum += sum_column(s, way, (size_t)j * (size_t)size[0] + (size_t)i);
    (&out[0][0])[square] = (float)(sum / ((end[0] - begin[0]) * (end[1] - begin[1])));
  }
}

void np_sweep_measure_outflow(const np_sweep *s, np_outflow *out) {
  for (int way = 0; way < NP_BORDER_WAYS; way++) measure_way(s, (np_border_way)way, out->way[way]);
}

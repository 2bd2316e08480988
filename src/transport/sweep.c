/* SPDX-License-Identifier: Apache-2.0 */
/* The order in which tiles of rows are swept. Light of a pair of octants moves from one corner of the plane of rows to
 * the opposite: tiles on a diagonal of it wait for those on the diagonal before, not for each other (the wavefront of
 * Koch, Baker and Alcouffe 1992), so that there is work for many threads, and every face has one writer. */
#include "transport/sweep.h"

#include <assert.h>
#include <string.h>

#include "core/alloc.h"
#include "core/isa.h"

/* Sweeps one tile in a pair of opposite octants. Tiles are numbered in the order of the light's direction. */
typedef void (*tile_fn)(const np_sweep *sweep, unsigned pair, int32_t tile_y, int32_t tile_z, unsigned thread);

void np_sweep_tile_v1(const np_sweep *, unsigned, int32_t, int32_t, unsigned);
void np_sweep_tile_v3(const np_sweep *, unsigned, int32_t, int32_t, unsigned);
void np_sweep_tile_v4(const np_sweep *, unsigned, int32_t, int32_t, unsigned);

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

/* Number of cells of a row, in the order of the light's direction, up to the last active one. */
static int32_t count_to_last_active(const np_transport_grid *g, unsigned octant, int32_t row) {
  const int32_t width = g->size[0], *active = g->active + (size_t)row * (size_t)width;
  int32_t n = width;
  while (n > 0 && active[octant & 1u ? width - n : n - 1] < 0) n--;
  return n;
}

/* Fills the reach of rows. Light travels in the positive direction of all three axes of its octant: cells of a row
 * beyond all cloud in this and the following rows are skipped. With a wrapped side, no cell is skipped. */
static neph_result fill_reach(np_sweep *s, unsigned octant) {
  const np_transport_grid *g = s->grid;
  const int32_t rows = g->size[1], layers = g->size[2];
  const bool is_wrapped = g->is_wrapped[0] || g->is_wrapped[1] || g->is_wrapped[2];
  int32_t *reach = s->reach[octant] = np_alloc(s->context, (size_t)rows * (size_t)layers, sizeof *reach);
  if (!reach) return NEPH_ERROR_OUT_OF_MEMORY;
  const int32_t next_row = octant & 2u ? -1 : 1, next_layer = octant & 4u ? -rows : rows;
  for (int32_t m = layers; m-- > 0;)
    for (int32_t n = rows; n-- > 0;) {
      const int32_t row = (octant & 4u ? layers - 1 - m : m) * rows + (octant & 2u ? rows - 1 - n : n);
      int32_t most = is_wrapped ? g->size[0] : count_to_last_active(g, octant, row);
      if (n + 1 < rows && reach[row + next_row] > most) most = reach[row + next_row];
      if (m + 1 < layers && reach[row + next_layer] > most) most = reach[row + next_layer];
      reach[row] = most;
    }
  return NEPH_OK;
}

neph_result np_sweep_init(neph_context *context, np_monitor *monitor, const np_transport_grid *grid,
                          const np_ordinates *ordinates, const np_cell_air *air, np_sweep *out) {
  *out = (np_sweep){.context = context, .monitor = monitor, .grid = grid, .ordinates = ordinates, .air = *air};
  neph_result result = NEPH_OK;
  for (int axis = 0; axis < 3 && !result; axis++) result = fill_widths(out, axis);
  for (unsigned octant = 0; octant < NP_OCTANT_COUNT && !result; octant++) result = fill_reach(out, octant);
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
  for (unsigned octant = 0; octant < NP_OCTANT_COUNT; octant++) np_alloc_free(s->context, s->reach[octant]);
  for (int axis = 0; axis < 3; axis++) np_alloc_free(s->context, s->inverse_m[axis]);
  *s = (np_sweep){0};
}

/* The tiles of one diagonal, of some pairs. */
typedef struct front {
  const np_sweep *sweep;
  tile_fn sweep_tile;
  int32_t diagonal, first_y, count; /* diagonal = tile_y + tile_z; first tile_y on it; number of tiles on it */
  unsigned first_pair, pair_count;
} front;

static neph_result sweep_tiles(void *user, size_t begin, size_t end, unsigned thread) {
  const front *f = user;
  for (size_t i = begin; i < end; i++) {
    const int32_t tile_y = f->first_y + (int32_t)(i / f->pair_count);
    const unsigned pair = f->first_pair + (unsigned)(i % f->pair_count);
    assert(pair < NP_OCTANT_PAIRS && tile_y <= f->diagonal);
    f->sweep_tile(f->sweep, pair, tile_y, f->diagonal - tile_y, thread);
  }
  return np_monitor_is_cancelled(f->sweep->monitor) ? NEPH_ERROR_CANCELLED : NEPH_OK;
}

static neph_result sweep_front(front *f, unsigned first_pair, unsigned pair_count) {
  f->first_pair = first_pair;
  f->pair_count = pair_count;
  const np_sweep *s = f->sweep;
  return np_parallel_for(s->context, s->monitor, (size_t)f->count * pair_count, 1, sweep_tiles, f);
}

/* Floats that one piece of the loop below clears: 256 kB. */
enum { CLEARED_FLOATS = 1 << 16 };

static size_t count_floats(const np_sweep *s) { return s->grid->active_count * np_harmonics_count(s->grid->degree); }

static neph_result clear_pieces(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const np_sweep *s = user;
  const size_t floats = count_floats(s), pieces = floats / CLEARED_FLOATS + 1;
  for (size_t i = begin; i < end; i++) {
    const size_t first = i % pieces * CLEARED_FLOATS, left = floats - first;
    memset(s->out[i / pieces] + first, 0, (left < CLEARED_FLOATS ? left : CLEARED_FLOATS) * sizeof(float));
  }
  return NEPH_OK;
}

/* Sums begin at zero. */
static neph_result clear_sums(np_sweep *s) {
  const size_t pieces = count_floats(s) / CLEARED_FLOATS + 1;
  return np_parallel_for(s->context, s->monitor, NP_SWEEP_PARTS * pieces, 4, clear_pieces, s);
}

/* Opposite pairs of octants start at opposite ends and share a sum. Where both would sweep the same tiles, one pair
 * waits. */
neph_result np_sweep_run(np_sweep *s) {
  static const tile_fn kernels[NP_ISA_COUNT] = {np_sweep_tile_v1, np_sweep_tile_v3, np_sweep_tile_v4};
  const np_transport_grid *g = s->grid;
  const int32_t tiles_y = (g->size[1] - 1) / NP_SWEEP_TILE + 1, tiles_z = (g->size[2] - 1) / NP_SWEEP_TILE + 1;
  neph_result cleared = clear_sums(s);
  if (cleared) return cleared;
  front f = {.sweep = s, .sweep_tile = kernels[neph_context_get_isa(s->context)]};
  for (f.diagonal = 0; f.diagonal < tiles_y + tiles_z - 1; f.diagonal++) {
    f.first_y = f.diagonal < tiles_z ? 0 : f.diagonal - tiles_z + 1;
    f.count = (f.diagonal < tiles_y ? f.diagonal : tiles_y - 1) - f.first_y + 1;
    assert(f.count >= 1);
    const bool is_middle = 2 * f.diagonal == tiles_y + tiles_z - 2;
    const unsigned some = is_middle ? NP_OCTANT_PAIRS / 2 : NP_OCTANT_PAIRS;
    for (unsigned pair = 0; pair < NP_OCTANT_PAIRS; pair += some) {
      neph_result result = sweep_front(&f, pair, some);
      if (result) return result;
    }
  }
  return NEPH_OK;
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

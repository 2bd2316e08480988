/* SPDX-License-Identifier: Apache-2.0 */
/* The sweep: diamond difference through the cells in the order in which light passes them, eight directions at once.
 *
 * Lewis and Miller 1984, section 4-3. With μ the cosine along an axis over the cell's edge, Q the source, σ the
 * extinction, a cell's mean radiance balances what enters, leaves and is lost, given that the mean is midway between
 * opposite faces:
 *
 *     ψ = (Q + Σ 2μ·ψ_in) / (σ + Σ 2μ),   ψ_out = 2ψ − ψ_in
 *
 * Where ψ_out comes out negative that face lets nothing through and the balance is solved anew, 2μψ_in becoming μψ_in
 * and 2μ leaving the denominator: still conservative. A wrapped axis of a single cell has ψ_out = ψ_in: μ = 0 there.
 */
#include "core/half.h"
#include "core/isa.h"
#include "light/sweep.h"

typedef float lanes __attribute__((vector_size(32), may_alias));
typedef int32_t mask __attribute__((vector_size(32)));

void NP_KERNEL(np_sweep_octant)(const np_sweep *sweep, unsigned octant, float *scratch, float *out);

/* One block of directions on its way through the cells. */
typedef struct flow {
  const np_sweep *sweep;
  const float (*harmonic)[NP_ORDINATE_LANES];
  const float (*weighted)[NP_HARMONIC_COUNT];
  lanes rate[3]; /* μ over edge */
  lanes inflow;
  bool is_backward[3];
  lanes *row_faces, *plane_faces; /* between rows of a plane, [i]; between planes, [j][i] */
  lanes *wrap_x, *wrap_y;         /* NULL: not wrapped over several cells */
  float *out;
} flow;

static inline bool is_any_negative(const lanes *a, const lanes *b, const lanes *c) {
  const mask negative = (*a < 0.0f) | (*b < 0.0f) | (*c < 0.0f);
#if defined(__AVX__)
  return _mm256_movemask_ps((__m256)negative) != 0;
#else
  int32_t any = 0;
  for (int i = 0; i < NP_ORDINATE_LANES; i++) any |= negative[i];
  return any != 0;
#endif
}

/* Keeps the faces whose outflow is not negative open. */
static inline void shut(lanes *open, const lanes *outflow) { *open = (lanes)((mask)*open & (*outflow >= 0.0f)); }

/* Solves one cell; `faces` hold what enters and then what leaves, x, y, z. */
static inline void solve_cell(const lanes rate[3], const lanes *source, float extinction, lanes *const faces[3],
                              lanes *out_mean) {
  lanes out[3], open[3];
  for (int a = 0; a < 3; a++) open[a] = (lanes){1, 1, 1, 1, 1, 1, 1, 1};
  for (int attempt = 0; attempt < 4; attempt++) {
    lanes gain = *source, loss = extinction + (lanes){0};
    for (int a = 0; a < 3; a++) {
      gain += rate[a] * (1.0f + open[a]) * *faces[a];
      loss += 2.0f * rate[a] * open[a];
    }
    *out_mean = gain / (loss + 1e-30f);
    for (int a = 0; a < 3; a++) out[a] = open[a] * (2.0f * *out_mean - *faces[a]);
    if (!is_any_negative(&out[0], &out[1], &out[2])) break;
    for (int a = 0; a < 3; a++) shut(&open[a], &out[a]);
  }
  for (int a = 0; a < 3; a++) *faces[a] = out[a];
}

/* The source towards each direction, from its moments; the truncated series may dip below 0, which no source does. */
static inline void evaluate_source(const flow *f, const float *moments, lanes *out) {
  lanes even = {0}, odd = {0};
  for (int i = 0; i < NP_HARMONIC_COUNT; i += 2) {
    even += moments[i] * *(const lanes *)f->harmonic[i];
    odd += moments[i + 1] * *(const lanes *)f->harmonic[i + 1];
  }
  const lanes sum = even + odd;
  *out = (lanes)((mask)sum & (sum > 0.0f));
}

/* Adds Σ weight·Y·ψ to a cell's moments. */
static inline void add_moments(const flow *f, const lanes *mean, float *moments) {
  lanes low = *(lanes *)moments, high = *(lanes *)(moments + NP_ORDINATE_LANES);
  for (int d = 0; d < NP_ORDINATE_LANES; d++) {
    low += (*mean)[d] * *(const lanes *)f->weighted[d];
    high += (*mean)[d] * *(const lanes *)(f->weighted[d] + NP_ORDINATE_LANES);
  }
  *(lanes *)moments = low;
  *(lanes *)(moments + NP_ORDINATE_LANES) = high;
}

static inline void cross_cell(const flow *f, int32_t live, lanes *x, lanes *y, lanes *z) {
  lanes *const faces[3] = {x, y, z};
  lanes source = {0}, mean;
  if (live < 0) {
    solve_cell(f->rate, &source, 0.0f, faces, &mean);
    return;
  }
  evaluate_source(f, f->sweep->source + (size_t)live * NP_HARMONIC_COUNT, &source);
  solve_cell(f->rate, &source, f->sweep->grid->extinction[live], faces, &mean);
  add_moments(f, &mean, f->out + (size_t)live * NP_HARMONIC_COUNT);
}

static void cross_row(const flow *f, int32_t j, int32_t k) {
  const np_transport_grid *grid = f->sweep->grid;
  const int32_t width = grid->size[0], row = (k * grid->size[1] + j) * width;
  lanes *wrap = f->wrap_x ? &f->wrap_x[k * grid->size[1] + j] : NULL;
  lanes x = wrap ? *wrap : f->inflow;
  for (int32_t n = 0; n < width; n++) {
    const int32_t i = f->is_backward[0] ? width - 1 - n : n;
    cross_cell(f, grid->live[row + i], &x, &f->row_faces[i], &f->plane_faces[j * width + i]);
  }
  if (wrap) *wrap = x;
}

static void cross_plane(const flow *f, int32_t k) {
  const np_transport_grid *grid = f->sweep->grid;
  const int32_t width = grid->size[0], height = grid->size[1];
  lanes *wrap = f->wrap_y ? &f->wrap_y[k * width] : NULL;
  for (int32_t i = 0; i < width; i++) f->row_faces[i] = wrap ? wrap[i] : f->inflow;
  for (int32_t n = 0; n < height; n++) cross_row(f, f->is_backward[1] ? height - 1 - n : n, k);
  for (int32_t i = 0; wrap && i < width; i++) wrap[i] = f->row_faces[i];
}

static void cross_all(const flow *f) {
  const np_transport_grid *grid = f->sweep->grid;
  const int32_t depth = grid->size[2];
  for (int32_t c = 0; c < grid->size[0] * grid->size[1]; c++) f->plane_faces[c] = f->inflow;
  for (int32_t n = 0; n < depth; n++) {
    if (np_monitor_is_cancelled(f->sweep->monitor)) return;
    cross_plane(f, f->is_backward[2] ? depth - 1 - n : n);
  }
}

/* Points a flow at its part of the wrapped faces: those across x, then those across y, for each octant and block. */
static void find_wrap(flow *f, unsigned octant, unsigned block) {
  const np_transport_grid *grid = f->sweep->grid;
  if (!f->sweep->wrap) return;
  const size_t across_x = (size_t)grid->size[1] * (size_t)grid->size[2],
               across_y = (size_t)grid->size[0] * (size_t)grid->size[2];
  lanes *faces = (lanes *)f->sweep->wrap + (octant * NP_ORDINATE_BLOCKS_MAX + block) * (across_x + across_y);
  if (grid->is_wrapped[0] && grid->size[0] > 1) f->wrap_x = faces;
  if (grid->is_wrapped[1] && grid->size[1] > 1) f->wrap_y = faces + across_x;
}

void NP_KERNEL(np_sweep_octant)(const np_sweep *sweep, unsigned octant, float *scratch, float *out) {
  const np_ordinates *o = sweep->ordinates;
  const np_transport_grid *grid = sweep->grid;
  for (unsigned block = 0; block < o->block_count; block++) {
    flow f = {.sweep = sweep,
              .harmonic = o->harmonic[octant][block],
              .weighted = o->weighted[octant][block],
              .inflow = *(const lanes *)sweep->inflow[octant][block],
              .row_faces = (lanes *)scratch,
              .plane_faces = (lanes *)scratch + grid->size[0],
              .out = out};
    for (int a = 0; a < 3; a++) {
      const bool is_still = grid->is_wrapped[a] && grid->size[a] == 1;
      f.rate[a] = *(const lanes *)o->cosine[a][block] * (is_still ? 0.0f : (float)(1.0 / grid->cell_m[a]));
      f.is_backward[a] = octant >> a & 1u;
    }
    find_wrap(&f, octant, block);
    cross_all(&f);
  }
}

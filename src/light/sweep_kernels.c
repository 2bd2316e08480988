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

void NP_KERNEL(np_sweep_tile)(const np_sweep *sweep, unsigned group, int32_t tile_y, int32_t tile_z);

/* One block of directions on its way through the cells. */
typedef struct flow {
  const np_sweep *sweep;
  unsigned harmonics;
  const float (*harmonic)[NP_ORDINATE_LANES];
  const float (*weighted)[NP_HARMONIC_COUNT_MAX];
  lanes cosine[3];
  lanes inflow;
  bool is_backward[3];
  const int32_t *reach; /* as in np_sweep */
  lanes *x, *y, *z; /* faces, as in np_sweep_faces */
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

/* Whether nothing enters; what has no cloud in it lets nothing out then. */
static inline bool is_dark(lanes *const faces[3]) {
  const mask any = (mask)*faces[0] | (mask)*faces[1] | (mask)*faces[2];
#if defined(__AVX__)
  return _mm256_testz_si256((__m256i)any, (__m256i)any) != 0;
#else
  int32_t bits = 0;
  for (int i = 0; i < NP_ORDINATE_LANES; i++) bits |= any[i];
  return bits == 0;
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
static inline void evaluate_source(const flow *f, const float *moments, unsigned count, lanes *out) {
  lanes even = {0}, odd = {0};
  for (unsigned i = 0; i < count; i += 2) {
    even += moments[i] * *(const lanes *)f->harmonic[i];
    odd += moments[i + 1] * *(const lanes *)f->harmonic[i + 1];
  }
  const lanes sum = even + odd;
  *out = (lanes)((mask)sum & (sum > 0.0f));
}

/* Adds Σ weight·Y·ψ to a cell's moments. */
static inline void add_moments(const flow *f, const lanes *mean, float *moments, unsigned count) {
  for (unsigned i = 0; i < count; i += NP_ORDINATE_LANES) {
    lanes sum = *(lanes *)(moments + i);
    for (int d = 0; d < NP_ORDINATE_LANES; d++) sum += (*mean)[d] * *(const lanes *)(f->weighted[d] + i);
    *(lanes *)(moments + i) = sum;
  }
}

static inline void cross_cell(const flow *f, const lanes rate[3], int32_t live, lanes *const faces[3], unsigned count) {
  lanes source = {0}, mean;
  if (live < 0) {
    if (is_dark(faces)) return;
    solve_cell(rate, &source, 0.0f, faces, &mean);
    return;
  }
  evaluate_source(f, f->sweep->source + (size_t)live * count, count, &source);
  solve_cell(rate, &source, f->sweep->grid->extinction[live], faces, &mean);
  add_moments(f, &mean, f->out + (size_t)live * count, count);
}

static inline void cross_cells(const flow *f, int32_t j, int32_t k, lanes *x, unsigned count) {
  const np_transport_grid *grid = f->sweep->grid;
  const int32_t width = grid->size[0], *live = grid->live + (size_t)(k * grid->size[1] + j) * (size_t)width;
  const float *inverse = f->sweep->inverse_m[0];
  lanes rate[3] = {{0}, f->cosine[1] * f->sweep->inverse_m[1][j], f->cosine[2] * f->sweep->inverse_m[2][k]};
  lanes *y = f->y + (size_t)k * (size_t)width, *z = f->z + (size_t)j * (size_t)width;
  const int32_t reach = f->reach[k * grid->size[1] + j];
  for (int32_t n = 0; n < reach; n++) {
    const int32_t i = f->is_backward[0] ? width - 1 - n : n;
    rate[0] = f->cosine[0] * inverse[i];
    cross_cell(f, rate, live[i], (lanes *const[3]){x, &y[i], &z[i]}, count);
  }
}

/* The least number of harmonics, which large clouds have, is known to the compiler. */
static void cross_row(const flow *f, int32_t j, int32_t k) {
  lanes *x = &f->x[k * f->sweep->grid->size[1] + j];
  if (!f->sweep->grid->is_wrapped[0]) *x = f->inflow;
  if (f->harmonics == NP_HARMONIC_COUNT_MIN) {
    cross_cells(f, j, k, x, NP_HARMONIC_COUNT_MIN);
  } else {
    cross_cells(f, j, k, x, f->harmonics);
  }
}

static void enter(const flow *f, lanes *faces, int axis) {
  if (f->sweep->grid->is_wrapped[axis]) return;
  for (int32_t i = 0; i < f->sweep->grid->size[0]; i++) faces[i] = f->inflow;
}

/* One octant of a group. */
static void start_flow(const np_sweep *sweep, unsigned group, unsigned turn, unsigned block, flow *out) {
  const np_ordinates *o = sweep->ordinates;
  const int32_t *size = sweep->grid->size;
  const unsigned octant = group * NP_SWEEP_OCTANTS + turn;
  const size_t part = turn * o->block_count + block;
  const np_sweep_faces *faces = &sweep->faces[group];
  *out = (flow){.sweep = sweep,
                .harmonics = np_harmonics_count(o->degree),
                .harmonic = o->harmonic[octant][block],
                .weighted = o->weighted[octant][block],
                .inflow = *(const lanes *)sweep->inflow[octant][block],
                .reach = sweep->reach[octant],
                .x = (lanes *)faces->x + part * (size_t)size[1] * (size_t)size[2],
                .y = (lanes *)faces->y + part * (size_t)size[0] * (size_t)size[2],
                .z = (lanes *)faces->z + part * (size_t)size[0] * (size_t)size[1],
                .out = sweep->out[group]};
  for (int a = 0; a < 3; a++) {
    out->cosine[a] = *(const lanes *)o->cosine[a][block];
    out->is_backward[a] = octant >> a & 1u;
  }
}

/* Row by row, each in all directions while what it keeps is at hand. */
void NP_KERNEL(np_sweep_tile)(const np_sweep *sweep, unsigned group, int32_t tile_y, int32_t tile_z) {
  const int32_t *size = sweep->grid->size, first_y = tile_y * NP_SWEEP_TILE, first_z = tile_z * NP_SWEEP_TILE;
  flow flows[NP_SWEEP_OCTANTS * NP_ORDINATE_BLOCKS_MAX];
  unsigned count = 0;
  for (unsigned turn = 0; turn < NP_SWEEP_OCTANTS; turn++)
    for (unsigned block = 0; block < sweep->ordinates->block_count; block++)
      start_flow(sweep, group, turn, block, &flows[count++]);
  for (int32_t m = first_z; m < first_z + NP_SWEEP_TILE && m < size[2]; m++) {
    const int32_t k = flows->is_backward[2] ? size[2] - 1 - m : m;
    if (np_monitor_is_cancelled(sweep->monitor)) return;
    for (int32_t n = first_y; n < first_y + NP_SWEEP_TILE && n < size[1]; n++) {
      const int32_t j = flows->is_backward[1] ? size[1] - 1 - n : n;
      for (const flow *f = flows; f < flows + count; f++) {
        if (n == 0) enter(f, &f->y[k * size[0]], 1);
        if (m == 0) enter(f, &f->z[j * size[0]], 2);
        cross_row(f, j, k);
      }
    }
  }
}

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
#include "transport/sweep.h"

typedef float lanes __attribute__((vector_size(32), may_alias));
typedef int32_t mask __attribute__((vector_size(32)));

void NP_KERNEL(np_sweep_cross_tile)(const np_sweep *sweep, const np_sweep_tile *tile, unsigned thread);

/* Light at the faces of a cell, x, y, z. */
typedef struct face_light {
  lanes at[3];
} face_light;

/* State of a block of directions of one octant during its sweep through the cells. */
typedef struct flow {
  unsigned octant, number;
  const int32_t *reach; /* reach of np_sweep */
  lanes *x, *y, *z;     /* faces, as in np_sweep_faces */
} flow;

/* Radiances of a row's cells in the two octants of a pair: first outgoing, then mean. */
typedef struct twin {
  lanes up, down;
} twin;

/* The same block of both octants of a pair: up x, and down. */
typedef struct sweep_block {
  const np_sweep *sweep;
  unsigned harmonics, even; /* number of harmonics, and of the ones even in x */
  const float (*harmonic)[NP_ORDINATE_LANES];
  const float (*weighted)[NP_HARMONIC_COUNT_MAX];
  lanes cosine[3];
  flow flow[2];
  twin *row;
  float *out;
  bool is_first; /* nothing has been added to the tile's sums in this sweep */
} sweep_block;

/* Whether any lane is negative, −0 included. */
static inline bool has_sign(const face_light *light) {
  const mask signs = (mask)light->at[0] | (mask)light->at[1] | (mask)light->at[2];
#if defined(__AVX__)
  return _mm256_movemask_ps((__m256)signs) != 0;
#else
  int32_t any = 0;
  for (int i = 0; i < NP_ORDINATE_LANES; i++) any |= signs[i];
  return any < 0;
#endif
}

/* Clears the mask of faces whose outflow is negative. */
static inline void close_negative(lanes *open, const lanes *outflow) {
  *open = (lanes)((mask)*open & (*outflow >= 0.0f));
}

/* Rates 2μ/width of the cells, and their values for a cell without cloud. */
typedef struct cell_rates {
  float inverse_m;      /* 1/width along x */
  lanes rate[3], total; /* Σ 2μ */
  lanes share[3];       /* share of the light that enters in a void cell's mean */
  lanes inverse_total;
} cell_rates;

static inline void set_rates(const lanes cosine[3], float inverse_m, cell_rates *r) {
  r->inverse_m = inverse_m;
  r->rate[0] = 2.0f * cosine[0] * inverse_m;
  r->total = r->rate[0] + r->rate[1] + r->rate[2] + 1e-30f;
  for (int a = 0; a < 3; a++) r->share[a] = r->rate[a] / r->total;
  r->inverse_total = 1.0f / r->total;
}

/* Solves a cell again that has negative outflow through some face, with such faces closed. `out` is first the outflow
 * with all faces open. */
static inline void solve_closed(const cell_rates *r, const lanes *source, float extinction, const face_light *in,
                                face_light *out, lanes *mean) {
  lanes open[3];
  for (int a = 0; a < 3; a++) open[a] = (lanes){1, 1, 1, 1, 1, 1, 1, 1};
  for (int attempt = 0; attempt < 3; attempt++) {
    for (int a = 0; a < 3; a++) close_negative(&open[a], &out->at[a]);
    lanes gain = *source, loss = extinction + (lanes){0};
    for (int a = 0; a < 3; a++) {
      gain += r->rate[a] * (0.5f + 0.5f * open[a]) * in->at[a];
      loss += r->rate[a] * open[a];
    }
    *mean = gain / (loss + 1e-30f);
    for (int a = 0; a < 3; a++) out->at[a] = (lanes)((open[a] > 0.0f) & (mask)(2.0f * *mean - in->at[a]));
    if (!has_sign(out)) break;
  }
}

/* Outflow of a cell whose mean radiance was found with all faces open. */
static inline void compute_outflow(const cell_rates *r, const lanes *source, float extinction, face_light *light,
                                   lanes *mean) {
  const face_light in = *light;
  for (int a = 0; a < 3; a++) light->at[a] = 2.0f * *mean - in.at[a];
  if (has_sign(light)) solve_closed(r, source, extinction, &in, light, mean);
}

/* Replaces the light that enters a cell by the light that leaves it. Terms along x are added last, since they depend on
 * the cell before. */
static inline void cross_cloud(const cell_rates *r, float extinction, face_light *light, lanes *source_and_mean) {
  const lanes source = *source_and_mean, inverse = 1.0f / (extinction + r->total);
  const lanes aside = (source + r->rate[1] * light->at[1] + r->rate[2] * light->at[2]) * inverse;
  *source_and_mean = aside + r->rate[0] * inverse * light->at[0];
  compute_outflow(r, &source, extinction, light, source_and_mean);
}

static inline void cross_void(const cell_rates *r, face_light *light) {
  const lanes none = {0};
  lanes mean = r->share[1] * light->at[1] + r->share[2] * light->at[2] + r->share[0] * light->at[0];
  compute_outflow(r, &none, 0.0f, light, &mean);
}

static inline void cross_air(const cell_rates *r, float light_per_metre, face_light *light) {
  const lanes source = light_per_metre + (lanes){0};
  lanes mean = source * r->inverse_total;
  for (int a = 0; a < 3; a++) mean += r->share[a] * light->at[a];
  compute_outflow(r, &source, 0.0f, light, &mean);
}

/* Σ m·Y over some harmonics, towards each direction. */
static inline void sum_harmonics(const sweep_block *b, const float *moments, unsigned begin, unsigned end, lanes *out) {
  lanes first = {0}, second = {0};
  for (unsigned i = begin; i < end; i += 2) {
    first += moments[i] * *(const lanes *)b->harmonic[i];
    second += moments[i + 1] * *(const lanes *)b->harmonic[i + 1];
  }
  *out = first + second;
}

/* A truncated series may dip below 0, which no source does. */
static inline void clamp_positive(lanes *sum) { *sum = (lanes)((mask)*sum & (*sum > 0.0f)); }

static inline void fill_sources(const sweep_block *b, const int32_t *active, unsigned count, unsigned even) {
  for (int32_t i = 0; i < b->sweep->grid->size[0]; i++) {
    if (active[i] < 0) continue;
    const float *moments = b->sweep->source + (size_t)active[i] * count;
    b->row[i] = (twin){{0}, {0}};
    if (moments[0] == 0.0f) continue; /* no source: a third of the cells touch cloud and hold none */
    lanes same, opposite;
    sum_harmonics(b, moments, 0, even, &same);
    sum_harmonics(b, moments, even, count, &opposite);
    b->row[i] = (twin){same + opposite, same - opposite};
    clamp_positive(&b->row[i].up);
    clamp_positive(&b->row[i].down);
  }
}

/* Adds Σ weight·Y·ψ to the cells' moments, or sets these to it. Even harmonics need the sum over the pair of octants,
 * odd ones the difference. */
static inline void add_moments(const sweep_block *b, const twin *mean, float *moments, unsigned count, unsigned even,
                               bool is_first) {
  const lanes sum = mean->up + mean->down, difference = mean->up - mean->down;
  for (unsigned first = 0; first < count; first += NP_ORDINATE_LANES) {
    const mask number = (mask){0, 1, 2, 3, 4, 5, 6, 7} + (int32_t)first, is_even = number < (int32_t)even;
    lanes total = {0};
    if (!is_first) total = *(lanes *)(moments + first);
    for (int d = 0; d < NP_ORDINATE_LANES; d++) {
      lanes shining = (lanes){0} + difference[d];
      if (first + NP_ORDINATE_LANES <= even)
        shining = (lanes){0} + sum[d];
      else if (first < even)
        shining = (lanes)(((mask)shining & ~is_even) | ((mask)((lanes){0} + sum[d]) & is_even));
      total += shining * *(const lanes *)(b->weighted[d] + first);
    }
    *(lanes *)(moments + first) = total;
  }
}

static inline void store_moments(const sweep_block *b, const int32_t *active, unsigned count, unsigned even,
                                 bool is_first) {
  for (int32_t i = 0; i < b->sweep->grid->size[0]; i++)
    if (active[i] >= 0) add_moments(b, &b->row[i], b->out + (size_t)active[i] * count, count, even, is_first);
}

/* State of one octant's light during its sweep along a row. */
typedef struct course {
  lanes x, *y, *z;               /* y, z: at the faces of each cell */
  int32_t reach;                 /* cells to cross */
  const np_column_light *ground; /* light from the ground of the row's columns */
  lanes glint;         /* sun glint of water in the course's directions, relative to its mean (np_border.glint) */
  const float *sunlit; /* the row in np_cell_air.sunlit; NULL: its air is dark */
  float air;           /* light of sunlit air per metre */
  bool is_down;
  cell_rates rates;
} course;

/* The last node of an axis below a place, and how far on to the next it is. */
static inline unsigned get_node_below(const np_border_nodes *nodes, float place, float *out_share) {
  unsigned i = 0;
  while (i + 2 < nodes->count && place >= nodes->at[i + 1]) i++;
  *out_share = (place - nodes->at[i]) / (nodes->at[i + 1] - nodes->at[i]);
  return i;
}

/* Radiance from outside at a place of a face. */
static inline void get_border(const np_sweep *sweep, const flow *f, int axis, float u, float v, lanes *out) {
  const np_border_faces *faces = sweep->border;
  const np_border_nodes *nodes = np_border_get_nodes(faces, f->octant, axis);
  float s, t;
  const unsigned i = get_node_below(&nodes[0], u, &s), j = get_node_below(&nodes[1], v, &t);
  const lanes *low = (const lanes *)np_border_get_node(faces, f->octant, axis, j, i) + f->number;
  const lanes *high = low + NP_BORDER_NODES * faces->block_count, *next = low + faces->block_count;
  *out = (1.0f - t) * ((1.0f - s) * *low + s * *next) + t * ((1.0f - s) * *high + s * *(high + faces->block_count));
}

/* Place of a cell's middle along an axis, as a share of the box. */
static inline float get_middle(const np_transport_grid *grid, int axis, int32_t at) {
  const double *edge = grid->edge_m[axis];
  return (float)((0.5 * (edge[at] + edge[at + 1]) - edge[0]) / (edge[grid->size[axis]] - edge[0]));
}

static inline lanes *get_x_face(const np_transport_grid *grid, const flow *f, int32_t j, int32_t k) {
  return &f->x[k * grid->size[1] + j];
}

static inline const lanes *get_glint(const np_sweep *sweep, const flow *f) {
  return (const lanes *)sweep->border->glint + f->octant * NP_ORDINATE_BLOCKS_MAX + f->number;
}

/* Light that goes up from the ground of a column. */
static inline void light_column(const np_column_light *ground, const lanes *glint, lanes *out) {
  *out = ground->even + ground->glint * *glint;
}

static inline course start_course(const sweep_block *b, const flow *f, int32_t j, int32_t k) {
  const np_transport_grid *grid = b->sweep->grid;
  const int32_t width = grid->size[0];
  course c = {.y = f->y + (size_t)k * (size_t)width,
              .z = f->z + (size_t)j * (size_t)width,
              .reach = f->reach[k * grid->size[1] + j],
              .ground = b->sweep->ground ? b->sweep->ground + (size_t)j * (size_t)width : NULL,
              .is_down = f->octant & 4u};
  if (c.ground) c.glint = *get_glint(b->sweep, f);
  if (b->sweep->air.sunlit) {
    c.sunlit = b->sweep->air.sunlit + (size_t)(k * grid->size[1] + j) * (size_t)width;
    c.air = b->sweep->air.radiance[k][c.is_down ? NP_CELL_AIR_DOWN : NP_CELL_AIR_UP];
  }
  if (grid->is_wrapped[0])
    c.x = *get_x_face(grid, f, j, k);
  else
    get_border(b->sweep, f, 0, get_middle(grid, 1, j), get_middle(grid, 2, k), &c.x);
  c.rates.rate[1] = 2.0f * b->cosine[1] * b->sweep->inverse_m[1][j];
  c.rates.rate[2] = 2.0f * b->cosine[2] * b->sweep->inverse_m[2][k];
  c.rates.inverse_m = -1.0f;
  return c;
}

static inline void cross_cell(const sweep_block *b, course *c, int32_t i, int32_t active, lanes *light) {
  if (b->sweep->inverse_m[0][i] != c->rates.inverse_m) set_rates(b->cosine, b->sweep->inverse_m[0][i], &c->rates);
  face_light faces = {{c->x, c->y[i], c->z[i]}};
  if (active == NP_TRANSPORT_CELL_SOLID) {
    faces.at[0] = faces.at[1] = (lanes){0} + c->ground[i].even;
    /* Downward light is kept for np_sweep_measure_outflow. */
    if (!c->is_down) light_column(&c->ground[i], &c->glint, &faces.at[2]);
  } else if (active < 0 && c->sunlit)
    cross_air(&c->rates, c->sunlit[i] * c->air, &faces);
  else if (active < 0)
    cross_void(&c->rates, &faces);
  else
    cross_cloud(&c->rates, b->sweep->grid->extinction[active], &faces, light);
  c->x = faces.at[0];
  c->y[i] = faces.at[1];
  c->z[i] = faces.at[2];
}

/* Sweeps a row in both octants, alternating by cell: the two recurrences are independent, and run in parallel. */
static inline void cross_cells(const sweep_block *b, int32_t j, int32_t k, const int32_t *active) {
  const np_transport_grid *grid = b->sweep->grid;
  course up = start_course(b, &b->flow[0], j, k), down = start_course(b, &b->flow[1], j, k);
  for (int32_t n = 0; n < up.reach || n < down.reach; n++) {
    const int32_t i = grid->size[0] - 1 - n;
    if (n < up.reach) cross_cell(b, &up, n, active[n], &b->row[n].up);
    if (n < down.reach) cross_cell(b, &down, i, active[i], &b->row[i].down);
  }
  *get_x_face(grid, &b->flow[0], j, k) = up.x;
  *get_x_face(grid, &b->flow[1], j, k) = down.x;
}

__attribute__((always_inline)) static inline void cross_row_of(const sweep_block *b, int32_t j, int32_t k,
                                                               unsigned count, unsigned even) {
  const np_transport_grid *grid = b->sweep->grid;
  const int32_t *active = grid->active + (size_t)(k * grid->size[1] + j) * (size_t)grid->size[0];
  fill_sources(b, active, count, even);
  cross_cells(b, j, k, active);
  if (b->is_first)
    store_moments(b, active, count, even, true);
  else
    store_moments(b, active, count, even, false);
}

/* The numbers of harmonics that most clouds have are known to the compiler. */
static void cross_row(const sweep_block *b, int32_t j, int32_t k) {
  if (b->harmonics == 16 && b->even == 10)
    cross_row_of(b, j, k, 16, 10);
  else if (b->harmonics == 64 && b->even == 36)
    cross_row_of(b, j, k, 64, 36);
  else
    cross_row_of(b, j, k, b->harmonics, b->even);
}

/* Fills the light that enters row j or k through a face of an axis. */
static void fill_faces(const np_sweep *sweep, const flow *f, lanes *faces, int axis, int32_t row) {
  const np_transport_grid *grid = sweep->grid;
  if (grid->is_wrapped[axis]) return;
  const bool is_up = axis == 2 && !(f->octant & 4u);
  const np_column_light *ground = is_up && sweep->ground ? sweep->ground + (size_t)row * (size_t)grid->size[0] : NULL;
  const float v = get_middle(grid, axis == 1 ? 2 : 1, row);
  for (int32_t i = 0; i < grid->size[0]; i++)
    if (ground && ground[i].even >= 0.0f)
      light_column(&ground[i], get_glint(sweep, f), &faces[i]);
    else
      get_border(sweep, f, axis, get_middle(grid, 0, i), v, &faces[i]);
}

static flow start_flow(const np_sweep *sweep, unsigned pair, unsigned turn, unsigned number) {
  const int32_t *size = sweep->grid->size;
  const unsigned octant = 2 * pair + turn;
  const size_t part = turn * sweep->ordinates->block_count + number;
  const np_sweep_faces *faces = &sweep->faces[pair];
  return (flow){.octant = octant,
                .number = number,
                .reach = sweep->reach[octant],
                .x = (lanes *)faces->x + part * (size_t)size[1] * (size_t)size[2],
                .y = (lanes *)faces->y + part * (size_t)size[0] * (size_t)size[2],
                .z = (lanes *)faces->z + part * (size_t)size[0] * (size_t)size[1]};
}

static void start_block(const np_sweep *sweep, const np_sweep_tile *tile, unsigned number, unsigned thread,
                        sweep_block *out) {
  const np_ordinates *o = sweep->ordinates;
  const unsigned pair = tile->pair;
  *out = (sweep_block){.sweep = sweep,
                       .harmonics = np_harmonics_count(o->degree),
                       .even = o->even_count,
                       .is_first = tile->is_first && number == 0,
                       .harmonic = o->harmonic[pair][number],
                       .weighted = o->weighted[pair][number],
                       .row = (twin *)sweep->rows + (size_t)thread * (size_t)sweep->grid->size[0],
                       .out = sweep->out};
  for (int a = 0; a < 3; a++) out->cosine[a] = *(const lanes *)o->cosine[a][number];
  for (unsigned turn = 0; turn < 2; turn++) out->flow[turn] = start_flow(sweep, pair, turn, number);
}

/* Rows of a tile along y or z, numbered in the order in which light passes them. Tiles are cut from the low end, from
 * wherever light comes: opposite pairs have the same. */
typedef struct tile_rows {
  int32_t begin, end;
} tile_rows;

static tile_rows compute_rows(int32_t size, int32_t edge, int32_t tile, bool is_down) {
  const int32_t low = edge * (is_down ? (size - 1) / edge - tile : tile);
  const int32_t high = low + edge < size ? low + edge : size;
  return is_down ? (tile_rows){size - high, size - low} : (tile_rows){low, high};
}

/* Sweeps row by row, each row in all directions, so that its moments stay in the processor's cache. */
void NP_KERNEL(np_sweep_cross_tile)(const np_sweep *sweep, const np_sweep_tile *tile, unsigned thread) {
  const int32_t *size = sweep->grid->size;
  const bool is_down_y = tile->pair & 1u, is_down_z = tile->pair & 2u;
  const tile_rows y = compute_rows(size[1], NP_SWEEP_TILE_Y, tile->y, is_down_y);
  const tile_rows z = compute_rows(size[2], NP_SWEEP_TILE_Z, tile->z, is_down_z);
  sweep_block blocks[NP_ORDINATE_BLOCKS_MAX];
  const unsigned count = sweep->ordinates->block_count;
  for (unsigned number = 0; number < count; number++) start_block(sweep, tile, number, thread, &blocks[number]);
  for (int32_t m = z.begin; m < z.end; m++) {
    const int32_t k = is_down_z ? size[2] - 1 - m : m;
    if (np_monitor_is_cancelled(sweep->monitor)) return;
    for (int32_t n = y.begin; n < y.end; n++) {
      const int32_t j = is_down_y ? size[1] - 1 - n : n;
      for (const sweep_block *b = blocks; b < blocks + count; b++) {
        for (const flow *f = b->flow; f < b->flow + 2; f++) {
          if (n == 0) fill_faces(sweep, f, &f->y[k * size[0]], 1, k);
          if (m == 0) fill_faces(sweep, f, &f->z[j * size[0]], 2, j);
        }
        cross_row(b, j, k);
      }
    }
  }
}

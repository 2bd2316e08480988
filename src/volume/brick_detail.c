/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/brick_detail.h"

#include <stdlib.h>

#include "core/alloc.h"
#include "core/context_private.h"
#include "core/random.h"
#include "noise/noise.h"
#include "volume/brick_box.h"

enum {
  NOISE_EDGE = NP_DETAIL_NOISE_BRICKS * NP_BRICK_EDGE, /* samples along the texture, 8 for each cell of its lattice */
  NOISE_BRICKS = NP_DETAIL_NOISE_BRICKS * NP_DETAIL_NOISE_BRICKS * NP_DETAIL_NOISE_BRICKS,
  SAMPLES_PER_CELL = 8,
  RANK_SAMPLES = 1 << 16,
  BLOCKS = 8 /* blocks of a brick: 5³ samples each, with shared faces */
};

/* The coverage threshold c of the detail as a share of the largest sample nearby: samples above c are all cloud. */
static const float core_share = 0.7f;

/* Margin for the rounding of look-ups, relative to the largest c. */
static const float range_margin = 1e-6f;

/* Weights of the finer layers beside the nearest of the first two. */
static const float fine_weight[NP_DETAIL_LAYERS] = {0, 0, 0.4f, 0.2f};

/* Width of the step S in the rank of the noise: an edge of about a sixth of a voxel. */
static const float step_width = 0.15f;

/* Lattice cells of each layer per size of the billows. Two point sets are as dense as one set with a lattice finer by
 * the cube root of 2. */
static const double frequency[NP_DETAIL_LAYERS] = {0.79, 0.74, 2.1, 4.6};

/* Rotations as quaternions. Neither they nor their differences map axes close to axes. */
static const double quaternion[NP_DETAIL_LAYERS][4] = {{5, 2, -1, 3}, {4, -3, 2, -2}, {3, 2, 3, -1}, {5, -1, 3, 2}};

typedef struct detail_builder {
  neph_context *context;
  const np_bricks *source;
  np_detailed_bricks *out;
  int32_t (*place)[3];     /* table position of each node: the first of equal nodes */
  float (*blocks)[BLOCKS]; /* largest sample in each block of a brick */
} detail_builder;

/* ---- Noise ---- */

/* Fills a plane of samples across x. */
static void fill_plane(neph_context *context, uint32_t seed, int plane, float *x, float *out) {
  enum { COUNT = NOISE_EDGE * NOISE_EDGE, PERIOD = NOISE_EDGE / SAMPLES_PER_CELL };
  const np_noise_lattice lattice = {seed, {PERIOD, PERIOD, PERIOD}};
  float *y = x + COUNT, *z = y + COUNT;
  for (int n = 0; n < COUNT; n++) {
    x[n] = (float)plane / SAMPLES_PER_CELL;
    y[n] = (float)(n / NOISE_EDGE) / SAMPLES_PER_CELL;
    z[n] = (float)(n % NOISE_EDGE) / SAMPLES_PER_CELL;
  }
  const np_noise_points points = {COUNT, x, y, z};
  np_noise_get_table(context->isa)->worley(&lattice, &points, out);
}

static void cut_brick(neph_context *context, const float *texture, size_t number, uint16_t *out) {
  enum { EDGE = NP_DETAIL_NOISE_BRICKS, MASK = NOISE_EDGE - 1 };
  const size_t first[3] = {number / (EDGE * EDGE) * NP_BRICK_EDGE, number / EDGE % EDGE * NP_BRICK_EDGE,
                           number % EDGE * NP_BRICK_EDGE};
  float samples[NP_BRICK_VOLUME];
  for (size_t n = 0; n < NP_BRICK_VOLUME; n++) {
    const size_t x = (first[0] + n / NP_BRICK_STRIDE_X) & MASK, z = (first[2] + n % NP_BRICK_SAMPLES) & MASK,
                 y = (first[1] + n / NP_BRICK_SAMPLES % NP_BRICK_SAMPLES) & MASK;
    samples[n] = texture[(x * NOISE_EDGE + y) * NOISE_EDGE + z];
  }
  np_half_encode(context->isa, samples, NP_BRICK_VOLUME, 1.0f, out);
}

static neph_result make_texture(detail_builder *b, uint64_t seed) {
  const size_t plane = (size_t)NOISE_EDGE * NOISE_EDGE;
  np_bricks *noise = &b->out->noise;
  *noise = (np_bricks){.context = b->context, .scale = 1.0f, .brick_count = NOISE_BRICKS, .value_max = 1.0f};
  noise->halves = np_alloc(b->context, (size_t)NOISE_BRICKS * NP_BRICK_STRIDE, sizeof *noise->halves);
  float *texture = np_alloc(b->context, (NOISE_EDGE + 3) * plane, sizeof *texture);
  const bool has_memory = noise->halves && texture;
  for (int k = 0; k < NOISE_EDGE && has_memory; k++)
    fill_plane(b->context, np_noise_derive_seed(seed, 0), k, texture + NOISE_EDGE * plane, texture + (size_t)k * plane);
  for (size_t n = 0; n < NOISE_BRICKS && has_memory; n++)
    cut_brick(b->context, texture, n, noise->halves + n * NP_BRICK_STRIDE);
  np_alloc_free(b->context, texture);
  return has_memory ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* Sets the map from index positions to samples of the texture. */
static void set_turn(np_brick_detail *detail, int layer, np_random *random) {
  const double *q = quaternion[layer], w = q[0], x = q[1], y = q[2], z = q[3];
  const double rotation[3][3] = {{w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)},
                                 {2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)},
                                 {2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z}};
  const double scale = SAMPLES_PER_CELL * frequency[layer] / (w * w + x * x + y * y + z * z);
  for (int row = 0; row < 3; row++) {
    for (int a = 0; a < 3; a++) detail->turn[layer][row][a] = scale * rotation[row][a] / detail->size_voxels[a];
    detail->turn[layer][row][3] = NOISE_EDGE * np_random_double(random);
  }
}

/* First rank that is above a value. */
static int search_rank(float value, float end) {
  int k = (int)np_clampf(value / end * NP_DETAIL_RANKS, 0.0f, NP_DETAIL_RANKS);
  while (k > 0 && value * NP_DETAIL_RANKS < (float)(k - 1) * end) k--;
  while (k < NP_DETAIL_RANKS && !(value * NP_DETAIL_RANKS < (float)k * end)) k++;
  return k;
}

/* Measures the distribution of the noise at distant positions in each layer, the same for all volumes. */
static neph_result rank_noise(detail_builder *b, np_random *random) {
  np_brick_detail *detail = &b->out->detail;
  float *values = np_alloc(b->context, RANK_SAMPLES, sizeof *values);
  if (!values) return NEPH_ERROR_OUT_OF_MEMORY;
  const double far_voxels = 4096.0;
  for (size_t n = 0; n < RANK_SAMPLES; n++) {
    double at[3];
    for (int a = 0; a < 3; a++) at[a] = far_voxels * detail->size_voxels[a] * np_random_double(random);
    values[n] = np_brick_detail_get_noise(detail, at);
  }
  size_t count[NP_DETAIL_RANKS + 1] = {0}, below = 0;
  for (size_t n = 0; n < RANK_SAMPLES; n++) detail->rank_end = np_maxf(detail->rank_end, values[n]);
  for (size_t n = 0; n < RANK_SAMPLES; n++) count[search_rank(values[n], detail->rank_end)]++;
  for (int k = 0; k <= NP_DETAIL_RANKS; k++) {
    below += count[k];
    detail->rank[k] = (float)below / RANK_SAMPLES;
  }
  detail->rank[NP_DETAIL_RANKS] = 1.0f;
  np_alloc_free(b->context, values);
  return NEPH_OK;
}

static neph_result make_noise(detail_builder *b, const np_brick_detail_desc *desc) {
  np_brick_detail *detail = &b->out->detail;
  np_random random = np_random_start(desc->seed, 0, 0, 0, 0);
  *detail = (np_brick_detail){.strength = desc->strength, .noise = &b->out->noise, .width = step_width};
  for (int k = NP_DETAIL_LAYERS - 1; k >= 2; k--) {
    detail->weight[k] = fine_weight[k];
    detail->rest[k] = fine_weight[k] + (k + 1 < NP_DETAIL_LAYERS ? detail->rest[k + 1] : 0.0f);
  }
  for (int a = 0; a < 3; a++) detail->size_voxels[a] = desc->size_voxels[a];
  for (int k = 0; k < NP_DETAIL_LAYERS; k++) set_turn(detail, k, &random);
  const neph_result result = make_texture(b, desc->seed);
  return result ? result : rank_noise(b, &random);
}

/* ---- Cores ---- */

static void set_places(const detail_builder *b) {
  const np_bricks *source = b->source;
  const size_t count = np_bricks_count_table(source),
               slice = (size_t)source->table_size[1] * (size_t)source->table_size[2];
  for (size_t entry = count; entry-- > 0;) {
    if (source->table[entry] == NP_BRICK_NONE) continue;
    int32_t *place = b->place[source->table[entry]];
    place[0] = (int32_t)(entry / slice);
    place[1] = (int32_t)(entry % slice / (size_t)source->table_size[2]);
    place[2] = (int32_t)(entry % (size_t)source->table_size[2]);
  }
}

/* Position of a cell, counted from the first of the table. */
static void get_cell(const detail_builder *b, size_t node, size_t number, int32_t out[3]) {
  const int32_t in_node[3] = {(int32_t)(number >> 8), (int32_t)(number >> 4 & 15), (int32_t)(number & 15)};
  for (int a = 0; a < 3; a++) out[a] = b->place[node][a] * NP_BRICK_NODE_EDGE + in_node[a] - b->source->lead[a];
}

static float get_sample(const np_bricks *bricks, size_t n) {
  return bricks->scale * (bricks->halves ? np_half_to_float(bricks->halves[n]) : bricks->floats[n]);
}

static void measure_blocks(const np_bricks *source, uint32_t brick, float out[BLOCKS]) {
  enum { HALF = NP_BRICK_EDGE / 2 };
  for (int k = 0; k < BLOCKS; k++) {
    const size_t first = (size_t)brick * NP_BRICK_STRIDE + (size_t)(k >> 2) * HALF * NP_BRICK_STRIDE_X +
                         (size_t)(k >> 1 & 1) * HALF * NP_BRICK_SAMPLES + (size_t)(k & 1) * HALF;
    float most = -INFINITY;
    for (size_t x = 0; x <= HALF; x++)
      for (size_t y = 0; y <= HALF; y++)
        for (size_t z = 0; z <= HALF; z++)
          most = fmaxf(most, get_sample(source, first + x * NP_BRICK_STRIDE_X + y * NP_BRICK_SAMPLES + z));
    out[k] = most;
  }
}

/* Largest value around a node, and the range of the constant cells. */
typedef struct core_bound {
  float most, level;
} core_bound;

/* Adds a block to the bound, by its position in blocks from the first of the table. */
static void include_block(const detail_builder *b, const int32_t at[3], core_bound *bound) {
  const np_bricks *source = b->source;
  int32_t cell[3];
  float value = source->background;
  bool is_inside = true;
  for (int a = 0; a < 3; a++) {
    cell[a] = at[a] >> 1;
    if (a < 2 && source->is_periodic[a]) cell[a] = np_brick_wrap(cell[a], source->size[a]);
    is_inside = is_inside && cell[a] >= 0 && cell[a] < source->size[a];
  }
  if (is_inside) {
    const np_brick_place place = np_bricks_get_place(source, cell);
    const uint32_t brick = np_bricks_get_brick(source, &place);
    if (brick != NP_BRICK_NONE) {
      bound->most = fmaxf(bound->most, b->blocks[brick][(at[0] & 1) << 2 | (at[1] & 1) << 1 | (at[2] & 1)]);
      return;
    }
    value = np_bricks_get_range(source, &place, 0).min;
  }
  bound->most = fmaxf(bound->most, value);
  if (value > 0.0f) bound->level = fminf(bound->level, value);
}

/* c at one of the nodes of a cell's brick. Next to constant cells, which have no detail, c is at most their value, so
 * that detail vanishes on their faces. */
static float measure_core(const detail_builder *b, const int32_t cell[3], const int node[3]) {
  core_bound bound = {-INFINITY, INFINITY};
  for (int k = 0; k < BLOCKS; k++) {
    const int32_t at[3] = {2 * cell[0] + node[0] - (k >> 2), 2 * cell[1] + node[1] - (k >> 1 & 1),
                           2 * cell[2] + node[2] - (k & 1)};
    include_block(b, at, &bound);
  }
  return fminf(core_share * bound.most, bound.level);
}

/* c·S, the target of a value, for a c of at most `core`. */
static float bound_step(const np_brick_detail *detail, float value, float core, float rank) {
  const float inside = fminf(value, core), edge = np_brick_detail_get_edge(inside / core, detail->width);
  return inside + detail->strength * (core * np_brick_detail_get_step(detail, edge, rank) - inside);
}

/* Range of v′, which increases with v; with c it increases for the lowest rank, and decreases for the highest. */
static np_brick_range bound_detail(const np_brick_detail *detail, np_brick_range range, float core) {
  const float margin = range_margin * core;
  np_brick_range out = range;
  if (!(core > 0.0f) || range.min >= core) return out;
  if (range.max > 0.0f) out.max = fmaxf(range.max, bound_step(detail, range.max, core, 0.0f) + margin);
  if (range.min > 0.0f) out.min = fminf(range.min, fmaxf(bound_step(detail, range.min, core, 1.0f) - margin, 0.0f));
  return out;
}

static void fill_cell(const detail_builder *b, size_t node, size_t number) {
  np_brick_node *own = &b->out->bricks.nodes[node];
  const uint32_t brick = own->brick[number];
  if (brick == NP_BRICK_NONE) return;
  float *cores = b->out->cores + (size_t)brick * NP_DETAIL_CORE_STRIDE, most = 0.0f;
  int32_t cell[3];
  get_cell(b, node, number, cell);
  for (int n = 0; n < NP_DETAIL_CORE_NODES * NP_DETAIL_CORE_NODES * NP_DETAIL_CORE_NODES; n++) {
    cores[n] = measure_core(b, cell, (const int[3]){n / 9, n / 3 % 3, n % 3});
    most = fmaxf(most, cores[n]);
  }
  own->range[number] = bound_detail(&b->out->detail, own->range[number], most);
}

static void unite_ranges(np_brick_node *node) {
  const np_brick_range nothing = {INFINITY, -INFINITY};
  node->whole_range = nothing;
  for (int g = 0; g < NP_BRICK_NODE_GROUPS; g++) node->group_range[g] = nothing;
  for (int cell = 0; cell < NP_BRICK_NODE_CELLS; cell++) {
    np_brick_range *group = &node->group_range[cell >> 10 << 4 | (cell >> 6 & 3) << 2 | (cell >> 2 & 3)];
    *group = np_brick_range_unite(*group, node->range[cell]);
    node->whole_range = np_brick_range_unite(node->whole_range, node->range[cell]);
  }
}

static neph_result measure_bricks(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const detail_builder *b = user;
  for (size_t brick = begin; brick < end; brick++) measure_blocks(b->source, (uint32_t)brick, b->blocks[brick]);
  return NEPH_OK;
}

static neph_result fill_nodes(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const detail_builder *b = user;
  for (size_t node = begin; node < end; node++) {
    b->out->bricks.nodes[node] = b->source->nodes[node];
    for (size_t number = 0; number < NP_BRICK_NODE_CELLS; number++) fill_cell(b, node, number);
    unite_ranges(&b->out->bricks.nodes[node]);
  }
  return NEPH_OK;
}

static neph_result make_bricks(detail_builder *b, np_monitor *monitor) {
  const np_bricks *source = b->source;
  np_detailed_bricks *out = b->out;
  out->bricks = *source;
  out->bricks.detail = &out->detail;
  out->bricks.is_indirect = true;
  out->bricks.nodes = np_alloc(b->context, source->node_count, sizeof *out->bricks.nodes);
  out->cores = np_alloc(b->context, source->brick_count * NP_DETAIL_CORE_STRIDE, sizeof *out->cores);
  b->blocks = np_alloc(b->context, source->brick_count, sizeof *b->blocks);
  b->place = np_alloc(b->context, source->node_count, sizeof *b->place);
  if (!out->bricks.nodes || !out->cores || !b->blocks || !b->place) return NEPH_ERROR_OUT_OF_MEMORY;
  out->detail.cores = out->cores;
  set_places(b);
  const neph_result result = np_parallel_for(b->context, monitor, source->brick_count, 64, measure_bricks, b);
  return result ? result : np_parallel_for(b->context, monitor, source->node_count, 1, fill_nodes, b);
}

neph_result np_detailed_bricks_build(neph_context *context, const np_brick_detail_desc *desc, np_monitor *monitor,
                                     np_detailed_bricks **out) {
  *out = NULL;
  detail_builder b = {.context = context, .source = desc->source, .out = np_alloc(context, 1, sizeof *b.out)};
  if (!b.out) return NEPH_ERROR_OUT_OF_MEMORY;
  b.out->bricks.context = context;
  neph_result result = make_noise(&b, desc);
  if (!result) result = make_bricks(&b, monitor);
  np_alloc_free(context, b.place);
  np_alloc_free(context, b.blocks);
  if (result)
    np_detailed_bricks_destroy(b.out);
  else
    *out = b.out;
  return result;
}

void np_detailed_bricks_destroy(np_detailed_bricks *detailed) {
  if (!detailed) return;
  neph_context *context = detailed->bricks.context;
  np_alloc_free(context, detailed->bricks.nodes);
  np_alloc_free(context, detailed->cores);
  np_bricks_clear(&detailed->noise);
  np_alloc_free(context, detailed);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* The sun optical-depth volume: placing its lattices, filling them column by column, and look-up. */
#include "caches/sun_optical_depth.h"

#include <assert.h>

#include "core/alloc.h"
#include "core/half.h"
#include "core/isa.h"
#include "core/stable.h"
#include "core/units.h"
#include "volume/brick_walk.h"
#include "volume/tracking.h"

enum { FINE_NODES = NP_SUN_FINE_EDGE + 1 };

/* ---- Kernels ---- */

typedef void (*column_fn)(np_sun_column *column);

void np_sun_column_fill_v1(np_sun_column *);
void np_sun_column_fill_v3(np_sun_column *);
void np_sun_column_fill_v4(np_sun_column *);
void np_sun_column_refine_v1(np_sun_column *);
void np_sun_column_refine_v3(np_sun_column *);
void np_sun_column_refine_v4(np_sun_column *);

static const struct {
  column_fn fill, refine;
} kernels[NP_ISA_COUNT] = {{np_sun_column_fill_v1, np_sun_column_refine_v1},
                           {np_sun_column_fill_v3, np_sun_column_refine_v3},
                           {np_sun_column_fill_v4, np_sun_column_refine_v4}};

/* ---- Places ---- */

/* Finest spacing of a cloud's samples. */
static double compute_finest_spacing(const np_instance *volume) {
  double finest = INFINITY;
  for (int a = 0; a < 3; a++) {
    const double *row = volume->world_to_index.m[a];
    finest = fmin(finest, 1.0 / np_dvec3_length(np_dvec3_make(row[0], row[1], row[2])));
  }
  return finest;
}

/* Unit axes of the lattice: the third points away from the sun, the first is level, so that under a low sun a flat
 * field of clouds fills its box. */
static np_affine make_axes(np_vec3 to_sun) {
  const np_dvec3 away = np_dvec3_scale(np_dvec3_normalize(np_vec3_to_double(to_sun)), -1.0);
  const np_dvec3 level = np_dvec3_make(-away.y, away.x, 0.0);
  const np_dvec3 u = np_dvec3_length(level) > 1e-6 ? np_dvec3_normalize(level) : np_dvec3_make(1.0, 0.0, 0.0);
  const np_dvec3 v = np_dvec3_cross(away, u);
  return (np_affine){{{u.x, u.y, u.z, 0}, {v.x, v.y, v.z, 0}, {away.x, away.y, away.z, 0}}};
}

/* Box of a cloud's bricks along the axes. */
static void bound(const np_instance *volume, const np_affine *axes, double low[3], double high[3]) {
  np_affine index_to_world;
  if (!np_affine_invert(&volume->world_to_index, &index_to_world)) index_to_world = np_affine_identity();
  const np_bricks *bricks = volume->bricks;
  for (int a = 0; a < 3; a++) {
    low[a] = INFINITY;
    high[a] = -INFINITY;
  }
  for (int corner = 0; corner < 8; corner++) {
    double index[3];
    for (int a = 0; a < 3; a++)
      index[a] = (double)NP_BRICK_EDGE * (bricks->origin[a] + (corner >> a & 1 ? bricks->size[a] : 0));
    const np_dvec3 p =
        np_affine_point(axes, np_affine_point(&index_to_world, np_dvec3_make(index[0], index[1], index[2])));
    const double along[3] = {p.x, p.y, p.z};
    for (int a = 0; a < 3; a++) {
      low[a] = fmin(low[a], along[a]);
      high[a] = fmax(high[a], along[a]);
    }
  }
}

/* The cloud of a lattice. */
static const np_instance *get_volume(const np_sun_optical_depth *cache, const np_world *world, unsigned lattice) {
  return cache->places ? &world->clouds.places->at[cache->stands[lattice]] : &world->clouds.at[lattice];
}

static bool has_lattice(const np_instance *volume) {
  return volume->bricks->value_max > 0.0f && !volume->bricks->is_periodic[0] && !volume->bricks->is_periodic[1];
}

/* Places a lattice over a cloud, with nodes `coarsening` times as far apart as its voxels. */
static void place(const np_instance *volume, np_vec3 to_sun, double coarsening, np_sun_lattice *out) {
  *out = (np_sun_lattice){.spacing_m = coarsening * compute_finest_spacing(volume)};
  if (!has_lattice(volume)) return;
  np_affine map = make_axes(to_sun);
  double low[3], high[3];
  bound(volume, &map, low, high);
  for (int a = 0; a < 3; a++) {
    const double edge = NP_SUN_CELL_EDGE * out->spacing_m;
    out->size[a] = (int32_t)np_clamp(ceil((high[a] - low[a]) / edge), 1.0, 1e5);
    for (int j = 0; j < 3; j++) map.m[a][j] /= out->spacing_m;
    map.m[a][3] = -low[a] / out->spacing_m;
  }
  out->world_to_lattice = map;
  if (!np_affine_invert(&map, &out->lattice_to_world)) out->size[0] = 0;
}

static size_t count_cells(const np_sun_lattice *l) {
  return (size_t)l->size[0] * (size_t)l->size[1] * (size_t)l->size[2];
}

/* Upper bound of bytes: the table, and all nodes where the cloud has bricks; rotated bricks touch half as many cells
 * again. */
static double bound_bytes(const np_sun_optical_depth *cache, const np_world *world, double coarsening) {
  double bytes = 0.0;
  for (unsigned v = 0; v < cache->volume_count; v++) {
    const np_instance *volume = get_volume(cache, world, v);
    np_sun_lattice lattice;
    place(volume, world->to_sun, coarsening, &lattice);
    const double cells = 1.5 * (double)volume->bricks->brick_count / (coarsening * coarsening * coarsening);
    if (lattice.size[0] == 0) continue;
    bytes += (double)count_cells(&lattice) * sizeof(uint32_t) +
             cells * (NP_SUN_CELL_NODES * NP_SUN_CELL_NODES * NP_SUN_CELL_NODES * sizeof(uint16_t));
  }
  return bytes;
}

/* Number of cells of a table that any cloud may have, and per brick: large tiles, and boxes that are empty but for a
 * stray voxel, have more. Cells too coarse for the tolerance then become steep. */
static const double cells_free = 0x1p14, cells_per_brick = 64.0;

/* Greatest number of cells: the smaller the share of cells with bricks, the fewer. */
static double count_cells_max(const np_instance *volume) {
  const int32_t *size = volume->bricks->size;
  const double box = (double)size[0] * size[1] * size[2];
  const double enough = cells_per_brick * (double)volume->bricks->brick_count;
  return fmax(cells_free, enough * sqrt(fmin(enough / box, 1.0)));
}

static bool has_too_many_cells(const np_sun_optical_depth *cache, const np_world *world, double coarsening) {
  bool has = false;
  for (unsigned v = 0; v < cache->volume_count; v++) {
    const np_instance *volume = get_volume(cache, world, v);
    np_sun_lattice lattice;
    place(volume, world->to_sun, coarsening, &lattice);
    has = has || (double)count_cells(&lattice) > count_cells_max(volume);
  }
  return has;
}

static double choose_coarsening(const np_sun_optical_depth *cache, const np_world *world,
                                const np_sun_optical_depth_desc *desc) {
  double coarsening = 1.0;
  while (coarsening < 1e3 && (bound_bytes(cache, world, coarsening) > (double)desc->bytes_max ||
                              has_too_many_cells(cache, world, coarsening)))
    coarsening *= 1.25;
  return coarsening;
}

/* ---- Filling ---- */

typedef struct lattice_fill {
  const np_instance *volume;
  const np_sun_optical_depth_desc *desc;
  np_sun_optical_depth *cache;
  np_sun_lattice *lattice;
  np_vec3 from_sun;
  column_fn kernel;
  float *rays; /* rays of each thread */
  size_t rays_stride;
} lattice_fill;

static lattice_fill start_fill(np_sun_optical_depth *cache, const np_world *world, unsigned v,
                               const np_sun_optical_depth_desc *desc) {
  return (lattice_fill){.volume = get_volume(cache, world, v),
                        .desc = desc,
                        .cache = cache,
                        .lattice = &cache->lattices[v],
                        .from_sun = np_vec3_scale(world->to_sun, -1.0f)};
}

static np_sun_column start_column(const lattice_fill *f, size_t n, unsigned thread) {
  const np_sun_lattice *l = f->lattice;
  return (np_sun_column){.context = f->cache->context,
                         .volume = f->volume,
                         .lattice = l,
                         .desc = f->desc,
                         .depth_end = f->cache->depth_end,
                         .from_sun = f->from_sun,
                         .at = {(int32_t)(n / (size_t)l->size[1]), (int32_t)(n % (size_t)l->size[1])},
                         .rays = f->rays + thread * f->rays_stride,
                         .cells = l->cells + n * (size_t)l->size[2]};
}

/* Encodes a cell's nodes. Depths beyond the halves' largest are as dark. */
static void encode_nodes(const np_sun_column *column, float *depths, size_t count, uint16_t *out) {
  for (size_t i = 0; i < count; i++) depths[i] = np_minf(depths[i], 65504.0f);
  np_half_encode(neph_context_get_isa(column->context), depths, count, 1.0f, out);
}

/* Copies the nodes of each cell from the rays, at its level, to `nodes`. */
static void copy_nodes(const np_sun_column *column, uint16_t *nodes) {
  const size_t count = (size_t)column->lattice->size[2] * NP_SUN_CELL_EDGE + 1;
  for (int32_t k = 0; k < column->lattice->size[2]; k++) {
    if (!np_sun_cell_keeps(column->cells[k])) continue;
    const unsigned stride = 1u << (np_sun_cell_get_level(column->cells[k]) - 1);
    const float *first = column->rays + (size_t)k * NP_SUN_CELL_EDGE;
    float depths[NP_SUN_CELL_NODES * NP_SUN_CELL_NODES * NP_SUN_CELL_NODES];
    size_t copied = 0;
    for (unsigned i = 0; i < NP_SUN_CELL_NODES; i += stride)
      for (unsigned j = 0; j < NP_SUN_CELL_NODES; j += stride)
        for (unsigned n = 0; n < NP_SUN_CELL_NODES; n += stride)
          depths[copied++] = first[(size_t)(i * NP_SUN_CELL_NODES + j) * count + n];
    encode_nodes(column, depths, copied, nodes);
    nodes += copied;
  }
}

static neph_result fill_columns(void *user, size_t begin, size_t end, unsigned thread) {
  const lattice_fill *f = user;
  np_sun_lattice *l = f->lattice;
  for (size_t n = begin; n < end; n++) {
    np_sun_column column = start_column(f, n, thread);
    f->kernel(&column);
    assert(column.node_count == 0 || !l->nodes[n]);
    if (column.node_count == 0) continue;
    l->nodes[n] = np_alloc(f->cache->context, column.node_count, sizeof **l->nodes);
    if (!l->nodes[n]) return NEPH_ERROR_OUT_OF_MEMORY;
    copy_nodes(&column, l->nodes[n]);
  }
  return NEPH_OK;
}

/* Corrects a node by a twelfth of its second differences, so that the interpolant is right in the mean. The face away
 * from the sun is read from all places behind it: there only differences along the face count. */
static float sharpen(const float *node, size_t stride, size_t n) {
  const size_t across = NP_SUN_FINE_RAYS * stride;
  float quadratic = *(node - across) + node[across] + *(node - stride) + node[stride] - 4.0f * *node;
  if (n > 0 && n < NP_SUN_FINE_EDGE) quadratic += *(node - 1) + node[1] - 2.0f * *node;
  return *node - quadratic * (1.0f / 12.0f);
}

/* Copies the nodes of refined cells from the fine rays. */
static void copy_fine_nodes(const np_sun_column *column, uint16_t *nodes) {
  const size_t stride = np_sun_column_count_fine(column);
  for (int32_t k = 0; k < column->lattice->size[2]; k++) {
    if (!np_sun_cell_keeps(column->cells[k]) || np_sun_cell_get_level(column->cells[k]) > 0) continue;
    const float *first = np_sun_column_get_fine(column, k);
    float depths[FINE_NODES * FINE_NODES * FINE_NODES];
    size_t copied = 0;
    for (size_t i = 0; i <= NP_SUN_FINE_EDGE; i++)
      for (size_t j = 0; j <= NP_SUN_FINE_EDGE; j++)
        for (size_t n = 0; n <= NP_SUN_FINE_EDGE; n++)
          depths[copied++] = sharpen(first + (i * NP_SUN_FINE_RAYS + j) * stride + n, stride, n);
    encode_nodes(column, depths, copied, nodes + (column->cells[k] >> NP_SUN_CELL_LEVEL_BITS));
  }
}

static size_t count_nodes(const np_sun_column *column) {
  size_t count = 0;
  for (int32_t k = 0; k < column->lattice->size[2]; k++)
    if (np_sun_cell_keeps(column->cells[k])) count += np_sun_level_count_nodes(np_sun_cell_get_level(column->cells[k]));
  return count;
}

static neph_result refine_columns(void *user, size_t begin, size_t end, unsigned thread) {
  const lattice_fill *f = user;
  np_sun_lattice *l = f->lattice;
  for (size_t n = begin; n < end; n++) {
    np_sun_column column = start_column(f, n, thread);
    const size_t before = column.node_count = count_nodes(&column);
    f->kernel(&column);
    assert(column.node_count >= before);
    if (column.node_count == before) continue;
    uint16_t *nodes = np_alloc_resize(f->cache->context, l->nodes[n], column.node_count, sizeof *nodes);
    if (!nodes) return NEPH_ERROR_OUT_OF_MEMORY;
    l->nodes[n] = nodes;
    copy_fine_nodes(&column, nodes);
  }
  return NEPH_OK;
}

static neph_result run_kernel(lattice_fill *f, column_fn kernel, size_t rays_stride, np_parallel_fn columns,
                              np_monitor *monitor) {
  neph_context *context = f->cache->context;
  f->kernel = kernel;
  f->rays_stride = rays_stride;
  f->rays = np_alloc(context, rays_stride * neph_context_get_thread_count(context), sizeof *f->rays);
  if (!f->rays) return NEPH_ERROR_OUT_OF_MEMORY;
  const size_t count = (size_t)f->lattice->size[0] * (size_t)f->lattice->size[1];
  neph_result result = np_parallel_for(context, monitor, count, 1, columns, f);
  np_alloc_free(context, f->rays);
  return result;
}

static neph_result fill_lattice(np_sun_optical_depth *cache, const np_world *world, unsigned v,
                                const np_sun_optical_depth_desc *desc, np_monitor *monitor) {
  np_sun_lattice *l = &cache->lattices[v];
  const size_t columns = (size_t)l->size[0] * (size_t)l->size[1];
  if (columns == 0) return NEPH_OK;
  lattice_fill f = start_fill(cache, world, v, desc);
  l->cells = np_alloc(cache->context, count_cells(l), sizeof *l->cells);
  l->nodes = np_alloc(cache->context, columns, sizeof *l->nodes);
  if (!l->cells || !l->nodes) return NEPH_ERROR_OUT_OF_MEMORY;
  const size_t stride = NP_SUN_CELL_NODES * NP_SUN_CELL_NODES * ((size_t)l->size[2] * NP_SUN_CELL_EDGE + 1);
  return run_kernel(&f, kernels[neph_context_get_isa(cache->context)].fill, stride, fill_columns, monitor);
}

static neph_result refine_lattice(np_sun_optical_depth *cache, const np_world *world, unsigned v,
                                  const np_sun_optical_depth_desc *desc, np_monitor *monitor) {
  const np_sun_lattice *l = &cache->lattices[v];
  if (l->size[0] == 0) return NEPH_OK;
  lattice_fill f = start_fill(cache, world, v, desc);
  const size_t stride = NP_SUN_FINE_RAYS * NP_SUN_FINE_RAYS * ((size_t)l->size[2] * NP_SUN_FINE_EDGE + 2);
  return run_kernel(&f, kernels[neph_context_get_isa(cache->context)].refine, stride, refine_columns, monitor);
}

/* Counts cells of each kind, for the log and tests. */
static void count_cell_kinds(np_sun_optical_depth *cache) {
  cache->bytes = 0;
  cache->steep_cells = cache->dark_cells = 0;
  for (unsigned level = 0; level < NP_SUN_CELL_LEVELS; level++) cache->level_cells[level] = 0;
  for (unsigned v = 0; v < cache->volume_count; v++) {
    const np_sun_lattice *l = &cache->lattices[v];
    const size_t count = count_cells(l);
    cache->bytes += count * sizeof *l->cells;
    for (size_t n = 0; n < count; n++) {
      cache->steep_cells += l->cells[n] == NP_SUN_CELL_STEEP;
      cache->dark_cells += l->cells[n] == NP_SUN_CELL_DARK;
      if (!np_sun_cell_keeps(l->cells[n])) continue;
      const uint32_t level = np_sun_cell_get_level(l->cells[n]);
      cache->level_cells[level]++;
      cache->bytes += np_sun_level_count_nodes(level) * sizeof **l->nodes;
    }
  }
}

static void report(const np_sun_optical_depth *c) {
  const uint64_t *cells = c->level_cells;
  np_log(c->context, NEPH_LOG_DEBUG,
         "sun optical depth: %.3g MB; cells of 17, 9, 5, 3 and 2 nodes an edge: %llu, %llu, %llu, %llu, %llu; "
         "steep %llu, dark %llu",
         (double)c->bytes * 1e-6, (unsigned long long)cells[0], (unsigned long long)cells[1],
         (unsigned long long)cells[2], (unsigned long long)cells[3], (unsigned long long)cells[4],
         (unsigned long long)c->steep_cells, (unsigned long long)c->dark_cells);
}

/* Fills the optical depths of all clouds, or of their steep cells. */
static neph_result fill_lattices(np_sun_optical_depth *cache, const np_world *world,
                                 const np_sun_optical_depth_desc *desc, bool is_fine, np_monitor *monitor) {
  neph_result result = NEPH_OK;
  const double share = 0.5 / cache->volume_count;
  for (unsigned v = 0; !result && v < cache->volume_count; v++) {
    const double begin = is_fine ? 0.5 + share * v : share * v;
    np_monitor_set_range(monitor, begin, begin + share);
    result = (is_fine ? refine_lattice : fill_lattice)(cache, world, v, desc, monitor);
  }
  if (!result) count_cell_kinds(cache);
  return result;
}

/* Places the lattices, coarser where memory is limited. */
static neph_result place_all(np_sun_optical_depth *out, const np_world *world, const np_sun_optical_depth_desc *desc) {
  unsigned count = world->clouds.count;
  if (world->clouds.places) {
    const neph_result result = np_sun_places_choose(world, out, &count);
    if (result) return result;
  }
  out->lattices = np_alloc(out->context, count, sizeof *out->lattices);
  if (!out->lattices) return NEPH_ERROR_OUT_OF_MEMORY;
  out->volume_count = count;
  const double coarsening = choose_coarsening(out, world, desc);
  for (unsigned v = 0; v < count; v++) place(get_volume(out, world, v), world->to_sun, coarsening, &out->lattices[v]);
  return NEPH_OK;
}

neph_result np_sun_optical_depth_build(neph_context *context, const np_world *world,
                                       const np_sun_optical_depth_desc *desc, np_monitor *monitor,
                                       np_sun_optical_depth *out) {
  *out = (np_sun_optical_depth){.context = context, .depth_end = 16.0f / desc->rate};
  neph_result result = place_all(out, world, desc);
  np_monitor_set_stage(monitor, "computing sun optical depth");
  if (!result) result = fill_lattices(out, world, desc, false, monitor);
  const size_t fine_bytes = np_sun_level_count_nodes(0) * sizeof(uint16_t);
  if (!result && out->steep_cells > 0 && out->bytes + out->steep_cells * fine_bytes <= desc->bytes_max)
    result = fill_lattices(out, world, desc, true, monitor);
  if (result)
    np_sun_optical_depth_clear(out);
  else
    report(out);
  return result;
}

void np_sun_optical_depth_clear(np_sun_optical_depth *cache) {
  for (unsigned v = 0; v < cache->volume_count; v++) {
    np_sun_lattice *l = &cache->lattices[v];
    const size_t columns = l->nodes && !l->all_nodes ? (size_t)l->size[0] * (size_t)l->size[1] : 0;
    for (size_t n = 0; n < columns; n++) np_alloc_free(cache->context, l->nodes[n]);
    np_alloc_free(cache->context, l->all_nodes);
    np_alloc_free(cache->context, l->nodes);
    np_alloc_free(cache->context, l->cells);
  }
  np_alloc_free(cache->context, cache->lattices);
  np_alloc_free(cache->context, cache->places);
  np_alloc_free(cache->context, cache->stands);
  *cache = (np_sun_optical_depth){0};
}

/* ---- Queries ---- */

/* Error of the transmittance that a span may make, by its range. */
static const float span_tolerance = 0.01f;

/* Number of look-ups of a span: one a voxel, or fewer where the range of the brick and the light that is left allow for
 * no error that matters. `rate`: optical depth of the scaled medium per value and metre. */
static int count_samples(const np_brick_span *span, float length, double step, float rate, float transmittance) {
  const float variation = rate * (span->range.max - span->range.min) * length * transmittance / span_tolerance;
  const int by_voxel = (int)fmin(fmax(ceil((double)length / step), 1.0), 64.0),
            by_range = np_track_count_samples(variation);
  return by_range < by_voxel ? by_range : by_voxel;
}

/* Optical depth of a span, per extinction of a value of 1; of nearest samples, exactly. */
static float compute_span_depth(const np_bricks *bricks, const np_brick_walk *walk, const np_brick_span *span,
                                int count) {
  const float length = (float)(span->t_end - span->t_begin);
  if (span->brick == NP_BRICK_NONE) return span->range.min * length;
  if (bricks->is_nearest) {
    const np_vec3 begin = np_brick_walk_local(walk, span, span->t_begin);
    const np_vec3 end = np_brick_walk_local(walk, span, span->t_end);
    return length * np_track_mean(bricks, span->brick, span->cell, begin, np_vec3_subtract(end, begin));
  }
  if (count == 0) return 0.5f * (span->range.min + span->range.max) * length;
  float sum = 0.0f;
  for (int k = 0; k < count; k++)
    sum += np_brick_sample(
        bricks, span->brick,
        np_brick_walk_local(walk, span, span->t_begin + (span->t_end - span->t_begin) * (k + 0.5) / count));
  return sum * (length / (float)count);
}

/* Adds to a depth that of one cloud, times `fade`. */
static float walk(const np_instance *volume, np_dvec3 position, np_vec3 to_sun, float fade, float depth,
                  float depth_end) {
  const np_dvec3 along = np_affine_vector(&volume->world_to_index, np_vec3_to_double(to_sun));
  const double step = 1.0 / fmax(np_dvec3_length(along), 1e-30);
  const float rate = fade * volume->extinction_per_value;
  np_brick_walk walk;
  np_brick_span span;
  np_brick_walk_start(&walk, volume->bricks, np_affine_point(&volume->world_to_index, position), along, 0.0, 1e7);
  while (depth < depth_end && np_brick_walk_next(&walk, &span)) {
    const float length = (float)(span.t_end - span.t_begin);
    const int count =
        span.brick == NP_BRICK_NONE ? 0 : count_samples(&span, length, step, rate, np_transmittance(depth));
    depth += rate * compute_span_depth(volume->bricks, &walk, &span, count);
  }
  return depth;
}

static float compute_depth(const np_sun_optical_depths *depths, np_dvec3 position, np_vec3 to_sun, const float *fade,
                           float depth_max) {
  float depth = 0.0f;
  np_place_walk places;
  const np_instance *volume;
  np_place_walk_start(&places, depths->clouds, position, to_sun, INFINITY);
  while (depth < depth_max && (volume = np_place_walk_next(&places, INFINITY))) {
    const float rate = fade ? fade[np_instances_get_index(depths->clouds, volume)] : 1.0f;
    const float own = np_sun_optical_depths_get_known(depths, volume, position, to_sun);
    depth = own == NP_SUN_OPTICAL_DEPTH_UNKNOWN ? walk(volume, position, to_sun, rate, depth, depth_max)
                                                : depth + rate * own;
  }
  return depth;
}

float np_sun_optical_depths_get(const np_sun_optical_depths *depths, np_dvec3 position, np_vec3 to_sun,
                                float depth_max) {
  return compute_depth(depths, position, to_sun, NULL, depth_max);
}

float np_sun_optical_depths_get_scaled(const np_sun_optical_depths *depths, np_dvec3 position, np_vec3 to_sun,
                                       const float fade[NP_INSTANCES_MAX], float depth_max) {
  return compute_depth(depths, position, to_sun, fade, depth_max);
}

static float get_from(const void *depths, np_dvec3 position, np_vec3 to_sun, const float *fade, float depth_max) {
  return compute_depth(depths, position, to_sun, fade, depth_max);
}

np_sun_optical_depth_source np_sun_optical_depths_get_source(const np_sun_optical_depths *depths) {
  return (np_sun_optical_depth_source){depths, get_from};
}

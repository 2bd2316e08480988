/* SPDX-License-Identifier: Apache-2.0 */
/* The sun optical-depth volume: optical depth of clouds between a point and the sun, computed once and looked up.
 *
 * Each cloud has a lattice of nodes whose third axis t runs away from the sun, so that a line of nodes is one ray
 * and is filled by one march. A cell has 8³ intervals of the lattice, and stores as many nodes as its tolerance
 * requires: 9³, 5³, 3³ or 2³, between which the depth is interpolated. Where it curves too much for that, as at a
 * dense edge that faces the sun, a second pass follows rays half a step apart, for 17³ nodes; a twelfth of their
 * second differences is taken off, so that between them the interpolant is right in the mean. Three kinds of cells
 * have no nodes:
 *
 *   empty   the depth does not change along t: it is read at the entry to the next cell towards the sun
 *   dark    light is negligible here
 *   steep   17³ nodes are too few, or did not fit the memory: rays march through it
 *
 * A ray that starts outside the cells runs to the first that is not empty, in its own direction; from there on the
 * middle of the sun's disk represents it. Rays march through periodic clouds, which have no lattice.
 *
 * A cloud in many places has one lattice for those that the sun shines on from the same side of the cloud, whatever
 * their size, and no more than NP_SUN_SIDES_MAX: places of the sides between take the nearest, by up to `side_rad`.
 *
 * Depends on the clouds, their places and the sun's direction; not on wavelength, nor on the camera: a sequence keeps
 * it (light_key.h).
 */
#ifndef NP_CACHES_SUN_OPTICAL_DEPTH_H
#define NP_CACHES_SUN_OPTICAL_DEPTH_H

#include <string.h>

#include "core/disk_cache.h"
#include "volume/places.h"
#include "world/world.h"

enum {
  NP_SUN_SIDES_MAX = 64,
  NP_SUN_CELL_EDGE = 8,
  NP_SUN_CELL_NODES = 9,     /* nodes along an edge */
  NP_SUN_FINE_EDGE = 16,     /* half steps along an edge */
  NP_SUN_FINE_RAYS = 19,     /* fine rays along an edge of a column, with one beyond it on each side */
  NP_SUN_CELL_LEVELS = 5,    /* levels: nodes half a step, one, two, four, eight steps apart */
  NP_SUN_CELL_LEVEL_BITS = 3 /* low bits of a cell with nodes: its level; the bits above: its first node */
};

/* Values of cells without nodes; all others are below these. */
#define NP_SUN_CELL_EMPTY 0xffffffffu
#define NP_SUN_CELL_DARK 0xfffffffeu
#define NP_SUN_CELL_STEEP 0xfffffffdu

static inline bool np_sun_cell_keeps(uint32_t cell) { return cell < NP_SUN_CELL_STEEP; }

static inline uint32_t np_sun_cell_get_level(uint32_t cell) { return cell & ((1u << NP_SUN_CELL_LEVEL_BITS) - 1); }

/* Depth of a query in cells without a stored depth, which rays march through. */
#define NP_SUN_OPTICAL_DEPTH_UNKNOWN (-1.0f)

typedef struct np_sun_lattice {
  np_affine world_to_lattice, lattice_to_world; /* maps between world and steps of the lattice */
  int32_t size[3];                              /* cells; 0: no lattice */
  double spacing_m;
  uint32_t *cells;     /* t fastest, then v */
  uint16_t **nodes;    /* halves of each column of cells along t: cell by cell, t fastest, then v */
  uint16_t *all_nodes; /* nodes of all columns of a lattice read from disk, in one block; else NULL */
} np_sun_lattice;

/* A place of a cloud, which uses the lattice of another place with the sun on the same side. */
typedef struct np_sun_place {
  uint32_t lattice;
  float scale;          /* factor from the lattice's optical depths to the place's */
  np_affine to_lattice; /* map from the world to the lattice's own place */
} np_sun_place;

typedef struct np_sun_optical_depth_desc {
  float rate;       /* least attenuation per unit of optical depth: the light is at most e^{−rate·depth} */
  float tolerance;  /* tolerance of e^{−x·depth}, for every x from `rate` to 1 */
  size_t bytes_max; /* memory limit, above which lattices are coarsened */
} np_sun_optical_depth_desc;

/* Error of 1 % of the light in full sun; a quarter of a gigabyte. */
#define NP_SUN_OPTICAL_DEPTH_DESC_DEFAULT                                                                              \
  { .rate = 1.0f, .tolerance = 0.015f, .bytes_max = (size_t)1 << 28 }

/* Error of e^{−depth}, in tolerances, above which a cell has no nodes. */
#define NP_SUN_STEEP_TOLERANCES 5.0f

typedef struct np_sun_optical_depth {
  neph_context *context; /* borrowed */
  unsigned volume_count;
  np_sun_lattice *lattices; /* lattices of each cloud; for clouds in many places, of each side on which the sun
                               shines */
  np_sun_place *places;     /* each place of a hierarchy; NULL: none */
  uint32_t *stands;         /* index of the place that each lattice was filled for; NULL without places */
  double side_rad;          /* greatest error in the sun's direction over a place */
  float depth_end;          /* depth that counts as dark: 16/rate */
  float error;              /* usual bound of the error of e^{−depth}; for the caller to set */
  size_t bytes;
  uint64_t level_cells[NP_SUN_CELL_LEVELS], steep_cells, dark_cells;
} np_sun_optical_depth;

/* Builds the cache. The same bits for any number of threads. On failure `*out` is empty. */
neph_result np_sun_optical_depth_build(neph_context *context, const np_world *world,
                                       const np_sun_optical_depth_desc *desc, np_monitor *monitor,
                                       np_sun_optical_depth *out);
void np_sun_optical_depth_clear(np_sun_optical_depth *cache);

/* Saves depths on disk. */
void np_sun_optical_depth_save(const np_sun_optical_depth *cache, np_cache_entry *entry);

/* Loads depths for the world's clouds; false, with `*out` empty, where the entry is too short. */
bool np_sun_optical_depth_load(neph_context *context, const np_world *world, np_cache_entry *entry,
                               np_sun_optical_depth *out);

/* Sun optical depths of all clouds, from the cache where it has them, otherwise marched in steps of a voxel. */
typedef struct np_sun_optical_depths {
  const np_instances *clouds;
  const np_sun_optical_depth *cache; /* NULL: none */
} np_sun_optical_depths;

/* Optical depth from a point; clouds beyond `depth_max` may be skipped. */
float np_sun_optical_depths_get(const np_sun_optical_depths *depths, np_dvec3 position, np_vec3 to_sun,
                                float depth_max);

/* Optical depth from a point, with each cloud's depth times `fade`. */
float np_sun_optical_depths_get_scaled(const np_sun_optical_depths *depths, np_dvec3 position, np_vec3 to_sun,
                                       const float fade[NP_INSTANCES_MAX], float depth_max);

/* Chooses the places whose lattices represent the others: sets `places`, `stands`, `side_rad`, and the number of
 * lattices. */
neph_result np_sun_places_choose(const np_world *world, np_sun_optical_depth *out, unsigned *out_count);

/* Function for lower modules that calls np_sun_optical_depths_get(); `depths` is borrowed. */
np_sun_optical_depth_source np_sun_optical_depths_get_source(const np_sun_optical_depths *depths);

/* ---- Inside: one column of cells ---- */

typedef struct np_sun_column {
  neph_context *context;
  const np_instance *volume;
  const np_sun_lattice *lattice;
  const np_sun_optical_depth_desc *desc;
  float depth_end;
  np_vec3 from_sun; /* direction of t */
  int32_t at[2];
  float *rays;       /* scratch: the 9 × 9 rays of the column, each with every node along t */
  uint32_t *cells;   /* output: cells of the column */
  size_t node_count; /* output: nodes that the cells store; for a refined cell, added to it */
} np_sun_column;

/* Number of nodes that a cell of a level stores. */
static inline size_t np_sun_level_count_nodes(uint32_t level) {
  const size_t edge = (size_t)(NP_SUN_FINE_EDGE >> level) + 1;
  return edge * edge * edge;
}

/* Length of a fine ray in `rays`, with one node beyond the last cell. */
static inline size_t np_sun_column_count_fine(const np_sun_column *column) {
  return (size_t)column->lattice->size[2] * NP_SUN_FINE_EDGE + 2;
}

/* The first node of a cell among the fine rays. */
static inline float *np_sun_column_get_fine(const np_sun_column *column, int32_t cell) {
  return column->rays + (NP_SUN_FINE_RAYS + 1) * np_sun_column_count_fine(column) + (size_t)cell * NP_SUN_FINE_EDGE;
}

/* ---- Look-up ---- */

/* Depth of a node, a finite half; subnormal ones, below 6.1e-5, may count as 0. Without branches, for levels without
 * F16C. */
static inline float np_sun_node_decode(uint16_t half) {
  const uint32_t bits = (uint32_t)(half & 0x8000u) << 16 | (uint32_t)(half & 0x7fffu) << 13;
  float shrunk;
  memcpy(&shrunk, &bits, sizeof shrunk);
  return shrunk * 0x1p112f;
}

static inline float np_sun_nodes_mix_pair(const uint16_t *nodes, float t) {
  return np_mixf(np_sun_node_decode(nodes[0]), np_sun_node_decode(nodes[1]), t);
}

static inline float np_sun_nodes_mix(const uint16_t *nodes, unsigned level, float u, float v, float t) {
  const int32_t last = NP_SUN_FINE_EDGE >> level, count = last + 1;
  const float scale = 2.0f / (float)(1u << level);
  const float place[3] = {u * scale, v * scale, t * scale};
  int32_t lower[3];
  float w[3];
  for (int a = 0; a < 3; a++) {
    const int32_t i = (int32_t)np_clampf(place[a], 0.0f, (float)last);
    lower[a] = i < last ? i : last - 1;
    w[a] = np_clampf(place[a] - (float)lower[a], 0.0f, 1.0f);
  }
  const uint16_t *n = nodes + (lower[0] * count + lower[1]) * count + lower[2];
  const uint16_t *m = n + count * count;
  const float a = np_mixf(np_sun_nodes_mix_pair(n, w[2]), np_sun_nodes_mix_pair(n + count, w[2]), w[1]);
  const float b = np_mixf(np_sun_nodes_mix_pair(m, w[2]), np_sun_nodes_mix_pair(m + count, w[2]), w[1]);
  return np_maxf(np_mixf(a, b, w[0]), 0.0f);
}

/* The cells along t, [*begin, *end), that a ray from p crosses within the sides of the lattice, and one more at either
 * end, which rounding may need; false: none. */
static inline bool np_sun_lattice_clip(const np_sun_lattice *l, np_dvec3 p, const double drift[2], int32_t *begin,
                                       int32_t *end) {
  const double from[2] = {p.x, p.y};
  double low = 0.0, high = (double)l->size[2] * NP_SUN_CELL_EDGE;
  for (int a = 0; a < 2; a++) {
    const double width = (double)l->size[a] * NP_SUN_CELL_EDGE;
    if (drift[a] == 0.0) {
      if (!(from[a] >= 0.0 && from[a] < width)) return false;
      continue;
    }
    const double inverse = 1.0 / drift[a], one = p.z - from[a] * inverse, other = one + width * inverse;
    const double first = one < other ? one : other, last = one < other ? other : one;
    low = first > low ? first : low;
    high = last < high ? last : high;
  }
  if (!(low <= high)) return false;
  *begin = (int32_t)(low * (1.0 / NP_SUN_CELL_EDGE)) - 1;
  *end = (int32_t)(high * (1.0 / NP_SUN_CELL_EDGE)) + 2;
  return true;
}

/* Depth of one cloud, or NP_SUN_OPTICAL_DEPTH_UNKNOWN. `to_sun` points to any place on the sun's disk. */
static inline float np_sun_lattice_get(const np_sun_lattice *l, float depth_end, np_dvec3 position, np_vec3 to_sun) {
  if (l->size[0] == 0) return NP_SUN_OPTICAL_DEPTH_UNKNOWN;
  const np_dvec3 p = np_affine_point(&l->world_to_lattice, position);
  const np_dvec3 d = np_affine_vector(&l->world_to_lattice, np_vec3_to_double(to_sun));
  if (!(p.z > 0.0) || !(d.z < 0.0)) return 0.0f;
  const double drift[2] = {d.x / d.z, d.y / d.z}, far = (double)l->size[2] * NP_SUN_CELL_EDGE;
  double t = p.z < far ? p.z : far;
  int32_t k = (int32_t)(t * (1.0 / NP_SUN_CELL_EDGE)), begin = 0, end = k + 1;
  bool is_clipped = false;
  for (; k >= begin; k--, t = (double)(k + 1) * NP_SUN_CELL_EDGE) {
    const double u = p.x + (t - p.z) * drift[0], v = p.y + (t - p.z) * drift[1];
    if (!(u >= 0.0 && v >= 0.0 && k < l->size[2] && u < (double)l->size[0] * NP_SUN_CELL_EDGE &&
          v < (double)l->size[1] * NP_SUN_CELL_EDGE)) {
      if (!is_clipped && !np_sun_lattice_clip(l, p, drift, &begin, &end)) return 0.0f;
      is_clipped = true;
      if (begin < 0) begin = 0;
      if (k > end) k = end;
      continue;
    }
    const int32_t i = (int32_t)(u * (1.0 / NP_SUN_CELL_EDGE)), j = (int32_t)(v * (1.0 / NP_SUN_CELL_EDGE));
    const size_t column = (size_t)i * (size_t)l->size[1] + (size_t)j;
    const uint32_t cell = l->cells[column * (size_t)l->size[2] + (size_t)k];
    if (cell == NP_SUN_CELL_EMPTY) continue;
    if (cell == NP_SUN_CELL_DARK) return depth_end;
    if (cell == NP_SUN_CELL_STEEP) return NP_SUN_OPTICAL_DEPTH_UNKNOWN;
    const uint16_t *nodes = l->nodes[column] + (cell >> NP_SUN_CELL_LEVEL_BITS);
    return np_sun_nodes_mix(nodes, np_sun_cell_get_level(cell), (float)(u - (double)i * NP_SUN_CELL_EDGE),
                            (float)(v - (double)j * NP_SUN_CELL_EDGE), (float)(t - (double)k * NP_SUN_CELL_EDGE));
  }
  return 0.0f;
}

/* Depth of one cloud at a place, whose lattice may belong to another. */
static inline float np_sun_place_get(const np_sun_optical_depth *cache, const np_sun_place *place, np_dvec3 position,
                                     np_vec3 to_sun) {
  const np_dvec3 along = np_affine_vector(&place->to_lattice, np_vec3_to_double(to_sun));
  const float depth = np_sun_lattice_get(&cache->lattices[place->lattice], cache->depth_end,
                                         np_affine_point(&place->to_lattice, position), np_dvec3_to_float(along));
  return depth == NP_SUN_OPTICAL_DEPTH_UNKNOWN ? depth : place->scale * depth;
}

/* Depth of one cloud in its place, where a cache has it; else NP_SUN_OPTICAL_DEPTH_UNKNOWN. */
static inline float np_sun_optical_depths_get_known(const np_sun_optical_depths *depths, const np_instance *volume,
                                                    np_dvec3 position, np_vec3 to_sun) {
  const np_sun_optical_depth *cache = depths->cache;
  if (!cache) return NP_SUN_OPTICAL_DEPTH_UNKNOWN;
  const size_t number = (size_t)(volume - np_instances_get_places(depths->clouds));
  if (cache->places) return np_sun_place_get(cache, &cache->places[number], position, to_sun);
  return np_sun_lattice_get(&cache->lattices[number], cache->depth_end, position, to_sun);
}

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Bricks: the form in which the renderer reads a volume.
 *
 * Sample i sits at integer index i. Brick b answers for index positions in [8b, 8b+8) and holds the window of 9³
 * samples that starts at 8b, so that a trilinear look-up touches one brick. Where that window is constant there is a
 * tile, no brick. Every cell of the table knows the minimum and maximum of the interpolant over it, and so do two
 * coarser levels of 4³ and 16³ cells, by which empty space is skipped and majorants are found.
 *
 * Look-ups and walks are inline, so that a kernel file takes them into its own instruction set.
 */
#ifndef NP_VOLUME_BRICKS_H
#define NP_VOLUME_BRICKS_H

#include <float.h>
#include <immintrin.h>
#include <string.h>

#include <nephos/volume.h>

#include "core/half.h"
#include "core/math.h"
#include "core/parallel.h"
#include "volume/brick_periods.h"
#include "volume/sparse_grid.h"

enum {
  NP_BRICK_EDGE = 8,
  NP_BRICK_SAMPLES = 9, /* along an edge */
  NP_BRICK_STRIDE_X =
      NP_BRICK_SAMPLES * NP_BRICK_SAMPLES, /* from one sample to the next along x; 9 along y, 1 along z */
  NP_BRICK_VOLUME = 729,                   /* 9³, z fastest */
  NP_BRICK_STRIDE = 736,                   /* from one brick to the next: 729 rounded up to 16 */
  NP_BRICK_LEVELS = 3,                     /* cells of 1, 4 and 16 bricks */
  NP_BRICK_LEVEL_SHIFT = 2                 /* a cell spans 2² cells of the level below, along each axis */
};

#define NP_BRICK_NONE 0xffffffffu

/* Bounds of the interpolant over one cell, in the file's unit, its rounding in float included. */
typedef struct np_brick_range {
  float min, max;
} np_brick_range;

typedef struct np_bricks {
  neph_context *context;            /* borrowed */
  int32_t origin[3];                /* brick coordinates of the table's first cell */
  int32_t size[NP_BRICK_LEVELS][3]; /* cells of each level */
  uint32_t *table;                  /* brick number of each cell of level 0, or NP_BRICK_NONE: then it is constant */
  np_brick_range *ranges[NP_BRICK_LEVELS]; /* of each cell, z fastest; a constant cell has min == max == its value */
  size_t brick_count;
  uint16_t *halves;                    /* samples divided by `scale`, when half */
  float *floats;                       /* samples, when float; exactly one of the two is not NULL */
  float scale;                         /* power of two that puts the largest magnitude in [1, 2); 1 when float */
  bool is_periodic[2];                 /* along x, y: then the table covers whole periods, and `origin` is 0 there */
  int32_t period[2];                   /* of the table in voxels, a multiple of 8, when periodic */
  int32_t reach_low[3], reach_high[3]; /* brick coordinates that rays walk through: the table, or all periods */
  float background;                    /* outside the table */
  float value_max;                     /* bound of the interpolant anywhere */
} np_bricks;

/* Builds bricks from a grid, in parallel. `period` NULL: not periodic; else voxels along x and y, multiples of 8, or 0
 * where not periodic: sample i is then the grid's sample i mod period, and the grid must lie in [0, period). */
neph_result np_bricks_build(neph_context *context, const np_sparse_grid *grid, neph_precision precision,
                            const int32_t period[2], np_monitor *monitor, np_bricks *out_bricks);
void np_bricks_clear(np_bricks *bricks);
size_t np_bricks_get_bytes(const np_bricks *bricks);
size_t np_bricks_count_cells(const np_bricks *bricks, int level);

/* Fills the ranges of the coarser levels, and value_max, from those of level 0. */
void np_bricks_build_coarse_ranges(np_bricks *bricks);

/* ------------------------------------------------------------------------------------------------- one sample */

/* The eight samples around a position, as four pairs along z, each in the lower two lanes. The upper lanes hold what
 * lies next in the brick, for which its stride leaves room: loading four and ignoring two spares all shuffling. */
typedef struct np_brick_corners {
  __m128 pair[2][2]; /* by x and y */
} np_brick_corners;

enum { NP_BRICK_X = NP_BRICK_STRIDE_X, NP_BRICK_Y = NP_BRICK_SAMPLES };

static inline np_brick_corners np_brick_load_floats(const float *sample) {
  return (np_brick_corners){{{_mm_loadu_ps(sample), _mm_loadu_ps(sample + NP_BRICK_Y)},
                             {_mm_loadu_ps(sample + NP_BRICK_X), _mm_loadu_ps(sample + NP_BRICK_X + NP_BRICK_Y)}}};
}

static inline __m128i np_brick_load_quad(const uint16_t *sample) {
  return _mm_loadl_epi64((const __m128i *)(const void *)sample);
}

#if !defined(__F16C__)
/* Four finite halves, each in the lower bits of a lane, by integer arithmetic. A subnormal half becomes the mantissa of
 * a float of 2⁻¹⁴, which is then taken off again, so that no float is ever subnormal. */
static inline __m128 np_brick_decode_halves(__m128i halves) {
  __m128i magnitude = _mm_and_si128(halves, _mm_set1_epi32(0x7fff)), mantissa = _mm_slli_epi32(magnitude, 13);
  __m128i sign = _mm_slli_epi32(_mm_xor_si128(halves, magnitude), 16);
  __m128i is_subnormal = _mm_cmplt_epi32(magnitude, _mm_set1_epi32(0x400));
  __m128i normal = _mm_add_epi32(mantissa, _mm_set1_epi32((127 - 15) << 23));
  __m128 shifted = _mm_castsi128_ps(_mm_add_epi32(mantissa, _mm_set1_epi32((127 - 14) << 23)));
  __m128i subnormal = _mm_castps_si128(_mm_sub_ps(shifted, _mm_set1_ps(0x1p-14f)));
  __m128i chosen = _mm_or_si128(_mm_and_si128(is_subnormal, subnormal), _mm_andnot_si128(is_subnormal, normal));
  return _mm_castsi128_ps(_mm_or_si128(chosen, sign));
}
#endif

static inline np_brick_corners np_brick_load_halves(const uint16_t *sample) {
  __m128i low_0 = np_brick_load_quad(sample), low_1 = np_brick_load_quad(sample + NP_BRICK_Y);
  __m128i high_0 = np_brick_load_quad(sample + NP_BRICK_X);
  __m128i high_1 = np_brick_load_quad(sample + NP_BRICK_X + NP_BRICK_Y);
#if defined(__F16C__)
  return (np_brick_corners){{{_mm_cvtph_ps(low_0), _mm_cvtph_ps(low_1)}, {_mm_cvtph_ps(high_0), _mm_cvtph_ps(high_1)}}};
#else
  __m128i zero = _mm_setzero_si128();
  __m128 low = np_brick_decode_halves(_mm_unpacklo_epi16(_mm_unpacklo_epi32(low_0, low_1), zero));
  __m128 high = np_brick_decode_halves(_mm_unpacklo_epi16(_mm_unpacklo_epi32(high_0, high_1), zero));
  return (np_brick_corners){{{low, _mm_movehl_ps(low, low)}, {high, _mm_movehl_ps(high, high)}}};
#endif
}

static inline __m128 np_brick_mix(__m128 a, __m128 b, __m128 t) {
  return _mm_add_ps(a, _mm_mul_ps(t, _mm_sub_ps(b, a)));
}

/* Value inside a known brick; `local` in [0, 8]³ from the brick's first sample, and clamped to it. NaN becomes 0. */
static inline float np_brick_sample(const np_bricks *bricks, uint32_t brick, np_vec3 local) {
  __m128 place = _mm_setr_ps(local.x, local.y, local.z, 0.0f);
  place = _mm_min_ps(_mm_max_ps(place, _mm_setzero_ps()), _mm_set1_ps((float)NP_BRICK_EDGE));
  __m128i lower = _mm_cvttps_epi32(_mm_min_ps(place, _mm_set1_ps((float)(NP_BRICK_EDGE - 1))));
  __m128 fraction = _mm_sub_ps(place, _mm_cvtepi32_ps(lower));
  __m128i strided = _mm_madd_epi16(lower, _mm_setr_epi32(NP_BRICK_STRIDE_X, NP_BRICK_SAMPLES, 1, 0));
  strided = _mm_add_epi32(strided, _mm_unpackhi_epi64(strided, strided));
  uint32_t offset = (uint32_t)_mm_cvtsi128_si32(_mm_add_epi32(strided, _mm_shuffle_epi32(strided, 1)));
  size_t first = (size_t)brick * NP_BRICK_STRIDE + offset;
  np_brick_corners corners =
      bricks->halves ? np_brick_load_halves(bricks->halves + first) : np_brick_load_floats(bricks->floats + first);
  __m128 x = _mm_shuffle_ps(fraction, fraction, 0x00), y = _mm_shuffle_ps(fraction, fraction, 0x55);
  __m128 z = _mm_movehl_ps(fraction, fraction);
  __m128 y_0 = np_brick_mix(corners.pair[0][0], corners.pair[1][0], x);
  __m128 y_1 = np_brick_mix(corners.pair[0][1], corners.pair[1][1], x);
  __m128 z_0 = np_brick_mix(y_0, y_1, y), z_1 = _mm_shuffle_ps(z_0, z_0, 0x55);
  return bricks->scale * _mm_cvtss_f32(np_brick_mix(z_0, z_1, z));
}

#if defined(__AVX2__)
/* Pairs along z of four places, offsets from the brick's first sample. */
static inline __m256 np_brick_load_pairs(const np_bricks *bricks, size_t first, const uint32_t offset[4]) {
  if (bricks->halves) {
    const uint16_t *halves = bricks->halves + first;
    int32_t pair[4];
    for (int k = 0; k < 4; k++) memcpy(&pair[k], halves + offset[k], sizeof pair[k]);
    return _mm256_cvtph_ps(_mm_setr_epi32(pair[0], pair[1], pair[2], pair[3]));
  }
  const float *floats = bricks->floats + first;
  double pair[4];
  for (int k = 0; k < 4; k++) memcpy(&pair[k], floats + offset[k], sizeof pair[k]);
  return _mm256_castpd_ps(_mm256_setr_pd(pair[0], pair[1], pair[2], pair[3]));
}

static inline __m256 np_brick_mix_pairs(__m256 a, __m256 b, __m256 t) {
  return _mm256_add_ps(a, _mm256_mul_ps(t, _mm256_sub_ps(b, a)));
}

/* Clamps four coordinates to the brick and splits them. */
static inline __m128i np_brick_split(__m128 place, __m128 *out_fraction) {
  place = _mm_min_ps(_mm_max_ps(place, _mm_setzero_ps()), _mm_set1_ps((float)NP_BRICK_EDGE));
  __m128i lower = _mm_cvttps_epi32(_mm_min_ps(place, _mm_set1_ps((float)(NP_BRICK_EDGE - 1))));
  *out_fraction = _mm_sub_ps(place, _mm_cvtepi32_ps(lower));
  return lower;
}

/* np_brick_sample() of four places, to the bit, in about the time of two. */
static inline __m128 np_brick_sample_four(const np_bricks *bricks, uint32_t brick, __m128 x, __m128 y, __m128 z) {
  __m128i lower_x = np_brick_split(x, &x), lower_y = np_brick_split(y, &y), lower_z = np_brick_split(z, &z);
  __m128i strided = _mm_madd_epi16(_mm_or_si128(lower_x, _mm_slli_epi32(lower_y, 16)),
                                   _mm_set1_epi32(NP_BRICK_STRIDE_X | NP_BRICK_SAMPLES << 16));
  uint32_t offset[4];
  _mm_storeu_si128((__m128i *)(void *)offset, _mm_add_epi32(strided, lower_z));
  const size_t first = (size_t)brick * NP_BRICK_STRIDE;
  const __m256i twice = _mm256_setr_epi32(0, 0, 1, 1, 2, 2, 3, 3);
  const __m256 x_twice = _mm256_permutevar8x32_ps(_mm256_castps128_ps256(x), twice);
  const __m256 y_twice = _mm256_permutevar8x32_ps(_mm256_castps128_ps256(y), twice);
  const __m256 y_0 = np_brick_mix_pairs(np_brick_load_pairs(bricks, first, offset),
                                        np_brick_load_pairs(bricks, first + NP_BRICK_X, offset), x_twice);
  const __m256 y_1 = np_brick_mix_pairs(np_brick_load_pairs(bricks, first + NP_BRICK_Y, offset),
                                        np_brick_load_pairs(bricks, first + NP_BRICK_X + NP_BRICK_Y, offset), x_twice);
  const __m256 pairs = np_brick_mix_pairs(y_0, y_1, y_twice);
  const __m128 low = _mm256_castps256_ps128(pairs), high = _mm256_extractf128_ps(pairs, 1);
  const __m128 z_0 = _mm_shuffle_ps(low, high, 0x88), z_1 = _mm_shuffle_ps(low, high, 0xdd);
  return _mm_mul_ps(_mm_set1_ps(bricks->scale), np_brick_mix(z_0, z_1, z));
}
#endif

#if defined(__AVX512F__) && defined(__AVX512VL__)
/* The same of eight places. */
static inline __m512 np_brick_gather_pairs(const np_bricks *bricks, size_t first, __m256i offset) {
  if (bricks->halves) return _mm512_cvtph_ps(_mm256_i32gather_epi32((const void *)(bricks->halves + first), offset, 2));
  return _mm512_castpd_ps(_mm512_i32gather_pd(offset, bricks->floats + first, 4));
}

static inline __m512 np_brick_mix_many_pairs(__m512 a, __m512 b, __m512 t) {
  return _mm512_add_ps(a, _mm512_mul_ps(t, _mm512_sub_ps(b, a)));
}

static inline __m256i np_brick_split_eight(__m256 place, __m256 *out_fraction) {
  place = _mm256_min_ps(_mm256_max_ps(place, _mm256_setzero_ps()), _mm256_set1_ps((float)NP_BRICK_EDGE));
  __m256i lower = _mm256_cvttps_epi32(_mm256_min_ps(place, _mm256_set1_ps((float)(NP_BRICK_EDGE - 1))));
  *out_fraction = _mm256_sub_ps(place, _mm256_cvtepi32_ps(lower));
  return lower;
}

static inline __m256 np_brick_sample_eight(const np_bricks *bricks, uint32_t brick, __m256 x, __m256 y, __m256 z) {
  __m256i lower_x = np_brick_split_eight(x, &x), lower_y = np_brick_split_eight(y, &y);
  __m256i lower_z = np_brick_split_eight(z, &z);
  __m256i strided = _mm256_madd_epi16(_mm256_or_si256(lower_x, _mm256_slli_epi32(lower_y, 16)),
                                      _mm256_set1_epi32(NP_BRICK_STRIDE_X | NP_BRICK_SAMPLES << 16));
  const __m256i offset = _mm256_add_epi32(strided, lower_z);
  const size_t first = (size_t)brick * NP_BRICK_STRIDE;
  const __m512i twice = _mm512_setr_epi32(0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7);
  const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 1, 3, 5, 7, 9, 11, 13, 15);
  const __m512 x_twice = _mm512_permutexvar_ps(twice, _mm512_castps256_ps512(x));
  const __m512 y_twice = _mm512_permutexvar_ps(twice, _mm512_castps256_ps512(y));
  const __m512 y_0 = np_brick_mix_many_pairs(np_brick_gather_pairs(bricks, first, offset),
                                             np_brick_gather_pairs(bricks, first + NP_BRICK_X, offset), x_twice);
  const __m512 y_1 =
      np_brick_mix_many_pairs(np_brick_gather_pairs(bricks, first + NP_BRICK_Y, offset),
                              np_brick_gather_pairs(bricks, first + NP_BRICK_X + NP_BRICK_Y, offset), x_twice);
  const __m512 parted = _mm512_permutexvar_ps(even, np_brick_mix_many_pairs(y_0, y_1, y_twice));
  const __m256 z_0 = _mm512_castps512_ps256(parted);
  const __m256 z_1 = _mm256_castpd_ps(_mm512_extractf64x4_pd(_mm512_castps_pd(parted), 1));
  return _mm256_mul_ps(_mm256_set1_ps(bricks->scale), np_brick_mix_pairs(z_0, z_1, z));
}
#endif

enum { NP_BRICK_LINE = 16 }; /* places that are looked up together */

/* Values at begin + at[k]·along inside a known brick: `count` of them, at most NP_BRICK_LINE. Up to seven more places
 * are looked at and written to: both arrays have NP_BRICK_LINE. */
static inline void np_brick_sample_along(const np_bricks *bricks, uint32_t brick, np_vec3 begin, np_vec3 along,
                                         const float at[NP_BRICK_LINE], int count, float out[NP_BRICK_LINE]) {
#if defined(__AVX512F__) && defined(__AVX512VL__)
  for (int first = 0; first < count; first += 8) {
    const __m256 k = _mm256_loadu_ps(at + first);
    const __m256 x = _mm256_add_ps(_mm256_set1_ps(begin.x), _mm256_mul_ps(k, _mm256_set1_ps(along.x)));
    const __m256 y = _mm256_add_ps(_mm256_set1_ps(begin.y), _mm256_mul_ps(k, _mm256_set1_ps(along.y)));
    const __m256 z = _mm256_add_ps(_mm256_set1_ps(begin.z), _mm256_mul_ps(k, _mm256_set1_ps(along.z)));
    _mm256_storeu_ps(out + first, np_brick_sample_eight(bricks, brick, x, y, z));
  }
#elif defined(__AVX2__)
  for (int first = 0; first < count; first += 4) {
    const __m128 k = _mm_loadu_ps(at + first);
    const __m128 x = _mm_add_ps(_mm_set1_ps(begin.x), _mm_mul_ps(k, _mm_set1_ps(along.x)));
    const __m128 y = _mm_add_ps(_mm_set1_ps(begin.y), _mm_mul_ps(k, _mm_set1_ps(along.y)));
    const __m128 z = _mm_add_ps(_mm_set1_ps(begin.z), _mm_mul_ps(k, _mm_set1_ps(along.z)));
    _mm_storeu_ps(out + first, np_brick_sample_four(bricks, brick, x, y, z));
  }
#else
  for (int k = 0; k < count; k++)
    out[k] = np_brick_sample(bricks, brick, np_vec3_add(begin, np_vec3_scale(along, at[k])));
#endif
}

/* Values at begin, begin + step, and so on. */
static inline void np_brick_sample_line(const np_bricks *bricks, uint32_t brick, np_vec3 begin, np_vec3 step, int count,
                                        float out[NP_BRICK_LINE]) {
  static const float steps[NP_BRICK_LINE] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  np_brick_sample_along(bricks, brick, begin, step, steps, count, out);
}

/* Floor of a number below 2⁶² in magnitude; libm's is a call below x86-64-v3. */
static inline double np_brick_floor(double x) {
  double whole = (double)(int64_t)x;
  return whole > x ? whole - 1.0 : whole;
}

/* Position of a cell of a level in that level's arrays. */
static inline size_t np_bricks_get_offset(const np_bricks *bricks, int level, const int32_t cell[3]) {
  const int32_t *size = bricks->size[level];
  return ((size_t)cell[0] * (size_t)size[1] + (size_t)cell[1]) * (size_t)size[2] + (size_t)cell[2];
}

/* Splits an index position into a cell of the table and the place in it. False outside the table, and for NaN. */
static inline bool np_bricks_locate(const np_bricks *bricks, np_dvec3 index_position, int32_t out_cell[3],
                                    np_vec3 *out_local) {
  const double position[3] = {index_position.x, index_position.y, index_position.z};
  float local[3];
  for (int a = 0; a < 3; a++) {
    double x = position[a] - (double)bricks->origin[a] * NP_BRICK_EDGE,
           extent = (double)bricks->size[0][a] * NP_BRICK_EDGE;
    if (a < 2 && bricks->is_periodic[a]) x = np_brick_wrap_position(x, extent);
    if (!(x >= 0.0 && x < extent)) return false;
    out_cell[a] = (int32_t)x / NP_BRICK_EDGE;
    local[a] = (float)(x - (double)out_cell[a] * NP_BRICK_EDGE);
  }
  *out_local = np_vec3_make(local[0], local[1], local[2]);
  return true;
}

/* Value at an index position: the trilinear interpolant of the samples, the background outside the table. */
static inline float np_bricks_sample(const np_bricks *bricks, np_dvec3 index_position) {
  int32_t cell[3];
  np_vec3 local;
  if (!np_bricks_locate(bricks, index_position, cell, &local)) return bricks->background;
  size_t offset = np_bricks_get_offset(bricks, 0, cell);
  uint32_t brick = bricks->table[offset];
  return brick == NP_BRICK_NONE ? bricks->ranges[0][offset].min : np_brick_sample(bricks, brick, local);
}

/* --------------------------------------------------------------------------------------------- along a ray */

/* The part of a ray inside one cell. */
typedef struct np_brick_span {
  double t_begin, t_end; /* half-open, t_begin < t_end */
  uint32_t brick;        /* or NP_BRICK_NONE: constant `range.min` */
  int32_t cell[3];       /* brick coordinates: index positions 8·cell to 8·cell + 8; not wrapped when periodic */
  np_brick_range range;
} np_brick_span;

/* A walk along a ray through the cells of the table in order, leaving out those whose range is [0, 0].
 *
 * Amanatides and Woo 1987 on three levels, but nothing is accumulated: the plane at which a cell is left is computed
 * from the ray each time, so that spans join exactly. No coordinate ever steps back, which bounds the walk by the
 * cells. */
typedef struct np_brick_walk {
  const np_bricks *bricks;
  double origin[3], direction[3], inverse[3]; /* inverse 0: the ray does not move along that axis */
  double t, t_end;
  int32_t cell[3];         /* the next to visit, in brick coordinates, not wrapped */
  int32_t low[3], high[3]; /* cells that exist */
} np_brick_walk;

/* Cell of an index coordinate, held inside [low, high]. */
static inline int32_t np_brick_walk_cell(double coordinate, int32_t low, int32_t high) {
  double cell = coordinate * (1.0 / NP_BRICK_EDGE);
  if (!(cell > (double)low)) return low;
  return cell >= (double)high ? high : (int32_t)np_brick_floor(cell);
}

/* Starts a walk over [t_begin, t_end), where index_position(t) = origin + t·direction. The direction may have any
 * length and zeros; whatever is not a number makes the walk empty. */
static inline void np_brick_walk_start(np_brick_walk *walk, const np_bricks *bricks, np_dvec3 origin,
                                       np_dvec3 direction, double t_begin, double t_end) {
  *walk = (np_brick_walk){.bricks = bricks,
                          .origin = {origin.x, origin.y, origin.z},
                          .direction = {direction.x, direction.y, direction.z},
                          .t = t_begin,
                          .t_end = t_end};
  bool is_hit = true;
  for (int a = 0; a < 3; a++) {
    walk->low[a] = bricks->reach_low[a];
    walk->high[a] = bricks->reach_high[a];
    double low = (double)walk->low[a] * NP_BRICK_EDGE, high = (double)walk->high[a] * NP_BRICK_EDGE;
    double o = walk->origin[a], inverse = 1.0 / walk->direction[a];
    if (fabs(inverse) <= DBL_MAX) {
      walk->inverse[a] = inverse;
      double t_low = (low - o) * inverse, t_high = (high - o) * inverse;
      double enter = t_low < t_high ? t_low : t_high, leave = t_low < t_high ? t_high : t_low;
      walk->t = enter > walk->t ? enter : walk->t;
      walk->t_end = leave < walk->t_end ? leave : walk->t_end;
      is_hit = is_hit && enter <= leave; /* false for NaN */
    } else {
      is_hit = is_hit && walk->direction[a] == walk->direction[a] && o >= low && o < high;
      walk->direction[a] = 0.0;
    }
  }
  is_hit = is_hit && walk->t < walk->t_end;
  if (!is_hit) walk->t = walk->t_end = 0.0;
  for (int a = 0; a < 3 && is_hit; a++) {
    double moved = walk->inverse[a] == 0.0 ? 0.0 : walk->t * walk->direction[a];
    walk->cell[a] = np_brick_walk_cell(walk->origin[a] + moved, walk->low[a], walk->high[a] - 1);
  }
}

/* The largest block of cells around the walk's cell that is of one kind: one cell that holds something, or a block of a
 * coarser level that holds nothing. */
typedef struct np_brick_block {
  int32_t low[3], high[3]; /* in brick coordinates, not wrapped; high is outside */
  np_brick_range range;
  uint32_t brick;
  bool is_empty;
} np_brick_block;

static inline bool np_brick_range_is_zero(np_brick_range range) { return range.min == 0.0f && range.max == 0.0f; }

static inline void np_brick_walk_get_block(const np_brick_walk *walk, np_brick_block *out_block) {
  const np_bricks *bricks = walk->bricks;
  int32_t inside[3], cell[3];
  for (int a = 0; a < 3; a++) {
    inside[a] = walk->cell[a] - bricks->origin[a];
    if (a < 2 && bricks->is_periodic[a]) inside[a] = np_brick_wrap(inside[a], bricks->size[0][a]);
  }
  size_t offset = np_bricks_get_offset(bricks, 0, inside);
  out_block->range = bricks->ranges[0][offset];
  out_block->brick = bricks->table[offset];
  out_block->is_empty = np_brick_range_is_zero(out_block->range);
  if (!out_block->is_empty) {
    for (int a = 0; a < 3; a++) out_block->high[a] = (out_block->low[a] = walk->cell[a]) + 1;
    return;
  }
  int level = 0;
  while (level + 1 < NP_BRICK_LEVELS) {
    int shift = (level + 1) * NP_BRICK_LEVEL_SHIFT;
    for (int a = 0; a < 3; a++) cell[a] = inside[a] >> shift;
    if (!np_brick_range_is_zero(bricks->ranges[level + 1][np_bricks_get_offset(bricks, level + 1, cell)])) break;
    level++;
  }
  for (int a = 0; a < 3; a++) {
    int32_t low = inside[a] >> level * NP_BRICK_LEVEL_SHIFT << level * NP_BRICK_LEVEL_SHIFT;
    int32_t high = low + (1 << level * NP_BRICK_LEVEL_SHIFT);
    high = high < bricks->size[0][a] ? high : bricks->size[0][a];
    out_block->low[a] = walk->cell[a] - inside[a] + low;
    out_block->high[a] = walk->cell[a] - inside[a] + high;
  }
}

/* Moves the walk to where it leaves an empty block. */
static inline void np_brick_walk_leave(np_brick_walk *walk, const np_brick_block *block) {
  double t_exit = walk->t_end;
  int axis = -1;
  for (int a = 0; a < 3; a++) {
    if (walk->inverse[a] == 0.0) continue;
    int32_t plane = walk->inverse[a] > 0.0 ? block->high[a] : block->low[a];
    double t = ((double)plane * NP_BRICK_EDGE - walk->origin[a]) * walk->inverse[a];
    if (t < t_exit) {
      t_exit = t;
      axis = a;
    }
  }
  walk->t = t_exit > walk->t ? t_exit : walk->t;
  if (axis < 0) {
    walk->t = walk->t_end;
    return;
  }
  for (int a = 0; a < 3; a++) {
    bool is_forward = walk->inverse[a] > 0.0;
    if (a == axis) {
      walk->cell[a] = is_forward ? block->high[a] : block->low[a] - 1;
      if (walk->cell[a] < walk->low[a] || walk->cell[a] >= walk->high[a]) walk->t = walk->t_end;
    } else if (walk->inverse[a] != 0.0) {
      int32_t low = is_forward ? walk->cell[a] : block->low[a], high = is_forward ? block->high[a] - 1 : walk->cell[a];
      walk->cell[a] = np_brick_walk_cell(walk->origin[a] + walk->t * walk->direction[a], low, high);
    }
  }
}

/* Distance at which the ray meets a plane of the cells across an axis; infinite, if it does not move along that. */
static inline double np_brick_walk_meet(const np_brick_walk *walk, int axis, int32_t plane) {
  double t = ((double)plane * NP_BRICK_EDGE - walk->origin[axis]) * walk->inverse[axis];
  return walk->inverse[axis] != 0.0 ? t : HUGE_VAL;
}

/* The same as np_brick_walk_leave() for a block of one cell, without branches that cannot be foreseen. */
static inline void np_brick_walk_leave_cell(np_brick_walk *walk) {
  double t[3];
  for (int a = 0; a < 3; a++) t[a] = np_brick_walk_meet(walk, a, walk->cell[a] + (walk->inverse[a] > 0.0));
  int axis = t[1] < t[0];
  axis = t[2] < t[axis] ? 2 : axis;
  double t_exit = t[axis];
  bool is_end = !(t_exit < walk->t_end);
  t_exit = is_end ? walk->t_end : t_exit;
  walk->t = t_exit > walk->t ? t_exit : walk->t;
  walk->cell[axis] += walk->inverse[axis] > 0.0 ? 1 : -1;
  if (is_end || walk->cell[axis] < walk->low[axis] || walk->cell[axis] >= walk->high[axis]) walk->t = walk->t_end;
}

/* The next span that is not empty; false at the end. */
static inline bool np_brick_walk_next(np_brick_walk *walk, np_brick_span *out_span) {
  while (walk->t < walk->t_end) {
    np_brick_block block;
    np_brick_walk_get_block(walk, &block);
    double t_begin = walk->t;
    for (int a = 0; a < 3; a++) out_span->cell[a] = walk->cell[a];
    if (block.is_empty) {
      np_brick_walk_leave(walk, &block);
      continue;
    }
    np_brick_walk_leave_cell(walk);
    if (!(t_begin < walk->t)) continue;
    out_span->t_begin = t_begin;
    out_span->t_end = walk->t;
    out_span->brick = block.brick;
    out_span->range = block.range;
    return true;
  }
  return false;
}

/* Place of the ray at `t` in the span's cell, in [0, 8]³ but for rounding. In double until the cell is subtracted, so
 * that nothing is lost far from index 0. */
static inline np_vec3 np_brick_walk_local(const np_brick_walk *walk, const np_brick_span *span, double t) {
  float local[3];
  for (int a = 0; a < 3; a++)
    local[a] = (float)(walk->origin[a] - (double)span->cell[a] * NP_BRICK_EDGE + t * walk->direction[a]);
  return np_vec3_make(local[0], local[1], local[2]);
}

#endif

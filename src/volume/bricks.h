/* SPDX-License-Identifier: Apache-2.0 */
/* Bricks: the form in which the renderer reads a volume.
 *
 * Sample i sits at integer index i. Brick b answers for index positions in [8b, 8b+8) and holds the window of 9³
 * samples that starts at 8b, so that a trilinear look-up touches one brick. Where that window is constant there is a
 * tile, no brick. Every cell knows the minimum and maximum of the interpolant over it, and so do two coarser levels of
 * 4³ and 16³ cells, by which empty space is skipped and majorants are found. Cells are in nodes of 16³, which are those
 * of OpenVDB's leaves; a node that is constant is an entry of the table and no more, and those that look alike beside
 * large tiles are one. So memory goes with what a grid holds, however large its box.
 *
 * Look-ups are inline, so that a kernel file takes them into its own instruction set.
 */
#ifndef NP_VOLUME_BRICKS_H
#define NP_VOLUME_BRICKS_H

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
  NP_BRICK_LEVEL_SHIFT = 2,                /* a cell spans 2² cells of the level below, along each axis */
  NP_BRICK_NODE_SHIFT = 4,
  NP_BRICK_NODE_EDGE = 16,    /* cells along an edge of a node */
  NP_BRICK_NODE_CELLS = 4096, /* 16³, z fastest */
  NP_BRICK_NODE_GROUPS = 64   /* of 4³ cells, z fastest */
};

#define NP_BRICK_NONE 0xffffffffu

/* Bounds of the interpolant over one cell, in the file's unit, its rounding in float included. */
typedef struct np_brick_range {
  float min, max;
} np_brick_range;

static inline bool np_brick_range_is_zero(np_brick_range range) { return range.min == 0.0f && range.max == 0.0f; }

/* The cells of a node that is not constant. */
typedef struct np_brick_node {
  uint32_t brick[NP_BRICK_NODE_CELLS];       /* number of each cell's brick, or NP_BRICK_NONE: then it is constant */
  np_brick_range range[NP_BRICK_NODE_CELLS]; /* a constant cell has min == max == its value */
  np_brick_range group_range[NP_BRICK_NODE_GROUPS]; /* of groups of cells */
  np_brick_range whole_range;
} np_brick_node;

/* Velocities at the samples of bricks whose matter moves: a value is looked up where its matter is at time 0. */
typedef struct np_brick_motion {
  const struct np_bricks *rest; /* at time 0 */
  const uint16_t *velocity;     /* of each brick along x, y and z, one after the other, in `scale` voxels a second */
  const int32_t (*cells)[3];    /* of each brick, in brick coordinates */
  float scale;
  float time_s;
} np_brick_motion;

typedef struct np_bricks {
  neph_context *context;        /* borrowed */
  int32_t origin[3], size[3];   /* brick coordinates of the first cell, and cells that there are */
  int32_t lead[3];              /* cells that the first node has before that */
  int32_t table_size[3];        /* nodes that the cells lie in */
  uint32_t *table;              /* of each, z fastest: its number among `nodes`, or NP_BRICK_NONE: it is constant */
  np_brick_range *table_ranges; /* of each that is constant */
  size_t node_count;
  np_brick_node *nodes;
  size_t brick_count;
  uint16_t *halves;                     /* samples divided by `scale`, when half */
  float *floats;                        /* samples, when float */
  const np_brick_motion *motion;        /* when they move; exactly one of the three is not NULL */
  const struct np_brick_detail *detail; /* finer than the samples (volume/brick_detail.h); NULL: none */
  bool is_indirect;                     /* they move or have detail: a look-up is more than its samples */
  float scale;                          /* power of two that puts the largest magnitude in [1, 2); 1 when float */
  bool is_periodic[2];                  /* along x, y: then the table covers whole periods, and `origin` is 0 there */
  int32_t period[2];                    /* of the table in voxels, a multiple of 8, when periodic */
  int32_t reach_low[3], reach_high[3];  /* brick coordinates that rays walk through: the table, or all periods */
  float background;                     /* outside the table */
  float value_max;                      /* bound of the interpolant anywhere */
} np_bricks;

/* Builds bricks from a grid, in parallel. `period` NULL: not periodic; else voxels along x and y, multiples of 8, or 0
 * where not periodic: sample i is then the grid's sample i mod period, and the grid must lie in [0, period). */
neph_result np_bricks_build(neph_context *context, const np_sparse_grid *grid, neph_precision precision,
                            const int32_t period[2], np_monitor *monitor, np_bricks *out_bricks);
void np_bricks_clear(np_bricks *bricks);
size_t np_bricks_get_bytes(const np_bricks *bricks);
size_t np_bricks_count_table(const np_bricks *bricks);

/* Voxels that count as one along each axis where light is followed, a power of two: light does not see them where
 * hardly any of the box has bricks, as in a large tile or around a stray voxel, beyond 512 of them in its longest side.
 * Layers, which repeat, are resolved to their voxels. */
double np_bricks_count_joined(const np_bricks *bricks);

/* Lists the cells in which the interpolant is not 0, in brick coordinates; `out` NULL: counts them alone. */
size_t np_bricks_list_cells(const np_bricks *bricks, int32_t (*out)[3]);

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

/* Eight corners, mixed by the fraction of the way from the first to the last. */
static inline float np_brick_mix_corners(const np_brick_corners *corners, __m128 fraction) {
  __m128 x = _mm_shuffle_ps(fraction, fraction, 0x00), y = _mm_shuffle_ps(fraction, fraction, 0x55);
  __m128 z = _mm_movehl_ps(fraction, fraction);
  __m128 y_0 = np_brick_mix(corners->pair[0][0], corners->pair[1][0], x);
  __m128 y_1 = np_brick_mix(corners->pair[0][1], corners->pair[1][1], x);
  __m128 z_0 = np_brick_mix(y_0, y_1, y), z_1 = _mm_shuffle_ps(z_0, z_0, 0x55);
  return _mm_cvtss_f32(np_brick_mix(z_0, z_1, z));
}

/* Functions for bricks that move or have detail, which are rare, are out of line: others pay nothing for them. */
#if defined(__GNUC__)
#define NP_BRICK_RARE __attribute__((noinline, unused))
#else
#define NP_BRICK_RARE
#endif

enum { NP_BRICK_LINE = 16 }; /* places that are looked up together */

/* A brick in its cell, in brick coordinates, not wrapped when periodic. */
typedef struct np_brick_ref {
  const np_bricks *bricks;
  uint32_t brick;
  const int32_t *cell;
} np_brick_ref;

NP_BRICK_RARE static float np_brick_sample_indirect(np_brick_ref ref, np_vec3 local);

/* `footprint`: voxels across that one value stands for; detail finer than that is left out. */
NP_BRICK_RARE static void np_brick_sample_along_indirect(np_brick_ref ref, np_vec3 begin, np_vec3 along,
                                                         float footprint, const float at[NP_BRICK_LINE], int count,
                                                         float out[NP_BRICK_LINE]);

/* Value inside a known brick at rest; `local` in [0, 8]³ from the brick's first sample, and clamped to it. NaN becomes
 * 0. */
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
  return bricks->scale * np_brick_mix_corners(&corners, fraction);
}

/* The same at rest or not, with detail where there is any. */
static inline float np_brick_eval(const np_bricks *bricks, uint32_t brick, const int32_t cell[3], np_vec3 local) {
  if (bricks->is_indirect) return np_brick_sample_indirect((np_brick_ref){bricks, brick, cell}, local);
  return np_brick_sample(bricks, brick, local);
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

/* Values at begin + at[k]·along inside a known brick at rest: `count` of them, at most NP_BRICK_LINE. Up to seven more
 * places are looked at and written to: both arrays have NP_BRICK_LINE. */
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

/* Values at begin, begin + step, and so on, of bricks at rest or not, with detail that the step resolves. */
static inline void np_brick_sample_line(const np_bricks *bricks, uint32_t brick, const int32_t cell[3], np_vec3 begin,
                                        np_vec3 step, int count, float out[NP_BRICK_LINE]) {
  static const float steps[NP_BRICK_LINE] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  if (bricks->is_indirect)
    np_brick_sample_along_indirect((np_brick_ref){bricks, brick, cell}, begin, step, np_vec3_length(step), steps, count,
                                   out);
  else
    np_brick_sample_along(bricks, brick, begin, step, steps, count, out);
}

/* Floor of a number below 2⁶² in magnitude; libm's is a call below x86-64-v3. */
static inline double np_brick_floor(double x) {
  double whole = (double)(int64_t)x;
  return whole > x ? whole - 1.0 : whole;
}

/* A cell by its place in its node. */
typedef struct np_brick_place {
  size_t entry;  /* of the table */
  uint32_t node; /* or NP_BRICK_NONE */
  uint32_t cell, group;
} np_brick_place;

/* Place of a cell, counted from the first. */
static inline np_brick_place np_bricks_get_place(const np_bricks *bricks, const int32_t cell[3]) {
  enum { MASK = NP_BRICK_NODE_EDGE - 1 };
  const uint32_t x = (uint32_t)(cell[0] + bricks->lead[0]), y = (uint32_t)(cell[1] + bricks->lead[1]),
                 z = (uint32_t)(cell[2] + bricks->lead[2]);
  np_brick_place out;
  out.entry = ((size_t)(x >> NP_BRICK_NODE_SHIFT) * (size_t)bricks->table_size[1] + (y >> NP_BRICK_NODE_SHIFT)) *
                  (size_t)bricks->table_size[2] +
              (z >> NP_BRICK_NODE_SHIFT);
  out.node = bricks->table[out.entry];
  out.cell = (x & MASK) << 8 | (y & MASK) << 4 | (z & MASK);
  out.group = (x & MASK) >> 2 << 4 | (y & MASK) >> 2 << 2 | (z & MASK) >> 2;
  return out;
}

/* Number of a cell's brick, or NP_BRICK_NONE: it is constant. */
static inline uint32_t np_bricks_get_brick(const np_bricks *bricks, const np_brick_place *at) {
  return at->node == NP_BRICK_NONE ? NP_BRICK_NONE : bricks->nodes[at->node].brick[at->cell];
}

/* Range of a cell of a level. */
static inline np_brick_range np_bricks_get_range(const np_bricks *bricks, const np_brick_place *at, int level) {
  if (at->node == NP_BRICK_NONE) return bricks->table_ranges[at->entry];
  const np_brick_node *node = &bricks->nodes[at->node];
  return level == 0 ? node->range[at->cell] : level == 1 ? node->group_range[at->group] : node->whole_range;
}

/* Splits an index position into a cell and the place in it. False outside the cells, and for NaN. */
static inline bool np_bricks_locate(const np_bricks *bricks, np_dvec3 index_position, int32_t out_cell[3],
                                    np_vec3 *out_local) {
  const double position[3] = {index_position.x, index_position.y, index_position.z};
  float local[3];
  for (int a = 0; a < 3; a++) {
    double x = position[a] - (double)bricks->origin[a] * NP_BRICK_EDGE,
           extent = (double)bricks->size[a] * NP_BRICK_EDGE;
    if (a < 2 && bricks->is_periodic[a]) x = np_brick_wrap_position(x, extent);
    if (!(x >= 0.0 && x < extent)) return false;
    out_cell[a] = (int32_t)x / NP_BRICK_EDGE;
    local[a] = (float)(x - (double)out_cell[a] * NP_BRICK_EDGE);
  }
  *out_local = np_vec3_make(local[0], local[1], local[2]);
  return true;
}

/* Value at an index position: the trilinear interpolant of the samples, the background outside the cells. */
static inline float np_bricks_sample(const np_bricks *bricks, np_dvec3 index_position) {
  int32_t cell[3];
  np_vec3 local;
  if (!np_bricks_locate(bricks, index_position, cell, &local)) return bricks->background;
  const np_brick_place at = np_bricks_get_place(bricks, cell);
  const uint32_t brick = np_bricks_get_brick(bricks, &at);
  if (brick == NP_BRICK_NONE) return np_bricks_get_range(bricks, &at, 0).min;
  if (!bricks->is_indirect) return np_brick_sample(bricks, brick, local);
  const double index[3] = {index_position.x - (double)local.x, index_position.y - (double)local.y,
                           index_position.z - (double)local.z};
  for (int a = 0; a < 3; a++) cell[a] = (int32_t)np_brick_floor(index[a] * (1.0 / NP_BRICK_EDGE) + 0.5);
  return np_brick_sample_indirect((np_brick_ref){bricks, brick, cell}, local);
}

/* Voxels a second inside a brick that moves. */
static inline np_vec3 np_brick_get_velocity(const np_brick_motion *motion, uint32_t brick, np_vec3 local) {
  __m128 place = _mm_setr_ps(local.x, local.y, local.z, 0.0f), fraction;
  place = _mm_min_ps(_mm_max_ps(place, _mm_setzero_ps()), _mm_set1_ps((float)NP_BRICK_EDGE));
  const __m128i lower = _mm_cvttps_epi32(_mm_min_ps(place, _mm_set1_ps((float)(NP_BRICK_EDGE - 1))));
  fraction = _mm_sub_ps(place, _mm_cvtepi32_ps(lower));
  __m128i strided = _mm_madd_epi16(lower, _mm_setr_epi32(NP_BRICK_STRIDE_X, NP_BRICK_SAMPLES, 1, 0));
  strided = _mm_add_epi32(strided, _mm_unpackhi_epi64(strided, strided));
  const uint32_t offset = (uint32_t)_mm_cvtsi128_si32(_mm_add_epi32(strided, _mm_shuffle_epi32(strided, 1)));
  float out[3];
  for (size_t a = 0; a < 3; a++) {
    const size_t first = (3 * (size_t)brick + a) * NP_BRICK_STRIDE + offset;
    const np_brick_corners corners = np_brick_load_halves(motion->velocity + first);
    out[a] = motion->scale * np_brick_mix_corners(&corners, fraction);
  }
  return np_vec3_make(out[0], out[1], out[2]);
}

/* Semi-Lagrangian: the value of x at the time t is that of x − v(x)·t at time 0. */
static inline float np_brick_sample_moving(const np_bricks *bricks, uint32_t brick, np_vec3 local) {
  const np_brick_motion *motion = bricks->motion;
  const int32_t *cell = motion->cells[brick];
  const np_vec3 moved = np_vec3_scale(np_brick_get_velocity(motion, brick, local), motion->time_s);
  const np_dvec3 index = np_dvec3_make((double)cell[0] * NP_BRICK_EDGE + (double)(local.x - moved.x),
                                       (double)cell[1] * NP_BRICK_EDGE + (double)(local.y - moved.y),
                                       (double)cell[2] * NP_BRICK_EDGE + (double)(local.z - moved.z));
  return np_bricks_sample(motion->rest, index);
}

#include "volume/brick_detail_sample.h"

static float np_brick_sample_indirect(np_brick_ref ref, np_vec3 local) {
  if (ref.bricks->motion) return np_brick_sample_moving(ref.bricks, ref.brick, local);
  return np_brick_detail_sample(ref, local);
}

static void np_brick_sample_along_indirect(np_brick_ref ref, np_vec3 begin, np_vec3 along, float footprint,
                                           const float at[NP_BRICK_LINE], int count, float out[NP_BRICK_LINE]) {
  if (!ref.bricks->motion) {
    np_brick_detail_sample_along(ref, begin, along, footprint, at, count, out);
    return;
  }
  for (int k = 0; k < count; k++)
    out[k] = np_brick_sample_moving(ref.bricks, ref.brick, np_vec3_add(begin, np_vec3_scale(along, at[k])));
}

#endif

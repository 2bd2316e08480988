/* SPDX-License-Identifier: Apache-2.0 */
/* Bricks: the form in which the renderer reads a volume.
 *
 * Sample i sits at integer index i. Brick b answers for index positions in [8b, 8b+8) and holds the 9³ samples from 8b
 * on, its window, so that a trilinear look-up touches one brick. A constant window is a tile and has no brick. Every
 * cell knows the minimum and maximum of the interpolant over it, and so do two coarser levels of 4³ and 16³ cells.
 * Empty-space skipping and majorants use them. Cells are grouped in nodes of 16³, which coincide with the 128³ voxels
 * of OpenVDB's lower internal nodes. A constant node is an entry of the table alone, and equal nodes amid large tiles
 * are shared, so that memory follows the content of a grid and not the size of its box.
 *
 * Look-ups are inline, so that each kernel file compiles them for its own instruction set. */
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
  NP_BRICK_SAMPLES = 9, /* samples along an edge */
  NP_BRICK_STRIDE_X =
      NP_BRICK_SAMPLES * NP_BRICK_SAMPLES, /* stride of one sample along x; along y it is 9, along z 1 */
  NP_BRICK_VOLUME = 729,                   /* 9³, z fastest */
  NP_BRICK_STRIDE = 736,                   /* stride of one brick: 729 rounded up to 16 */
  NP_BRICK_LEVELS = 3,                     /* cells of 1, 4 and 16 bricks */
  NP_BRICK_LEVEL_SHIFT = 2,                /* a cell spans 2² cells of the level below, along each axis */
  NP_BRICK_NODE_SHIFT = 4,
  NP_BRICK_NODE_EDGE = 16,    /* cells along an edge of a node */
  NP_BRICK_NODE_CELLS = 4096, /* 16³, z fastest */
  NP_BRICK_NODE_GROUPS = 64   /* groups of 4³ cells, z fastest */
};

#define NP_BRICK_NONE 0xffffffffu

/* Bounds of the interpolant over one cell, in the file's unit. They include the rounding in float. */
typedef struct np_brick_range {
  float min, max;
} np_brick_range;

static inline bool np_brick_range_is_zero(np_brick_range range) { return range.min == 0.0f && range.max == 0.0f; }

/* Cells of a node that is not constant. */
typedef struct np_brick_node {
  uint32_t brick[NP_BRICK_NODE_CELLS];       /* number of each cell's brick, or NP_BRICK_NONE: the cell is constant */
  np_brick_range range[NP_BRICK_NODE_CELLS]; /* a constant cell has min == max == its value */
  np_brick_range group_range[NP_BRICK_NODE_GROUPS]; /* range of each group of cells */
  np_brick_range whole_range;
} np_brick_node;

/* Velocities at the samples of moving bricks. A value is looked up at the position of its matter at time 0. */
typedef struct np_brick_motion {
  const struct np_bricks *rest; /* bricks at time 0 */
  const uint16_t *velocity;     /* x, y and z components of each brick in turn, in `scale` voxels a second */
  const int32_t (*cells)[3];    /* brick coordinates of each brick */
  float scale;
  float time_s;
} np_brick_motion;

typedef struct np_bricks {
  neph_context *context;        /* borrowed */
  int32_t origin[3], size[3];   /* brick coordinates of the first cell, and number of cells */
  int32_t lead[3];              /* offset of the first cell in the first node */
  int32_t table_size[3];        /* size of the table in nodes */
  uint32_t *table;              /* number of each node among `nodes`, or NP_BRICK_NONE for a constant node; z fastest */
  np_brick_range *table_ranges; /* range of each constant node */
  size_t node_count;
  np_brick_node *nodes;
  size_t brick_count;
  uint16_t *halves;                     /* samples divided by `scale`, when half */
  float *floats;                        /* samples, when float */
  const np_brick_motion *motion;        /* velocities of moving bricks; exactly one of these three is not NULL */
  const struct np_brick_detail *detail; /* finer than the samples (volume/brick_detail.h); NULL: none */
  bool is_nearest;        /* a look-up yields the nearest sample, so that steps between samples stay sharp */
  bool is_indirect;       /* they move, have detail or are nearest: a look-up is no plain interpolation of samples */
  float scale;            /* power of two that puts the largest magnitude in [1, 2); 1 when float */
  bool is_periodic[2];    /* along x and y; then the table covers whole periods, and `origin` is 0 */
  int32_t period[2];      /* period of the table in voxels, a multiple of 8 */
  double field_period[2]; /* period of the samples in voxels, of which the table may hold several */
  int32_t reach_low[3],
      reach_high[3]; /* range of brick coordinates that rays walk through: the table, or all periods */
  float background;  /* value outside the table */
  float value_max;   /* upper bound of the interpolant */
} np_bricks;

/* Builds bricks from a grid, in parallel. `period` NULL: not periodic; else voxels along x and y, multiples of 8, or 0
 * along an axis that is not periodic. Sample i is then the grid's sample i mod period, and the grid must lie in [0,
 * period). */
neph_result np_bricks_build(neph_context *context, const np_sparse_grid *grid, neph_precision precision,
                            const int32_t period[2], np_monitor *monitor, np_bricks *out_bricks);
void np_bricks_clear(np_bricks *bricks);
size_t np_bricks_get_bytes(const np_bricks *bricks);
size_t np_bricks_count_table(const np_bricks *bricks);

/* Voxels that the light caches treat as one along each axis, a power of two. It is above 1 only for a sparse box with
 * more than 512 voxels along its longest side, as around a large tile or a stray voxel. Periodic layers are resolved to
 * their voxels. */
double np_bricks_count_joined(const np_bricks *bricks);

/* Lists the cells whose interpolant is not 0, in brick coordinates; `out` NULL: only counts them. */
size_t np_bricks_list_cells(const np_bricks *bricks, int32_t (*out)[3]);

/* The eight samples around a position, as four pairs along z in the two lower lanes. The upper lanes hold the next
 * samples of the brick, for which its stride leaves room: a load of four of which two are ignored needs no shuffle. */
typedef struct np_brick_corners {
  __m128 pair[2][2]; /* indexed by x and y */
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
/* Decodes four finite halves, each in the low bits of a lane, by integer arithmetic. A subnormal half becomes the
 * mantissa of a float of 2⁻¹⁴, which is then subtracted, so that no float is ever subnormal. */
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

/* Trilinear interpolation of eight corners. */
static inline float np_brick_mix_corners(const np_brick_corners *corners, __m128 fraction) {
  __m128 x = _mm_shuffle_ps(fraction, fraction, 0x00), y = _mm_shuffle_ps(fraction, fraction, 0x55);
  __m128 z = _mm_movehl_ps(fraction, fraction);
  __m128 y_0 = np_brick_mix(corners->pair[0][0], corners->pair[1][0], x);
  __m128 y_1 = np_brick_mix(corners->pair[0][1], corners->pair[1][1], x);
  __m128 z_0 = np_brick_mix(y_0, y_1, y), z_1 = _mm_shuffle_ps(z_0, z_0, 0x55);
  return _mm_cvtss_f32(np_brick_mix(z_0, z_1, z));
}

/* Functions for moving bricks, detail and nearest samples are not inlined: they are rare, and other bricks pay nothing
 * for them. */
#if defined(__GNUC__)
#define NP_BRICK_RARE __attribute__((noinline, unused))
#else
#define NP_BRICK_RARE
#endif

/* Whether values along a ray are a cubic from one plane of samples to the next. */
static inline bool np_bricks_are_smooth(const np_bricks *bricks) { return !bricks->detail && !bricks->is_nearest; }

enum { NP_BRICK_LINE = 16 }; /* positions that are looked up together */

/* A brick and its cell, in brick coordinates, not wrapped if periodic. */
typedef struct np_brick_ref {
  const np_bricks *bricks;
  uint32_t brick;
  const int32_t *cell;
} np_brick_ref;

NP_BRICK_RARE static float np_brick_sample_indirect(np_brick_ref ref, np_vec3 local);

/* `footprint`: width in voxels over which a value is averaged; finer detail is left out. */
NP_BRICK_RARE static void np_brick_sample_along_indirect(np_brick_ref ref, np_vec3 begin, np_vec3 along,
                                                         float footprint, const float at[NP_BRICK_LINE], int count,
                                                         float out[NP_BRICK_LINE]);

/* Value inside a known brick at rest. `local` is in [0, 8]³ from the brick's first sample, and clamped to it; NaN
 * becomes 0. */
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

/* Value inside a known brick of any kind: at rest, moving, with detail or of nearest samples. */
static inline float np_brick_eval(const np_bricks *bricks, uint32_t brick, const int32_t cell[3], np_vec3 local) {
  if (bricks->is_indirect) return np_brick_sample_indirect((np_brick_ref){bricks, brick, cell}, local);
  return np_brick_sample(bricks, brick, local);
}

#if defined(__AVX2__)
/* Loads the pairs along z of four positions, by offsets from the brick's first sample. */
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

/* Clamps four coordinates to the brick and splits them into integers and fractions. */
static inline __m128i np_brick_split(__m128 place, __m128 *out_fraction) {
  place = _mm_min_ps(_mm_max_ps(place, _mm_setzero_ps()), _mm_set1_ps((float)NP_BRICK_EDGE));
  __m128i lower = _mm_cvttps_epi32(_mm_min_ps(place, _mm_set1_ps((float)(NP_BRICK_EDGE - 1))));
  *out_fraction = _mm_sub_ps(place, _mm_cvtepi32_ps(lower));
  return lower;
}

/* np_brick_sample() at four positions, with equal bits, in about the time of two. */
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
/* Loads the pairs along z of eight positions. */
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

/* Values at begin + at[k]·along inside a known brick at rest: `count` of them, at most NP_BRICK_LINE. The function
 * reads and writes up to seven elements beyond `count`: both arrays have NP_BRICK_LINE. */
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

/* np_brick_sample_along() of the samples: linear or nearest, without detail and motion. */
static inline void np_brick_sample_along_plain(np_brick_ref ref, np_vec3 begin, np_vec3 along,
                                               const float at[NP_BRICK_LINE], int count, float out[NP_BRICK_LINE]) {
  if (ref.bricks->is_nearest)
    np_brick_sample_along_indirect(ref, begin, along, 0.0f, at, count, out);
  else
    np_brick_sample_along(ref.bricks, ref.brick, begin, along, at, count, out);
}

/* Values at begin, begin + step, and so on, of bricks of any kind, with the detail that the step resolves. */
static inline void np_brick_sample_line(const np_bricks *bricks, uint32_t brick, const int32_t cell[3], np_vec3 begin,
                                        np_vec3 step, int count, float out[NP_BRICK_LINE]) {
  static const float steps[NP_BRICK_LINE] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  if (bricks->is_indirect)
    np_brick_sample_along_indirect((np_brick_ref){bricks, brick, cell}, begin, step, np_vec3_length(step), steps, count,
                                   out);
  else
    np_brick_sample_along(bricks, brick, begin, step, steps, count, out);
}

/* Floor of a number below 2⁶² in magnitude; libm's floor is a function call below x86-64-v3. */
static inline double np_brick_floor(double x) {
  double whole = (double)(int64_t)x;
  return whole > x ? whole - 1.0 : whole;
}

/* Position of a cell in the table and in its node. */
typedef struct np_brick_place {
  size_t entry;  /* entry of the table */
  uint32_t node; /* index into `nodes`, or NP_BRICK_NONE */
  uint32_t cell, group;
} np_brick_place;

/* Looks a cell up in the table; cells are counted from the first. */
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

/* Number of a cell's brick, or NP_BRICK_NONE if the cell is constant. */
static inline uint32_t np_bricks_get_brick(const np_bricks *bricks, const np_brick_place *at) {
  return at->node == NP_BRICK_NONE ? NP_BRICK_NONE : bricks->nodes[at->node].brick[at->cell];
}

/* Range of a cell, or of the coarser cell around it on a level. */
static inline np_brick_range np_bricks_get_range(const np_bricks *bricks, const np_brick_place *at, int level) {
  if (at->node == NP_BRICK_NONE) return bricks->table_ranges[at->entry];
  const np_brick_node *node = &bricks->nodes[at->node];
  return level == 0 ? node->range[at->cell] : level == 1 ? node->group_range[at->group] : node->whole_range;
}

/* Splits an index position into a cell and the position in it. False outside of the cells, and for NaN. */
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

/* Velocity inside a moving brick, in voxels a second. */
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

/* Semi-Lagrangian look-up: the value of x at time t is the value of x − v(x)·t at time 0. */
static inline float np_brick_sample_moving(const np_bricks *bricks, uint32_t brick, np_vec3 local) {
  const np_brick_motion *motion = bricks->motion;
  const int32_t *cell = motion->cells[brick];
  const np_vec3 moved = np_vec3_scale(np_brick_get_velocity(motion, brick, local), motion->time_s);
  const np_dvec3 index = np_dvec3_make((double)cell[0] * NP_BRICK_EDGE + (double)(local.x - moved.x),
                                       (double)cell[1] * NP_BRICK_EDGE + (double)(local.y - moved.y),
                                       (double)cell[2] * NP_BRICK_EDGE + (double)(local.z - moved.z));
  return np_bricks_sample(motion->rest, index);
}

/* Value of the nearest sample: that of sample i from i − ½ to below i + ½. */
static inline float np_brick_sample_nearest(const np_bricks *bricks, uint32_t brick, np_vec3 local) {
  return np_brick_sample(bricks, brick,
                         np_vec3_make(floorf(local.x + 0.5f), floorf(local.y + 0.5f), floorf(local.z + 0.5f)));
}

#include "volume/brick_detail_sample.h"

static float np_brick_sample_indirect(np_brick_ref ref, np_vec3 local) {
  if (ref.bricks->motion) return np_brick_sample_moving(ref.bricks, ref.brick, local);
  if (ref.bricks->is_nearest) return np_brick_sample_nearest(ref.bricks, ref.brick, local);
  return np_brick_detail_sample(ref, local);
}

static void np_brick_sample_along_indirect(np_brick_ref ref, np_vec3 begin, np_vec3 along, float footprint,
                                           const float at[NP_BRICK_LINE], int count, float out[NP_BRICK_LINE]) {
  if (ref.bricks->detail && !ref.bricks->motion) {
    np_brick_detail_sample_along(ref, begin, along, footprint, at, count, out);
    return;
  }
  for (int k = 0; k < count; k++)
    out[k] = np_brick_sample_indirect(ref, np_vec3_add(begin, np_vec3_scale(along, at[k])));
}

#endif

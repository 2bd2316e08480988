/* SPDX-License-Identifier: Apache-2.0 */
/* Look-ups of detail finer than the samples of bricks (built by brick_detail.h). bricks.h includes this file after the
 * functions that it needs.
 *
 * At the edge of a cloud the value v of a coarse grid is a mean of full and empty places. With c, the largest value
 * nearby, the share of full places is t = v/c. A noise u, uniform in [0, 1], selects them: v′ = (1 − s)·v + s·c·S(t,
 * u), where S rises from 0 to 1 as u falls below about t, over a width w. The mean of S over u is t, so that the mean
 * of v′ is v. The bound 0 ≤ S ≤ min(√(2t/w), 1) bounds v′. */
#ifndef NP_VOLUME_BRICK_DETAIL_SAMPLE_H
#define NP_VOLUME_BRICK_DETAIL_SAMPLE_H

enum {
  NP_DETAIL_LAYERS = 4,       /* layers of the noise */
  NP_DETAIL_NOISE_BRICKS = 8, /* bricks along an edge of the periodic texture */
  NP_DETAIL_RANKS = 256,
  NP_DETAIL_CORE_NODES = 3,  /* nodes of c along an edge of a brick: one every 4 samples */
  NP_DETAIL_CORE_STRIDE = 32 /* 3³ nodes, and room for loads of four */
};

typedef struct np_brick_detail {
  float strength;
  double size_voxels[3];                     /* size of the largest billows along each axis */
  const np_bricks *noise;                    /* texture of 8³ bricks, periodic */
  double turn[NP_DETAIL_LAYERS][3][4];       /* map of each layer from index positions to samples of the texture */
  float width;                               /* width of the step S in the rank of the noise */
  float weight[NP_DETAIL_LAYERS];            /* weights of the finer layers, from the third on */
  float rest[NP_DETAIL_LAYERS];              /* largest sum of the layers from each on */
  float rank_end, rank[NP_DETAIL_RANKS + 1]; /* share of the noise below k/256 of its maximum */
  const float *cores;                        /* c at 3³ nodes of each brick, z fastest */
} np_brick_detail;

/* Value of c at a position. */
static inline float np_brick_detail_get_core(const np_brick_detail *detail, uint32_t brick, np_vec3 local) {
  __m128 place = _mm_mul_ps(_mm_setr_ps(local.x, local.y, local.z, 0.0f), _mm_set1_ps(0.25f));
  place = _mm_min_ps(_mm_max_ps(place, _mm_setzero_ps()), _mm_set1_ps((float)(NP_DETAIL_CORE_NODES - 1)));
  const __m128i lower = _mm_cvttps_epi32(_mm_min_ps(place, _mm_set1_ps((float)(NP_DETAIL_CORE_NODES - 2))));
  const __m128 fraction = _mm_sub_ps(place, _mm_cvtepi32_ps(lower));
  int32_t at[4];
  _mm_storeu_si128((__m128i *)(void *)at, lower);
  const float *first = detail->cores + (size_t)brick * NP_DETAIL_CORE_STRIDE + at[0] * 9 + at[1] * 3 + at[2];
  const np_brick_corners corners = {
      {{_mm_loadu_ps(first), _mm_loadu_ps(first + 3)}, {_mm_loadu_ps(first + 9), _mm_loadu_ps(first + 12)}}};
  return np_brick_mix_corners(&corners, fraction);
}

static inline float np_brick_detail_get_texture(const np_bricks *noise, const double turn[3][4], const double at[3]) {
  enum { EDGE = NP_DETAIL_NOISE_BRICKS * NP_BRICK_EDGE };
  float local[3];
  uint32_t brick = 0;
  for (int a = 0; a < 3; a++) {
    double x = turn[a][0] * at[0] + turn[a][1] * at[1] + turn[a][2] * at[2] + turn[a][3];
    x -= EDGE * np_brick_floor(x * (1.0 / EDGE));
    const uint32_t cell = (uint32_t)x / NP_BRICK_EDGE & (NP_DETAIL_NOISE_BRICKS - 1);
    local[a] = (float)(x - (double)cell * NP_BRICK_EDGE);
    brick = brick * NP_DETAIL_NOISE_BRICKS + cell;
  }
  return np_brick_sample(noise, brick, np_vec3_make(local[0], local[1], local[2]));
}

/* Billows: squared distance to the nearest point of two periodic point sets with different periods, and shares of the
 * distances to the points of two finer sets. */
static inline float np_brick_detail_get_noise(const np_brick_detail *detail, const double at[3]) {
  float noise = np_minf(np_brick_detail_get_texture(detail->noise, detail->turn[0], at),
                        np_brick_detail_get_texture(detail->noise, detail->turn[1], at));
  for (int k = 2; k < NP_DETAIL_LAYERS; k++)
    noise += detail->weight[k] * np_brick_detail_get_texture(detail->noise, detail->turn[k], at);
  return noise;
}

/* Share of space in which the noise is lower. */
static inline float np_brick_detail_get_rank(const np_brick_detail *detail, float noise) {
  const float place = np_clampf(noise / detail->rank_end, 0.0f, 1.0f) * NP_DETAIL_RANKS;
  const int lower = place < NP_DETAIL_RANKS - 1 ? (int)place : NP_DETAIL_RANKS - 1;
  return detail->rank[lower] + (place - (float)lower) * (detail->rank[lower + 1] - detail->rank[lower]);
}

/* The a that makes t the mean of clamp((a − u)/w, 0, 1) over u in [0, 1]. */
static inline float np_brick_detail_get_edge(float t, float w) {
  if (t < 0.5f * w) return sqrtf(2.0f * w * t);
  if (t > 1.0f - 0.5f * w) return 1.0f + w - sqrtf(2.0f * w * np_maxf(1.0f - t, 0.0f));
  return t + 0.5f * w;
}

/* S for the position a of the edge and a rank of the noise. */
static inline float np_brick_detail_get_step(const np_brick_detail *detail, float edge, float rank) {
  return np_clampf((edge - rank) / detail->width, 0.0f, 1.0f);
}

/* S at a position. Octaves are added until the remaining ones cannot change S. */
static inline float np_brick_detail_select(const np_brick_detail *detail, const double at[3], float edge) {
  float noise = np_minf(np_brick_detail_get_texture(detail->noise, detail->turn[0], at),
                        np_brick_detail_get_texture(detail->noise, detail->turn[1], at));
  for (int k = 2;; k++) {
    const float rank = np_brick_detail_get_rank(detail, noise);
    if (k == NP_DETAIL_LAYERS) return np_brick_detail_get_step(detail, edge, rank);
    if (rank >= edge) return 0.0f;
    if (np_brick_detail_get_rank(detail, noise + detail->rest[k]) <= edge - detail->width) return 1.0f;
    noise += detail->weight[k] * np_brick_detail_get_texture(detail->noise, detail->turn[k], at);
  }
}

/* Whether the rank of the noise at a position is below a limit. */
static inline bool np_brick_detail_is_below(const np_brick_detail *detail, const double at[3], float limit) {
  float noise = np_minf(np_brick_detail_get_texture(detail->noise, detail->turn[0], at),
                        np_brick_detail_get_texture(detail->noise, detail->turn[1], at));
  for (int k = 2; k < NP_DETAIL_LAYERS; k++) {
    if (np_brick_detail_get_rank(detail, noise) >= limit) return false;
    if (np_brick_detail_get_rank(detail, noise + detail->rest[k]) < limit) return true;
    noise += detail->weight[k] * np_brick_detail_get_texture(detail->noise, detail->turn[k], at);
  }
  return np_brick_detail_get_rank(detail, noise) < limit;
}

/* Size of the largest billows, in voxels along the axis on which they are smallest. */
static inline float np_brick_detail_get_size(const np_brick_detail *detail) {
  return (float)fmin(fmin(detail->size_voxels[0], detail->size_voxels[1]), detail->size_voxels[2]);
}

/* Share of the detail that remains in a value averaged over `footprint` voxels: 1 up to half of the detail's size,
 * falling to 0 at its size. */
static inline float np_brick_detail_get_share(const np_brick_detail *detail, float footprint) {
  return np_clampf(2.0f - 2.0f * footprint / np_brick_detail_get_size(detail), 0.0f, 1.0f);
}

/* Index position of a local one. */
static inline void np_brick_detail_locate(np_brick_ref ref, np_vec3 local, double out_at[3]) {
  const float within[3] = {local.x, local.y, local.z};
  for (int a = 0; a < 3; a++) out_at[a] = (double)ref.cell[a] * NP_BRICK_EDGE + (double)within[a];
}

/* v′ − v for a known v. */
static inline float np_brick_detail_add(np_brick_ref ref, np_vec3 local, float value, float share) {
  const np_brick_detail *detail = ref.bricks->detail;
  if (!(value > 0.0f) || !(share > 0.0f)) return 0.0f;
  const float core = np_brick_detail_get_core(detail, ref.brick, local);
  if (!(value < core)) return 0.0f;
  double at[3];
  np_brick_detail_locate(ref, local, at);
  const float step = np_brick_detail_select(detail, at, np_brick_detail_get_edge(value / core, detail->width));
  return share * detail->strength * (core * step - value);
}

/* v′ − v at a position in bricks at rest. */
static inline float np_brick_detail_get_excess(np_brick_ref ref, np_vec3 local, float footprint) {
  const float value = np_brick_sample(ref.bricks, ref.brick, local);
  return np_brick_detail_add(ref, local, value, np_brick_detail_get_share(ref.bricks->detail, footprint));
}

static inline float np_brick_detail_sample(np_brick_ref ref, np_vec3 local) {
  const float value = np_brick_sample(ref.bricks, ref.brick, local);
  return value + np_brick_detail_add(ref, local, value, 1.0f);
}

/* Whether v′ exceeds a threshold, 0 or more. Octaves are added until the remaining ones cannot change the answer. */
static inline bool np_brick_detail_exceeds(np_brick_ref ref, np_vec3 local, float threshold) {
  const np_brick_detail *detail = ref.bricks->detail;
  const float value = np_brick_sample(ref.bricks, ref.brick, local);
  if (!(value > 0.0f)) return false;
  const float core = np_brick_detail_get_core(detail, ref.brick, local);
  if (!(value < core)) return threshold < value;
  const float step = (threshold - (1.0f - detail->strength) * value) / (detail->strength * core);
  const float edge = np_brick_detail_get_edge(value / core, detail->width), rank = edge - step * detail->width;
  if (step < 0.0f) return true;
  if (step >= 1.0f || rank <= 0.0f) return false;
  double at[3];
  np_brick_detail_locate(ref, local, at);
  return np_brick_detail_is_below(detail, at, rank);
}

static inline void np_brick_detail_sample_along(np_brick_ref ref, np_vec3 begin, np_vec3 along, float footprint,
                                                const float at[NP_BRICK_LINE], int count, float out[NP_BRICK_LINE]) {
  const float share = np_brick_detail_get_share(ref.bricks->detail, footprint);
  np_brick_sample_along(ref.bricks, ref.brick, begin, along, at, count, out);
  for (int k = 0; k < count && share > 0.0f; k++)
    out[k] += np_brick_detail_add(ref, np_vec3_add(begin, np_vec3_scale(along, at[k])), out[k], share);
}

/* Number of parts of a segment, each a quarter of the size of the detail, so that detail hardly varies within a
 * part. */
static inline int np_brick_detail_count(const np_brick_detail *detail, np_vec3 along) {
  const float delta[3] = {along.x, along.y, along.z};
  float sum = 0.0f;
  for (int a = 0; a < 3; a++) {
    const float sizes = delta[a] / (float)detail->size_voxels[a];
    sum += sizes * sizes;
  }
  return 1 + (int)np_minf(4.0f * sqrtf(sum), 4095.0f);
}

/* Mean of v′ from `begin` to begin + along, by two Gauss points in each part. */
static inline float np_brick_detail_mean(np_brick_ref ref, np_vec3 begin, np_vec3 along) {
  const int count = np_brick_detail_count(ref.bricks->detail, along);
  float sum = 0.0f;
  for (int k = 0; k < 2 * count; k++) {
    const float at = ((float)(k / 2) + 0.5f + (k % 2 ? 0.28867513f : -0.28867513f)) / (float)count;
    sum += np_brick_detail_sample(ref, np_vec3_add(begin, np_vec3_scale(along, at)));
  }
  return sum / (float)(2 * count);
}

#endif

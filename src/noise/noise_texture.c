/* SPDX-License-Identifier: Apache-2.0 */
#include <assert.h>
#include <nephos/noise_texture.h>

#include "core/alloc.h"
#include "core/given.h"
#include "core/math.h"
#include "core/parallel.h"
#include "noise/noise.h"

struct neph_noise_texture {
  neph_context *context;
  int32_t size; /* a power of two */
  float *values;
};

enum { SIZE_MAX_TEXELS = 128 };

typedef struct texture_kind {
  int32_t size, cells;
  np_noise_octaves octaves;
} texture_kind;

/* Sizes: the finest octave has at least four texels a cell, so that trilinear look-ups follow it. */
static const texture_kind kinds[] = {
    [NEPH_NOISE_TEXTURE_BASE] = {128, 4, {4, 0.5f}}, [NEPH_NOISE_TEXTURE_DETAIL] = {32, 2, {3, 0.5f}}};

typedef struct texture_job {
  const neph_noise_texture *texture;
  const np_noise_table *noise;
  neph_noise_texture_kind kind;
  np_noise_lattice lattice;
} texture_job;

static void fill_row(const texture_job *job, size_t row) {
  const texture_kind *kind = &kinds[job->kind];
  const int32_t size = kind->size;
  assert(size <= SIZE_MAX_TEXELS && (size & (size - 1)) == 0);
  const float cells_per_texel = (float)kind->cells / (float)size;
  float x[SIZE_MAX_TEXELS], y[SIZE_MAX_TEXELS], z[SIZE_MAX_TEXELS], *out = job->texture->values + row * (size_t)size;
  for (int32_t i = 0; i < size; i++) {
    x[i] = (float)i * cells_per_texel;
    y[i] = (float)(row % (size_t)size) * cells_per_texel;
    z[i] = (float)(row / (size_t)size) * cells_per_texel;
  }
  const np_noise_points points = {(size_t)size, x, y, z};
  if (job->kind == NEPH_NOISE_TEXTURE_BASE)
    job->noise->perlin_worley(&job->lattice, &kind->octaves, &points, out);
  else
    job->noise->worley_fbm(&job->lattice, &kind->octaves, &points, out);
}

static neph_result fill_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t row = begin; row < end; row++) fill_row(user, row);
  return NEPH_OK;
}

static neph_result fill(neph_context *context, neph_noise_texture_kind kind, uint64_t seed,
                        const neph_noise_texture *texture) {
  const int32_t cells = kinds[kind].cells;
  texture_job job = {
      texture, np_noise_get_table(context->isa), kind, {np_noise_derive_seed(seed, kind), {cells, cells, cells}}};
  np_monitor monitor;
  np_monitor_start(&monitor, context, NULL, NULL);
  return np_parallel_for(context, &monitor, (size_t)texture->size * (size_t)texture->size, 64, fill_rows, &job);
}

neph_result neph_noise_texture_create(neph_context *context, neph_noise_texture_kind kind, uint64_t seed,
                                      neph_noise_texture **out_texture) {
  if (NP_LACKS_OUT(context, out_texture)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_texture = NULL;
  if (kind != NEPH_NOISE_TEXTURE_BASE && kind != NEPH_NOISE_TEXTURE_DETAIL)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "noise texture: kind is %d, must be base (0) or detail (1)",
                   (int)kind);
  neph_noise_texture *texture = np_alloc(context, 1, sizeof *texture);
  if (!texture) return NEPH_ERROR_OUT_OF_MEMORY;
  np_context_retain(context);
  *texture = (neph_noise_texture){.context = context, .size = kinds[kind].size};
  const size_t side = (size_t)texture->size, count = side * side * side;
  const unsigned mode = np_float_mode_enter();
  texture->values = np_alloc(context, count, sizeof *texture->values);
  neph_result result = texture->values ? fill(context, kind, seed, texture) : NEPH_ERROR_OUT_OF_MEMORY;
  np_float_mode_leave(mode);
  if (result)
    neph_noise_texture_destroy(texture);
  else
    *out_texture = texture;
  return result;
}

void neph_noise_texture_destroy(neph_noise_texture *texture) {
  if (!texture) return;
  neph_context *context = texture->context;
  np_alloc_free(context, texture->values);
  np_alloc_free(context, texture);
  np_context_release(context);
}

unsigned neph_noise_texture_get_size(const neph_noise_texture *texture) {
  return texture ? (unsigned)texture->size : 0;
}

const float *neph_noise_texture_get_values(const neph_noise_texture *texture) {
  return texture ? texture->values : NULL;
}

/* Texels on both sides of a coordinate, and the fraction between them. */
typedef struct texel_axis {
  size_t low, high;
  float fraction;
} texel_axis;

static texel_axis compute_texels(const neph_noise_texture *texture, float x) {
  const float scaled = x * (float)texture->size;
  int32_t i = (int32_t)scaled;
  i -= scaled < (float)i;
  const uint32_t mask = (uint32_t)texture->size - 1;
  return (texel_axis){(uint32_t)i & mask, ((uint32_t)i + 1) & mask, scaled - (float)i};
}

float neph_noise_texture_sample(const neph_noise_texture *texture, float x, float y, float z) {
  if (!texture) return 0.0f;
  const texel_axis u = compute_texels(texture, x), v = compute_texels(texture, y), w = compute_texels(texture, z);
  const size_t size = (size_t)texture->size;
  const float *low = texture->values + w.low * size * size, *high = texture->values + w.high * size * size;
  const float *ll = low + v.low * size, *lh = low + v.high * size;
  const float *hl = high + v.low * size, *hh = high + v.high * size;
  const float bottom =
      np_mixf(np_mixf(ll[u.low], ll[u.high], u.fraction), np_mixf(lh[u.low], lh[u.high], u.fraction), v.fraction);
  const float top =
      np_mixf(np_mixf(hl[u.low], hl[u.high], u.fraction), np_mixf(hh[u.low], hh[u.high], u.fraction), v.fraction);
  return np_mixf(bottom, top, w.fraction);
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "noise/noise_texture.h"

#include "core/alloc.h"

enum { SIZE_MAX_TEXELS = 128 };

typedef struct texture_kind {
  int32_t size, cells;
  np_noise_octaves octaves;
} texture_kind;

/* The finest octave keeps four texels a cell or more, so that trilinear look-ups follow it. */
static const texture_kind kinds[] = {
    [NP_NOISE_TEXTURE_BASE] = {128, 4, {4, 0.5f}}, [NP_NOISE_TEXTURE_DETAIL] = {32, 2, {3, 0.5f}}};

typedef struct texture_job {
  const np_noise_texture *texture;
  const np_noise_table *noise;
  np_noise_texture_kind kind;
  np_noise_lattice lattice;
} texture_job;

static void fill_row(const texture_job *job, size_t row) {
  const texture_kind *kind = &kinds[job->kind];
  const int32_t size = kind->size;
  const float cells_per_texel = (float)kind->cells / (float)size;
  float x[SIZE_MAX_TEXELS], y[SIZE_MAX_TEXELS], z[SIZE_MAX_TEXELS], *out = job->texture->values + row * (size_t)size;
  for (int32_t i = 0; i < size; i++) {
    x[i] = (float)i * cells_per_texel;
    y[i] = (float)(row % (size_t)size) * cells_per_texel;
    z[i] = (float)(row / (size_t)size) * cells_per_texel;
  }
  const np_noise_points points = {(size_t)size, x, y, z};
  if (job->kind == NP_NOISE_TEXTURE_BASE)
    job->noise->perlin_worley(&job->lattice, &kind->octaves, &points, out);
  else
    job->noise->worley_fbm(&job->lattice, &kind->octaves, &points, out);
}

static neph_result fill_rows(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  for (size_t row = begin; row < end; row++) fill_row(user, row);
  return NEPH_OK;
}

neph_result np_noise_texture_build(neph_context *context, np_noise_texture_kind kind, uint32_t seed,
                                   np_monitor *monitor, np_noise_texture *out_texture) {
  const int32_t size = kinds[kind].size, cells = kinds[kind].cells;
  const size_t row_count = (size_t)size * (size_t)size;
  *out_texture = (np_noise_texture){.context = context, .size = size};
  out_texture->values = np_alloc(context, row_count * (size_t)size, sizeof *out_texture->values);
  if (!out_texture->values) return NEPH_ERROR_OUT_OF_MEMORY;
  texture_job job = {out_texture, np_noise_get_table(context->isa), kind, {seed, {cells, cells, cells}}};
  neph_result result = np_parallel_for(context, monitor, row_count, 64, fill_rows, &job);
  if (result) np_noise_texture_clear(out_texture);
  return result;
}

void np_noise_texture_clear(np_noise_texture *texture) {
  if (texture->context) np_alloc_free(texture->context, texture->values);
  *texture = (np_noise_texture){0};
}

/* Texels on both sides of a coordinate, and the place between them. */
typedef struct texel_axis {
  size_t low, high;
  float fraction;
} texel_axis;

static texel_axis find_texels(const np_noise_texture *texture, float x) {
  const float scaled = x * (float)texture->size;
  int32_t i = (int32_t)scaled;
  i -= scaled < (float)i;
  const uint32_t mask = (uint32_t)texture->size - 1;
  return (texel_axis){(uint32_t)i & mask, ((uint32_t)i + 1) & mask, scaled - (float)i};
}

static float lerp(float a, float b, float t) { return a + t * (b - a); }

float np_noise_texture_sample(const np_noise_texture *texture, float x, float y, float z) {
  const texel_axis u = find_texels(texture, x), v = find_texels(texture, y), w = find_texels(texture, z);
  const size_t size = (size_t)texture->size;
  const float *low = texture->values + w.low * size * size, *high = texture->values + w.high * size * size;
  const float *ll = low + v.low * size, *lh = low + v.high * size;
  const float *hl = high + v.low * size, *hh = high + v.high * size;
  const float bottom =
      lerp(lerp(ll[u.low], ll[u.high], u.fraction), lerp(lh[u.low], lh[u.high], u.fraction), v.fraction);
  const float top = lerp(lerp(hl[u.low], hl[u.high], u.fraction), lerp(hh[u.low], hh[u.high], u.fraction), v.fraction);
  return lerp(bottom, top, w.fraction);
}

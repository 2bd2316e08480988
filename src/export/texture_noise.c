/* SPDX-License-Identifier: Apache-2.0 */
/* Noises that repeat: the cubes of nephos/noise_texture.h with their octaves beside them, curl, and blue noise. */
#include <nephos/noise_texture.h>

#include "core/parallel.h"
#include "export/texture_makers.h"
#include "integrate/blue_noise_table.h"
#include "noise/noise.h"

enum { CUBE_MAX = 128, OCTAVES = 3, CURL_SIZE = 32, CURL_CELLS = 4, ROWS_PER_PIECE = 8 };

static const uint64_t seed = 0;

/* Streams of the seed. neph_noise_texture uses the streams below. */
enum { STREAM_OCTAVE = 8, STREAM_CURL = 16 };

/* A cube of noise and its single octaves of billows 1 − F1². */
typedef struct cube {
  const np_texture_set *set;
  const np_noise_table *noise;
  const float *sum;     /* values of neph_noise_texture's cube */
  unsigned sum_channel; /* channel of `sum`; the octaves have the others, in order */
  int32_t size, cells;
  unsigned slice;
  float *out;
} cube;

static np_noise_lattice make_lattice(int32_t cells, uint32_t stream) {
  return (np_noise_lattice){np_noise_derive_seed(seed, stream), {cells, cells, cells}};
}

/* Positions of a row of texels, in cells. */
static np_noise_points place_row(int32_t size, int32_t cells, size_t y, size_t z, float at[3][CUBE_MAX]) {
  const float cells_per_texel = (float)cells / (float)size;
  for (int32_t i = 0; i < size; i++) {
    at[0][i] = (float)i * cells_per_texel;
    at[1][i] = (float)y * cells_per_texel;
    at[2][i] = (float)z * cells_per_texel;
  }
  return (np_noise_points){(size_t)size, at[0], at[1], at[2]};
}

static neph_result fill_rows(void *user, size_t begin, size_t end, unsigned thread) {
  static const np_noise_octaves single = {1, 1.0f};
  const cube *c = user;
  const size_t size = (size_t)c->size;
  float at[3][CUBE_MAX], values[CUBE_MAX];
  (void)thread;
  for (size_t y = begin; y < end; y++) {
    float *row = c->out + 4 * size * y;
    for (size_t x = 0; x < size; x++) row[4 * x + c->sum_channel] = c->sum[(c->slice * size + y) * size + x];
    for (unsigned k = 0; k < OCTAVES; k++) {
      const np_noise_lattice lattice = make_lattice(c->cells << k, STREAM_OCTAVE + k);
      const np_noise_points points = place_row(c->size, c->cells << k, y, c->slice, at);
      c->noise->worley_fbm(&lattice, &single, &points, values);
      for (size_t x = 0; x < size; x++) row[4 * x + (k + (k >= c->sum_channel))] = values[x];
    }
  }
  return NEPH_OK;
}

static neph_result fill_cube(void *user, unsigned slice, float *out_values) {
  cube *c = user;
  c->slice = slice;
  c->out = out_values;
  return np_parallel_for(c->set->context, c->set->monitor, (size_t)c->size, ROWS_PER_PIECE, fill_rows, c);
}

static neph_result fill_curl(void *user, unsigned slice, float *out_values) {
  const np_noise_table *noise = user;
  const np_noise_lattice lattice = make_lattice(CURL_CELLS, STREAM_CURL);
  float at[3][CUBE_MAX], values[3][CURL_SIZE];
  for (size_t y = 0; y < CURL_SIZE; y++) {
    const np_noise_points points = place_row(CURL_SIZE, CURL_CELLS, y, slice, at);
    noise->curl(&lattice, &points, values[0], values[1], values[2]);
    for (size_t x = 0; x < CURL_SIZE; x++)
      for (size_t a = 0; a < 4; a++) out_values[4 * (y * CURL_SIZE + x) + a] = a < 3 ? values[a][x] : 0.0f;
  }
  return NEPH_OK;
}

/* The highest eight bits of each rank. */
static neph_result fill_blue_noise(void *user, unsigned slice, float *out_values) {
  (void)user, (void)slice;
  for (size_t i = 0; i < NP_BLUE_NOISE_EDGE * NP_BLUE_NOISE_EDGE; i++)
    out_values[i] = (float)(np_blue_noise_ranks[i] >> 4) / 255.0f;
  return NEPH_OK;
}

#define OCTAVE(which, cells)                                                                                           \
  { "octave " which " alone: billows 1 − F1² of Worley noise, " cells " cells a side", "1", 1.0 }

/* Adds a cube with the library's noise in one channel. */
static neph_result add_cube(np_texture_set *set, neph_noise_texture_kind kind, cube *c, np_texture *texture) {
  neph_noise_texture *noise = NULL;
  neph_result result = set->desc->is_dry_run ? NEPH_OK : neph_noise_texture_create(set->context, kind, seed, &noise);
  if (result) return result;
  c->set = set;
  c->noise = np_noise_get_table(set->context->isa);
  c->sum = neph_noise_texture_get_values(noise);
  c->size = (int32_t)texture->size[0];
  texture->fill = fill_cube;
  texture->user = c;
  texture->dimensions = 3;
  texture->tiles = true;
  texture->texel = NP_TEXEL_RGBA8;
  result = np_texture_set_add(set, texture);
  neph_noise_texture_destroy(noise);
  return result;
}

static neph_result add_base(np_texture_set *set) {
  cube c = {.sum_channel = 0, .cells = 4};
  np_texture texture = {
      .name = "noise_base",
      .purpose = "shape of billows, of a few hundred metres",
      .mapping = "one period along each axis; let one period span 4 times the cloud's billow_m",
      .size = {128, 128, 128},
      .channels = {{"Perlin-Worley noise of 4 octaves, the first of 4 cells a side (neph_noise_texture, base, seed 0)",
                    "1", 1.0},
                   OCTAVE("1", "4"),
                   OCTAVE("2", "8"),
                   OCTAVE("3", "16")}};
  return add_cube(set, NEPH_NOISE_TEXTURE_BASE, &c, &texture);
}

static neph_result add_detail(np_texture_set *set) {
  cube c = {.sum_channel = 3, .cells = 2};
  np_texture texture = {
      .name = "noise_detail",
      .purpose = "erosion of edges, of some tens of metres",
      .mapping = "one period along each axis; let one period span 2 × 0.46 times the cloud's billow_m",
      .size = {32, 32, 32},
      .channels = {
          OCTAVE("1", "2"),
          OCTAVE("2", "4"),
          OCTAVE("3", "8"),
          {"sum of 3 octaves of billows, the first of 2 cells a side (neph_noise_texture, detail, seed 0)", "1", 1.0}}};
  return add_cube(set, NEPH_NOISE_TEXTURE_DETAIL, &c, &texture);
}

static neph_result add_curl(np_texture_set *set) {
  const np_texture texture = {.name = "noise_curl",
                              .purpose = "displacement of the detail's coordinates along eddies, without divergence",
                              .mapping = "one period along each axis, of 4 cells",
                              .texel = NP_TEXEL_RGBA16F,
                              .dimensions = 3,
                              .size = {CURL_SIZE, CURL_SIZE, CURL_SIZE},
                              .tiles = true,
                              .channels = {{"x component, root mean square near 1", "1", 1.0},
                                           {"y component, root mean square near 1", "1", 1.0},
                                           {"z component, root mean square near 1", "1", 1.0},
                                           {"unused, 0", "1", 1.0}},
                              .fill = fill_curl,
                              .user = (void *)(uintptr_t)np_noise_get_table(set->context->isa)};
  return np_texture_set_add(set, &texture);
}

static neph_result add_blue_noise(np_texture_set *set) {
  const np_texture texture = {
      .name = "blue_noise",
      .purpose = "offsets of the first step of rays, so that banding becomes noise of high frequency",
      .mapping = "one texel a pixel, without filtering; add 0.618 times the frame's number and take the fraction",
      .texel = NP_TEXEL_R8,
      .dimensions = 2,
      .size = {NP_BLUE_NOISE_EDGE, NP_BLUE_NOISE_EDGE, 1},
      .tiles = true,
      .channels = {{"rank by void-and-cluster, each of 256 values as often as any other", "1", 1.0}},
      .fill = fill_blue_noise};
  return np_texture_set_add(set, &texture);
}

neph_result np_texture_noise_add(np_texture_set *set, const np_texture_scene *of) {
  (void)of;
  np_monitor_set_stage(set->monitor, "noise textures");
  neph_result result = add_base(set);
  if (!result) result = add_detail(set);
  if (!result) result = add_curl(set);
  return result ? result : add_blue_noise(set);
}

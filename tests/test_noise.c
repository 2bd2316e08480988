/* SPDX-License-Identifier: Apache-2.0 */
#include "test_support.h"

#include <stdlib.h>

#include <nephos/noise_texture.h>

#include "core/random.h"
#include "core/units.h"
#include "noise/noise.h"

enum { COUNT = 4096, CHANNELS = 3 };

static const np_noise_lattice tile = {.seed = 17, .period = {3, 5, 7}};
static const np_noise_lattice endless = {.seed = 17, .period = {65536, 65536, 65536}};
static const np_noise_octaves four_octaves = {.count = 4, .gain = 0.5f};

typedef enum noise_kind {
  VALUE,
  VALUE_FBM,
  PERLIN,
  PERLIN_FBM,
  WORLEY,
  WORLEY_FBM,
  PERLIN_WORLEY,
  CURL,
  SWIRL,
  KIND_COUNT
} noise_kind;

typedef struct points {
  float x[COUNT], y[COUNT], z[COUNT];
} points;

static np_noise_points view_points(const points *p) { return (np_noise_points){COUNT, p->x, p->y, p->z}; }

static void eval(neph_isa isa, noise_kind kind, const np_noise_lattice *lattice, const points *p,
                 float out[CHANNELS][COUNT]) {
  const np_noise_table *table = np_noise_get_table(isa);
  const np_noise_points view = view_points(p);
  memset(out, 0, sizeof(float) * CHANNELS * COUNT);
  switch (kind) {
  case VALUE:
    table->value(lattice, &view, out[0]);
    break;
  case VALUE_FBM:
    table->value_fbm(lattice, &four_octaves, &view, out[0]);
    break;
  case PERLIN:
    table->perlin(lattice, &view, out[0]);
    break;
  case PERLIN_FBM:
    table->perlin_fbm(lattice, &four_octaves, &view, out[0]);
    break;
  case WORLEY:
    table->worley(lattice, &view, out[0]);
    break;
  case WORLEY_FBM:
    table->worley_fbm(lattice, &four_octaves, &view, out[0]);
    break;
  case PERLIN_WORLEY:
    table->perlin_worley(lattice, &four_octaves, &view, out[0]);
    break;
  case CURL:
    table->curl(lattice, &view, out[0], out[1], out[2]);
    break;
  case SWIRL:
    table->swirl(lattice, &view, out[0], out[1]);
    break;
  case KIND_COUNT:
    break;
  }
}

/* Positions in multiples of 2⁻⁸, which stay exact when a tile's period is added: the noise itself must not round. */
static float draw_coordinate(np_random *random, float size) {
  return floorf((np_random_float(random) - 0.5f) * size * 256.0f) / 256.0f;
}

static void draw_points(uint64_t seed, float size, points *out) {
  np_random random = np_random_start(seed, 0, 0, 0, 0);
  for (int i = 0; i < COUNT; i++) {
    out->x[i] = draw_coordinate(&random, size);
    out->y[i] = draw_coordinate(&random, size);
    out->z[i] = draw_coordinate(&random, size);
  }
}

typedef struct statistics {
  double min, max, mean, deviation;
} statistics;

/* Over 2²⁰ positions in 4000 cells a side, all channels together. */
static statistics gather_statistics(noise_kind kind, uint32_t seed) {
  static points p;
  static float values[CHANNELS][COUNT];
  np_noise_lattice lattice = endless;
  lattice.seed = seed;
  statistics s = {.min = INFINITY, .max = -INFINITY};
  double sum = 0, sum2 = 0, count = 0;
  const int channels = kind == CURL ? 3 : kind == SWIRL ? 2 : 1;
  for (unsigned run = 0; run < 256; run++) {
    draw_points(run, 4000.0f, &p);
    eval(np_isa_detect(), kind, &lattice, &p, values);
    for (int c = 0; c < channels; c++)
      for (int i = 0; i < COUNT; i++) {
        double v = values[c][i];
        s.min = fmin(s.min, v);
        s.max = fmax(s.max, v);
        sum += v;
        sum2 += v * v;
        count++;
      }
  }
  s.mean = sum / count;
  s.deviation = sqrt(sum2 / count - s.mean * s.mean);
  return s;
}

/* Promises of noise.h. Tolerances: a mean of 2²⁰ values has a standard error of 1e-3 deviations, so 0.005 deviations
 * is five of them; the documented figures are rounded to a hundredth, which adds 0.005. */
static void assert_statistics(noise_kind kind, double min, double max, double mean, double deviation) {
  for (uint32_t seed = 0; seed < 3; seed++) {
    statistics s = gather_statistics(kind, seed * 0x10001u);
    assert_true(s.min >= min && s.max <= max);
    assert_near(s.mean, mean, 0.005 + 0.005 * deviation);
    assert_near(s.deviation, deviation, 0.005 + 0.01 * deviation);
  }
}

static void ranges_and_moments_are_as_documented_for_any_seed(void **state) {
  (void)state;
  assert_statistics(VALUE, 0, 1, 0.5, 0.20);
  assert_statistics(PERLIN, -1, 1, 0, 0.17);
  assert_statistics(PERLIN_FBM, -1, 1, 0, 0.104);
  assert_statistics(WORLEY, 0, 1, 0.30, 0.18);
  assert_statistics(WORLEY_FBM, 0, 1, 0.70, 0.111);
  assert_statistics(PERLIN_WORLEY, 0, 1, 0.85, 0.059);
}

static void curl_has_unit_components(void **state) {
  (void)state;
  for (noise_kind kind = CURL; kind <= SWIRL; kind++) {
    statistics s = gather_statistics(kind, 3);
    assert_near(s.mean, 0, 0.005);
    assert_near(s.deviation, 1, 0.02); /* the scale is rounded to a hundredth */
  }
}

static void assert_same_values(noise_kind kind, float a[CHANNELS][COUNT], float b[CHANNELS][COUNT]) {
  for (int c = 0; c < CHANNELS; c++)
    for (int i = 0; i < COUNT; i++)
      if (memcmp(&a[c][i], &b[c][i], sizeof(float)) != 0)
        fail_msg("noise %d, value %d: %.9g and %.9g", (int)kind, i, (double)a[c][i], (double)b[c][i]);
}

static void all_levels_give_the_same_bits(void **state) {
  (void)state;
  static points p;
  static float a[CHANNELS][COUNT], b[CHANNELS][COUNT];
  draw_points(1, 300.0f, &p);
  for (noise_kind kind = VALUE; kind < KIND_COUNT; kind++) {
    eval(NEPH_ISA_X86_64, kind, &tile, &p, a);
    for (neph_isa isa = NEPH_ISA_X86_64_V3; isa <= np_isa_detect(); isa++) {
      eval(isa, kind, &tile, &p, b);
      assert_same_values(kind, a, b);
    }
  }
}

/* A row of any length gives what single positions give. */
static void a_value_does_not_depend_on_its_neighbours(void **state) {
  (void)state;
  static points p;
  static float whole[CHANNELS][COUNT];
  draw_points(2, 300.0f, &p);
  eval(np_isa_detect(), PERLIN_WORLEY, &endless, &p, whole);
  for (size_t begin = 0, count = 1; begin + count <= COUNT; begin += count, count = count % 37 + 1) {
    float part[64];
    const np_noise_points view = {count, p.x + begin, p.y + begin, p.z + begin};
    np_noise_get_table(np_isa_detect())->perlin_worley(&endless, &four_octaves, &view, part);
    assert_memory_equal(part, whole[0] + begin, count * sizeof(float));
  }
}

static void tiles_meet_bit_for_bit(void **state) {
  (void)state;
  static points p, shifted;
  static float a[CHANNELS][COUNT], b[CHANNELS][COUNT];
  draw_points(3, 60.0f, &p);
  for (int i = 0; i < COUNT; i += 4) p.x[i] = 0, p.y[i + 1] = 0, p.z[i + 2] = 0; /* faces as well as the inside */
  for (int axis = 0; axis < 3; axis++)
    for (int turn = -2; turn <= 3; turn++) {
      shifted = p;
      float *coordinate = axis == 0 ? shifted.x : axis == 1 ? shifted.y : shifted.z;
      for (int i = 0; i < COUNT; i++) coordinate[i] += (float)(turn * tile.period[axis]);
      for (noise_kind kind = VALUE; kind < KIND_COUNT; kind++) {
        eval(np_isa_detect(), kind, &tile, &p, a);
        eval(np_isa_detect(), kind, &tile, &shifted, b);
        assert_same_values(kind, a, b);
      }
    }
}

/* One scalar lattice written the plain way, to compare with. */
static uint32_t scatter(uint32_t h) {
  h = (h ^ h >> 15) * 0x2c1b3c6du;
  return h ^ h >> 14;
}

static uint32_t hash_lattice(uint32_t seed, const int64_t cell[3], const int32_t period[3]) {
  static const uint32_t steps[3] = {0x9e3779b1u, 0x85ebca6bu, 0xc2b2ae35u};
  uint32_t h = scatter(seed) * 0x297a2d39u;
  for (int i = 0; i < 3; i++) h += (uint32_t)((cell[i] % period[i] + period[i]) % period[i]) * steps[i];
  return scatter(h);
}

/* Three numbers in [1, 2) from one hash. */
static void split_hash(uint32_t hash, float out[3]) {
  const uint32_t bits[3] = {hash >> 9, hash & 0x7fffffu, hash << 10 & 0x7fffffu};
  for (int i = 0; i < 3; i++) out[i] = 1.0f + (float)bits[i] * 0x1p-23f;
}

/* In float and in the order of the definition, Σ (corner − position + place)²: exactly what the kernels must give. */
static float reference_worley(const np_noise_lattice *lattice, const float p[3]) {
  float best = 1;
  for (int k = 0; k < 27; k++) {
    const int side[3] = {k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1};
    int64_t cell[3];
    float place[3], squared = 0;
    for (int i = 0; i < 3; i++) cell[i] = (int64_t)floorf(p[i]) + side[i];
    split_hash(hash_lattice(lattice->seed, cell, lattice->period), place);
    for (int i = 0; i < 3; i++) {
      const float d = -1.0f - (p[i] - floorf(p[i])) + (float)side[i] + place[i];
      squared += d * d;
    }
    best = fminf(best, squared);
  }
  return best;
}

static double fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }

/* Bits `first`, counted from the highest, and those after it, up to 23: a number in [0, 1). */
static double take_bits(uint32_t hash, int first) { return (hash << first >> 9) * 0x1p-23; }

/* Volume of the ball of radius 1.15. */
static void reference_gradient(uint32_t hash, double out[3]) {
  const double radius = 1.15 * fmax(take_bits(hash, 0), fmax(take_bits(hash, 6), take_bits(hash, 12)));
  const double height = 2 * take_bits(hash, 18) - 1, across = radius * sqrt(1 - height * height);
  const double angle = 0.5 * NP_PI * (take_bits(hash & ~3u, 25) + 1.0 / 64);
  out[0] = across * sin(angle) * (hash & 1 ? -1 : 1);
  out[1] = across * cos(angle) * (hash & 2 ? -1 : 1);
  out[2] = radius * height;
}

static double reference_perlin(const np_noise_lattice *lattice, const float p[3]) {
  double sum = 0;
  for (int corner = 0; corner < 8; corner++) {
    int64_t cell[3];
    double weight = 1, offset[3], gradient[3];
    for (int i = 0; i < 3; i++) {
      int side = corner >> i & 1;
      cell[i] = (int64_t)floorf(p[i]) + side;
      offset[i] = (double)p[i] - (double)cell[i];
      weight *= fade(1 - fabs(offset[i]));
    }
    reference_gradient(hash_lattice(lattice->seed, cell, lattice->period), gradient);
    for (int i = 0; i < 3; i++) sum += weight * gradient[i] * offset[i];
  }
  return sum;
}

static void noise_agrees_with_the_plain_way(void **state) {
  (void)state;
  static points p;
  static float worley[CHANNELS][COUNT], perlin[CHANNELS][COUNT];
  draw_points(4, 90.0f, &p);
  eval(np_isa_detect(), WORLEY, &tile, &p, worley);
  eval(np_isa_detect(), PERLIN, &tile, &p, perlin);
  for (int i = 0; i < COUNT; i++) {
    const float position[3] = {p.x[i], p.y[i], p.z[i]};
    if (worley[0][i] != reference_worley(&tile, position)) fail_msg("position %d", i);
    /* the azimuth's polynomial errs by 1.2e-4 of gradients of up to 1.15 */
    assert_near(perlin[0][i], reference_perlin(&tile, position), 1.5e-4);
  }
}

/* Gradients in units of the ball's radius, from the noise a short way off lattice points, where it is linear to 10 h².
 */
static void gather_gradients(float out[CHANNELS][COUNT]) {
  static points p;
  static float noise[CHANNELS][COUNT];
  const float h = 1.0f / 256.0f;
  for (int axis = 0; axis < 3; axis++) {
    for (int i = 0; i < COUNT; i++) {
      p.x[i] = (float)(i % 16) + (axis == 0 ? h : 0);
      p.y[i] = (float)(i / 16 % 16) + (axis == 1 ? h : 0);
      p.z[i] = (float)(i / 256) + (axis == 2 ? h : 0);
    }
    eval(np_isa_detect(), PERLIN, &endless, &p, noise);
    for (int i = 0; i < COUNT; i++) out[axis][i] = noise[0][i] / (1.15f * h);
  }
}

static double compute_moment(float gradients[CHANNELS][COUNT], int powers_x, int powers_y, int powers_z) {
  double sum = 0;
  for (int i = 0; i < COUNT; i++)
    sum += pow((double)gradients[0][i], powers_x) * pow((double)gradients[1][i], powers_y) *
           pow((double)gradients[2][i], powers_z);
  return sum / COUNT;
}

static int compare_doubles(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* In a ball the cube of the distance from the centre is uniform, the mean square of a component 1/5, and the fourth
 * moments, which distinguish a ball from a cube, 3/35 and 1/35. Tolerances: 1.95/√N is the Kolmogorov distance that N
 * samples exceed once in a thousand times; four standard errors of a moment, of which the largest deviation is 0.45. */
static void gradients_are_uniform_in_a_ball(void **state) {
  (void)state;
  static float g[CHANNELS][COUNT];
  static double volume[COUNT];
  gather_gradients(g);
  for (int i = 0; i < COUNT; i++) {
    const double x = (double)g[0][i], y = (double)g[1][i], z = (double)g[2][i], squared = x * x + y * y + z * z;
    volume[i] = squared * sqrt(squared);
    assert_true(squared < 1.001);
  }
  qsort(volume, COUNT, sizeof *volume, compare_doubles);
  for (int i = 0; i < COUNT; i++) assert_near(volume[i], (i + 0.5) / COUNT, 1.95 / sqrt(COUNT));
  const double tolerance = 4 * 0.45 / sqrt(COUNT);
  for (int axis = 0; axis < 3; axis++) {
    const int x = axis == 0, y = axis == 1, z = axis == 2;
    assert_near(compute_moment(g, x, y, z), 0, tolerance);
    assert_near(compute_moment(g, 1 - x, 1 - y, 1 - z), 0, tolerance);
    assert_near(compute_moment(g, 2 * x, 2 * y, 2 * z), 1.0 / 5, 0.5 * tolerance);
    assert_near(compute_moment(g, 4 * x, 4 * y, 4 * z), 3.0 / 35, 0.4 * tolerance);
    assert_near(compute_moment(g, 2 - 2 * x, 2 - 2 * y, 2 - 2 * z), 1.0 / 35, 0.15 * tolerance);
  }
}

/* Across a cell's face the slope must not jump: a difference quotient taken on both sides agrees to the change that a
 * bounded second derivative allows, |f″|·h, with |f″| ≤ 40 for a quintic between slopes of at most 2. */
static void slopes_are_continuous_across_cells(void **state) {
  (void)state;
  static points low, middle, high;
  static float a[CHANNELS][COUNT], b[CHANNELS][COUNT], c[CHANNELS][COUNT];
  const float h = 1.0f / 256.0f;
  draw_points(5, 90.0f, &middle);
  for (int axis = 0; axis < 3; axis++) {
    points *all[3] = {&low, &middle, &high};
    float *coordinate = axis == 0 ? middle.x : axis == 1 ? middle.y : middle.z;
    for (int i = 0; i < COUNT; i++) coordinate[i] = roundf(coordinate[i]);
    low = high = middle;
    for (int side = -1; side <= 1; side += 2) {
      points *moved = all[side + 1];
      coordinate = axis == 0 ? moved->x : axis == 1 ? moved->y : moved->z;
      for (int i = 0; i < COUNT; i++) coordinate[i] += (float)side * h;
    }
    for (int k = 0; k < 2; k++) {
      noise_kind kind = k == 0 ? PERLIN : VALUE;
      eval(np_isa_detect(), kind, &endless, &low, a);
      eval(np_isa_detect(), kind, &endless, &middle, b);
      eval(np_isa_detect(), kind, &endless, &high, c);
      for (int i = 0; i < COUNT; i++) assert_near((c[0][i] - b[0][i]) / h, (b[0][i] - a[0][i]) / h, 40.0 * (double)h);
    }
  }
}

static double compute_divergence(noise_kind kind, const points *p, int axis_count, double h) {
  static points moved;
  static float field[2][CHANNELS][COUNT], divergence[COUNT];
  memset(divergence, 0, sizeof divergence);
  for (int axis = 0; axis < axis_count; axis++) {
    for (int side = 0; side < 2; side++) {
      moved = *p;
      float *coordinate = axis == 0 ? moved.x : axis == 1 ? moved.y : moved.z;
      for (int i = 0; i < COUNT; i++) coordinate[i] += (float)(side ? h : -h);
      eval(np_isa_detect(), kind, &endless, &moved, field[side]);
    }
    for (int i = 0; i < COUNT; i++) divergence[i] += (field[1][axis][i] - field[0][axis][i]) / (float)(2 * h);
  }
  double sum = 0;
  for (int i = 0; i < COUNT; i++) sum += (double)divergence[i] * (double)divergence[i];
  return sqrt(sum / COUNT);
}

/* Central differences err by h²/6 of a third derivative, about 30 here, and by float rounding, 1e-6/h: 5e-4 together at
 * h = 2⁻⁷. One term of the sum alone is of the order of 5. */
static void curl_has_no_divergence(void **state) {
  (void)state;
  static points p;
  draw_points(6, 90.0f, &p);
  for (noise_kind kind = CURL; kind <= SWIRL; kind++) {
    const int axis_count = kind == CURL ? 3 : 2;
    double whole = compute_divergence(kind, &p, axis_count, 0x1p-7), part = compute_divergence(kind, &p, 1, 0x1p-7);
    assert_true(part > 1.0);
    assert_true(whole < 2e-3 * part);
  }
}

/* Mean squared difference at a distance: the same along an axis as along the diagonals of face and body, to the 5 % by
 * which the lattice itself is not round (gradients along axes alone would give 40 %). */
static double compute_variogram(const points *p, double dx, double dy, double dz) {
  static points moved;
  static float a[CHANNELS][COUNT], b[CHANNELS][COUNT];
  double length = sqrt(dx * dx + dy * dy + dz * dz), sum = 0;
  moved = *p;
  for (int i = 0; i < COUNT; i++) {
    moved.x[i] += (float)(0.1 * dx / length);
    moved.y[i] += (float)(0.1 * dy / length);
    moved.z[i] += (float)(0.1 * dz / length);
  }
  eval(np_isa_detect(), PERLIN, &endless, p, a);
  eval(np_isa_detect(), PERLIN, &endless, &moved, b);
  for (int i = 0; i < COUNT; i++) sum += pow((double)(a[0][i] - b[0][i]), 2);
  return sum / COUNT;
}

static void perlin_noise_prefers_no_direction(void **state) {
  (void)state;
  static points p;
  double axis = 0, face = 0, body = 0;
  for (uint64_t run = 0; run < 16; run++) {
    draw_points(100 + run, 4000.0f, &p);
    axis += compute_variogram(&p, 1, 0, 0) + compute_variogram(&p, 0, 1, 0) + compute_variogram(&p, 0, 0, 1);
    face += compute_variogram(&p, 1, 1, 0) + compute_variogram(&p, 0, 1, -1) + compute_variogram(&p, -1, 0, 1);
    body += compute_variogram(&p, 1, 1, 1) + compute_variogram(&p, 1, -1, 1) + compute_variogram(&p, -1, 1, 1);
  }
  assert_near_relative(face, axis, 0.05);
  assert_near_relative(body, axis, 0.05);
}

/* Two seeds, or two streams of one: no correlation beyond 5/√N of N positions. */
static void seeds_give_independent_noise(void **state) {
  (void)state;
  static points p;
  static float a[CHANNELS][COUNT], b[CHANNELS][COUNT];
  draw_points(7, 4000.0f, &p);
  np_noise_lattice first = endless, second = endless;
  first.seed = np_noise_derive_seed(1, 0);
  const uint32_t others[] = {np_noise_derive_seed(1, 1), np_noise_derive_seed(2, 0), first.seed + 1};
  eval(np_isa_detect(), PERLIN, &first, &p, a);
  for (size_t k = 0; k < sizeof others / sizeof *others; k++) {
    second.seed = others[k];
    eval(np_isa_detect(), PERLIN, &second, &p, b);
    double ab = 0, aa = 0, bb = 0;
    for (int i = 0; i < COUNT; i++) {
      ab += (double)a[0][i] * (double)b[0][i];
      aa += (double)a[0][i] * (double)a[0][i];
      bb += (double)b[0][i] * (double)b[0][i];
    }
    assert_near(ab / sqrt(aa * bb), 0, 5.0 / sqrt(COUNT));
  }
}

/* ---- Textures ---- */

typedef float (*sample_fn)(const neph_noise_texture *texture, float x, float y, float z);

/* Both sides of every face: what a texture holds at 0 is what it holds at 1, bit for bit, and a step across a face is
 * no larger than the largest step inside. */
static void assert_seamless(const neph_noise_texture *t) {
  const sample_fn at = neph_noise_texture_sample;
  const int n = (int)neph_noise_texture_get_size(t);
  const float h = 1.0f / (float)n;
  float inside = 0, across = 0;
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      const float a = (float)i * h, b = ((float)j + 0.25f) * h;
      if (at(t, 0, a, b) != at(t, 1, a, b) || at(t, a, -1, b) != at(t, a, 2, b) || at(t, a, b, 0) != at(t, a, b, 1))
        fail_msg("faces differ at %d, %d", i, j);
      for (int k = -1; k < n - 1; k++) {
        const float c = (float)k * h;
        const float step =
            fmaxf(fabsf(at(t, c, a, b) - at(t, c + h, a, b)),
                  fmaxf(fabsf(at(t, a, c, b) - at(t, a, c + h, b)), fabsf(at(t, a, b, c) - at(t, a, b, c + h))));
        float *largest = k < 0 ? &across : &inside;
        *largest = fmaxf(*largest, step);
      }
    }
  assert_true(across <= inside);
  assert_true(inside > 0.01f);
}

static void textures_have_no_seam(void **state) {
  (void)state;
  neph_context *context = test_context_create(2, NULL);
  for (neph_noise_texture_kind kind = NEPH_NOISE_TEXTURE_BASE; kind <= NEPH_NOISE_TEXTURE_DETAIL; kind++) {
    neph_noise_texture *texture;
    assert_int_equal(neph_noise_texture_create(context, kind, 5, &texture), NEPH_OK);
    assert_int_equal(neph_noise_texture_get_size(texture), kind == NEPH_NOISE_TEXTURE_BASE ? 128 : 32);
    assert_seamless(texture);
    neph_noise_texture_destroy(texture);
  }
  neph_context_destroy(context);
}

/* A texel is the noise itself; between texels the look-up errs by what docs/results/bake.md states, rounded up. */
static void textures_are_the_noise_to_a_stated_error(void **state) {
  (void)state;
  static points p;
  static float noise[COUNT];
  static const double stated_rms[] = {0.002, 0.008};
  const np_noise_table *table = np_noise_get_table(np_isa_detect());
  const np_noise_octaves octaves[] = {{4, 0.5f}, {3, 0.5f}};
  neph_context *context = test_context_create(2, NULL);
  for (neph_noise_texture_kind kind = NEPH_NOISE_TEXTURE_BASE; kind <= NEPH_NOISE_TEXTURE_DETAIL; kind++) {
    neph_noise_texture *texture;
    const int32_t cells = kind == NEPH_NOISE_TEXTURE_BASE ? 4 : 2;
    const np_noise_lattice lattice = {np_noise_derive_seed(9, kind), {cells, cells, cells}};
    draw_points(8, (float)cells, &p);
    const np_noise_points view = view_points(&p);
    if (kind == NEPH_NOISE_TEXTURE_BASE)
      table->perlin_worley(&lattice, &octaves[kind], &view, noise);
    else
      table->worley_fbm(&lattice, &octaves[kind], &view, noise);
    assert_int_equal(neph_noise_texture_create(context, kind, 9, &texture), NEPH_OK);
    double squared = 0;
    const float scale = 1.0f / (float)cells;
    for (int i = 0; i < COUNT; i++) {
      const double d =
          (double)neph_noise_texture_sample(texture, p.x[i] * scale, p.y[i] * scale, p.z[i] * scale) - (double)noise[i];
      squared += d * d;
    }
    assert_true(sqrt(squared / COUNT) < stated_rms[kind]);
    const float origin = 0, *values = neph_noise_texture_get_values(texture);
    const np_noise_points first = {1, &origin, &origin, &origin};
    if (kind == NEPH_NOISE_TEXTURE_BASE)
      table->perlin_worley(&lattice, &octaves[kind], &first, noise);
    else
      table->worley_fbm(&lattice, &octaves[kind], &first, noise);
    assert_true(values[0] == noise[0]);
    neph_noise_texture_destroy(texture);
  }
  neph_context_destroy(context);
}

static void an_unknown_texture_is_refused(void **state) {
  (void)state;
  test_log log;
  test_log_start(&log);
  neph_context *context = test_context_create(1, &log);
  neph_noise_texture *texture = (neph_noise_texture *)8; /* must be overwritten */
  assert_int_equal(neph_noise_texture_create(context, (neph_noise_texture_kind)2, 0, &texture),
                   NEPH_ERROR_INVALID_ARGUMENT);
  assert_null(texture);
  assert_one_error(&log, "noise texture: kind is 2, must be base (0) or detail (1)");
  neph_noise_texture_destroy(NULL);
  neph_context_destroy(context);
}

static neph_result build_detail(neph_context *context, void *user) {
  (void)user;
  neph_noise_texture *detail;
  neph_result result = neph_noise_texture_create(context, NEPH_NOISE_TEXTURE_DETAIL, 5, &detail);
  neph_noise_texture_destroy(detail);
  return result;
}

static void a_texture_survives_failed_allocations(void **state) {
  (void)state;
  assert_survives_failed_allocations(build_detail, NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(ranges_and_moments_are_as_documented_for_any_seed),
      cmocka_unit_test(curl_has_unit_components),
      cmocka_unit_test(all_levels_give_the_same_bits),
      cmocka_unit_test(a_value_does_not_depend_on_its_neighbours),
      cmocka_unit_test(tiles_meet_bit_for_bit),
      cmocka_unit_test(noise_agrees_with_the_plain_way),
      cmocka_unit_test(gradients_are_uniform_in_a_ball),
      cmocka_unit_test(slopes_are_continuous_across_cells),
      cmocka_unit_test(curl_has_no_divergence),
      cmocka_unit_test(perlin_noise_prefers_no_direction),
      cmocka_unit_test(seeds_give_independent_noise),
      cmocka_unit_test(textures_have_no_seam),
      cmocka_unit_test(textures_are_the_noise_to_a_stated_error),
      cmocka_unit_test(an_unknown_texture_is_refused),
      cmocka_unit_test(a_texture_survives_failed_allocations),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

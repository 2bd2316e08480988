/* SPDX-License-Identifier: Apache-2.0 */
/* Noise kernels; compiled once per instruction-set level, the same bits out of each.
 *
 * Perlin 2002, "Improving Noise" (quintic fade), with gradients uniform in a ball, so that no direction is preferred.
 * Worley 1996, "A Cellular Texture Basis Function" (F1 over 27 cells; a nearer point outside them is farther than 1,
 * where the distance is clipped, so nothing is ever missed). Perlin-Worley: Schneider and Vos 2015, "The Real-time
 * Volumetric Cloudscapes of Horizon: Zero Dawn". The divergence-free field is the bitangent noise of DeWolf 2005,
 * "Divergence-Free Noise".
 *
 * One lane is one position. The lanes' functions are inlined into `omp simd` loops; integer hashing leaves no table to
 * gather from.
 */
#include <math.h>

#include "noise/noise.h"

extern const np_noise_table NP_KERNEL(np_noise_kernels);

/* Inlined, since a loop is vectorized only if all functions that it calls are inside it. */
#define LANE static inline __attribute__((always_inline))

/* A lattice point is a number, the sum of a seed and its indices times three odd constants, so that corners share all
 * but an addition; distinct points within reach of each other are distinct numbers. One round of shift, multiplication
 * and shift then scatters them. */
static const uint32_t axis_steps[3] = {0x9e3779b1u, 0x85ebca6bu, 0xc2b2ae35u};

LANE uint32_t scatter(uint32_t point) {
  uint32_t hash = (point ^ point >> 15) * 0x2c1b3c6du;
  return hash ^ hash >> 14;
}

LANE int32_t floor_to_int(float x) {
  int32_t i = (int32_t)x;
  return i - (x < (float)i);
}

LANE int32_t wrap(int32_t i, int32_t period, float period_inverse) {
  int32_t r = i - floor_to_int((float)i * period_inverse) * period;
  r += r < 0 ? period : 0; /* the quotient may round across a multiple of the period, either way */
  return r - (r >= period ? period : 0);
}

LANE float fade(float t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); }
LANE float fade_slope(float t) { return 30.0f * t * t * (t * (t - 2.0f) + 1.0f); }
LANE float lerp(float a, float b, float t) { return a + t * (b - a); }
LANE float clip(float x, float low, float high) { return x < low ? low : x > high ? high : x; }

/* A lattice prepared for lanes: one octave's frequency, shift and reciprocals. */
typedef struct grid {
  uint32_t seed;
  int32_t period[3];
  float period_inverse[3];
  float frequency, shift;
  bool is_binary; /* periods are powers of two, which wrap with a mask */
} grid;

static bool is_power_of_two(int32_t n) { return (n & (n - 1)) == 0; }

/* Grid of an octave. Octaves are shifted, so that their lattices share no points; in 256ths, so that tiles still meet
 * exactly. */
static grid make_grid(const np_noise_lattice *lattice, unsigned octave) {
  grid g = {.seed = scatter(lattice->seed + octave * 0x85ebca6bu) * 0x297a2d39u,
            .frequency = (float)(1u << octave),
            .shift = (float)octave * (97.0f / 256.0f),
            .is_binary = true};
  for (int i = 0; i < 3; i++) {
    g.period[i] = lattice->period[i] << octave;
    g.period_inverse[i] = 1.0f / (float)g.period[i];
    g.is_binary = g.is_binary && is_power_of_two(g.period[i]);
  }
  return g;
}

/* A position's cell: what the low and the high lattice index, wrapped, and the one before them add to a lattice point's
 * number; and the fraction between low and high. */
typedef struct cell_axis {
  uint32_t previous, low, high;
  float fraction;
} cell_axis;

LANE cell_axis compute_cell(const grid *g, int axis, float x, bool is_binary) {
  const int32_t period = g->period[axis];
  const uint32_t step = axis_steps[axis], last = (uint32_t)(period - 1) * step;
  float scaled = x * g->frequency + g->shift;
  int32_t i = floor_to_int(scaled), index = is_binary ? i & (period - 1) : wrap(i, period, g->period_inverse[axis]);
  uint32_t low = (uint32_t)index * step;
  return (cell_axis){low == 0 ? last : low - step, low, low == last ? 0 : low + step, scaled - (float)i};
}

/* A bit pattern with the exponent of 1 is a number in [1, 2). A hash gives three of them, each led by bits of its own;
 * what follows those is far too small to be seen to agree. */
LANE float make_float(uint32_t bits) {
  union {
    uint32_t bits;
    float value;
  } number = {.bits = bits | 0x3f800000u};
  return number.value;
}

LANE float take_first(uint32_t hash) { return make_float(hash >> 9); }
LANE float take_second(uint32_t hash) { return make_float(hash & 0x7fffffu); }
LANE float take_third(uint32_t hash) { return make_float(hash << 10 & 0x7fffffu); }

/* A number from the bits from `first` on, counted from the highest. */
LANE float take_from(uint32_t hash, int first) {
  return make_float((first < 9 ? hash >> (9 - first) : hash << (first - 9)) & 0x7fffffu);
}

/* The quarter of a sine wave over u in [0, 1], to 1.2e-4: an odd polynomial that is 1 at 1. */
LANE float quarter_sine(float u) {
  float u2 = u * u;
  return u * (1.5706f + u2 * (-0.6428f + u2 * 0.0722f));
}

/* `sign` is 0 or the highest bit. */
LANE float flip(float x, uint32_t sign) {
  union {
    float value;
    uint32_t bits;
  } number = {.value = x};
  number.bits ^= sign;
  return number.value;
}

typedef struct gradient {
  float x, y, z, dot;
} gradient;

LANE float larger(float a, float b) { return a > b ? a : b; }

/* Uniform in the unit ball: the largest of three uniform numbers has the density 3r² of the distance from the centre,
 * and heights on a sphere are uniform (Archimedes). Of the hash's bits six lead each of the three numbers, seven the
 * height, five a quarter turn of azimuth, set half a step off its ends to be even; two choose the quarter. */
LANE gradient compute_gradient(uint32_t point, float dx, float dy, float dz) {
  uint32_t hash = scatter(point);
  float radius = larger(larger(take_from(hash, 0), take_from(hash, 6)), take_from(hash, 12)) - 1.0f;
  float height = 2.0f * take_from(hash, 18) - 3.0f, turn = take_from(hash & ~3u, 25) - (1.0f - 0x1p-6f);
  float across = radius * sqrtf(1.0f - height * height);
  gradient g = {flip(across * quarter_sine(turn), hash << 31),
                flip(across * quarter_sine(1.0f - turn), (hash & 2u) << 30), radius * height, 0};
  g.dot = g.x * dx + g.y * dy + g.z * dz;
  return g;
}

/* Length of gradients, at which noise stays within ±1: the bound Σ weight·|offset| is largest in the middle of a cell,
 * where it is √3/2. */
static const float gradient_length = 1.15f;

LANE float eval_perlin(const grid *g, float px, float py, float pz, bool is_binary) {
  cell_axis x = compute_cell(g, 0, px, is_binary), y = compute_cell(g, 1, py, is_binary),
            z = compute_cell(g, 2, pz, is_binary);
  float u = fade(x.fraction), v = fade(y.fraction), w = fade(z.fraction);
  float x0 = x.fraction, y0 = y.fraction, z0 = z.fraction, x1 = x0 - 1.0f, y1 = y0 - 1.0f, z1 = z0 - 1.0f;
  uint32_t p0 = g->seed + x.low, p1 = g->seed + x.high;
  uint32_t p00 = p0 + y.low, p01 = p0 + y.high, p10 = p1 + y.low, p11 = p1 + y.high;
  float n000 = compute_gradient(p00 + z.low, x0, y0, z0).dot, n001 = compute_gradient(p00 + z.high, x0, y0, z1).dot;
  float n010 = compute_gradient(p01 + z.low, x0, y1, z0).dot, n011 = compute_gradient(p01 + z.high, x0, y1, z1).dot;
  float n100 = compute_gradient(p10 + z.low, x1, y0, z0).dot, n101 = compute_gradient(p10 + z.high, x1, y0, z1).dot;
  float n110 = compute_gradient(p11 + z.low, x1, y1, z0).dot, n111 = compute_gradient(p11 + z.high, x1, y1, z1).dot;
  float low = lerp(lerp(n000, n001, w), lerp(n010, n011, w), v);
  float high = lerp(lerp(n100, n101, w), lerp(n110, n111, w), v);
  return lerp(low, high, u) * gradient_length;
}

LANE float value_at(uint32_t point) { return take_first(scatter(point)); }

LANE float eval_value(const grid *g, float px, float py, float pz, bool is_binary) {
  cell_axis x = compute_cell(g, 0, px, is_binary), y = compute_cell(g, 1, py, is_binary),
            z = compute_cell(g, 2, pz, is_binary);
  float u = fade(x.fraction), v = fade(y.fraction), w = fade(z.fraction);
  uint32_t p0 = g->seed + x.low, p1 = g->seed + x.high;
  uint32_t p00 = p0 + y.low, p01 = p0 + y.high, p10 = p1 + y.low, p11 = p1 + y.high;
  float n00 = lerp(value_at(p00 + z.low), value_at(p00 + z.high), w);
  float n01 = lerp(value_at(p01 + z.low), value_at(p01 + z.high), w);
  float n10 = lerp(value_at(p10 + z.low), value_at(p10 + z.high), w);
  float n11 = lerp(value_at(p11 + z.low), value_at(p11 + z.high), w);
  return clip(lerp(lerp(n00, n01, v), lerp(n10, n11, v), u) - 1.0f, 0.0f, 1.0f);
}

typedef struct slope {
  float x, y, z;
} slope;

LANE float blend(float n000, float n001, float n010, float n011, float n100, float n101, float n110, float n111,
                 float u, float v, float w) {
  return lerp(lerp(lerp(n000, n001, w), lerp(n010, n011, w), v), lerp(lerp(n100, n101, w), lerp(n110, n111, w), v), u);
}

/* ∇(Σ weight·dot) = Σ weight·gradient + Σ ∇weight·dot: exact, so that the cross product of two has no divergence. */
LANE slope eval_perlin_slope(const grid *g, float px, float py, float pz, bool is_binary) {
  cell_axis x = compute_cell(g, 0, px, is_binary), y = compute_cell(g, 1, py, is_binary),
            z = compute_cell(g, 2, pz, is_binary);
  float u = fade(x.fraction), v = fade(y.fraction), w = fade(z.fraction);
  float x0 = x.fraction, y0 = y.fraction, z0 = z.fraction, x1 = x0 - 1.0f, y1 = y0 - 1.0f, z1 = z0 - 1.0f;
  uint32_t p0 = g->seed + x.low, p1 = g->seed + x.high;
  uint32_t p00 = p0 + y.low, p01 = p0 + y.high, p10 = p1 + y.low, p11 = p1 + y.high;
  gradient a = compute_gradient(p00 + z.low, x0, y0, z0), b = compute_gradient(p00 + z.high, x0, y0, z1);
  gradient c = compute_gradient(p01 + z.low, x0, y1, z0), d = compute_gradient(p01 + z.high, x0, y1, z1);
  gradient e = compute_gradient(p10 + z.low, x1, y0, z0), f = compute_gradient(p10 + z.high, x1, y0, z1);
  gradient k = compute_gradient(p11 + z.low, x1, y1, z0), l = compute_gradient(p11 + z.high, x1, y1, z1);
  float along_x = lerp(lerp(e.dot - a.dot, f.dot - b.dot, w), lerp(k.dot - c.dot, l.dot - d.dot, w), v);
  float along_y = lerp(lerp(c.dot - a.dot, d.dot - b.dot, w), lerp(k.dot - e.dot, l.dot - f.dot, w), u);
  float along_z = lerp(lerp(b.dot - a.dot, d.dot - c.dot, v), lerp(f.dot - e.dot, l.dot - k.dot, v), u);
  float mean_x = blend(a.x, b.x, c.x, d.x, e.x, f.x, k.x, l.x, u, v, w);
  float mean_y = blend(a.y, b.y, c.y, d.y, e.y, f.y, k.y, l.y, u, v, w);
  float mean_z = blend(a.z, b.z, c.z, d.z, e.z, f.z, k.z, l.z, u, v, w);
  float slope_x = fade_slope(x.fraction), slope_y = fade_slope(y.fraction), slope_z = fade_slope(z.fraction);
  return (slope){(mean_x + slope_x * along_x) * gradient_length, (mean_y + slope_y * along_y) * gradient_length,
                 (mean_z + slope_z * along_z) * gradient_length};
}

/* Squared distance to the point of a cell, whose corner's offset, less 1, is given. */
LANE float distance_squared(uint32_t point, float dx, float dy, float dz) {
  uint32_t hash = scatter(point);
  float x = dx + take_first(hash), y = dy + take_second(hash), z = dz + take_third(hash);
  return x * x + y * y + z * z;
}

LANE float nearer(float a, float b) { return a < b ? a : b; }

/* Least distance in the three cells along z of one column. */
LANE float search_column(uint32_t point, cell_axis z, float dx, float dy, float dz, float best) {
  best = nearer(best, distance_squared(point + z.previous, dx, dy, dz - 1.0f));
  best = nearer(best, distance_squared(point + z.low, dx, dy, dz));
  return nearer(best, distance_squared(point + z.high, dx, dy, dz + 1.0f));
}

/* Least distance in the nine cells of one sheet across x. */
LANE float search_sheet(uint32_t point, cell_axis y, cell_axis z, float dx, float dy, float dz, float best) {
  best = search_column(point + y.previous, z, dx, dy - 1.0f, dz, best);
  best = search_column(point + y.low, z, dx, dy, dz, best);
  return search_column(point + y.high, z, dx, dy + 1.0f, dz, best);
}

LANE float eval_worley(const grid *g, float px, float py, float pz, bool is_binary) {
  cell_axis x = compute_cell(g, 0, px, is_binary), y = compute_cell(g, 1, py, is_binary),
            z = compute_cell(g, 2, pz, is_binary);
  float dx = -1.0f - x.fraction, dy = -1.0f - y.fraction, dz = -1.0f - z.fraction, best = 1.0f;
  best = search_sheet(g->seed + x.previous, y, z, dx - 1.0f, dy, dz, best);
  best = search_sheet(g->seed + x.low, y, z, dx, dy, dz, best);
  return search_sheet(g->seed + x.high, y, z, dx + 1.0f, dy, dz, best);
}

typedef float (*eval_fn)(const grid *g, float px, float py, float pz, bool is_binary);

/* out += amplitude · noise. Inlined with `eval` known, so that the loop becomes vectors. */
LANE void add_lanes(const grid *g, eval_fn eval, float amplitude, const np_noise_points *points, float *out,
                    bool is_binary) {
  const float *x = points->x, *y = points->y, *z = points->z;
#pragma omp simd
  for (size_t i = 0; i < points->count; i++) out[i] += amplitude * eval(g, x[i], y[i], z[i], is_binary);
}

LANE void add_octave(const np_noise_lattice *lattice, unsigned octave, eval_fn eval, float amplitude,
                     const np_noise_points *points, float *out) {
  const grid g = make_grid(lattice, octave);
  if (g.is_binary)
    add_lanes(&g, eval, amplitude, points, out, true);
  else
    add_lanes(&g, eval, amplitude, points, out, false);
}

static void add_perlin(const np_noise_lattice *lattice, unsigned octave, float amplitude, const np_noise_points *points,
                       float *out) {
  add_octave(lattice, octave, eval_perlin, amplitude, points, out);
}

static void add_worley(const np_noise_lattice *lattice, unsigned octave, float amplitude, const np_noise_points *points,
                       float *out) {
  add_octave(lattice, octave, eval_worley, amplitude, points, out);
}

static void add_value(const np_noise_lattice *lattice, unsigned octave, float amplitude, const np_noise_points *points,
                      float *out) {
  add_octave(lattice, octave, eval_value, amplitude, points, out);
}

static void set_all(float *out, size_t count, float value) {
  for (size_t i = 0; i < count; i++) out[i] = value;
}

static void fill_value(const np_noise_lattice *lattice, const np_noise_points *points, float *out) {
  set_all(out, points->count, 0.0f);
  add_value(lattice, 0, 1.0f, points, out);
}

static void fill_perlin(const np_noise_lattice *lattice, const np_noise_points *points, float *out) {
  set_all(out, points->count, 0.0f);
  add_perlin(lattice, 0, 1.0f, points, out);
}

static void fill_worley(const np_noise_lattice *lattice, const np_noise_points *points, float *out) {
  set_all(out, points->count, 0.0f);
  add_worley(lattice, 0, 1.0f, points, out);
}

/* Amplitude of each octave, adding up to 1. */
static void compute_amplitudes(const np_noise_octaves *octaves, float out_amplitudes[NP_NOISE_OCTAVES_MAX]) {
  float amplitude = 1.0f, sum = 0.0f;
  for (unsigned k = 0; k < octaves->count; k++, amplitude *= octaves->gain) sum += amplitude;
  amplitude = 1.0f / sum;
  for (unsigned k = 0; k < octaves->count; k++, amplitude *= octaves->gain) out_amplitudes[k] = amplitude;
}

typedef void (*add_fn)(const np_noise_lattice *lattice, unsigned octave, float amplitude, const np_noise_points *points,
                       float *out);

/* start + sign · Σ amplitude · noise, held to [low, 1]. */
static void fill_octaves(const np_noise_lattice *lattice, const np_noise_octaves *octaves, add_fn add, float start,
                         float sign, float low, const np_noise_points *points, float *out) {
  float amplitudes[NP_NOISE_OCTAVES_MAX];
  compute_amplitudes(octaves, amplitudes);
  set_all(out, points->count, start);
  for (unsigned k = 0; k < octaves->count; k++) add(lattice, k, sign * amplitudes[k], points, out);
  for (size_t i = 0; i < points->count; i++) out[i] = clip(out[i], low, 1.0f);
}

static void fill_value_fbm(const np_noise_lattice *lattice, const np_noise_octaves *octaves,
                           const np_noise_points *points, float *out) {
  fill_octaves(lattice, octaves, add_value, 0.0f, 1.0f, 0.0f, points, out);
}

static void fill_perlin_fbm(const np_noise_lattice *lattice, const np_noise_octaves *octaves,
                            const np_noise_points *points, float *out) {
  fill_octaves(lattice, octaves, add_perlin, 0.0f, 1.0f, -1.0f, points, out);
}

static void fill_worley_fbm(const np_noise_lattice *lattice, const np_noise_octaves *octaves,
                            const np_noise_points *points, float *out) {
  fill_octaves(lattice, octaves, add_worley, 1.0f, -1.0f, 0.0f, points, out);
}

/* Scratch lives on the stack in blocks. */
enum { BLOCK = 256 };

static np_noise_points take_block(const np_noise_points *points, size_t begin) {
  size_t rest = points->count - begin;
  return (np_noise_points){rest < BLOCK ? rest : BLOCK, points->x + begin, points->y + begin, points->z + begin};
}

static void fill_perlin_worley(const np_noise_lattice *lattice, const np_noise_octaves *octaves,
                               const np_noise_points *points, float *out) {
  float perlin[BLOCK];
  for (size_t begin = 0; begin < points->count; begin += BLOCK) {
    const np_noise_points block = take_block(points, begin);
    float *billows = out + begin;
    fill_perlin_fbm(lattice, octaves, &block, perlin);
    fill_worley_fbm(lattice, octaves, &block, billows);
    for (size_t i = 0; i < block.count; i++)
      billows[i] = clip(lerp(billows[i], 1.0f, 0.5f + 0.5f * perlin[i]), 0.0f, 1.0f);
  }
}

/* Scale of the cross product of two potentials' slopes to a root mean square of 1 per component. */
static const float curl_scale = 3.60f;

LANE void fill_slope_lanes(const grid *g, const np_noise_points *points, float *out_x, float *out_y, float *out_z,
                           bool is_binary) {
  const float *x = points->x, *y = points->y, *z = points->z;
#pragma omp simd
  for (size_t i = 0; i < points->count; i++) {
    slope s = eval_perlin_slope(g, x[i], y[i], z[i], is_binary);
    out_x[i] = s.x;
    out_y[i] = s.y;
    out_z[i] = s.z;
  }
}

static void fill_slope(const grid *g, const np_noise_points *points, float *out_x, float *out_y, float *out_z) {
  if (g->is_binary)
    fill_slope_lanes(g, points, out_x, out_y, out_z, true);
  else
    fill_slope_lanes(g, points, out_x, out_y, out_z, false);
}

static void fill_curl(const np_noise_lattice *lattice, const np_noise_points *points, float *out_x, float *out_y,
                      float *out_z) {
  const grid first = make_grid(lattice, 0);
  grid second = first;
  second.seed ^= 0xc2b2ae35u;
  second.shift = 0.5f;
  float x[BLOCK], y[BLOCK], z[BLOCK];
  for (size_t begin = 0; begin < points->count; begin += BLOCK) {
    const np_noise_points block = take_block(points, begin);
    float *ax = out_x + begin, *ay = out_y + begin, *az = out_z + begin;
    fill_slope(&first, &block, ax, ay, az);
    fill_slope(&second, &block, x, y, z);
    for (size_t i = 0; i < block.count; i++) {
      float cx = ay[i] * z[i] - az[i] * y[i], cy = az[i] * x[i] - ax[i] * z[i], cz = ax[i] * y[i] - ay[i] * x[i];
      ax[i] = cx * curl_scale;
      ay[i] = cy * curl_scale;
      az[i] = cz * curl_scale;
    }
  }
}

/* Scale of a slope's components to a root mean square of 1. */
static const float swirl_scale = 2.26f;

static void fill_swirl(const np_noise_lattice *lattice, const np_noise_points *points, float *out_x, float *out_y) {
  const grid g = make_grid(lattice, 0);
  float along_x[BLOCK], along_z[BLOCK];
  for (size_t begin = 0; begin < points->count; begin += BLOCK) {
    const np_noise_points block = take_block(points, begin);
    fill_slope(&g, &block, along_x, out_x + begin, along_z);
    for (size_t i = 0; i < block.count; i++) {
      out_x[begin + i] *= swirl_scale;
      out_y[begin + i] = -swirl_scale * along_x[i];
    }
  }
}

const np_noise_table NP_KERNEL(np_noise_kernels) = {
    .value = fill_value,
    .value_fbm = fill_value_fbm,
    .perlin = fill_perlin,
    .perlin_fbm = fill_perlin_fbm,
    .worley = fill_worley,
    .worley_fbm = fill_worley_fbm,
    .perlin_worley = fill_perlin_worley,
    .curl = fill_curl,
    .swirl = fill_swirl,
};

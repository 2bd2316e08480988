/* SPDX-License-Identifier: Apache-2.0 */
/* Noise kernels; compiled once per instruction-set level, the same bits out of each.
 *
 * Perlin 2002, "Improving Noise" (quintic fade), with gradients spread evenly through a cube: their covariance is a
 * multiple of the identity, so that no direction is preferred. Worley 1996, "A Cellular Texture Basis Function" (F1
 * over 27 cells; a nearer point outside them is farther than 1, where the distance is clipped, so nothing is ever
 * missed). Perlin-Worley: Schneider and Vos 2015, "The Real-time Volumetric Cloudscapes of Horizon: Zero Dawn". The
 * divergence-free field is the bitangent noise of DeWolf 2005, "Divergence-Free Noise".
 *
 * One lane is one position. The lanes' functions are inlined into `omp simd` loops; integer hashing leaves no table to
 * gather from.
 */
#include "noise/noise.h"

extern const np_noise_table NP_KERNEL(np_noise_kernels);

/* A loop becomes vectors only if all that it calls is inside it. */
#define LANE static inline __attribute__((always_inline))

/* Hash of a lattice point, one axis at a time so that corners share the first two steps. */
LANE uint32_t hash_axis(uint32_t hash, int32_t index) {
  hash += (uint32_t)index * 0x9e3779b1u;
  hash ^= hash >> 15;
  return hash * 0x2c1b3c6du;
}

/* The product's low bits are its weak ones: high bits are laid over them. */
LANE uint32_t hash_finish(uint32_t hash) { return hash ^ hash >> 15; }

LANE int32_t floor_to_int(float x) {
  int32_t i = (int32_t)x;
  return i - (x < (float)i);
}

LANE int32_t wrap(int32_t i, int32_t period, float period_inverse) {
  int32_t r = i - floor_to_int((float)i * period_inverse) * period;
  r += r < 0 ? period : 0; /* the quotient may round across a multiple of the period, either way */
  return r - (r >= period ? period : 0);
}

LANE int32_t next(int32_t i, int32_t period) { return i + 1 == period ? 0 : i + 1; }
LANE int32_t previous(int32_t i, int32_t period) { return i == 0 ? period - 1 : i - 1; }

LANE float fade(float t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); }
LANE float fade_slope(float t) { return 30.0f * t * t * (t * (t - 2.0f) + 1.0f); }
LANE float lerp(float a, float b, float t) { return a + t * (b - a); }
LANE float clip(float x, float low, float high) { return x < low ? low : x > high ? high : x; }

/* A lattice made ready for lanes: one octave's frequency, shift and reciprocals. */
typedef struct grid {
  uint32_t seed;
  int32_t period[3];
  float period_inverse[3];
  float frequency, shift;
} grid;

/* Octaves are shifted so that their lattices do not share points; in 256ths, so that tiles still meet exactly. */
static grid make_grid(const np_noise_lattice *lattice, unsigned octave) {
  grid g = {.seed = lattice->seed + octave * 0x85ebca6bu,
            .frequency = (float)(1u << octave),
            .shift = (float)octave * (97.0f / 256.0f)};
  for (int i = 0; i < 3; i++) {
    g.period[i] = lattice->period[i] << octave;
    g.period_inverse[i] = 1.0f / (float)g.period[i];
  }
  return g;
}

/* A position's cell: its low and high lattice index, wrapped, and the fraction between them. */
typedef struct cell_axis {
  int32_t low, high;
  float fraction;
} cell_axis;

LANE cell_axis find_cell(const grid *g, int axis, float x) {
  float scaled = x * g->frequency + g->shift;
  int32_t i = floor_to_int(scaled), low = wrap(i, g->period[axis], g->period_inverse[axis]);
  return (cell_axis){low, next(low, g->period[axis]), scaled - (float)i};
}

/* Three fields of ten bits stay where they are in the hash; what they are worth is put into the scale of the offsets:
 * 1, 2⁻¹⁰ and 2⁻²⁰. Components are then in [0, 1023] and want their mean off. */
typedef struct gradient {
  float x, y, z, dot; /* y and z times 2¹⁰ and 2²⁰; product with the offset from the corner */
} gradient;

LANE gradient find_gradient(uint32_t hash, float dx, float dy, float dz) {
  uint32_t h = hash_finish(hash);
  gradient g = {(float)(int32_t)(h & 0x3ffu), (float)(int32_t)(h & 0xffc00u), (float)(int32_t)(h & 0x3ff00000u), 0};
  g.dot = g.x * dx + g.y * dy + g.z * dz;
  return g;
}

/* Of components in [0, 1023]: their mean, and the factor that brings them to (−1, 1). Noise then stays within ±1.5, its
 * standard deviation over all space is 0.19, and 1, where it is clipped, is met about once in 10⁷ positions. */
static const float gradient_mean = 511.5f, gradient_scale = 1.0f / 511.5f;

LANE float eval_perlin(const grid *g, float px, float py, float pz) {
  cell_axis x = find_cell(g, 0, px), y = find_cell(g, 1, py), z = find_cell(g, 2, pz);
  float u = fade(x.fraction), v = fade(y.fraction), w = fade(z.fraction);
  float x0 = x.fraction, y0 = y.fraction * 0x1p-10f, z0 = z.fraction * 0x1p-20f;
  float x1 = x0 - 1.0f, y1 = y0 - 0x1p-10f, z1 = z0 - 0x1p-20f;
  uint32_t h0 = hash_axis(g->seed, x.low), h1 = hash_axis(g->seed, x.high);
  uint32_t h00 = hash_axis(h0, y.low), h01 = hash_axis(h0, y.high);
  uint32_t h10 = hash_axis(h1, y.low), h11 = hash_axis(h1, y.high);
  float n000 = find_gradient(hash_axis(h00, z.low), x0, y0, z0).dot;
  float n001 = find_gradient(hash_axis(h00, z.high), x0, y0, z1).dot;
  float n010 = find_gradient(hash_axis(h01, z.low), x0, y1, z0).dot;
  float n011 = find_gradient(hash_axis(h01, z.high), x0, y1, z1).dot;
  float n100 = find_gradient(hash_axis(h10, z.low), x1, y0, z0).dot;
  float n101 = find_gradient(hash_axis(h10, z.high), x1, y0, z1).dot;
  float n110 = find_gradient(hash_axis(h11, z.low), x1, y1, z0).dot;
  float n111 = find_gradient(hash_axis(h11, z.high), x1, y1, z1).dot;
  float low = lerp(lerp(n000, n001, w), lerp(n010, n011, w), v);
  float high = lerp(lerp(n100, n101, w), lerp(n110, n111, w), v);
  /* A constant gradient's share, blended over the corners, is the fraction less its fade. */
  float mean = gradient_mean * ((x.fraction - u) + (y.fraction - v) + (z.fraction - w));
  return clip((lerp(low, high, u) - mean) * gradient_scale, -1.0f, 1.0f);
}

LANE float value_at(uint32_t hash) { return (float)(hash_finish(hash) >> 8) * 0x1p-24f; }

LANE float eval_value(const grid *g, float px, float py, float pz) {
  cell_axis x = find_cell(g, 0, px), y = find_cell(g, 1, py), z = find_cell(g, 2, pz);
  float u = fade(x.fraction), v = fade(y.fraction), w = fade(z.fraction);
  uint32_t h0 = hash_axis(g->seed, x.low), h1 = hash_axis(g->seed, x.high);
  uint32_t h00 = hash_axis(h0, y.low), h01 = hash_axis(h0, y.high);
  uint32_t h10 = hash_axis(h1, y.low), h11 = hash_axis(h1, y.high);
  float n00 = lerp(value_at(hash_axis(h00, z.low)), value_at(hash_axis(h00, z.high)), w);
  float n01 = lerp(value_at(hash_axis(h01, z.low)), value_at(hash_axis(h01, z.high)), w);
  float n10 = lerp(value_at(hash_axis(h10, z.low)), value_at(hash_axis(h10, z.high)), w);
  float n11 = lerp(value_at(hash_axis(h11, z.low)), value_at(hash_axis(h11, z.high)), w);
  return clip(lerp(lerp(n00, n01, v), lerp(n10, n11, v), u), 0.0f, 1.0f);
}

typedef struct slope {
  float x, y, z;
} slope;

LANE float blend(float n000, float n001, float n010, float n011, float n100, float n101, float n110, float n111,
                 float u, float v, float w) {
  return lerp(lerp(lerp(n000, n001, w), lerp(n010, n011, w), v), lerp(lerp(n100, n101, w), lerp(n110, n111, w), v), u);
}

/* ∇(Σ weight·dot) = Σ weight·gradient + Σ ∇weight·dot: exact, so that the cross product of two has no divergence. */
LANE slope eval_perlin_slope(const grid *g, float px, float py, float pz) {
  cell_axis x = find_cell(g, 0, px), y = find_cell(g, 1, py), z = find_cell(g, 2, pz);
  float u = fade(x.fraction), v = fade(y.fraction), w = fade(z.fraction);
  float x0 = x.fraction, y0 = y.fraction * 0x1p-10f, z0 = z.fraction * 0x1p-20f;
  float x1 = x0 - 1.0f, y1 = y0 - 0x1p-10f, z1 = z0 - 0x1p-20f;
  uint32_t h0 = hash_axis(g->seed, x.low), h1 = hash_axis(g->seed, x.high);
  uint32_t h00 = hash_axis(h0, y.low), h01 = hash_axis(h0, y.high);
  uint32_t h10 = hash_axis(h1, y.low), h11 = hash_axis(h1, y.high);
  gradient a = find_gradient(hash_axis(h00, z.low), x0, y0, z0), b = find_gradient(hash_axis(h00, z.high), x0, y0, z1);
  gradient c = find_gradient(hash_axis(h01, z.low), x0, y1, z0), d = find_gradient(hash_axis(h01, z.high), x0, y1, z1);
  gradient e = find_gradient(hash_axis(h10, z.low), x1, y0, z0), f = find_gradient(hash_axis(h10, z.high), x1, y0, z1);
  gradient k = find_gradient(hash_axis(h11, z.low), x1, y1, z0), l = find_gradient(hash_axis(h11, z.high), x1, y1, z1);
  float along_x = lerp(lerp(e.dot - a.dot, f.dot - b.dot, w), lerp(k.dot - c.dot, l.dot - d.dot, w), v);
  float along_y = lerp(lerp(c.dot - a.dot, d.dot - b.dot, w), lerp(k.dot - e.dot, l.dot - f.dot, w), u);
  float along_z = lerp(lerp(b.dot - a.dot, d.dot - c.dot, v), lerp(f.dot - e.dot, l.dot - k.dot, v), u);
  float mean_x = blend(a.x, b.x, c.x, d.x, e.x, f.x, k.x, l.x, u, v, w);
  float mean_y = blend(a.y, b.y, c.y, d.y, e.y, f.y, k.y, l.y, u, v, w) * 0x1p-10f;
  float mean_z = blend(a.z, b.z, c.z, d.z, e.z, f.z, k.z, l.z, u, v, w) * 0x1p-20f;
  float slope_x = fade_slope(x.fraction), slope_y = fade_slope(y.fraction), slope_z = fade_slope(z.fraction);
  return (slope){(mean_x + slope_x * along_x - gradient_mean * (1.0f - slope_x)) * gradient_scale,
                 (mean_y + slope_y * along_y - gradient_mean * (1.0f - slope_y)) * gradient_scale,
                 (mean_z + slope_z * along_z - gradient_mean * (1.0f - slope_z)) * gradient_scale};
}

/* Squared distance to the point of a cell, in 1024ths: its corner's offset is given, its place in it comes from the
 * hash. */
LANE float distance_squared(uint32_t hash, float dx, float dy, float dz) {
  uint32_t h = hash_finish(hash);
  float x = dx + (float)(int32_t)(h & 1023u);
  float y = dy + (float)(int32_t)(h >> 10 & 1023u);
  float z = dz + (float)(int32_t)(h >> 22);
  return x * x + y * y + z * z;
}

LANE float nearer(float a, float b) { return a < b ? a : b; }

/* The three cells along z of one column. */
LANE float search_column(uint32_t hash, const int32_t z[3], float dx, float dy, float dz, float best) {
  best = nearer(best, distance_squared(hash_axis(hash, z[0]), dx, dy, dz - 1024.0f));
  best = nearer(best, distance_squared(hash_axis(hash, z[1]), dx, dy, dz));
  return nearer(best, distance_squared(hash_axis(hash, z[2]), dx, dy, dz + 1024.0f));
}

/* The nine cells of one sheet across x. */
LANE float search_sheet(uint32_t hash, const int32_t y[3], const int32_t z[3], float dx, float dy, float dz,
                        float best) {
  best = search_column(hash_axis(hash, y[0]), z, dx, dy - 1024.0f, dz, best);
  best = search_column(hash_axis(hash, y[1]), z, dx, dy, dz, best);
  return search_column(hash_axis(hash, y[2]), z, dx, dy + 1024.0f, dz, best);
}

LANE float eval_worley(const grid *g, float px, float py, float pz) {
  cell_axis x = find_cell(g, 0, px), y = find_cell(g, 1, py), z = find_cell(g, 2, pz);
  const int32_t ys[3] = {previous(y.low, g->period[1]), y.low, y.high};
  const int32_t zs[3] = {previous(z.low, g->period[2]), z.low, z.high};
  float dx = -1024.0f * x.fraction, dy = -1024.0f * y.fraction, dz = -1024.0f * z.fraction, best = 0x1p20f;
  best = search_sheet(hash_axis(g->seed, previous(x.low, g->period[0])), ys, zs, dx - 1024.0f, dy, dz, best);
  best = search_sheet(hash_axis(g->seed, x.low), ys, zs, dx, dy, dz, best);
  return search_sheet(hash_axis(g->seed, x.high), ys, zs, dx + 1024.0f, dy, dz, best) * 0x1p-20f;
}

static void fill_value(const np_noise_lattice *lattice, const np_noise_points *points, float *out) {
  const grid g = make_grid(lattice, 0);
  const float *x = points->x, *y = points->y, *z = points->z;
#pragma omp simd
  for (size_t i = 0; i < points->count; i++) out[i] = eval_value(&g, x[i], y[i], z[i]);
}

static void fill_perlin(const np_noise_lattice *lattice, const np_noise_points *points, float *out) {
  const grid g = make_grid(lattice, 0);
  const float *x = points->x, *y = points->y, *z = points->z;
#pragma omp simd
  for (size_t i = 0; i < points->count; i++) out[i] = eval_perlin(&g, x[i], y[i], z[i]);
}

static void fill_worley(const np_noise_lattice *lattice, const np_noise_points *points, float *out) {
  const grid g = make_grid(lattice, 0);
  const float *x = points->x, *y = points->y, *z = points->z;
#pragma omp simd
  for (size_t i = 0; i < points->count; i++) out[i] = eval_worley(&g, x[i], y[i], z[i]);
}

/* Amplitude of each octave, adding up to 1. */
static void find_amplitudes(const np_noise_octaves *octaves, float out_amplitudes[NP_NOISE_OCTAVES_MAX]) {
  float amplitude = 1.0f, sum = 0.0f;
  for (unsigned k = 0; k < octaves->count; k++, amplitude *= octaves->gain) sum += amplitude;
  amplitude = 1.0f / sum;
  for (unsigned k = 0; k < octaves->count; k++, amplitude *= octaves->gain) out_amplitudes[k] = amplitude;
}

static void fill_perlin_fbm(const np_noise_lattice *lattice, const np_noise_octaves *octaves,
                            const np_noise_points *points, float *out) {
  float amplitudes[NP_NOISE_OCTAVES_MAX];
  find_amplitudes(octaves, amplitudes);
  const float *x = points->x, *y = points->y, *z = points->z;
  for (size_t i = 0; i < points->count; i++) out[i] = 0.0f;
  for (unsigned k = 0; k < octaves->count; k++) {
    const grid g = make_grid(lattice, k);
    const float amplitude = amplitudes[k];
#pragma omp simd
    for (size_t i = 0; i < points->count; i++) out[i] += amplitude * eval_perlin(&g, x[i], y[i], z[i]);
  }
  for (size_t i = 0; i < points->count; i++) out[i] = clip(out[i], -1.0f, 1.0f);
}

static void fill_worley_fbm(const np_noise_lattice *lattice, const np_noise_octaves *octaves,
                            const np_noise_points *points, float *out) {
  float amplitudes[NP_NOISE_OCTAVES_MAX];
  find_amplitudes(octaves, amplitudes);
  const float *x = points->x, *y = points->y, *z = points->z;
  for (size_t i = 0; i < points->count; i++) out[i] = 1.0f;
  for (unsigned k = 0; k < octaves->count; k++) {
    const grid g = make_grid(lattice, k);
    const float amplitude = amplitudes[k];
#pragma omp simd
    for (size_t i = 0; i < points->count; i++) out[i] -= amplitude * eval_worley(&g, x[i], y[i], z[i]);
  }
  for (size_t i = 0; i < points->count; i++) out[i] = clip(out[i], 0.0f, 1.0f);
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

/* Brings the cross product of two potentials' slopes to a root mean square of 1 per component. */
static const float curl_scale = 2.87f;

static void fill_slope(const grid *g, const np_noise_points *points, float *out_x, float *out_y, float *out_z) {
  const float *x = points->x, *y = points->y, *z = points->z;
#pragma omp simd
  for (size_t i = 0; i < points->count; i++) {
    slope s = eval_perlin_slope(g, x[i], y[i], z[i]);
    out_x[i] = s.x;
    out_y[i] = s.y;
    out_z[i] = s.z;
  }
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

const np_noise_table NP_KERNEL(np_noise_kernels) = {
    .value = fill_value,
    .perlin = fill_perlin,
    .perlin_fbm = fill_perlin_fbm,
    .worley = fill_worley,
    .worley_fbm = fill_worley_fbm,
    .perlin_worley = fill_perlin_worley,
    .curl = fill_curl,
};

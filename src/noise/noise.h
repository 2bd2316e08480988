/* SPDX-License-Identifier: Apache-2.0 */
/* Seeded, tileable noise in three dimensions, over arrays of positions.
 *
 * Positions are in lattice cells, |x| < 2²² after the last octave's doubling. Every function repeats with its lattice's
 * period and gives the same bits at every instruction-set level: nothing but + − × ÷ √ and integers is used.
 */
#ifndef NP_NOISE_NOISE_H
#define NP_NOISE_NOISE_H

#include "core/isa.h"

/* Greatest period, too long to be visible. Its eighth octave still counts exactly in float. */
#define NP_NOISE_PERIOD_MAX 65536

enum { NP_NOISE_OCTAVES_MAX = 8 };

/* Lattice of a noise. Two seeds differ everywhere in value, not in statistics. */
typedef struct np_noise_lattice {
  uint32_t seed;
  int32_t period[3]; /* cells along x, y, z; 1 to NP_NOISE_PERIOD_MAX */
} np_noise_lattice;

/* A sum of octaves, each of twice the frequency and `gain` times the amplitude, divided by the sum of amplitudes. */
typedef struct np_noise_octaves {
  unsigned count; /* 1 to NP_NOISE_OCTAVES_MAX */
  float gain;     /* ≥ 0 */
} np_noise_octaves;

/* Borrowed coordinates; none may overlap an output. */
typedef struct np_noise_points {
  size_t count;
  const float *x, *y, *z;
} np_noise_points;

/* The functions of one instruction-set level. */
typedef struct np_noise_table {
  /* Random values at lattice points, blended by a quintic: [0, 1], mean ½, C². */
  void (*value)(const np_noise_lattice *lattice, const np_noise_points *points, float *out);

  /* Sum of octaves of value noise: [0, 1], mean ½. The cheapest noise for clouds. */
  void (*value_fbm)(const np_noise_lattice *lattice, const np_noise_octaves *octaves, const np_noise_points *points,
                    float *out);

  /* Gradient noise: [−1, 1], mean 0, standard deviation 0.17, C². */
  void (*perlin)(const np_noise_lattice *lattice, const np_noise_points *points, float *out);

  /* Sum of octaves of Perlin noise: [−1, 1], mean 0. */
  void (*perlin_fbm)(const np_noise_lattice *lattice, const np_noise_octaves *octaves, const np_noise_points *points,
                     float *out);

  /* Squared distance to the nearest of one random point per cell, at most 1: [0, 1], mean 0.30, C⁰ with creases
   * half-way between points. 1 − F1² is a heap of round billows. */
  void (*worley)(const np_noise_lattice *lattice, const np_noise_points *points, float *out);

  /* Sum of octaves of billows 1 − F1²: [0, 1]. */
  void (*worley_fbm)(const np_noise_lattice *lattice, const np_noise_octaves *octaves, const np_noise_points *points,
                     float *out);

  /* Billows w joined by Perlin noise p in [0, 1]: w + p·(1 − w), from octaves of both: [0, 1]. */
  void (*perlin_worley)(const np_noise_lattice *lattice, const np_noise_octaves *octaves, const np_noise_points *points,
                        float *out);

  /* A divergence-free field ∇a × ∇b = ∇ × (a∇b) of two Perlin noises: components of mean 0, root mean square 1. */
  void (*curl)(const np_noise_lattice *lattice, const np_noise_points *points, float *out_x, float *out_y,
               float *out_z);

  /* A horizontal field (∂a/∂y, −∂a/∂x), the curl of a vertical potential, which is Perlin noise: no divergence in any
   * plane of constant z; components of mean 0, root mean square 1. */
  void (*swirl)(const np_noise_lattice *lattice, const np_noise_points *points, float *out_x, float *out_y);
} np_noise_table;

/* Functions of an instruction-set level that the machine supports. */
const np_noise_table *np_noise_get_table(neph_isa isa);

/* 32-bit seed for stream number `stream` of a 64-bit seed, for independent noises. */
uint32_t np_noise_derive_seed(uint64_t seed, uint32_t stream);

#endif

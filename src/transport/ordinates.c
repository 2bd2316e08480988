/* SPDX-License-Identifier: Apache-2.0 */
/* Gauss points along z and even azimuths: with N + 1 points and 2N + 2 azimuths they are exact for every product of two
 * harmonics of degree N. Layers have as many points in each half of the vertical, for their light is another above the
 * horizon and below; so has the least degree, whose lowest directions then stand 4° above the horizon: a twilight comes
 * from there (S6, level-symmetric, has them at 15°). */
#include "transport/ordinates.h"

#include <assert.h>

#include "core/units.h"

/* A product quadrature: Gauss points in the upper half of the vertical, and azimuths in a quarter turn. */
typedef struct product_set {
  unsigned points, azimuths;
  bool is_halved; /* Gauss points are chosen for each half of the interval */
} product_set;

static product_set choose_product(unsigned degree, bool is_layered) {
  if (degree <= NP_DEGREE_MIN) return (product_set){is_layered ? 8 : 4, 2, true};
  return (product_set){is_layered ? degree + 1 : (degree + 2) / 2, (degree + 2) / 2, is_layered};
}

unsigned np_ordinates_count(unsigned degree, bool is_layered) {
  const product_set set = choose_product(degree, is_layered);
  return NP_OCTANT_COUNT * set.points * set.azimuths;
}

/* Harmonics up to l = 3, written out. */
static void evaluate_low(np_vec3 d, float out[NP_HARMONIC_COUNT_MIN]) {
  const float x = d.x, y = d.y, z = d.z, xx = x * x, yy = y * y, zz = z * z;
  out[0] = 0.28209479f;
  out[1] = 0.48860251f * y;
  out[2] = 0.48860251f * z;
  out[3] = 0.48860251f * x;
  out[4] = 1.09254843f * x * y;
  out[5] = 1.09254843f * y * z;
  out[6] = 0.31539157f * (3.0f * zz - 1.0f);
  out[7] = 1.09254843f * x * z;
  out[8] = 0.54627422f * (xx - yy);
  out[9] = 0.59004359f * y * (3.0f * xx - yy);
  out[10] = 2.89061144f * x * y * z;
  out[11] = 0.45704580f * y * (5.0f * zz - 1.0f);
  out[12] = 0.37317633f * z * (5.0f * zz - 3.0f);
  out[13] = 0.45704580f * x * (5.0f * zz - 1.0f);
  out[14] = 1.44530572f * z * (xx - yy);
  out[15] = 0.59004359f * x * (xx - 3.0f * yy);
}

/* All of one m > 0 and of −m, or of m = 0. `cosine` and `sine` are sinᵐθ·cos mφ and sinᵐθ·sin mφ, `top` is the factor
 * of Y_mm before them; from there upwards in l (fully normalised associated Legendre functions, Holmes and Featherstone
 * 2002, eq. 11). */
static void evaluate_order(unsigned degree, unsigned m, double top, double z, double cosine, double sine, float *out) {
  double now = top, before = 0.0;
  for (unsigned l = m; l <= degree; l++) {
    const unsigned centre = l * (l + 1);
    out[centre + m] = (float)(now * cosine);
    if (m > 0) out[centre - m] = (float)(now * sine);
    const double n = l + 1.0, mm = (double)m * m, scale = sqrt((4.0 * n * n - 1.0) / (n * n - mm));
    const double low = l > m ? sqrt(((n - 1.0) * (n - 1.0) - mm) / (4.0 * (n - 1.0) * (n - 1.0) - 1.0)) : 0.0;
    const double next = scale * (z * now - low * before);
    before = now;
    now = next;
  }
}

void np_harmonics_eval(unsigned degree, np_vec3 d, float out[NP_HARMONIC_COUNT_MAX]) {
  assert(np_harmonics_count(degree) <= NP_HARMONIC_COUNT_MAX);
  if (degree <= NP_DEGREE_MIN) {
    evaluate_low(d, out);
    return;
  }
  const double x = d.x, y = d.y;
  double cosine = 1.0, sine = 0.0, top = sqrt(0.25 / NP_PI);
  for (unsigned m = 0; m <= degree; m++) {
    evaluate_order(degree, m, top, d.z, cosine, sine, out);
    const double turned = x * cosine - y * sine;
    sine = x * sine + y * cosine;
    cosine = turned;
    /* The √2 of real harmonics enters at m = 1. */
    top *= sqrt((2.0 * m + 3.0) / (2.0 * m + 2.0) * (m == 0 ? 2.0 : 1.0));
  }
}

np_vec3 np_ordinates_direction(const np_ordinates *ordinates, unsigned octant, unsigned block, unsigned lane) {
  float d[3];
  for (unsigned a = 0; a < 3; a++)
    d[a] = octant >> a & 1u ? -ordinates->cosine[a][block][lane] : ordinates->cosine[a][block][lane];
  return np_vec3_make(d[0], d[1], d[2]);
}

static void add_direction(np_ordinates *o, double x, double y, double z, double weight) {
  const unsigned block = o->count / NP_ORDINATE_LANES, lane = o->count % NP_ORDINATE_LANES;
  assert(block < NP_ORDINATE_BLOCKS_MAX && weight > 0.0);
  o->cosine[0][block][lane] = (float)x;
  o->cosine[1][block][lane] = (float)y;
  o->cosine[2][block][lane] = (float)z;
  o->weight[block][lane] = (float)weight;
  o->count++;
}

/* The i-th of n points of Gauss on [0, 1], by Newton's method on P_n. */
static void compute_gauss(unsigned n, unsigned i, double *out_point, double *out_weight) {
  double x = cos(NP_PI * (i + 0.75) / (n + 0.5)), slope = 1.0;
  for (int step = 0; step < 20; step++) {
    double now = 1.0, before = 0.0;
    for (unsigned l = 0; l < n; l++) {
      const double next = ((2.0 * l + 1.0) * x * now - l * before) / (l + 1.0);
      before = now;
      now = next;
    }
    slope = n * (before - x * now) / ((1.0 - x) * (1.0 + x));
    x -= now / slope;
  }
  *out_point = 0.5 * (1.0 - x);
  *out_weight = 1.0 / ((1.0 - x) * (1.0 + x) * slope * slope);
}

static void add_product(np_ordinates *o, product_set set) {
  for (unsigned i = 0; i < set.points; i++) {
    double z, weight;
    if (set.is_halved) {
      compute_gauss(set.points, i, &z, &weight);
    } else {
      compute_gauss(2 * set.points, i, &z, &weight);
      z = fabs(2.0 * z - 1.0);
      weight *= 2.0;
    }
    const double r = sqrt((1.0 - z) * (1.0 + z)), quarter = 0.5 * NP_PI;
    for (unsigned k = 0; k < set.azimuths; k++) {
      const double azimuth = quarter * (k + 0.5) / set.azimuths;
      add_direction(o, r * cos(azimuth), r * sin(azimuth), z, weight * quarter / set.azimuths);
    }
  }
}

static void fill_padding(np_ordinates *o) {
  o->block_count = (o->count + NP_ORDINATE_LANES - 1) / NP_ORDINATE_LANES;
  for (unsigned i = o->count; i < o->block_count * NP_ORDINATE_LANES; i++)
    for (int a = 0; a < 3; a++) o->cosine[a][i / NP_ORDINATE_LANES][i % NP_ORDINATE_LANES] = o->cosine[a][0][0];
}

/* Parity in x: cos mφ has the parity of m, sin mφ the opposite. */
static bool is_even_in_x(int m) { return (m < 0) == (m % 2 != 0); }

static void fill_places(np_ordinates *o) {
  const int degree = (int)o->degree;
  unsigned next = 0;
  for (int pass = 0; pass < 2; pass++) {
    for (int l = 0; l <= degree; l++)
      for (int m = -l; m <= l; m++)
        if (is_even_in_x(m) == (pass == 0)) o->place[l * (l + 1) + m] = (unsigned char)next++;
    if (pass == 0) o->even_count = next;
    assert(next % 2 == 0 && next <= np_harmonics_count(o->degree));
  }
}

static void fill_harmonics(np_ordinates *o, unsigned pair, unsigned block) {
  const unsigned count = np_harmonics_count(o->degree);
  for (unsigned lane = 0; lane < NP_ORDINATE_LANES; lane++) {
    float values[NP_HARMONIC_COUNT_MAX];
    np_harmonics_eval(o->degree, np_ordinates_direction(o, 2 * pair, block, lane), values);
    for (unsigned i = 0; i < count; i++) {
      o->harmonic[pair][block][o->place[i]][lane] = values[i];
      o->weighted[pair][block][lane][o->place[i]] = values[i] * o->weight[block][lane];
    }
  }
}

void np_ordinates_init(unsigned degree, bool is_layered, np_ordinates *out) {
  *out = (np_ordinates){.degree = degree};
  add_product(out, choose_product(degree, is_layered));
  fill_padding(out);
  fill_places(out);
  for (unsigned pair = 0; pair < NP_OCTANT_PAIRS; pair++)
    for (unsigned block = 0; block < out->block_count; block++) fill_harmonics(out, pair, block);
}

unsigned np_ordinates_search_nearest(const np_ordinates *o, np_vec3 d) {
  const unsigned octant = (d.x < 0.0f ? 1u : 0u) | (d.y < 0.0f ? 2u : 0u) | (d.z < 0.0f ? 4u : 0u);
  unsigned best = 0;
  float best_cosine = -1.0f;
  for (unsigned i = 0; i < o->count; i++) {
    const unsigned block = i / NP_ORDINATE_LANES, lane = i % NP_ORDINATE_LANES;
    const float cosine = fabsf(d.x) * o->cosine[0][block][lane] + fabsf(d.y) * o->cosine[1][block][lane] +
                         fabsf(d.z) * o->cosine[2][block][lane];
    if (cosine <= best_cosine) continue;
    best_cosine = cosine;
    best = i;
  }
  return octant * NP_ORDINATE_BLOCKS_MAX * NP_ORDINATE_LANES + best;
}

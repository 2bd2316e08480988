/* SPDX-License-Identifier: Apache-2.0 */
/* Level-symmetric quadratures (Lewis and Miller 1984, "Computational Methods of Neutron Transport", table 4-1): the
 * same cosines along each axis, μᵢ² = μ₁² + 2(i−1)(1−3μ₁²)/(N−2), and one weight for all permutations of a triple.
 * And a product set: eight points of Gauss in each half of the cosine along z, eight even azimuths. */
#include "light/ordinates.h"

#include "core/units.h"

typedef struct triple {
  unsigned char level[3]; /* ascending */
  double weight;          /* an octant's add up to 1 over all permutations */
} triple;

typedef struct level_set {
  unsigned order, triple_count;
  double first_cosine;
  triple triples[2];
} level_set;

static const level_set sets[] = {
    {4, 1, 0.3500212, {{{0, 0, 1}, 0.3333333}}},
    {6, 2, 0.2666355, {{{0, 0, 2}, 0.1761263}, {{0, 1, 1}, 0.1572071}}},
};

void np_harmonics_eval(np_vec3 d, float out[NP_HARMONIC_COUNT]) {
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

np_vec3 np_ordinates_direction(const np_ordinates *ordinates, unsigned octant, unsigned block, unsigned lane) {
  float d[3];
  for (unsigned a = 0; a < 3; a++)
    d[a] = octant >> a & 1u ? -ordinates->cosine[a][block][lane] : ordinates->cosine[a][block][lane];
  return np_vec3_make(d[0], d[1], d[2]);
}

static void add_direction(np_ordinates *o, const double cosine[3], double weight) {
  const unsigned block = o->count / NP_ORDINATE_LANES, lane = o->count % NP_ORDINATE_LANES;
  for (int a = 0; a < 3; a++) o->cosine[a][block][lane] = (float)cosine[a];
  o->weight[block][lane] = (float)weight;
  o->count++;
}

/* Every arrangement of a triple's levels on the three axes, once. */
static void add_permutations(np_ordinates *o, const triple *t, const double cosines[4], double weight) {
  static const unsigned char orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  unsigned seen[6], seen_count = 0;
  for (int p = 0; p < 6; p++) {
    unsigned code = 0;
    double cosine[3];
    for (int a = 0; a < 3; a++) {
      const unsigned level = t->level[orders[p][a]];
      code = 4 * code + level;
      cosine[a] = cosines[level];
    }
    bool is_new = true;
    for (unsigned i = 0; i < seen_count; i++) is_new = is_new && seen[i] != code;
    if (!is_new) continue;
    seen[seen_count++] = code;
    add_direction(o, cosine, weight);
  }
}

static void fill_padding(np_ordinates *o) {
  o->block_count = (o->count + NP_ORDINATE_LANES - 1) / NP_ORDINATE_LANES;
  for (unsigned i = o->count; i < o->block_count * NP_ORDINATE_LANES; i++)
    for (int a = 0; a < 3; a++) o->cosine[a][i / NP_ORDINATE_LANES][i % NP_ORDINATE_LANES] = o->cosine[a][0][0];
}

static void fill_harmonics(np_ordinates *o, unsigned octant, unsigned block) {
  for (unsigned lane = 0; lane < NP_ORDINATE_LANES; lane++) {
    float values[NP_HARMONIC_COUNT];
    np_harmonics_eval(np_ordinates_direction(o, octant, block, lane), values);
    for (unsigned i = 0; i < NP_HARMONIC_COUNT; i++) {
      o->harmonic[octant][block][i][lane] = values[i];
      o->weighted[octant][block][lane][i] = values[i] * o->weight[block][lane];
    }
  }
}

static void fill_all_harmonics(np_ordinates *o) {
  for (unsigned octant = 0; octant < NP_OCTANT_COUNT; octant++)
    for (unsigned block = 0; block < o->block_count; block++) fill_harmonics(o, octant, block);
}

/* Gauss-Legendre points and weights on [0, 1], eight of them; the other four mirror these about 1/2. */
static const double gauss[4][2] = {{0.0198550717512319, 0.0506142681451881},
                                   {0.1016667612931866, 0.1111905172266872},
                                   {0.2372337950418355, 0.1568533229389437},
                                   {0.4082826787521751, 0.1813418916891810}};

static void add_product_directions(np_ordinates *o) {
  for (int i = 0; i < 8; i++) {
    const double *point = gauss[i < 4 ? i : 7 - i], z = i < 4 ? point[0] : 1.0 - point[0], r = sqrt(1.0 - z * z);
    for (int k = 0; k < 2; k++) {
      const double azimuth = (2 * k + 1) * NP_PI / 8.0;
      add_direction(o, (const double[3]){r * cos(azimuth), r * sin(azimuth), z}, point[1] * NP_PI / 4.0);
    }
  }
}

void np_ordinates_init(unsigned order, np_ordinates *out) {
  if (order == NP_ORDINATES_PRODUCT) {
    *out = (np_ordinates){0};
    add_product_directions(out);
    fill_padding(out);
    fill_all_harmonics(out);
    return;
  }
  const level_set *set = &sets[order == 4 ? 0 : 1];
  *out = (np_ordinates){0};
  double cosines[4] = {0}, total = 0.0;
  const double first = set->first_cosine * set->first_cosine;
  for (unsigned i = 0; i < set->order / 2; i++)
    cosines[i] = sqrt(first + 2.0 * i * (1.0 - 3.0 * first) / (set->order - 2.0));
  for (unsigned i = 0; i < set->triple_count; i++)
    add_permutations(out, &set->triples[i], cosines, set->triples[i].weight);
  fill_padding(out);
  for (unsigned i = 0; i < out->count; i++) total += (double)out->weight[i / NP_ORDINATE_LANES][i % NP_ORDINATE_LANES];
  /* The printed weights have seven digits: an octant's are brought to π/2 exactly. */
  for (unsigned i = 0; i < out->count; i++)
    out->weight[i / NP_ORDINATE_LANES][i % NP_ORDINATE_LANES] *= (float)(0.5 * NP_PI / total);
  fill_all_harmonics(out);
}

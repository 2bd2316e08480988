/* SPDX-License-Identifier: Apache-2.0 */
/* Draine lobes: their moments in closed form, and exact sampling from one random number.
 *
 * A Henyey-Greenstein lobe H times (1 + αμ²), normalised (Draine 2003, eq. 4). Since H has the Legendre moments gˡ and
 * μ·P_l = ((l+1)·P_{l+1} + l·P_{l−1})/(2l+1), the moments of μ²·H follow from two applications of that recurrence.
 */
#include "optics/phase.h"

#include <assert.h>

np_phase np_phase_isotropic(void) { return np_phase_henyey_greenstein(0); }

np_phase np_phase_rayleigh(void) { return np_phase_cornette_shanks(0); }

np_phase np_phase_henyey_greenstein(float g) { return (np_phase){.lobe = {{g, 0}, {0, 0}}, .weight = 0}; }

np_phase np_phase_two_lobe(float g_forward, float g_backward, float weight_backward) {
  return (np_phase){.lobe = {{g_forward, 0}, {g_backward, 0}}, .weight = weight_backward};
}

np_phase np_phase_cornette_shanks(float g) { return np_phase_draine(g, 1); }

np_phase np_phase_haze(double g) {
  static const double narrow = 0.93, narrow_share = 0.48, narrowest = 0.985, narrowest_share = 0.05;
  const double broad_share = 1.0 - narrow_share - narrowest_share;
  const double broad = (g - narrow_share * narrow - narrowest_share * narrowest) / broad_share;
  return (np_phase){.lobe = {{(float)broad, 0}, {(float)narrow, 0}, {(float)narrowest, 0}},
                    .weight = (float)(narrow_share / (1.0 - narrowest_share)),
                    .third_weight = (float)narrowest_share};
}

np_phase np_phase_draine(float g, float alpha) { return (np_phase){.lobe = {{g, alpha}, {0, 0}}, .weight = 0}; }

np_phase np_phase_tabulated(const np_phase_table *table) { return (np_phase){.table = table, .table_weight = 1}; }

np_phase np_phase_of_bands(const np_phase_bands *bands) {
  np_phase phase = np_phase_tabulated(&bands->mean);
  phase.bands = bands;
  return phase;
}

np_phase np_phase_get_band(const np_phase *phase, int band) {
  np_phase own = *phase;
  if (phase->bands) own.table = &phase->bands->band[band];
  own.bands = NULL;
  return own;
}

np_spectrum np_phase_eval_bands(const np_phase *phase, float versine) {
  np_spectrum value = np_spectrum_grey(np_phase_eval(phase, versine));
  if (!phase->bands) return value;
  const np_phase_place place = np_phase_table_search(phase->table, versine);
  const float mean = np_phase_table_get(phase->table, place);
  for (int b = 0; b < NP_BAND_COUNT; b++)
    value.band[b] += phase->table_weight * (np_phase_table_get(&phase->bands->band[b], place) - mean);
  return value;
}

np_phase np_phase_droplets(double diameter_m) {
  const double d_um = diameter_m * 1e6;
  double g_hg = exp(-0.0990567 / (d_um - 1.67154));
  double g_draine = exp(-2.20679 / (d_um + 3.91029) - 0.428934);
  double alpha = exp(3.62489 - 8.29288 / (d_um + 5.52825));
  double weight = exp(-0.599085 / (d_um - 0.641583) - 0.665888);
  return (np_phase){.lobe = {{(float)g_hg, 0}, {(float)g_draine, (float)alpha}}, .weight = (float)weight};
}

static bool is_same_lobe(np_phase_lobe a, np_phase_lobe b) { return a.asymmetry == b.asymmetry && a.alpha == b.alpha; }

bool np_phase_is_equal(const np_phase *a, const np_phase *b) {
  return is_same_lobe(a->lobe[0], b->lobe[0]) && is_same_lobe(a->lobe[1], b->lobe[1]) &&
         is_same_lobe(a->lobe[2], b->lobe[2]) && a->weight == b->weight && a->third_weight == b->third_weight &&
         a->table == b->table && a->table_weight == b->table_weight && a->bands == b->bands;
}

/* Normalisation 1 + α(1+2g²)/3: one plus α times the mean of μ² over H. */
static double compute_norm(np_phase_lobe lobe) {
  double g = lobe.asymmetry, alpha = lobe.alpha;
  return 1.0 + alpha * (1.0 + 2.0 * g * g) / 3.0;
}

/* Sampling. H is sampled by t uniform in [0, 1] through (numerics: no cancellation for 0 ≤ g < 1, with k = 1 − g)
 *
 *     y = k + 2gt,   1 − μ = 2k²(1−t)(1+gt)/y²,   μ = (2t(1+g²)(k+gt) − k²)/y²
 *
 * so in t the Draine lobe has the density (1+αμ²)/norm, which is bounded: between 1/norm and (1+α)/norm. With A = 1+g²
 * and c = 1−g+g², integrating μ² over t gives
 *
 *     ∫₀ᵗ μ² dt = t·(k³ − 2k²c·t + (4/3)k·c²·t² + 2gA²·t³)/y³
 *
 * where the division by g³ of the textbook antiderivative has been carried out, so that g → 0 and g → 1 are harmless.
 * (t + α∫μ²)/norm = u is the quartic that Jendersie and d'Eon 2023 solve in radicals; those cancel in float for g near
 * 0 and 1, whereas Newton's method inside a shrinking bracket holds everywhere. */
typedef struct draine_cdf {
  double value, density;
} draine_cdf;

static draine_cdf integrate_draine(double t, double g, double alpha, double norm) {
  double k = 1.0 - g, a = 1.0 + g * g, c = a - g, y = k + 2.0 * g * t;
  double mu = (2.0 * t * a * (k + g * t) - k * k) / (y * y);
  double mu2 = t * (k * k * k + t * (-2.0 * k * k * c + t * (4.0 / 3.0 * k * c * c + t * 2.0 * g * a * a)));
  return (draine_cdf){(t + alpha * mu2 / (y * y * y)) / norm, (1.0 + alpha * mu * mu) / norm};
}

/* The t at which the lobe's cumulative distribution is u. Newton doubles its digits from the third step or so; 60 steps
 * bound the worst case, in which every one of them halves the bracket. */
static double invert_draine(double u, double g, double alpha, double norm) {
  assert(0.0 <= u && u <= 1.0 && 0.0 <= g && g < 1.0 && norm > 0.0);
  double low = 0.0, high = 1.0, t = u;
  for (int i = 0; i < 60; i++) {
    draine_cdf cdf = integrate_draine(t, g, alpha, norm);
    if (cdf.value > u)
      high = t;
    else
      low = t;
    double next = t - (cdf.value - u) / cdf.density;
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    if (fabs(next - t) <= 1e-15) return next;
    t = next;
  }
  return t;
}

/* Versine of the scattering angle about the lobe's own axis, which is backwards for g < 0. */
static double sample_versine(np_phase_lobe lobe, double u) {
  double g = fabs((double)lobe.asymmetry), k = 1.0 - g;
  double t = lobe.alpha > 0 ? invert_draine(u, g, lobe.alpha, compute_norm(lobe)) : u;
  double y = k + 2.0 * g * t;
  return fmin(2.0 * k * k * (1.0 - t) * (1.0 + g * t) / (y * y), 2.0);
}

/* A versine sampled by two numbers, about the forward axis or, where `*out_is_backward`, the backward one. */
static double sample_mixture(const np_phase *phase, const float u[3], bool *out_is_backward) {
  assert(phase->weight >= 0.0f && phase->weight <= 1.0f);
  assert(phase->table_weight >= 0.0f && phase->table_weight <= 1.0f);
  *out_is_backward = false;
  if (phase->table && u[0] < phase->table_weight) return np_phase_table_sample(phase->table, (double)u[1]);
  float choice = phase->table ? (u[0] - phase->table_weight) / (1.0f - phase->table_weight) : u[0];
  np_phase_lobe lobe = phase->lobe[2];
  if (choice >= phase->third_weight)
    lobe = phase->lobe[(choice - phase->third_weight) / (1.0f - phase->third_weight) < phase->weight];
  *out_is_backward = lobe.asymmetry < 0;
  return sample_versine(lobe, (double)u[1]);
}

np_vec3 np_phase_sample(const np_phase *phase, np_vec3 forward, const float u[3], float *out_value) {
  bool is_backward;
  double versine = sample_mixture(phase, u, &is_backward);
  *out_value = np_phase_eval(phase, (float)(is_backward ? 2.0 - versine : versine));

  np_vec3 axis = is_backward ? np_vec3_scale(forward, -1.0f) : forward, tangent, bitangent;
  np_frame_around(axis, &tangent, &bitangent);
  float sine = (float)sqrt(versine * (2.0 - versine)), cosine = (float)(1.0 - versine);
  float azimuth = 2.0f * NP_PI_F * u[2];
  np_vec3 across =
      np_vec3_add(np_vec3_scale(tangent, sine * cosf(azimuth)), np_vec3_scale(bitangent, sine * sinf(azimuth)));
  /* Normalised, since a long path would otherwise accumulate the rounding of every frame. */
  return np_vec3_normalize(np_vec3_add(np_vec3_scale(axis, cosine), across));
}

static double compute_lobe_mean_cosine(np_phase_lobe lobe) {
  double g = lobe.asymmetry, alpha = lobe.alpha;
  return g * (1.0 + alpha * (3.0 + 2.0 * g * g) / 5.0) / compute_norm(lobe);
}

double np_phase_mean_cosine(const np_phase *phase) {
  if (phase->table) {
    double moments[2];
    np_phase_get_moments(phase, 2, moments);
    return moments[1];
  }
  double w = phase->weight, third = phase->third_weight;
  double two = (1.0 - w) * compute_lobe_mean_cosine(phase->lobe[0]) + w * compute_lobe_mean_cosine(phase->lobe[1]);
  return third > 0.0 ? (1.0 - third) * two + third * compute_lobe_mean_cosine(phase->lobe[2]) : two;
}

/* Moment l of H; l = −1 occurs with the factor 0. */
static double compute_hg_moment(double g, int l) { return l < 0 ? 0.0 : pow(g, l); }

/* Moment l of μ·H, by the recurrence; l = −1 occurs with the factor 0. */
static double compute_mu_hg_moment(double g, int l) {
  if (l < 0) return 0.0;
  return ((l + 1) * compute_hg_moment(g, l + 1) + l * compute_hg_moment(g, l - 1)) / (2 * l + 1);
}

static double compute_lobe_moment(np_phase_lobe lobe, int l) {
  double g = lobe.asymmetry, alpha = lobe.alpha;
  double mu2 = ((l + 1) * compute_mu_hg_moment(g, l + 1) + l * compute_mu_hg_moment(g, l - 1)) / (2 * l + 1);
  return (compute_hg_moment(g, l) + alpha * mu2) / compute_norm(lobe);
}

void np_phase_get_moments(const np_phase *phase, unsigned count, double *out_moments) {
  double w = phase->weight, third = phase->third_weight, share = phase->table ? (double)phase->table_weight : 0.0;
  if (phase->table) np_phase_table_get_moments(phase->table, count, out_moments);
  for (unsigned l = 0; l < count; l++) {
    double lobes =
        (1.0 - w) * compute_lobe_moment(phase->lobe[0], (int)l) + w * compute_lobe_moment(phase->lobe[1], (int)l);
    if (third > 0.0) lobes += third * (compute_lobe_moment(phase->lobe[2], (int)l) - lobes);
    out_moments[l] = phase->table ? share * out_moments[l] + (1.0 - share) * lobes : lobes;
  }
}

np_phase np_phase_broaden(const np_phase *phase, float factor) {
  np_phase result = *phase;
  for (int i = 0; i < NP_PHASE_LOBES; i++) {
    result.lobe[i].asymmetry *= factor;
    result.lobe[i].alpha *= factor;
  }
  result.table_weight *= factor;
  return result;
}

/* ---- Sources ---- */

static np_phase make_rayleigh(const np_phase_source *s) { return (void)s, np_phase_rayleigh(); }

static np_phase make_isotropic(const np_phase_source *s) { return (void)s, np_phase_isotropic(); }

static np_phase make_droplets(const np_phase_source *s) { return np_phase_droplets(s->diameter_m); }

static np_phase make_henyey_greenstein(const np_phase_source *s) {
  return np_phase_henyey_greenstein((float)s->asymmetry);
}

static np_phase make_two_lobe(const np_phase_source *s) {
  return np_phase_two_lobe((float)s->forward, (float)s->backward, (float)s->backward_weight);
}

static np_phase make_cornette_shanks(const np_phase_source *s) { return np_phase_cornette_shanks((float)s->asymmetry); }

static np_phase make_haze(const np_phase_source *s) { return np_phase_haze(s->asymmetry); }

static np_phase make_draine(const np_phase_source *s) {
  return np_phase_draine((float)s->draine_asymmetry, (float)s->alpha);
}

static np_phase (*const makers[NP_PHASE_COUNT])(const np_phase_source *) = {
    [NEPH_PHASE_DROPLETS] = make_droplets,   [NEPH_PHASE_HENYEY_GREENSTEIN] = make_henyey_greenstein,
    [NEPH_PHASE_TWO_LOBE] = make_two_lobe,   [NEPH_PHASE_RAYLEIGH] = make_rayleigh,
    [NEPH_PHASE_ISOTROPIC] = make_isotropic, [NEPH_PHASE_CORNETTE_SHANKS] = make_cornette_shanks,
    [NEPH_PHASE_DRAINE] = make_draine,       [NEPH_PHASE_TABLE] = make_isotropic,
    [NEPH_PHASE_MIE] = make_isotropic,       [NEPH_PHASE_RAIN] = make_isotropic,
    [NEPH_PHASE_ICE] = make_isotropic,       [NEPH_PHASE_HAZE] = make_haze,
};

np_phase np_phase_make(const np_phase_source *source) {
  assert((unsigned)source->kind < NP_PHASE_COUNT);
  return makers[source->kind](source);
}

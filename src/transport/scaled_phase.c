/* SPDX-License-Identifier: Apache-2.0 */
/* Delta-M scaling (Wiscombe 1977, "The Delta-M Method", eqs. 7 to 13) and the forward peak beyond it.
 *
 * With Legendre moments χ_l and f = χ_{N+1} the phase function is p = (1−f)·p′ + f·B₁, p′ of degree N with moments
 * c_l = (χ_l−f)/(1−f), and a rest B₁ with moments π_l = 1 for l ≤ N + 1, χ_l/f beyond. Scattering by B₁ counts as going
 * straight on, except in light that comes from the sun without any other scattering: there the small-angle spreading
 * is carried exactly in the number of scatterings (Goudsmit and Saunderson 1940, "Multiple Scattering of Electrons",
 * whose moments after a depth t of peak scattering are e^{−t(1−π_l)}). On top of the sunlight that the scaled medium
 * lets through, a point sees per unit of scattering, with t_s, t_v the peak-scattering depths to sun and camera,
 *
 *     D = (1−f)·p′(θ) + e^{−t_v}·Σ (2l+1)/4π · f·π_l · e^{−t_s(1−π_l)} · P_l(cosθ)
 *
 * the last scattering being a broad one with the peak's spreading on either side of it (whose moments are 1 where p′
 * has any), or one of the peak, after which nothing else happens. The term of e^{−t_s}·f·B₁ = e^{−t_s}·(p − (1−f)p′) is
 * taken out of the sum and evaluated exactly; left is the smooth Σ (2l+1)/4π·fπ_l·(e^{−t_s(1−π_l)} − e^{−t_s})·P_l.
 *
 * A phase function without a forward peak (χ₁ or χ_{N+1} not positive) is left unscaled: f = 0, D = p. */
#include "transport/scaled_phase.h"

#include "core/alloc.h"

/* Moments below this have no part in any second order; more than 4096 only occur for |g| > 0.998. */
static const double moment_end = 1e-3;
enum { MOMENTS_MAX = 4096, BAND_MOMENTS_MAX = 1024 };

static float node_angle(unsigned i) {
  const float u = (float)i / (float)(NP_PEAK_ANGLES - 1);
  return NP_PI_F * u * u;
}

/* (2l+1)/4π·fπ_l·(e^{−t(1−π_l)} − e^{−t}) for one l at every depth of the table. */
static void fill_degree(const np_scaled_phase *s, unsigned l, double moment, float out[NP_PEAK_DEPTHS]) {
  const double forward = (double)s->forward, pi = l <= s->degree + 1 ? 1.0 : moment / forward;
  for (unsigned k = 0; k < NP_PEAK_DEPTHS; k++) {
    const double t = (double)NP_PEAK_DEPTH_SCALE * expm1((double)NP_PEAK_DEPTH_RATE * k);
    out[k] = (float)((2 * l + 1) / (4.0 * NP_PI) * forward * pi * (exp(-t * (1.0 - pi)) - exp(-t)));
  }
}

static void add_degree(np_scaled_phase *s, const float degree[NP_PEAK_DEPTHS], const double *legendre) {
  for (unsigned i = 0; i < NP_PEAK_ANGLES; i++)
    for (unsigned k = 0; k < NP_PEAK_DEPTHS; k++) s->peak[i * NP_PEAK_DEPTHS + k] += (float)legendre[i] * degree[k];
}

/* Sums the series, with P_l at all angles advanced together by the three-term recurrence. */
static void fill_peak(np_scaled_phase *s, const double *moments, unsigned count) {
  double cosine[NP_PEAK_ANGLES], now[NP_PEAK_ANGLES], before[NP_PEAK_ANGLES];
  for (unsigned i = 0; i < NP_PEAK_ANGLES; i++) {
    cosine[i] = cos((double)node_angle(i));
    now[i] = 1.0;
    before[i] = 0.0;
  }
  for (unsigned l = 0; l < count; l++) {
    float degree[NP_PEAK_DEPTHS];
    fill_degree(s, l, moments[l], degree);
    add_degree(s, degree, now);
    for (unsigned i = 0; i < NP_PEAK_ANGLES; i++) {
      const double next = ((2 * l + 1) * cosine[i] * now[i] - l * before[i]) / (l + 1);
      before[i] = now[i];
      now[i] = next;
    }
  }
}

/* Fades the moments out where they go beyond the last, as diffraction by ice and raindrops does: the sum would ring at
 * all angles. Light that the peak scatters twice and more is spread by another 0.15°. */
static void fade_moments(double *moments, unsigned count) {
  const double end = 0.37 * count;
  for (unsigned l = 0; l < count; l++) moments[l] *= exp(-(l / end) * (l / end));
}

float np_scaled_phase_compute_forward(const np_phase *phase, unsigned degree) {
  double moments[NP_DEGREE_MAX + 2];
  np_phase_get_moments(phase, degree + 2, moments);
  return moments[1] > 0.0 ? (float)fmax(0.0, moments[degree + 1]) : 0.0f;
}

neph_result np_scaled_phase_init(neph_context *context, const np_phase *phase, unsigned degree, np_scaled_phase *out) {
  *out = (np_scaled_phase){.context = context, .phase = *phase, .degree = degree};
  double *moments = np_alloc(context, MOMENTS_MAX, sizeof *moments);
  out->peak = np_alloc(context, (size_t)NP_PEAK_ANGLES * NP_PEAK_DEPTHS, sizeof *out->peak);
  if (!moments || !out->peak) {
    np_alloc_free(context, moments);
    np_scaled_phase_clear(out);
    return NEPH_ERROR_OUT_OF_MEMORY;
  }
  np_phase_get_moments(phase, degree + 2, moments);
  out->forward = np_scaled_phase_compute_forward(phase, degree);
  out->least_forward = np_scaled_phase_compute_forward(phase, NP_DEGREE_MIN);
  for (unsigned l = 0; l <= degree; l++) out->moments[l] = (float)moments[l] - out->forward;
  if (out->forward > 0.0f) {
    const unsigned most = phase->bands ? BAND_MOMENTS_MAX : MOMENTS_MAX;
    unsigned count = most / 16;
    np_phase_get_moments(phase, count, moments);
    for (; count < most && fabs(moments[count - 1]) > moment_end; np_phase_get_moments(phase, count, moments))
      count *= 4;
    if (phase->bands && fabs(moments[count - 1]) > moment_end) fade_moments(moments, count);
    while (count > degree + 2 && fabs(moments[count - 1]) < moment_end) count--;
    fill_peak(out, moments, count);
  }
  np_alloc_free(context, moments);
  return NEPH_OK;
}

void np_scaled_phase_clear(np_scaled_phase *scaled) {
  np_alloc_free(scaled->context, scaled->peak);
  *scaled = (np_scaled_phase){0};
}

void np_scaled_phase_fill_column(const np_scaled_phase *s, float versine, np_peak_column *out) {
  const float mu = 1.0f - versine;
  float now = 1.0f, before = 0.0f;
  out->broad = 0.0f;
  for (unsigned l = 0; l <= s->degree; l++) {
    const float n = (float)l, next = ((2.0f * n + 1.0f) * mu * now - n * before) / (n + 1.0f);
    out->broad += (2.0f * n + 1.0f) / (4.0f * NP_PI_F) * s->moments[l] * now;
    before = now;
    now = next;
  }
  out->sharp = np_spectrum_subtract(np_phase_eval_bands(&s->phase, versine), np_spectrum_grey(out->broad));
  const float angle = 2.0f * asinf(sqrtf(fminf(0.5f * versine, 1.0f)));
  const float x = sqrtf(angle / NP_PI_F) * (float)(NP_PEAK_ANGLES - 1);
  const unsigned lower = x < (float)(NP_PEAK_ANGLES - 2) ? (unsigned)x : NP_PEAK_ANGLES - 2;
  const float *low = s->peak + lower * NP_PEAK_DEPTHS, *high = low + NP_PEAK_DEPTHS, t = x - (float)lower;
  for (unsigned k = 0; k < NP_PEAK_DEPTHS; k++) out->peak[k] = low[k] + t * (high[k] - low[k]);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Lorenz-Mie series. The logarithmic derivative D_n of ψ_n(mx) comes from downward recurrence, ψ_n(x) and χ_n(x) from
 * upward recurrence, and the number of terms from Wiscombe 1980, "Improved Mie scattering algorithms", eq. 8.
 *
 * Angles are summed in the combinations S₁ ± S₂ = Σ (2n+1)/(n(n+1))·(a_n ± b_n)·(π_n ± τ_n), four real products a term;
 * |S₁|² + |S₂|² = (|S₁+S₂|² + |S₁−S₂|²)/2. */
#include "optics/mie.h"

#include <assert.h>
#include <complex.h>
#include <math.h>

#include "core/alloc.h"
#include "core/units.h"

enum { SIZES_MAX = 400, ANGLE_BLOCK = 32 };

/* A sphere's coefficients, n from 1. */
typedef struct mie_series {
  unsigned count;
  double complex *a, *b;
} mie_series;

static unsigned count_terms(double x) { return (unsigned)(x + 4.05 * cbrt(x) + 2.0); }

/* D_n(mx), n from 0 to `count`. */
static void fill_derivatives(double complex argument, unsigned start, unsigned count, double complex *out) {
  double complex d = 0.0;
  for (unsigned n = start; n > 0; n--) {
    if (n <= count) out[n] = d;
    const double complex ratio = n / argument;
    d = ratio - 1.0 / (d + ratio);
  }
  out[0] = d;
}

static void fill_series(double x, double complex m, const double complex *derivatives, mie_series *s) {
  double psi_before = cos(x), psi = sin(x), chi_before = -sin(x), chi = cos(x);
  for (unsigned n = 1; n <= s->count; n++) {
    const double factor = (2.0 * n - 1.0) / x, psi_next = factor * psi - psi_before;
    const double chi_next = factor * chi - chi_before;
    const double complex xi = CMPLX(psi_next, -chi_next), xi_before = CMPLX(psi, -chi);
    const double complex electric = derivatives[n] / m + n / x, magnetic = m * derivatives[n] + n / x;
    s->a[n] = (electric * psi_next - psi) / (electric * xi - xi_before);
    s->b[n] = (magnetic * psi_next - psi) / (magnetic * xi - xi_before);
    psi_before = psi;
    psi = psi_next;
    chi_before = chi;
    chi = chi_next;
  }
}

static void clear_series(neph_context *context, mie_series *s) { np_alloc_free(context, s->a); }

static neph_result make_series(neph_context *context, double x, np_refractive_index index, mie_series *out) {
  assert(x > 0.0 && index.imaginary >= 0.0);
  const double complex m = CMPLX(index.real, index.imaginary);
  const double inner = cabs(m) * x;
  const unsigned count = count_terms(x), start = (unsigned)fmax(count, inner + 8.0 * cbrt(inner)) + 16;
  *out = (mie_series){.count = count, .a = np_alloc(context, 3 * ((size_t)count + 1), sizeof *out->a)};
  if (!out->a) return NEPH_ERROR_OUT_OF_MEMORY;
  out->b = out->a + count + 1;
  fill_derivatives(m * x, start, count, out->b + count + 1);
  fill_series(x, m, out->b + count + 1, out);
  return NEPH_OK;
}

static double real_product(double complex a, double complex b) { return creal(a) * creal(b) + cimag(a) * cimag(b); }

static np_mie_efficiency sum_series(const mie_series *s, double x) {
  double extinction = 0.0, scattering = 0.0, cosine = 0.0;
  for (unsigned n = 1; n <= s->count; n++) {
    const double weight = 2.0 * n + 1.0;
    extinction += weight * creal(s->a[n] + s->b[n]);
    scattering += weight * (real_product(s->a[n], s->a[n]) + real_product(s->b[n], s->b[n]));
    cosine += weight / (n * (n + 1.0)) * real_product(s->a[n], s->b[n]);
    if (n < s->count)
      cosine += n * (n + 2.0) / (n + 1.0) * (real_product(s->a[n], s->a[n + 1]) + real_product(s->b[n], s->b[n + 1]));
  }
  const double factor = 2.0 / (x * x);
  return (np_mie_efficiency){factor * extinction, factor * scattering, 2.0 * cosine / scattering};
}

neph_result np_mie_compute_sphere(neph_context *context, double size_parameter, np_refractive_index index,
                                  np_mie_efficiency *out) {
  mie_series series;
  const neph_result result = make_series(context, size_parameter, index, &series);
  if (result) return result;
  *out = sum_series(&series, size_parameter);
  clear_series(context, &series);
  return NEPH_OK;
}

/* ---- Sizes ---- */

/* Spheres of one size: the series' sums over a ± b, each with its factor. */
typedef struct mie_size {
  double radius_m, share; /* share of all spheres */
  mie_series series;
  np_mie_efficiency efficiency;
} mie_size;

typedef struct mie_task {
  neph_context *context;
  double wavenumber; /* 1/m */
  np_refractive_index index;
  unsigned size_count, angle_count;
  mie_size size[SIZES_MAX];
  const double *angle_rad;
  double *values;
  double scattering_m2;
} mie_task;

/* Sizes that differ by less count as one. */
static const double variance_min = 1e-6;

/* Logarithm of the geometric cross section at a radius over that at the mode, in units of the effective radius. */
static double log_area(double r, double b) {
  const double power = 1.0 / b - 1.0, mode = 1.0 - b;
  return power * log(r / mode) - (r - mode) / b;
}

/* Radius on one side of the mode beyond which there is less than e^{−14} of the area at the mode. */
static double compute_end(double b, bool is_upper) {
  double inner = 1.0 - b, outer = is_upper ? 2.0 : 0.0;
  while (is_upper && log_area(outer, b) > -14.0) outer *= 2.0;
  for (int i = 0; i < 50; i++) {
    const double middle = 0.5 * (inner + outer);
    if (log_area(middle, b) > -14.0)
      inner = middle;
    else
      outer = middle;
  }
  return outer;
}

static void fill_sizes(mie_task *t, const np_mie_sizes *sizes) {
  const double a = sizes->effective_radius_m, b = sizes->effective_variance;
  if (b < variance_min) {
    t->size_count = 1;
    t->size[0] = (mie_size){.radius_m = a, .share = 1.0};
    return;
  }
  const double low = compute_end(b, false), high = compute_end(b, true);
  t->size_count = SIZES_MAX;
  for (unsigned i = 0; i < SIZES_MAX; i++) {
    const double r = low + (high - low) * (i + 0.5) / SIZES_MAX;
    t->size[i] = (mie_size){.radius_m = a * r, .share = exp(log_area(r, b)) / (r * r)};
  }
}

static neph_result expand_size(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  mie_task *t = user;
  neph_result result = NEPH_OK;
  for (size_t i = begin; i < end && !result; i++) {
    mie_size *s = &t->size[i];
    const double x = t->wavenumber * s->radius_m;
    result = make_series(t->context, x, t->index, &s->series);
    if (result) return result;
    s->efficiency = sum_series(&s->series, x);
    for (unsigned n = 1; n <= s->series.count; n++) {
      const double complex a = s->series.a[n], b = s->series.b[n];
      const double factor = (2.0 * n + 1.0) / (n * (n + 1.0));
      s->series.a[n] = factor * (a + b);
      s->series.b[n] = factor * (a - b);
    }
  }
  return result;
}

/* ---- Angles ---- */

typedef struct angle_block {
  double cosine[ANGLE_BLOCK], pi[ANGLE_BLOCK], pi_before[ANGLE_BLOCK];
  double sum[4][ANGLE_BLOCK]; /* S₁ + S₂ and S₁ − S₂, real and imaginary */
} angle_block;

/* Adds term n to the sums, and moves π_n on by one. */
static void add_term(angle_block *block, unsigned n, double complex plus, double complex minus) {
  const double up = (2.0 * n + 1.0) / n, back = (n + 1.0) / n, degree = n;
  const double p0 = creal(plus), p1 = cimag(plus), m0 = creal(minus), m1 = cimag(minus);
  for (int j = 0; j < ANGLE_BLOCK; j++) {
    const double pi = block->pi[j], before = block->pi_before[j], rise = block->cosine[j] * pi;
    const double tau = degree * rise - (degree + 1.0) * before, sum = pi + tau, difference = pi - tau;
    block->sum[0][j] += p0 * sum;
    block->sum[1][j] += p1 * sum;
    block->sum[2][j] += m0 * difference;
    block->sum[3][j] += m1 * difference;
    block->pi_before[j] = pi;
    block->pi[j] = up * rise - back * before;
  }
}

static void add_size(angle_block *block, const mie_size *size, double out[ANGLE_BLOCK]) {
  for (int j = 0; j < ANGLE_BLOCK; j++) {
    block->pi[j] = 1.0;
    block->pi_before[j] = 0.0;
    for (int k = 0; k < 4; k++) block->sum[k][j] = 0.0;
  }
  for (unsigned n = 1; n <= size->series.count; n++) add_term(block, n, size->series.a[n], size->series.b[n]);
  for (int j = 0; j < ANGLE_BLOCK; j++)
    for (int k = 0; k < 4; k++) out[j] += 0.25 * size->share * block->sum[k][j] * block->sum[k][j];
}

static neph_result sum_angles(void *user, size_t begin, size_t end, unsigned thread) {
  (void)thread;
  const mie_task *t = user;
  for (size_t i = begin; i < end; i++) {
    angle_block block;
    double intensity[ANGLE_BLOCK] = {0};
    const unsigned first = (unsigned)i * ANGLE_BLOCK;
    for (unsigned j = 0; j < ANGLE_BLOCK; j++)
      block.cosine[j] = cos(t->angle_rad[first + j < t->angle_count ? first + j : t->angle_count - 1]);
    for (unsigned k = 0; k < t->size_count; k++) add_size(&block, &t->size[k], intensity);
    const double factor = 1.0 / (t->wavenumber * t->wavenumber * t->scattering_m2);
    for (unsigned j = 0; j < ANGLE_BLOCK && first + j < t->angle_count; j++)
      t->values[first + j] = factor * intensity[j];
  }
  return NEPH_OK;
}

static np_mie_efficiency sum_sizes(mie_task *t) {
  double area = 0.0, extinction = 0.0, scattering = 0.0, cosine = 0.0;
  for (unsigned i = 0; i < t->size_count; i++) {
    const mie_size *s = &t->size[i];
    const double own = s->share * NP_PI * s->radius_m * s->radius_m;
    area += own;
    extinction += own * s->efficiency.extinction;
    scattering += own * s->efficiency.scattering;
    cosine += own * s->efficiency.scattering * s->efficiency.asymmetry;
  }
  t->scattering_m2 = scattering;
  return (np_mie_efficiency){extinction / area, scattering / area, cosine / scattering};
}

neph_result np_mie_compute_phase(neph_context *context, np_monitor *monitor, const np_mie_sizes *sizes,
                                 double wavelength_m, np_refractive_index index, unsigned count,
                                 const double *angle_rad, double *out_values, np_mie_efficiency *out_mean) {
  assert(count > 0 && sizes->effective_variance <= 0.4);
  mie_task *t = np_alloc(context, 1, sizeof *t);
  if (!t) return NEPH_ERROR_OUT_OF_MEMORY;
  *t = (mie_task){.context = context,
                  .wavenumber = 2.0 * NP_PI / wavelength_m,
                  .index = index,
                  .angle_count = count,
                  .angle_rad = angle_rad,
                  .values = out_values};
  fill_sizes(t, sizes);
  neph_result result = np_parallel_for(context, monitor, t->size_count, 8, expand_size, t);
  if (!result) *out_mean = sum_sizes(t);
  if (!result) result = np_parallel_for(context, monitor, (count + ANGLE_BLOCK - 1) / ANGLE_BLOCK, 1, sum_angles, t);
  for (unsigned i = 0; i < t->size_count; i++) clear_series(context, &t->size[i].series);
  np_alloc_free(context, t);
  return result;
}

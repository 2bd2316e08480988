/* SPDX-License-Identifier: Apache-2.0 */
/* Half of what a large sphere scatters is diffracted at its rim, the other half is reflected and refracted. A ray that
 * meets the sphere at the angle of incidence i leaves it after p − 1 reflections inside, turned by
 *
 *     D₀ = π − 2i,   D_p = 2(i − r) + (p − 1)(π − 2r),   sin i = n·sin r,
 *
 * with the share R for p = 0 and (1 − R)²·R^{p−1} beyond, Fresnel's R as the mean over both polarisations. Where D_p is
 * least rays bunch up into a rainbow, and the intensity of rays, C/√δ at an angle δ beyond it, is replaced by Airy's
 * (Airy 1838, "On the intensity of light in the neighbourhood of a caustic"; van de Hulst 1957, "Light Scattering by
 * Small Particles", section 13.23):
 *
 *     C·2π√k·Ai²(−kδ),   k = (x²/h)^{1/3},   h = (p² − 1)²/p²·√((p² − n²)/(n² − 1)³)
 *
 * whose mean over its fringes is C/√δ again. */
#include "optics/raindrop.h"

#include <math.h>

#include "core/alloc.h"
#include "core/units.h"

enum { ORDERS = 4, INCIDENCES = 20000, SIZES = 48 };

/* ---- Sizes ---- */

/* Node of the distribution of area over radius: the radius over the effective one, and its share. */
typedef struct size_node {
  double radius, share;
} size_node;

/* Even nodes in the logarithm of the radius. */
static void fill_sizes(double variance, size_node out[SIZES]) {
  double sum = 0.0;
  for (int i = 0; i < SIZES; i++) {
    const double r = exp(log(0.1) + (log(4.0) - log(0.1)) * (i + 0.5) / SIZES);
    out[i].radius = r;
    out[i].share = exp(log(r) / variance - r / variance); /* r²·n(r)·r, the last r from d(log r) */
    sum += out[i].share;
  }
  for (int i = 0; i < SIZES; i++) out[i].share /= sum;
}

/* Energy within the disk's rings: p = x²/4π·(2J₁(z)/z)², z = x·sinθ, of small angles, beyond which it fades. */
static double diffract(double x, double angle) {
  const double z = x * sin(angle), tilt = 0.5 * (1.0 + cos(angle));
  const double ring = z > 1e-4 ? 2.0 * j1(z) / z : 1.0;
  return x * x / (4.0 * NP_PI) * ring * ring * tilt * tilt;
}

void np_diffraction_fill(double effective_radius_m, double effective_variance, double wavelength_m, unsigned count,
                         const double *angle_rad, double *out_values) {
  size_node sizes[SIZES];
  fill_sizes(effective_variance, sizes);
  const double x = 2.0 * NP_PI * effective_radius_m / wavelength_m;
  for (unsigned i = 0; i < count; i++) {
    out_values[i] = 0.0;
    for (int k = 0; k < SIZES && angle_rad[i] < 0.5 * NP_PI; k++)
      out_values[i] += sizes[k].share * diffract(x * sizes[k].radius, angle_rad[i]);
  }
}

/* ---- Airy's function ---- */

/* Ai(z): its power series near 0, and its asymptotic forms beyond (Abramowitz and Stegun 1964, 10.4.2, 59 and 60);
 * right to 1e-3. */
static double eval_airy(double z) {
  if (fabs(z) < 4.0) {
    double f = 1.0, g = z, term_f = 1.0, term_g = z;
    for (int k = 1; k < 60; k++) {
      term_f *= z * z * z / ((3.0 * k - 1.0) * (3.0 * k));
      term_g *= z * z * z / ((3.0 * k) * (3.0 * k + 1.0));
      f += term_f;
      g += term_g;
    }
    return 0.355028053887817 * f - 0.258819403792807 * g;
  }
  const double zeta = 2.0 / 3.0 * pow(fabs(z), 1.5), root = sqrt(NP_PI) * pow(fabs(z), 0.25);
  if (z > 0.0) return 0.5 * exp(-zeta) / root * (1.0 - 5.0 / (72.0 * zeta));
  const double phase = zeta + 0.25 * NP_PI;
  return (sin(phase) - 5.0 / (72.0 * zeta) * cos(phase)) / root;
}

/* ---- Rays ---- */

/* Share of the light that rays of an order carry at an angle of incidence. */
static double compute_share(double incidence, double index, int order) {
  const double refracted = asin(sin(incidence) / index), cosine = cos(incidence), inner = cos(refracted);
  const double across = (cosine - index * inner) / (cosine + index * inner);
  const double along = (index * cosine - inner) / (index * cosine + inner);
  const double reflected[2] = {across * across, along * along};
  double sum = 0.0;
  for (int s = 0; s < 2; s++) {
    const double r = reflected[s], passed = (1.0 - r) * (1.0 - r);
    sum += 0.5 * (order == 0 ? r : passed * pow(r, order - 1));
  }
  return sum;
}

static double compute_deflection(double incidence, double index, int order) {
  const double refracted = asin(fmin(sin(incidence) / index, 1.0));
  if (order == 0) return NP_PI - 2.0 * incidence;
  return 2.0 * (incidence - refracted) + (order - 1) * (NP_PI - 2.0 * refracted);
}

/* Scattering angle of a deflection. */
static double fold(double deflection) {
  const double turn = fmod(fabs(deflection), 2.0 * NP_PI);
  return turn > NP_PI ? 2.0 * NP_PI - turn : turn;
}

/* First angle of an ascending list that is not below a value. */
static unsigned search(const double *angles, unsigned count, double value) {
  unsigned low = 0, high = count;
  while (low < high) {
    const unsigned middle = (low + high) / 2;
    if (angles[middle] < value)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

/* Adds the intensity of rays of one order at the angles: s·ds/(π·sinθ·dθ), s = sin i. */
static void add_rays(double index, int order, unsigned count, const double *angles, double *values) {
  for (int k = 0; k < INCIDENCES; k++) {
    const double begin = 0.5 * NP_PI * k / INCIDENCES, end = 0.5 * NP_PI * (k + 1) / INCIDENCES;
    const double first = fold(compute_deflection(begin, index, order)),
                 last = fold(compute_deflection(end, index, order));
    const double low = fmin(first, last), high = fmax(first, last), middle = 0.5 * (begin + end);
    if (!(high > low)) continue;
    const double energy = 0.5 * sin(2.0 * middle) * (end - begin) * compute_share(middle, index, order);
    const double value = energy / (NP_PI * sin(0.5 * (low + high)) * (high - low));
    for (unsigned i = search(angles, count, low); i < count && angles[i] < high; i++) values[i] += value;
  }
  values[count - 1] = values[count - 2]; /* 180° is the end of an interval, and in none */
}

/* ---- Rainbows ---- */

typedef struct rainbow {
  double angle_rad;
  double side;  /* 1: its rays go to larger angles; −1: to smaller ones */
  double width; /* h^{1/3} */
} rainbow;

/* Rays turn least where cos i = √((n² − 1)/(p² − 1)). */
static rainbow make_rainbow(double index, int order) {
  const double n2 = index * index, p2 = (double)order * order;
  const double deflection = compute_deflection(acos(sqrt((n2 - 1.0) / (p2 - 1.0))), index, order);
  const double h = (p2 - 1.0) * (p2 - 1.0) / p2 * sqrt((p2 - n2) / pow(n2 - 1.0, 3.0));
  return (rainbow){fold(deflection), fmod(deflection, 2.0 * NP_PI) > NP_PI ? -1.0 : 1.0, cbrt(h)};
}

/* Angle from a rainbow at which C is taken: rows nearer have the same. */
static const double nearest_rad = 0.1 * NP_DEGREE;

/* C of the row nearest to the rainbow on its bright side. */
static double get_strength(const rainbow *bow, unsigned count, const double *angles, const double *rays) {
  unsigned i = search(angles, count, bow->angle_rad + bow->side * nearest_rad);
  if (bow->side < 0.0 && i > 0) i--;
  return rays[i] * sqrt(fabs(angles[i] - bow->angle_rad));
}

/* Airy's intensity over C, of all sizes. */
static double eval_rainbow(const rainbow *bow, const size_node sizes[SIZES], double x, double delta) {
  double sum = 0.0;
  for (int s = 0; s < SIZES; s++) {
    const double k = pow(x * sizes[s].radius, 2.0 / 3.0) / bow->width, airy = eval_airy(-k * delta);
    sum += sizes[s].share * 2.0 * NP_PI * sqrt(k) * airy * airy;
  }
  return sum;
}

/* Angle from a rainbow beyond which its fringes are washed out, and on whose dark side nothing is left. */
static const double fringes_rad = 20.0 * NP_DEGREE;

static void spread_rainbow(const rainbow *bow, const size_node sizes[SIZES], double x, unsigned count,
                           const double *angles, double *rays) {
  const double strength = get_strength(bow, count, angles, rays);
  for (unsigned i = 0; i < count; i++) {
    const double delta = bow->side * (angles[i] - bow->angle_rad);
    if (fabs(delta) > fringes_rad) continue;
    const double own = delta > nearest_rad ? rays[i] * sqrt(delta) : strength;
    rays[i] = own * eval_rainbow(bow, sizes, x, delta);
  }
}

/* Effective variance of n(D) ∝ D³·e^{−3D/mode}, and its effective radius over the diameter of the mode. */
static const double rain_variance = 1.0 / 6.0, radius_of_mode = 1.0;

neph_result np_raindrop_compute_phase(neph_context *context, double mode_diameter_m, double wavelength_m, double index,
                                      unsigned count, const double *angle_rad, double *out_values) {
  size_node sizes[SIZES];
  double *rays = np_alloc(context, count, sizeof *rays);
  if (!rays) return NEPH_ERROR_OUT_OF_MEMORY;
  const double radius_m = radius_of_mode * mode_diameter_m, x = 2.0 * NP_PI * radius_m / wavelength_m;
  fill_sizes(rain_variance, sizes);
  np_diffraction_fill(radius_m, rain_variance, wavelength_m, count, angle_rad, out_values);
  for (int p = 0; p < ORDERS; p++) {
    for (unsigned i = 0; i < count; i++) rays[i] = 0.0;
    add_rays(index, p, count, angle_rad, rays);
    const rainbow bow = p >= 2 ? make_rainbow(index, p) : (rainbow){0};
    if (p >= 2) spread_rainbow(&bow, sizes, x, count, angle_rad, rays);
    for (unsigned i = 0; i < count; i++) out_values[i] += rays[i];
  }
  for (unsigned i = 0; i < count; i++) out_values[i] *= 0.5;
  np_alloc_free(context, rays);
  return NEPH_OK;
}

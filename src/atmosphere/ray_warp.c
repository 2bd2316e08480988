/* SPDX-License-Identifier: Apache-2.0 */
/* A change of variable from u to C(u) = ½·u + ½·∫ρ du/∫ρ. ρ is the light scattered along the ray and transmitted to its
 * start, by tents, tables and cut layers alone if there are any. ρ is linear between knots, which are uniform in u, and
 * at the ray's crossings of kinks of profiles, so that C and its slope are continuous and have a closed form. A rule in
 * C has half of its points in the layers of ρ, however thin, and an integrand that is smooth except at its kinks. */
#include "atmosphere/ray_warp.h"

#include "atmosphere/ray_cuts.h"

enum { KNOTS_EVEN = 48, CUTS_MOST = 40, KNOTS_MAX = KNOTS_EVEN + 2 * CUTS_MOST + 8 };

static float sum_bands(np_bands value) { return value[0] + value[1] + value[2]; }

/* Scattering that attracts points at an altitude, summed over the bands. */
static double compute_density(const np_medium *medium, double altitude_m) {
  double sum = 0.0;
  for (int i = 0; i < medium->layer_count; i++) {
    const np_layer *layer = &medium->layers[i];
    if (medium->has_profile_kinks && !np_layer_has_profile_kinks(layer)) continue;
    sum += np_layer_density_exact(layer, fmax(altitude_m, 0.0)) * (double)sum_bands(np_layer_scattering(layer));
  }
  return sum;
}

typedef struct warp {
  int count;
  double u[KNOTS_MAX], slope[KNOTS_MAX], sum[KNOTS_MAX]; /* C′ and C at the knots */
} warp;

static void add_knot(warp *w, double u) {
  if (!(u > 0.0 && u < 1.0) || w->count == KNOTS_MAX - 1) return;
  int i = w->count++;
  for (; i > 0 && w->u[i - 1] > u; i--) w->u[i] = w->u[i - 1];
  w->u[i] = u;
}

static void place_knots(const np_medium *medium, const np_ray *ray, double begin_m, double end_m, int power, warp *w) {
  w->count = 0;
  for (int i = 0; i <= KNOTS_EVEN; i++) w->u[w->count++] = (double)i / KNOTS_EVEN;
  np_ray_cuts cuts = np_ray_cuts_make(medium, ray, CUTS_MOST);
  const double last = fmax(begin_m, end_m);
  for (double t = np_ray_cuts_next(&cuts); t < last; t = np_ray_cuts_next(&cuts)) {
    const double part = (t - begin_m) / (end_m - begin_m);
    if (part > 0.0) add_knot(w, power == 2 ? sqrt(part) : part);
  }
}

static void sum_slopes(warp *w) {
  double total = 0.0;
  for (int i = 0; i + 1 < w->count; i++) total += 0.5 * (w->slope[i] + w->slope[i + 1]) * (w->u[i + 1] - w->u[i]);
  for (int i = 0; i < w->count; i++) w->slope[i] = total > 0.0 ? 0.5 + 0.5 * w->slope[i] / total : 1.0;
  w->sum[0] = 0.0;
  for (int i = 0; i + 1 < w->count; i++)
    w->sum[i + 1] = w->sum[i] + 0.5 * (w->slope[i] + w->slope[i + 1]) * (w->u[i + 1] - w->u[i]);
}

/* u at which C has a value: a quadratic between two knots, solved without cancellation. */
static double invert(const warp *w, double value, double *out_slope) {
  int i = 0;
  while (i + 2 < w->count && w->sum[i + 1] < value) i++;
  const double step = w->u[i + 1] - w->u[i], curvature = (w->slope[i + 1] - w->slope[i]) / fmax(step, 1e-300);
  const double rest = fmax(value - w->sum[i], 0.0), slope = w->slope[i];
  const double root = sqrt(fmax(slope * slope + 2.0 * curvature * rest, 0.0));
  *out_slope = root;
  return fmin(w->u[i] + 2.0 * rest / (slope + root), w->u[i + 1]);
}

static double compute_distance(double begin_m, double end_m, int power, double u) {
  return begin_m + (end_m - begin_m) * (power == 2 ? u * u : u);
}

/* ρ at the knots, by the trapezoidal depth from the knot nearest to the ray's start. */
static void compute_slopes(const np_medium *medium, const np_ray *ray, double begin_m, double end_m, int power,
                           warp *w) {
  double depth = 0.0, before = 0.0, extinction_before = 0.0;
  for (int k = 0; k < w->count; k++) {
    const int i = end_m >= begin_m ? k : w->count - 1 - k;
    const double t = compute_distance(begin_m, end_m, power, w->u[i]), altitude = np_ray_altitude(ray, t);
    const double extinction = (double)sum_bands(np_extinction_at(medium, altitude)) / NP_BAND_COUNT;
    if (k) depth += 0.5 * (extinction + extinction_before) * fabs(t - before);
    before = t;
    extinction_before = extinction;
    w->slope[i] = exp(-depth) * compute_density(medium, altitude) * (power == 2 ? w->u[i] : 1.0);
  }
}

np_quadrature np_warp_rule(const np_medium *medium, const np_ray *ray, double begin_m, double end_m, int power,
                           const np_quadrature *rule) {
  warp w;
  place_knots(medium, ray, begin_m, end_m, power, &w);
  compute_slopes(medium, ray, begin_m, end_m, power, &w);
  sum_slopes(&w);
  np_quadrature warped = {.count = rule->count};
  for (int i = 0; i < rule->count; i++) {
    double slope;
    warped.x[i] = invert(&w, rule->x[i] * w.sum[w.count - 1], &slope);
    warped.weight[i] = rule->weight[i] * w.sum[w.count - 1] / slope;
  }
  return warped;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Doubling (van de Hulst 1963; de Haan, Bosma and Hovenier 1987, "The adding method for multiple scattering
 * calculations of polarized light", eqs. 85 to 91) of kernels r and t for each Fourier mode m of the azimuth:
 *
 *     I(μ, φ) = 1/π ∫∫ r(μ, μ', φ − φ') μ' I(μ', φ') dμ' dφ',   r = Σ (2 − δ_m0) r_m cos m(φ − φ')
 *
 * on Gauss points of (0, 1), to which the directions of sun and viewer are added with the weight 0. The first layer is
 * so thin that it scatters once. The forward peak is cut by delta-M (Wiscombe 1977), and first-order scattering is
 * restored with the whole phase function (Nakajima and Tanaka 1988, method TMS). */
#include "optics/slab_reflectance.h"

#include <math.h>
#include <string.h>

#include "core/alloc.h"
#include "core/math.h"
#include "core/units.h"

enum {
  POINTS = 24,
  SUN = POINTS,
  VIEW,
  SIZE,
  MOMENTS = 2 * POINTS,
  STEPS = 4,    /* depths in a factor of 2 */
  HALVINGS = 12 /* number of halvings of the first depth */
};

static const double depth_low = 0.02;
static const double mode_negligible = 1e-6; /* relative to the sum */

typedef double matrix[SIZE][SIZE];

typedef struct slab_layer {
  matrix r, t;
  double direct[SIZE]; /* transmittance */
} slab_layer;

typedef struct doubling {
  const np_slab_view *view;
  double mu[SIZE], weight[SIZE]; /* weight: 2·μ·w */
  double moments[MOMENTS];       /* Legendre moments without the forward peak */
  double cut, albedo;            /* forward peak; albedo without it */
  slab_layer own;
  matrix s, q, d, u, product; /* workspace */
} doubling;

/* ---- Points ---- */

/* Gauss-Legendre points of (0, 1), by Newton's method. */
static void set_points(doubling *d) {
  for (int i = 0; i < POINTS; i++) {
    double x = cos(NP_PI * (i + 0.75) / (POINTS + 0.5)), slope = 1;
    for (int round = 0; round < 20; round++) {
      double below = 1, value = x;
      for (int l = 2; l <= POINTS; l++) {
        const double next = ((2 * l - 1) * x * value - (l - 1) * below) / l;
        below = value;
        value = next;
      }
      slope = POINTS * (x * value - below) / (x * x - 1);
      x -= value / slope;
    }
    d->mu[i] = 0.5 * (1 + x);
    d->weight[i] = 2 * d->mu[i] / ((1 - x * x) * slope * slope);
  }
  d->mu[SUN] = d->view->mu_sun;
  d->mu[VIEW] = d->view->mu_view;
}

static void set_phase(doubling *d) {
  double moments[MOMENTS + 1];
  np_phase_get_moments(d->view->phase, MOMENTS + 1, moments);
  d->cut = fmax(moments[MOMENTS], 0.0);
  d->albedo = d->view->albedo * (1 - d->cut) / (1 - d->view->albedo * d->cut);
  for (int l = 0; l < MOMENTS; l++) d->moments[l] = (moments[l] - d->cut) / (1 - d->cut);
}

/* Associated Legendre functions of order m, times √((l − m)!/(l + m)!). */
static void compute_legendre(int m, double mu, double out[MOMENTS]) {
  double start = 1;
  const double sine = sqrt(fmax(1 - mu * mu, 0.0));
  for (int i = 1; i <= m; i++) start *= sine * sqrt((2 * i - 1) / (2.0 * i));
  memset(out, 0, MOMENTS * sizeof *out);
  if (m >= MOMENTS) return;
  out[m] = start;
  if (m + 1 < MOMENTS) out[m + 1] = mu * sqrt(2 * m + 1) * start;
  for (int l = m + 2; l < MOMENTS; l++) {
    const double a = sqrt((double)(l - m) * (l + m)), b = sqrt((double)(l - 1 - m) * (l - 1 + m));
    out[l] = ((2 * l - 1) * mu * out[l - 1] - b * out[l - 2]) / a;
  }
}

/* ---- Layers ---- */

/* (e^(−τ/a) − e^(−τ/b))/(a − b) for the transmittances of two directions. */
static double compute_passage(double depth, double a, double b) {
  if (fabs(a - b) < 1e-9) return depth / (a * b) * exp(-depth / a);
  return (exp(-depth / a) - exp(-depth / b)) / (a - b);
}

/* A layer that scatters once. */
static void set_thin(doubling *d, int m, double depth) {
  double legendre[SIZE][MOMENTS];
  for (int i = 0; i < SIZE; i++) compute_legendre(m, d->mu[i], legendre[i]);
  for (int i = 0; i < SIZE; i++) {
    d->own.direct[i] = exp(-depth / d->mu[i]);
    for (int j = 0; j < SIZE; j++) {
      const double a = d->mu[i], b = d->mu[j];
      double ahead = 0, back = 0;
      for (int l = m; l < MOMENTS; l++) {
        const double term = (2 * l + 1) * d->moments[l] * legendre[i][l] * legendre[j][l];
        ahead += term;
        back += (l + m) % 2 ? -term : term;
      }
      d->own.r[i][j] = 0.25 * d->albedo * back / (a + b) * -expm1(-depth * (1 / a + 1 / b));
      d->own.t[i][j] = 0.25 * d->albedo * ahead * compute_passage(depth, a, b);
    }
  }
}

/* out = a·W·b, with the weights W of the points. */
static void multiply(const doubling *d, matrix a, matrix b, matrix out) {
  memset(out, 0, sizeof(matrix));
  for (int i = 0; i < SIZE; i++)
    for (int k = 0; k < POINTS; k++) {
      const double factor = a[i][k] * d->weight[k];
      for (int j = 0; j < SIZE; j++) out[i][j] += factor * b[k][j];
    }
}

/* Sum of all reflections between two layers, q = s + s·W·s + …, as the solution of (1 − s·W)·q = s by elimination;
 * pivots are positive, because each reflection loses energy or keeps it. */
static void sum_reflections(doubling *d) {
  matrix left;
  memcpy(d->q, d->s, sizeof(matrix));
  for (int i = 0; i < SIZE; i++)
    for (int k = 0; k < SIZE; k++) left[i][k] = (i == k) - d->s[i][k] * d->weight[k];
  for (int k = 0; k < SIZE; k++)
    for (int i = 0; i < SIZE; i++) {
      if (i == k) continue;
      const double factor = left[i][k] / left[k][k];
      if (factor == 0) continue;
      for (int j = k; j < SIZE; j++) left[i][j] -= factor * left[k][j];
      for (int j = 0; j < SIZE; j++) d->q[i][j] -= factor * d->q[k][j];
    }
  for (int i = 0; i < SIZE; i++)
    for (int j = 0; j < SIZE; j++) d->q[i][j] /= left[i][i];
}

/* Light between the layer and one with the reflection `below`: downwards d, upwards u. */
static void compute_between(doubling *d, matrix below) {
  slab_layer *own = &d->own;
  multiply(d, own->r, below, d->s);
  sum_reflections(d);
  multiply(d, d->q, own->t, d->d);
  for (int i = 0; i < SIZE; i++)
    for (int j = 0; j < SIZE; j++) d->d[i][j] += own->t[i][j] + d->q[i][j] * own->direct[j];
  multiply(d, below, d->d, d->u);
  for (int i = 0; i < SIZE; i++)
    for (int j = 0; j < SIZE; j++) d->u[i][j] += below[i][j] * own->direct[j];
}

/* Reflection of the layer with what is below it. */
static double get_reflection(doubling *d, int i, int j) {
  double sum = d->own.r[i][j] + d->own.direct[i] * d->u[i][j];
  for (int k = 0; k < POINTS; k++) sum += d->own.t[i][k] * d->weight[k] * d->u[k][j];
  return sum;
}

static void double_layer(doubling *d) {
  slab_layer *own = &d->own;
  matrix reflected;
  compute_between(d, own->r);
  for (int i = 0; i < SIZE; i++)
    for (int j = 0; j < SIZE; j++) reflected[i][j] = get_reflection(d, i, j);
  multiply(d, own->t, d->d, d->product);
  for (int i = 0; i < SIZE; i++)
    for (int j = 0; j < SIZE; j++) d->product[i][j] += own->direct[i] * d->d[i][j] + own->t[i][j] * own->direct[j];
  memcpy(own->r, reflected, sizeof(matrix));
  memcpy(own->t, d->product, sizeof(matrix));
  for (int i = 0; i < SIZE; i++) own->direct[i] *= own->direct[i];
}

static double add_ground(doubling *d, int m) {
  matrix ground;
  if (m > 0 || d->view->ground_albedo == 0) return d->own.r[VIEW][SUN];
  for (int i = 0; i < SIZE; i++)
    for (int j = 0; j < SIZE; j++) ground[i][j] = d->view->ground_albedo;
  compute_between(d, ground);
  return get_reflection(d, VIEW, SUN);
}

/* ---- Table ---- */

/* Adds a mode; returns its largest value. */
static double add_mode(doubling *d, int m, np_slab_table *table) {
  const double factor = (m ? 2 : 1) * cos(m * (NP_PI - d->view->azimuth_rad)), scale = 1 - d->view->albedo * d->cut;
  double largest = 0;
  for (int step = 0; step < STEPS; step++) {
    const double first = depth_low * exp2((double)step / STEPS);
    set_thin(d, m, scale * ldexp(first, -HALVINGS));
    for (int n = 0; n < HALVINGS; n++) double_layer(d);
    for (int n = 0; 1 + n * STEPS + step < NP_SLAB_DEPTHS; n++) {
      const int k = 1 + n * STEPS + step;
      const double value = add_ground(d, m);
      table->reflectances[k] += factor * value;
      table->depths[k] = ldexp(first, n);
      largest = fmax(largest, fabs(value));
      double_layer(d);
    }
  }
  return largest;
}

/* Restores the forward peak in first-order scattering. */
static void restore_first_order(const doubling *d, np_slab_table *table) {
  const np_slab_view *v = d->view;
  const double sines = sqrt((1 - v->mu_sun * v->mu_sun) * (1 - v->mu_view * v->mu_view));
  const double cosine = -v->mu_sun * v->mu_view - sines * cos(v->azimuth_rad);
  double truncated = 0, below = 0, value = 1;
  for (int l = 0; l < MOMENTS; l++) {
    truncated += (2 * l + 1) * d->moments[l] * value;
    const double next = ((2 * l + 1) * cosine * value - l * below) / (l + 1);
    below = value;
    value = next;
  }
  const double whole = 4 * NP_PI * (double)np_phase_eval(v->phase, (float)(1 - cosine));
  const double scale = 1 - v->albedo * d->cut, slant = 1 / v->mu_sun + 1 / v->mu_view;
  const double missing = 0.25 * (v->albedo * whole / scale - d->albedo * truncated) / (v->mu_sun + v->mu_view);
  for (int k = 1; k < NP_SLAB_DEPTHS; k++)
    table->reflectances[k] += missing * -expm1(-scale * table->depths[k] * slant);
}

neph_result np_slab_table_make(neph_context *context, const np_slab_view *view, np_slab_table *out_table) {
  doubling *d = np_alloc(context, 1, sizeof *d);
  if (!d) return NEPH_ERROR_OUT_OF_MEMORY;
  np_slab_table table = {.reflectances = {view->ground_albedo}};
  d->view = view;
  set_points(d);
  set_phase(d);
  const double first = add_mode(d, 0, &table);
  double largest = first;
  for (int m = 1; m < MOMENTS && largest > mode_negligible * first; m++) largest = add_mode(d, m, &table);
  restore_first_order(d, &table);
  *out_table = table;
  np_alloc_free(context, d);
  return NEPH_OK;
}

double np_slab_table_eval(const np_slab_table *table, double depth) {
  const double *depths = table->depths, *values = table->reflectances;
  int k = 1;
  while (k < NP_SLAB_DEPTHS - 1 && depths[k] < depth) k++;
  const double share = k == 1 ? depth / depths[1] : log(depth / depths[k - 1]) / log(depths[k] / depths[k - 1]);
  return values[k - 1] + np_clamp(share, 0.0, 1.0) * (values[k] - values[k - 1]);
}

double np_slab_table_invert(const np_slab_table *table, double reflectance) {
  const double *depths = table->depths, *values = table->reflectances;
  int k = 1;
  while (k < NP_SLAB_DEPTHS - 1 && values[k] < reflectance) k++;
  const double share = np_clamp((reflectance - values[k - 1]) / (values[k] - values[k - 1]), 0.0, 1.0);
  return k == 1 ? share * depths[1] : depths[k - 1] * pow(depths[k] / depths[k - 1], share);
}

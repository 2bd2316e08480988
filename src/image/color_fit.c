/* SPDX-License-Identifier: Apache-2.0 */
#include "image/color_fit.h"

#include <math.h>
#include <string.h>

enum { UNKNOWNS = 9, CELL_COUNT = 60 };

static const double prior_weight = 0.1, probe_y = 0.4;
static const double white[3] = {0.95047, 1.0, 1.08883};

/* Cells of 612.47, 537.53, 447.50 nm, then of 652.40, 552.52, 432.56 nm. */
const unsigned np_color_fit_cells[NP_COLOR_PROBE_BAND_COUNT] = {42, 27, 9, 50, 30, 6};

/* X, Y, Z of unit radiance in each band of a probe. */
static const double probe_xyz[NP_COLOR_PROBE_BAND_COUNT][3] = {
    {61.7848, 34.8004, 4.3015}, {-81.5391, 15.8373, 104.1674},  {40.3337, 43.1895, 144.7200},
    {19.4983, 7.4543, -0.2504}, {152.4217, 117.8619, -78.1769}, {-3.4627, -24.6985, 25.7329},
};

/* Upper triangle by rows, for 447.50 nm · X, Y, Z, 537.53 nm · X, Y, Z, 612.47 nm · X, Y, Z. Its condition number is
 * 1.5e4, which requires all these digits. */
static const double prior_gram[UNKNOWNS * (UNKNOWNS + 1) / 2] = {
    1.30287301,  -1.27349762,   0,
    0.738081563, -0.718261839,  0,
    0.52968929,  -0.515787117,  0,
    1.5120542,   -0.124902966,  -0.718261839,
    0.849067953, -0.075125099,  -0.515787117,
    0.610212986, -0.0573390604, 0.0817736791,
    0,           -0.075125099,  0.0540689394,
    0,           -0.0573390604, 0.0453568999,
    0.46466503,  -0.451128791,  0,
    0.362551553, -0.353519944,  0,
    0.532141156, -0.0527639081, -0.353519944,
    0.419069154, -0.0468321092, 0.0463774847,
    0,           -0.0468321092, 0.0532038879,
    0.311410611, -0.30717717,   0,
    0.368917364, -0.0508855714, 0.0918537748,
};
static const double prior_right[UNKNOWNS] = {1.62313448,  1.37980023, 2.13941461, 0.979356349, 1.61110131,
                                             0.732127487, 1.02012713, 1.57227341, -0.174003079};

void np_color_fit_choose_cells(np_wavelengths *out) { np_wavelengths_choose(CELL_COUNT, out); }

void np_color_fit_compute_xyz(const double x[NP_COLOR_PROBE_BAND_COUNT], double out_xyz[3]) {
  for (int c = 0; c < 3; c++) {
    out_xyz[c] = 0.0;
    for (int b = 0; b < NP_COLOR_PROBE_BAND_COUNT; b++) out_xyz[c] += x[b] * probe_xyz[b][c];
  }
}

/* Derivative of f(X / X of white) of CIE L*a*b* by X. */
static double compute_slope(double value, int component) {
  const double t = value / white[component];
  const double slope = t > 216.0 / 24389.0 ? 1.0 / (3.0 * cbrt(t * t)) : 24389.0 / (27.0 * 116.0);
  return slope / white[component];
}

static void compute_metric(const double xyz[3], double out[3][3]) {
  const double x = compute_slope(xyz[0], 0), y = compute_slope(xyz[1], 1), z = compute_slope(xyz[2], 2);
  const double jacobian[3][3] = {{0.0, 116.0 * y, 0.0}, {500.0 * x, -500.0 * y, 0.0}, {0.0, 200.0 * y, -200.0 * z}};
  for (int r = 0; r < 3; r++)
    for (int c = 0; c < 3; c++) {
      out[r][c] = 0.0;
      for (int k = 0; k < 3; k++) out[r][c] += jacobian[k][r] * jacobian[k][c];
    }
}

/* Index among unknowns; the prior orders bands from the shortest. */
static int get_place(int band, int component) { return 3 * (NP_COLOR_BAND_COUNT - 1 - band) + component; }

void np_color_fit_add(np_color_fit *fit, const double x[NP_COLOR_BAND_COUNT], const double xyz[3], double weight) {
  if (!(xyz[1] > 0.0) || !isfinite(xyz[0] + xyz[1] + xyz[2])) return;
  const double scale = probe_y / xyz[1];
  double scaled[3], metric[3][3];
  for (int c = 0; c < 3; c++) scaled[c] = scale * xyz[c];
  compute_metric(scaled, metric);
  for (int b = 0; b < NP_COLOR_BAND_COUNT; b++)
    for (int c = 0; c < 3; c++) {
      const int row = get_place(b, c);
      for (int other = 0; other < NP_COLOR_BAND_COUNT; other++)
        for (int d = 0; d < 3; d++)
          fit->gram[row][get_place(other, d)] += weight * scale * x[b] * scale * x[other] * metric[c][d];
      for (int d = 0; d < 3; d++) fit->right[row] += weight * scale * x[b] * metric[c][d] * scaled[d];
    }
  fit->weight += weight;
}

/* Gauss-Jordan elimination with partial pivoting; the system is definite. */
static void solve(double matrix[UNKNOWNS][UNKNOWNS + 1]) {
  for (int p = 0; p < UNKNOWNS; p++) {
    int best = p;
    for (int r = p + 1; r < UNKNOWNS; r++)
      if (fabs(matrix[r][p]) > fabs(matrix[best][p])) best = r;
    double row[UNKNOWNS + 1];
    memcpy(row, matrix[best], sizeof row);
    memcpy(matrix[best], matrix[p], sizeof row);
    for (int k = 0; k <= UNKNOWNS; k++) matrix[p][k] = row[k] / row[p];
    for (int r = 0; r < UNKNOWNS; r++) {
      const double factor = r == p ? 0.0 : matrix[r][p];
      for (int k = p; k <= UNKNOWNS; k++) matrix[r][k] -= factor * matrix[p][k];
    }
  }
}

void np_color_fit_solve(const np_color_fit *fit, np_color_weights *out) {
  double matrix[UNKNOWNS][UNKNOWNS + 1];
  const double own = fit->weight > 0.0 ? 1.0 / fit->weight : 0.0;
  int next = 0;
  for (int r = 0; r < UNKNOWNS; r++) {
    for (int c = r; c < UNKNOWNS; c++, next++) {
      matrix[r][c] = own * fit->gram[r][c] + prior_weight * prior_gram[next];
      matrix[c][r] = own * fit->gram[c][r] + prior_weight * prior_gram[next];
    }
    matrix[r][UNKNOWNS] = own * fit->right[r] + prior_weight * prior_right[r];
  }
  solve(matrix);
  for (int b = 0; b < NP_COLOR_BAND_COUNT; b++)
    for (int c = 0; c < 3; c++) out->at[b][c] = matrix[get_place(b, c)][UNKNOWNS];
}

/* Inverse by Cramer's rule. */
bool np_color_weights_invert(const np_color_weights *weights, const double xyz[3], double out_x[NP_COLOR_BAND_COUNT]) {
  const double *a = weights->at[0], *b = weights->at[1], *c = weights->at[2];
  const double across[3][3] = {
      {b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]},
      {c[1] * a[2] - c[2] * a[1], c[2] * a[0] - c[0] * a[2], c[0] * a[1] - c[1] * a[0]},
      {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]},
  };
  const double determinant = a[0] * across[0][0] + a[1] * across[0][1] + a[2] * across[0][2];
  if (!(fabs(determinant) > 0.0)) return false;
  for (int k = 0; k < NP_COLOR_BAND_COUNT; k++)
    out_x[k] = (across[k][0] * xyz[0] + across[k][1] * xyz[1] + across[k][2] * xyz[2]) / determinant;
  return true;
}

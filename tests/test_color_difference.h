/* SPDX-License-Identifier: Apache-2.0 */
/* ΔE*ab (CIE 1976, white D65) between colours in linear Rec.709, both scaled until the reference's luminance is 0.4. */
#ifndef TEST_COLOR_DIFFERENCE_H
#define TEST_COLOR_DIFFERENCE_H

#include <math.h>
#include <stddef.h>

typedef struct color_difference {
  double sum, max;
  size_t count;
} color_difference;

static inline void color_difference_compute_lab(const double rgb[3], double out[3]) {
  static const double xyz_from_rgb[3][3] = {
      {0.4124564, 0.3575761, 0.1804375}, {0.2126729, 0.7151522, 0.0721750}, {0.0193339, 0.1191920, 0.9503041}};
  static const double white[3] = {0.95047, 1.0, 1.08883};
  double f[3];
  for (int r = 0; r < 3; r++) {
    double t = 0.0;
    for (int c = 0; c < 3; c++) t += xyz_from_rgb[r][c] * rgb[c] / white[r];
    f[r] = t > 216.0 / 24389.0 ? cbrt(t) : (24389.0 / 27.0 * t + 16.0) / 116.0;
  }
  out[0] = 116.0 * f[1] - 16.0;
  out[1] = 500.0 * (f[0] - f[1]);
  out[2] = 200.0 * (f[1] - f[2]);
}

/* A reference without light is left out. */
static inline void color_difference_add(color_difference *d, const double rgb[3], const double reference[3]) {
  const double luminance = 0.2126729 * reference[0] + 0.7151522 * reference[1] + 0.072175 * reference[2];
  if (!(luminance > 0.0)) return;
  double own[3], exact[3], own_lab[3], exact_lab[3], square = 0.0;
  for (int c = 0; c < 3; c++) {
    own[c] = 0.4 * rgb[c] / luminance;
    exact[c] = 0.4 * reference[c] / luminance;
  }
  color_difference_compute_lab(own, own_lab);
  color_difference_compute_lab(exact, exact_lab);
  for (int c = 0; c < 3; c++) square += pow(own_lab[c] - exact_lab[c], 2.0);
  d->sum += sqrt(square);
  d->max = fmax(d->max, sqrt(square));
  d->count++;
}

#endif

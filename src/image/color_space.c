/* SPDX-License-Identifier: Apache-2.0 */
/* Matrices from primaries by SMPTE RP 177:1993; adaptation by the linear Bradford transform (Lam 1985, "Metamerism and
 * Colour Constancy"; ICC.1:2022, annex E). */
#include "image/color_space.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "image/matching.h"

/* ITU-R BT.709-6 and BT.2020-2; SMPTE ST 2065-1 with the primaries AP1 of ACES S-2014-004; primaries for which R, G and
 * B are X, Y and Z (OpenEXR's, with white at equal energy). */
static const float chromaticities[NP_COLOR_SPACE_COUNT][8] = {
    [NP_COLOR_REC709] = {0.640f, 0.330f, 0.300f, 0.600f, 0.150f, 0.060f, 0.3127f, 0.3290f},
    [NP_COLOR_ACESCG] = {0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f},
    [NP_COLOR_REC2020] = {0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.3290f},
    [NP_COLOR_XYZ] = {1.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 1.0f / 3.0f, 1.0f / 3.0f},
};

static const np_color_matrix bradford = {
    {{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}}};

/* ---- Three by three ---- */

static np_color_matrix multiply(const np_color_matrix *a, const np_color_matrix *b) {
  np_color_matrix out;
  for (int r = 0; r < 3; r++)
    for (int c = 0; c < 3; c++)
      out.at[r][c] = a->at[r][0] * b->at[0][c] + a->at[r][1] * b->at[1][c] + a->at[r][2] * b->at[2][c];
  return out;
}

static void transform(const np_color_matrix *m, const double v[3], double out[3]) {
  for (int r = 0; r < 3; r++) out[r] = m->at[r][0] * v[0] + m->at[r][1] * v[1] + m->at[r][2] * v[2];
}

/* Inverse by cofactors. False for a singular matrix. */
static bool invert(const np_color_matrix *m, np_color_matrix *out) {
  np_color_matrix cofactor;
  for (int r = 0; r < 3; r++)
    for (int c = 0; c < 3; c++) {
      const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
      cofactor.at[r][c] = m->at[r1][c1] * m->at[r2][c2] - m->at[r1][c2] * m->at[r2][c1];
    }
  double determinant = 0.0;
  for (int c = 0; c < 3; c++) determinant += m->at[0][c] * cofactor.at[0][c];
  if (!(fabs(determinant) > 1e-12)) return false;
  for (int r = 0; r < 3; r++)
    for (int c = 0; c < 3; c++) out->at[r][c] = cofactor.at[c][r] / determinant;
  return true;
}

/* ---- Spaces ---- */

static void compute_xyz(const float chromaticity[2], double out_xyz[3]) {
  const double x = (double)chromaticity[0], y = (double)chromaticity[1];
  out_xyz[0] = x / y;
  out_xyz[1] = 1.0;
  out_xyz[2] = (1.0 - x - y) / y;
}

/* Matrix from R, G, B to X, Y, Z: primaries are scaled so that their sum is the white. */
static bool compute_xyz_from_rgb(const float chromaticity[8], np_color_matrix *out) {
  np_color_matrix primaries, inverse;
  double white[3], strength[3];
  for (int i = 0; i < 4; i++)
    if (!(chromaticity[2 * i + 1] > 0.0f)) return false;
  for (int c = 0; c < 3; c++) {
    double xyz[3];
    compute_xyz(chromaticity + (ptrdiff_t)2 * c, xyz);
    for (int r = 0; r < 3; r++) primaries.at[r][c] = xyz[r];
  }
  if (!invert(&primaries, &inverse)) return false;
  compute_xyz(chromaticity + 6, white);
  transform(&inverse, white, strength);
  for (int r = 0; r < 3; r++)
    for (int c = 0; c < 3; c++) out->at[r][c] = primaries.at[r][c] * strength[c];
  return true;
}

/* Chromatic adaptation from one white to another. */
static np_color_matrix adapt(const float from_white[2], const float to_white[2]) {
  double from[3], to[3], from_cones[3], to_cones[3];
  compute_xyz(from_white, from);
  compute_xyz(to_white, to);
  transform(&bradford, from, from_cones);
  transform(&bradford, to, to_cones);
  np_color_matrix scaled = bradford, inverse;
  for (int r = 0; r < 3; r++)
    for (int c = 0; c < 3; c++) scaled.at[r][c] *= to_cones[r] / from_cones[r];
  (void)invert(&bradford, &inverse);
  return multiply(&inverse, &scaled);
}

const char *np_color_space_get_name(np_color_space space) {
  static const char *const names[NP_COLOR_SPACE_COUNT] = {[NP_COLOR_BANDS] = "nephos-bands",
                                                          [NP_COLOR_REC709] = "rec709",
                                                          [NP_COLOR_ACESCG] = "acescg",
                                                          [NP_COLOR_REC2020] = "rec2020",
                                                          [NP_COLOR_XYZ] = "xyz"};
  return names[space];
}

const float *np_color_space_get_chromaticities(np_color_space space) { return chromaticities[space]; }

static bool is_xyz(const float own[8]) { return !memcmp(own, chromaticities[NP_COLOR_XYZ], sizeof *chromaticities); }

np_color_matrix np_color_space_from_xyz(np_color_space space) {
  if (space == NP_COLOR_XYZ) return (np_color_matrix){{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
  const float *own = chromaticities[space];
  const np_color_matrix adaptation = adapt(chromaticities[NP_COLOR_REC709] + 6, own + 6);
  np_color_matrix xyz_from_rgb, rgb_from_xyz;
  (void)compute_xyz_from_rgb(own, &xyz_from_rgb);
  (void)invert(&xyz_from_rgb, &rgb_from_xyz);
  return multiply(&rgb_from_xyz, &adaptation);
}

void np_color_space_weigh(np_color_space space, const double xyz_nm[3], double out_rgb[3]) {
  const np_color_matrix rgb_from_xyz = np_color_space_from_xyz(space);
  transform(&rgb_from_xyz, xyz_nm, out_rgb);
  for (int c = 0; c < 3; c++) out_rgb[c] /= np_matching_luminous_width_nm();
}

bool np_color_space_to_rec709(const float from[8], np_color_matrix *out_rec709_from_rgb) {
  np_color_matrix xyz_from_rgb;
  if (is_xyz(from)) return *out_rec709_from_rgb = np_color_space_from_xyz(NP_COLOR_REC709), true;
  if (!compute_xyz_from_rgb(from, &xyz_from_rgb)) return false;
  const np_color_matrix adaptation = adapt(from + 6, chromaticities[NP_COLOR_REC709] + 6);
  const np_color_matrix rec709_from_xyz = np_color_space_from_xyz(NP_COLOR_REC709);
  const np_color_matrix adapted = multiply(&adaptation, &xyz_from_rgb);
  *out_rec709_from_rgb = multiply(&rec709_from_xyz, &adapted);
  return true;
}

bool np_color_space_get_luminances(const float chromaticities_of_rgb[8], double out[3]) {
  np_color_matrix xyz_from_rgb = {{{0.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 0.0}}};
  if (!is_xyz(chromaticities_of_rgb) && !compute_xyz_from_rgb(chromaticities_of_rgb, &xyz_from_rgb)) return false;
  for (int c = 0; c < 3; c++) out[c] = xyz_from_rgb.at[1][c];
  return true;
}

void np_color_space_get_chromaticity(const double rec709[3], double out_xy[2]) {
  np_color_matrix xyz_from_rgb;
  double xyz[3];
  (void)compute_xyz_from_rgb(chromaticities[NP_COLOR_REC709], &xyz_from_rgb);
  transform(&xyz_from_rgb, rec709, xyz);
  for (int i = 0; i < 2; i++) out_xy[i] = xyz[i] / (xyz[0] + xyz[1] + xyz[2]);
}

bool np_color_space_adapt_white(const double xy[2], np_color_matrix *out) {
  const float white[2] = {(float)xy[0], (float)xy[1]}, *d65 = chromaticities[NP_COLOR_REC709] + 6;
  double xyz[3], cones[3];
  compute_xyz(white, xyz);
  transform(&bradford, xyz, cones);
  for (int c = 0; c < 3; c++)
    if (!(cones[c] > 1e-3) || !(cones[c] < 1e3)) return false;
  np_color_matrix xyz_from_rgb, rgb_from_xyz;
  (void)compute_xyz_from_rgb(chromaticities[NP_COLOR_REC709], &xyz_from_rgb);
  (void)invert(&xyz_from_rgb, &rgb_from_xyz);
  const np_color_matrix adaptation = adapt(white, d65), adapted = multiply(&adaptation, &xyz_from_rgb);
  *out = multiply(&rgb_from_xyz, &adapted);
  return true;
}

double np_color_space_white_luminance(void) { return NP_LUMENS_PER_WATT * np_matching_luminous_width_nm(); }

/* SPDX-License-Identifier: Apache-2.0 */
/* Pieces are as fine as the smoothing of the traced rays: halos have edges between 18 and 50°. */
#include "optics/ice_table.h"

#include <math.h>

#include "core/math.h"
#include "core/units.h"

const np_ice_table_piece np_ice_table_pieces[NP_ICE_TABLE_PIECES] = {
    {0.0, 0.2, 0, 91}, {18.0, 0.05, 91, 641}, {50.0, 0.2, 732, 51}, {60.0, 0.5, 783, 241}};

static const double codes_per_octave = 400.0, octaves_below_one = 8.0;

uint16_t np_ice_table_encode(double value) {
  return (uint16_t)lround((log2(value) + octaves_below_one) * codes_per_octave);
}

static double get_code(const uint16_t *codes, int row, int count) {
  return (double)codes[row < 0 ? 0 : row < count ? row : count - 1];
}

/* Catmull-Rom spline through the codes of a piece. */
static double interpolate(const uint16_t *codes, int count, double place) {
  const int i = (int)np_clamp(floor(place), 0.0, count - 2.0);
  const double f = place - i, p0 = get_code(codes, i - 1, count), p1 = get_code(codes, i, count);
  const double p2 = get_code(codes, i + 1, count), p3 = get_code(codes, i + 2, count);
  return p1 + 0.5 * f * (p2 - p0 + f * (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3 + f * (3.0 * (p1 - p2) + p3 - p0)));
}

static double eval(const uint16_t *codes, double angle_deg) {
  int k = NP_ICE_TABLE_PIECES - 1;
  while (k > 0 && angle_deg < np_ice_table_pieces[k].begin_deg) k--;
  const np_ice_table_piece *piece = &np_ice_table_pieces[k];
  const double code = interpolate(codes + piece->first, piece->count, (angle_deg - piece->begin_deg) / piece->step_deg);
  return exp2(code / codes_per_octave - octaves_below_one);
}

bool np_ice_table_read(double wavelength_m, unsigned count, const double *angle_rad, double *out_values,
                       double *out_straight) {
  int band = 0;
  while (band < NP_ICE_TABLE_BANDS && fabs(np_ice_table_nm[band] - wavelength_m * 1e9) > 0.01) band++;
  if (band == NP_ICE_TABLE_BANDS) return false;
  for (unsigned i = 0; i < count; i++) out_values[i] = eval(np_ice_table_codes[band], angle_rad[i] / NP_DEGREE);
  *out_straight = np_ice_table_straight[band];
  return true;
}

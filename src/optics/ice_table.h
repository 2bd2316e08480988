/* SPDX-License-Identifier: Apache-2.0 */
/* Rays traced through the mixed habit of ice at the wavelengths of colour pictures, so that a first picture of ice need
 * not trace them. */
#ifndef NP_OPTICS_ICE_TABLE_H
#define NP_OPTICS_ICE_TABLE_H

#include <stdbool.h>
#include <stdint.h>

enum { NP_ICE_TABLE_BANDS = 6, NP_ICE_TABLE_ROWS = 1024, NP_ICE_TABLE_PIECES = 4 };

/* Rows are evenly spaced within each piece of the angles, whose ends belong to both neighbours. A code c is the value
 * 2^(c/400 − 8) per sr, to 0.1 %. */
typedef struct np_ice_table_piece {
  double begin_deg, step_deg;
  int first, count;
} np_ice_table_piece;

extern const np_ice_table_piece np_ice_table_pieces[NP_ICE_TABLE_PIECES];
extern const double np_ice_table_nm[NP_ICE_TABLE_BANDS];
extern const double np_ice_table_straight[NP_ICE_TABLE_BANDS];
extern const uint16_t np_ice_table_codes[NP_ICE_TABLE_BANDS][NP_ICE_TABLE_ROWS];

/* Code of a value. */
uint16_t np_ice_table_encode(double value);

/* Reads what np_ice_prism_trace computes for the mixed habit, to 0.2 % rms. False: not a wavelength of the table. */
bool np_ice_table_read(double wavelength_m, unsigned count, const double *angle_rad, double *out_values,
                       double *out_straight);

#endif

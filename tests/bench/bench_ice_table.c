/* SPDX-License-Identifier: Apache-2.0 */
/* Traces the mixed habit of ice at the wavelengths of colour pictures: prints src/optics/ice_table_rows.c.
 *
 * Usage: bench_ice_table
 */
#include <nephos/nephos.h>
#include <stdio.h>

#include "core/units.h"
#include "image/color_fit.h"
#include "optics/ice_prism.h"
#include "optics/ice_table.h"
#include "optics/refraction.h"

static void print_numbers(const char *declaration, const double *values, int digits) {
  printf("%s = {", declaration);
  for (int b = 0; b < NP_ICE_TABLE_BANDS; b++) printf("%s%.*f", b ? ", " : "", digits, values[b]);
  printf("};\n");
}

static void print_codes(const double *values) {
  printf("  {");
  for (int i = 0; i < NP_ICE_TABLE_ROWS; i++) printf("%s%d,", i % 18 ? " " : "\n  ", np_ice_table_encode(values[i]));
  printf("\n  },\n");
}

static void fill_angles(double *out_rad) {
  for (int k = 0; k < NP_ICE_TABLE_PIECES; k++)
    for (int i = 0; i < np_ice_table_pieces[k].count; i++)
      out_rad[np_ice_table_pieces[k].first + i] =
          (np_ice_table_pieces[k].begin_deg + i * np_ice_table_pieces[k].step_deg) * NP_DEGREE;
}

int main(void) {
  static double value[NP_ICE_TABLE_BANDS][NP_ICE_TABLE_ROWS];
  double nm[NP_ICE_TABLE_BANDS], straight[NP_ICE_TABLE_BANDS], angle[NP_ICE_TABLE_ROWS];
  np_wavelengths wavelengths;
  neph_context *context;
  if (neph_context_create(NULL, &context)) return 1;
  np_color_fit_choose_cells(&wavelengths);
  fill_angles(angle);
  for (int b = 0; b < NP_ICE_TABLE_BANDS; b++) {
    nm[b] = wavelengths.nm[np_color_fit_cells[b]];
    if (np_ice_prism_trace(context, NULL, NEPH_ICE_MIXED, np_refraction_get_ice(nm[b]), NP_ICE_TABLE_ROWS, angle,
                           value[b], &straight[b]))
      return 1;
  }
  printf("/* SPDX-License-Identifier: Apache-2.0 */\n"
         "/* Codes of the traced rays, band by band. Printed by a benchmark:\n"
         " *\n"
         " *   bench_ice_table >src/optics/ice_table_rows.c\n"
         " */\n"
         "#include \"optics/ice_table.h\"\n\n"
         "/* clang-format off */\n\n");
  print_numbers("const double np_ice_table_nm[NP_ICE_TABLE_BANDS]", nm, 4);
  print_numbers("const double np_ice_table_straight[NP_ICE_TABLE_BANDS]", straight, 6);
  printf("\nconst uint16_t np_ice_table_codes[NP_ICE_TABLE_BANDS][NP_ICE_TABLE_ROWS] = {\n");
  for (int b = 0; b < NP_ICE_TABLE_BANDS; b++) print_codes(value[b]);
  printf("};\n");
  neph_context_destroy(context);
  return 0;
}

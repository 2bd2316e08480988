/* SPDX-License-Identifier: Apache-2.0 */
/* Quantities with units as text: "20 m", "35 deg", "0.05 1/m", "10 um", and plain numbers. */
#ifndef NP_SCENE_SCENE_VALUES_H
#define NP_SCENE_SCENE_VALUES_H

#include <locale.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum np_unit {
  NP_UNIT_NONE,
  NP_UNIT_METRE,
  NP_UNIT_KILOMETRE,
  NP_UNIT_MICROMETRE,
  NP_UNIT_DEGREE,
  NP_UNIT_PER_METRE,
  NP_UNIT_PER_CUBIC_CENTIMETRE,
  NP_UNIT_IRRADIANCE,
  NP_UNIT_RADIANCE,
  NP_UNIT_STOP,
  NP_UNIT_VOXEL,
  NP_UNIT_SECOND,
  NP_UNIT_METRE_PER_SECOND,
  NP_UNIT_KELVIN,
  NP_UNIT_GIGABYTE
} np_unit;

/* "m"; "" for plain numbers. */
const char *np_unit_get_name(np_unit unit);

/* "a length", "an angle", "a number". */
const char *np_unit_get_quantity(np_unit unit);

double np_unit_to_si(np_unit unit, double value);

/* Parses a number, optionally with a unit of the same quantity as `unit` (the default), to SI. False: not a number, or
 * not finite. The decimal point is the C locale's: see np_values_enter. */
bool np_value_parse_real(const char *text, np_unit unit, double *out_value_si);

/* Parses digits without sign, point or exponent. */
bool np_value_parse_integer(const char *text, uint64_t *out_value);

/* Writes the shortest number with its unit that parses to exactly the same value. */
void np_value_format_real(double value_si, np_unit unit, char *out, size_t size);

/* Switches the calling thread to the C locale for numbers, until np_values_leave. */
locale_t np_values_enter(void);
void np_values_leave(locale_t saved);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_values.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/text.h"
#include "core/units.h"

typedef enum dimension {
  NUMBER,
  LENGTH,
  ANGLE,
  PER_LENGTH,
  PER_VOLUME,
  IRRADIANCE,
  RADIANCE,
  STOPS,
  VOXELS,
  TIME,
  SPEED,
  TEMPERATURE,
  MEMORY
} dimension;

/* One SI unit is divisor/multiplier units. Two factors make 20 um exactly the double 20e-6. */
typedef struct unit_row {
  const char *name;
  dimension dimension;
  double multiplier, divisor;
} unit_row;

static const unit_row units[] = {
    [NP_UNIT_NONE] = {"", NUMBER, 1, 1},
    [NP_UNIT_METRE] = {"m", LENGTH, 1, 1},
    [NP_UNIT_KILOMETRE] = {"km", LENGTH, 1000, 1},
    [NP_UNIT_MICROMETRE] = {"um", LENGTH, 1, 1e6},
    [NP_UNIT_DEGREE] = {"deg", ANGLE, NP_PI, 180},
    [NP_UNIT_PER_METRE] = {"1/m", PER_LENGTH, 1, 1},
    [NP_UNIT_PER_CUBIC_CENTIMETRE] = {"1/cm3", PER_VOLUME, 1e6, 1},
    [NP_UNIT_IRRADIANCE] = {"W/m2/nm", IRRADIANCE, 1, 1},
    [NP_UNIT_RADIANCE] = {"W/m2/sr/nm", RADIANCE, 1, 1},
    [NP_UNIT_STOP] = {"EV", STOPS, 1, 1},
    [NP_UNIT_VOXEL] = {"voxels", VOXELS, 1, 1},
    [NP_UNIT_SECOND] = {"s", TIME, 1, 1},
    [NP_UNIT_METRE_PER_SECOND] = {"m/s", SPEED, 1, 1},
    [NP_UNIT_KELVIN] = {"K", TEMPERATURE, 1, 1},
    [NP_UNIT_GIGABYTE] = {"GB", MEMORY, 1e9, 1},
    {"cm", LENGTH, 1, 100},
    {"mm", LENGTH, 1, 1000},
    {"nm", LENGTH, 1, 1e9},
    {"\xc2\xb5m", LENGTH, 1, 1e6}, /* micro sign */
    {"\xce\xbcm", LENGTH, 1, 1e6}, /* Greek mu */
    {"rad", ANGLE, 1, 1},
    {"\xc2\xb0", ANGLE, NP_PI, 180},
    {"1/km", PER_LENGTH, 1, 1000},
    {"1/m3", PER_VOLUME, 1, 1},
    {"voxel", VOXELS, 1, 1},
    {"min", TIME, 60, 1},
    {"h", TIME, 3600, 1},
    {"km/h", SPEED, 10, 36},
    {"MB", MEMORY, 1e6, 1},
};

const char *np_unit_get_name(np_unit unit) { return units[unit].name; }

const char *np_unit_get_quantity(np_unit unit) {
  static const char *const names[] = {
      [NUMBER] = "a number",
      [LENGTH] = "a length",
      [ANGLE] = "an angle",
      [PER_LENGTH] = "a number per length",
      [PER_VOLUME] = "a number per volume",
      [IRRADIANCE] = "an irradiance",
      [RADIANCE] = "a radiance",
      [STOPS] = "a number of stops",
      [VOXELS] = "a number of voxels",
      [TIME] = "a time",
      [SPEED] = "a speed",
      [TEMPERATURE] = "a temperature",
      [MEMORY] = "an amount of memory",
  };
  return names[units[unit].dimension];
}

static double convert_to_si(const unit_row *unit, double value) { return value * unit->multiplier / unit->divisor; }

double np_unit_to_si(np_unit unit, double value) { return convert_to_si(&units[unit], value); }

/* ---- Reading ---- */

static const char *skip_digits(const char *text) { return text + strspn(text, "0123456789"); }

static const char *skip_spaces(const char *text) { return text + strspn(text, " \t"); }

/* End of the decimal number at the start of `text`, or NULL. Other forms of strtod (hexadecimal, "inf", "nan") are not
 * accepted. */
static const char *skip_number(const char *text) {
  const char *c = text + (*text == '+' || *text == '-');
  const char *whole_end = skip_digits(c), *end = whole_end;
  size_t digit_count = (size_t)(whole_end - c);
  if (*end == '.') {
    end = skip_digits(whole_end + 1);
    digit_count += (size_t)(end - whole_end - 1);
  }
  if (!digit_count) return NULL;
  if (*end == 'e' || *end == 'E') {
    const char *exponent = end + 1 + (end[1] == '+' || end[1] == '-');
    const char *exponent_end = skip_digits(exponent);
    if (exponent_end > exponent) end = exponent_end;
  }
  return end;
}

static const unit_row *search_unit(const char *name, dimension wanted) {
  for (size_t i = 0; i < sizeof units / sizeof *units; i++)
    if (units[i].dimension == wanted && !strcmp(units[i].name, name)) return &units[i];
  return NULL;
}

bool np_value_parse_real(const char *text, np_unit unit, double *out_value_si) {
  const char *end = skip_number(text);
  if (!end) return false;
  const char *name = skip_spaces(end);
  const unit_row *given = *name ? search_unit(name, units[unit].dimension) : &units[unit];
  if (!given) return false;
  *out_value_si = convert_to_si(given, strtod(text, NULL));
  return isfinite(*out_value_si);
}

bool np_value_parse_integer(const char *text, uint64_t *out_value) {
  if (!*text || *skip_digits(text)) return false;
  uint64_t value = 0;
  for (const char *c = text; *c; c++)
    if (__builtin_mul_overflow(value, (uint64_t)10, &value) ||
        __builtin_add_overflow(value, (uint64_t)(*c - '0'), &value))
      return false;
  *out_value = value;
  return true;
}

/* ---- Writing ---- */

/* Writes the fewest digits that parse to the same value. */
static void format_shortest(double value, double value_si, const unit_row *unit, char *out, size_t size) {
  for (int digits = 6; digits <= 17; digits++) {
    np_print(out, size, "%.*g", digits, value);
    if (convert_to_si(unit, strtod(out, NULL)) == value_si) return; /* NOLINT: compares bits */
  }
}

/* Writes a value in a unit, and returns the length of its number. */
static size_t format_in_unit(double value_si, const unit_row *unit, char *out, size_t size) {
  char number[40];
  format_shortest(value_si * unit->divisor / unit->multiplier, value_si, unit, number, sizeof number);
  np_print(out, size, "%s%s%s", number, *unit->name ? " " : "", unit->name);
  return strlen(number);
}

void np_value_format_real(double value_si, np_unit unit, char *out, size_t size) {
  const size_t length = format_in_unit(value_si, &units[unit], out, size);
  if (unit != NP_UNIT_METRE || fabs(value_si) < 1000) return;
  char kilometres[48]; /* rounding may have them need all 17 digits: -8.949069999999999 km are -8949.07 m */
  if (format_in_unit(value_si, &units[NP_UNIT_KILOMETRE], kilometres, sizeof kilometres) <= length + 1)
    np_print(out, size, "%s", kilometres);
}

/* glibc has one permanent C locale: newlocale allocates nothing and cannot fail. */
locale_t np_values_enter(void) { return uselocale(newlocale(LC_ALL_MASK, "C", (locale_t)0)); }

void np_values_leave(locale_t saved) { uselocale(saved); }

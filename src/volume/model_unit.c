/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/model_unit.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/units.h"

typedef struct symbol {
  const char *name;
  np_model_unit unit;
} symbol;

/* clang-format off */
static const symbol symbols[] = {
    {"kg", {.factor = 1, .mass = 1}},          {"g", {.factor = 1e-3, .mass = 1}},
    {"mg", {.factor = 1e-6, .mass = 1}},       {"ug", {.factor = 1e-9, .mass = 1}},
    {"m", {.factor = 1, .length = 1}},         {"km", {.factor = 1e3, .length = 1}},
    {"cm", {.factor = 1e-2, .length = 1}},     {"mm", {.factor = 1e-3, .length = 1}},
    {"um", {.factor = 1e-6, .length = 1}},     {"micron", {.factor = 1e-6, .length = 1}},
    {"microns", {.factor = 1e-6, .length = 1}}, {"micrometer", {.factor = 1e-6, .length = 1}},
    {"micrometre", {.factor = 1e-6, .length = 1}}, {"\302\265m", {.factor = 1e-6, .length = 1}},
    {"\316\274m", {.factor = 1e-6, .length = 1}}, {"nm", {.factor = 1e-9, .length = 1}},
    {"meter", {.factor = 1, .length = 1}},     {"meters", {.factor = 1, .length = 1}},
    {"metre", {.factor = 1, .length = 1}},     {"metres", {.factor = 1, .length = 1}},
    {"kilometers", {.factor = 1e3, .length = 1}}, {"gpm", {.factor = 1, .length = 1}},
    {"l", {.factor = 1e-3, .length = 3}},
    {"s", {.factor = 1, .time = 1}},           {"sec", {.factor = 1, .time = 1}},
    {"K", {.factor = 1, .temperature = 1}},    {"kelvin", {.factor = 1, .temperature = 1}},
    {"degK", {.factor = 1, .temperature = 1}}, {"degC", {.factor = 1, .offset = 273.15, .temperature = 1}},
    {"Pa", {.factor = 1, .mass = 1, .length = -1, .time = -2}},
    {"hPa", {.factor = 100, .mass = 1, .length = -1, .time = -2}},
    {"kPa", {.factor = 1000, .mass = 1, .length = -1, .time = -2}},
    {"mb", {.factor = 100, .mass = 1, .length = -1, .time = -2}},
    {"mbar", {.factor = 100, .mass = 1, .length = -1, .time = -2}},
    {"millibar", {.factor = 100, .mass = 1, .length = -1, .time = -2}},
    {"millibars", {.factor = 100, .mass = 1, .length = -1, .time = -2}},
    {"pascal", {.factor = 1, .mass = 1, .length = -1, .time = -2}},
    {"rad", {.factor = 1, .angle = 1}},        {"radian", {.factor = 1, .angle = 1}},
    {"degree", {.factor = NP_DEGREE, .angle = 1}}, {"degrees", {.factor = NP_DEGREE, .angle = 1}},
    {"degrees_east", {.factor = NP_DEGREE, .angle = 1}}, {"degrees_north", {.factor = NP_DEGREE, .angle = 1}},
    {"degree_east", {.factor = NP_DEGREE, .angle = 1}}, {"degree_north", {.factor = NP_DEGREE, .angle = 1}},
    {"#", {.factor = 1}},                      {"num", {.factor = 1}},
};
/* clang-format on */

static const np_model_unit *search_symbol(const char *name, size_t length) {
  for (size_t i = 0; i < sizeof symbols / sizeof *symbols; i++)
    if (strlen(symbols[i].name) == length && !strncmp(symbols[i].name, name, length)) return &symbols[i].unit;
  return NULL;
}

/* A letter of a symbol: those of English, '_', '#', and bytes of other letters. */
static bool is_letter(char c) { return isalpha((unsigned char)c) || c == '_' || c == '#' || (unsigned char)c >= 0x80; }

/* Reads "2", "-2", "^-2" or "**-2"; 1: there is none. */
static int read_exponent(const char **at) {
  const char *text = *at;
  if (text[0] == '^')
    text++;
  else if (text[0] == '*' && text[1] == '*')
    text += 2;
  const bool is_signed = text[0] == '-' || text[0] == '+';
  if (!isdigit((unsigned char)text[is_signed])) return 1;
  const int size = text[is_signed] - '0';
  *at = text + is_signed + 1;
  return text[0] == '-' ? -size : size;
}

static void multiply(np_model_unit *product, const np_model_unit *unit, int exponent) {
  product->factor *= pow(unit->factor, exponent);
  if (exponent == 1) product->offset += unit->offset;
  product->mass += exponent * unit->mass;
  product->length += exponent * unit->length;
  product->time += exponent * unit->time;
  product->temperature += exponent * unit->temperature;
  product->angle += exponent * unit->angle;
}

/* Multiplies by a number or a symbol with its exponent; `sign` is -1 behind a slash. */
static bool read_term(const char **at, int sign, np_model_unit *product) {
  char *end;
  if (is_letter(**at)) {
    const char *begin = *at;
    while (is_letter(**at)) (*at)++;
    const np_model_unit *unit = search_symbol(begin, (size_t)(*at - begin));
    if (unit) multiply(product, unit, sign * read_exponent(at));
    return unit;
  }
  const double number = isdigit((unsigned char)**at) ? strtod(*at, &end) : 0.0;
  if (!(number > 0.0) || !isfinite(number)) return false;
  *at = end;
  product->factor *= pow(number, sign);
  return true;
}

bool np_model_unit_parse(const char *text, np_model_unit *out_unit) {
  int sign = 1;
  bool has_term = false;
  *out_unit = (np_model_unit){.factor = 1.0};
  for (const char *at = text; *at;) {
    const bool is_product = *at == ' ' || *at == '.' || (*at == '*' && at[1] != '*');
    if (is_product || *at == '/') {
      if (*at == '/') sign = -1;
      at++;
      continue;
    }
    if (!read_term(&at, sign, out_unit)) return false;
    has_term = true;
    sign = 1;
  }
  return has_term && isfinite(out_unit->factor) && out_unit->factor > 0.0;
}

bool np_model_unit_is_alike(const np_model_unit *a, const np_model_unit *b) {
  return a->mass == b->mass && a->length == b->length && a->time == b->time && a->temperature == b->temperature &&
         a->angle == b->angle;
}

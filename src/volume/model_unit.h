/* SPDX-License-Identifier: Apache-2.0 */
/* Units of variables in files of atmospheric models, in the syntax of UDUNITS: "g kg-1", "kg/m3", "m2 s-2". */
#ifndef NP_VOLUME_MODEL_UNIT_H
#define NP_VOLUME_MODEL_UNIT_H

#include <stdbool.h>

/* Exponents of the base units. */
typedef struct np_model_unit {
  double factor, offset; /* a value in SI is factor·value + offset */
  int mass, length, time, temperature, angle;
} np_model_unit;

/* False: a symbol in the text is unknown. */
bool np_model_unit_parse(const char *text, np_model_unit *out_unit);

/* Whether two units measure the same quantity. */
bool np_model_unit_is_alike(const np_model_unit *a, const np_model_unit *b);

#endif

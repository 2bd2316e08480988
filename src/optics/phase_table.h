/* SPDX-License-Identifier: Apache-2.0 */
/* Phase functions from tables: linear in the cosine between rows. */
#ifndef NP_OPTICS_PHASE_TABLE_H
#define NP_OPTICS_PHASE_TABLE_H

#include "core/context_private.h"

/* Rows by ascending versine, from 0 to 2. */
typedef struct np_phase_table {
  neph_context *context; /* borrowed */
  unsigned count;        /* ≥ 2 */
  float *versine;        /* 1 − cosθ */
  float *value;          /* 1/sr; integrates to one over the sphere */
  double *cumulative;    /* share of the light scattered within each versine; 0 to 1 */
} np_phase_table;

/* Reads comma-separated values with the columns `angle_deg` or `cosine`, from one pole to the other in either order,
 * and `value` in 1/sr. A table that integrates to one within 1 % is normalised; otherwise NEPH_ERROR_BAD_FILE, with the
 * integral in the message. */
neph_result np_phase_table_load(neph_context *context, const char *path, np_phase_table *out_table);
void np_phase_table_clear(np_phase_table *table);

/* Copies rows, which have the order of a table, and normalises them. */
neph_result np_phase_table_make(neph_context *context, unsigned count, const float *versine, const float *value,
                                np_phase_table *out_table);

/* Versine below which a share u of the light is scattered, by inversion of the cumulative distribution. */
double np_phase_table_sample(const np_phase_table *table, double u);

/* Legendre moments χ_0 … χ_{count−1}. */
void np_phase_table_get_moments(const np_phase_table *table, unsigned count, double *out_moments);

/* Place between two rows. */
typedef struct np_phase_place {
  unsigned low;
  float share; /* share of the next row */
} np_phase_place;

static inline np_phase_place np_phase_table_search(const np_phase_table *table, float versine) {
  unsigned low = 0, high = table->count - 1;
  while (high - low > 1) {
    const unsigned middle = (low + high) / 2;
    if (table->versine[middle] <= versine)
      low = middle;
    else
      high = middle;
  }
  const float t = (versine - table->versine[low]) / (table->versine[high] - table->versine[low]);
  return (np_phase_place){low, t < 1.0f ? t : 1.0f};
}

static inline float np_phase_table_get(const np_phase_table *table, np_phase_place place) {
  const float *value = table->value + place.low;
  return value[0] + place.share * (value[1] - value[0]);
}

static inline float np_phase_table_eval(const np_phase_table *table, float versine) {
  return np_phase_table_get(table, np_phase_table_search(table, versine));
}

#endif

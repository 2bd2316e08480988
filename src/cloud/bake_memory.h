/* SPDX-License-Identifier: Apache-2.0 */
/* Memory estimate of a bake. */
#ifndef NP_CLOUD_BAKE_MEMORY_H
#define NP_CLOUD_BAKE_MEMORY_H

#include "cloud/bake.h"

/* Leaves of the bake's box that may hold cloud: one byte each, z fastest. */
typedef struct np_bake_marks {
  uint8_t *is_cloudy;
  size_t cloudy_count;
  double share; /* share of the marked leaves that hold cloud, estimated from a sample */
} np_bake_marks;

/* Logs an upper bound of the memory for the bake and for the use of its grid, and fails if it is not available. */
neph_result np_bake_check_memory(const np_bake *bake, const np_bake_marks *marks);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Memory of a bake. */
#ifndef NP_CLOUD_BAKE_MEMORY_H
#define NP_CLOUD_BAKE_MEMORY_H

#include "cloud/bake.h"

/* Which leaves of the bake's box may hold cloud: a byte each, z fastest. */
typedef struct np_bake_marks {
  uint8_t *is_cloudy;
  size_t cloudy_count;
  double share; /* of the marked leaves that do hold cloud, by a sample */
} np_bake_marks;

/* Logs what the bake and what is done with its grid may need at most, and fails when that is not to be had. */
neph_result np_bake_check_memory(const np_bake *bake, const np_bake_marks *marks);

#endif

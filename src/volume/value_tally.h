/* SPDX-License-Identifier: Apache-2.0 */
/* Counts of invalid values in a grid, and of negative rounding errors, by kind and with the first voxel of each. They
 * are classified by their bits, because threads run with subnormals flushed to zero. Inside the volume module only. */
#ifndef NP_VOLUME_VALUE_TALLY_H
#define NP_VOLUME_VALUE_TALLY_H

#include "core/parallel.h"
#include "volume/sparse_grid.h"

typedef enum np_value_kind {
  NP_VALUE_NAN,
  NP_VALUE_INFINITE,
  NP_VALUE_NEGATIVE,
  NP_VALUE_ROUNDING, /* negative, and tiny relative to the largest value */
  NP_VALUE_SUBNORMAL,
  NP_VALUE_KINDS,
  NP_VALUE_GOOD
} np_value_kind;

/* The values that a grid may have. */
typedef enum np_value_rule {
  NP_VALUES_OF_CLOUD, /* finite and not negative */
  NP_VALUES_OF_VECTOR /* finite */
} np_value_rule;

/* "NaN", "infinite" … */
extern const char *const np_value_kind_names[NP_VALUE_KINDS];

/* The number of a first value is leaf · 512 + voxel, or, past all leaves, a tile. */
typedef struct np_value_tally {
  float max; /* largest finite value; at least 0 */
  uint64_t counts[NP_VALUE_KINDS], first[NP_VALUE_KINDS];
  float first_value[NP_VALUE_KINDS];
} np_value_tally;

/* Whether values are signed distances, whatever the class of the grid: they fall as far below 0 as the background is
 * above it. */
bool np_values_are_distances(float background, float value_min);

/* Counts the values of leaves and tiles that break a rule. Repair sets them to 0, or active positive infinity of a
 * cloud to the largest finite value. `monitor` may be NULL. */
neph_result np_value_tally_count(np_sparse_grid *grid, np_value_rule rule, bool is_repaired, np_monitor *monitor,
                                 np_value_tally *out_tally);

typedef struct np_value_place {
  int32_t voxel[3];
  double world_m[3]; /* in the grid's transform */
} np_value_place;

/* Position of the value with a number. */
void np_value_tally_locate(const np_sparse_grid *grid, uint64_t number, np_value_place *out_place);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Values that a cloud cannot have, and those that rounding leaves of 0: each kind counted, with its first voxel. They
 * are classified by their bits, because threads run with subnormals flushed to zero. Inside the volume module only. */
#ifndef NP_VOLUME_VALUE_TALLY_H
#define NP_VOLUME_VALUE_TALLY_H

#include "core/parallel.h"
#include "volume/sparse_grid.h"

typedef enum np_value_kind {
  NP_VALUE_NAN,
  NP_VALUE_INFINITE,
  NP_VALUE_NEGATIVE,
  NP_VALUE_ROUNDING, /* negative, and next to nothing beside the largest */
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

/* A first value's number is leaf · 512 + voxel, or, past all leaves, a tile. */
typedef struct np_value_tally {
  float max; /* of the finite values; at least 0 */
  uint64_t counts[NP_VALUE_KINDS], first[NP_VALUE_KINDS];
  float first_value[NP_VALUE_KINDS];
} np_value_tally;

/* Whether the values of a grid are those of a level set, whatever its class: as far below 0 as its background is above
 * it. */
bool np_values_are_distances(float background, float value_min);

/* Counts the values of leaves and tiles that break a rule. Where they are repaired they become 0, but a cloud's active
 * ones of positive infinity the largest finite value. `monitor` may be NULL. */
neph_result np_value_tally_count(np_sparse_grid *grid, np_value_rule rule, bool is_repaired, np_monitor *monitor,
                                 np_value_tally *out_tally);

typedef struct np_value_place {
  int32_t voxel[3];
  double world_m[3]; /* by the grid's own transform */
} np_value_place;

/* Place of a value of that number. */
void np_value_tally_locate(const np_sparse_grid *grid, uint64_t number, np_value_place *out_place);

#endif

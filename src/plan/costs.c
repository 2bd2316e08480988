/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/costs.h"

#include <assert.h>

static const struct {
  const char *name;
  np_stage_cost cost;
} rows[NP_UNIT_COUNT] = {
#define ROW(id, name, seconds, bytes) [NP_UNIT_##id] = {name, {seconds, bytes}},
    NP_COST_ROWS(ROW)
#undef ROW
};

const char *np_cost_unit_get_name(np_cost_unit unit) { return rows[unit].name; }

np_stage_cost np_costs_sum(const np_cost_counts *counts) {
  np_stage_cost sum = {.seconds = 0.0};
  for (int u = 0; u < NP_UNIT_COUNT; u++) {
    assert(counts->of[u] >= 0.0);
    sum.seconds += counts->of[u] * rows[u].cost.seconds;
    sum.bytes += counts->of[u] * rows[u].cost.bytes;
  }
  return sum;
}

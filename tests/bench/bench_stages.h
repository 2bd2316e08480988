/* SPDX-License-Identifier: Apache-2.0 */
/* Included before the sources that begin stages: Callgrind writes what it has counted, and the name of what comes. */
#ifndef NP_BENCH_STAGES_H
#define NP_BENCH_STAGES_H

#include <valgrind/callgrind.h>

#include "plan/schedule.h"
#include "plan/stage_rules.h"

static inline void bench_begin(np_schedule *schedule, np_monitor *monitor, np_stage stage, unsigned index,
                               unsigned count) {
  CALLGRIND_DUMP_STATS_AT(np_stage_get_rule(stage)->name);
  np_schedule_begin(schedule, monitor, stage, index, count);
}

#define np_schedule_begin bench_begin

#endif

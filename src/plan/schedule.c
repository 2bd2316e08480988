/* SPDX-License-Identifier: Apache-2.0 */
#include "plan/schedule.h"

#include <assert.h>

/* Share of the remaining time limit for solving multiple scattering: at most, and at least. */
static const double solving_share = 0.6, solving_share_min = 0.1;

/* Bytes of film that are saved per second on two cores, half to an .exr and half to a .png. */
static const double written_bytes_per_s = 8e7;

/* Sets the limits. The grace, the excess over the time limit that a call may take, is 10 % of it or 1 s; half of that
 * is reserved for writing files. */
static void set_limits(const np_plan *plan, np_schedule *s) {
  const double limit_s = plan->request.desc.time_limit_s, grace_s = fmax(0.1 * limit_s, 1.0);
  const double files_s = (double)plan->request.film_bytes / written_bytes_per_s;
  s->limit_s = s->first_samples_s = s->deadline_s = HUGE_VAL;
  if (!isfinite(limit_s)) return;
  s->limit_s = fmax(limit_s - fmax(files_s - 0.5 * grace_s, 0.0), 0.0);
  s->first_samples_s = s->limit_s + 0.25 * grace_s;
  s->deadline_s = s->limit_s + 0.5 * grace_s;
}

void np_schedule_make(const np_plan *plan, np_monitor_part whole, np_schedule *out) {
  const double core_s = np_plan_get_core_s(plan);
  *out = (np_schedule){.whole = whole, .indispensable_s = core_s * plan->forecast.one_sample_s};
  for (int i = 0; i < NP_STAGE_COUNT; i++) {
    out->seconds[i] = core_s * plan->forecast.stages[i].cost.seconds;
    out->all_s += out->seconds[i];
    if (i > NP_STAGE_ORDINATES && i != NP_STAGE_INTEGRATOR) out->indispensable_s += out->seconds[i];
  }
  if (np_plan_needs(plan, NP_STAGE_ORDINATES))
    out->solves_left = plan->decisions.packet_count * np_plan_count_lights(plan);
  set_limits(plan, out);
}

/* A reused stage takes no time, and its part of the progress is done. */
void np_schedule_begin(np_schedule *s, np_monitor *monitor, np_stage stage, unsigned index, unsigned count) {
  assert(index < count);
  if (index == 0) {
    s->before_s += s->stage_s;
    s->stage_s = s->seconds[stage];
  }
  const double all_s = fmax(s->all_s, 1e-9), share_s = s->stage_s / count;
  s->done_s = s->before_s + share_s * index;
  const double end = stage == NP_STAGE_INTEGRATOR ? 1.0 : fmin((s->done_s + share_s) / all_s, 1.0);
  np_monitor_set_part(monitor, s->whole, fmin(s->done_s / all_s, 1.0), end);
}

/* A machine that has taken longer than predicted, because it is slow or shared, stays as slow. */
double np_schedule_take_solve(np_schedule *s, const np_monitor *monitor) {
  if (!isfinite(s->limit_s)) return HUGE_VAL;
  const double now_s = np_monitor_get_seconds(monitor), left_s = fmax(s->limit_s - now_s, 0.0);
  const double slowness = s->done_s > 0.0 ? fmax(now_s / s->done_s, 1.0) : 1.0;
  const double spared_s = left_s - slowness * s->indispensable_s;
  const unsigned solves = s->solves_left > 1 ? s->solves_left : 1;
  s->solves_left = solves - 1;
  return fmin(fmax(spared_s, solving_share_min * left_s), solving_share * left_s) / solves;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of a plan. Each is written by one file, and read-only for all others. */
#ifndef NP_PLAN_PLAN_PARTS_H
#define NP_PLAN_PLAN_PARTS_H

#include "core/parallel.h"
#include "plan/decisions.h"
#include "plan/forecast.h"
#include "plan/inputs.h"
#include "plan/request.h"

/* Quality that a picture gives up to stay within its limit on memory; memory_estimate.c writes it. */
typedef struct np_savings {
  bool are_halves;        /* volumes in memory are halves, whatever their clouds' precision */
  bool are_coarse;        /* voxels of files are twice as long */
  double light_bytes_max; /* memory for multiple scattering; without a limit the request's */
  char text[320];         /* the savings in words; empty: none */
} np_savings;

typedef struct np_plan {
  np_request request;
  np_inputs inputs;
  np_savings savings;
  np_decisions decisions;
  np_forecast forecast;
  char hash[33]; /* name of the picture, once np_plan_compute_hash has read its files; empty: none */
} np_plan;

static inline bool np_plan_needs(const np_plan *plan, np_stage stage) {
  return plan->decisions.stages[stage].is_needed;
}

/* Voxels that hold cloud, and the share of clouds with detail finer than voxels. */
static inline double np_plan_get_cloud_voxels(const np_plan *plan) {
  return plan->inputs.voxels.cloud[plan->savings.are_coarse ? 1 : 0];
}

static inline double np_plan_get_detailed_voxels(const np_plan *plan) {
  return plan->inputs.voxels.detailed[plan->savings.are_coarse ? 1 : 0];
}

/* Voxels that are split into droplets and crystals, and voxels in bricks that this adds. */
static inline double np_plan_get_split_voxels(const np_plan *plan) {
  return plan->inputs.voxels.split[plan->savings.are_coarse ? 1 : 0];
}

static inline double np_plan_get_part_voxels(const np_plan *plan) {
  return plan->inputs.voxels.parts[plan->savings.are_coarse ? 1 : 0];
}

/* Wall-clock seconds on all threads for one core-second of work. */
static inline double np_plan_get_core_s(const np_plan *plan) {
  return 1.0 / neph_context_get_thread_count(plan->request.context);
}

/* Whether light that air scatters is looked up in tables: for all but paths that trace it, and for the solution that
 * guides such paths. */
static inline bool np_plan_has_air_light(const np_plan *plan) {
  return !np_request_traces_air(&plan->request) || np_plan_needs(plan, NP_STAGE_CLOUD_SKY) ||
         np_plan_needs(plan, NP_STAGE_ORDINATES);
}

/* Precision of a cloud's values in memory. */
static inline neph_precision np_plan_get_precision(const np_plan *plan, const np_scene_cloud *cloud) {
  return plan->savings.are_halves ? NEPH_PRECISION_HALF : cloud->precision;
}

/* Number of lights: sun, moon or both; one, without irradiance, if neither shines. */
static inline bool np_plan_has_sun_world(const np_plan *plan) {
  return plan->decisions.has_sun || !np_plan_needs(plan, NP_STAGE_MOON);
}

static inline unsigned np_plan_count_lights(const np_plan *plan) {
  const unsigned moons = np_plan_needs(plan, NP_STAGE_MOON) ? 1 : 0;
  if (plan->request.has_light_groups)
    return (plan->decisions.has_sun ? 2u : 1u) + moons + plan->decisions.emission_count;
  return (np_plan_has_sun_world(plan) ? 1u : 0u) + moons;
}

#endif

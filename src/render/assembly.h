/* SPDX-License-Identifier: Apache-2.0 */
/* Everything a picture is rendered from, built as the plan says: volumes, terrain, atmosphere, skies, camera. */
#ifndef NP_RENDER_ASSEMBLY_H
#define NP_RENDER_ASSEMBLY_H

#include "render/packet.h"
#include "render/plan.h"
#include "render/stage_times.h"
#include "render/stores.h"

/* Surroundings of a build. */
typedef struct np_build_job {
  np_stores *stores;        /* borrowed: results of earlier pictures, and this picture's for later ones */
  np_stage_times *times;    /* borrowed: filled while the stages are built; NULL: not measured */
  np_monitor_part progress; /* part of the call's progress that the picture is; run-up frames are the rest */
} np_build_job;

/* The whole of a call that measures no times. */
static inline np_build_job np_build_job_make(np_stores *stores) {
  return (np_build_job){.stores = stores, .progress = np_monitor_whole};
}

/* Builds what `plan` needs for its frame; on failure nothing is left. Where no cloud turns out to hold anything, the
 * plan is made without them. */
neph_result np_assembly_build(const neph_scene *scene, np_plan *plan, const np_build_job *job, np_monitor *monitor,
                              np_assembly *out_assembly);

/* The same with those stages alone whose bits are set: to look at some of them. */
neph_result np_assembly_build_some(const neph_scene *scene, np_plan *plan, uint32_t stages, const np_build_job *job,
                                   np_monitor *monitor, np_assembly *out_assembly);
void np_assembly_clear(np_assembly *assembly);

#endif

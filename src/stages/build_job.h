/* SPDX-License-Identifier: Apache-2.0 */
/* Surroundings of a build: its stores, its measured times, and the light that other frames or processes have left. */
#ifndef NP_STAGES_BUILD_JOB_H
#define NP_STAGES_BUILD_JOB_H

#include "plan/light_span.h"
#include "stages/stage_times.h"
#include "stages/stores.h"

/* Unfinished solutions of light, kept beside the picture's checkpoint. */
typedef struct np_light_checkpoints {
  const char *path; /* the path of the picture's checkpoint; NULL: none are kept */
  double interval_s;
  bool is_resumed;
  unsigned block_end; /* 0: light of the frame itself; 1, 2: light of the first and of the last frame of its block */
} np_light_checkpoints;

typedef struct np_build_job {
  np_stores *stores;        /* borrowed: results of earlier pictures, and this picture's for later ones */
  np_stage_times *times;    /* borrowed: filled while the stages are built; NULL: not measured */
  np_monitor_part progress; /* part of the call's progress that the picture is; run-up frames are the rest */
  np_light_span light_span; /* frames between which the light is interpolated */
  np_light_checkpoints light_checkpoints;
} np_build_job;

/* Describes a build that reports the call's whole progress, measures no times, and does not interpolate light. */
static inline np_build_job np_build_job_make(np_stores *stores) {
  return (np_build_job){.stores = stores, .progress = np_monitor_whole};
}

/* The checkpoints that a description names. */
static inline np_light_checkpoints np_light_checkpoints_make(const neph_render_desc *desc, unsigned block_end) {
  return (np_light_checkpoints){.path = desc->checkpoint_path,
                                .interval_s = desc->checkpoint_interval_s,
                                .is_resumed = desc->is_resumed,
                                .block_end = block_end};
}

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Rules for parts and checkpoints that can be kept. */
#ifndef NP_PLAN_PART_CHECK_H
#define NP_PLAN_PART_CHECK_H

#include "plan/plan_parts.h"

/* Whether not all samples of the picture are taken. */
static inline bool np_part_is_range(const neph_render_desc *d) {
  return d->sample_begin > 0 || d->sample_end < d->sample_count;
}

/* NEPH_ERROR_INVALID_ARGUMENT, with a message, where the request has a part or a checkpoint that cannot be kept: with
 * deep pixels or a time limit, and of sample ranges with a target error. */
neph_result np_part_check(const neph_scene *scene, const np_request *request);

/* Fails too where the scene has no hash, once that is known. */
neph_result np_part_check_hash(const np_plan *plan);

#endif

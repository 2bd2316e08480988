/* SPDX-License-Identifier: Apache-2.0 */
#include "volume/volume_file.h"

enum { LEAVES_PER_PIECE = 64 };

typedef struct ramp_job {
  np_sparse_grid *grid;
  const neph_volume_ramp *ramp;
} ramp_job;

static float apply(const neph_volume_ramp *r, float value) {
  if (!((double)value > r->low_cut)) return 0.0f;
  return (float)(r->gain * pow(fmax((double)value + r->offset, 0.0), r->gamma));
}

static neph_result apply_to_leaves(void *user, size_t begin, size_t end, unsigned thread) {
  const ramp_job *job = user;
  (void)thread;
  for (size_t i = begin; i < end; i++)
    for (int n = 0; n < NP_LEAF_SIZE; n++)
      job->grid->leaves[i].values[n] = apply(job->ramp, job->grid->leaves[i].values[n]);
  return NEPH_OK;
}

neph_result np_volume_apply_ramp(neph_context *context, np_sparse_grid *grid, const neph_volume_ramp *ramp,
                                 np_monitor *monitor) {
  const neph_volume_ramp r = *ramp;
  ramp_job job = {grid, ramp};
  if (r.low_cut == 0.0 && r.offset == 0.0 && r.gain == 1.0 && r.gamma == 1.0) return NEPH_OK;
  for (size_t i = 0; i < grid->tile_count; i++) grid->tiles[i].value = apply(ramp, grid->tiles[i].value);
  return np_parallel_for(context, monitor, grid->leaf_count, LEAVES_PER_PIECE, apply_to_leaves, &job);
}

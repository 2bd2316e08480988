/* SPDX-License-Identifier: Apache-2.0 */
/* Results of stages on disk. An entry's key consists of all that its bits depend on: a picture has the same bits with
 * the cache and without. */
#include "stages/stage_part.h"

/* A result that takes longer is abandoned, or its machine is far slower. */
static const double waiting_max_s = 3600.0;

/* Computes the key of a part's result; false: the cache is off, or the result is not cached. */
static bool compute_key(const np_stage_reuse *reuse, const np_stage_task *task, char out_key[33]) {
  neph_context *context = task->in.part.context;
  const np_stage_disk *disk = reuse->disk;
  if (!disk || !np_disk_cache_is_wanted(context)) return false;
  np_hash *key = np_hash_create(context);
  if (key) np_cache_key_begin(context, disk->kind, disk->has_isa, key);
  const bool is_kept = disk->add_key(task, key);
  return !np_hash_finish(key, out_key) && is_kept;
}

bool np_stage_disk_load(const np_stage_reuse *reuse, const np_stage_task *task) {
  char key[33];
  np_cache_entry entry;
  neph_context *context = task->in.part.context;
  if (!compute_key(reuse, task, key) || !np_cache_read_begin(context, reuse->disk->kind, key, &entry)) return false;
  const bool is_loaded = !reuse->disk->load(task, &entry);
  if (np_cache_read_end(&entry) && is_loaded) return true;
  void *result = reuse->exchange(task, NULL);
  if (result) reuse->destroy(result);
  return false;
}

/* A picture with a time limit does not wait. */
neph_result np_stage_disk_lock(const np_stage_reuse *reuse, const np_stage_task *task, np_cache_lock *out_lock) {
  char key[33];
  out_lock->file = -1;
  if (!task->in.part.key || isfinite(task->in.part.plan->request.desc.time_limit_s) || !compute_key(reuse, task, key))
    return NEPH_OK;
  return np_cache_lock_take(task->in.part.context, task->in.part.monitor, reuse->disk->kind, key, waiting_max_s,
                            out_lock);
}

void np_stage_disk_save(const np_stage_reuse *reuse, const np_stage_task *task) {
  char key[33];
  np_cache_entry entry;
  if (!compute_key(reuse, task, key)) return;
  np_cache_write_begin(task->in.part.context, reuse->disk->kind, key, &entry);
  reuse->disk->save(task, &entry);
  np_cache_write_commit(&entry);
  if (reuse->disk->state_kind) np_cache_remove(task->in.part.context, reuse->disk->state_kind, key);
}

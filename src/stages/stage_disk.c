/* SPDX-License-Identifier: Apache-2.0 */
/* Results of stages on disk. An entry's key consists of all that its bits depend on: a picture has the same bits with
 * the cache and without. */
#include "stages/stage_part.h"

/* A result that takes longer is abandoned, or its machine is far slower. */
static const double waiting_max_s = 3600.0;

bool np_stage_disk_compute_key(const np_stage_disk *disk, const np_stage_part *part, char out_key[33]) {
  neph_context *context = part->made->context;
  np_hash *key = np_hash_create(context);
  if (key) np_cache_key_begin(context, disk->kind, disk->has_isa, key);
  const bool is_kept = disk->add_key(part, key);
  return !np_hash_finish(key, out_key) && is_kept;
}

/* False: no cache is wanted, or the result is not to be kept. */
static bool compute_key(const np_stage_reuse *reuse, const np_stage_part *part, char out_key[33]) {
  return reuse->disk && np_disk_cache_is_wanted(part->made->context) &&
         np_stage_disk_compute_key(reuse->disk, part, out_key);
}

bool np_stage_disk_load(const np_stage_reuse *reuse, const np_stage_part *part) {
  char key[33];
  np_cache_entry entry;
  neph_context *context = part->made->context;
  if (!compute_key(reuse, part, key) || !np_cache_read_begin(context, reuse->disk->kind, key, &entry)) return false;
  const bool is_loaded = !reuse->disk->load(part, &entry);
  if (np_cache_read_end(&entry) && is_loaded) return true;
  void *result = reuse->exchange(part, NULL);
  if (result) reuse->destroy(result);
  return false;
}

/* A picture with a time limit does not wait. */
neph_result np_stage_disk_lock(const np_stage_reuse *reuse, const np_stage_part *part, np_cache_lock *out_lock) {
  char key[33];
  out_lock->file = -1;
  if (!part->key || isfinite(part->plan->request.desc.time_limit_s) || !compute_key(reuse, part, key)) return NEPH_OK;
  return np_cache_lock_take(part->made->context, part->monitor, reuse->disk->kind, key, waiting_max_s, out_lock);
}

void np_stage_disk_save(const np_stage_reuse *reuse, const np_stage_part *part) {
  char key[33];
  np_cache_entry entry;
  if (!compute_key(reuse, part, key)) return;
  np_cache_write_begin(part->made->context, reuse->disk->kind, key, &entry);
  reuse->disk->save(part, &entry);
  np_cache_write_commit(&entry);
  if (reuse->disk->state_kind) np_cache_remove(part->made->context, reuse->disk->state_kind, key);
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Locks on entries of the cache that are being computed: other processes wait for the lock and then read the entry. A
 * lock is a byte of one file of the cache's folder, locked for an open file (fcntl, F_OFD_SETLK), so that it ends with
 * its process in any case. In a folder without locks no process waits. */
#ifndef NP_CORE_CACHE_LOCK_H
#define NP_CORE_CACHE_LOCK_H

#include "core/parallel.h"

typedef struct np_cache_lock {
  int file; /* −1: no lock */
} np_cache_lock;

/* Takes the lock on an entry of the cache, or waits for it, `wait_max_s` at most; the caller continues without a lock
 * after that. Returns NEPH_ERROR_CANCELLED where the monitor stops the call. */
neph_result np_cache_lock_take(neph_context *context, np_monitor *monitor, const char *kind, const char *key,
                               double wait_max_s, np_cache_lock *out_lock);

void np_cache_lock_release(np_cache_lock *lock);

#endif

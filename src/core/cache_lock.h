/* SPDX-License-Identifier: Apache-2.0 */
/* Locks on results of the cache that are being made: who else wants one waits for it instead of making it as well.
 *
 * A lock is a byte of one file of the cache's folder, locked for an open file (fcntl, F_OFD_SETLK), so that it ends
 * with its process, however that ends. On a folder without locks nobody waits. */
#ifndef NP_CORE_CACHE_LOCK_H
#define NP_CORE_CACHE_LOCK_H

#include "core/parallel.h"

typedef struct np_cache_lock {
  int file; /* −1: there is none */
} np_cache_lock;

/* Takes the lock on an entry of the cache, or waits for it, `wait_max_s` at most; without it the caller goes on all the
 * same. NEPH_ERROR_CANCELLED where the monitor ends it. */
neph_result np_cache_lock_take(neph_context *context, np_monitor *monitor, const char *kind, const char *key,
                               double wait_max_s, np_cache_lock *out_lock);

void np_cache_lock_release(np_cache_lock *lock);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "core/alloc.h"
#include "core/context_private.h"
#include "core/disk_cache.h"
#include "core/file.h"
#include "core/given.h"
#include "core/isa.h"
#include "core/loop_log.h"
#include "core/parallel.h"
#include "core/path_map.h"

enum { THREADS_MAX = 1024 };

static neph_result check_desc(neph_context *context, const neph_context_desc *desc) {
  if (desc->thread_count != NEPH_THREADS_ALL && (desc->thread_count < 1 || desc->thread_count > THREADS_MAX))
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "neph_context_desc.thread_count is %u, must be in [1, %d] or NEPH_THREADS_ALL", desc->thread_count,
                   THREADS_MAX);
  if ((unsigned)desc->isa_max > NEPH_ISA_X86_64_V4)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT, "neph_context_desc.isa_max is %d, must be a neph_isa",
                   (int)desc->isa_max);
  if ((unsigned)desc->log_level_max > NEPH_LOG_DEBUG)
    return np_fail(context, NEPH_ERROR_INVALID_ARGUMENT,
                   "neph_context_desc.log_level_max is %d, must be a neph_log_level", (int)desc->log_level_max);
  return NEPH_OK;
}

/* Fills the members that depend on the description alone, enough for logging and allocation. */
static void fill_from_desc(neph_context *context, const neph_context_desc *desc) {
  atomic_init(&context->references, 1);
  atomic_init(&context->allocated_bytes, 0);
  atomic_init(&context->allocated_bytes_peak, 0);
  const bool is_printed = !desc->log && desc->log_level_max > NEPH_LOG_WARNING;
  context->log = desc->log ? desc->log : np_log_print;
  context->log_user = desc->log_user;
  context->log_level_max = is_printed ? NEPH_LOG_WARNING : desc->log_level_max;
  context->reallocate = desc->reallocate;
  context->reallocate_user = desc->reallocate_user;
  context->is_interrupted = desc->is_interrupted;
  context->interrupt_user = desc->interrupt_user;
}

static unsigned choose_thread_count(unsigned wanted) {
  if (wanted != NEPH_THREADS_ALL) return wanted;
  unsigned cpus = np_cpu_count();
  return cpus < THREADS_MAX ? cpus : THREADS_MAX;
}

static neph_result fill_owned(neph_context *context, const neph_context_desc *desc) {
  const neph_isa isa = np_isa_detect();
  context->isa = isa < desc->isa_max ? isa : desc->isa_max;
  context->thread_count = choose_thread_count(desc->thread_count);
  if (desc->module_dir) {
    context->module_dir = np_alloc_text(context, desc->module_dir);
    if (!context->module_dir) return NEPH_ERROR_OUT_OF_MEMORY;
  }
  context->disk_cache = np_alloc(context, 1, sizeof *context->disk_cache);
  if (!context->disk_cache) return NEPH_ERROR_OUT_OF_MEMORY;
  neph_result result = np_disk_cache_open(context, desc->cache_dir, desc->cache_size_max_bytes, context->disk_cache);
  if (!result && desc->path_mapping) result = np_path_map_load(context, desc->path_mapping, &context->path_map);
  if (!result && desc->loop_log) result = np_loop_log_open(context, desc->loop_log, &context->loop_log);
  return result ? result : np_pool_create(context, context->thread_count, &context->pool);
}

neph_result neph_context_create(const neph_context_desc *desc, neph_context **out_context) {
  if (!out_context) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_context = NULL;
  const neph_context_desc defaults = NEPH_CONTEXT_DESC_DEFAULT;
  neph_context_desc wanted;

  /* Context with the allocator and the log of the description, until the real one exists. */
  neph_context seed = {0};
  fill_from_desc(&seed, &defaults);
  neph_result result = np_desc_read(&seed, "neph_context_desc", &defaults, sizeof defaults, desc, &wanted);
  if (result) return result;
  fill_from_desc(&seed, &wanted);
  result = check_desc(&seed, &wanted);
  if (result) return result;
  neph_context *context = np_alloc(&seed, 1, sizeof *context);
  if (!context) return NEPH_ERROR_OUT_OF_MEMORY;
  fill_from_desc(context, &wanted);
  atomic_store(&context->allocated_bytes, atomic_load(&seed.allocated_bytes));

  result = fill_owned(context, &wanted);
  if (result)
    np_context_release(context);
  else
    *out_context = context;
  return result;
}

void np_context_retain(neph_context *context) { atomic_fetch_add(&context->references, 1); }

void np_context_release(neph_context *context) {
  if (atomic_fetch_sub(&context->references, 1) != 1) return;
  np_pool_destroy(context, context->pool);
  np_loop_log_close(context, context->loop_log);
  if (context->disk_cache) np_disk_cache_close(context, context->disk_cache);
  np_alloc_free(context, context->disk_cache);
  np_alloc_free(context, context->module_dir);
  np_path_map_destroy(context, context->path_map);
  np_alloc_free(context, context);
}

void neph_context_destroy(neph_context *context) {
  if (context) np_context_release(context);
}

unsigned neph_context_get_thread_count(const neph_context *context) { return context ? context->thread_count : 0; }

neph_isa neph_context_get_isa(const neph_context *context) { return context ? context->isa : NEPH_ISA_X86_64; }

neph_result neph_target_check(neph_context *context, const char *path) {
  if (NP_LACKS(context, path)) return NEPH_ERROR_INVALID_ARGUMENT;
  return np_file_check_target(context, path);
}

neph_result neph_text_save(neph_context *context, const char *text, const char *path) {
  if (NP_LACKS(context, text, path)) return NEPH_ERROR_INVALID_ARGUMENT;
  return np_file_write_all(context, path, text, strlen(text));
}

void neph_text_destroy(neph_context *context, char *text) {
  if (context) np_alloc_free(context, text);
}

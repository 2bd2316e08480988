/* SPDX-License-Identifier: Apache-2.0 */
/* The members of a context, and the functions with which all other files log and fail. */
#ifndef NP_CORE_CONTEXT_PRIVATE_H
#define NP_CORE_CONTEXT_PRIVATE_H

#include <stdarg.h>
#include <stdatomic.h>

#include <nephos/context.h>

typedef struct np_pool np_pool;
typedef struct np_loop_log np_loop_log;

struct neph_context {
  atomic_size_t references; /* the owner's reference, and one for each object */
  unsigned thread_count;
  neph_isa isa;
  neph_log_fn log;
  void *log_user;
  neph_log_level log_level_max;
  neph_reallocate_fn reallocate;
  void *reallocate_user;
  neph_interrupt_fn is_interrupted; /* may be NULL */
  void *interrupt_user;
  char *module_dir;                 /* NULL: none is given */
  struct np_path_map *path_map;     /* NULL: names are not mapped */
  struct np_disk_cache *disk_cache; /* its folder is NULL: no cache */
  np_pool *pool;
  np_loop_log *loop_log; /* NULL: loops are not logged */
  atomic_size_t allocated_bytes, allocated_bytes_peak;
};

void np_context_retain(neph_context *context);
void np_context_release(neph_context *context);

/* Default log: errors and warnings as lines on stderr. */
void np_log_print(void *user, neph_log_level level, const char *message);

static inline bool np_log_is_wanted(const neph_context *context, neph_log_level level) {
  return level <= context->log_level_max;
}

/* Logs a message if its level is enabled. */
void np_log(neph_context *context, neph_log_level level, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* Logs an error and returns `result`: `return np_fail(context, NEPH_ERROR_IO, "%s: …", path);`. It is called once,
 * where the failure is detected. */
neph_result np_fail(neph_context *context, neph_result result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Copies a caller's description over the defaults, as much of it as the caller's struct has; NULL keeps the defaults.
 * Fails when struct_size is smaller than its own member or larger than this version's struct. */
neph_result np_desc_read(neph_context *context, const char *type_name, const void *defaults, size_t size,
                         const void *desc, void *out);

/* Checks beforehand that np_desc_write will accept a caller's struct, for structs that are filled much later. */
neph_result np_desc_check_size(neph_context *context, const char *type_name, const void *desc, size_t size);

/* Copies `from`, a struct of this version, to a caller's, as much of it as the caller's struct has; its struct_size
 * stays. Fails, with nothing written, where np_desc_read would. */
neph_result np_desc_write(neph_context *context, const char *type_name, const void *from, size_t size, void *out);

#endif

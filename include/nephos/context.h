/* SPDX-License-Identifier: Apache-2.0 */
/* The context: threads, memory, log and instruction set. Every object belongs to one and keeps it alive. */
#ifndef NEPHOS_CONTEXT_H
#define NEPHOS_CONTEXT_H

#include <stdint.h>

#include <nephos/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/** One pool of threads, one allocator, one log. Several may live in one process; none shares anything with another. */
typedef struct neph_context neph_context;

typedef enum neph_log_level { NEPH_LOG_ERROR, NEPH_LOG_WARNING, NEPH_LOG_INFO, NEPH_LOG_DEBUG } neph_log_level;

/** Receives one message, without a line end, on the thread where it arose; several threads may call it at once. */
typedef void (*neph_log_fn)(void *user, neph_log_level level, const char *message);

/** The memory of the library's own C code; OpenVDB and Embree keep theirs.
 *
 * @param block      NULL to allocate, else a block this function returned.
 * @param old_bytes  the size with which `block` was allocated; 0 when NULL.
 * @param new_bytes  0 to free; then the result is ignored.
 * @return a block aligned to 16 bytes, or NULL when there is no memory (`block` then stays valid).
 */
typedef void *(*neph_reallocate_fn)(void *user, void *block, size_t old_bytes, size_t new_bytes);

/** Ends the current call, with NEPH_ERROR_CANCELLED, by returning true. Runs at least every 0.1 s while a call waits
 * for another process (a reader of files, an entry of the cache), in any thread, so also within calls that have no
 * neph_progress_fn. */
typedef bool (*neph_interrupt_fn)(void *user);

/** Instruction-set levels of the x86-64 psABI; kernels exist once for each. */
typedef enum neph_isa { NEPH_ISA_X86_64, NEPH_ISA_X86_64_V3, NEPH_ISA_X86_64_V4 } neph_isa;

/** One thread for each CPU that the process may use. */
#define NEPH_THREADS_ALL 0xffffffffu

typedef struct neph_context_desc {
  size_t struct_size;
  unsigned thread_count;         /**< 1 to 1024, or NEPH_THREADS_ALL (default) */
  neph_isa isa_max;              /**< highest level to use, if the machine has it (default: v4) */
  neph_log_fn log;               /**< NULL (default): errors and warnings go to stderr, each a line that begins with
                                      "nephos: error: " or "nephos: warning: " */
  void *log_user;                /**< passed to `log` (default NULL) */
  neph_log_level log_level_max;  /**< least urgent level delivered (default NEPH_LOG_INFO) */
  neph_reallocate_fn reallocate; /**< NULL (default): the C library's allocator */
  void *reallocate_user;         /**< passed to `reallocate` (default NULL) */
  const char *module_dir;        /**< folder of nephos_vdb.so, nephos_gdal.so and nephos_assimp, searched last
                                      (default NULL) */
  const char *cache_dir; /**< folder whose "nephos-cache" keeps light in clouds, bakes, mountains and tables of air from
                              process to process; created, with its parents, where it is missing (default NULL: none) */
  uint64_t cache_size_max_bytes;    /**< size limit of the cache's files; the least recently used are removed first
                                         (default 4 GB) */
  const char *path_mapping;         /**< rules for names of files in scenes: a JSON file of Open Job Description,
                                         "pathmapping-1.0" (default NULL: none) */
  neph_interrupt_fn is_interrupted; /**< default NULL: waits for other processes end by a progress callback alone */
  void *interrupt_user;             /**< passed to `is_interrupted` (default NULL) */
  const char *loop_log; /**< file for the CPU time of each piece of each parallel loop that the calling thread of
                             neph_context_create starts, for benchmarks of scaling (default NULL: none) */
} neph_context_desc;

#define NEPH_CONTEXT_DESC_DEFAULT                                                                                      \
  {                                                                                                                    \
    .struct_size = sizeof(neph_context_desc), .thread_count = NEPH_THREADS_ALL, .isa_max = NEPH_ISA_X86_64_V4,         \
    .log = NULL, .log_user = NULL, .log_level_max = NEPH_LOG_INFO, .reallocate = NULL, .reallocate_user = NULL,        \
    .module_dir = NULL, .cache_dir = NULL, .cache_size_max_bytes = UINT64_C(4000000000), .path_mapping = NULL,         \
    .is_interrupted = NULL, .interrupt_user = NULL, .loop_log = NULL                                                   \
  }

/** Creates a context and starts its threads.
 *
 * @param desc         NULL for the defaults.
 * @param out_context  set to NULL on failure; owned by the caller otherwise.
 */
NEPH_API neph_result neph_context_create(const neph_context_desc *desc, neph_context **out_context) NEPH_NODISCARD;

/** Drops the caller's hold on a context, which ends with the last object created from it. NULL is allowed. */
NEPH_API void neph_context_destroy(neph_context *context);

/** Number of threads that work for this context. */
NEPH_API unsigned neph_context_get_thread_count(const neph_context *context);

/** Instruction-set level in use: the lower of what was allowed and what the machine has. */
NEPH_API neph_isa neph_context_get_isa(const neph_context *context);

/** Name of a level as `--isa` takes it: "x86-64", "x86-64-v3", "x86-64-v4"; "unknown" otherwise. */
NEPH_API const char *neph_isa_get_name(neph_isa isa);

/** Parts of the library that a machine or an installation may lack. */
typedef enum neph_feature {
  NEPH_FEATURE_VDB,    /**< .vdb files are read and written: nephos_vdb.so is found and can be loaded */
  NEPH_FEATURE_GDAL,   /**< GeoTIFF and other georeferenced height fields are read: nephos_gdal.so is found and can be
                            loaded */
  NEPH_FEATURE_ASSIMP, /**< meshes are read: the program nephos_assimp is found */
  NEPH_FEATURE_NETCDF, /**< fields of atmospheric models are read: nephos_netcdf.so is found and can be loaded */
  NEPH_FEATURE_OCIO    /**< previews are shown by views of OpenColorIO: nephos_ocio.so is found and can be loaded */
} neph_feature;

/** Whether a feature can be used; false for values outside the enumeration. Loads the feature's module on first use,
 * and logs nothing. */
NEPH_API bool neph_feature_is_present(neph_context *context, neph_feature feature);

/** Whether a file can be written at `path`: fails as saving one there does, with the same message, and creates no
 * file. */
NEPH_API neph_result neph_target_check(neph_context *context, const char *path) NEPH_NODISCARD;

/** Writes a text of the library to a file, which appears complete or not at all. */
NEPH_API neph_result neph_text_save(neph_context *context, const char *text, const char *path) NEPH_NODISCARD;

/** Frees a text that the library returned through a `char **`. NULL is allowed. */
NEPH_API void neph_text_destroy(neph_context *context, char *text);

#ifdef __cplusplus
}
#endif

#endif

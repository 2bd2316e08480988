/* SPDX-License-Identifier: Apache-2.0 */
/* Version, results, progress and text: the base of every other nephos header. */
#ifndef NEPHOS_BASE_H
#define NEPHOS_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define NEPHOS_VERSION_MAJOR 0
#define NEPHOS_VERSION_MINOR 1
#define NEPHOS_VERSION_PATCH 0

/** Version of the headers, to compare with neph_version_get_number: 1000000·major + 1000·minor + patch. */
#define NEPHOS_VERSION_NUMBER (NEPHOS_VERSION_MAJOR * 1000000 + NEPHOS_VERSION_MINOR * 1000 + NEPHOS_VERSION_PATCH)

#if defined(NEPHOS_BUILDING)
#define NEPH_API __attribute__((visibility("default")))
#else
#define NEPH_API
#endif

#if defined(__GNUC__)
#define NEPH_NODISCARD __attribute__((warn_unused_result))
#else
#define NEPH_NODISCARD
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Every result: constant, value, and the sentence that explains it. Zero is success. */
#define NEPH_RESULTS(X)                                                                                                \
  X(NEPH_OK, 0, "done")                                                                                                \
  X(NEPH_ERROR_INTERNAL, 1, "internal error")                                                                          \
  X(NEPH_ERROR_OUT_OF_MEMORY, 2, "out of memory")                                                                      \
  X(NEPH_ERROR_INVALID_ARGUMENT, 3, "invalid argument")                                                                \
  X(NEPH_ERROR_BAD_SCENE, 4, "bad scene")                                                                              \
  X(NEPH_ERROR_NOT_FOUND, 5, "file not found")                                                                         \
  X(NEPH_ERROR_IO, 6, "input or output failed")                                                                        \
  X(NEPH_ERROR_BAD_FILE, 7, "file is damaged or of another kind")                                                      \
  X(NEPH_ERROR_LIMIT, 8, "a limit was reached")                                                                        \
  X(NEPH_ERROR_CANCELLED, 9, "cancelled")                                                                              \
  X(NEPH_ERROR_UNSUPPORTED, 10, "not supported by this build or machine")

typedef enum neph_result {
#define NEPH_RESULT_CONSTANT(name, value, text) name = value,
  NEPH_RESULTS(NEPH_RESULT_CONSTANT)
#undef NEPH_RESULT_CONSTANT
} neph_result;

/** Name of a result, such as "NEPH_ERROR_IO"; "unknown" for a value outside the enumeration. Never NULL. */
NEPH_API const char *neph_result_get_name(neph_result result);

/** One sentence about a result; the cause of a failure in a given call goes to the context's log. Never NULL. */
NEPH_API const char *neph_result_get_text(neph_result result);

/** Version of the library in use, "MAJOR.MINOR.PATCH". Never NULL. */
NEPH_API const char *neph_version_get_text(void);

/** Version of the library in use as a number that grows with it; NEPHOS_VERSION_NUMBER is the number of the headers. */
NEPH_API unsigned neph_version_get_number(void);

/** Progress of a call. Valid only during the callback. */
typedef struct neph_progress {
  const char *stage;  /**< name of the current stage, a few words: "baking", "rendering"; never NULL */
  double fraction;    /**< completed share of the call, by predicted times of its stages: 0 to 1, never less than
                           before */
  double elapsed_s;   /**< seconds since the call began */
  double remaining_s; /**< estimated seconds until the call ends; infinite before there is an estimate */
} neph_progress;

/** Reports progress, and can cancel.
 *
 * Called on the thread of the library call, several times a second.
 * @return false to cancel: the call then returns NEPH_ERROR_CANCELLED within half a second and leaves nothing behind.
 */
typedef bool (*neph_progress_fn)(void *user, const neph_progress *progress);

/** Format of a description as text. */
typedef enum neph_text_format {
  NEPH_TEXT_PLAIN, /**< aligned lines for people */
  NEPH_TEXT_JSON   /**< one JSON value for programs */
} neph_text_format;

#ifdef __cplusplus
}
#endif

#endif

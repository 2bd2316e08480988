/* SPDX-License-Identifier: Apache-2.0 */
/* Speed of a machine, for predictions of time. */
#ifndef NEPHOS_MACHINE_H
#define NEPHOS_MACHINE_H

#include <nephos/context.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Kinds of work, whose speeds differ from machine to machine. */
typedef enum neph_work {
  NEPH_WORK_TERRAIN, /**< generation and erosion of heights, the ray-tracing structure */
  NEPH_WORK_BAKE,    /**< noise of clouds; volumes */
  NEPH_WORK_SKY,     /**< tables of the air */
  NEPH_WORK_SOLVE,   /**< multiple scattering: bound by memory more than by arithmetic */
  NEPH_WORK_MARCH,   /**< look-ups along rays: the march, sun optical depth, shadows in air */
  NEPH_WORK_PATH     /**< collisions along paths */
} neph_work;

#define NEPH_WORK_COUNT 6

/** "terrain", "bake", "sky", "solve", "march", "path". */
NEPH_API const char *neph_work_get_name(neph_work work);

/** Time that one core of a machine takes, over the time of the machine on which the library's constants were
 * measured. */
typedef struct neph_machine {
  size_t struct_size;
  char cpu[64]; /**< model of the CPU, "" where it is unknown */
  double factor[NEPH_WORK_COUNT];
} neph_machine;

/** A machine as fast as the one of the library's constants. */
#define NEPH_MACHINE_DEFAULT                                                                                           \
  {                                                                                                                    \
    .struct_size = sizeof(neph_machine), .cpu = "", .factor = { 1, 1, 1, 1, 1, 1 }                                     \
  }

/** Measures this machine by a few small scenes: some ten seconds of CPU time. Nothing else should compute.
 *
 * @param progress     NULL: no callback.
 * @param out_machine  starts from NEPH_MACHINE_DEFAULT; unchanged on failure.
 */
NEPH_API neph_result neph_machine_calibrate(neph_context *context, neph_progress_fn progress, void *user,
                                            neph_machine *out_machine) NEPH_NODISCARD;

/** Writes a machine's figures as JSON; the file appears complete or not at all. */
NEPH_API neph_result neph_machine_save(neph_context *context, const neph_machine *machine,
                                       const char *path) NEPH_NODISCARD;

/** Reads a file of neph_machine_save. A file measured on another model of CPU is ignored: a warning says so, and the
 * result is NEPH_MACHINE_DEFAULT. NEPH_ERROR_BAD_FILE, with a message, where it is damaged; NEPH_ERROR_NOT_FOUND where
 * there is none.
 *
 * @param out_machine  starts from NEPH_MACHINE_DEFAULT; unchanged on failure.
 */
NEPH_API neph_result neph_machine_load(neph_context *context, const char *path,
                                       neph_machine *out_machine) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif

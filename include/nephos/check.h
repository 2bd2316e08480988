/* SPDX-License-Identifier: Apache-2.0 */
/* Checks of files and scenes before they are rendered: faults of their contents, each with its place, its cause and the
 * key or option that mends it. */
#ifndef NEPHOS_CHECK_H
#define NEPHOS_CHECK_H

#include <nephos/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A list of findings. One owner. */
typedef struct neph_check neph_check;

typedef enum neph_severity {
  NEPH_SEVERITY_NOTE,    /**< worth knowing; pictures are as meant */
  NEPH_SEVERITY_WARNING, /**< pictures may differ from what is intended */
  NEPH_SEVERITY_ERROR    /**< a render refuses the file or the scene */
} neph_severity;

/** A finding of a check. Its texts are valid until the check changes or ends. */
typedef struct neph_finding {
  size_t struct_size;
  neph_severity severity;
  const char *rule;  /**< "values.nan"; "read" for complaints of the reader itself */
  const char *file;  /**< name of the file, as given or as the scene has it */
  const char *grid;  /**< grid of a .vdb; NULL: the finding concerns the whole file */
  const char *place; /**< "voxel (1, 2, 3), (0.5, 1, 1.5)", "4:12" of a scene; NULL: none */
  const char *cause;
  const char *remedy;   /**< keys and options; NULL: the cause names them, or none helps */
  unsigned frame_count; /**< number of frames of a sequence that have the fault; 0: not a sequence */
} neph_finding;

#define NEPH_FINDING_DEFAULT                                                                                           \
  { .struct_size = sizeof(neph_finding) }

/** A check without findings. Until it is destroyed, errors and warnings of its context become findings and do not reach
 * the context's log: a scene loaded in the meantime is checked as well. One check at a time for each context, and no
 * other calls of that context on other threads. */
NEPH_API neph_result neph_check_create(neph_context *context, neph_check **out_check) NEPH_NODISCARD;

/** Ends a check. NULL is allowed. */
NEPH_API void neph_check_destroy(neph_check *check);

/** Sets the callback for the progress of checks. `progress` NULL: no callback. */
NEPH_API void neph_check_set_progress(neph_check *check, neph_progress_fn progress, void *user);

/** Sets the file to which findings of other calls, such as loading a scene, belong. NULL: none. */
NEPH_API neph_result neph_check_set_file(neph_check *check, const char *path) NEPH_NODISCARD;

/** Checks a file by its name's ending: .vdb, or a name with #### for all frames of a sequence; height fields; .exr and
 * .png pictures; .csv phase functions, places, cameras and star catalogues; .gltf and .glb cameras; meshes; scenes,
 * .yaml and .yml, and where a key of one fails, the files that it names. Faults are findings: the call itself fails
 * only where memory runs out, the progress callback cancels, or the kind of file is unknown. */
NEPH_API neph_result neph_check_file(neph_check *check, const char *path) NEPH_NODISCARD;

/** Whether the ending of `path` is one that neph_check_file accepts. */
NEPH_API bool neph_check_is_file(const char *path);

/** Checks a scene, of the check's context, with all files that it names, in a frame. */
NEPH_API neph_result neph_check_scene(neph_check *check, const neph_scene *scene, int frame) NEPH_NODISCARD;

/** Number of findings of a severity, those beyond the list counted. */
NEPH_API size_t neph_check_count(const neph_check *check, neph_severity severity);

/** Number of listed findings: the first 200. */
NEPH_API size_t neph_check_get_finding_count(const neph_check *check);

/** @param out_finding  starts from NEPH_FINDING_DEFAULT; unchanged on failure, which is that of its struct_size, or an
 * index beyond the list. */
NEPH_API neph_result neph_check_get_finding(const neph_check *check, size_t index,
                                            neph_finding *out_finding) NEPH_NODISCARD;

/** Describes all findings and their number.
 *
 * @param out_text  free it with neph_text_destroy; NULL on failure.
 */
NEPH_API neph_result neph_check_describe(const neph_check *check, neph_text_format format,
                                         char **out_text) NEPH_NODISCARD;

/** Writes a mended copy of a .vdb or .nvdb file, or of each file of a sequence, where both names have ####: scalar
 * grids hold finite values that are not negative, infinity becoming the largest finite value and all else 0, densities
 * end in 0 and are fog volumes, values beyond halves are stored as floats, velocities and colours are finite. All other
 * grids, but points, which are refused, and all metadata are kept; so is a grid that looks like a level set without its
 * class, with a warning. A copy of a .nvdb is not compressed; quantised grids become floats, and other types of numbers
 * are refused. `out_path` ends as the file does, and appears complete or not at all; the file itself is refused.
 *
 * @param out_text  describes the changes of each grid; free it with neph_text_destroy; NULL is allowed.
 */
NEPH_API neph_result neph_check_mend_file(neph_context *context, const char *path, const char *out_path,
                                          char **out_text) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif

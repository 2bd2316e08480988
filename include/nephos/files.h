/* SPDX-License-Identifier: Apache-2.0 */
/* The files that a command reads and writes: a check beforehand that none is overwritten by another. */
#ifndef NEPHOS_FILES_H
#define NEPHOS_FILES_H

#include <nephos/base.h>
#include <nephos/context.h>

#ifdef __cplusplus
extern "C" {
#endif

struct neph_scene;

/** A table of files, each with its role. */
typedef struct neph_files neph_files;

typedef enum neph_file_use { NEPH_FILE_READ, NEPH_FILE_WRITTEN } neph_file_use;

/** @param out_files  owned by the caller; NULL on failure. */
NEPH_API neph_result neph_files_create(neph_context *context, neph_files **out_files) NEPH_NODISCARD;

/** Destroys a table of files. NULL is allowed. */
NEPH_API void neph_files_destroy(neph_files *files);

/** Adds a file, which need not be there. Folders, devices, pipes, and a `path` of NULL add nothing. Fails with
 * NEPH_ERROR_IO, and one message, where a file that is written has a name or a path that is too long, or lies in the
 * folder of a cache.
 *
 * @param role  the key or the option that names it, for messages; copied, as the path is.
 */
NEPH_API neph_result neph_files_add(neph_files *files, neph_file_use use, const char *role,
                                    const char *path) NEPH_NODISCARD;

/** Adds all that a scene reads: its file, those that its keys name, and those of its clouds, with every file of a
 * sequence, and the levels of detail beside them, but for files that clouds are baked to. */
NEPH_API neph_result neph_files_add_scene(neph_files *files, const struct neph_scene *scene) NEPH_NODISCARD;

/** Adds the file of a cloud that is baked, and the levels of detail beside it, "cloud.lod1.vdb", …: all that a bake
 * writes, or, read, those that are there. */
NEPH_API neph_result neph_files_add_bake(neph_files *files, neph_file_use use, const char *role,
                                         const struct neph_scene *scene, unsigned cloud_index,
                                         const char *path) NEPH_NODISCARD;

/** Adds the light of sun and moon that a render keeps beside a checkpoint, "shot.npart.light0-0", …, and removes with
 * it. A `checkpoint_path` of NULL adds nothing. */
NEPH_API neph_result neph_files_add_light(neph_files *files, const char *checkpoint_path) NEPH_NODISCARD;

/** NEPH_ERROR_INVALID_ARGUMENT, with one message, where a file that is written is one of the others as well: by device
 * and inode where it is there, else by its name behind links. */
NEPH_API neph_result neph_files_check(const neph_files *files) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of a picture, tiles and ranges of samples, and merging them to the whole. */
#ifndef NEPHOS_PARTS_H
#define NEPHOS_PARTS_H

#include <nephos/render.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Size of a hash as text, its terminating zero included. */
#define NEPH_HASH_SIZE 33

/** Fingerprint of everything that determines the bits of a picture: scene, contents of its files, settings, frame, eye,
 * seed, version of nephos and instruction-set level. Tiles and ranges of samples of one picture share one hash.
 * Finished pictures bear it as the attribute nephos:sceneHash. Reads every file that the frame is rendered from.
 *
 * @param desc      NULL: the scene's own settings.
 * @param out_hash  empty on failure, and where the scene holds an object set by a call.
 */
NEPH_API neph_result neph_render_compute_hash(const neph_scene *scene, const neph_render_desc *desc,
                                              char out_hash[NEPH_HASH_SIZE]) NEPH_NODISCARD;

/** Whether a file is the finished picture of a render, or, with desc.part_path, the finished part, by the hash, the
 * tile and the range of samples in its header; false where there is no file.
 *
 * @param desc  NULL: the scene's own settings.
 */
NEPH_API neph_result neph_render_is_done(const neph_scene *scene, const neph_render_desc *desc, const char *path,
                                         bool *out_is_done) NEPH_NODISCARD;

/** Removes the light that a render has kept beside its checkpoint (neph_render_desc.checkpoint_path), which a finished
 * frame no longer needs. The checkpoint itself stays. */
NEPH_API void neph_checkpoint_clear_light(const char *checkpoint_path);

/** Joins parts of one picture, tiles and ranges of samples, to the bits of the whole.
 *
 * Parts are files of neph_render_desc.part_path, and .exr files of tiles. Fails with NEPH_ERROR_INVALID_ARGUMENT where
 * parts are of different pictures or overlap, with NEPH_ERROR_NOT_FOUND where some are missing, whose list is in the
 * message, with NEPH_ERROR_BAD_FILE where one is damaged.
 *
 * @param out_pixel_type  pixel type of the file to write; NULL is allowed.
 * @param out_image       owned by the caller; NULL on failure.
 */
NEPH_API neph_result neph_parts_merge(neph_context *context, const char *const *paths, size_t path_count,
                                      neph_pixel_type *out_pixel_type, neph_image **out_image) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Textures of a scene for renderers in real time: weather maps, profiles, noises, tables of the sky, distances. */
#ifndef NEPHOS_TEXTURES_H
#define NEPHOS_TEXTURES_H

#include <nephos/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Format of the files of textures. */
typedef enum neph_texture_format {
  NEPH_TEXTURE_KTX2, /**< Khronos texture 2.0, one level, not compressed */
  NEPH_TEXTURE_RAW   /**< texels alone, x fastest, little-endian */
} neph_texture_format;

enum { NEPH_TEXTURE_SIZE_MIN = 16, NEPH_TEXTURE_SIZE_MAX = 1024 };

/** One texture, or the JSON file that describes all of them. Valid only during the callback. */
typedef struct neph_texture {
  const char *name;    /**< its name in the JSON file */
  const char *path;    /**< path of its file */
  const char *texels;  /**< format of its texels, as Vulkan names it: "R8G8B8A8_UNORM"; "JSON" of the JSON file */
  unsigned size[3];    /**< texels along x, y, z, 1 where it has no such axis; 0 where only a bake shows its size */
  uint64_t byte_count; /**< bytes of its texels, or of the JSON file; 0 where only a bake shows its size */
} neph_texture;

/** Reports one texture, after all have been written. Called on the thread of the library call. */
typedef void (*neph_texture_fn)(void *user, const neph_texture *texture);

typedef struct neph_textures_desc {
  size_t struct_size;
  neph_texture_format format; /**< default NEPH_TEXTURE_KTX2 */
  unsigned size;              /**< voxels along the longest edge of the distances of a cloud, at most;
                                   NEPH_TEXTURE_SIZE_MIN to NEPH_TEXTURE_SIZE_MAX (default 128) */
  bool is_dry_run;            /**< reports the textures, and writes nothing (default false) */
  neph_texture_fn report;     /**< default NULL */
  void *report_user;          /**< default NULL */
  neph_progress_fn progress;  /**< default NULL */
  void *progress_user;        /**< default NULL */
} neph_textures_desc;

#define NEPH_TEXTURES_DESC_DEFAULT                                                                                     \
  {                                                                                                                    \
    .struct_size = sizeof(neph_textures_desc), .format = NEPH_TEXTURE_KTX2, .size = 128, .is_dry_run = false,          \
    .report = NULL, .report_user = NULL, .progress = NULL, .progress_user = NULL                                       \
  }

/** Writes the textures of a scene, as it stands in a frame, and `textures.json`, which describes each of them, into a
 * folder:
 *
 * - noises that repeat, and blue noise: the same for every scene;
 * - of the air, where the scene has any: transmittance, multiple scattering, and the sky from the camera;
 * - of each baked cloud: weather map, profile, extinction, signed distance, and optical depth in six directions.
 *
 * Clouds that are read from files have none, which the log says. Either all files appear or none. The same bits for any
 * number of threads.
 *
 * @param desc    NULL for the defaults.
 * @param folder  one that exists.
 */
NEPH_API neph_result neph_scene_export_textures(const neph_scene *scene, int frame, const neph_textures_desc *desc,
                                                const char *folder) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif

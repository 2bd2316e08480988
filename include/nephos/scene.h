/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes, described in docs/scene-format.md: read from YAML, changed key by key. */
#ifndef NEPHOS_SCENE_H
#define NEPHOS_SCENE_H

#include <nephos/image.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A camera, a sun, an atmosphere, clouds, a terrain, and how to render and write them. One owner. */
typedef struct neph_scene neph_scene;

/** A scene with every key at its default. */
NEPH_API neph_result neph_scene_create(neph_context *context, neph_scene **out_scene) NEPH_NODISCARD;

/** Reads a scene file; relative paths in it are seen from its folder. "-" reads standard input. All errors of a scene
 * are logged, in the order of its file, at most 20 and then their number; an error of the YAML ends the reading. */
NEPH_API neph_result neph_scene_load(neph_context *context, const char *path, neph_scene **out_scene) NEPH_NODISCARD;

/** Reads a scene file as neph_scene_load does, for a scene of which more keys will be set before its use: only
 * neph_scene_check then checks keys together. */
NEPH_API neph_result neph_scene_open(neph_context *context, const char *path, neph_scene **out_scene) NEPH_NODISCARD;

/** Reads a scene from text; `name` stands for the file in messages and for relative paths. */
NEPH_API neph_result neph_scene_load_text(neph_context *context, const char *text, const char *name,
                                          neph_scene **out_scene) NEPH_NODISCARD;

/** Ends a scene. NULL is allowed. */
NEPH_API void neph_scene_destroy(neph_scene *scene);

/** Sets one key as the scene file would: `neph_scene_set(scene, "clouds[0].voxel", "20 m")`.
 *
 * @param key    a key of `nephos schema`; an old name is accepted, with a warning.
 * @param value  YAML in flow style, with its unit.
 */
NEPH_API neph_result neph_scene_set(neph_scene *scene, const char *key, const char *value) NEPH_NODISCARD;

/** Sets the frame in which a scene is described, checked, and shown by pictures of its sky, by its USD layer and by
 * neph_scene_get_output: keys of `animate` have their values in it. Renders, bakes, maps and exports are of the frame
 * that they are given, and leave this one as it is. A new scene is at frame 1. Texts got from the scene stay valid. */
NEPH_API neph_result neph_scene_set_frame(neph_scene *scene, int frame) NEPH_NODISCARD;

/** Whether any key changes from frame to frame. */
NEPH_API bool neph_scene_is_animated(const neph_scene *scene);

/** Checks keys together: each cloud has a source and a density unit, a terrain its kind, a camera a direction, stars a
 * time and a place. All errors are logged, each by a message of its own, and their number where there are several.
 * Loading ends with it, and plans, renders and bakes begin with it; a scene that neph_scene_set is still putting
 * together may fail it. Called itself, once a scene is complete, it also warns of each key that is given and that
 * another rules out, as terrain.width beside an .hgt. */
NEPH_API neph_result neph_scene_check(const neph_scene *scene) NEPH_NODISCARD;

/** Whether every file that a scene reads can be opened, with an error for each that cannot: tables, pictures, height
 * fields, but not the .vdb files of clouds, whose names may differ from frame to frame: neph_render_explain opens those
 * too. */
NEPH_API neph_result neph_scene_check_files(const neph_scene *scene) NEPH_NODISCARD;

/** Keys with type, unit, range and default, and old names of keys.
 *
 * @param key       a key, which is listed with all below it, or the beginning of keys: "camera", "clouds[0].phase",
 *                  "output.p"; NULL: all. NEPH_ERROR_INVALID_ARGUMENT when no key begins so.
 * @param out_text  free it with neph_text_destroy; NULL on failure.
 */
NEPH_API neph_result neph_schema_describe(neph_context *context, const char *key, neph_text_format format,
                                          char **out_text) NEPH_NODISCARD;

/** Every key of a scene with its value, defaults and presets resolved, as text to be freed with neph_text_destroy. */
NEPH_API neph_result neph_scene_describe(const neph_scene *scene, neph_text_format format,
                                         char **out_text) NEPH_NODISCARD;

/** Output files of a scene and their format. Texts are valid until the scene changes. */
typedef struct neph_output {
  size_t struct_size;
  const char *image;              /**< OpenEXR name, '#' for the frame; resolved; NULL: none wanted */
  const char *preview;            /**< PNG name, '#' for the frame; resolved; NULL: none wanted */
  const char *deep;               /**< deep OpenEXR name, '#' for the frame; resolved; NULL: none wanted */
  neph_pixel_type pixel_type;     /**< type of colour pixels (default NEPH_PIXEL_HALF) */
  bool has_beauty;                /**< false: the picture has no R, G and B, and no preview */
  neph_preview_desc preview_desc; /**< stays the last, so that it can grow */
} neph_output;

#define NEPH_OUTPUT_DEFAULT                                                                                            \
  { .struct_size = sizeof(neph_output), .has_beauty = true, .preview_desc = NEPH_PREVIEW_DESC_DEFAULT }

/** @param out_output  starts from NEPH_OUTPUT_DEFAULT; unchanged on failure. */
NEPH_API neph_result neph_scene_get_output(const neph_scene *scene, neph_output *out_output) NEPH_NODISCARD;

/** Whether each frame has two pictures, of a left and a right eye: camera.stereo is given, and its eye is both. */
NEPH_API bool neph_scene_is_stereo(const neph_scene *scene);

/** Number of clouds in a scene. */
NEPH_API unsigned neph_scene_get_cloud_count(const neph_scene *scene);

/** Name of a cloud; NULL when `index` is not below the count. */
NEPH_API const char *neph_scene_get_cloud_name(const neph_scene *scene, unsigned index);

/** Whether a cloud is baked from parameters rather than read from a file alone. */
NEPH_API bool neph_scene_is_cloud_baked(const neph_scene *scene, unsigned index);

/** File of a cloud, resolved, a pattern where it has one for each frame: read, or baked to where the cloud is baked as
 * well. NULL when it has none, or when `index` is not below the count. */
NEPH_API const char *neph_scene_get_cloud_file(const neph_scene *scene, unsigned index);

/** Picture of a baked cloud's weather map, resolved, a pattern where it has one for each frame. NULL when there is
 * none, or a shape in its place. */
NEPH_API const char *neph_scene_get_cloud_map(const neph_scene *scene, unsigned index);

/** Whether a name is a pattern, with a place for the number of a frame: "####", "%04d" or "$F4", padded with zeros to
 * 4 digits, "%d", "$F", or "$FF", which is for frames between two as well. */
NEPH_API bool neph_frame_is_numbered(const char *pattern);

/** The name that a pattern has in one frame: the last place for a number holds it.
 *
 * @param out_path  free it with neph_text_destroy; a copy of `pattern` where it is no pattern.
 */
NEPH_API neph_result neph_frame_get_path(neph_context *context, const char *pattern, int frame,
                                         char **out_path) NEPH_NODISCARD;

#ifdef __cplusplus
}
#endif

#endif

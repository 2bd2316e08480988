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

/** Copies a scene, its frame and its objects too, which both then hold: one copy may change while the other renders.
 *
 * @param out_scene  owned by the caller; NULL on failure.
 */
NEPH_API neph_result neph_scene_clone(const neph_scene *scene, neph_scene **out_scene) NEPH_NODISCARD;

/** Ends a scene. NULL is allowed. */
NEPH_API void neph_scene_destroy(neph_scene *scene);

/** Sets one key as the scene file would: `neph_scene_set(scene, "clouds[0].voxel", "20 m")`.
 *
 * @param key    a key of `nephos schema`; an old name is accepted, with a warning.
 * @param value  YAML in flow style, with its unit.
 */
NEPH_API neph_result neph_scene_set(neph_scene *scene, const char *key, const char *value) NEPH_NODISCARD;

/** Takes a key away, so that it has its default: `neph_scene_unset(scene, "sun.elevation")`. A failure changes nothing.
 *
 * A key that is not given is none to take away. A section stays, perhaps empty, when its keys go, and goes with all of
 * them when it is named itself. "clouds[1]" removes one element of a list: later ones move down, and so do the keys of
 * `animate` that name them. Tracks of a key go with it.
 */
NEPH_API neph_result neph_scene_unset(neph_scene *scene, const char *key) NEPH_NODISCARD;

/** Inserts an element into a list of sections: `neph_scene_insert(scene, "clouds[0]", "{name: fog, bake: {}}")`.
 *
 * Later elements move up, and so do the keys of `animate` that name them. A failure changes nothing.
 *
 * @param key    a list with the index that the element gets, at most the number of elements.
 * @param value  YAML in flow style: a mapping of the element's keys.
 */
NEPH_API neph_result neph_scene_insert(neph_scene *scene, const char *key, const char *value) NEPH_NODISCARD;

/** Sets several keys in order, or takes them away where their value is NULL: all of them, or none where one is wrong or
 * neph_scene_check refuses the scene that results. A program that edits a scene piece by piece keeps it renderable so.
 *
 * @param keys, values  `count` keys, as neph_scene_set and neph_scene_unset take them, and their values.
 */
NEPH_API neph_result neph_scene_set_keys(neph_scene *scene, const char *const *keys, const char *const *values,
                                         unsigned count) NEPH_NODISCARD;

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

/** Keys with type, unit, range and default, and old names of keys. As JSON also controls for an editor: `label`, `rank`
 * ("basic" or "all"), `soft_min` to `soft_max`, the usual values in the key's unit, with `step` and `scale` ("linear",
 * or "log", whose step is a share of the value), and `cost`, the work that an edit causes: "display", pixels alone,
 * "view", the picture by the same light, "light", light too, "bake", clouds or terrain too.
 *
 * @param key       a key, which is listed with all below it, or the beginning of keys: "camera", "clouds[0].phase",
 *                  "output.p"; NULL: all. NEPH_ERROR_INVALID_ARGUMENT when no key begins so.
 * @param out_text  free it with neph_text_destroy; NULL on failure.
 */
NEPH_API neph_result neph_schema_describe(neph_context *context, const char *key, neph_text_format format,
                                          char **out_text) NEPH_NODISCARD;

/** Every key of a scene with its value, defaults and presets resolved, as text to be freed with neph_text_destroy. JSON
 * has the texts in `values`, in `numbers` the numbers among them in the unit of the schema, to 12 digits, a list for
 * several, and in `given` whether the scene states the key itself. */
NEPH_API neph_result neph_scene_describe(const neph_scene *scene, neph_text_format format,
                                         char **out_text) NEPH_NODISCARD;

/** The text that a scene was read from, with what has changed since: values are replaced where they stand, new keys
 * come at the end of their mapping, keys taken away are cut. Everything else keeps its bytes: comments, order, blanks,
 * breaks of lines. A scene without a text gets one of a line for each section.
 *
 * NEPH_ERROR_UNSUPPORTED where a volume, a terrain or an air was given by the program, where the text is UTF-16, and
 * where its layout does not let the changes be put in. A text that is returned reads as the scene.
 *
 * @param out_text  free it with neph_text_destroy; NULL on failure.
 */
NEPH_API neph_result neph_scene_get_text(const neph_scene *scene, char **out_text) NEPH_NODISCARD;

/** Writes neph_scene_get_text to a file, atomically, the file that the scene was read from or another. In another
 * folder relative names of files would mean others: NEPH_ERROR_INVALID_ARGUMENT names the first. */
NEPH_API neph_result neph_scene_save(const neph_scene *scene, const char *path) NEPH_NODISCARD;

/** Keys that differ from the text that a scene was read from: as options of the command line, one a line, "--set
 * 'sun.elevation=5 deg'", a key that was taken away as a comment, or as JSON, "edits" with "key" and "value", null
 * where it was taken away. A list whose number of elements has changed is one value.
 *
 * @param out_text  free it with neph_text_destroy; NULL on failure.
 */
NEPH_API neph_result neph_scene_describe_edits(const neph_scene *scene, neph_text_format format,
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

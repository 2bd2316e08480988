/* SPDX-License-Identifier: Apache-2.0 */
/* Kinds of files, by their names' endings. */
#include <math.h>
#include <string.h>
#include <strings.h>

#include <nephos/terrain.h>

#include "check/check_heights.h"
#include "check/check_mesh.h"
#include "check/check_scene.h"
#include "check/check_table.h"
#include "check/check_volume.h"
#include "core/alloc.h"
#include "core/file.h"
#include "core/frame_name.h"
#include "core/given.h"
#include "core/path_map.h"
#include "image/image_private.h"
#include "mesh/camera_file.h"
#include "scene/scene_node.h"

typedef np_finding_draft draft;

/* ---- Pictures ---- */

static neph_result check_height_file(neph_check *check, const char *path) {
  return np_check_heights(check, path, NULL);
}

/* Checks a PNG. Heights need 16 bits of grey: others are weather maps, or pictures of the ground. */
static neph_result check_png(neph_check *check, const char *path) {
  static const np_rule other = {"picture.kind", NEPH_SEVERITY_NOTE, NULL};
  neph_image *image = NULL;
  unsigned bits = 0;
  bool is_grey = false;
  draft out = {{0}, {0}};
  neph_result result = neph_check_set_file(check, path);
  if (!result) result = np_image_read_png_kind(check->context, path, &bits, &is_grey);
  if (!result && bits == 16 && is_grey) return check_height_file(check, path);
  if (!result) result = neph_image_load_png(check->context, path, &image);
  neph_image_destroy(image);
  if (result) return np_check_pass(result);
  np_draft_set(&out,
               "it has %u bits%s: taken for a picture, as a weather map or the colours of the ground, since heights "
               "have 16 bits of grey, or a terrain.encoding",
               bits, is_grey ? "" : " of colour");
  np_check_add(check, &other, &out);
  return NEPH_OK;
}

static void check_channel(neph_check *check, neph_image *image, const char *name) {
  static const np_rule bad = {"picture.values", NEPH_SEVERITY_WARNING, "render or export it anew"};
  const float *values = neph_image_get_channel(image, name);
  const size_t width = neph_image_get_width(image), count = width * neph_image_get_height(image);
  const bool is_depth = !strcasecmp(name, "Z") || strstr(name, "distance") || strstr(name, "depth");
  size_t bad_count = 0, first = 0;
  for (size_t i = 0; i < count; i++)
    if (!isfinite(values[i]) && !(is_depth && !isnan(values[i])) && !bad_count++) first = i;
  draft out = {{0}, {0}};
  if (!bad_count) return;
  np_draft_set_place(&out, "channel %s, column %zu, row %zu", name, first % width, first / width);
  np_draft_set(&out, "%zu samples are not finite, the first %g", bad_count, (double)values[first]);
  np_check_add(check, &bad, &out);
}

static neph_result check_exr(neph_check *check, const char *path) {
  neph_image *image = NULL;
  neph_result result = neph_check_set_file(check, path);
  if (!result) result = neph_image_load_exr(check->context, path, &image);
  for (unsigned i = 0; !result && i < neph_image_get_channel_count(image); i++)
    check_channel(check, image, neph_image_get_channel_name(image, i));
  neph_image_destroy(image);
  return np_check_pass(result);
}

/* ---- Cameras ---- */

static neph_result check_camera(neph_check *check, const char *path) {
  static const double frame_rate = 24.0;
  static const np_rule still = {"camera.still", NEPH_SEVERITY_NOTE, NULL};
  np_camera_file file;
  draft out = {{0}, {0}};
  neph_result result = neph_check_set_file(check, path);
  if (!result) result = np_camera_file_load(check->context, path, NULL, frame_rate, &file);
  if (result) return np_check_pass(result);
  if (file.count == 1 && np_draft_set(&out, "its camera stands still")) np_check_add(check, &still, &out);
  np_camera_file_clear(&file);
  return NEPH_OK;
}

/* Checks a glTF as a camera and as a mesh; the complaint that it has no camera does not count where it has a mesh. */
static neph_result check_gltf(neph_check *check, const char *path) {
  const size_t listed = check->listed, errors = check->counts[NEPH_SEVERITY_ERROR];
  neph_result result = check_camera(check, path);
  if (result || check->counts[NEPH_SEVERITY_ERROR] == errors) return result;
  check->listed = listed;
  check->counts[NEPH_SEVERITY_ERROR] = errors;
  return np_check_mesh(check, path, NULL);
}

/* ---- Scenes ---- */

static bool is_scene(const char *path) { return np_file_has_ending(path, ".yaml") || np_file_has_ending(path, ".yml"); }

/* Checks the existing files that scalars of a scene name. */
static neph_result check_named_in(neph_check *check, const char *scene, const np_node *node) {
  neph_result result = NEPH_OK;
  for (const np_node *child = node->first; child && !result; child = child->next)
    result = check_named_in(check, scene, child);
  if (result || node->kind != NP_NODE_SCALAR || !neph_check_is_file(node->text) || is_scene(node->text)) return result;
  char *path, *problem;
  result = np_path_map_resolve(check->context, scene, node->text, &path, &problem);
  np_alloc_free(check->context, problem);
  if (result) return result == NEPH_ERROR_BAD_SCENE ? NEPH_OK : result; /* a scene logs its own errors */
  if (np_frame_name_is_pattern(path) || np_file_exists(path)) result = neph_check_file(check, path);
  np_alloc_free(check->context, path);
  return result;
}

/* Checks the files of a scene whose keys fail, each by itself, without those that it writes. */
static neph_result check_named_files(neph_check *check, const char *path) {
  void *bytes;
  size_t size;
  np_node *document, *output;
  neph_result result = np_file_read_any(check->context, path, &bytes, &size);
  if (result) return result;
  result = np_scene_parse(check->context, bytes, size, path, false, &document);
  np_alloc_free(check->context, bytes);
  if (result) return result;
  while ((output = np_node_search(document, "output"))) {
    np_node_remove(document, output);
    np_node_destroy(check->context, output);
  }
  result = check_named_in(check, path, document);
  np_node_destroy(check->context, document);
  return result;
}

static neph_result check_scene_file(neph_check *check, const char *path) {
  neph_scene *scene = NULL;
  neph_result result = neph_check_set_file(check, path);
  if (!result) result = neph_scene_load(check->context, path, &scene);
  if (!result) result = neph_scene_check(scene);
  result = result ? check_named_files(check, path) : np_check_scene_frame(check, scene, path, 1);
  neph_scene_destroy(scene);
  return np_check_pass(result);
}

/* ---- Kinds ---- */

static neph_result check_vdb(neph_check *check, const char *path) {
  return np_frame_name_is_pattern(path) ? np_check_sequence(check, path, NULL)
                                        : np_check_volume(check, path, true, NULL, NULL);
}

static neph_result check_mesh(neph_check *check, const char *path) { return np_check_mesh(check, path, NULL); }

static const struct {
  const char *ending;
  neph_result (*check)(neph_check *check, const char *path);
} kinds[] = {
    {".vdb", check_vdb},         {".nvdb", check_vdb},        {".yaml", check_scene_file},
    {".yml", check_scene_file},  {".exr", check_exr},         {".csv", np_check_table},
    {".gltf", check_gltf},       {".glb", check_gltf},        {".hgt", check_height_file},
    {".png", check_png},         {".tif", check_height_file}, {".tiff", check_height_file},
    {".asc", check_height_file}, {".bil", check_height_file}, {".flt", check_height_file},
    {".dem", check_height_file}, {".img", check_height_file}, {".dt0", check_height_file},
    {".dt1", check_height_file}, {".dt2", check_height_file}, {".vrt", check_height_file},
    {".zip", check_height_file}, {".obj", check_mesh},        {".ply", check_mesh},
    {".stl", check_mesh},        {".fbx", check_mesh},        {".dae", check_mesh},
    {".r16", check_height_file}, {".raw", check_height_file}, {".chan", np_check_camera_table},
    {".nc", check_vdb},
};

enum { KIND_COUNT = sizeof kinds / sizeof *kinds };

static size_t search_kind(const char *path) {
  size_t kind = 0;
  while (kind < KIND_COUNT && !np_file_has_ending(path, kinds[kind].ending)) kind++;
  return kind;
}

bool neph_check_is_file(const char *path) { return path && search_kind(path) < KIND_COUNT; }

neph_result neph_check_file(neph_check *check, const char *path) {
  if (NP_LACKS(NP_CONTEXT_OF(check), path)) return NEPH_ERROR_INVALID_ARGUMENT;
  const size_t kind = search_kind(path);
  if (kind == KIND_COUNT)
    return np_fail(check->context, NEPH_ERROR_INVALID_ARGUMENT, "%s has an unknown ending", path);
  const unsigned float_mode = np_float_mode_enter();
  const neph_result result = kinds[kind].check(check, path);
  np_float_mode_leave(float_mode);
  check->file = NULL;
  return result;
}

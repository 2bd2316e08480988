/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_private.h"

#include <nephos/files.h>

#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/frame_name.h"
#include "core/given.h"
#include "core/path_map.h"
#include "core/text.h"
#include "scene/scene_keys.h"
#include "terrain/heightfield_files.h"
#include "volume/volume_levels.h"

enum { PATH_SIZE = 160 };

/* Checks that a file exists; `key` is as in --set. */
static neph_result check_file(const neph_scene *scene, const np_node *node, const char *key, const char *path) {
  const char *reason;
  if (np_height_files_is_pattern(path)) return NEPH_OK; /* pattern of several files */
  neph_result result = np_file_probe(path, &reason);
  if (!result) return result;
  const char *hint = strpbrk(path, "@<%") ? " (a number is ####, %04d, $F4 or $F)" : "";
  if (!node->line)
    return np_fail(scene->context, result, "%s is %s, which cannot be read: %s%s", key, path, reason, hint);
  return np_fail(scene->context, result, "%s:%u:%u: %s is %s, which cannot be read: %s%s",
                 scene->file ? scene->file : "scene", node->line, node->column, key, path, reason, hint);
}

neph_result np_scene_check_cloud_file(const neph_scene *scene, unsigned index, const char *path) {
  char key[PATH_SIZE];
  const np_node *cloud = np_node_get(np_node_search(scene->document, "clouds"), index);
  const np_node *model = np_node_search(cloud, "netcdf"), *file = model ? np_node_search(model, "file") : NULL;
  np_print(key, sizeof key, "clouds[%u].%s", index, file ? "netcdf.file" : model ? "netcdf" : "vdb");
  return check_file(scene, file ? file : model ? model : np_node_search(cloud, "vdb"), key, path);
}

/* Name of a node for messages; nodes set by calls have no line. */
static char *name_node(const neph_scene *scene, const np_node *node) {
  if (!node->line) return np_alloc_text(scene->context, "");
  return np_alloc_printf(scene->context, "%s:%u:%u: ", scene->file ? scene->file : "scene", node->line, node->column);
}

neph_result np_scene_check_cloud_unit(const neph_scene *scene, unsigned index, const char *path,
                                      double extinction_per_value) {
  if (scene->clouds[index].density_unit != NP_DENSITY_OF_FILE || extinction_per_value > 0.0) return NEPH_OK;
  char *place = name_node(scene, np_node_get(np_node_search(scene->document, "clouds"), index));
  if (!place) return NEPH_ERROR_OUT_OF_MEMORY;
  const neph_result result =
      np_fail(scene->context, NEPH_ERROR_BAD_SCENE,
              "%sclouds[%u] has no unit for the values of its file, must have one of extinction, mean_free_path, "
              "optical_depth, liquid_water: %s states none (units: 1/m, and nephos:extinction_per_value above 0)",
              place, index, path);
  np_alloc_free(scene->context, place);
  return result;
}

/* ---- File keys ---- */

typedef struct lookup lookup;

/* Visits a file named by a node. */
typedef neph_result visit_fn(const lookup *l, const np_node *node, const char *file);

/* Search of a key in the document, over all elements of the lists in its path. */
struct lookup {
  const neph_scene *scene;
  const np_key *key;
  visit_fn *visit;
  neph_files *files;    /* list to which files are added; NULL: none */
  char path[PATH_SIZE]; /* path of `node`, as in --set */
};

static neph_result visit_node(const lookup *l, const np_node *node) {
  if (node->kind != NP_NODE_SCALAR) return NEPH_OK;
  if (l->key->is_numbered && np_frame_name_is_pattern(node->text))
    return NEPH_OK; /* the bake of each frame checks it */
  char *file = np_path_map_resolve_again(l->scene->context, l->scene->file, node->text);
  if (file) np_frame_name_unescape(file);
  neph_result result = file ? l->visit(l, node, file) : NEPH_ERROR_OUT_OF_MEMORY;
  np_alloc_free(l->scene->context, file);
  return result;
}

static neph_result visit_below(lookup *l, const np_node *node, const char *rest);

static neph_result visit_elements(lookup *l, const np_node *list, const char *rest) {
  const size_t length = strlen(l->path);
  unsigned index = 0;
  neph_result result = NEPH_OK;
  for (const np_node *item = list->first; item; item = item->next) {
    np_print(l->path + length, sizeof l->path - length, "[%u].", index++);
    const neph_result of_item = visit_below(l, item, rest);
    if (!result) result = of_item;
  }
  return result;
}

/* Visits the files below `node`; `rest` is the remaining path of the key: "clouds[].phase.table". */
static neph_result visit_below(lookup *l, const np_node *node, const char *rest) {
  const size_t length = strlen(l->path), count = strcspn(rest, ".[");
  np_print(l->path + length, sizeof l->path - length, "%.*s", (int)count, rest);
  const np_node *child = node->kind == NP_NODE_MAPPING ? np_node_search(node, l->path + length) : NULL;
  if (!child) return NEPH_OK;
  if (rest[count] == '[') return visit_elements(l, child, rest + count + strlen("[]."));
  if (rest[count] == '\0') return visit_node(l, child);
  const char *below = rest + count + 1;
  if (child->kind == NP_NODE_SCALAR && !strchr(below, '.') && np_key_is_shorthand(l->key)) return visit_node(l, child);
  np_print(l->path + length + count, sizeof l->path - length - count, ".");
  return visit_below(l, child, below);
}

/* Visits all files, even after a failure. */
static neph_result visit_files(const neph_scene *scene, visit_fn *visit, neph_files *files) {
  neph_result result = NEPH_OK;
  for (size_t i = 0; i < np_key_count(); i++) {
    lookup l = {.scene = scene, .key = np_key_get(i), .visit = visit, .files = files};
    const neph_result of_key =
        np_key_get(i)->is_input ? visit_below(&l, scene->document, np_key_get(i)->path) : NEPH_OK;
    if (!result) result = of_key;
  }
  return result;
}

static neph_result check_visited(const lookup *l, const np_node *node, const char *file) {
  return check_file(l->scene, node, l->path, file);
}

neph_result neph_scene_check_files(const neph_scene *scene) {
  return scene ? visit_files(scene, check_visited, NULL) : NEPH_ERROR_INVALID_ARGUMENT;
}

/* ---- List of files ---- */

static neph_result add_heights(const lookup *l, const char *pattern) {
  np_height_files list = {NULL, 0};
  neph_result result = np_height_files_list(l->scene->context, pattern, &list);
  for (size_t i = 0; !result && i < list.count; i++)
    result = neph_files_add(l->files, NEPH_FILE_READ, l->path, list.paths[i]);
  np_height_files_clear(l->scene->context, &list);
  return result;
}

/* Adds up to `count` files of levels of detail beside a cloud's file, if it is an input and as far as they exist. */
static neph_result add_levels(neph_files *files, neph_file_use use, const char *role, const char *path, unsigned count,
                              neph_context *context) {
  neph_result result = NEPH_OK;
  bool is_present = true;
  for (unsigned k = 1; k < count && is_present && !result; k++) {
    char *level = np_volume_name_level(context, path, k);
    if (!level) return NEPH_ERROR_OUT_OF_MEMORY;
    is_present = use == NEPH_FILE_WRITTEN || np_file_exists(level);
    if (is_present) result = neph_files_add(files, use, role, level);
    np_alloc_free(context, level);
  }
  return result;
}

/* Adds a file of a key, and the level files read with a cloud's file. */
static neph_result add_file(const lookup *l, const char *path) {
  const neph_result result = neph_files_add(l->files, NEPH_FILE_READ, l->path, path);
  if (result || strncmp(l->path, "clouds", strlen("clouds")) != 0) return result;
  return add_levels(l->files, NEPH_FILE_READ, l->path, path, NEPH_BAKE_LODS_MAX, l->scene->context);
}

/* Adds the existing files of a sequence. */
static neph_result add_sequence(const lookup *l, const char *pattern) {
  neph_context *context = l->scene->context;
  np_frame_numbers list = {NULL, 0};
  neph_result result = np_frame_name_list(context, pattern, &list);
  for (size_t i = 0; !result && i < list.count; i++) {
    char *path = np_frame_name_make(context, pattern, list.numbers[i]);
    result = path ? add_file(l, path) : NEPH_ERROR_OUT_OF_MEMORY;
    np_alloc_free(context, path);
  }
  np_alloc_free(context, list.numbers);
  return result;
}

static neph_result add_visited(const lookup *l, const np_node *node, const char *file) {
  (void)node;
  if (np_height_files_is_pattern(file)) return add_heights(l, file);
  if (np_frame_name_is_pattern(file) && !np_file_exists(file)) return add_sequence(l, file);
  return add_file(l, file);
}

static bool has_model(const neph_scene *scene, unsigned index) {
  return np_node_search(np_node_get(np_node_search(scene->document, "clouds"), index), "netcdf");
}

static neph_result add_cloud(const neph_scene *scene, unsigned index, neph_files *files) {
  const np_scene_cloud *cloud = &scene->clouds[index];
  lookup l = {.scene = scene, .files = files};
  np_print(l.path, sizeof l.path, "clouds[%u].%s", index, has_model(scene, index) ? "netcdf" : "vdb");
  if (!cloud->vdb || cloud->volume || cloud->is_baked) return NEPH_OK;
  return add_visited(&l, NULL, cloud->vdb);
}

neph_result neph_files_add_scene(neph_files *files, const neph_scene *scene) {
  if (!files || !scene) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_result result = neph_files_add(files, NEPH_FILE_READ, "the scene", scene->file);
  if (!result) result = visit_files(scene, add_visited, files);
  for (unsigned i = 0; !result && i < scene->cloud_count; i++) result = add_cloud(scene, i, files);
  return result;
}

neph_result neph_files_add_bake(neph_files *files, neph_file_use use, const char *role, const neph_scene *scene,
                                unsigned cloud_index, const char *path) {
  if (!files || !scene || !path || cloud_index >= scene->cloud_count) return NEPH_ERROR_INVALID_ARGUMENT;
  const np_scene_cloud *cloud = &scene->clouds[cloud_index];
  const unsigned written_count = cloud->bake.repeat_m > 0.0 ? 1 : cloud->level_count;
  const unsigned count = use == NEPH_FILE_READ ? NEPH_BAKE_LODS_MAX : written_count;
  const neph_result result = neph_files_add(files, use, role, path);
  return result ? result : add_levels(files, use, role, path, count, scene->context);
}

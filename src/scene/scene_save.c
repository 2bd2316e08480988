/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes as files: the text that was read, with the edits since. */
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/file.h"
#include "core/given.h"
#include "core/json.h"
#include "core/path_map.h"
#include "scene/scene_apply.h"
#include "scene/scene_diff.h"
#include "scene/scene_flow.h"
#include "scene/scene_save.h"

/* ---- What no text can hold ---- */

static bool has_assets(const np_node *node) {
  if (node->assets.volume || node->assets.terrain || node->assets.atmosphere) return true;
  for (const np_node *child = node->first; child; child = child->next)
    if (has_assets(child)) return true;
  return false;
}

neph_result np_scene_check_text(const neph_scene *scene) {
  for (const np_node *section = np_scene_get_source(scene)->first; section; section = section->next)
    if (has_assets(section))
      return np_fail(scene->context, NEPH_ERROR_UNSUPPORTED,
                     "%s is an object of the program, which a scene file cannot name: set it to a file", section->key);
  return NEPH_OK;
}

/* libyaml reads UTF-16 behind its byte-order mark alone. */
static neph_result check_encoding(const neph_scene *scene) {
  const char *text = scene->text;
  if (!text || scene->text_size < 2 || (memcmp(text, "\xff\xfe", 2) != 0 && memcmp(text, "\xfe\xff", 2) != 0))
    return NEPH_OK;
  return np_fail(scene->context, NEPH_ERROR_UNSUPPORTED,
                 "%s: a scene in UTF-16 cannot be edited in place: make it UTF-8", scene->file);
}

/* ---- Texts ---- */

neph_result np_scene_parse_original(const neph_scene *scene, np_node **out_document) {
  neph_result result = check_encoding(scene);
  *out_document = NULL;
  if (result) return result;
  if (scene->text)
    return np_scene_parse(scene->context, scene->text, scene->text_size, scene->file ? scene->file : "scene", false,
                          out_document);
  *out_document = np_node_create(scene->context, NP_NODE_MAPPING, NULL, NULL);
  return *out_document ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
}

/* A text of one line for each section. */
static neph_result write_sections(const neph_scene *scene, char **out_text) {
  np_text text = {.context = scene->context};
  const np_node *document = np_scene_get_source(scene);
  if (!document->first) np_text_add(&text, "{}\n");
  for (const np_node *section = document->first; section; section = section->next) {
    np_flow_add_scalar(&text, section->key, false);
    np_text_add(&text, ": ");
    np_flow_add(&text, np_key_search(NULL, section->key), section);
    np_text_add(&text, "\n");
  }
  return np_text_finish(&text, out_text);
}

/* Whether a text reads as the scene's document. */
static bool reads_as(const neph_scene *scene, const char *text) {
  np_node *document;
  if (np_scene_parse(scene->context, text, strlen(text), NULL, false, &document)) return false;
  const bool is_same = np_flow_is_same(NULL, document, np_scene_get_source(scene));
  np_node_destroy(scene->context, document);
  return is_same;
}

static neph_result fail_splicing(const neph_scene *scene) {
  return np_fail(scene->context, NEPH_ERROR_UNSUPPORTED,
                 "%s: the edits cannot be put into this text, whose layout is unusual: write its sections as "
                 "\"key: value\" lines",
                 scene->file ? scene->file : "scene");
}

static neph_result splice(const neph_scene *scene, char **out_text) {
  np_node *original;
  neph_result result = np_scene_parse_original(scene, &original);
  if (result) return result;
  result =
      np_scene_splice(scene->context, scene->text, scene->text_size, original, np_scene_get_source(scene), out_text);
  np_node_destroy(scene->context, original);
  const bool is_wrong = !result && !reads_as(scene, *out_text);
  if (is_wrong) {
    np_alloc_free(scene->context, *out_text);
    *out_text = NULL;
  }
  return is_wrong || result == NEPH_ERROR_INTERNAL ? fail_splicing(scene) : result;
}

neph_result neph_scene_get_text(const neph_scene *scene, char **out_text) {
  if (NP_LACKS_OUT(NP_CONTEXT_OF(scene), out_text)) return NEPH_ERROR_INVALID_ARGUMENT;
  *out_text = NULL;
  const locale_t saved = np_values_enter();
  neph_result result = np_scene_check_text(scene);
  if (!result) result = scene->text ? splice(scene, out_text) : write_sections(scene, out_text);
  np_values_leave(saved);
  return result;
}

/* ---- Files ---- */

/* Checks that a name of a file means the same file in a scene at `path`. */
static neph_result check_file(const neph_scene *scene, const np_key *key, const np_node *node, const char *path) {
  char *here = np_path_map_resolve_again(scene->context, scene->file, node->text);
  char *there = np_path_map_resolve_again(scene->context, path, node->text);
  neph_result result = here && there ? NEPH_OK : NEPH_ERROR_OUT_OF_MEMORY;
  if (!result && strcmp(here, there) != 0)
    result = np_fail(scene->context, NEPH_ERROR_INVALID_ARGUMENT,
                     "%s: %s is %s, seen from the folder of %s: save the scene there, or give the name in full", path,
                     key->path, node->text, scene->file ? scene->file : "the program");
  np_alloc_free(scene->context, here);
  np_alloc_free(scene->context, there);
  return result;
}

static neph_result check_files_in(const neph_scene *scene, const np_key *key, const np_node *node, const char *path) {
  const bool is_mapping = node->kind == NP_NODE_MAPPING;
  if (node->kind == NP_NODE_SCALAR)
    return key && key->type == NP_KEY_FILE && *node->text ? check_file(scene, key, node, path) : NEPH_OK;
  neph_result result = NEPH_OK;
  for (const np_node *child = node->first; child && !result; child = child->next) {
    const np_key *below = is_mapping ? np_key_search(key, child->key) : key;
    if (below) result = check_files_in(scene, below, child, path);
  }
  return result;
}

static char *get_folder(const char *path) {
  char *folder = path ? strdup(path) : NULL, *slash = folder ? strrchr(folder, '/') : NULL;
  if (slash) slash[slash == folder] = '\0';
  char *real = realpath(slash ? folder : ".", NULL);
  free(folder);
  return real;
}

static bool is_same_folder(const char *a, const char *b) {
  char *of_a = get_folder(a), *of_b = get_folder(b);
  const bool is_same = of_a && of_b && !strcmp(of_a, of_b);
  free(of_a);
  free(of_b);
  return is_same;
}

neph_result neph_scene_save(const neph_scene *scene, const char *path) {
  if (NP_LACKS(NP_CONTEXT_OF(scene), path)) return NEPH_ERROR_INVALID_ARGUMENT;
  neph_result result = NEPH_OK;
  char *text = NULL;
  if (!is_same_folder(scene->file, path)) result = check_files_in(scene, NULL, np_scene_get_source(scene), path);
  if (!result) result = neph_scene_get_text(scene, &text);
  if (!result) result = neph_text_save(scene->context, text, path);
  neph_text_destroy(scene->context, text);
  return result;
}

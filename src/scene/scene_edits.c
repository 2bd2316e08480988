/* SPDX-License-Identifier: Apache-2.0 */
/* The edits of a scene: keys whose value is no longer that of its text. */
#include <string.h>

#include "core/alloc.h"
#include "core/given.h"
#include "core/json.h"
#include "scene/scene_flow.h"
#include "scene/scene_save.h"

enum { PATH_SIZE = 512 };

typedef struct edit_list {
  neph_context *context;
  np_json *json; /* NULL: options go to `text` */
  np_text text;
  char path[PATH_SIZE];
  neph_result result;
} edit_list;

/* ---- One edit ---- */

/* Adds a word for a shell, in single quotes. */
static void add_word(np_text *out, const char *text) {
  np_text_add(out, "'");
  for (; *text; text++) np_text_add(out, *text == '\'' ? "'\\''" : "%c", *text);
  np_text_add(out, "'");
}

static neph_result add_option(edit_list *list, const char *value) {
  if (!value) return np_text_add(&list->text, "# %s is no longer given\n", list->path), NEPH_OK;
  char *assignment = np_alloc_printf(list->context, "%s=%s", list->path, value);
  if (!assignment) return NEPH_ERROR_OUT_OF_MEMORY;
  np_text_add(&list->text, "--set ");
  add_word(&list->text, assignment);
  np_text_add(&list->text, "\n");
  np_alloc_free(list->context, assignment);
  return NEPH_OK;
}

static void put_object(edit_list *list, const char *value) {
  np_json_begin_object(list->json, NULL);
  np_json_put_text(list->json, "key", list->path);
  np_json_put_text(list->json, "value", value);
  np_json_end(list->json);
}

/* Adds an edit of the key `list->path`; NULL: it is taken away. */
static void add_edit(edit_list *list, const np_key *key, const np_node *node) {
  np_text text = {.context = list->context};
  char *value = NULL;
  if (node) np_flow_add(&text, key, node);
  neph_result result = node ? np_text_finish(&text, &value) : NEPH_OK;
  if (!result && list->json) put_object(list, value);
  if (!result && !list->json) result = add_option(list, value);
  if (result) list->result = result;
  np_alloc_free(list->context, value);
}

/* ---- Documents ---- */

static void list_edits(edit_list *list, const np_key *key, const np_node *old, const np_node *now);

/* Appends a part to the path, lists what is below it, and takes the part off. */
static void list_below(edit_list *list, const np_key *key, const char *part, const np_node *old, const np_node *now) {
  const size_t length = strlen(list->path);
  np_print(list->path + length, PATH_SIZE - length, "%s", part);
  list_edits(list, key, old, now);
  list->path[length] = '\0';
}

static void list_entry(edit_list *list, const np_key *section, const char *name, const np_node *old,
                       const np_node *now) {
  char part[PATH_SIZE / 2];
  if (strlen(list->path) + strlen(name) + 2 > PATH_SIZE / 2) return; /* no key is as long */
  np_print(part, sizeof part, "%s%s", *list->path ? "." : "", name);
  list_below(list, np_key_search(section, name), part, old, now);
}

static const char *get_new_name(const np_key *section, const char *name) {
  const np_key_rename *rename = np_key_get_rename(section, name);
  return rename ? np_path_get_name(rename->path) : name;
}

/* Keys that are gone first: a key may exclude one that was there. */
static void list_mapping(edit_list *list, const np_key *section, const np_node *old, const np_node *now) {
  for (const np_node *child = old->first; child; child = child->next) {
    const char *name = get_new_name(section, child->key);
    const np_node *other = np_node_search(now, name);
    list_entry(list, section, name, child, other);
  }
  for (const np_node *child = now->first; child; child = child->next) {
    bool is_new = true;
    for (const np_node *other = old->first; other; other = other->next)
      if (!strcmp(get_new_name(section, other->key), child->key)) is_new = false;
    if (is_new) list_entry(list, section, child->key, NULL, child);
  }
}

static void list_elements(edit_list *list, const np_key *key, const np_node *old, const np_node *now) {
  char part[32];
  unsigned index = 0;
  for (; old && now; old = old->next, now = now->next) {
    np_print(part, sizeof part, "[%u]", index++);
    list_below(list, key, part, old, now);
  }
}

static void list_edits(edit_list *list, const np_key *key, const np_node *old, const np_node *now) {
  if (old && now && np_flow_is_same(key, old, now)) return;
  const bool is_root = !*list->path, is_pair = old && now && old->kind == now->kind;
  if (is_root || (is_pair && old->kind == NP_NODE_MAPPING))
    list_mapping(list, key, old, now);
  else if (is_pair && key && key->type == NP_KEY_LIST && np_node_count(old) == np_node_count(now))
    list_elements(list, key, old->first, now->first);
  else
    add_edit(list, key, now);
}

/* ---- The call ---- */

static neph_result finish(edit_list *list, char **out_text) {
  if (!list->json) {
    const neph_result result = np_text_finish(&list->text, out_text);
    return list->result ? list->result : result;
  }
  np_json_end(list->json);
  if (!list->result) return np_json_finish(list->json, out_text);
  np_json_destroy(list->json);
  return list->result;
}

static neph_result describe(const neph_scene *scene, const np_node *original, neph_text_format format,
                            char **out_text) {
  edit_list list = {.context = scene->context, .text = {.context = scene->context}};
  if (format == NEPH_TEXT_JSON) {
    list.json = np_json_create(scene->context);
    if (!list.json) return NEPH_ERROR_OUT_OF_MEMORY;
    np_json_put_text(list.json, "kind", "edits");
    np_json_put_text(list.json, "file", scene->file);
    np_json_begin_array(list.json, "edits");
  }
  list_edits(&list, NULL, original, np_scene_get_source(scene));
  return finish(&list, out_text);
}

neph_result neph_scene_describe_edits(const neph_scene *scene, neph_text_format format, char **out_text) {
  if (NP_LACKS_OUT(NP_CONTEXT_OF(scene), out_text)) return NEPH_ERROR_INVALID_ARGUMENT;
  np_node *original;
  *out_text = NULL;
  const locale_t saved = np_values_enter();
  neph_result result = np_scene_check_text(scene);
  if (!result) result = np_scene_parse_original(scene, &original);
  if (!result) {
    result = describe(scene, original, format, out_text);
    np_node_destroy(scene->context, original);
  }
  np_values_leave(saved);
  if (result) {
    np_alloc_free(scene->context, *out_text);
    *out_text = NULL;
  }
  return result;
}

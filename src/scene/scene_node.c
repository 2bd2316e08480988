/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_node.h"

#include <string.h>

#include "core/alloc.h"

np_node *np_node_create(neph_context *context, np_node_kind kind, const char *text, const char *key) {
  np_node *node = np_alloc(context, 1, sizeof *node);
  if (!node) return NULL;
  node->kind = kind;
  node->text = text ? np_alloc_text(context, text) : NULL;
  node->key = key ? np_alloc_text(context, key) : NULL;
  if ((text && !node->text) || (key && !node->key)) {
    np_node_destroy(context, node);
    return NULL;
  }
  return node;
}

np_node *np_node_create_numbers(neph_context *context, const double *numbers, unsigned count) {
  np_node *node = np_node_create(context, count == 1 ? NP_NODE_NUMBER : NP_NODE_SEQUENCE, NULL, NULL);
  if (node && count == 1) node->number = *numbers;
  for (unsigned i = 0; node && count > 1 && i < count; i++) {
    np_node *item = np_node_create_numbers(context, &numbers[i], 1);
    if (!item) return np_node_destroy(context, node), NULL;
    np_node_append(node, item);
  }
  return node;
}

/* Appends a scalar of `length` bytes to `list`. */
static bool append_scalar(neph_context *context, np_node *list, const char *text, size_t length) {
  np_node *item = np_node_create(context, NP_NODE_SCALAR, NULL, NULL);
  if (!item) return false;
  np_node_append(list, item);
  item->text = np_alloc_printf(context, "%.*s", (int)length, text);
  return item->text != NULL;
}

np_node *np_node_create_value(neph_context *context, const char *text) {
  static const char separator[] = ", ";
  if (!strstr(text, separator)) return np_node_create(context, NP_NODE_SCALAR, text, NULL);
  np_node *list = np_node_create(context, NP_NODE_SEQUENCE, NULL, NULL);
  for (const char *end; list && text; text = end ? end + strlen(separator) : NULL) {
    end = strstr(text, separator);
    if (append_scalar(context, list, text, end ? (size_t)(end - text) : strlen(text))) continue;
    np_node_destroy(context, list);
    list = NULL;
  }
  return list;
}

np_node_assets np_node_assets_retain(np_node_assets assets) {
  (void)neph_volume_retain(assets.volume);
  (void)neph_terrain_retain(assets.terrain);
  (void)neph_atmosphere_retain(assets.atmosphere);
  return assets;
}

static void release_assets(const np_node_assets *assets) {
  neph_volume_release(assets->volume);
  neph_terrain_release(assets->terrain);
  neph_atmosphere_release(assets->atmosphere);
}

void np_node_destroy(neph_context *context, np_node *node) {
  if (!node) return;
  while (node->first) {
    np_node *child = node->first;
    node->first = child->next;
    np_node_destroy(context, child);
  }
  release_assets(&node->assets);
  np_alloc_free(context, node->text);
  np_alloc_free(context, node->key);
  np_alloc_free(context, node);
}

np_node *np_node_copy(neph_context *context, const np_node *node) {
  np_node *copy = np_node_create(context, node->kind, node->text, node->key);
  if (!copy) return NULL;
  copy->is_quoted = node->is_quoted;
  copy->number = node->number;
  copy->line = node->line;
  copy->column = node->column;
  copy->key_line = node->key_line;
  copy->key_column = node->key_column;
  copy->is_flow = node->is_flow;
  copy->begin = node->begin;
  copy->end = node->end;
  copy->key_begin = node->key_begin;
  copy->assets = np_node_assets_retain(node->assets);
  np_node **link = &copy->first;
  for (const np_node *child = node->first; child; child = child->next, link = &(*link)->next) {
    *link = np_node_copy(context, child);
    if (!*link) {
      np_node_destroy(context, copy);
      return NULL;
    }
  }
  return copy;
}

/* Pointer that links to `child`, or, for NULL, the last one. */
static np_node **search_link(np_node *parent, const np_node *child) {
  np_node **link = &parent->first;
  while (*link != child) link = &(*link)->next;
  return link;
}

void np_node_append(np_node *parent, np_node *child) {
  child->next = NULL;
  *search_link(parent, NULL) = child;
}

void np_node_insert(np_node *parent, const np_node *next, np_node *child) {
  np_node **link = search_link(parent, next);
  child->next = *link;
  *link = child;
}

void np_node_remove(np_node *parent, np_node *child) {
  *search_link(parent, child) = child->next;
  child->next = NULL;
}

void np_node_replace(neph_context *context, np_node *parent, np_node *child, np_node *node) {
  np_node **link = search_link(parent, child);
  char *key = node->key;
  node->key = child->key;
  child->key = key;
  node->next = child->next;
  child->next = NULL;
  *link = node;
  np_node_destroy(context, child);
}

np_node *np_node_search(const np_node *mapping, const char *key) {
  if (mapping->kind != NP_NODE_MAPPING) return NULL;
  for (np_node *child = mapping->first; child; child = child->next)
    if (!strcmp(child->key, key)) return child;
  return NULL;
}

np_node *np_node_get(const np_node *sequence, size_t index) {
  np_node *child = sequence->first;
  while (child && index--) child = child->next;
  return child;
}

size_t np_node_count(const np_node *node) {
  size_t count = 0;
  for (const np_node *child = node->first; child; child = child->next) count++;
  return count;
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "view_edits.h"

#include <stdlib.h>
#include <string.h>

static void clear_edit(cli_view_edit *edit) {
  free(edit->key);
  free(edit->value);
  *edit = (cli_view_edit){0};
}

/* Drops the edits behind the first `count`. */
static void truncate_list(cli_view_edits *edits, size_t count) {
  while (edits->count > count) clear_edit(&edits->list[--edits->count]);
  if (edits->in_force > count) edits->in_force = count;
}

void cli_view_edits_clear(cli_view_edits *edits) {
  truncate_list(edits, 0);
  free(edits->list);
  *edits = (cli_view_edits){0};
}

void cli_view_edits_begin(cli_view_edits *edits, unsigned long long gesture) {
  if (!gesture || gesture != edits->gesture) edits->group++;
  edits->gesture = gesture;
}

/* The set of a key in the current group, behind which that group has sets alone; NULL: none. */
static cli_view_edit *get_same(cli_view_edits *edits, const char *key) {
  for (size_t i = edits->in_force; i-- > 0 && edits->list[i].group == edits->group;) {
    if (edits->list[i].kind != CLI_VIEW_SET) return NULL;
    if (!strcmp(edits->list[i].key, key)) return &edits->list[i];
  }
  return NULL;
}

/* Appends a copy of an edit. */
static bool append(cli_view_edits *edits, const cli_view_edit *edit) {
  cli_view_edit *list = realloc(edits->list, (edits->count + 1) * sizeof *list);
  if (!list) return false;
  edits->list = list;
  cli_view_edit *copy = &list[edits->count];
  *copy = (cli_view_edit){edit->kind, strdup(edit->key), edit->value ? strdup(edit->value) : NULL, edit->group};
  if (!copy->key || (edit->value && !copy->value)) return clear_edit(copy), false;
  edits->in_force = ++edits->count;
  return true;
}

bool cli_view_edits_add(cli_view_edits *edits, cli_view_edit_kind kind, const char *key, const char *value) {
  truncate_list(edits, edits->in_force);
  cli_view_edit *same = kind == CLI_VIEW_SET ? get_same(edits, key) : NULL;
  if (!same) {
    const cli_view_edit edit = {kind, (char *)(uintptr_t)key, (char *)(uintptr_t)value, edits->group};
    return append(edits, &edit);
  }
  char *copy = strdup(value);
  if (!copy) return false;
  free(same->value);
  same->value = copy;
  return true;
}

bool cli_view_edits_undo(cli_view_edits *edits) {
  if (!edits->in_force) return false;
  const unsigned long long group = edits->list[edits->in_force - 1].group;
  while (edits->in_force && edits->list[edits->in_force - 1].group == group) edits->in_force--;
  edits->gesture = 0;
  return true;
}

bool cli_view_edits_redo(cli_view_edits *edits) {
  if (edits->in_force == edits->count) return false;
  const unsigned long long group = edits->list[edits->in_force].group;
  while (edits->in_force < edits->count && edits->list[edits->in_force].group == group) edits->in_force++;
  edits->gesture = 0;
  return true;
}

void cli_view_edits_drop(cli_view_edits *edits, size_t count) {
  for (size_t i = 0; i < count; i++) clear_edit(&edits->list[i]);
  if (count) memmove(edits->list, edits->list + count, (edits->count - count) * sizeof *edits->list);
  edits->count -= count;
  edits->in_force -= count;
}

neph_result cli_view_edits_apply(const cli_view_edits *edits, neph_scene *scene) {
  neph_result result = NEPH_OK;
  for (size_t i = 0; !result && i < edits->in_force; i++) {
    const cli_view_edit *edit = &edits->list[i];
    if (edit->kind == CLI_VIEW_SET)
      result = neph_scene_set(scene, edit->key, edit->value);
    else if (edit->kind == CLI_VIEW_UNSET)
      result = neph_scene_unset(scene, edit->key);
    else
      result = neph_scene_insert(scene, edit->key, edit->value);
  }
  return result;
}

bool cli_view_edits_copy(const cli_view_edits *edits, cli_view_edits *copy) {
  bool is_complete = true;
  *copy = (cli_view_edits){0};
  for (size_t i = 0; is_complete && i < edits->count; i++) is_complete = append(copy, &edits->list[i]);
  copy->in_force = is_complete ? edits->in_force : 0;
  copy->group = edits->group;
  copy->gesture = edits->gesture;
  if (!is_complete) cli_view_edits_clear(copy);
  return is_complete;
}

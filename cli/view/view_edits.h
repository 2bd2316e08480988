/* SPDX-License-Identifier: Apache-2.0 */
/* Edit history of a scene: edits in force, followed by undone ones. */
#ifndef NEPHOS_CLI_VIEW_EDITS_H
#define NEPHOS_CLI_VIEW_EDITS_H

#include <stdio.h>

#include <nephos/nephos.h>

typedef enum cli_view_edit_kind {
  CLI_VIEW_SET,
  CLI_VIEW_UNSET, /* resets a key to its default, or removes a list element */
  CLI_VIEW_INSERT /* inserts a list element */
} cli_view_edit_kind;

typedef struct cli_view_edit {
  cli_view_edit_kind kind;
  char *key, *value;        /* no value: unset */
  unsigned long long group; /* edits of one group are undone together */
} cli_view_edit;

/* Edit history; empty when zeroed. */
typedef struct cli_view_edits {
  cli_view_edit *list;
  size_t count;                      /* all edits */
  size_t in_force;                   /* edits that are not undone, the first of the list */
  unsigned long long group, gesture; /* last group, and the gesture that it belongs to */
} cli_view_edits;

void cli_view_edits_clear(cli_view_edits *edits);

/* Begins a group of edits that are undone together, unless the same `gesture` above 0 continues. */
void cli_view_edits_begin(cli_view_edits *edits, unsigned long long gesture);

/* Adds an edit to the group; a set replaces one of the same key at the group's end. Undone edits are dropped. False: no
 * memory. */
bool cli_view_edits_add(cli_view_edits *edits, cli_view_edit_kind kind, const char *key, const char *value);

/* Undoes or redoes the last group; false: there is none. */
bool cli_view_edits_undo(cli_view_edits *edits);
bool cli_view_edits_redo(cli_view_edits *edits);

/* Drops the first `count` edits, which are in force. */
void cli_view_edits_drop(cli_view_edits *edits, size_t count);

/* Applies the edits in force. */
neph_result cli_view_edits_apply(const cli_view_edits *edits, neph_scene *scene);

/* A copy of the edits. False: no memory; the copy is empty. */
bool cli_view_edits_copy(const cli_view_edits *edits, cli_view_edits *out_copy);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Changes on disk: of the scene's file, and of the files that the scene reads. One thread uses it. */
#ifndef NEPHOS_CLI_VIEW_WATCH_H
#define NEPHOS_CLI_VIEW_WATCH_H

#include <stdbool.h>
#include <stddef.h>

typedef struct cli_view_watch cli_view_watch;

/* Watches a scene's file. NULL: no memory, or the system has no more watches; nothing is followed then. */
cli_view_watch *cli_view_watch_create(const char *scene_path);
void cli_view_watch_destroy(cli_view_watch *watch);

/* Descriptor that becomes readable when something may have changed; -1 for NULL. */
int cli_view_watch_get(const cli_view_watch *watch);

/* Watches the files of a scene, by the text of neph_scene_describe, in place of those before. In names of sequences
 * '#' stands for digits of `frame`. */
void cli_view_watch_set_files(cli_view_watch *watch, const char *schema, const char *described, int frame);

/* Takes the changes since the last call: whether the scene's file may have changed, and whether one of the others has.
 */
typedef struct cli_view_changes {
  bool is_scene, is_file;
} cli_view_changes;

cli_view_changes cli_view_watch_take(cli_view_watch *watch);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* The files of a scene, watched for changes. */
#ifndef NEPHOS_CLI_VIEW_WATCH_H
#define NEPHOS_CLI_VIEW_WATCH_H

#include <stdbool.h>

/* Watches the folder of a file, since editors write a new one and rename it. Returns a descriptor that can be read
 * after a change; -1: the system gives none, and nothing is watched. */
int cli_view_watch_open(const char *path);

/* Reads the pending changes of the folder; returns whether the file itself is among them. */
bool cli_view_watch_take(int watch, const char *path);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Folders for the program's own files: a report, a calibration. */
#ifndef NEPHOS_CLI_MAKE_FOLDER_H
#define NEPHOS_CLI_MAKE_FOLDER_H

#include <stdbool.h>

/* Creates the missing folders of a path, up to its last slash. */
void cli_folder_make_parents(const char *path);

/* Creates a folder with its parents. `*out_is_made`: it was missing. Returns false, after a message, on failure. */
bool cli_folder_make(const char *path, bool *out_is_made);

#endif

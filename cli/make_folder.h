/* SPDX-License-Identifier: Apache-2.0 */
/* Folders that the program keeps its own files in: a report, a calibration. */
#ifndef NEPHOS_CLI_MAKE_FOLDER_H
#define NEPHOS_CLI_MAKE_FOLDER_H

#include <stdbool.h>

/* Makes the folders that a path leads through, up to its last slash, as far as they are missing. */
void cli_folder_make_parents(const char *path);

/* Makes a folder with its parents. `*out_is_made`: it was missing. False, with a message: it cannot be made. */
bool cli_folder_make(const char *path, bool *out_is_made);

#endif

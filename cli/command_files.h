/* SPDX-License-Identifier: Apache-2.0 */
/* The files of a command, and the check that none is overwritten by another. */
#ifndef NEPHOS_CLI_COMMAND_FILES_H
#define NEPHOS_CLI_COMMAND_FILES_H

#include "session.h"

/* Begins a table with the arguments of the command line, which are read, and the files of all options but --output. */
cli_exit cli_files_begin(const cli_session *session, neph_files **out_files);

/* Adds a file that is written: --output where it is given, else the path of a key. */
cli_exit cli_files_add_output(const cli_session *session, neph_files *files, const char *key, const char *path);

/* Adds the files that a scene reads (NULL: none), checks the table and destroys it. `exit` is the result of earlier
 * steps.
 */
cli_exit cli_files_end(neph_files *files, const neph_scene *scene, cli_exit exit);

/* Checks the files of a command without a scene that writes one file, --output. */
cli_exit cli_files_check_output(const cli_session *session);

#endif

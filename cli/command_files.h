/* SPDX-License-Identifier: Apache-2.0 */
/* The files of a command, which refuses to write one over another before it begins. */
#ifndef NEPHOS_CLI_COMMAND_FILES_H
#define NEPHOS_CLI_COMMAND_FILES_H

#include "session.h"

/* Begins the table with the arguments of the command line, which are read, and the files of options but --output. */
cli_exit cli_files_begin(const cli_session *session, neph_files **out_files);

/* Adds a file that is written: by --output where it is given, else by a key. */
cli_exit cli_files_add_output(const cli_session *session, neph_files *files, const char *key, const char *path);

/* Adds the files of a scene that are read. NULL: none. Checks the table and destroys it. `exit` is of the steps before.
 */
cli_exit cli_files_end(neph_files *files, const neph_scene *scene, cli_exit exit);

/* A command without a scene, with one file that is written, by --output. */
cli_exit cli_files_check_output(const cli_session *session);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* The session of a verb: a context that logs to standard error, scenes with their settings, exit codes. */
#ifndef NEPHOS_CLI_SESSION_H
#define NEPHOS_CLI_SESSION_H

#include <stdio.h>

#include <nephos/nephos.h>

#include "options.h"
#include "process.h"
#include "progress.h"

typedef struct cli_session {
  const cli_options *options;
  neph_context *context;
  cli_progress progress;
} cli_session;

cli_exit cli_session_start(const cli_options *options, cli_session *out_session);
void cli_session_end(cli_session *session);

/* The exit code for a result. */
cli_exit cli_exit_of(neph_result result);

/* Loads a scene and applies the settings of the command line. */
cli_exit cli_load_scene(cli_session *session, const char *path, neph_scene **out_scene);

/* Applies the settings and the frame of the command line to a scene. */
neph_result cli_set_scene(const cli_session *session, neph_scene *scene);
neph_result cli_read_scene(cli_session *session, const char *path, neph_scene **out_scene);

/* Checks whether a file can be created at `path`, without creating one. Returns CLI_IO, after a message, when not. */
cli_exit cli_check_target(const cli_session *session, const char *path);

/* Prints a text of the library and frees it. */
void cli_print_text(cli_session *session, char *text);

/* Format of results: JSON with --json, else plain text. */
neph_text_format cli_text_format(const cli_session *session);

/* Whether `path` ends in `extension`, such as ".exr", in letters of either case. */
bool cli_has_extension(const char *path, const char *extension);

/* Whether `path` has the ending of a scene file, or is "-", a scene on standard input. */
bool cli_is_scene(const char *path);

/* Assigns a path of --output to the preview, .png, or to the picture, with `extension`. False: it has another ending,
 * or there is one already. */
bool cli_place_output(const char *path, const char *extension, const char **image, const char **preview);

/* Whether at most one frame is given. */
bool cli_is_single_frame(const cli_options *options);

#endif

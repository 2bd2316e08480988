/* SPDX-License-Identifier: Apache-2.0 */
/* A verb's surroundings: a context that logs to standard error, scenes with their settings, exit codes. */
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

/* Loads a scene and sets what the command line says. */
cli_exit cli_load_scene(cli_session *session, const char *path, neph_scene **out_scene);
neph_result cli_read_scene(cli_session *session, const char *path, neph_scene **out_scene);

/* Whether a file can be made at `path`, which is not tried by making one. CLI_IO, after a message, when not. */
cli_exit cli_check_target(const cli_session *session, const char *path);

/* Prints a text of the library and frees it. */
void cli_print_text(cli_session *session, char *text);

/* A JSON string, quotes included; printed on standard output. */
void cli_put_json_text(FILE *out, const char *text);
void cli_print_json_text(const char *text);

/* PLAIN, or JSON with --json. */
neph_text_format cli_text_format(const cli_session *session);

/* Whether `path` ends in `extension`, such as ".exr", in letters of either case. */
bool cli_has_extension(const char *path, const char *extension);

/* Whether `path` ends as scene files do, or is "-", a scene on standard input. */
bool cli_is_scene(const char *path);

/* Puts a path of --output in its place: a preview, .png, or a picture, with `extension`. False: it is neither, or its
 * place is taken. */
bool cli_place_output(const char *path, const char *extension, const char **image, const char **preview);

/* Whether no more than one frame is asked for. */
bool cli_is_single_frame(const cli_options *options);

#endif

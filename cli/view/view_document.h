/* SPDX-License-Identifier: Apache-2.0 */
/* The scene under edit: its file and the edits since, each of which can be undone. One thread uses it. */
#ifndef NEPHOS_CLI_VIEW_DOCUMENT_H
#define NEPHOS_CLI_VIEW_DOCUMENT_H

#include <stdio.h>

#include "session.h"
#include "view_messages.h"

typedef struct cli_view_document cli_view_document;

/* Opens the scene of the command line, with its settings. `allows_files`: edits may set keys that name files.
 * `messages` stay the caller's. */
cli_exit cli_view_document_open(cli_session *session, cli_view_messages *messages, const char *path, bool allows_files,
                                cli_view_document **out_document);
void cli_view_document_close(cli_view_document *document);

/* Each of these returns the status of an answer: 200, or that of a refusal, after which the scene is as it was, and
 * cli_view_document_get_refusal has the reason. */

/* Sets the keys of `lines`, each KEY=VALUE. Sets of one gesture, a number above 0, are undone together. */
unsigned cli_view_document_set(cli_view_document *document, char *lines, unsigned long long gesture);

/* Resets a key to its default, or removes an element of a list. */
unsigned cli_view_document_unset(cli_view_document *document, const char *key);

/* Adds a cloud of a preset, behind the others. */
unsigned cli_view_document_add_cloud(cli_view_document *document, const char *preset);
unsigned cli_view_document_undo(cli_view_document *document);
unsigned cli_view_document_redo(cli_view_document *document);

/* Reads the file anew, with the edits since the last save on top, or without any. */
unsigned cli_view_document_reload(cli_view_document *document, bool keeps_edits);

/* Saves the scene, with comments and order, to its file, or to a new file beside it, whose name is returned. */
unsigned cli_view_document_save(cli_view_document *document);
unsigned cli_view_document_save_copy(cli_view_document *document, cli_text *out_name);

/* Chooses a name beside the scene's that no file has: "scene-2.png". */
unsigned cli_view_document_choose_name(cli_view_document *document, const char *ending, cli_text *out_name);

/* Path of the picture that is the map of a cloud's coverage, to be freed; NULL: it has none. A cloud that is not baked
 * is refused. */
unsigned cli_view_document_get_map(cli_view_document *document, unsigned cloud, char **out_path);
double cli_view_document_get_coverage(const cli_view_document *document, unsigned cloud);

/* Whether two paths end in the same name. */
bool cli_view_is_same_name(const char *a, const char *b);

/* Makes a picture, whose name the program has chosen, the map of a cloud, or notes that it has other pixels. */
unsigned cli_view_document_set_map(cli_view_document *document, unsigned cloud, const char *path);

/* Switches a cloud off, or on again, in the pictures alone: the scene keeps it. */
unsigned cli_view_document_toggle_cloud(cli_view_document *document, unsigned cloud);

/* Shows another frame. */
unsigned cli_view_document_set_frame(cli_view_document *document, int frame);
int cli_view_document_get_frame(const cli_view_document *document);

/* Notes that a file that the scene reads has changed on disk. */
void cli_view_document_touch(cli_view_document *document);

/* Key of the pictures of a copy of the scene, by cli_view_past_create_key. */
char *cli_view_document_create_key(const cli_view_document *document, const neph_scene *scene);

/* JSON of the schema, and of the scene's values, to be freed by neph_text_destroy. */
const char *cli_view_document_get_schema(const cli_view_document *document);
neph_result cli_view_document_describe(const cli_view_document *document, char **out_text);

/* Notes the reason of a refusal, and returns its status. */
unsigned cli_view_document_refuse(cli_view_document *document, unsigned status, const char *reason);

const char *cli_view_document_get_refusal(const cli_view_document *document);

/* The scene with all edits, owned by the document. */
const neph_scene *cli_view_document_get_scene(const cli_view_document *document);

/* A copy of the scene for the renderer, whose clouds are baked in memory alone. */
neph_result cli_view_document_copy_scene(cli_view_document *document, neph_scene **out_scene);

/* Makes a copy of the scene for each line, KEY=VALUE, with that key set; at most `max`. */
unsigned cli_view_document_vary(cli_view_document *document, char *lines, unsigned max, neph_scene **out_scenes,
                                unsigned *out_count);

/* Numbers of the last edit that clouds or ground are baked for, that a render shows, and of all. */
unsigned long long cli_view_document_get_bake(const cli_view_document *document);
unsigned long long cli_view_document_get_generation(const cli_view_document *document);
unsigned long long cli_view_document_get_number(const cli_view_document *document);

/* Writes the state as members of a JSON object, without its braces. */
void cli_view_document_write_state(const cli_view_document *document, FILE *out);

/* The least number of samples a pixel that the scene's channels need. */
unsigned cli_view_document_get_samples_min(const cli_view_document *document);

/* JSON of the keys that differ from the file, by neph_scene_describe_edits. */
neph_result cli_view_document_describe_edits(const cli_view_document *document, char **out_text);

/* Notes that the scene's file may have changed on disk. Reads it where there are no edits to lose. Returns whether the
 * scene has changed. */
bool cli_view_document_follow(cli_view_document *document);

/* Path of the scene's file. */
const char *cli_view_document_get_path(const cli_view_document *document);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Complete pictures of the last settings, so that an undo shows its picture at once. */
#ifndef NEPHOS_CLI_VIEW_PAST_H
#define NEPHOS_CLI_VIEW_PAST_H

#include "view_picture.h"

enum { CLI_VIEW_PAST_MAX = 16 };

/* Pictures, the latest first; empty when zeroed. */
typedef struct cli_view_past {
  struct {
    char *key;
    cli_view_step step;
    neph_image *image;
  } list[CLI_VIEW_PAST_MAX];
  size_t count;
} cli_view_past;

/* Keeps a picture, and drops one of the same key, and the oldest beyond 16 pictures or 256 MiB. Takes key and image. */
void cli_view_past_put(cli_view_past *past, char *key, const cli_view_step *step, neph_image *image);

/* The picture of a key, which passes to the caller with its step; NULL: none is kept. */
neph_image *cli_view_past_take(cli_view_past *past, const char *key, cli_view_step *out_step);

void cli_view_past_clear(cli_view_past *past);

/* Makes the key of a scene's pictures, to be freed: all that their pixels depend on, which exposure and view are not.
 * `schema` is the JSON of neph_schema_describe; `files` numbers the states of the files that the scene reads. NULL: no
 * memory. */
char *cli_view_past_create_key(neph_context *context, const char *schema, const neph_scene *scene, int frame,
                               unsigned long long files);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Variants of the scene as small pictures: seeds or presets to choose from. The worker renders them when the picture is
 * done; each function locks for itself. */
#ifndef NEPHOS_CLI_VIEW_VARIANTS_H
#define NEPHOS_CLI_VIEW_VARIANTS_H

#include <stdio.h>

#include <nephos/nephos.h>

enum { CLI_VIEW_VARIANTS_MAX = 16, CLI_VIEW_VARIANT_WIDTH = 112 };

typedef struct cli_view_variants cli_view_variants;

cli_view_variants *cli_view_variants_create(void);
void cli_view_variants_destroy(cli_view_variants *variants);

/* Replaces all variants by `count` scenes, which pass to `variants`. */
void cli_view_variants_begin(cli_view_variants *variants, neph_scene *const *scenes, unsigned count);

/* Whether one is still to be rendered. */
bool cli_view_variants_is_waiting(cli_view_variants *variants);

/* Renders the next variant in a frame. A cancelled variant is rendered again later; a failed one has no picture. */
void cli_view_variants_render(cli_view_variants *variants, neph_renderer *renderer, int frame,
                              neph_progress_fn progress, void *user);

/* Writes their state as members of a JSON object: a number that grows with each set and each picture, and how many. */
void cli_view_variants_write_state(cli_view_variants *variants, FILE *out);

/* Writes a JSON object with width and height of each, a line end, and their pixels one after another. */
void cli_view_variants_write_pixels(cli_view_variants *variants, FILE *out);

#endif

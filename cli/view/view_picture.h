/* SPDX-License-Identifier: Apache-2.0 */
/* The picture on the page: its pixels, the radiance behind them, and its state. The worker shows, the server reads;
 * each function locks for itself. */
#ifndef NEPHOS_CLI_VIEW_PICTURE_H
#define NEPHOS_CLI_VIEW_PICTURE_H

#include <stdio.h>

#include <nephos/nephos.h>

typedef struct cli_view_picture cli_view_picture;

/* `wake` is called after each change, on the thread of the change. */
cli_view_picture *cli_view_picture_create(neph_context *context, void (*wake)(void *user), void *user);
void cli_view_picture_destroy(cli_view_picture *picture);

/* One step of refinement, as the worker begins it. */
typedef struct cli_view_step {
  unsigned long long generation; /* number of the edit that the picture shows */
  unsigned level;                /* 0: few pixels, 1: all, from 2: more samples */
  unsigned width, height;        /* size on the page; pictures of level 0 are smaller, and enlarged */
  unsigned samples;              /* samples a pixel */
  double start_s;                /* time of the edit, by cli_view_clock_get_s */
  double waited_s;               /* seconds from the edit to the first step, while the picture before it ended */
  double region[4]; /* left, top, right, bottom of the part that is rendered, as shares; empty: the whole. Pictures of
                       level 0 are whole */
} cli_view_step;

/* Pixels of a step's region in a picture of a size; `step` NULL: all. */
void cli_view_step_get_window(const cli_view_step *step, unsigned width, unsigned height, unsigned out_min[2],
                              unsigned out_max[2]);

/* Shows a complete picture, or that of a region over the last whole one; it passes to `picture`. A whole one is kept
 * under `key` when another replaces it; NULL: it is not. */
neph_result cli_view_picture_show(cli_view_picture *picture, const cli_view_step *step, const char *key,
                                  neph_image *image);

/* Shows the picture that is kept under a key again, for the edit of `step`, which gets its level, samples and size.
 * False: none is kept. */
bool cli_view_picture_recall(cli_view_picture *picture, const char *key, cli_view_step *step,
                             neph_image_error *out_error);

/* Shows a finished tile over the picture before it; it is on the page after the next flush, at most every 60 ms. */
neph_result cli_view_picture_show_tile(cli_view_picture *picture, const cli_view_step *step, const neph_tile *tile);

/* Develops the complete picture anew, after an edit of exposure or view. The pixels stay where that fails, after a
 * message. */
void cli_view_picture_set_preview(cli_view_picture *picture, const neph_preview_desc *preview);

/* Chooses the channel to show (view_channel.h); "": the picture itself. A picture without it shows itself. */
neph_result cli_view_picture_set_channel(cli_view_picture *picture, const char *name);

/* Saves the last complete picture as OpenEXR, or as the PNG of its preview. NEPH_ERROR_NOT_FOUND: there is none. */
neph_result cli_view_picture_save(cli_view_picture *picture, const char *path, bool is_exr);

/* Sets the name of the current stage, and the last message of the renderer. */
void cli_view_picture_set_stage(cli_view_picture *picture, const char *stage, double fraction);
void cli_view_picture_set_message(cli_view_picture *picture, const char *message);

/* Number of the picture on the page, 0 before the first; it is incremented by each change of pixels. */
unsigned long long cli_view_picture_get_number(cli_view_picture *picture);

/* Writes the state as members of a JSON object, without its braces. */
void cli_view_picture_write_state(cli_view_picture *picture, FILE *out);

/* Writes the pixels, rows of R, G, B, 255 from the top. */
void cli_view_picture_write_pixels(cli_view_picture *picture, FILE *out);

/* Writes the values of all channels at a pixel as a JSON object; an empty one outside of the picture. */
void cli_view_picture_write_values(cli_view_picture *picture, unsigned x, unsigned y, FILE *out);

/* Writes the names of its channels as a JSON list. */
void cli_view_picture_write_channels(cli_view_picture *picture, FILE *out);

#endif

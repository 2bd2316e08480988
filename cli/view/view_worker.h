/* SPDX-License-Identifier: Apache-2.0 */
/* The rendering thread: renders few pixels, then all, then more samples, until the scene changes. */
#ifndef NEPHOS_CLI_VIEW_WORKER_H
#define NEPHOS_CLI_VIEW_WORKER_H

#include "session.h"
#include "view_picture.h"
#include "view_variants.h"

typedef struct cli_view_worker cli_view_worker;

/* Starts the thread, which shows its pictures in `picture`, and renders `variants` when that is done. Fails after a
 * message. */
cli_exit cli_view_worker_create(cli_session *session, cli_view_picture *picture, cli_view_variants *variants,
                                cli_view_worker **out_worker);

/* Ends the current picture and the thread. NULL is allowed. */
void cli_view_worker_destroy(cli_view_worker *worker);

/* A scene to show. */
typedef struct cli_view_order {
  neph_scene *scene;             /* the worker's from the call on */
  char *key;                     /* the worker's too: key of its pictures (view_past.h); NULL: they are not kept */
  unsigned long long generation; /* number of the edit */
  unsigned long long bake;       /* number of the last edit that changed clouds or ground */
  unsigned samples_min;          /* least number of samples a pixel, for the channels of the scene */
  int frame;
} cli_view_order;

/* Hands over a scene, which replaces one that has not begun. The picture under way is cancelled, unless it is of few
 * pixels: while edits come faster than pictures, those are all that is seen. One that takes long is cancelled too, if
 * the one before it was not. */
void cli_view_worker_submit(cli_view_worker *worker, const cli_view_order *order);

/* Renders a part of the picture alone, from the step of all pixels on; an empty one: the whole. Bounds are shares of
 * width and height: left, top, right, bottom. */
void cli_view_worker_set_region(cli_view_worker *worker, const double region[4]);

/* Renders the tiles of later pictures from a place outwards, given as shares of width and height. */
void cli_view_worker_set_focus(cli_view_worker *worker, double x, double y);

/* Has new variants rendered. */
void cli_view_worker_awake(cli_view_worker *worker);

#endif

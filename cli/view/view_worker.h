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

/* Hands over a scene, the worker's from now on, with the number of its edit. It replaces one that has not begun. The
 * picture under way is cancelled, unless it is of few pixels: while edits come faster than pictures, those are all that
 * is seen. One that takes long is cancelled too, if the one before it was not. */
void cli_view_worker_submit(cli_view_worker *worker, neph_scene *scene, unsigned long long generation);

/* Has new variants rendered. */
void cli_view_worker_awake(cli_view_worker *worker);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Finished tiles on their way to the caller: threads of the pool mark them, the calling thread hands them over. */
#ifndef NP_FRAME_TILE_FEED_H
#define NP_FRAME_TILE_FEED_H

#include <stdatomic.h>

#include <nephos/render.h>

struct np_kept_film;

typedef struct np_tile_feed {
  neph_tile_fn fn; /* NULL: nobody listens */
  void *user;
  neph_context *context;
  const neph_image *image; /* while tiles of it are under way, else NULL */
  unsigned edge;           /* of a tile in pixels */
  unsigned pass_index;
  bool is_final;
  struct np_kept_film *film;                               /* NULL: none is kept */
  void (*keep)(struct np_kept_film *film, double seconds); /* called before tiles are delivered; NULL: no film */
  atomic_bool *are_done; /* of the pass; row by row; true from when a tile is finished to when it is handed over */
} np_tile_feed;

/* Begins the passes over an image, by tiles of `edge` pixels. Does nothing where nobody listens. */
neph_result np_tile_feed_open(np_tile_feed *feed, neph_context *context, const neph_image *image, unsigned edge);

/* From any thread: a tile of the pass is in the image. */
void np_tile_feed_mark(np_tile_feed *feed, size_t tile);

/* On the calling thread, `seconds` after the call's start: hands over what is marked, neighbours in a row as one.
 * False: the caller wants no more. */
bool np_tile_feed_deliver(np_tile_feed *feed, double seconds);

void np_tile_feed_close(np_tile_feed *feed);

#endif

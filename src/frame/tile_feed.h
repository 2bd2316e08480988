/* SPDX-License-Identifier: Apache-2.0 */
/* Queue of finished tiles: threads of the pool mark tiles, the calling thread passes them to the callback. */
#ifndef NP_FRAME_TILE_FEED_H
#define NP_FRAME_TILE_FEED_H

#include <stdatomic.h>

#include <nephos/render.h>

struct np_kept_film;

typedef struct np_tile_feed {
  neph_tile_fn fn; /* NULL: there is no callback */
  void *user;
  neph_context *context;
  const neph_image *image; /* image whose tiles are in progress; else NULL */
  unsigned edge;           /* edge of a tile in pixels */
  unsigned pass_index;
  bool is_final;
  struct np_kept_film *film;                               /* NULL: none is kept */
  void (*keep)(struct np_kept_film *film, double seconds); /* called before tiles are delivered; NULL: no film */
  atomic_bool *are_done; /* finished tiles of the pass that are not delivered yet, row by row */
} np_tile_feed;

/* Begins the passes over an image, by tiles of `edge` pixels. Does nothing without a callback. */
neph_result np_tile_feed_open(np_tile_feed *feed, neph_context *context, const neph_image *image, unsigned edge);

/* Marks a tile of the pass that is in the image; any thread may call it. */
void np_tile_feed_mark(np_tile_feed *feed, size_t tile);

/* Delivers marked tiles on the calling thread, `seconds` after the call's start, neighbours in a row as one. False: the
 * caller has cancelled the picture. */
bool np_tile_feed_deliver(np_tile_feed *feed, double seconds);

void np_tile_feed_close(np_tile_feed *feed);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
#include "frame/tile_feed.h"

#include "core/alloc.h"

static unsigned count_along(unsigned pixels, unsigned edge) { return (pixels + edge - 1) / edge; }

neph_result np_tile_feed_open(np_tile_feed *feed, neph_context *context, const neph_image *image, unsigned edge) {
  if (!feed->fn) return NEPH_OK;
  const size_t across = count_along(neph_image_get_width(image), edge);
  feed->are_done = np_alloc(context, across * count_along(neph_image_get_height(image), edge), sizeof *feed->are_done);
  if (!feed->are_done) return NEPH_ERROR_OUT_OF_MEMORY;
  feed->context = context;
  feed->image = image;
  feed->edge = edge;
  return NEPH_OK;
}

void np_tile_feed_mark(np_tile_feed *feed, size_t tile) {
  if (feed->image) atomic_store_explicit(&feed->are_done[tile], true, memory_order_release);
}

static bool take(np_tile_feed *feed, size_t tile) {
  return atomic_exchange_explicit(&feed->are_done[tile], false, memory_order_acquire);
}

static unsigned min(unsigned a, unsigned b) { return a < b ? a : b; }

/* Tiles [begin, end) of a row. */
static bool deliver_run(const np_tile_feed *feed, unsigned row, unsigned begin, unsigned end) {
  const unsigned width = neph_image_get_width(feed->image), height = neph_image_get_height(feed->image);
  const neph_tile tile = {.min = {begin * feed->edge, row * feed->edge},
                          .max = {min(end * feed->edge, width), min((row + 1) * feed->edge, height)},
                          .pass_index = feed->pass_index,
                          .is_final = feed->is_final,
                          .image = feed->image};
  return feed->fn(feed->user, &tile);
}

bool np_tile_feed_deliver(np_tile_feed *feed, double seconds) {
  if (feed->keep) feed->keep(feed->film, seconds);
  if (!feed->image) return true;
  const unsigned across = count_along(neph_image_get_width(feed->image), feed->edge);
  const unsigned down = count_along(neph_image_get_height(feed->image), feed->edge);
  for (unsigned row = 0; row < down; row++)
    for (unsigned column = 0; column < across; column++) {
      const unsigned begin = column;
      while (column < across && take(feed, (size_t)row * across + column)) column++;
      if (column > begin && !deliver_run(feed, row, begin, column)) return false;
    }
  return true;
}

void np_tile_feed_close(np_tile_feed *feed) {
  np_alloc_free(feed->context, feed->are_done);
  feed->are_done = NULL;
  feed->image = NULL;
}

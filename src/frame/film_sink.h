/* SPDX-License-Identifier: Apache-2.0 */
/* Film of a frame that is kept beside its image, for a part of a picture or a checkpoint. The render job names the
 * functions; a frame calls them, and links to none of their files. */
#ifndef NP_FRAME_FILM_SINK_H
#define NP_FRAME_FILM_SINK_H

#include "image/film.h"
#include "plan/plan_parts.h"

struct np_frame;
struct np_tile_total;

/* The film of one frame: a record for each pixel. */
typedef struct np_kept_film np_kept_film;

typedef struct np_film_sink {
  /* Begins the records of a frame whose image has its header, and loads the records of a matching checkpoint. NULL with
   * NEPH_OK: the plan stores no film. */
  neph_result (*open)(const neph_scene *scene, const np_plan *plan, const struct np_frame *f, np_kept_film **out_film);

  /* The record of a pixel, by its place in the image. */
  double *(*get_record)(const np_kept_film *film, size_t index);

  /* Whether a pixel is rendered, by its place in the image. */
  bool (*has)(const np_kept_film *film, size_t index);

  /* Fills a pixel from its record; false where it is not rendered yet. */
  bool (*develop)(const np_kept_film *film, const struct np_frame *f, size_t index, struct np_tile_total *total);

  /* Fills a record of a pixel that has been sampled: its numbers, and the distance and depth of its centre's ray. */
  void (*keep_numbers)(const np_kept_film *film, double *record, const np_film_accumulator *accumulator,
                       const double *numbers, uint32_t count);
  void (*keep_depths)(double *record, double distance, double depth);

  /* Marks a tile's records as complete. Thread-safe. */
  void (*mark)(np_kept_film *film, size_t tile);

  /* Writes a checkpoint when one is due; the calling thread does so. `seconds` of the call have passed. */
  void (*write_when_due)(np_kept_film *film, double seconds);

  /* Writes the part where all went well, a checkpoint where the frame was cancelled, and frees the film, which may be
   * NULL. Returns `result`, or the failure of writing. */
  neph_result (*finish)(np_kept_film *film, neph_result result);
} np_film_sink;

#endif

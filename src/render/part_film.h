/* SPDX-License-Identifier: Apache-2.0 */
/* The records of a frame in the making, kept for the file of a part or of a checkpoint. A checkpoint is the part as far
 * as it is done, tile by tile. */
#ifndef NP_RENDER_PART_FILM_H
#define NP_RENDER_PART_FILM_H

#include "image/film.h"
#include "render/frame_state.h"

typedef struct np_part_film np_part_film;

/* Begins the records of a frame whose image has its header, and takes over what a checkpoint of the same picture has.
 * NULL, and NEPH_OK, where the plan wants none. */
neph_result np_part_film_open(const neph_scene *scene, const np_plan *plan, const np_frame *f, np_part_film **out_film);
void np_part_film_close(np_part_film *film); /* NULL is allowed */

/* The record of a pixel, by its place in the image; a count of 0 is one that is not rendered yet. */
double *np_part_film_get_record(const np_part_film *film, size_t index);

/* Whether a pixel is rendered, by its place in the image. */
bool np_part_film_has(const np_part_film *film, size_t index);

/* Fills a pixel from its record; false where it is not rendered yet. */
bool np_part_film_develop(const np_part_film *film, const np_frame *f, size_t index, np_tile_total *total);

/* Fills a record of a pixel that has been sampled. */
void np_part_film_keep(const np_part_film *film, double *record, const np_film_accumulator *accumulator,
                       const double *numbers, uint32_t count);

/* From any thread: the records of a tile are there. */
void np_part_film_mark(np_part_film *film, size_t tile);

/* On the calling thread: writes a checkpoint when one is due. `seconds` of the call have passed. */
void np_part_film_write_when_due(np_part_film *film, double seconds);

/* At the end: the part where all went well, a checkpoint where the frame was cancelled. */
neph_result np_part_film_finish(np_part_film *film, neph_result result);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* Part of a picture: some of its pixels, and of their samples a range, as sums that finish to the bits of the whole.
 *
 * Of each pixel a part keeps a record: number of samples, distance, depth, and the numbers of the film
 * (np_channels_count_numbers) for each maximal node of its range (image/film.h), or once, where it has all samples.
 */
#ifndef NP_PARTS_PART_HEADER_H
#define NP_PARTS_PART_HEADER_H

#include "frame/channels.h"
#include "image/film.h"
#include "image/image_private.h"

enum { NP_PART_RECORD_COUNT, NP_PART_RECORD_DISTANCE, NP_PART_RECORD_DEPTH, NP_PART_RECORD_NUMBERS };

typedef struct np_part_header {
  char version[32];       /* version of nephos */
  char hash[33];          /* hash of the whole picture (scene_hash.h) */
  int32_t min[2], max[2]; /* pixels; max is one past the last */
  int32_t whole_min[2], whole_max[2];
  int32_t display_min[2], display_max[2];          /* display window of the picture, without overscan */
  uint32_t tile_index, tile_count;                 /* number from 0; count 1: all of the picture */
  uint32_t sample_begin, sample_end, sample_count; /* samples of the part; count of the whole */
  uint32_t is_complete;                            /* records have all samples of a pixel in one set of numbers */
  uint32_t pixel_type;                             /* pixel type of the file that the picture is for */
  uint32_t scattering_max;
  double target_error, dim[NP_BAND_COUNT], lost_share; /* members of np_frame */
  np_channels channels;                                /* channels that finish a pixel */
  const neph_image *image;                             /* its channels' names and header */
} np_part_header;

/* Doubles of a record. */
unsigned np_part_header_count_reals(const np_part_header *header);

/* An accumulator for a pixel's numbers, from the part's first sample on. */
void np_part_record_begin(const np_part_header *header, np_film_accumulator *accumulator);

/* Adds the nodes of a record to a pixel's sums; false if they do not continue the samples so far. */
bool np_part_record_add(const np_part_header *header, const double *record, np_film_accumulator *accumulator);

/* Name of the first field in which two parts are not of one picture, whatever their tiles and ranges of samples; NULL:
 * there is none. */
const char *np_part_header_compare(const np_part_header *a, const np_part_header *b);

/* Sets the display window from an image. */
void np_part_header_set_display(np_part_header *header, const np_image_header *image);

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* One part of a picture to be merged: the file of a part, or the OpenEXR file of a tile.
 *
 * The room of parts stands above frame, whose film sink it implements (part_film.h), so that tiles, ranges of samples
 * and checkpoints are kept while a frame is rendered. It defines their files (part_file.h), merges them (merge.c) and
 * says whether a file is finished (render_done.c). It calls frame, plan and image; render alone calls it.
 */
#ifndef NP_PARTS_MERGE_STATE_H
#define NP_PARTS_MERGE_STATE_H

#include "frame/frame_state.h"
#include "parts/part_file.h"

typedef struct np_merge_part {
  neph_context *context;
  const char *path;      /* borrowed */
  np_part_file *file;    /* NULL: */
  neph_image *tile;      /* finished pixels */
  np_part_header header; /* all that the file states; less for a tile's picture */
  np_part_grid grid;
  double *rows; /* records of one row of tiles of a file */
  int row;      /* index of the row in `records`; -1: none yet */
} np_merge_part;

#endif

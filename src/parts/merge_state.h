/* SPDX-License-Identifier: Apache-2.0 */
/* One part of a picture to be merged: the file of a part, or the OpenEXR file of a tile.
 *
 * The module stands above render, which writes parts while it renders and defines their files (render/part_file.h);
 * nothing of the library calls it. Entry point: merge.c (nephos/parts.h).
 */
#ifndef NP_PARTS_MERGE_STATE_H
#define NP_PARTS_MERGE_STATE_H

#include "render/frame_state.h"
#include "render/part_file.h"

typedef struct np_merge_part {
  neph_context *context;
  const char *path;      /* borrowed */
  np_part_file *file;    /* NULL: */
  neph_image *tile;      /* finished pixels */
  np_part_header header; /* all that the file states; less for a tile's picture */
  np_part_grid grid;
  double *rows; /* records of one row of tiles of a file */
  int row;      /* number of that row; -1: none yet */
} np_merge_part;

#endif

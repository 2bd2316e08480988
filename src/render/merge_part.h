/* SPDX-License-Identifier: Apache-2.0 */
/* One part of a picture to be merged: the file of a part, or the OpenEXR file of a tile. */
#ifndef NP_RENDER_MERGE_PART_H
#define NP_RENDER_MERGE_PART_H

#include "render/frame_state.h"
#include "render/part_file.h"

typedef struct np_merge_part {
  neph_context *context;
  const char *path;      /* borrowed */
  np_part_file *file;    /* NULL: */
  neph_image *tile;      /* finished pixels */
  np_part_header header; /* of a tile: as far as its picture tells */
  np_part_grid grid;
  double *rows; /* records of one row of tiles of a file */
  int row;      /* number of that row; -1: none yet */
} np_merge_part;

/* Opens a part; refuses one that is not finished, or was cut by a time limit. */
neph_result np_merge_part_open(neph_context *context, const char *path, np_merge_part *out_part);
void np_merge_part_close(np_merge_part *part);

/* NEPH_ERROR_INVALID_ARGUMENT, with a message that says why, where two are not of the same picture. */
neph_result np_merge_part_compare(const np_merge_part *part, const np_merge_part *first);

/* Makes the records of the picture's row `y` available. */
neph_result np_merge_part_load_row(np_merge_part *part, int y);

/* The record of a pixel of that row. */
const double *np_merge_part_get_record(const np_merge_part *part, int x, int y);

#endif

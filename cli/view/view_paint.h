/* SPDX-License-Identifier: Apache-2.0 */
/* The map of a cloud's coverage under the brush. Its file lies beside the scene, under a name that is free; maps that
 * the scene had before are read and never written. */
#ifndef NEPHOS_CLI_VIEW_PAINT_H
#define NEPHOS_CLI_VIEW_PAINT_H

#include "view_document.h"
#include "view_map.h"

typedef struct cli_view_paint {
  cli_view_document *document; /* borrowed */
  neph_context *context;       /* borrowed */
  cli_view_map *map;           /* NULL: none yet */
} cli_view_paint;

void cli_view_paint_clear(cli_view_paint *paint);

/* Each returns a status as the functions of a document do. Paints the dabs of `lines`, each "X Y RADIUS STRENGTH
 * COVERAGE", on a cloud's map. Dabs of one stroke, a number above 0, are taken back together. */
unsigned cli_view_paint_dabs(cli_view_paint *paint, unsigned cloud, char *lines, unsigned long long stroke);

/* Swaps a cloud's map with that before the last stroke. */
unsigned cli_view_paint_swap(cli_view_paint *paint, unsigned cloud);

/* Writes a cloud's map as it is, a byte a pixel. */
unsigned cli_view_paint_write_pixels(cli_view_paint *paint, unsigned cloud, FILE *out);

#endif

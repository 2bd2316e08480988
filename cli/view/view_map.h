/* SPDX-License-Identifier: Apache-2.0 */
/* Coverage of a cloud's field, seen from above and painted by a brush: a 16-bit PNG of one channel. */
#ifndef NEPHOS_CLI_VIEW_MAP_H
#define NEPHOS_CLI_VIEW_MAP_H

#include <stdio.h>

#include <nephos/nephos.h>

enum { CLI_VIEW_MAP_EDGE = 256 }; /* pixels a side */

typedef struct cli_view_map {
  char *path;                                          /* its file; NULL: it has none yet */
  float at[CLI_VIEW_MAP_EDGE * CLI_VIEW_MAP_EDGE];     /* coverage, 0 to 1, rows from the north */
  float before[CLI_VIEW_MAP_EDGE * CLI_VIEW_MAP_EDGE]; /* the same before the last stroke */
  unsigned long long stroke;                           /* number of the last stroke; 0: none */
} cli_view_map;

/* A dab of the brush, in shares of the map's edge from its north-western corner. */
typedef struct cli_view_dab {
  double x, y, radius;
  double strength; /* share of the way to `coverage` in the dab's middle, 0 to 1 */
  double coverage;
} cli_view_dab;

void cli_view_map_clear(cli_view_map *map);

/* Makes the map even, or that of a grey picture. */
void cli_view_map_fill(cli_view_map *map, double coverage);
neph_result cli_view_map_load(cli_view_map *map, neph_context *context, const char *path);

/* Paints a dab. The first of another stroke, a number above 0, keeps the map as it was before. */
void cli_view_map_paint(cli_view_map *map, const cli_view_dab *dab, unsigned long long stroke);

/* Swaps the map with that before the last stroke. */
void cli_view_map_swap(cli_view_map *map);

/* Writes the map to its file, replaced when all of it is there; false: it cannot be written. */
bool cli_view_map_save(const cli_view_map *map);

/* Writes a byte a pixel, rows from the north. */
void cli_view_map_write_pixels(const cli_view_map *map, FILE *out);

#endif

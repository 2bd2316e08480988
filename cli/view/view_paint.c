/* SPDX-License-Identifier: Apache-2.0 */
#include "view_paint.h"

#include <stdlib.h>
#include <string.h>

#include "view_keys.h"

void cli_view_paint_clear(cli_view_paint *paint) {
  if (paint->map) cli_view_map_clear(paint->map);
  free(paint->map);
  paint->map = NULL;
}

/* Whether the map under the brush is the scene's. */
static bool is_current(const cli_view_paint *paint, const char *path) {
  return paint->map && paint->map->path && path && cli_view_is_same_name(paint->map->path, path);
}

/* Fills the map by the cloud's own: of its picture, or even. */
static unsigned fill(cli_view_paint *paint, unsigned cloud, const char *path) {
  cli_view_paint_clear(paint);
  paint->map = calloc(1, sizeof *paint->map);
  if (!paint->map) return cli_view_document_refuse(paint->document, 500, "out of memory");
  const neph_result result = path ? cli_view_map_load(paint->map, paint->context, path) : NEPH_OK;
  if (!path) cli_view_map_fill(paint->map, cli_view_document_get_coverage(paint->document, cloud));
  if (!result) return 200;
  cli_view_paint_clear(paint);
  return cli_view_document_refuse(paint->document, 422, "the map of this cloud is no PNG that can be painted on");
}

/* Has the cloud's map under the brush. */
static unsigned take_map(cli_view_paint *paint, unsigned cloud) {
  char *path = NULL;
  unsigned status = cli_view_document_get_map(paint->document, cloud, &path);
  if (status == 200 && !is_current(paint, path)) status = fill(paint, cloud, path);
  free(path);
  return status;
}

/* Saves the map, under a name of its own, which becomes the cloud's. */
static unsigned keep(cli_view_paint *paint, unsigned cloud) {
  cli_view_map *map = paint->map;
  unsigned status = 200;
  if (!map->path) {
    cli_text name = {0};
    status = cli_view_document_choose_name(paint->document, ".png", &name);
    if (status == 200 && !(map->path = strdup(cli_text_get(&name)))) status = 500;
    cli_text_clear(&name);
  }
  if (status == 200 && !cli_view_map_save(map))
    status = cli_view_document_refuse(paint->document, 422, "the map cannot be written beside the scene");
  return status == 200 ? cli_view_document_set_map(paint->document, cloud, map->path) : status;
}

unsigned cli_view_paint_dabs(cli_view_paint *paint, unsigned cloud, char *lines, unsigned long long stroke) {
  unsigned status = take_map(paint, cloud);
  char *rest = NULL;
  for (char *line = strtok_r(lines, "\n", &rest); line && status == 200; line = strtok_r(NULL, "\n", &rest)) {
    double numbers[5];
    if (!cli_view_read_numbers(line, 5, numbers))
      return cli_view_document_refuse(paint->document, 400, "a dab must be five numbers");
    const cli_view_dab dab = {numbers[0], numbers[1], numbers[2], numbers[3], numbers[4]};
    cli_view_map_paint(paint->map, &dab, stroke);
  }
  return status == 200 ? keep(paint, cloud) : status;
}

unsigned cli_view_paint_swap(cli_view_paint *paint, unsigned cloud) {
  const unsigned status = take_map(paint, cloud);
  if (status != 200) return status;
  cli_view_map_swap(paint->map);
  return keep(paint, cloud);
}

unsigned cli_view_paint_write_pixels(cli_view_paint *paint, unsigned cloud, FILE *out) {
  const unsigned status = take_map(paint, cloud);
  if (status == 200) cli_view_map_write_pixels(paint->map, out);
  return status;
}

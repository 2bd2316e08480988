/* SPDX-License-Identifier: Apache-2.0 */
#include "view_past.h"

#include <stdlib.h>
#include <string.h>

#include "print.h"
#include "view_keys.h"

static const size_t bytes_max = (size_t)256 << 20;

/* ---- Pictures ---- */

static size_t count_bytes(const neph_image *image) {
  return (size_t)neph_image_get_width(image) * neph_image_get_height(image) * neph_image_get_channel_count(image) *
         sizeof(float);
}

/* Closes the gap at an index, whose picture is no longer the list's. */
static void close_gap(cli_view_past *past, size_t index) {
  past->count--;
  memmove(&past->list[index], &past->list[index + 1], (past->count - index) * sizeof *past->list);
}

static void drop(cli_view_past *past, size_t index) {
  free(past->list[index].key);
  neph_image_destroy(past->list[index].image);
  close_gap(past, index);
}

/* Index of a key; the count: it is not in the list. */
static size_t search(const cli_view_past *past, const char *key) {
  size_t index = 0;
  while (index < past->count && strcmp(past->list[index].key, key)) index++;
  return index;
}

/* Drops the oldest pictures beyond the memory. */
static void limit(cli_view_past *past) {
  size_t bytes = 0, kept = 0;
  while (kept < past->count && (bytes += count_bytes(past->list[kept].image)) <= bytes_max) kept++;
  while (past->count > kept) drop(past, past->count - 1);
}

void cli_view_past_put(cli_view_past *past, char *key, const cli_view_step *step, neph_image *image) {
  const size_t same = search(past, key);
  if (same < past->count)
    drop(past, same);
  else if (past->count == CLI_VIEW_PAST_MAX)
    drop(past, past->count - 1);
  memmove(&past->list[1], &past->list[0], past->count * sizeof *past->list);
  past->count++;
  past->list[0].key = key;
  past->list[0].step = *step;
  past->list[0].image = image;
  limit(past);
}

neph_image *cli_view_past_take(cli_view_past *past, const char *key, cli_view_step *out_step) {
  const size_t index = search(past, key);
  if (index == past->count) return NULL;
  neph_image *image = past->list[index].image;
  *out_step = past->list[index].step;
  free(past->list[index].key);
  close_gap(past, index);
  return image;
}

void cli_view_past_clear(cli_view_past *past) {
  while (past->count) drop(past, past->count - 1);
}

/* ---- Keys ---- */

/* Whether a line of the description, KEY: VALUE, is of exposure or view. */
static bool is_display(const char *schema, const char *line) {
  static const char section[] = "output.";
  if (strncmp(line, section, strlen(section))) return false;
  char *key = strndup(line, strcspn(line, ":"));
  const bool is_display = key && cli_view_key_get_cost(schema, key) == CLI_VIEW_COST_DISPLAY;
  free(key);
  return is_display;
}

/* Adds the values that pixels depend on. */
static void add_values(cli_text *text, const char *schema, const char *described) {
  for (const char *line = described; *line;) {
    const size_t length = strcspn(line, "\n");
    if (!is_display(schema, line)) cli_text_add(text, "%.*s\n", (int)length, line);
    line += length + (line[length] == '\n');
  }
}

char *cli_view_past_create_key(neph_context *context, const char *schema, const neph_scene *scene, int frame,
                               unsigned long long files) {
  char *described = NULL, *tracks = NULL;
  cli_text text = {0};
  neph_result result = neph_scene_describe(scene, NEPH_TEXT_PLAIN, &described);
  /* A description has values of one frame, while blur and light depend on others: tracks are in the scene's text. */
  if (!result && neph_scene_is_animated(scene)) result = neph_scene_get_text(scene, &tracks);
  cli_text_add(&text, "frame %d, files %llu\n%s", frame, files, tracks ? tracks : "");
  if (!result) add_values(&text, schema, described);
  if (result || text.has_failed) cli_text_clear(&text);
  neph_text_destroy(context, described);
  neph_text_destroy(context, tracks);
  return text.characters;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* A scene, edited, and written back into its text, which then reads as the scene. An input is the text of the scene,
 * then, behind a line of "====", edits, one a line: "KEY=VALUE" sets, "-KEY" takes away, "+KEY=VALUE" inserts. */
#include "fuzz_support.h"

#include <stdlib.h>
#include <string.h>

#include <nephos/scene.h>

static const char separator[] = "\n====\n";

static void edit(neph_scene *scene, char *line) {
  char *equals = strchr(line, '=');
  const bool is_removal = *line == '-', is_insertion = *line == '+';
  if (is_removal) {
    fuzz_expect(neph_scene_unset(scene, line + 1));
  } else if (equals) {
    *equals = '\0';
    fuzz_expect(is_insertion ? neph_scene_insert(scene, line + 1, equals + 1)
                             : neph_scene_set(scene, line, equals + 1));
  }
}

static void edit_all(neph_scene *scene, char *edits) {
  for (char *next; edits; edits = next) {
    next = strchr(edits, '\n');
    if (next) *next++ = '\0';
    edit(scene, edits);
  }
}

/* Texts are the same, or the process ends. */
static void expect_same(neph_context *context, char *a, char *b) {
  if (!a || !b || strcmp(a, b) != 0) abort();
  neph_text_destroy(context, a);
  neph_text_destroy(context, b);
}

/* Reads the text back where the scene can be read at all. */
static void read_back(neph_context *context, const neph_scene *scene, const char *text) {
  neph_scene *read;
  char *expected, *described;
  const neph_result result = neph_scene_check(scene);
  fuzz_expect(result);
  if (result) return;
  fuzz_expect(neph_scene_load_text(context, text, "fuzz.yaml", &read));
  if (!read) abort();
  fuzz_expect(neph_scene_describe(scene, NEPH_TEXT_PLAIN, &expected));
  fuzz_expect(neph_scene_describe(read, NEPH_TEXT_PLAIN, &described));
  expect_same(context, expected, described);
  neph_scene_destroy(read);
}

static void write_back(neph_context *context, neph_scene *scene, char *edits) {
  char *text, *listed;
  edit_all(scene, edits);
  const neph_result result = neph_scene_get_text(scene, &text);
  fuzz_expect(result);
  if (!result) read_back(context, scene, text);
  neph_text_destroy(context, text);
  fuzz_expect(neph_scene_describe_edits(scene, NEPH_TEXT_PLAIN, &listed));
  neph_text_destroy(context, listed);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  neph_context *context = fuzz_get_context();
  neph_scene *scene;
  char *text = malloc(size + 1);
  if (!text) return 0;
  memcpy(text, data, size);
  text[size] = '\0';
  char *edits = strstr(text, separator);
  if (edits) *edits = '\0', edits += strlen(separator);
  const neph_result result = neph_scene_load_text(context, text, "fuzz.yaml", &scene);
  fuzz_expect(result);
  if (!result) write_back(context, scene, edits);
  neph_scene_destroy(scene);
  free(text);
  return 0;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* The text of a scene: read, checked, and written out with its defaults. */
#include "fuzz_support.h"

#include <stdlib.h>
#include <string.h>

#include <nephos/scene.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  neph_context *context = fuzz_get_context();
  neph_scene *scene;
  char *text = malloc(size + 1), *described;
  if (!text) return 0;
  memcpy(text, data, size);
  text[size] = 0;
  const neph_result result = neph_scene_load_text(context, text, "fuzz.yaml", &scene);
  fuzz_expect(result);
  if (!result) {
    fuzz_expect(neph_scene_describe(scene, NEPH_TEXT_JSON, &described));
    neph_text_destroy(context, described);
  }
  neph_scene_destroy(scene);
  free(text);
  return 0;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* A camera's file, of the format that the first byte chooses: its scene, in two frames. */
#include "fuzz_support.h"

#include <nephos/scene.h>
#include <stdio.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static const char *const names[] = {"shot.chan", "shot.csv", "shot.gltf", "shot.glb"};
  if (size == 0) return 0;
  const char *path = fuzz_write_file(names[data[0] % (sizeof names / sizeof *names)], data + 1, size - 1);
  char text[256];
  snprintf(text, sizeof text, "frame_rate: 24\nenvironment: {radiance: 1}\ncamera: {motion: {file: %s}}\n", path);
  neph_scene *scene;
  const neph_result result = neph_scene_load_text(fuzz_get_context(), text, "fuzz.yaml", &scene);
  fuzz_expect(result);
  for (int frame = 1; !result && frame <= 2; frame++) fuzz_expect(neph_scene_set_frame(scene, frame));
  neph_scene_destroy(scene);
  return 0;
}

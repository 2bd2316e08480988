/* SPDX-License-Identifier: Apache-2.0 */
/* Renders a scene with one thread at x86-64-v3, for Callgrind to count its stages (instructions.sh). */
#include <stdio.h>

#include <nephos/nephos.h>
#include <valgrind/callgrind.h>

int main(int count, char **words) {
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  neph_context *context;
  neph_scene *scene;
  neph_image *image;
  desc.thread_count = 1;
  desc.isa_max = NEPH_ISA_X86_64_V3;
  desc.log_level_max = NEPH_LOG_ERROR;
  if (count != 2 || neph_context_create(&desc, &context)) {
    fputs("usage: bench_stages SCENE.yaml\n", stderr);
    return 1;
  }
  if (neph_scene_load(context, words[1], &scene) || neph_render_image(scene, NULL, &image)) return 1;
  CALLGRIND_DUMP_STATS_AT("end");
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
  return 0;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* A program against the library: reads a scene, renders it, writes the picture.
 *
 *     cc render_scene.c $(pkg-config --cflags --libs nephos) -o render_scene && ./render_scene scene.yaml picture.exr
 */
#include <stdio.h>

#include <nephos/nephos.h>

static void print_message(void *user, neph_log_level level, const char *message) {
  (void)user;
  fprintf(stderr, "%s%s\n", level == NEPH_LOG_ERROR ? "error: " : "", message);
}

static neph_result render_file(const neph_context_desc *desc, const char *scene_path, const char *image_path) {
  neph_context *context = NULL;
  neph_scene *scene = NULL;
  neph_image *image = NULL;

  neph_result result = neph_context_create(desc, &context);
  if (!result) result = neph_scene_load(context, scene_path, &scene);
  if (!result) result = neph_render_image(scene, NULL, &image);
  if (!result) result = neph_image_save_exr(image, image_path, NEPH_PIXEL_HALF);

  neph_image_destroy(image);
  neph_scene_destroy(scene);
  neph_context_destroy(context);
  return result;
}

int main(int argc, char **argv) {
  if (argc != 3) {
    fprintf(stderr, "usage: %s SCENE.yaml PICTURE.exr\n", argv[0]);
    return 2;
  }
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  desc.log = print_message;
  return render_file(&desc, argv[1], argv[2]) ? 1 : 0;
}

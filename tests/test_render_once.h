/* SPDX-License-Identifier: Apache-2.0 */
/* A whole render of a small scene, for the tests that fail each of its allocations in turn. */
#ifndef NP_TEST_RENDER_ONCE_H
#define NP_TEST_RENDER_ONCE_H

#include <nephos/nephos.h>

/* `user` is the scene's text; the picture is thrown away. */
static inline neph_result test_render_once(neph_context *context, void *user) {
  neph_scene *scene = NULL;
  neph_image *image = NULL;
  neph_result result = neph_scene_load_text(context, user, "test.yaml", &scene);
  if (!result) result = neph_render_image(scene, NULL, &image);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
  return result;
}

#endif

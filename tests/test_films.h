/* SPDX-License-Identifier: Apache-2.0 */
/* A scene with the renderer of its frames, which keeps from one to the next. */
#ifndef NP_TEST_FILMS_H
#define NP_TEST_FILMS_H

#include "test_support.h"

#include <nephos/renderer.h>

typedef struct test_film {
  neph_scene *scene;
  neph_renderer *renderer;
} test_film;

static inline test_film film_load(neph_context *context, const char *text, const char *name) {
  test_film out;
  assert_int_equal(neph_scene_load_text(context, text, name, &out.scene), NEPH_OK);
  assert_int_equal(neph_renderer_create(context, &out.renderer), NEPH_OK);
  return out;
}

static inline void film_destroy(test_film film) {
  neph_renderer_destroy(film.renderer);
  neph_scene_destroy(film.scene);
}

static inline neph_result film_render(test_film film, int frame, neph_image **out_image) {
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  assert_int_equal(neph_scene_get_render_desc(film.scene, &desc), NEPH_OK);
  desc.frame = frame;
  return neph_renderer_render(film.renderer, film.scene, &desc, out_image);
}

#endif

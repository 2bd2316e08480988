/* SPDX-License-Identifier: Apache-2.0 */
/* A scene whose keys a test changes, with a log of what that does. */
#ifndef NP_TEST_SCENES_H
#define NP_TEST_SCENES_H

#include <stdlib.h>

#include "test_contexts.h"

#include <nephos/renderer.h>
#include <nephos/scene.h>

typedef struct fixture {
  test_log log;
  neph_context *context;
  neph_scene *scene;
  neph_renderer *renderer; /* renderer for a sequence of the scene */
} fixture;

static inline int set_up_scene_with(void **state, unsigned thread_count, const char *text,
                                    neph_context *(*create_context)(unsigned, test_log *)) {
  fixture *f = calloc(1, sizeof *f);
  assert_non_null(f);
  test_log_start(&f->log);
  f->context = create_context(thread_count, &f->log);
  assert_int_equal(neph_scene_load_text(f->context, text, "dir/scene.yaml", &f->scene), NEPH_OK);
  assert_int_equal(neph_renderer_create(f->context, &f->renderer), NEPH_OK);
  *state = f;
  return 0;
}

/* Called by a test's set-up; the scene is `text` as the file dir/scene.yaml would hold it. */
static inline int set_up_scene(void **state, unsigned thread_count, const char *text) {
  return set_up_scene_with(state, thread_count, text, test_context_create);
}

/* The same with a context of test_context_create_verbose. */
static inline int set_up_scene_verbose(void **state, unsigned thread_count, const char *text) {
  return set_up_scene_with(state, thread_count, text, test_context_create_verbose);
}

/* The same with a context of test_context_create_cached. */
static inline int set_up_scene_cached(void **state, unsigned thread_count, const char *text) {
  return set_up_scene_with(state, thread_count, text, test_context_create_cached);
}

static inline int tear_down(void **state) {
  fixture *f = *state;
  neph_renderer_destroy(f->renderer);
  neph_scene_destroy(f->scene);
  neph_context_destroy(f->context);
  free(f);
  return 0;
}

static inline void set(fixture *f, const char *key, const char *value) {
  if (neph_scene_set(f->scene, key, value)) fail_msg("%s = %s: %s", key, value, f->log.text);
}

/* Renders the next frame of a sequence, one key changed; the log holds what that said alone. */
static inline void render_changed(fixture *f, const char *key, const char *value) {
  neph_image *image;
  test_log_clear(&f->log);
  set(f, key, value);
  assert_int_equal(neph_renderer_render(f->renderer, f->scene, NULL, &image), NEPH_OK);
  neph_image_destroy(image);
}

#endif

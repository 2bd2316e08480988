/* SPDX-License-Identifier: Apache-2.0 */
/* The sample scenes. */
#ifndef NP_TEST_SAMPLES_H
#define NP_TEST_SAMPLES_H

#include <stdlib.h>

#include "test_support.h"

#include <nephos/scene.h>

static const char *const sample_names[] = {
    "above_the_deck", "alps",  "coast",   "cumulus_field", "hero_congestus", "hero_noon", "hero_thunderhead",
    "horizon",        "night", "presets", "shapes",        "sliders",        "sunset"};

enum { SAMPLE_COUNT = sizeof sample_names / sizeof *sample_names };

/* Path of a sample, to be freed. */
static inline char *get_sample_path(unsigned index) {
  char name[64];
  snprintf(name, sizeof name, "%s.yaml", sample_names[index]);
  return test_path(NEPHOS_TEST_SOURCE_DIR "/../samples", name);
}

static inline neph_scene *load_sample(neph_context *context, unsigned index) {
  char *path = get_sample_path(index);
  neph_scene *scene;
  assert_int_equal(neph_scene_load(context, path, &scene), NEPH_OK);
  free(path);
  return scene;
}

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* A small scene of two clouds in the air over hills, for the tests of layers of a comp. */
#ifndef NP_TEST_LAYERS_H
#define NP_TEST_LAYERS_H

#include <nephos/nephos.h>

#include "image/cryptomatte.h"
#include "test_scenes.h"

/* The right cloud stands before the left one; hills below, sky between and above. */
static const char layered_scene[] =
    "version: 1\n"
    "camera: {position: [0 m, -3 km, 500 m], look_at: [0 m, 0 m, 900 m], fov: 50 deg, resolution: [32, 20]}\n"
    "sun: {elevation: 35 deg, azimuth: 120 deg}\n"
    "clouds:\n"
    "  - {name: left, albedo: 1, bake: {preset: cumulus_humilis, seed: 3, extent: [1200 m, 900 m],\n"
    "     center: [-400 m, 600 m], base: 700 m, thickness: 500 m, voxel: 50 m, coverage: 1, extinction: 0.02 1/m}}\n"
    "  - {name: right, bake: {preset: cumulus_humilis, seed: 5, extent: [800 m, 600 m],\n"
    "     center: [300 m, -400 m], base: 600 m, thickness: 300 m, voxel: 50 m, coverage: 1, extinction: 0.03 1/m}}\n"
    "terrain: {ridges: {seed: 1, samples: 65, relief: 600 m}, width: 12 km}\n"
    "render: {samples: 4}\n"
    "output: {pixel_type: float}\n";

static inline int set_up_layers(void **state) { return set_up_scene_cached(state, 2, layered_scene); }

static const char *const integrators[] = {"march", "path"};

/* The layers of output.aovs, and any other key. */
static inline neph_image *render_layers(fixture *f, const char *integrator, const char *aovs) {
  neph_image *image = NULL;
  set(f, "render.integrator", integrator);
  set(f, "output.aovs", aovs);
  if (neph_render_image(f->scene, NULL, &image)) fail_msg("%s", f->log.text);
  return image;
}

static inline size_t count_pixels(const neph_image *image) {
  return (size_t)neph_image_get_width(image) * neph_image_get_height(image);
}

static inline double get_value(const neph_image *image, const char *channel, size_t pixel) {
  const float *values = neph_image_get_values(image, channel);
  if (!values) fail_msg("there is no channel %s", channel);
  return values ? (double)values[pixel] : 0.0;
}

static inline double get_mean(const neph_image *image, const char *channel) {
  double sum = 0.0;
  for (size_t p = 0; p < count_pixels(image); p++) sum += get_value(image, channel, p);
  return sum / (double)count_pixels(image);
}

/* The coverage that a pixel's ranks give an identifier. */
static inline double get_coverage(const neph_image *image, float id, size_t pixel) {
  double sum = 0.0;
  for (unsigned rank = 0; rank < NP_CRYPTOMATTE_RANKS; rank++) {
    char name[2][32];
    for (unsigned k = 0; k < 2; k++) np_cryptomatte_name_channel(2 * rank + k, name[k], sizeof name[k]);
    if ((float)get_value(image, name[0], pixel) == id) sum += get_value(image, name[1], pixel);
  }
  return sum;
}

#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* The tables of one sky and 48 × 27 looks at it: the least program that does what a sky's picture needs. */
#include <math.h>

#include <nephos/nephos.h>

enum { WIDTH = 48, HEIGHT = 27 };

static void fill(const neph_sky *sky, float *pixels) {
  for (int i = 0; i < WIDTH * HEIGHT; i++) {
    const double right = (i % WIDTH - WIDTH / 2) * 0.02, up = 0.3 - (double)i / WIDTH * 0.02;
    const double scale = 1.0 / sqrt(1.0 + right * right + up * up);
    double radiance[3];
    neph_sky_get_radiance(sky, (double[]){right * scale, scale, up * scale}, radiance);
    pixels[i] = (float)(radiance[0] + radiance[1] + radiance[2]);
  }
}

int main(int count, char **words) {
  static const char *const names[] = {"Y"};
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  neph_context *context;
  neph_atmosphere *air;
  neph_image *image;
  neph_sky *sky;
  neph_sky_desc view = NEPH_SKY_DESC_DEFAULT;
  view.observer_m[2] = 900.0;
  view.sun_direction[1] = 0.8;
  view.sun_direction[2] = 0.6;
  desc.thread_count = 1;
  if (count != 2 || neph_context_create(&desc, &context)) return 1;
  if (neph_image_create(context, WIDTH, HEIGHT, 1, names, &image)) return 1;
  if (neph_atmosphere_create(context, NULL, &air) || neph_sky_create(air, &view, &sky)) return 1;
  fill(sky, neph_image_get_channel(image, "Y"));
  const neph_result result = neph_image_save_exr(image, words[1], NEPH_PIXEL_HALF);
  neph_sky_destroy(sky);
  neph_atmosphere_release(air);
  neph_image_destroy(image);
  neph_context_destroy(context);
  return result ? 1 : 0;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* Bricks from a .vdb, and 48 × 27 rays through them: the smallest program that computes a cloud's optical depth. */
#include <nephos/nephos.h>

enum { WIDTH = 48, HEIGHT = 27, STEPS = 64 };

/* Mean density along one ray straight down. */
static float sum_column(const neph_volume *volume, const neph_volume_info *info, int column, int row) {
  double positions[STEPS][3];
  float values[STEPS], sum = 0.0f;
  for (int s = 0; s < STEPS; s++) {
    const double share[3] = {(column + 0.5) / WIDTH, (row + 0.5) / HEIGHT, (s + 0.5) / STEPS};
    for (int a = 0; a < 3; a++)
      positions[s][a] = info->bounds_min_m[a] + share[a] * (info->bounds_max_m[a] - info->bounds_min_m[a]);
  }
  neph_volume_sample(volume, STEPS, positions[0], values);
  for (int s = 0; s < STEPS; s++) sum += values[s] / STEPS;
  return sum;
}

int main(int count, char **words) {
  static const char *const names[] = {"Y"};
  neph_context_desc desc = NEPH_CONTEXT_DESC_DEFAULT;
  neph_volume_info info = NEPH_VOLUME_INFO_DEFAULT;
  neph_context *context;
  neph_volume *volume;
  neph_image *image;
  desc.thread_count = 1;
  if (count != 3 || neph_context_create(&desc, &context)) return 1;
  if (neph_image_create(context, WIDTH, HEIGHT, 1, names, &image)) return 1;
  if (neph_volume_load(context, words[1], NULL, &volume) || neph_volume_get_info(volume, &info)) return 1;
  float *pixels = neph_image_get_channel(image, "Y");
  for (int i = 0; i < WIDTH * HEIGHT; i++) pixels[i] = sum_column(volume, &info, i % WIDTH, i / WIDTH);
  const neph_result result = neph_image_save_exr(image, words[2], NEPH_PIXEL_HALF);
  neph_volume_release(volume);
  neph_image_destroy(image);
  neph_context_destroy(context);
  return result ? 1 : 0;
}

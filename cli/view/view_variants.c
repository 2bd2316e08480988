/* SPDX-License-Identifier: Apache-2.0 */
#include "view_variants.h"

#include <pthread.h>
#include <stdlib.h>

typedef struct variant {
  neph_scene *scene; /* NULL once it is rendered */
  uint8_t *pixels;   /* NULL: none */
  unsigned width, height;
} variant;

struct cli_view_variants {
  pthread_mutex_t lock;
  variant list[CLI_VIEW_VARIANTS_MAX];
  unsigned count, done;
  unsigned long long set, number; /* the set, and all changes */
};

cli_view_variants *cli_view_variants_create(void) {
  cli_view_variants *variants = calloc(1, sizeof *variants);
  if (variants) pthread_mutex_init(&variants->lock, NULL);
  return variants;
}

static void clear(cli_view_variants *variants) {
  for (unsigned i = 0; i < variants->count; i++) {
    neph_scene_destroy(variants->list[i].scene);
    free(variants->list[i].pixels);
    variants->list[i] = (variant){0};
  }
  variants->count = variants->done = 0;
}

void cli_view_variants_destroy(cli_view_variants *variants) {
  if (!variants) return;
  clear(variants);
  pthread_mutex_destroy(&variants->lock);
  free(variants);
}

void cli_view_variants_begin(cli_view_variants *variants, neph_scene *const *scenes, unsigned count) {
  pthread_mutex_lock(&variants->lock);
  clear(variants);
  for (unsigned i = 0; i < count; i++) variants->list[i].scene = scenes[i];
  variants->count = count;
  variants->set++;
  variants->number++;
  pthread_mutex_unlock(&variants->lock);
}

bool cli_view_variants_is_waiting(cli_view_variants *variants) {
  pthread_mutex_lock(&variants->lock);
  const bool is_waiting = variants->done < variants->count;
  pthread_mutex_unlock(&variants->lock);
  return is_waiting;
}

/* Renders a scene, few pixels at one sample. */
static neph_result render_small(neph_renderer *renderer, const neph_scene *scene, int frame, neph_progress_fn progress,
                                void *user, neph_image **out_image) {
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT;
  const neph_result result = neph_scene_get_render_desc(scene, &desc);
  if (result) return result;
  desc.height = (desc.height * CLI_VIEW_VARIANT_WIDTH + desc.width - 1) / desc.width;
  desc.width = CLI_VIEW_VARIANT_WIDTH;
  desc.crop_min[0] = desc.crop_min[1] = 0;
  desc.crop_max[0] = desc.width;
  desc.crop_max[1] = desc.height;
  desc.frame = frame;
  desc.sample_count = 1;
  desc.target_error = desc.time_limit_s = NEPH_UNLIMITED;
  desc.progress = progress;
  desc.progress_user = user;
  return neph_renderer_render(renderer, scene, &desc, out_image);
}

/* Develops a small picture by the scene's own preview. */
static variant develop(const neph_scene *scene, const neph_image *image) {
  neph_output output = NEPH_OUTPUT_DEFAULT;
  const unsigned width = neph_image_get_width(image), height = neph_image_get_height(image);
  variant shown = {.width = width, .height = height, .pixels = malloc(4 * (size_t)width * height)};
  if (shown.pixels && !neph_scene_get_output(scene, &output) &&
      !neph_image_develop(image, &output.preview_desc, 0, 0, width, height, shown.pixels, 4 * (size_t)width))
    return shown;
  free(shown.pixels);
  return (variant){0};
}

void cli_view_variants_render(cli_view_variants *variants, neph_renderer *renderer, int frame,
                              neph_progress_fn progress, void *user) {
  neph_image *image = NULL;
  pthread_mutex_lock(&variants->lock);
  variant *next = variants->done < variants->count ? &variants->list[variants->done] : NULL;
  neph_scene *scene = next ? next->scene : NULL;
  const unsigned long long set = variants->set;
  if (next) next->scene = NULL; /* the thread's own while it is rendered */
  pthread_mutex_unlock(&variants->lock);
  if (!scene) return;
  const neph_result result = render_small(renderer, scene, frame, progress, user, &image);
  pthread_mutex_lock(&variants->lock);
  if (variants->set == set && result == NEPH_ERROR_CANCELLED) {
    next->scene = scene;
    scene = NULL;
  } else if (variants->set == set) {
    *next = result ? (variant){0} : develop(scene, image);
    variants->done++;
    variants->number++;
  }
  pthread_mutex_unlock(&variants->lock);
  neph_image_destroy(image);
  neph_scene_destroy(scene);
}

void cli_view_variants_write_state(cli_view_variants *variants, FILE *out) {
  pthread_mutex_lock(&variants->lock);
  fprintf(out, "\"variants\":%llu,\"variants_left\":%u", variants->number, variants->count - variants->done);
  pthread_mutex_unlock(&variants->lock);
}

void cli_view_variants_write_pixels(cli_view_variants *variants, FILE *out) {
  pthread_mutex_lock(&variants->lock);
  fputs("{\"sizes\":[", out);
  for (unsigned i = 0; i < variants->count; i++)
    fprintf(out, "%s[%u,%u]", i ? "," : "", variants->list[i].width, variants->list[i].height);
  fputs("]}\n", out);
  for (unsigned i = 0; i < variants->count; i++)
    if (variants->list[i].pixels)
      fwrite(variants->list[i].pixels, 4, (size_t)variants->list[i].width * variants->list[i].height, out);
  pthread_mutex_unlock(&variants->lock);
}

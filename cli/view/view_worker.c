/* SPDX-License-Identifier: Apache-2.0 */
#include "view_worker.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "print.h"
#include "view_clock.h"

/* Coarse pictures have a 16th of the pixels, at one sample. While clouds and ground are those of the last full picture,
 * they share these with it, and light that is near their own; else they have a renderer of their own, with clouds and
 * heights half as fine, and octaves in place of the solution of multiple scattering. */
enum { COARSE_DIVISOR = 4, SAMPLES_MAX = 1024 };

/* Samples of the first picture with all pixels, where the scene has twice as many or more: fewer than those of the
 * scene take near light and voxels, and the next picture goes on with them if these are its own. */
enum { FIRST_SAMPLES = 2 };

/* Noise that the eye does not see, a step of 8 bits in a mid grey. */
static const double invisible_noise = 0.005;

/* Time after which few pixels take long, seconds. */
static const double patience_s = 0.7;

struct cli_view_worker {
  pthread_t thread;
  pthread_mutex_t lock; /* held for next…, region, has_region_news, is_ending */
  pthread_cond_t changed;
  cli_view_order next; /* without a scene: none waits */
  double next_start_s;
  double region[4]; /* left, top, right, bottom, as shares of the picture; empty: all of it */
  double focus[2];  /* place whose tiles are rendered first, as shares */
  bool has_region_news;
  bool is_ending;

  /* The thread's own. */
  cli_session *session;
  cli_view_picture *picture;
  cli_view_variants *variants;
  neph_renderer *renderer;        /* renders full pictures, and coarse ones of the same clouds and ground */
  neph_renderer *coarse_renderer; /* renders coarse pictures of other clouds or ground; NULL: none yet */
  neph_renderer *spare;           /* renderer of variants, which would drop what the other keeps; NULL: none waits */
  neph_scene *scene;
  char *key;               /* key of the scene's pictures; NULL: they are not kept */
  cli_view_step step;      /* next step to render, or the current one */
  unsigned long long bake; /* number of the edit whose clouds and ground the step shows */
  unsigned long long full; /* number of the last edit that has a full picture */
  unsigned samples_min;    /* least number of samples a pixel */
  int frame;
  double begin_s;   /* time at which the step began */
  bool has_skipped; /* few pixels were given up for the next edit, and none has been shown since */
  bool is_settled;  /* more samples would not lower the error */
};

/* ---- Hand-over ---- */

void cli_view_worker_submit(cli_view_worker *worker, const cli_view_order *order) {
  pthread_mutex_lock(&worker->lock);
  neph_scene *replaced = worker->next.scene;
  free(worker->next.key);
  worker->next = *order;
  worker->next_start_s = cli_view_clock_get_s();
  pthread_cond_signal(&worker->changed);
  pthread_mutex_unlock(&worker->lock);
  neph_scene_destroy(replaced);
}

void cli_view_worker_set_region(cli_view_worker *worker, const double region[4]) {
  pthread_mutex_lock(&worker->lock);
  memcpy(worker->region, region, sizeof worker->region);
  worker->has_region_news = true;
  pthread_cond_signal(&worker->changed);
  pthread_mutex_unlock(&worker->lock);
}

void cli_view_worker_set_focus(cli_view_worker *worker, double x, double y) {
  pthread_mutex_lock(&worker->lock);
  worker->focus[0] = x;
  worker->focus[1] = y;
  pthread_mutex_unlock(&worker->lock);
}

static neph_result aim(cli_view_worker *worker) {
  pthread_mutex_lock(&worker->lock);
  double x = worker->focus[0], y = worker->focus[1];
  pthread_mutex_unlock(&worker->lock);
  const double *region = worker->step.region; /* the focus of a region is a share of it */
  if (region[0] < region[2]) x = (x - region[0]) / (region[2] - region[0]);
  if (region[1] < region[3]) y = (y - region[1]) / (region[3] - region[1]);
  return neph_renderer_set_focus(worker->renderer, x, y);
}

/* Begins the order that waits: the caller has locked. Returns the scene that it replaces. */
static neph_scene *begin_order(cli_view_worker *worker) {
  neph_scene *before = worker->scene;
  const cli_view_order *next = &worker->next;
  worker->scene = next->scene;
  free(worker->key);
  worker->key = next->key;
  worker->bake = next->bake;
  worker->samples_min = next->samples_min;
  worker->frame = next->frame;
  worker->step = (cli_view_step){.generation = next->generation, .start_s = worker->next_start_s};
  worker->next.scene = NULL;
  worker->next.key = NULL;
  worker->is_settled = false;
  return before;
}

/* Takes all pixels of another region: those of the step of few pixels stay around it. */
static void begin_region(cli_view_worker *worker) {
  worker->has_region_news = false;
  if (!worker->scene || !worker->step.level) return;
  worker->step.level = 1;
  worker->step.start_s = cli_view_clock_get_s();
  worker->is_settled = false;
}

/* Waits for a step to render; false: the end has come. */
static bool await_step(cli_view_worker *worker) {
  neph_scene *before = NULL;
  pthread_mutex_lock(&worker->lock);
  while (!worker->is_ending && !worker->next.scene && !worker->has_region_news && worker->is_settled &&
         !cli_view_variants_is_waiting(worker->variants))
    pthread_cond_wait(&worker->changed, &worker->lock);
  const bool has_order = worker->next.scene, goes_on = !worker->is_ending;
  if (has_order) before = begin_order(worker);
  if (worker->has_region_news) begin_region(worker);
  memcpy(worker->step.region, worker->region, sizeof worker->region);
  pthread_mutex_unlock(&worker->lock);
  if (has_order) cli_view_picture_set_message(worker->picture, NULL);
  neph_scene_destroy(before);
  return goes_on;
}

/* Whether the next edit ends the step under way. Few pixels are given up if they take long, as after an edit that is
 * undone at once, but not twice in a row: a picture follows. */
static bool may_skip(const cli_view_worker *worker) {
  if (worker->step.level > 0) return true;
  return !worker->has_skipped && cli_view_clock_get_s() - worker->begin_s > patience_s;
}

/* Whether the current step is still useful. */
static bool is_current(cli_view_worker *worker) {
  pthread_mutex_lock(&worker->lock);
  const bool has_news = worker->next.scene || (worker->has_region_news && worker->step.level);
  const bool is_replaced = has_news && may_skip(worker);
  const bool is_current = !worker->is_ending && !is_replaced;
  pthread_mutex_unlock(&worker->lock);
  return is_current;
}

/* ---- Steps ---- */

static bool report(void *user, const neph_progress *progress) {
  cli_view_worker *worker = user;
  cli_view_picture_set_stage(worker->picture, progress->stage, progress->fraction);
  return is_current(worker);
}

static bool show_tile(void *user, const neph_tile *tile) {
  cli_view_worker *worker = user;
  if (tile->is_final && worker->step.level > 0 && cli_view_picture_show_tile(worker->picture, &worker->step, tile))
    return false;
  return is_current(worker);
}

/* Whether the step is a coarse picture with a renderer of its own. */
static bool has_own_renderer(const cli_view_worker *worker) {
  return !worker->step.level && worker->full < worker->bake;
}

static neph_result choose_renderer(cli_view_worker *worker, neph_renderer **out_renderer) {
  *out_renderer = worker->renderer;
  if (!has_own_renderer(worker)) return NEPH_OK;
  neph_result result = NEPH_OK;
  if (!worker->coarse_renderer) result = neph_renderer_create(worker->session->context, &worker->coarse_renderer);
  *out_renderer = worker->coarse_renderer;
  return result;
}

/* Settings of the next step. The scene's time limit does not count, and its target error not before the scene's samples
 * are taken. */
static neph_result describe_step(cli_view_worker *worker, neph_render_desc *out) {
  const neph_result result = neph_scene_get_render_desc(worker->scene, out);
  if (result) return result;
  cli_view_step *step = &worker->step;
  const cli_options *options = worker->session->options;
  const unsigned divisor = step->level ? 1 : COARSE_DIVISOR;
  step->width = options->has_resolution ? options->resolution[0] : out->width;
  step->height = options->has_resolution ? options->resolution[1] : out->height;
  if (!step->level && out->sample_count < worker->samples_min)
    cli_view_picture_set_message(worker->picture, "render.samples is 1, and the error of a pixel takes 2: the view "
                                                  "renders 2, while nephos render refuses the scene");
  if (step->level == 0) step->samples = 1;
  if (step->level == 1) step->samples = out->sample_count < 2 * FIRST_SAMPLES ? out->sample_count : FIRST_SAMPLES;
  if (step->samples < worker->samples_min) step->samples = worker->samples_min;
  out->frame = worker->frame;
  out->sample_count = step->samples;
  out->target_error = out->time_limit_s = NEPH_UNLIMITED;
  out->width = (step->width + divisor - 1) / divisor;
  out->height = (step->height + divisor - 1) / divisor;
  cli_view_step_get_window(step->level ? step : NULL, out->width, out->height, out->crop_min, out->crop_max);
  out->detail_height = has_own_renderer(worker) ? (step->height + 1) / 2 : step->height;
  const bool is_solved = out->multiple_scattering == NEPH_MULTIPLE_SCATTERING_ORDINATES;
  if (has_own_renderer(worker) && is_solved) out->multiple_scattering = NEPH_MULTIPLE_SCATTERING_OCTAVES;
  out->progress = report;
  out->tile = show_tile;
  out->progress_user = out->tile_user = worker;
  return NEPH_OK;
}

/* Whether more samples lower the error: noise is more than half of the bias, and can be seen; the target of
 * the scene, where it has one, is not reached. The scene's own samples are taken in any case. */
static bool is_worth_more(const cli_view_worker *worker, const neph_image_error *error, const neph_render_desc *given) {
  if (worker->step.samples < given->sample_count) return true;
  if (worker->step.samples >= SAMPLES_MAX) return false;
  if (isfinite(given->target_error) && error->error.value <= given->target_error) return false;
  return isfinite(error->noise.value) && error->noise.value > fmax(0.5 * error->bias.value, invisible_noise);
}

/* Chooses the step behind a finished one: the scene's samples, then twice as many, as long as they are worth it. */
static void choose_next_step(cli_view_worker *worker, const neph_image_error *error, const neph_render_desc *given) {
  cli_view_step *step = &worker->step;
  worker->is_settled = step->level > 0 && !is_worth_more(worker, error, given);
  if (step->level > 0) step->samples = step->samples < given->sample_count ? given->sample_count : 2 * step->samples;
  step->level++;
}

/* Shows the picture that the scene had before, when it was shown last, in place of few pixels; false: none is kept. It
 * goes on from there. */
static bool recall(cli_view_worker *worker) {
  neph_render_desc given = NEPH_RENDER_DESC_DEFAULT;
  neph_image_error error = NEPH_IMAGE_ERROR_DEFAULT;
  const double *region = worker->step.region;
  const bool is_whole = !(region[0] < region[2] && region[1] < region[3]);
  if (worker->step.level || !worker->key || !is_whole || neph_scene_get_render_desc(worker->scene, &given))
    return false;
  if (!cli_view_picture_recall(worker->picture, worker->key, &worker->step, &error)) return false;
  choose_next_step(worker, &error, &given);
  if (worker->is_settled) cli_view_picture_set_stage(worker->picture, "done", 1.0);
  return true;
}

static void render_step(cli_view_worker *worker) {
  neph_render_desc desc = NEPH_RENDER_DESC_DEFAULT, given = NEPH_RENDER_DESC_DEFAULT;
  neph_image *image = NULL;
  neph_result result = neph_scene_get_render_desc(worker->scene, &given);
  if (!result) result = describe_step(worker, &desc);
  worker->begin_s = cli_view_clock_get_s();
  if (!worker->step.level) worker->step.waited_s = worker->begin_s - worker->step.start_s;
  neph_renderer *renderer;
  if (!result) result = aim(worker);
  if (!result) result = choose_renderer(worker, &renderer);
  if (!result) result = neph_renderer_render(renderer, worker->scene, &desc, &image);
  const cli_view_step shown = worker->step;
  if (!result && shown.level) worker->full = shown.generation;
  worker->has_skipped = result == NEPH_ERROR_CANCELLED && !shown.level;
  neph_image_error error = NEPH_IMAGE_ERROR_DEFAULT;
  if (!result) result = neph_image_get_error(image, &error);
  if (!result) choose_next_step(worker, &error, &given);
  if (!result) result = cli_view_picture_show(worker->picture, &shown, shown.level ? worker->key : NULL, image);
  /* A failed picture is given up until the next edit; its message has been logged. */
  if (result && result != NEPH_ERROR_CANCELLED) worker->is_settled = true;
  if (worker->is_settled) cli_view_picture_set_stage(worker->picture, result ? "failed" : "done", result ? 0.0 : 1.0);
}

/* ---- Variants ---- */

void cli_view_worker_awake(cli_view_worker *worker) {
  pthread_mutex_lock(&worker->lock);
  pthread_cond_signal(&worker->changed);
  pthread_mutex_unlock(&worker->lock);
}

/* Continues a variant until the next edit. */
static bool report_variant(void *user, const neph_progress *progress) {
  cli_view_worker *worker = user;
  (void)progress;
  pthread_mutex_lock(&worker->lock);
  const bool goes_on = !worker->is_ending && !worker->next.scene;
  pthread_mutex_unlock(&worker->lock);
  return goes_on;
}

static void render_variant(cli_view_worker *worker) {
  cli_view_picture_set_stage(worker->picture, "variants", 0.5);
  if (!worker->spare && neph_renderer_create(worker->session->context, &worker->spare)) return;
  cli_view_variants_render(worker->variants, worker->spare, worker->frame, report_variant, worker);
  if (cli_view_variants_is_waiting(worker->variants)) return;
  neph_renderer_destroy(worker->spare);
  worker->spare = NULL;
  cli_view_picture_set_stage(worker->picture, "done", 1.0);
}

/* ---- Lifetime ---- */

static void *work(void *user) {
  cli_view_worker *worker = user;
  while (await_step(worker))
    if (worker->is_settled)
      render_variant(worker);
    else if (!recall(worker))
      render_step(worker);
  return NULL;
}

cli_exit cli_view_worker_create(cli_session *session, cli_view_picture *picture, cli_view_variants *variants,
                                cli_view_worker **out_worker) {
  cli_view_worker *worker = *out_worker = calloc(1, sizeof *worker);
  if (!worker) return cli_complain("out of memory"), CLI_INTERNAL;
  pthread_mutex_init(&worker->lock, NULL);
  pthread_cond_init(&worker->changed, NULL);
  worker->session = session;
  worker->picture = picture;
  worker->variants = variants;
  worker->is_settled = true;
  worker->focus[0] = worker->focus[1] = 0.5;
  neph_result result = neph_renderer_create(session->context, &worker->renderer);
  if (!result) result = neph_renderer_keep_samples(worker->renderer, true);
  if (!result && !pthread_create(&worker->thread, NULL, work, worker)) return CLI_DONE;
  if (!result) cli_complain("a thread cannot be started");
  worker->is_ending = true;
  neph_renderer_destroy(worker->renderer);
  free(worker);
  *out_worker = NULL;
  return result ? cli_exit_of(result) : CLI_INTERNAL;
}

void cli_view_worker_destroy(cli_view_worker *worker) {
  if (!worker) return;
  pthread_mutex_lock(&worker->lock);
  worker->is_ending = true;
  pthread_cond_signal(&worker->changed);
  pthread_mutex_unlock(&worker->lock);
  pthread_join(worker->thread, NULL);
  neph_renderer_destroy(worker->renderer);
  neph_renderer_destroy(worker->coarse_renderer);
  neph_renderer_destroy(worker->spare);
  neph_scene_destroy(worker->scene);
  neph_scene_destroy(worker->next.scene);
  free(worker->key);
  free(worker->next.key);
  pthread_mutex_destroy(&worker->lock);
  pthread_cond_destroy(&worker->changed);
  free(worker);
}

/* SPDX-License-Identifier: Apache-2.0 */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "core/alloc.h"
#include "core/text.h"
#include "frame/bias_model.h"
#include "frame/channel_mattes.h"
#include "frame/channel_table.h"
#include "frame/error_estimate.h"
#include "frame/frame.h"
#include "frame/frame_state.h"
#include "frame/kept_samples.h"
#include "frame/reconstruction.h"
#include "frame/render_header.h"
#include "image/color_space.h"
#include "image/deep.h"
#include "image/image_private.h"
#include "plan/error_forecast.h"
#include "plan/integrator_choice.h"

static bool is_lit(const np_plan *plan) {
  return np_plan_needs(plan, NP_STAGE_SUN_LIGHT) || np_plan_needs(plan, NP_STAGE_SKY_LIGHT) ||
         np_plan_needs(plan, NP_STAGE_MOON) || np_plan_needs(plan, NP_STAGE_EMISSION);
}

/* Share of the paths cut by a limit on scatterings that are followed to measure the loss: one in sixty-four costs a
 * fraction of a picture, and a frame of 480 x 270 pixels has thousands. */
static const float lost_share = 1.0f / 64.0f;

static bool has_limit(const np_frame *f, const np_plan *plan) {
  return is_lit(plan) && f->desc->integrator == NEPH_INTEGRATOR_PATH && f->desc->scattering_max != NEPH_SCATTERINGS_ALL;
}

static void choose_integrator(np_frame *f, const np_plan *plan, const neph_scene *scene) {
  const bool is_approximated = np_plan_needs(plan, NP_STAGE_APPROXIMATION);
  np_integrator_choice_make(
      &scene->render, is_approximated ? f->desc->multiple_scattering : NEPH_MULTIPLE_SCATTERING_NONE, &f->settings);
  f->settings.scattering_max = is_lit(plan) ? f->desc->scattering_max : 0;
  f->settings.is_split = f->desc->path_guiding == NEPH_PATH_GUIDING_ADJOINT && np_plan_needs(plan, NP_STAGE_ORDINATES);
  f->settings.is_air_traced = is_lit(plan) && np_request_traces_air(&plan->request);
  f->settings.has_sun_share = plan->request.aovs & NP_AOV_SHADOW;
  for (unsigned i = 0; i < f->assembly->clouds.count; i++)
    f->settings.has_holdout = f->settings.has_holdout || scene->clouds[i].is_held_out;
  f->settings.is_ground_held_out = f->channels.is_ground_held_out;
  f->settings.lost_share = has_limit(f, plan) ? lost_share : 0.0f;
  const np_integrator_kernels *kernels = np_integrator_get_kernels(neph_context_get_isa(f->assembly->context));
  f->integrate = f->desc->integrator == NEPH_INTEGRATOR_PATH ? kernels->path : kernels->march;
  f->half_distance = kernels->half_distance;
  const np_camera *camera = &f->assembly->camera;
  f->spread_rad = (float)sqrt(np_camera_get_pixel_sr(camera, (int)camera->width / 2, (int)camera->height / 2));
  f->view_depth = kernels->view_depth;
  f->settings.monitor = f->monitor;
}

static void set_window(np_frame *f, const np_plan *plan) {
  memcpy(f->min, plan->request.window_min, sizeof f->min);
  memcpy(f->view_min, plan->request.view_min, sizeof f->view_min);
  memcpy(f->view_max, plan->request.view_max, sizeof f->view_max);
  f->width = (unsigned)(plan->request.window_max[0] - plan->request.window_min[0]);
  f->height = (unsigned)(plan->request.window_max[1] - plan->request.window_min[1]);
}

/* Components whose light deep pixels hold: the components of clouds, unless light is not computed. */
static unsigned choose_depth_components(const np_plan *plan, const np_scene_output *output) {
  if (!output->deep || plan->request.is_sky_alone) return 0;
  const bool has_air = output->cloud_air == NP_CLOUD_AIR_KEPT;
  return NP_COMPONENTS_OF_CLOUDS | (has_air ? 1u << NP_COMPONENT_AIR : 0u);
}

static void choose_motion(np_frame *f) {
  const np_motion *motion = f->assembly->motion;
  if (motion && (motion->has_camera || motion->has_clouds)) f->exposure = motion;
  if (motion && f->aovs & NP_AOV_MOTION) f->vectors = motion;
}

static void fill_header(const np_frame *f, neph_image *image) {
  np_image_header *header = &image->header;
  header->has_window = true;
  for (int a = 0; a < 2; a++) {
    header->data_min[a] = f->min[a];
    header->data_max[a] = f->min[a] + (int)(a == 0 ? f->width : f->height) - 1;
    header->display_max[a] = (int)(a == 0 ? f->desc->width : f->desc->height) - 1;
  }
}

static neph_result create_image(np_frame *f, neph_image **out_image) {
  const char *names[NP_CHANNELS_MAX] = {NULL};
  const unsigned count = f->channels.count;
  for (unsigned c = 0; c < count; c++) names[c] = f->channels.channel[c].name;
  neph_result result = neph_image_create(f->assembly->context, f->width, f->height, count, names, out_image);
  if (result) return result;
  for (unsigned c = 0; c < count; c++) f->planes[c] = neph_image_get_channel(*out_image, names[c]);
  fill_header(f, *out_image);
  f->image = *out_image;
  return f->depth_components ? np_image_add_deep(f->image) : NEPH_OK;
}

static neph_result set_triple(neph_image *image, const char *name, const double values[NP_BAND_COUNT]) {
  char text[96];
  np_print(text, sizeof text, "%.6g %.6g %.6g", values[0], values[1], values[2]);
  return neph_image_set_attribute(image, name, text);
}

/* The picture's mean and its standard error, into header and log. */
static neph_result describe_mean(const np_frame *f, neph_image *image) {
  const double pixels = (double)f->width * f->height;
  double mean[NP_BAND_COUNT] = {0}, error[NP_BAND_COUNT] = {0};
  for (size_t tile = 0; tile < np_frame_count_tiles(f); tile++)
    for (int b = 0; b < NP_BAND_COUNT; b++) {
      mean[b] += f->totals[tile].sum[b] / pixels;
      error[b] += f->totals[tile].variance[b];
    }
  for (int b = 0; b < NP_BAND_COUNT; b++) error[b] = sqrt(error[b]) / pixels;
  neph_result result = set_triple(image, "nephos:mean", mean);
  if (result || f->desc->sample_count < 2) return result;
  np_log(f->assembly->context, NEPH_LOG_DEBUG, "mean of R, G, B: %.6g +- %.2g, %.6g +- %.2g, %.6g +- %.2g", mean[0],
         error[0], mean[1], error[1], mean[2], error[2]);
  return set_triple(image, "nephos:meanStandardError", error);
}

/* Followed paths below which the light that a limit took is not known: as in probes (render/probe_slab.c). */
enum { FOLLOWED_LEAST = 16 };

/* Light lost to the limit on scatterings: its mean in a pixel, infinite where too few paths were followed to know it.
 */
static void compute_loss(const np_frame *f, double lost[NP_BAND_COUNT]) {
  const double pixels = (double)f->width * f->height;
  uint64_t cut_count = 0, followed_count = 0;
  for (size_t tile = 0; tile < np_frame_count_tiles(f); tile++) {
    for (int b = 0; b < NP_BAND_COUNT; b++) lost[b] += f->totals[tile].lost[b] / pixels;
    cut_count += f->totals[tile].cut_count;
    followed_count += f->totals[tile].followed_count;
  }
  const bool is_finite = isfinite(lost[0] + lost[1] + lost[2]); /* false: a followed path was given up before its end */
  if (is_finite && (cut_count == 0 || followed_count >= FOLLOWED_LEAST)) return;
  for (int b = 0; b < NP_BAND_COUNT; b++) lost[b] = HUGE_VAL;
  np_log(f->assembly->context, NEPH_LOG_WARNING,
         "render.max_scatterings %u ended %llu paths, of which %llu were followed%s: the light that is lost is not "
         "known; render more samples, or raise the limit",
         f->desc->scattering_max, (unsigned long long)cut_count, (unsigned long long)followed_count,
         is_finite ? ", must be 16" : ", not all of them to the end");
}

/* The loss and its share of the whole. */
static neph_result describe_loss(const np_frame *f, neph_image *image) {
  if (!(f->settings.lost_share > 0.0f)) return NEPH_OK;
  double lost[NP_BAND_COUNT] = {0}, kept = 0.0, all = 0.0;
  compute_loss(f, lost);
  for (size_t tile = 0; tile < np_frame_count_tiles(f); tile++)
    for (int b = 0; b < NP_BAND_COUNT; b++) kept += f->totals[tile].sum[b] / ((double)f->width * f->height);
  for (int b = 0; b < NP_BAND_COUNT; b++) all += lost[b];
  all += kept;
  if (isfinite(all))
    np_log(f->assembly->context, NEPH_LOG_INFO,
           "render.max_scatterings %u lost a mean of %.4g, %.4g, %.4g in R, G, B: %.3g %% of the light",
           f->desc->scattering_max, lost[0], lost[1], lost[2], all > 0.0 ? 100.0 * (1.0 - kept / all) : 0.0);
  return set_triple(image, "nephos:lostMean", lost);
}

/* The number of samples that a target error needs is unknown before. */
static neph_result describe_cut(const np_frame *f, double samples, neph_image *image) {
  char text[96];
  if (np_frame_has_target(f))
    np_print(text, sizeof text, "cut at %.4g samples a pixel", samples);
  else
    np_print(text, sizeof text, "cut at %.4g of %u samples a pixel", samples, f->desc->sample_count);
  np_log(f->assembly->context, NEPH_LOG_INFO, "the time limit of %g s ended sampling, %s", f->desc->time_limit_s, text);
  return neph_image_set_attribute(image, "nephos:sampling", text);
}

static int compare_counts(const void *a, const void *b) {
  const float *x = a, *y = b;
  return (*x > *y) - (*x < *y);
}

/* The least, the median and the largest number that a target error chose. */
static neph_result describe_counts(const np_frame *f) {
  const size_t pixels = (size_t)f->width * f->height;
  if (!np_frame_has_target(f) || !f->luminances) return NEPH_OK;
  float *counts = np_alloc(f->assembly->context, pixels, sizeof *counts);
  if (!counts) return NEPH_ERROR_OUT_OF_MEMORY;
  for (size_t i = 0; i < pixels; i++) counts[i] = f->luminances[i].count;
  qsort(counts, pixels, sizeof *counts, compare_counts);
  np_log(f->assembly->context, NEPH_LOG_INFO, "samples of a pixel: least %.0f, median %.0f, largest %.0f",
         (double)counts[0], (double)counts[pixels / 2], (double)counts[pixels - 1]);
  np_alloc_free(f->assembly->context, counts);
  return NEPH_OK;
}

/* Writes the number of samples, and the pixels' standard error, into the header. */
static neph_result describe_samples(const np_frame *f, neph_image *image) {
  const double pixels = (double)f->width * f->height;
  uint64_t samples = 0;
  double squares = 0.0;
  for (size_t tile = 0; tile < np_frame_count_tiles(f); tile++) {
    samples += f->totals[tile].samples;
    squares += f->totals[tile].squares;
  }
  neph_result result = np_image_set_real(image, "nephos:samples", (double)samples / pixels);
  if (!result) result = describe_counts(f);
  if (!result && f->is_cut) result = describe_cut(f, (double)samples / pixels, image);
  if (result || f->desc->sample_count < 2) return result;
  const double error = sqrt(squares / pixels);
  np_log(f->assembly->context, np_frame_has_target(f) ? NEPH_LOG_INFO : NEPH_LOG_DEBUG,
         "%.4g samples a pixel, with a relative error of %.3g", (double)samples / pixels, error);
  return np_image_set_real(image, "nephos:pixelError", error);
}

neph_result np_frame_describe(const np_frame *f, neph_image *image) {
  neph_result result = describe_samples(f, image);
  if (!result) result = describe_loss(f, image);
  return result ? result : describe_mean(f, image);
}

static void choose_luminance(np_frame *f, const np_plan *plan) {
  for (int b = 0; b < NP_BAND_COUNT; b++) f->luminance_weights[b] = 1.0 / NP_BAND_COUNT;
  if (plan->decisions.color_space == NP_COLOR_BANDS) return;
  (void)np_color_space_get_luminances(np_color_space_get_chromaticities(plan->decisions.color_space),
                                      f->luminance_weights);
}

/* An estimate that is no more than this above the target is as good as it. */
static const double target_slack = 1.3;

/* Warns of a missed target error, with its cause. */
static void warn_of_target(const np_frame *f, const np_frame_error *e) {
  const double target = f->desc->target_error;
  if (!np_frame_has_target(f) || isnan(e->total.value) || e->total.value <= target_slack * target) return;
  char why[128] = "";
  if (f->is_cut)
    np_print(why, sizeof why, "the time limit of %g s came first", f->desc->time_limit_s);
  else if (isfinite(f->desc->time_limit_s))
    np_print(why, sizeof why, "the time limit of %g s allowed no better settings", f->desc->time_limit_s);
  else if (e->bias.value > target)
    np_print(why, sizeof why, "the march errs by that much here: set render.integrator to path");
  else
    np_print(why, sizeof why, "raise render.max_samples or lower the target");
  np_log(f->assembly->context, NEPH_LOG_WARNING,
         "the error reached is %.2g %% a pixel (noise %.2g, bias about %.2g), the target is %.2g %%: %s",
         100.0 * e->total.value, 100.0 * e->noise.value, 100.0 * e->bias.value, 100.0 * target, why);
}

static neph_result estimate_error(const np_frame *f, const np_plan *plan, double *out_s, neph_image *image) {
  np_frame_error error;
  const double start_s = np_cpu_time_s();
  neph_result result = np_frame_estimate_error(f, plan, &error);
  *out_s = np_cpu_time_s() - start_s;
  if (result) return result;
  warn_of_target(f, &error);
  return np_frame_error_write(&error, image);
}

static neph_result integrate_frame(np_frame *f, const np_plan *plan, np_stage_times *times, neph_image *image) {
  neph_context *context = f->assembly->context;
  f->totals = np_alloc(context, np_frame_count_tiles(f), sizeof *f->totals);
  f->luminances = np_alloc(context, (size_t)f->width * f->height, sizeof *f->luminances);
  if (!f->totals || !f->luminances) return NEPH_ERROR_OUT_OF_MEMORY;
  choose_luminance(f, plan);
  neph_result result = np_tile_feed_open(f->feed, context, image, NP_TILE_EDGE);
  if (!result) result = np_frame_sample(f);
  np_tile_feed_close(f->feed);
  if (!result && !f->reconstruction) result = estimate_error(f, plan, &times->error_s, image);
  if (!result) result = np_image_set_real(image, "renderTime", np_monitor_get_seconds(f->monitor));
  if (result) return result;
  return f->reconstruction ? np_reconstruction_describe(f, image) : np_frame_describe(f, image);
}

/* Samples the frame, and keeps its film where the plan names a file for it. */
static neph_result integrate_and_keep(np_frame *f, const neph_scene *scene, const np_plan *plan,
                                      np_stage_times *times) {
  assert(f->sink || (!plan->request.desc.part_path && !plan->request.desc.checkpoint_path));
  neph_result result = f->sink ? f->sink->open(scene, plan, f, &f->film) : NEPH_OK;
  if (!result && f->kept) result = np_kept_samples_begin(f->kept, scene, plan, f);
  if (result) return f->sink ? f->sink->finish(f->film, result) : result;
  if (!f->sink) return integrate_frame(f, plan, times, f->image);
  f->feed->keep = f->film ? f->sink->write_when_due : NULL;
  f->feed->film = f->film;
  result = integrate_frame(f, plan, times, f->image);
  f->feed->keep = NULL;
  return f->sink->finish(f->film, result);
}

neph_result np_frame_render(const neph_scene *scene, const np_plan *plan, const np_render_job *job,
                            const np_assembly *assembly, np_monitor *monitor, neph_image **out_image) {
  const neph_render_desc *desc = &plan->request.desc;
  neph_context *context = assembly->context;
  np_tile_feed nobody = {.fn = NULL};
  np_frame *f = np_alloc(context, 1, sizeof *f);
  if (!f) return NEPH_ERROR_OUT_OF_MEMORY;
  f->feed = job->feed ? job->feed : &nobody;
  f->sink = job->sink;
  f->kept = job->kept;
  f->focus = job->focus;
  f->assembly = assembly;
  f->desc = desc;
  f->aovs = plan->request.aovs;
  f->noise_target = np_plan_choose_noise(plan);
  f->prediction = &job->build.times->prediction;
  f->depth_components = choose_depth_components(plan, &scene->output);
  f->has_light_groups = plan->request.has_light_groups;
  f->has_layers = f->depth_components || f->has_light_groups ||
                  plan->request.aovs & (NP_AOV_MATTES | NP_AOV_CRYPTOMATTE | NP_AOV_MOTION);
  choose_motion(f);
  f->monitor = monitor;
  set_window(f, plan);
  np_channels_choose(plan, scene, &f->channels);
  choose_integrator(f, plan, scene);
  neph_result result = create_image(f, out_image);
  if (!result && plan->request.aovs & NP_AOV_CRYPTOMATTE) result = np_channels_write_manifest(scene, *out_image);
  if (!result) result = np_render_header_write(scene, plan, assembly, *out_image);
  if (!result) result = np_reconstruction_create(scene, plan, f, &f->reconstruction);
  if (!result) result = integrate_and_keep(f, scene, plan, job->build.times);
  if (!result && f->reconstruction) result = np_reconstruction_store(f->reconstruction, plan, job->build.stores);
  np_reconstruction_destroy(f->reconstruction);
  if (result) {
    neph_image_destroy(*out_image);
    *out_image = NULL;
  }
  np_alloc_free(context, f->totals);
  np_alloc_free(context, f->luminances);
  np_alloc_free(context, f);
  return result;
}

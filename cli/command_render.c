/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#include "calibration.h"
#include "command_files.h"
#include "print.h"
#include "render_job.h"
#include "verbs.h"

/* ---- Target and limits ---- */

/* Chooses settings by the target error and the time limit of the command, and sets its memory limit. */
static neph_result choose_effort(render_job *job) {
  const cli_options *options = job->session->options;
  neph_render_desc *desc = &job->desc, chosen = NEPH_RENDER_DESC_DEFAULT;
  neph_effort effort = NEPH_EFFORT_DEFAULT;
  if (options->target_error > 0.0) desc->target_error = options->target_error;
  if (options->has_time_limit) desc->time_limit_s = options->time_limit_s;
  if (options->has_memory_max) desc->memory_max_bytes = options->memory_max_bytes;
  desc->machine = &job->machine;
  if (!isfinite(desc->target_error) && !isfinite(desc->time_limit_s)) return NEPH_OK;
  neph_result result = job->renderer ? neph_renderer_choose_effort(job->renderer, job->scene, desc, &effort)
                                     : neph_scene_choose_effort(job->scene, desc, &effort);
  if (!result) result = neph_scene_get_render_desc(job->scene, &chosen);
  if (result) return result;
  desc->integrator = chosen.integrator;
  desc->sample_count = chosen.sample_count;
  return NEPH_OK;
}

/* ---- Crop, tile and samples ---- */

static cli_exit choose_pixels(render_job *job) {
  const cli_options *options = job->session->options;
  neph_render_desc *desc = &job->desc;
  for (int i = 0; options->has_crop && i < 2; i++) {
    desc->crop_min[i] = options->crop[i];
    desc->crop_max[i] = options->crop[i + 2];
  }
  if (options->has_sample_range) {
    desc->sample_begin = options->sample_range[0];
    desc->sample_end = options->sample_range[1];
  }
  if (!options->tile_count) return CLI_DONE;
  const unsigned top = desc->crop_min[1], bottom = desc->crop_max[1];
  const uint64_t rows = bottom > top ? bottom - top : 0;
  if (rows < options->tile_count) {
    cli_progress_complain(&job->session->progress,
                          "--tile is %u/%u, must be at most as many bands as there are rows, %u", options->tile_index,
                          options->tile_count, (unsigned)rows);
    return CLI_USAGE;
  }
  desc->tile_index = options->tile_index - 1;
  desc->tile_count = options->tile_count;
  return CLI_DONE;
}

static neph_result set_resolution(const cli_options *options, neph_scene *scene) {
  char value[32];
  if (!options->has_resolution) return NEPH_OK;
  cli_print(value, sizeof value, "[%u, %u]", options->resolution[0], options->resolution[1]);
  const neph_result result = neph_scene_set(scene, "camera.resolution", value);
  /* A wrong value of an option is an error of the command line, not of the scene. */
  return result == NEPH_ERROR_BAD_SCENE ? NEPH_ERROR_INVALID_ARGUMENT : result;
}

cli_exit render_job_choose_settings(render_job *job) {
  neph_result result = set_resolution(job->session->options, job->scene);
  if (!result) result = neph_scene_get_render_desc(job->scene, &job->desc);
  job->desc.progress = cli_progress_report;
  job->desc.progress_user = &job->session->progress;
  cli_exit exit = result ? cli_exit_of(result) : choose_pixels(job);
  if (!exit) exit = cli_exit_of(cli_calibration_load(job->session, &job->machine));
  return exit ? exit : cli_exit_of(choose_effort(job));
}

/* ---- Frames ---- */

static neph_result save_frame(const render_job *job, const neph_image *image, const render_targets *t) {
  neph_result result = NEPH_OK;
  if (t->image && !t->is_part) result = neph_image_save_exr(image, t->image, job->output.pixel_type);
  if (!result && t->preview) result = neph_image_save_png(image, t->preview, &job->output.preview_desc);
  if (!result && t->deep) result = neph_image_save_deep_exr(image, t->deep, job->output.pixel_type);
  return result;
}

static cli_exit render_to(render_job *job, render_targets *t) {
  neph_image *image = NULL;
  cli_progress *progress = &job->session->progress;
  cli_progress_set_call(progress, 0.97);
  neph_result result = neph_renderer_render(job->renderer, job->scene, &job->desc, &image);
  if (!result) cli_progress_set_stage(progress, "writing", 0.97);
  if (!result) job->batch.is_stopped = (result = save_frame(job, image, t)) != NEPH_OK;
  if (!result) render_job_remove_checkpoint(t);
  if (!result) cli_progress_set_stage(progress, "writing", 1.0);
  cli_progress_finish(progress);
  cli_progress_end_frame(progress, !result);
  frame_facts facts = {.seconds = cli_progress_get_frame_s(progress), .error = NEPH_IMAGE_ERROR_DEFAULT};
  if (!result) result = neph_image_get_error(image, &facts.error);
  facts.image = image;
  facts.preview_stops = NAN;
  if (!result && t->preview)
    result = neph_image_compute_exposure(image, &job->output.preview_desc, &facts.preview_stops);
  if (!result) facts.hash = neph_image_get_attribute(image, "nephos:sceneHash");
  if (!result) render_job_warn_of_lift(job, &facts);
  if (!result) render_job_print_frame(job, t, &facts);
  neph_image_destroy(image);
  fflush(stdout);
  return cli_exit_of(result);
}

/* Renders a frame, unless it exists already: then it is skipped, and its checkpoint removed. */
static cli_exit render_or_skip(render_job *job, render_targets *t) {
  bool is_done = false;
  neph_result result = render_job_set_restart(job, t);
  if (!result && job->session->options->skips_existing) result = render_job_check_done(job, t, &is_done);
  if (result) return cli_exit_of(result);
  if (!is_done) return render_to(job, t);
  render_job_remove_checkpoint(t);
  render_job_print_skipped(job, t);
  fflush(stdout);
  return CLI_DONE;
}

static cli_exit explain(render_job *job) {
  char *text;
  const neph_text_format format = cli_text_format(job->session);
  neph_result result = neph_renderer_explain(job->renderer, job->scene, &job->desc, format, &text);
  if (!result) cli_print_text(job->session, text);
  return cli_exit_of(result);
}

/* A dry run, which fails wherever a render fails before its first pixel. */
static cli_exit rehearse(render_job *job, const render_targets *t) {
  char *text;
  neph_result result = neph_renderer_explain(job->renderer, job->scene, &job->desc, NEPH_TEXT_PLAIN, &text);
  if (result) return cli_exit_of(result);
  neph_text_destroy(job->session->context, text);
  if (t->image) cli_say("%s", t->image);
  if (t->preview) cli_say("%s", t->preview);
  if (t->deep) cli_say("%s", t->deep);
  return CLI_DONE;
}

static cli_exit render_frame(render_job *job) {
  const cli_options *options = job->session->options;
  if (options->wants_plan) return explain(job);
  render_targets t;
  cli_exit exit = cli_exit_of(render_job_name_targets(job, &t));
  if (!exit) exit = options->is_dry_run ? rehearse(job, &t) : render_or_skip(job, &t);
  render_job_free_targets(job, &t);
  return exit;
}

cli_exit render_job_for_each_eye(render_job *job, cli_exit (*step)(render_job *job)) {
  if (!neph_scene_is_stereo(job->scene)) return step(job);
  cli_exit exit = CLI_DONE;
  for (neph_eye eye = NEPH_EYE_LEFT; !exit && eye <= NEPH_EYE_RIGHT; eye++) {
    job->desc.eye = eye;
    exit = cli_is_interrupted() ? CLI_INTERRUPTED : step(job);
  }
  return exit;
}

cli_exit render_job_for_each_frame(render_job *job, cli_exit (*step)(render_job *job)) {
  cli_frame_walk walk = {0};
  cli_exit exit = CLI_DONE;
  while (!exit && cli_next_frame(job->session->options, &walk, &job->desc.frame)) {
    cli_frame_walk ahead = walk;
    job->desc.has_next_frame = cli_next_frame(job->session->options, &ahead, &job->desc.next_frame);
    exit = cli_is_interrupted() ? CLI_INTERRUPTED : step(job);
  }
  return exit;
}

static cli_exit count_frame(render_job *job) {
  job->batch.count++;
  return CLI_DONE;
}

/* Predicts the time of the frames; only ratios matter, where there are several. A frame without a prediction fails
 * later by itself. */
static void predict_times(render_job *job) {
  frame_batch *b = &job->batch;
  b->first_s = b->next_s = 1.0;
  if (b->count < 2 && !neph_scene_is_stereo(job->scene)) return;
  if (neph_render_estimate_time(job->scene, &job->desc, &b->first_s, &b->next_s)) return;
  b->first_s = fmax(b->first_s, 1e-6);
  b->next_s = fmax(b->next_s, 1e-6);
}

static cli_exit check_eyes(render_job *job) { return render_job_for_each_eye(job, render_job_check_targets); }

static cli_exit check_files(render_job *job) {
  cli_exit exit = cli_files_begin(job->session, &job->files);
  if (!exit) exit = render_job_for_each_frame(job, check_eyes);
  return cli_files_end(job->files, job->scene, exit);
}

static void note_failure(render_job *job, cli_exit exit) {
  cli_failures_add(&job->batch.failures, job->desc.frame);
  render_job_print_failed(job, exit);
}

/* Renders a picture. Its share of the progress follows from predicted times. */
static cli_exit render_picture(render_job *job) {
  frame_batch *b = &job->batch;
  const unsigned eyes = neph_scene_is_stereo(job->scene) ? 2 : 1, i = b->begun_count++;
  const double all_s = b->first_s + (b->count * eyes - 1) * b->next_s;
  const double begin = i > 0 ? (b->first_s + (i - 1) * b->next_s) / all_s : 0.0;
  const double end = (b->first_s + i * b->next_s) / all_s;
  cli_progress_begin_frame(&job->session->progress, job->desc.frame, i / eyes, b->count, begin, end);
  return render_frame(job);
}

/* Renders the picture of each eye of a frame. A failure does not end a batch of frames. */
static cli_exit render_eyes(render_job *job) {
  const cli_exit exit = render_job_for_each_eye(job, render_picture);
  if (!exit || exit == CLI_INTERRUPTED || job->batch.count == 1) return exit;
  note_failure(job, exit);
  return job->batch.is_stopped ? exit : CLI_DONE;
}

/* Reports failed frames. `exit` is the result of the step that ended the batch early. */
static cli_exit end_batch(const render_job *job, cli_exit exit) {
  const frame_batch *b = &job->batch;
  if (!b->failures.count) return exit;
  cli_failures_complain(&b->failures, &job->session->progress, b->count,
                        b->is_stopped ? "; those after it were not begun" : "");
  return exit ? exit : CLI_SOME_FAILED;
}

static cli_exit render_batch(render_job *job) {
  cli_exit exit = render_job_for_each_frame(job, count_frame);
  if (!exit && !job->session->options->wants_plan) predict_times(job);
  if (!exit) exit = render_job_for_each_frame(job, render_eyes);
  return end_batch(job, exit);
}

static bool is_part(const neph_render_desc *desc) {
  return desc->tile_count > 1 || desc->crop_max[0] - desc->crop_min[0] < desc->width ||
         desc->crop_max[1] - desc->crop_min[1] < desc->height;
}

static cli_exit run(render_job *job) {
  const cli_options *options = job->session->options;
  cli_exit exit = render_job_choose_settings(job);
  if (!exit && options->wants_plan) return render_batch(job);
  /* Output texts belong to the scene's settings, which the effort has changed. */
  if (!exit) exit = cli_exit_of(neph_scene_get_output(job->scene, &job->output));
  if (!exit) exit = render_job_choose_outputs(job);
  if (!exit) render_job_choose_exposure(job, is_part(&job->desc));
  if (!exit) exit = check_files(job);
  return exit ? exit : render_batch(job);
}

static cli_exit run_render(cli_session *session) {
  render_job job = {.session = session,
                    .desc = NEPH_RENDER_DESC_DEFAULT,
                    .machine = NEPH_MACHINE_DEFAULT,
                    .output = NEPH_OUTPUT_DEFAULT};
  cli_exit exit = cli_load_scene(session, session->options->files[0], &job.scene);
  if (exit) return exit;
  cli_catch_interrupts();
  cli_catch_snapshots();
  exit = cli_exit_of(neph_renderer_create(session->context, &job.renderer));
  if (!exit) exit = run(&job);
  exit = render_job_end_restart(&job, exit);
  neph_renderer_destroy(job.renderer);
  neph_scene_destroy(job.scene);
  return exit;
}

const cli_verb cli_verb_render = {
    .name = "render",
    .arguments = "SCENE",
    .summary = "render frames to OpenEXR and PNG",
    .argument_min = 1,
    .argument_max = 1,
    .run = run_render,
    .files = "yaml yml",
    .exits =
        CLI_MAY(CLI_BAD_SCENE) | CLI_MAY(CLI_NOT_FOUND) | CLI_MAY(CLI_LIMIT) | CLI_MAY(CLI_SOME_FAILED) | CLI_MAY_STOP,
    .description = "Renders frames. The file names come from the scene's `output`; the last run of # in them is the "
                   "frame's number, and %V, of a stereo camera, the eye's name, left or right. Everything that can be "
                   "checked is checked before the first pixel: the scene, the "
                   "names, whether their folders can be written.",
    .options = {{"--output",
                 "write to FILE, an .exr or a .png, or, given twice, one of each, and nothing else; an .npart is a "
                 "part, for nephos merge",
                 .files = "exr png npart"},
                {"--set"},
                {"--frames", "frames to render"},
                {"--resolution"},
                {"--crop"},
                {"--tile"},
                {"--sample-range"},
                {"--checkpoint"},
                {"--resume"},
                {"--skip-existing"},
                {"--samples"},
                {"--seed"},
                {"--quality"},
                {"--integrator"},
                {"--path-guiding"},
                {"--target-error", "choose all settings that the scene does not give for an error a pixel of X, noise "
                                   "and bias together, in the least time"},
                {"--time-limit", "choose all settings that the scene does not give for the least error in that time, "
                                 "and end each frame then, with the samples it has"},
                {"--machine"},
                {"--max-memory", "save memory where a render may need more, or refuse it with exit code 6"},
                {"--cache"},
                {"--cache-size"},
                {"--path-mapping"},
                {"--explain"},
                {"--dry-run"},
                {"--progress"}},
    .examples = {{"nephos render scene.yaml --frames 1-3x2", "render the frames 1 and 3"},
                 {"nephos render scene.yaml -o look.png --samples 1 --resolution 32x18", "render a small preview"},
                 {"nephos render scene.yaml --tile 2/4", "render the second of four bands, for a farm"},
                 {"nephos render scene.yaml --frames 1-3 --checkpoint 60s --resume --skip-existing",
                  "start, or start again, a batch that may be stopped"},
                 {"nephos render scene.yaml --target-error 0.1 --explain", "print settings, time, memory and error"}},
};

/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "verbs.h"

/* The files of one frame; NULL: not wanted. */
typedef struct targets {
  char *image, *preview, *deep;
} targets;

typedef struct render_job {
  cli_session *session;
  neph_scene *scene;
  neph_render_desc desc;
  neph_output output;
} render_job;

/* ---- Where to ---- */

/* --output replaces what the scene says: once or twice, a picture and a preview. Deep pictures are the scene's alone.
 */
static cli_exit choose_outputs(render_job *job) {
  const cli_options *options = job->session->options;
  if (options->output_count) job->output.image = job->output.preview = NULL;
  for (size_t i = 0; i < options->output_count; i++) {
    const char *path = options->outputs[i];
    const bool is_preview = cli_has_extension(path, ".png");
    const char **place = is_preview ? &job->output.preview : &job->output.image;
    if ((!is_preview && !cli_has_extension(path, ".exr")) || *place) {
      cli_complain("--output is %s, must be one .exr, one .png, or one of each", path);
      return CLI_USAGE;
    }
    *place = path;
  }
  if (job->output.image || job->output.preview || job->output.deep) return CLI_DONE;
  cli_complain("%s names no output: give output.image in it, or --output", options->files[0]);
  return CLI_USAGE;
}

/* Stands for the eye's name, as in Nuke. */
static const char eye_mark[] = "%V";

static cli_exit check_pattern(const render_job *job, const char *pattern) {
  if (pattern && neph_scene_is_stereo(job->scene) && !strstr(pattern, eye_mark)) {
    cli_complain("%s would be written for both eyes: put %s where left or right goes", pattern, eye_mark);
    return CLI_USAGE;
  }
  if (!pattern || cli_is_single_frame(job->session->options) || strchr(pattern, '#')) return CLI_DONE;
  cli_complain("%s would be written for every frame: put # where the number goes", pattern);
  return CLI_USAGE;
}

/* Pattern, to be freed, with the name of the eye in the place of its mark. NULL: no memory. */
static char *name_eye(const render_job *job, const char *pattern) {
  const char *mark = strstr(pattern, eye_mark);
  if (!mark || job->desc.eye == NEPH_EYE_CENTRE) return strdup(pattern);
  char *named;
  const int printed = asprintf(&named, "%.*s%s%s", (int)(mark - pattern), pattern,
                               job->desc.eye == NEPH_EYE_LEFT ? "left" : "right", mark + strlen(eye_mark));
  return printed < 0 ? NULL : named;
}

/* Output path, to be freed: the pattern, or, for a tile, "out/frame.####.tile2of4.exr". NULL: no memory. */
static char *name_tile(const cli_options *options, const char *pattern) {
  const size_t length = strlen(pattern), ending = strlen(".exr");
  if (!options->tile_count || options->output_count || length <= ending) return strdup(pattern);
  char *tiled;
  const int stem = (int)(length - ending);
  const int printed =
      asprintf(&tiled, "%.*s.tile%uof%u%s", stem, pattern, options->tile_index, options->tile_count, pattern + stem);
  return printed < 0 ? NULL : tiled;
}

static neph_result name_target(const render_job *job, const char *pattern, char **out_path) {
  *out_path = NULL;
  if (!pattern) return NEPH_OK;
  char *named = name_eye(job, pattern), *tiled = named ? name_tile(job->session->options, named) : NULL;
  neph_result result = NEPH_ERROR_OUT_OF_MEMORY;
  if (tiled) result = neph_frame_get_path(job->session->context, tiled, job->desc.frame, out_path);
  free(named);
  free(tiled);
  return result;
}

static void free_targets(const render_job *job, targets *t) {
  neph_text_destroy(job->session->context, t->image);
  neph_text_destroy(job->session->context, t->preview);
  neph_text_destroy(job->session->context, t->deep);
}

static neph_result name_targets(const render_job *job, targets *out) {
  *out = (targets){NULL, NULL, NULL};
  neph_result result = name_target(job, job->output.image, &out->image);
  if (!result) result = name_target(job, job->output.preview, &out->preview);
  if (!result) result = name_target(job, job->output.deep, &out->deep);
  return result;
}

/* A cloud that is not on disk is baked to its file before the first pixel. */
static cli_exit check_cloud(const render_job *job, unsigned index) {
  const char *pattern = neph_scene_get_cloud_file(job->scene, index);
  if (!pattern || !neph_scene_is_cloud_baked(job->scene, index)) return CLI_DONE;
  char *path;
  cli_exit exit = cli_exit_of(neph_frame_get_path(job->session->context, pattern, job->desc.frame, &path));
  if (!exit && access(path, F_OK)) exit = cli_check_target(job->session, path);
  neph_text_destroy(job->session->context, path);
  return exit;
}

static cli_exit check_targets(render_job *job) {
  targets t;
  neph_result result = name_targets(job, &t);
  cli_exit exit = cli_exit_of(result);
  if (!exit && t.image) exit = cli_check_target(job->session, t.image);
  if (!exit && t.preview) exit = cli_check_target(job->session, t.preview);
  if (!exit && t.deep) exit = cli_check_target(job->session, t.deep);
  for (unsigned i = 0; !exit && i < neph_scene_get_cloud_count(job->scene); i++) exit = check_cloud(job, i);
  free_targets(job, &t);
  return exit;
}

/* Parts of a picture, and frames of a sequence, must match: what none of them shows alone cannot expose them. */
static void choose_exposure(render_job *job) {
  const neph_render_desc *desc = &job->desc;
  neph_preview_desc *preview = &job->output.preview_desc;
  const bool is_part =
      desc->crop_max[0] - desc->crop_min[0] < desc->width || desc->crop_max[1] - desc->crop_min[1] < desc->height;
  const bool is_of_sequence = job->output.preview && strchr(job->output.preview, '#');
  if (preview->exposure == NEPH_EXPOSURE_AUTO && (is_part || is_of_sequence)) preview->exposure = NEPH_EXPOSURE_METER;
}

/* ---- How long ---- */

static void choose_effort(render_job *job) {
  const cli_options *options = job->session->options;
  if (options->target_error > 0.0) job->desc.target_error = options->target_error;
  if (options->has_time_limit) job->desc.time_limit_s = options->time_limit_s;
  if (options->has_memory_max) job->desc.memory_max_bytes = options->memory_max_bytes;
}

/* ---- Which pixels ---- */

static cli_exit choose_pixels(render_job *job) {
  const cli_options *options = job->session->options;
  neph_render_desc *desc = &job->desc;
  for (int i = 0; options->has_crop && i < 2; i++) {
    desc->crop_min[i] = options->crop[i];
    desc->crop_max[i] = options->crop[i + 2];
  }
  if (!options->tile_count) return CLI_DONE;
  const unsigned top = desc->crop_min[1], bottom = desc->crop_max[1];
  const uint64_t rows = bottom > top ? bottom - top : 0;
  if (rows < options->tile_count) {
    cli_complain("--tile is %u/%u, must be at most as many bands as there are rows, %u", options->tile_index,
                 options->tile_count, (unsigned)rows);
    return CLI_USAGE;
  }
  desc->crop_min[1] = top + (unsigned)(rows * (options->tile_index - 1) / options->tile_count);
  desc->crop_max[1] = top + (unsigned)(rows * options->tile_index / options->tile_count);
  return CLI_DONE;
}

/* ---- Frames ---- */

static double get_time_s(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* A frame that is done. */
typedef struct frame_facts {
  double seconds;
  neph_image_error error;
} frame_facts;

/* Most memory that the process has had so far. */
static double get_memory_bytes(void) {
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * (double)usage.ru_maxrss;
}

/* "2.6", "12", "0.04": shares as per cent, to two digits. */
static void print_percent(double share) {
  const double percent = 100.0 * share;
  printf(percent >= 9.95 || percent == 0.0 ? "%.0f" : percent >= 0.995 ? "%.1f" : "%.2g", percent);
}

static void print_memory(double bytes) {
  if (bytes >= 1e9)
    printf("%.1f GB", 1e-9 * bytes);
  else
    printf("%.0f MB", 1e-6 * bytes);
}

static void print_bias(const neph_image_error *error) {
  if (error->bias.value == 0.0) {
    printf("no bias)");
    return;
  }
  printf("bias about ");
  print_percent(error->bias.value);
  printf("%s%s)", isnan(error->error.value) ? " %" : "", error->bias_source == NEPH_BIAS_BY_MODEL ? " by model" : "");
}

/* "error 2.6 % a pixel (noise 1.1, bias about 2.4)" */
static void print_error(const neph_image_error *error) {
  if (isnan(error->bias.value)) return;
  printf("; error ");
  if (isnan(error->error.value)) {
    printf("unknown (noise unknown, ");
  } else {
    print_percent(error->error.value);
    printf(" %% a pixel (noise ");
    print_percent(error->noise.value);
    printf(", ");
  }
  print_bias(error);
}

static void print_json_bounded(const char *name, const neph_bounded *figure) {
  const struct {
    const char *ending;
    double value;
  } parts[] = {{"", figure->value}, {"_min", figure->min}, {"_max", figure->max}};
  for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
    if (isnan(parts[i].value))
      printf(", \"%s%s\": null", name, parts[i].ending);
    else
      printf(", \"%s%s\": %.4g", name, parts[i].ending, parts[i].value);
}

static void print_json_facts(const frame_facts *facts) {
  static const char *const sources[] = {"null", "\"model\"", "\"measured\""};
  printf(", \"seconds\": %.3f, \"memory_bytes\": %.0f", facts->seconds, get_memory_bytes());
  print_json_bounded("error", &facts->error.error);
  print_json_bounded("noise", &facts->error.noise);
  print_json_bounded("bias", &facts->error.bias);
  printf(", \"bias_source\": %s}\n", sources[facts->error.bias_source]);
}

static void print_frame(const render_job *job, const targets *t, const frame_facts *facts) {
  if (!job->session->options->is_json) {
    const char *const names[] = {t->image, t->preview, t->deep}, *join = "";
    printf("frame %d: ", job->desc.frame);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
      if (!names[i]) continue;
      printf("%s%s", join, names[i]);
      join = ", ";
    }
    printf(", %.2f s, ", facts->seconds);
    print_memory(get_memory_bytes());
    print_error(&facts->error);
    printf("\n");
    return;
  }
  printf("{\"frame\": %d", job->desc.frame);
  if (t->image) printf(", \"image\": "), cli_print_json_text(t->image);
  if (t->preview) printf(", \"preview\": "), cli_print_json_text(t->preview);
  if (t->deep) printf(", \"deep\": "), cli_print_json_text(t->deep);
  print_json_facts(facts);
}

static neph_result save_frame(const render_job *job, const neph_image *image, const targets *t) {
  neph_result result = NEPH_OK;
  if (t->image) result = neph_image_save_exr(image, t->image, job->output.pixel_type);
  if (!result && t->preview) result = neph_image_save_png(image, t->preview, &job->output.preview_desc);
  if (!result && t->deep) result = neph_image_save_deep_exr(image, t->deep, job->output.pixel_type);
  return result;
}

static cli_exit render_to(render_job *job, const targets *t) {
  neph_image *image = NULL;
  cli_progress *progress = &job->session->progress;
  double start_s = get_time_s();
  cli_progress_set_call(progress, 0.97);
  neph_result result = neph_render_image(job->scene, &job->desc, &image);
  if (!result) cli_progress_set_stage(progress, "writing", 0.97);
  if (!result) result = save_frame(job, image, t);
  if (!result) cli_progress_set_stage(progress, "writing", 1.0);
  cli_progress_finish(progress);
  frame_facts facts = {.seconds = get_time_s() - start_s, .error = NEPH_IMAGE_ERROR_DEFAULT};
  if (!result) result = neph_image_get_error(image, &facts.error);
  neph_image_destroy(image);
  if (!result) print_frame(job, t, &facts);
  fflush(stdout);
  return cli_exit_of(result);
}

static cli_exit explain(render_job *job) {
  char *text;
  neph_result result = neph_render_explain(job->scene, &job->desc, cli_text_format(job->session), &text);
  if (!result) cli_print_text(job->session, text);
  return cli_exit_of(result);
}

/* A dry run refuses all that a render refuses before its first pixel. */
static cli_exit rehearse(render_job *job, const targets *t) {
  char *text;
  neph_result result = neph_render_explain(job->scene, &job->desc, NEPH_TEXT_PLAIN, &text);
  if (result) return cli_exit_of(result);
  neph_text_destroy(job->session->context, text);
  if (t->image) printf("%s\n", t->image);
  if (t->preview) printf("%s\n", t->preview);
  if (t->deep) printf("%s\n", t->deep);
  return CLI_DONE;
}

static cli_exit render_frame(render_job *job) {
  const cli_options *options = job->session->options;
  if (options->wants_plan) return explain(job);
  targets t;
  cli_exit exit = cli_exit_of(name_targets(job, &t));
  if (!exit) exit = options->is_dry_run ? rehearse(job, &t) : render_to(job, &t);
  free_targets(job, &t);
  return exit;
}

/* Calls `step` for each picture of a frame. */
static cli_exit for_each_eye(render_job *job, cli_exit (*step)(render_job *job)) {
  if (!neph_scene_is_stereo(job->scene)) return step(job);
  cli_exit exit = CLI_DONE;
  for (neph_eye eye = NEPH_EYE_LEFT; !exit && eye <= NEPH_EYE_RIGHT; eye++) {
    job->desc.eye = eye;
    exit = cli_is_interrupted() ? CLI_INTERRUPTED : step(job);
  }
  return exit;
}

/* Calls `step` for each picture of each frame until one fails or the process is interrupted. */
static cli_exit for_each_frame(render_job *job, cli_exit (*step)(render_job *job)) {
  static const cli_frame_range only_first = {1, 1, 1};
  const cli_options *options = job->session->options;
  const cli_frame_range *ranges = options->frame_range_count ? options->frames : &only_first;
  const size_t count = options->frame_range_count ? options->frame_range_count : 1;
  cli_exit exit = CLI_DONE;
  for (size_t i = 0; i < count; i++)
    for (int64_t frame = ranges[i].first; !exit && frame <= ranges[i].last; frame += ranges[i].step) {
      job->desc.frame = (int)frame;
      exit = cli_is_interrupted() ? CLI_INTERRUPTED : for_each_eye(job, step);
    }
  return exit;
}

static cli_exit run(render_job *job) {
  const cli_options *options = job->session->options;
  choose_effort(job);
  cli_exit exit = choose_pixels(job);
  if (!exit && options->wants_plan) return for_each_frame(job, render_frame);
  if (!exit) exit = choose_outputs(job);
  if (!exit) choose_exposure(job);
  if (!exit) exit = check_pattern(job, job->output.image);
  if (!exit) exit = check_pattern(job, job->output.preview);
  if (!exit) exit = check_pattern(job, job->output.deep);
  if (!exit) exit = for_each_frame(job, check_targets);
  return exit ? exit : for_each_frame(job, render_frame);
}

static neph_result set_resolution(const cli_options *options, neph_scene *scene) {
  char value[32];
  if (!options->has_resolution) return NEPH_OK;
  snprintf(value, sizeof value, "[%u, %u]", options->resolution[0], options->resolution[1]);
  const neph_result result = neph_scene_set(scene, "camera.resolution", value);
  /* A wrong value of an option is the command line's fault, not the scene's. */
  return result == NEPH_ERROR_BAD_SCENE ? NEPH_ERROR_INVALID_ARGUMENT : result;
}

static cli_exit run_render(cli_session *session) {
  render_job job = {.session = session, .desc = NEPH_RENDER_DESC_DEFAULT, .output = NEPH_OUTPUT_DEFAULT};
  cli_exit exit = cli_load_scene(session, session->options->files[0], &job.scene);
  if (exit) return exit;
  neph_result result = set_resolution(session->options, job.scene);
  if (!result) result = neph_scene_get_render_desc(job.scene, &job.desc);
  if (!result) result = neph_scene_get_output(job.scene, &job.output);
  job.desc.progress = cli_progress_report;
  job.desc.progress_user = &session->progress;
  cli_catch_interrupts();
  exit = result ? cli_exit_of(result) : run(&job);
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
    .exits = CLI_MAY(CLI_BAD_SCENE) | CLI_MAY(CLI_NOT_FOUND) | CLI_MAY(CLI_LIMIT),
    .description = "Renders frames. The file names come from the scene's `output`; the last run of # in them is the "
                   "frame's number, and %V, of a stereo camera, the eye's name, left or right. Everything that can be "
                   "checked is checked before the first pixel: the scene, the "
                   "names, whether their folders can be written.",
    .options = {{"--output", "write to FILE, an .exr or a .png, or, given twice, one of each, and nothing else",
                 .files = "exr png"},
                {"--set"},
                {"--frames", "frames to render"},
                {"--resolution"},
                {"--crop"},
                {"--tile"},
                {"--samples"},
                {"--seed"},
                {"--integrator"},
                {"--path-guiding"},
                {"--target-error"},
                {"--time-limit"},
                {"--max-memory", "refuse, with exit code 6, a render that may need more"},
                {"--explain"},
                {"--dry-run"},
                {"--progress"}},
    .examples = {{"nephos render scene.yaml --frames 1-3x2", "render the frames 1 and 3"},
                 {"nephos render scene.yaml -o look.png --samples 1 --resolution 32x18", "render a small preview"},
                 {"nephos render scene.yaml --tile 2/4", "render the second of four bands, for a farm"},
                 {"nephos render scene.yaml --explain", "print the plan"}},
};

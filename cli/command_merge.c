/* SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "command_files.h"
#include "print.h"
#include "render_job.h"
#include "verbs.h"

/* Merges parts to a picture and, where `preview` is not NULL, a preview of it, in the pixel type of the parts. */
static neph_result merge_parts(cli_session *session, const char *const *parts, size_t count, const char *path,
                               const char *preview, const neph_preview_desc *desc) {
  neph_image *image = NULL;
  neph_preview_desc of_picture = *desc;
  neph_result result = neph_parts_merge(session->context, parts, count, &of_picture.pixel_type, &image);
  if (!result) result = neph_image_save_exr(image, path, of_picture.pixel_type);
  if (!result && preview) result = neph_image_save_png(image, preview, &of_picture);
  neph_image_destroy(image);
  if (result) return result;
  if (session->options->is_json) {
    printf("{\"image\": ");
    cli_print_json_text(path);
    if (preview) printf(", \"preview\": "), cli_print_json_text(preview);
    printf(", \"parts\": %zu}\n", count);
  } else
    cli_say("%s%s%s: merged from %zu part%s", path, preview ? ", " : "", preview ? preview : "", count,
            count == 1 ? "" : "s");
  return NEPH_OK;
}

/* ---- Parts given by name ---- */

/* Reads the outputs: one .exr, and at most one .png. */
static cli_exit read_outputs(const cli_session *session, const char **out_image, const char **out_preview) {
  const cli_options *options = session->options;
  bool is_placed = true;
  *out_image = *out_preview = NULL;
  for (size_t i = 0; i < options->output_count && is_placed; i++)
    is_placed = cli_place_output(options->outputs[i], ".exr", out_image, out_preview);
  if (is_placed && *out_image) return CLI_DONE;
  cli_complain("--output of nephos merge must be one .exr, or one and a .png");
  return CLI_USAGE;
}

static cli_exit check_no_frames(const cli_options *options) {
  if (!options->frame_range_count && !options->shard_count && !options->setting_count) return CLI_DONE;
  cli_complain("--frames, --tiles and --set go with a scene: nephos merge SCENE --frames LIST --tiles N");
  return CLI_USAGE;
}

static cli_exit merge_files(cli_session *session) {
  const cli_options *options = session->options;
  const char *image, *preview;
  const neph_preview_desc desc = NEPH_PREVIEW_DESC_DEFAULT;
  cli_exit exit = check_no_frames(options);
  if (!exit) exit = read_outputs(session, &image, &preview);
  if (!exit) exit = cli_check_target(session, image);
  if (!exit && preview) exit = cli_check_target(session, preview);
  if (!exit) exit = cli_files_check_output(session);
  return exit ? exit : cli_exit_of(merge_parts(session, options->files, options->file_count, image, preview, &desc));
}

/* ---- Tiles of a scene ---- */

/* Names of the picture's tiles, in order; the caller frees each by neph_text_destroy. */
static neph_result name_tiles(const render_job *job, char **names, unsigned count) {
  cli_options tiled = *job->session->options;
  cli_session session = {.options = &tiled, .context = job->session->context};
  render_job tile = *job;
  neph_result result = NEPH_OK;
  tile.session = &session;
  tiled.tile_count = count;
  tile.output.preview = tile.output.deep = NULL;
  for (unsigned i = 0; !result && i < count; i++) {
    render_targets t;
    tiled.tile_index = i + 1;
    result = render_job_name_targets(&tile, &t);
    names[i] = t.image;
  }
  return result;
}

static cli_exit merge_picture(render_job *job) {
  const unsigned count = job->session->options->shard_count;
  char **names = calloc(count, sizeof *names);
  render_targets whole;
  if (!names) return CLI_INTERNAL;
  neph_result result = render_job_name_targets(job, &whole);
  if (!result) result = name_tiles(job, names, count);
  if (!result)
    result = merge_parts(job->session, (const char *const *)names, count, whole.image, whole.preview,
                         &job->output.preview_desc);
  for (unsigned i = 0; i < count; i++) neph_text_destroy(job->session->context, names[i]);
  free(names);
  render_job_free_targets(job, &whole);
  fflush(stdout);
  return cli_exit_of(result);
}

static cli_exit add_picture(render_job *job) {
  const unsigned count = job->session->options->shard_count;
  char **names = calloc(count, sizeof *names);
  render_targets whole;
  if (!names) return CLI_INTERNAL;
  neph_result result = render_job_name_targets(job, &whole);
  if (!result) result = name_tiles(job, names, count);
  for (unsigned i = 0; !result && i < count; i++)
    result = neph_files_add(job->files, NEPH_FILE_READ, "a tile", names[i]);
  const cli_exit exit = result ? cli_exit_of(result) : render_job_add_targets(job, &whole);
  for (unsigned i = 0; i < count; i++) neph_text_destroy(job->session->context, names[i]);
  free(names);
  render_job_free_targets(job, &whole);
  return exit;
}

static cli_exit add_frame(render_job *job) { return render_job_for_each_eye(job, add_picture); }

static cli_exit check_files(render_job *job) {
  cli_exit exit = cli_files_begin(job->session, &job->files);
  if (!exit) exit = render_job_for_each_frame(job, add_frame);
  return cli_files_end(job->files, job->scene, exit);
}

/* Merges a frame. A frame without its tiles does not end a batch. */
static cli_exit merge_frame(render_job *job) {
  const cli_exit exit = render_job_for_each_eye(job, merge_picture);
  job->batch.count++;
  if (!exit) return CLI_DONE;
  job->batch.failures.count++;
  return cli_is_single_frame(job->session->options) ? exit : CLI_DONE;
}

static cli_exit merge_frames(render_job *job) {
  cli_exit exit = render_job_choose_outputs(job);
  if (exit) return exit;
  if (!job->output.image) {
    cli_complain("%s has no output.image: tiles are merged by it", job->session->options->files[0]);
    return CLI_USAGE;
  }
  render_job_choose_exposure(job, false);
  exit = check_files(job);
  if (exit) return exit;
  exit = render_job_for_each_frame(job, merge_frame);
  if (exit || !job->batch.failures.count) return exit;
  cli_complain("%u of %u frames were not merged", job->batch.failures.count, job->batch.count);
  return CLI_SOME_FAILED;
}

static cli_exit merge_scene(cli_session *session) {
  const cli_options *options = session->options;
  render_job job = {.session = session, .desc = NEPH_RENDER_DESC_DEFAULT, .output = NEPH_OUTPUT_DEFAULT};
  if (!options->shard_count || options->file_count != 1 || options->output_count) {
    cli_complain("to merge tiles of a scene: nephos merge SCENE --frames LIST --tiles N, without --output: the scene "
                 "names the pictures");
    return CLI_USAGE;
  }
  cli_exit exit = cli_load_scene(session, options->files[0], &job.scene);
  if (exit) return exit;
  neph_result result = neph_scene_get_render_desc(job.scene, &job.desc);
  if (!result) result = neph_scene_get_output(job.scene, &job.output);
  job.output.deep = NULL;
  exit = result ? cli_exit_of(result) : merge_frames(&job);
  neph_scene_destroy(job.scene);
  return exit;
}

/* Whether the argument is a scene: any file with --tiles, as in nephos render. */
static bool is_scene(const cli_options *options) {
  const char *first = options->files[0];
  const bool is_picture = cli_has_extension(first, ".exr") || cli_has_extension(first, ".npart");
  return cli_is_scene(first) || (options->shard_count && !is_picture);
}

static cli_exit run_merge(cli_session *session) {
  return is_scene(session->options) ? merge_scene(session) : merge_files(session);
}

const cli_verb cli_verb_merge = {
    .name = "merge",
    .arguments = "PART...|SCENE",
    .summary = "join tiles and ranges of samples to the bits of the whole picture",
    .argument_min = 1,
    .argument_max = (size_t)-1,
    .run = run_merge,
    .files = "npart exr yaml yml",
    .exits = CLI_MAY(CLI_BAD_SCENE) | CLI_MAY(CLI_NOT_FOUND) | CLI_MAY(CLI_SOME_FAILED),
    .description =
        "Joins parts of one picture: .npart files, which hold sums over samples, and .exr files of tiles. Every "
        "channel gets the bits that one render of the whole gives it. Parts of another scene, frame, seed, version or "
        "instruction-set level are refused by the hash in their headers, and so are parts that overlap. Where some are "
        "missing, the message lists them by tile and range of samples, and the exit code is 4.\n\n"
        "With a scene, its tiles are joined for each frame, by the names of output.image, and previews are written.",
    .options = {{"--output", "write the picture to FILE, an .exr, and, given twice, a preview, a .png",
                 .files = "exr png"},
                {"--frames", "frames of a scene to merge"},
                {"--tiles", "tiles that each frame of a scene was rendered in"},
                {"--set"},
                {"--path-mapping"}},
    .examples = {{"nephos merge frame.tile*.exr -o frame.exr -o frame.png", "join tiles, and write a preview"},
                 {"nephos merge frame.samples*.npart -o frame.exr", "join ranges of samples"},
                 {"nephos merge scene.yaml --frames 1-3 --tiles 2", "join the tiles of three frames"}},
};

/* SPDX-License-Identifier: Apache-2.0 */
/* The files of a frame: their names by the scene or --output, and their check before the first pixel. */
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "command_files.h"
#include "print.h"
#include "render_job.h"

/* Placeholder for the eye's name, as in Nuke. */
static const char eye_mark[] = "%V";

static cli_exit check_pattern(const render_job *job, const char *pattern) {
  if (pattern && neph_scene_is_stereo(job->scene) && !strstr(pattern, eye_mark)) {
    cli_progress_complain(&job->session->progress, "%s would be written for both eyes: put %s where left or right goes",
                          pattern, eye_mark);
    return CLI_USAGE;
  }
  if (!pattern || cli_is_single_frame(job->session->options) || neph_frame_is_numbered(pattern)) return CLI_DONE;
  cli_progress_complain(&job->session->progress, "%s would be written for every frame: put # where the number goes",
                        pattern);
  return CLI_USAGE;
}

/* Chooses the outputs: --output, given once or twice, replaces the scene's picture and preview. Deep pictures are named
 * in the scene alone.
 */
static cli_exit choose_outputs(render_job *job) {
  const cli_options *options = job->session->options;
  if (options->output_count) job->output.image = job->output.preview = NULL;
  for (size_t i = 0; i < options->output_count; i++) {
    const char *path = options->outputs[i];
    const bool is_part = cli_has_extension(path, ".npart");
    if (!cli_place_output(path, is_part ? ".npart" : ".exr", &job->output.image, &job->output.preview)) {
      cli_progress_complain(&job->session->progress,
                            "--output is %s, must be one .exr, one .png, or one of each; or a part, .npart", path);
      return CLI_USAGE;
    }
    if (options->has_sample_range && !is_part) {
      cli_progress_complain(&job->session->progress, "--output is %s, must be an .npart: --sample-range renders a part",
                            path);
      return CLI_USAGE;
    }
  }
  if (options->has_sample_range) job->output.preview = NULL;
  if (job->output.image || job->output.preview || job->output.deep) return CLI_DONE;
  cli_progress_complain(&job->session->progress, "%s names no output: give output.image in it, or --output",
                        options->files[0]);
  return CLI_USAGE;
}

static cli_exit check_preview(const render_job *job) {
  if (!job->output.preview || job->output.has_beauty) return CLI_DONE;
  cli_progress_complain(&job->session->progress,
                        "the preview %s shows R, G and B, and output.beauty: false leaves them out",
                        job->output.preview);
  return CLI_USAGE;
}

cli_exit render_job_choose_outputs(render_job *job) {
  cli_exit exit = choose_outputs(job);
  if (!exit) exit = check_preview(job);
  if (!exit) exit = check_pattern(job, job->output.image);
  if (!exit) exit = check_pattern(job, job->output.preview);
  return exit ? exit : check_pattern(job, job->output.deep);
}

/* The pattern with the eye's name in place of its mark; the caller frees it. NULL: no memory. */
static char *name_eye(const render_job *job, const char *pattern) {
  const char *mark = strstr(pattern, eye_mark);
  if (!mark || job->desc.eye == NEPH_EYE_CENTRE) return strdup(pattern);
  char *named;
  const int printed = asprintf(&named, "%.*s%s%s", (int)(mark - pattern), pattern,
                               job->desc.eye == NEPH_EYE_LEFT ? "left" : "right", mark + strlen(eye_mark));
  return printed < 0 ? NULL : named;
}

/* Output path, which the caller frees: the pattern, or, for a tile, "out/frame.####.tile2of4.exr", and for a range of
 * samples "out/frame.####.samples0to64.npart". NULL: no memory. */
static char *name_tile(const cli_options *options, const char *pattern) {
  const size_t length = strlen(pattern), ending = strlen(".exr");
  const bool is_whole = !options->tile_count && !options->has_sample_range;
  if (is_whole || options->output_count || length <= ending) return strdup(pattern);
  char tile[48] = "", range[48] = "", *named;
  const int stem = (int)(length - ending);
  if (options->tile_count) cli_print(tile, sizeof tile, ".tile%uof%u", options->tile_index, options->tile_count);
  if (options->has_sample_range)
    cli_print(range, sizeof range, ".samples%uto%u", options->sample_range[0], options->sample_range[1]);
  const int printed = asprintf(&named, "%.*s%s%s%s", stem, pattern, tile, range, *range ? ".npart" : pattern + stem);
  return printed < 0 ? NULL : named;
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

void render_job_free_targets(const render_job *job, render_targets *t) {
  neph_text_destroy(job->session->context, t->image);
  neph_text_destroy(job->session->context, t->preview);
  neph_text_destroy(job->session->context, t->deep);
  free(t->checkpoint);
  free(t->snapshot);
}

neph_result render_job_name_targets(const render_job *job, render_targets *out) {
  *out = (render_targets){.image = NULL};
  neph_result result = name_target(job, job->output.image, &out->image);
  if (!result) result = name_target(job, job->output.preview, &out->preview);
  if (!result) result = name_target(job, job->output.deep, &out->deep);
  return result;
}

/* Checks the file of a cloud. A cloud without a file on disk is baked to it before the first pixel. */
static cli_exit check_cloud(const render_job *job, unsigned index) {
  const char *pattern = neph_scene_get_cloud_file(job->scene, index);
  if (!pattern || !neph_scene_is_cloud_baked(job->scene, index)) return CLI_DONE;
  char *path;
  cli_exit exit = cli_exit_of(neph_frame_get_path(job->session->context, pattern, job->desc.frame, &path));
  const bool is_written = !exit && access(path, F_OK); /* an existing file is read */
  char role[32];
  cli_print(role, sizeof role, "clouds[%u].vdb", index);
  if (is_written) exit = cli_check_target(job->session, path);
  const neph_file_use use = is_written ? NEPH_FILE_WRITTEN : NEPH_FILE_READ;
  if (!exit) exit = cli_exit_of(neph_files_add_bake(job->files, use, role, job->scene, index, path));
  neph_text_destroy(job->session->context, path);
  return exit;
}

/* Adds a snapshot, unless its name is too long: it can never be written then, and the picture is rendered all the
 * same. */
static cli_exit add_snapshot(const render_job *job, const char *path) {
  if (!path || strlen(basename(path)) > NAME_MAX) return CLI_DONE;
  return cli_exit_of(neph_files_add(job->files, NEPH_FILE_WRITTEN, "the snapshot", path));
}

cli_exit render_job_add_targets(const render_job *job, const render_targets *t) {
  const struct { const char *key, *path; } rows[] = {{"output.image", t->image}, {"output.preview", t->preview}};
  cli_exit exit = CLI_DONE;
  for (size_t i = 0; !exit && i < sizeof rows / sizeof *rows; i++) {
    if (rows[i].path) exit = cli_check_target(job->session, rows[i].path);
    if (!exit) exit = cli_files_add_output(job->session, job->files, rows[i].key, rows[i].path);
  }
  if (!exit && t->deep) exit = cli_check_target(job->session, t->deep);
  if (!exit) exit = cli_exit_of(neph_files_add(job->files, NEPH_FILE_WRITTEN, "output.deep", t->deep));
  const char *checkpoint = t->is_part ? NULL : t->checkpoint;
  if (!exit && checkpoint) exit = cli_check_target(job->session, checkpoint);
  if (!exit) exit = cli_exit_of(neph_files_add(job->files, NEPH_FILE_WRITTEN, "the checkpoint", checkpoint));
  if (!exit) exit = cli_exit_of(neph_files_add_light(job->files, t->checkpoint));
  return exit ? exit : add_snapshot(job, t->snapshot);
}

/* Names that a configuration of OpenColorIO lacks are the scene's fault. */
static cli_exit check_view(const render_job *job) {
  const neph_result result = neph_preview_check(job->session->context, &job->output.preview_desc);
  return result == NEPH_ERROR_INVALID_ARGUMENT ? CLI_BAD_SCENE : cli_exit_of(result);
}

cli_exit render_job_check_targets(render_job *job) {
  render_targets t;
  neph_result result = render_job_name_targets(job, &t);
  if (!result) result = render_job_name_restart(job, &t);
  cli_exit exit = cli_exit_of(result);
  if (!exit) exit = render_job_add_targets(job, &t);
  if (!exit && t.preview) exit = check_view(job);
  for (unsigned i = 0; !exit && i < neph_scene_get_cloud_count(job->scene); i++) exit = check_cloud(job, i);
  render_job_free_targets(job, &t);
  return exit;
}

void render_job_choose_exposure(render_job *job, bool is_part) {
  neph_preview_desc *preview = &job->output.preview_desc;
  const bool is_of_sequence = job->output.preview && neph_frame_is_numbered(job->output.preview);
  const bool is_of_pair = neph_scene_is_stereo(job->scene) || job->desc.eye != NEPH_EYE_CENTRE;
  if (preview->exposure != NEPH_EXPOSURE_AUTO) return;
  job->matched = is_of_sequence ? "frames" : is_part ? "parts" : is_of_pair ? "eyes" : NULL;
  if (job->matched) preview->exposure = NEPH_EXPOSURE_METER;
}

/* SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cloud_target.h"
#include "command_files.h"
#include "export_textures.h"
#include "failures.h"
#include "print.h"
#include "verbs.h"

typedef struct export_job {
  cli_session *session;
  neph_scene *scene;
  neph_renderer *renderer;   /* one renderer for all frames */
  neph_exported_cloud *done; /* exported clouds, which own their paths */
  size_t count;
  neph_files *files;    /* table to which files are added; NULL: they are written */
  bool is_cloud_failed; /* the last failure was in reading or writing a cloud; other failures end the export */
  unsigned frame_count;
  cli_failures failures;
} export_job;

/* ---- Checks ---- */

static cli_exit check_outputs(cli_session *session, unsigned cloud_count) {
  const cli_options *options = session->options;
  const char *output = options->output_count ? options->outputs[0] : NULL;
  if (!cloud_count) {
    cli_complain("%s has no cloud", options->files[0]);
    return CLI_BAD_SCENE;
  }
  if (output &&
      (options->output_count > 1 || (!cli_is_folder(output) && (cloud_count > 1 || !cli_get_grid_ending(output))))) {
    cli_complain("--output of nephos export must be %s",
                 cloud_count == 1 ? "a .vdb, a .nvdb or a folder" : "a folder, for several clouds");
    return CLI_USAGE;
  }
  if (!options->usd_path) return CLI_DONE;
  if (output && cli_has_extension(output, ".nvdb")) {
    cli_complain("--usd refers to the clouds as .vdb, --output is %s: write a .vdb, or leave out --usd", output);
    return CLI_USAGE;
  }
  if (!cli_has_extension(options->usd_path, ".usda")) {
    cli_complain("--usd is %s, must be a .usda", options->usd_path);
    return CLI_USAGE;
  }
  return cli_check_target(session, options->usd_path);
}

/* ---- Clouds ---- */

/* Names of the grids beside the density. */
static void print_fields(const neph_exported_cloud *cloud, const char *before, const char *quote) {
  static const char *const names[] = {"vel", "Cd", "Ce", "temperature", "flame"};
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    if (!(cloud->fields >> i & 1u)) continue;
    printf("%s%s%s%s", before, quote, names[i], quote);
    before = ", ";
  }
}

static void print_done(const export_job *job, const neph_exported_cloud *cloud) {
  const double *a = cloud->bounds_min_m, *b = cloud->bounds_max_m;
  if (job->session->options->is_json) {
    printf("{\"cloud\": ");
    cli_print_json_text(cloud->name);
    printf(", \"file\": ");
    cli_print_json_text(cloud->path);
    printf(", \"frame\": %d, \"empty\": %s, \"bounds_m\": [[%.9g, %.9g, %.9g], [%.9g, %.9g, %.9g]], "
           "\"extinction_per_value\": %.9g, \"fields\": [",
           cloud->frame, cloud->is_empty ? "true" : "false", a[0], a[1], a[2], b[0], b[1], b[2],
           cloud->extinction_per_value);
    print_fields(cloud, "", "\"");
    printf("]}\n");
  } else if (cloud->is_empty) {
    cli_say("%s: empty in frame %d", cloud->name, cloud->frame);
  } else {
    cli_show(cloud->name);
    printf(": ");
    cli_show(cloud->path);
    printf(", %.4g x %.4g x %.4g m, extinction of a value of 1: %.9g 1/m", b[0] - a[0], b[1] - a[1], b[2] - a[2],
           cloud->extinction_per_value);
    print_fields(cloud, ", with ", "");
    printf("\n");
  }
  fflush(stdout);
}

/* Adds the file to which the cloud was baked, as one that is read if it exists. */
static cli_exit add_source(const export_job *job, unsigned cloud, int frame) {
  const char *pattern = neph_scene_get_cloud_file(job->scene, cloud);
  char *path, role[32];
  if (!pattern) return CLI_DONE;
  neph_result result = neph_frame_get_path(job->session->context, pattern, frame, &path);
  cli_print(role, sizeof role, "clouds[%u].vdb", cloud);
  if (!result && !access(path, F_OK))
    result = neph_files_add_bake(job->files, NEPH_FILE_READ, role, job->scene, cloud, path);
  neph_text_destroy(job->session->context, path);
  return cli_exit_of(result);
}

/* Adds the file of level `level` of detail, beside the cloud's own. */
static cli_exit add_level(const export_job *job, const char *role, const char *path, unsigned level) {
  const char *ending = cli_get_grid_ending(path);
  const size_t length = strlen(path) - strlen(ending);
  char *beside;
  if (asprintf(&beside, "%.*s.lod%u%s", (int)length, path, level, ending) < 0) return CLI_INTERNAL;
  const cli_exit exit = cli_files_add_output(job->session, job->files, role, beside);
  free(beside);
  return exit;
}

/* Adds the files of a cloud to the table. Takes ownership of `path`. */
static cli_exit add_path(const export_job *job, unsigned cloud, int frame, char *path) {
  const char *role = neph_scene_get_cloud_name(job->scene, cloud);
  cli_exit exit = add_source(job, cloud, frame);
  if (!exit) exit = cli_files_add_output(job->session, job->files, role, path);
  for (unsigned i = 1; !exit && i < job->session->options->level_count; i++) exit = add_level(job, role, path, i);
  free(path);
  return exit;
}

/* Exports a cloud to a path. Takes ownership of `path`, allocated by malloc. */
static cli_exit export_to(export_job *job, unsigned cloud, int frame, char *path) {
  const cli_options *options = job->session->options;
  neph_exported_cloud *grown = realloc(job->done, (job->count + 1) * sizeof *grown);
  if (!grown) return free(path), CLI_INTERNAL;
  job->done = grown;
  neph_exported_cloud *out = &job->done[job->count++];
  *out = (neph_exported_cloud)NEPH_EXPORTED_CLOUD_DEFAULT;
  out->path = path;
  cli_exit exit = cli_check_target(job->session, path);
  if (exit) return exit;
  neph_export_desc desc = NEPH_EXPORT_DESC_DEFAULT;
  desc.precision = options->is_half ? NEPH_PRECISION_HALF : NEPH_PRECISION_FLOAT;
  if (options->level_count) desc.level_count = options->level_count;
  desc.is_dry_run = options->is_dry_run;
  desc.renderer = job->renderer;
  desc.progress = cli_progress_report;
  desc.progress_user = &job->session->progress;
  neph_result result = neph_scene_export_cloud(job->scene, cloud, frame, &desc, path, out);
  cli_progress_finish(&job->session->progress);
  job->is_cloud_failed = result != NEPH_OK;
  if (result) free((char *)(uintptr_t)job->done[--job->count].path);
  if (!result && options->is_dry_run)
    cli_say("%s", path);
  else if (!result)
    print_done(job, out);
  return cli_exit_of(result);
}

/* Exports a cloud, or adds its file to the table. */
static cli_exit export_cloud(export_job *job, unsigned cloud, int frame) {
  const cli_options *options = job->session->options;
  char *pattern = cli_get_cloud_target(options, job->scene, cloud, false), *numbered = NULL;
  if (!pattern) return CLI_INTERNAL;
  cli_exit exit = CLI_DONE;
  if (!neph_frame_is_numbered(pattern) && !cli_is_single_frame(options)) {
    cli_complain("%s would be written for every frame: put # where the number goes", pattern);
    exit = CLI_USAGE;
  }
  if (!exit) exit = cli_exit_of(neph_frame_get_path(job->session->context, pattern, frame, &numbered));
  char *path = numbered ? strdup(numbered) : NULL;
  neph_text_destroy(job->session->context, numbered);
  free(pattern);
  if (exit || !path) return exit ? exit : CLI_INTERNAL;
  return job->files ? add_path(job, cloud, frame, path) : export_to(job, cloud, frame, path);
}

/* Exports a frame. A failure does not end a batch of frames. */
static cli_exit export_frame(export_job *job, int frame) {
  const unsigned count = neph_scene_get_cloud_count(job->scene);
  cli_exit exit = CLI_DONE;
  job->is_cloud_failed = false;
  job->frame_count++;
  for (unsigned i = 0; !exit && i < count; i++) exit = export_cloud(job, i, frame);
  const bool is_ended = !job->is_cloud_failed || exit == CLI_INTERRUPTED || cli_is_single_frame(job->session->options);
  if (!exit || is_ended) return exit;
  cli_failures_add(&job->failures, frame);
  return CLI_DONE;
}

static cli_exit save_usd(const export_job *job) {
  const cli_options *options = job->session->options;
  cli_exit exit = CLI_DONE;
  if (!options->usd_path || !job->count) return exit;
  if (!options->is_dry_run)
    exit = cli_exit_of(neph_scene_save_volumes_usd(job->scene, job->done, job->count, options->usd_path));
  if (!exit && !options->is_json) cli_say("%s", options->usd_path);
  return exit;
}

static cli_exit check_files(export_job *job) {
  cli_frame_walk walk = {0};
  cli_exit exit = cli_files_begin(job->session, &job->files);
  for (int frame; !exit && cli_next_frame(job->session->options, &walk, &frame);)
    for (unsigned i = 0; !exit && i < neph_scene_get_cloud_count(job->scene); i++) exit = export_cloud(job, i, frame);
  exit = cli_files_end(job->files, job->scene, exit);
  job->files = NULL;
  return exit;
}

static cli_exit export_frames(export_job *job) {
  cli_frame_walk walk = {0};
  cli_exit exit = check_outputs(job->session, neph_scene_get_cloud_count(job->scene));
  if (!exit) exit = check_files(job);
  for (int frame; !exit && cli_next_frame(job->session->options, &walk, &frame);) exit = export_frame(job, frame);
  if (!exit) exit = save_usd(job);
  if (exit || !job->failures.count) return exit;
  cli_failures_complain(&job->failures, &job->session->progress, job->frame_count, "");
  return CLI_SOME_FAILED;
}

/* Refuses options that only textures have. */
static cli_exit check_clouds_alone(const cli_options *options) {
  if (!options->texture_file && !options->texture_size) return CLI_DONE;
  cli_complain("%s of nephos export goes with --for textures", options->texture_file ? "--format" : "--size");
  return CLI_USAGE;
}

static cli_exit run_export(cli_session *session) {
  export_job job = {.session = session};
  cli_catch_interrupts();
  cli_exit exit = cli_load_scene(session, session->options->files[0], &job.scene);
  if (exit) return exit;
  if (session->options->export_use && !strcmp(session->options->export_use, "textures")) {
    exit = cli_export_textures(session, job.scene);
  } else {
    exit = check_clouds_alone(session->options);
    if (!exit) exit = cli_exit_of(neph_renderer_create(session->context, &job.renderer));
    if (!exit) exit = export_frames(&job);
  }
  for (size_t i = 0; i < job.count; i++) free((char *)(uintptr_t)job.done[i].path);
  free(job.done);
  neph_renderer_destroy(job.renderer);
  neph_scene_destroy(job.scene);
  return exit;
}

const cli_verb cli_verb_export = {
    .name = "export",
    .arguments = "SCENE",
    .summary = "write clouds of a scene, in their places: .vdb, .nvdb, .usda, textures",
    .argument_min = 1,
    .argument_max = 1,
    .run = run_export,
    .files = "yaml yml",
    .exits = CLI_MAY(CLI_BAD_SCENE) | CLI_MAY(CLI_NOT_FOUND) | CLI_MAY(CLI_LIMIT) | CLI_MAY(CLI_SOME_FAILED),
    .description = "Writes each cloud of a scene, read from its file or baked, as one fog volume `density`: in the "
                   "world's place, z up, in metres, its values the extinction in 1/m. Transforms, units, ramps, sums "
                   "of grids and repairs that the scene asks for are done. Velocities (`vel`) and colours (`Cd`) of "
                   "its file go with it, turned and in m/s, and, where the cloud has `emission`, `temperature` in K, "
                   "`flame` and emitted light (`Ce`) in the units of the keys' defaults. Files go by the cloud's name "
                   "and .vdb into the current folder. For textures, the folder FILE gets weather map, profile, "
                   "extinction, signed distance and six optical depths of each baked cloud, noises, blue noise, tables "
                   "of the sky, and textures.json, which says what each channel is.",
    .options = {{"--output", "write to FILE, a .vdb or .nvdb, where the scene has one cloud, or into the folder FILE",
                 .files = "vdb"},
                {"--for"},
                {"--format"},
                {"--size"},
                {"--usd", "write a layer with a Volume for each cloud to FILE, a .usda"},
                {"--set"},
                {"--path-mapping"},
                {"--frames", "export a file for each frame, its number in place of #"},
                {"--half", "write values as halves, scaled by a power of two, which is printed"},
                {"--levels", "write N levels of detail: beside cloud.vdb cloud.lod1.vdb, the whole cloud with voxels "
                             "twice as long, cloud.lod2.vdb, …"},
                {"--dry-run"},
                {"--progress"}},
    .examples = {{"nephos export clouds.yaml -o hero.vdb --usd hero.usda", "export the only cloud of a scene"},
                 {"nephos export clouds.yaml -o . --half", "export into a folder, in halves"},
                 {"nephos export clouds.yaml --for textures -o textures", "export textures for a game"}},
};

/* SPDX-License-Identifier: Apache-2.0 */
#include "export_textures.h"

#include <string.h>

#include "command_files.h"
#include "make_folder.h"
#include "print.h"

typedef struct texture_export {
  cli_session *session;
  const neph_scene *scene;
  neph_files *files; /* table to which files are added; NULL: they are written */
  cli_exit exit;     /* first failure while files are added */
} texture_export;

static cli_exit check(const cli_options *options) {
  const char *clouds_alone = options->usd_path      ? "--usd"
                             : options->is_half     ? "--half"
                             : options->level_count ? "--levels"
                                                    : NULL;
  if (clouds_alone) {
    cli_complain("%s of nephos export does not go with --for textures", clouds_alone);
    return CLI_USAGE;
  }
  if (options->output_count != 1) {
    cli_complain("--for textures needs one --output, a folder");
    return CLI_USAGE;
  }
  if (cli_is_single_frame(options) || neph_frame_is_numbered(options->outputs[0])) return CLI_DONE;
  cli_complain("%s would be written for every frame: put # where the number goes", options->outputs[0]);
  return CLI_USAGE;
}

/* ---- Textures ---- */

static void print_json(const neph_texture *texture) {
  printf("{\"texture\": ");
  cli_print_json_text(texture->name);
  printf(", \"file\": ");
  cli_print_json_text(texture->path);
  printf(", \"format\": \"%s\", \"size\": [%u, %u, %u], \"bytes\": %llu}\n", texture->texels, texture->size[0],
         texture->size[1], texture->size[2], (unsigned long long)texture->byte_count);
}

static void print_plain(const neph_texture *texture) {
  const unsigned *size = texture->size;
  cli_show(texture->path);
  if (!size[0])
    printf("\n");
  else if (size[2] == 1)
    printf(": %u x %u, %s, %llu bytes\n", size[0], size[1], texture->texels, (unsigned long long)texture->byte_count);
  else
    printf(": %u x %u x %u, %s, %llu bytes\n", size[0], size[1], size[2], texture->texels,
           (unsigned long long)texture->byte_count);
}

static void report(void *user, const neph_texture *texture) {
  texture_export *job = user;
  const cli_options *options = job->session->options;
  if (job->files) {
    if (!job->exit) job->exit = cli_files_add_output(job->session, job->files, texture->name, texture->path);
  } else if (options->is_dry_run) {
    cli_say("%s", texture->path);
  } else if (options->is_json) {
    print_json(texture);
  } else {
    print_plain(texture);
  }
}

/* Exports a frame, or adds its files to the table. */
static cli_exit export_frame(texture_export *job, int frame) {
  const cli_options *options = job->session->options;
  neph_textures_desc desc = NEPH_TEXTURES_DESC_DEFAULT;
  char *folder = NULL;
  bool is_made;
  cli_exit exit = cli_exit_of(neph_frame_get_path(job->session->context, options->outputs[0], frame, &folder));
  desc.is_dry_run = job->files || options->is_dry_run;
  if (options->texture_file && !strcmp(options->texture_file, "raw")) desc.format = NEPH_TEXTURE_RAW;
  if (options->texture_size) desc.size = options->texture_size;
  desc.report = report;
  desc.report_user = job;
  if (!desc.is_dry_run) desc.progress = cli_progress_report;
  desc.progress_user = &job->session->progress;
  if (!exit && !desc.is_dry_run && !cli_folder_make(folder, &is_made)) exit = CLI_IO;
  if (!exit) exit = cli_exit_of(neph_scene_export_textures(job->scene, frame, &desc, folder));
  if (!desc.is_dry_run) cli_progress_finish(&job->session->progress);
  neph_text_destroy(job->session->context, folder);
  return exit ? exit : job->exit;
}

static cli_exit check_files(texture_export *job) {
  cli_frame_walk walk = {0};
  cli_exit exit = cli_files_begin(job->session, &job->files);
  for (int frame; !exit && cli_next_frame(job->session->options, &walk, &frame);) exit = export_frame(job, frame);
  exit = cli_files_end(job->files, job->scene, exit);
  job->files = NULL;
  return exit;
}

cli_exit cli_export_textures(cli_session *session, const neph_scene *scene) {
  texture_export job = {.session = session, .scene = scene};
  cli_frame_walk walk = {0};
  cli_exit exit = check(session->options);
  if (!exit) exit = check_files(&job);
  for (int frame; !exit && cli_next_frame(session->options, &walk, &frame);) exit = export_frame(&job, frame);
  return exit;
}

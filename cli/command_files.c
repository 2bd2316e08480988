/* SPDX-License-Identifier: Apache-2.0 */
#include "command_files.h"

#include <string.h>

static cli_exit add(neph_files *files, neph_file_use use, const char *role, const char *path) {
  return cli_exit_of(neph_files_add(files, use, role, path));
}

static cli_exit add_options(const cli_options *options, neph_files *files) {
  const struct {
    const char *name, *path;
    neph_file_use use;
  } rows[] = {{"--machine", options->machine, options->is_calibrating ? NEPH_FILE_WRITTEN : NEPH_FILE_READ},
              {"--path-mapping", options->path_mapping, NEPH_FILE_READ},
              {"--reference", options->reference, NEPH_FILE_READ},
              {"--second", options->second, NEPH_FILE_READ},
              {"--usd", options->usd_path, NEPH_FILE_WRITTEN},
              {"--log", options->log_path, NEPH_FILE_WRITTEN}};
  cli_exit exit = CLI_DONE;
  for (size_t i = 0; !exit && i < sizeof rows / sizeof *rows; i++)
    exit = add(files, rows[i].use, rows[i].name, rows[i].path);
  return exit;
}

cli_exit cli_files_begin(const cli_session *session, neph_files **out_files) {
  const cli_options *options = session->options;
  cli_exit exit = cli_exit_of(neph_files_create(session->context, out_files));
  for (size_t i = 0; !exit && i < options->file_count; i++)
    if (strcmp(options->files[i], "-"))
      exit = add(*out_files, NEPH_FILE_READ, cli_is_scene(options->files[i]) ? "the scene" : "an argument",
                 options->files[i]);
  return exit ? exit : add_options(options, *out_files);
}

cli_exit cli_files_add_output(const cli_session *session, neph_files *files, const char *key, const char *path) {
  return add(files, NEPH_FILE_WRITTEN, session->options->output_count ? "--output" : key, path);
}

cli_exit cli_files_end(neph_files *files, const neph_scene *scene, cli_exit exit) {
  if (!exit && scene) exit = cli_exit_of(neph_files_add_scene(files, scene));
  if (!exit) exit = cli_exit_of(neph_files_check(files));
  neph_files_destroy(files);
  return exit;
}

cli_exit cli_files_check_output(const cli_session *session) {
  neph_files *files;
  cli_exit exit = cli_files_begin(session, &files);
  for (size_t i = 0; !exit && i < session->options->output_count; i++)
    exit = cli_files_add_output(session, files, "--output", session->options->outputs[i]);
  return cli_files_end(files, NULL, exit);
}

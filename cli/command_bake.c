/* SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "session.h"

static unsigned count_baked(const neph_scene *scene) {
  unsigned count = 0;
  for (unsigned i = 0; i < neph_scene_get_cloud_count(scene); i++) count += neph_scene_is_cloud_baked(scene, i);
  return count;
}

static bool is_folder(const char *path) {
  struct stat status;
  size_t length = strlen(path);
  return (length && path[length - 1] == '/') || (!stat(path, &status) && S_ISDIR(status.st_mode));
}

static cli_exit check_output(const cli_options *options, unsigned baked_count) {
  if (!baked_count) {
    cli_complain("%s bakes no cloud", options->files[0]);
    return CLI_BAD_SCENE;
  }
  if (!options->output_count) return CLI_DONE;
  const char *output = options->outputs[0];
  if (options->output_count == 1 && (is_folder(output) || (baked_count == 1 && cli_has_extension(output, ".vdb"))))
    return CLI_DONE;
  cli_complain("--output of nephos bake must be %s",
               baked_count == 1 ? "one .vdb or a folder" : "a folder, for several clouds");
  return CLI_USAGE;
}

/* To be freed: where --output says, else the cloud's own file, else NAME.vdb. NULL: no memory. */
static char *choose_path(const cli_session *session, const neph_scene *scene, unsigned index) {
  const cli_options *options = session->options;
  const char *name = neph_scene_get_cloud_name(scene, index), *file = neph_scene_get_cloud_file(scene, index);
  const char *output = options->output_count ? options->outputs[0] : NULL;
  if (output && !is_folder(output)) return strdup(output);
  if (!output && file) return strdup(file);
  const char *slash = output && output[strlen(output) - 1] != '/' ? "/" : "";
  char *path = NULL;
  return asprintf(&path, "%s%s%s.vdb", output ? output : "", slash, name) < 0 ? NULL : path;
}

static void print_done(const cli_session *session, const char *name, const char *path, double seconds) {
  if (!session->options->is_json) {
    printf("%s: %s, %.2f s\n", name, path, seconds);
    return;
  }
  printf("{\"cloud\": ");
  cli_print_json_text(name);
  printf(", \"file\": ");
  cli_print_json_text(path);
  printf(", \"seconds\": %.3f}\n", seconds);
}

static double get_time_s(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static cli_exit bake_cloud(cli_session *session, neph_scene *scene, unsigned index, const char *path) {
  cli_exit exit = cli_check_target(path);
  if (exit) return exit;
  if (session->options->is_dry_run) return printf("%s\n", path), CLI_DONE;
  double start_s = get_time_s();
  neph_result result = neph_scene_bake_file(scene, index, path, cli_progress_report, &session->progress);
  cli_progress_finish(&session->progress);
  if (!result) print_done(session, neph_scene_get_cloud_name(scene, index), path, get_time_s() - start_s);
  fflush(stdout);
  return cli_exit_of(result);
}

static cli_exit bake_clouds(cli_session *session, neph_scene *scene) {
  cli_exit exit = check_output(session->options, count_baked(scene));
  for (unsigned i = 0; !exit && i < neph_scene_get_cloud_count(scene); i++) {
    if (!neph_scene_is_cloud_baked(scene, i)) continue;
    char *path = choose_path(session, scene, i);
    exit = path ? bake_cloud(session, scene, i, path) : CLI_INTERNAL;
    free(path);
  }
  return exit;
}

cli_exit cli_command_bake(cli_session *session) {
  neph_scene *scene;
  cli_exit exit = cli_load_scene(session, session->options->files[0], &scene);
  if (exit) return exit;
  cli_catch_interrupts();
  exit = bake_clouds(session, scene);
  neph_scene_destroy(scene);
  return exit;
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "cloud_target.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

bool cli_is_folder(const char *path) {
  struct stat status;
  size_t length = strlen(path);
  return (length && path[length - 1] == '/') || (!stat(path, &status) && S_ISDIR(status.st_mode));
}

const char *cli_get_grid_ending(const char *path) {
  static const char *const endings[] = {".vdb", ".nvdb"};
  for (size_t i = 0; i < sizeof endings / sizeof *endings; i++)
    if (cli_has_extension(path, endings[i])) return endings[i];
  return NULL;
}

char *cli_get_cloud_target(const cli_options *options, const neph_scene *scene, unsigned cloud, bool is_own_file) {
  const char *name = neph_scene_get_cloud_name(scene, cloud);
  const char *file = is_own_file ? neph_scene_get_cloud_file(scene, cloud) : NULL;
  const char *output = options->output_count ? options->outputs[0] : NULL;
  if (output && !cli_is_folder(output)) return strdup(output);
  if (!output && file) return strdup(file);
  const char *slash = output && output[strlen(output) - 1] != '/' ? "/" : "";
  const char *number = cli_is_single_frame(options) ? "" : ".####";
  char *path = NULL;
  return asprintf(&path, "%s%s%s%s.vdb", output ? output : "", slash, name, number) < 0 ? NULL : path;
}

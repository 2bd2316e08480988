/* SPDX-License-Identifier: Apache-2.0 */
#include "bake_map.h"

#include <stdlib.h>
#include <string.h>

#include "cloud_target.h"
#include "print.h"

static unsigned count_maps(const neph_scene *scene) {
  unsigned count = 0;
  for (unsigned i = 0; i < neph_scene_get_cloud_count(scene); i++) count += neph_scene_get_cloud_map(scene, i) != NULL;
  return count;
}

cli_exit cli_maps_check(const cli_session *session, const neph_scene *scene) {
  const char *path = session->options->preview_map;
  const unsigned count = path ? count_maps(scene) : 0;
  if (!path) return CLI_DONE;
  if (!count) {
    cli_complain("--preview-map shows a weather map, and %s bakes no cloud with one: give clouds[].bake.map a picture, "
                 "or leave the option out",
                 session->options->files[0]);
    return CLI_BAD_SCENE;
  }
  if (cli_is_folder(path) || (count == 1 && cli_has_extension(path, ".png"))) return CLI_DONE;
  cli_complain("--preview-map is %s, must be %s", path,
               count == 1 ? "one .png or a folder" : "a folder, for several clouds with a map");
  return CLI_USAGE;
}

/* Pattern of the names of maps, with # where there are several frames; the caller frees it. NULL: no memory. */
static char *make_pattern(const cli_options *options, const char *name) {
  const char *output = options->preview_map, *number = cli_is_single_frame(options) ? "" : ".####";
  char *pattern = NULL;
  if (!cli_is_folder(output)) return strdup(output);
  const char *slash = output[strlen(output) - 1] == '/' ? "" : "/";
  return asprintf(&pattern, "%s%s%s.map%s.png", output, slash, name, number) < 0 ? NULL : pattern;
}

static void print_json_pair(const char *key, const double values[2]) {
  printf(", \"%s\": [%.9g, %.9g]", key, values[0], values[1]);
}

static void print_json_map(const char *name, const char *path, const neph_map_picture *picture) {
  printf("{\"cloud\": ");
  cli_print_json_text(name);
  printf(", \"map_preview\": ");
  cli_print_json_text(path);
  printf(", \"panel\": [%u, %u], \"gap\": %u, \"pixel_m\": %.9g", picture->panel_width, picture->panel_height,
         picture->gap, picture->pixel_m);
  print_json_pair("panel_min_m", picture->panel_min_m);
  print_json_pair("panel_max_m", picture->panel_max_m);
  print_json_pair("field_min_m", picture->field_min_m);
  print_json_pair("field_max_m", picture->field_max_m);
  print_json_pair("painted_min_m", picture->painted_min_m);
  print_json_pair("painted_max_m", picture->painted_max_m);
  for (unsigned i = 0; i < picture->panel_count; i++)
    printf("%s\"%s\"", i ? ", " : ", \"quantities\": [", picture->quantities[i]);
  printf("]}\n");
}

static void print_box(const char *meaning, const double min_m[2], const double max_m[2]) {
  printf("  %-9sx %.9g to %.9g m, y %.9g to %.9g m\n", meaning, min_m[0], max_m[0], min_m[1], max_m[1]);
}

static void print_map(const char *name, const char *path, const neph_map_picture *picture) {
  printf("%s: %s, the weather map from above, north up, pixels of %.4g m; ", name, path, picture->pixel_m);
  for (unsigned i = 0; i < picture->panel_count; i++) printf("%s%s", i ? ", " : "", picture->quantities[i]);
  printf("%s\n", picture->panel_count > 1 ? ", from the left" : "");
  print_box("field", picture->field_min_m, picture->field_max_m);
  print_box("picture", picture->painted_min_m, picture->painted_max_m);
}

static cli_exit save_map(cli_session *session, neph_scene *scene, unsigned cloud, int frame, const char *path) {
  const bool is_dry_run = session->options->is_dry_run;
  const char *name = neph_scene_get_cloud_name(scene, cloud);
  neph_map_picture picture = NEPH_MAP_PICTURE_DEFAULT;
  cli_exit exit = cli_check_target(session, path);
  if (!exit) exit = cli_exit_of(neph_scene_save_map(scene, cloud, frame, is_dry_run ? NULL : path, &picture));
  if (exit) return exit;
  if (is_dry_run)
    cli_say("%s", path);
  else if (session->options->is_json)
    print_json_map(name, path, &picture);
  else
    print_map(name, path, &picture);
  fflush(stdout);
  return CLI_DONE;
}

static cli_exit take_frame(cli_session *session, neph_scene *scene, unsigned cloud, int frame, neph_files *files) {
  char *pattern = make_pattern(session->options, neph_scene_get_cloud_name(scene, cloud)), *path = NULL;
  cli_exit exit = pattern ? CLI_DONE : CLI_INTERNAL;
  if (!exit && !neph_frame_is_numbered(pattern) && !cli_is_single_frame(session->options)) {
    cli_complain("%s would be written for every frame: put # where the number goes", pattern);
    exit = CLI_USAGE;
  }
  if (!exit) exit = cli_exit_of(neph_frame_get_path(session->context, pattern, frame, &path));
  if (!exit && files)
    exit = cli_exit_of(neph_files_add(files, NEPH_FILE_WRITTEN, "--preview-map", path));
  else if (!exit)
    exit = save_map(session, scene, cloud, frame, path);
  if (path) neph_text_destroy(session->context, path);
  free(pattern);
  return exit;
}

/* `files` NULL saves the pictures; otherwise their names are added to it. */
static cli_exit walk_maps(cli_session *session, neph_scene *scene, neph_files *files) {
  cli_frame_walk walk = {0};
  cli_exit exit = CLI_DONE;
  if (!session->options->preview_map) return CLI_DONE;
  for (int frame; !exit && cli_next_frame(session->options, &walk, &frame);)
    for (unsigned i = 0; !exit && i < neph_scene_get_cloud_count(scene); i++)
      if (neph_scene_get_cloud_map(scene, i)) exit = take_frame(session, scene, i, frame, files);
  return exit;
}

cli_exit cli_maps_add_files(cli_session *session, neph_scene *scene, neph_files *files) {
  return walk_maps(session, scene, files);
}

cli_exit cli_maps_save(cli_session *session, neph_scene *scene) { return walk_maps(session, scene, NULL); }

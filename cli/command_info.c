/* SPDX-License-Identifier: Apache-2.0 */
#include "print.h"
#include "verbs.h"

static cli_exit describe_scene(cli_session *session, const char *path, char **out_text) {
  neph_scene *scene;
  cli_exit exit = cli_load_scene(session, path, &scene);
  if (exit) return exit;
  neph_result result = neph_scene_describe(scene, cli_text_format(session), out_text);
  neph_scene_destroy(scene);
  return cli_exit_of(result);
}

typedef neph_result (*describe_fn)(neph_context *context, const char *path, neph_text_format format, char **out_text);

/* Chooses the description of a file by its ending. A PNG is described as a height field. */
static describe_fn choose_describer(const char *path) {
  static const struct {
    const char *extension;
    describe_fn describe;
  } kinds[] = {
      {".vdb", neph_volume_describe_file},  {".nvdb", neph_volume_describe_file}, {".png", neph_terrain_describe_file},
      {".hgt", neph_terrain_describe_file}, {".tif", neph_terrain_describe_file}, {".tiff", neph_terrain_describe_file},
      {".asc", neph_terrain_describe_file}, {".bil", neph_terrain_describe_file}, {".flt", neph_terrain_describe_file},
      {".dem", neph_terrain_describe_file}, {".img", neph_terrain_describe_file}, {".dt0", neph_terrain_describe_file},
      {".nc", neph_volume_describe_file},   {".dt1", neph_terrain_describe_file}, {".dt2", neph_terrain_describe_file},
      {".vrt", neph_terrain_describe_file}, {".zip", neph_terrain_describe_file}, {".exr", neph_image_describe_file}};
  for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
    if (cli_has_extension(path, kinds[i].extension)) return kinds[i].describe;
  return NULL;
}

static cli_exit describe_file(cli_session *session, const char *path, char **out_text) {
  describe_fn describe = choose_describer(path);
  if (describe) return cli_exit_of(describe(session->context, path, cli_text_format(session), out_text));
  if (cli_is_scene(path)) return describe_scene(session, path, out_text);
  cli_complain(
      "%s has an unknown ending, must end in .vdb, .nvdb, .nc, .hgt, .tif, .asc, .bil, .flt, .dem, .img, .dt2, "
      ".vrt, .zip, .exr, .png or .yaml",
      path);
  return CLI_USAGE;
}

/* Describes every file that can be read; the first failure gives the exit code. */
static cli_exit run_info(cli_session *session) {
  const cli_options *options = session->options;
  bool is_list = options->file_count > 1;
  cli_exit exit = CLI_DONE;
  size_t printed_count = 0;
  if (options->is_json && is_list) printf("[\n");
  for (size_t i = 0; i < options->file_count; i++) {
    char *text;
    cli_exit file_exit = describe_file(session, options->files[i], &text);
    if (!exit) exit = file_exit;
    if (file_exit) continue;
    if (printed_count++ && is_list) printf(options->is_json ? ",\n" : "\n");
    if (is_list && !options->is_json) printf("== %s ==\n", options->files[i]);
    cli_print_text(session, text);
  }
  if (options->is_json && is_list) printf("]\n");
  return exit;
}

const cli_verb cli_verb_info = {
    .name = "info",
    .arguments = "FILE...",
    .summary = "describe .vdb, .nvdb, .nc, height-field, .exr, .png and scene files",
    .argument_min = 1,
    .argument_max = SIZE_MAX,
    .run = run_info,
    .files = "vdb nvdb nc hgt tif asc bil flt dem img dt0 dt1 dt2 vrt zip exr png yaml yml",
    .exits = CLI_MAY(CLI_BAD_SCENE) | CLI_MAY(CLI_NOT_FOUND),
    .description =
        "Describes files, by their endings: .vdb and .nvdb grids, models' fields (.nc), height fields (.hgt, .png, "
        "GeoTIFF and other "
        "rasters), .exr pictures, scenes. Of a scene it prints every key with its value, defaults and presets "
        "resolved, each as --set takes it. The exit code is that of the first file that fails.",
    .options = {{"--set"}, {"--frame"}},
    .examples = {{"nephos info low.vdb frame.exr", "describe a cloud and a picture"},
                 {"nephos info scene.yaml --frame 57", "print a scene as it is in a frame"},
                 {"nephos info scene.yaml --set camera.fov=30", "print a scene with a key changed"}},
};

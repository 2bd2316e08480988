/* SPDX-License-Identifier: Apache-2.0 */
#include "command_files.h"
#include "print.h"
#include "verbs.h"

/* Checks a scene. Errors of the scene and its settings become findings; other failures fail. */
static neph_result check_scene(cli_session *session, neph_check *check, const char *path) {
  const cli_options *options = session->options;
  neph_scene *scene = NULL;
  neph_result result = neph_check_set_file(check, path[0] == '-' && !path[1] ? "standard input" : path);
  if (!result) result = cli_read_scene(session, path, &scene);
  if (result == NEPH_ERROR_OUT_OF_MEMORY || result == NEPH_ERROR_CANCELLED) return result;
  if (!scene && neph_check_is_file(path)) return neph_check_file(check, path);
  result = scene ? neph_check_scene(check, scene, options->has_frame ? options->frame : 1) : NEPH_OK;
  neph_scene_destroy(scene);
  return result;
}

static cli_exit check_names(const cli_options *options) {
  size_t scene_count = 0;
  for (size_t i = 0; i < options->file_count; i++) {
    scene_count += cli_is_scene(options->files[i]);
    if (!cli_is_scene(options->files[i]) && !neph_check_is_file(options->files[i])) {
      cli_complain(
          "%s has an unknown ending, must end in .vdb, .nvdb, .nc, .hgt, .tif, .asc, .bil, .flt, .dem, .img, "
          ".dt2, .vrt, .zip, .r16, .raw, .exr, .png, .csv, .chan, .gltf, .glb, .obj, .ply, .stl, .fbx, .dae or .yaml",
          options->files[i]);
      return CLI_USAGE;
    }
  }
  if (scene_count || (!options->setting_count && !options->has_frame)) return CLI_DONE;
  cli_complain("%s of nephos check goes with a scene, and none is given", options->has_frame ? "--frame" : "--set");
  return CLI_USAGE;
}

/* Whether the file and the output both have an ending. */
static bool has_ending(const cli_options *options, const char *ending) {
  return cli_has_extension(options->outputs[0], ending) && cli_has_extension(options->files[0], ending);
}

static cli_exit check_fix(const cli_session *session) {
  const cli_options *options = session->options;
  if (!options->is_fixed && !options->output_count) return CLI_DONE;
  const bool is_one = options->output_count == 1 && options->file_count == 1 &&
                      (has_ending(options, ".vdb") || has_ending(options, ".nvdb"));
  if (options->is_fixed && is_one) {
    const cli_exit exit = cli_check_target(session, options->outputs[0]);
    return exit ? exit : cli_files_check_output(session);
  }
  cli_complain(options->is_fixed ? "--fix of nephos check takes one .vdb or .nvdb, and --output for its mended copy, "
                                   "of the same ending"
                                 : "--output of nephos check goes with --fix");
  return CLI_USAGE;
}

static neph_result check_files(cli_session *session, neph_check *check) {
  const cli_options *options = session->options;
  neph_result result = NEPH_OK;
  for (size_t i = 0; !result && i < options->file_count; i++)
    result = cli_is_scene(options->files[i]) ? check_scene(session, check, options->files[i])
                                             : neph_check_file(check, options->files[i]);
  return result;
}

/* Prints the findings. */
static cli_exit report(cli_session *session, neph_check *check) {
  char *text;
  const neph_result result = neph_check_describe(check, cli_text_format(session), &text);
  if (result) return cli_exit_of(result);
  cli_print_text(session, text);
  return neph_check_count(check, NEPH_SEVERITY_ERROR) + neph_check_count(check, NEPH_SEVERITY_WARNING) ? CLI_DIFFERENT
                                                                                                       : CLI_DONE;
}

static cli_exit mend(const cli_session *session) {
  const cli_options *options = session->options;
  char *changes;
  const neph_result result = neph_check_mend_file(session->context, options->files[0], options->outputs[0], &changes);
  if (!result && !options->is_json)
    printf("%s: mended copy of %s\n%s", options->outputs[0], options->files[0], changes);
  neph_text_destroy(session->context, changes);
  return cli_exit_of(result);
}

static bool goes_on(void *user, const neph_progress *progress) {
  (void)user, (void)progress;
  return !cli_is_interrupted();
}

static cli_exit run_check(cli_session *session) {
  cli_exit exit = check_names(session->options);
  if (!exit) exit = check_fix(session);
  if (exit) return exit;
  neph_check *check;
  neph_result result = neph_check_create(session->context, &check);
  if (result) return cli_exit_of(result);
  cli_catch_interrupts();
  neph_check_set_progress(check, goes_on, NULL);
  result = check_files(session, check);
  exit = result ? cli_exit_of(result) : report(session, check);
  neph_check_destroy(check);
  if (session->options->is_fixed && (!exit || exit == CLI_DIFFERENT)) return mend(session);
  return exit;
}

const cli_verb cli_verb_check = {
    .name = "check",
    .arguments = "FILE...",
    .summary = "look for faults in clouds, sequences, height fields and scenes",
    .argument_min = 1,
    .argument_max = SIZE_MAX,
    .run = run_check,
    .files =
        "vdb nvdb nc hgt tif tiff asc bil flt dem img dt0 dt1 dt2 vrt zip r16 raw exr png csv chan gltf glb obj ply "
        "stl fbx yaml yml",
    .exits = CLI_MAY(CLI_DIFFERENT) | CLI_MAY(CLI_NOT_FOUND),
    .description =
        "Reads files, by their endings, and lists their faults: a render refuses an error, a warning may be "
        "unintended, a note is worth knowing. Each line has the file, the severity, the grid, the cause, the place, "
        "behind an arrow the key or option that repairs it, and the name of the rule. A .vdb name "
        "with #### is a sequence: all its files are read, and compared from frame to frame. A scene is checked with "
        "all that it names, all errors at once.\n\n"
        "With --fix a copy of a .vdb or .nvdb is written whose values a cloud can have, and what has changed in each "
        "grid is printed; of a sequence, with #### in both names, each file is.\n\n"
        "The exit code is 7 where there are errors or warnings.",
    .options = {{"--fix"},
                {"--output", "write the mended copy to FILE, a .vdb or .nvdb", .files = "vdb nvdb"},
                {"--set"},
                {"--frame"},
                {"--cache"},
                {"--path-mapping"}},
    .examples = {{"nephos check low.vdb", "check a cloud"},
                 {"nephos check scene.yaml", "check a scene with all its files"},
                 {"nephos check low.vdb --fix -o mended.vdb", "write a copy with its values mended"}},
};

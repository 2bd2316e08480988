/* SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "command_files.h"
#include "print.h"
#include "verbs.h"

static cli_exit check_output(const cli_session *session) {
  const cli_options *options = session->options;
  if (!options->output_count) return CLI_DONE;
  if (options->output_count == 1 && cli_has_extension(options->outputs[0], ".exr"))
    return cli_check_target(session, options->outputs[0]);
  cli_complain("--output of nephos sky must be one .exr");
  return CLI_USAGE;
}

/* Checks the options of a USD layer, which needs a picture to name. */
static cli_exit check_usd(const cli_session *session) {
  const cli_options *options = session->options;
  if (!options->usd_path) return CLI_DONE;
  if (!cli_has_extension(options->usd_path, ".usda") || !options->output_count) {
    cli_complain(options->output_count ? "--usd is %s, must be a .usda" : "--usd %s needs --output, the dome's picture",
                 options->usd_path);
    return CLI_USAGE;
  }
  return cli_check_target(session, options->usd_path);
}

/* Chooses the sun's disk: a layer has the sun as a light of its own, so its picture has no disk unless an option says
 * so. */
static neph_sky_disks choose_disks(const cli_options *options) {
  const char *disks = options->disks ? options->disks : options->usd_path ? "none" : "include";
  if (!strcmp(disks, "layer")) return NEPH_SKY_DISKS_LAYER;
  return !strcmp(disks, "none") ? NEPH_SKY_DISKS_NONE : NEPH_SKY_DISKS_INCLUDE;
}

/* The picture's name relative to the layer's folder; its name alone where the folders differ. */
static const char *get_texture(const cli_options *options) {
  const char *picture = options->outputs[0], *layer = options->usd_path;
  const char *picture_end = strrchr(picture, '/'), *layer_end = strrchr(layer, '/');
  const size_t folder = picture_end ? (size_t)(picture_end - picture) + 1 : 0;
  const size_t layer_folder = layer_end ? (size_t)(layer_end - layer) + 1 : 0;
  return folder == layer_folder && !strncmp(picture, layer, folder) ? picture + folder : picture;
}

/* Folder, name and ending joined to a path; the caller frees it. NULL: no memory. */
static char *join_path(const char *folder, const char *name, const char *ending) {
  char *path;
  return asprintf(&path, "%s/%s%s", folder, name, ending) < 0 ? NULL : path;
}

static void print_plain(const char *label, const char *values, const char *bands, const char *space) {
  printf("%-15s %s W/m2/nm %s %s\n", label, values, bands ? "at" : "in", bands ? bands : space);
}

/* Prints the next three numbers of an attribute, separated by spaces, as a JSON array. Returns the rest. */
static const char *print_triple(const char *values) {
  char *rest;
  double first = strtod(values, &rest), second = strtod(rest, &rest), third = strtod(rest, &rest);
  printf("[%.9g, %.9g, %.9g]", first, second, third);
  return rest;
}

static void print_json(const char *name, const char *values) {
  printf("\"%s\": ", name);
  print_triple(values);
}

enum { HARMONICS = 9 };

static void print_harmonics(const cli_session *session, const char *values) {
  static const char *const names[HARMONICS] = {"1", "y", "z", "x", "xy", "yz", "3z2-1", "xz", "x2-y2"};
  if (session->options->is_json) printf(", \"sky_harmonics\": [");
  for (int i = 0; i < HARMONICS; i++) {
    if (session->options->is_json) {
      if (i) printf(", ");
      values = print_triple(values);
      continue;
    }
    char *rest;
    double first = strtod(values, &rest), second = strtod(rest, &rest), third = strtod(rest, &rest);
    printf("harmonic %-6s %.6g %.6g %.6g\n", names[i], first, second, third);
    values = rest;
  }
  if (session->options->is_json) printf("]");
}

static void print_irradiances(const cli_session *session, const neph_image *image) {
  const char *sun = neph_image_get_attribute(image, "nephos:sunIrradiance");
  const char *sky = neph_image_get_attribute(image, "nephos:skyIrradiance");
  const char *bands = neph_image_get_attribute(image, "nephos:bands");
  const char *space = neph_image_get_attribute(image, "nephos:colorSpace");
  const char *harmonics = neph_image_get_attribute(image, "nephos:skyHarmonics");
  const bool has_air = sun && sky;
  if (session->options->is_json) {
    printf("{\"color_space\": ");
    cli_print_json_text(space);
    if (has_air) printf(", ");
    if (has_air) print_json("sun_irradiance_w_m2_nm", sun);
    if (has_air) printf(", ");
    if (has_air) print_json("sky_irradiance_w_m2_nm", sky);
    print_harmonics(session, harmonics);
    printf("}\n");
  } else if (has_air) {
    print_plain("sun irradiance", sun, bands, space);
    print_plain("sky irradiance", sky, bands, space);
    print_harmonics(session, harmonics);
  } else {
    printf("the scene has no air, and so no sky\n");
  }
}

static neph_result render_sky(cli_session *session, neph_scene *scene, neph_image **out_image) {
  neph_sky_image_desc desc = NEPH_SKY_IMAGE_DESC_DEFAULT;
  if (session->options->has_resolution) {
    desc.width = session->options->resolution[0];
    desc.height = session->options->resolution[1];
  }
  desc.disks = choose_disks(session->options);
  if (session->options->has_center)
    desc.center_azimuth_rad = session->options->center_deg * 3.14159265358979323846 / 180.0;
  desc.progress = cli_progress_report;
  desc.progress_user = &session->progress;
  const neph_result result = neph_render_sky(scene, &desc, out_image);
  cli_progress_finish(&session->progress);
  return result;
}

static neph_result save_table(const cli_session *session, neph_scene *scene, neph_sky_table table) {
  static const char *const endings[] = {".exr", ".png"};
  neph_preview_desc preview = NEPH_PREVIEW_DESC_DEFAULT;
  preview.view = NEPH_VIEW_FILMIC;
  if (table < NEPH_SKY_TABLE_AEROSOL) preview.exposure = NEPH_EXPOSURE_FIXED;
  neph_image *image;
  neph_result result = neph_render_sky_table(scene, table, &image);
  for (int i = 0; !result && i < 2; i++) {
    char *path = join_path(session->options->table_folder, neph_sky_table_get_name(table), endings[i]);
    if (!path) result = NEPH_ERROR_OUT_OF_MEMORY;
    if (!result)
      result = i ? neph_image_save_png(image, path, &preview) : neph_image_save_exr(image, path, NEPH_PIXEL_HALF);
    if (!result && !session->options->is_json) cli_say("%s", path);
    free(path);
  }
  neph_image_destroy(image);
  return result;
}

static neph_result save_tables(const cli_session *session, neph_scene *scene) {
  neph_result result = NEPH_OK;
  for (int i = 0; !result && i < NEPH_SKY_TABLE_COUNT; i++) result = save_table(session, scene, (neph_sky_table)i);
  return result;
}

static neph_result verify(cli_session *session, neph_scene *scene) {
  neph_sky_verify_desc desc = NEPH_SKY_VERIFY_DESC_DEFAULT;
  if (session->options->path_count) desc.path_count = session->options->path_count;
  desc.progress = cli_progress_report;
  desc.progress_user = &session->progress;
  char *text;
  neph_result result = neph_render_sky_verify(scene, &desc, cli_text_format(session), &text);
  cli_progress_finish(&session->progress);
  if (!result) cli_print_text(session, text);
  return result;
}

/* Prints the names of the files that would be written. */
static cli_exit rehearse(const cli_options *options, const neph_scene *scene) {
  neph_result result = neph_scene_check_files(scene);
  if (result) return cli_exit_of(result);
  if (options->output_count) cli_say("%s", options->outputs[0]);
  if (options->usd_path) cli_say("%s", options->usd_path);
  for (int i = 0; options->table_folder && i < NEPH_SKY_TABLE_COUNT; i++)
    printf("%s/%s.exr\n%s/%s.png\n", options->table_folder, neph_sky_table_get_name((neph_sky_table)i),
           options->table_folder, neph_sky_table_get_name((neph_sky_table)i));
  return CLI_DONE;
}

static cli_exit run(cli_session *session, neph_scene *scene) {
  const cli_options *options = session->options;
  if (options->is_dry_run) return rehearse(options, scene);
  neph_image *image = NULL;
  neph_result result = render_sky(session, scene, &image);
  if (!result && options->output_count) result = neph_image_save_exr(image, options->outputs[0], NEPH_PIXEL_FLOAT);
  if (!result && options->usd_path) result = neph_scene_save_usd(scene, image, get_texture(options), options->usd_path);
  if (!result && options->table_folder) result = save_tables(session, scene);
  if (!result && options->is_verifying) result = verify(session, scene);
  if (!result && !options->is_verifying) print_irradiances(session, image);
  neph_image_destroy(image);
  return cli_exit_of(result);
}

static cli_exit add_tables(const cli_session *session, neph_files *files) {
  const char *folder = session->options->table_folder;
  cli_exit exit = CLI_DONE;
  for (int i = 0; !exit && folder && i < 2 * NEPH_SKY_TABLE_COUNT; i++) {
    char *path = join_path(folder, neph_sky_table_get_name((neph_sky_table)(i / 2)), i % 2 ? ".png" : ".exr");
    exit = path ? cli_exit_of(neph_files_add(files, NEPH_FILE_WRITTEN, "--tables", path)) : CLI_INTERNAL;
    free(path);
  }
  return exit;
}

static cli_exit check_files(const cli_session *session, const neph_scene *scene) {
  neph_files *files;
  cli_exit exit = cli_files_begin(session, &files);
  if (!exit && session->options->output_count)
    exit = cli_files_add_output(session, files, "--output", session->options->outputs[0]);
  if (!exit) exit = add_tables(session, files);
  return cli_files_end(files, scene, exit);
}

static cli_exit run_sky(cli_session *session) {
  neph_scene *scene;
  cli_exit exit = check_output(session);
  if (!exit) exit = check_usd(session);
  if (!exit) exit = cli_load_scene(session, session->options->files[0], &scene);
  if (exit) return exit;
  cli_catch_interrupts();
  exit = check_files(session, scene);
  if (!exit) exit = run(session, scene);
  neph_scene_destroy(scene);
  return exit;
}

const cli_verb cli_verb_sky = {
    .name = "sky",
    .arguments = "SCENE",
    .summary = "compute the sky alone: irradiances, and a latitude-longitude picture",
    .argument_min = 1,
    .argument_max = 1,
    .run = run_sky,
    .files = "yaml yml",
    .exits = CLI_MAY(CLI_BAD_SCENE) | CLI_MAY(CLI_NOT_FOUND),
    .description =
        "Prints the irradiance of sun and sky on a level plane at the camera, and spherical harmonics of order "
        "2 of the sky.\n\n"
        "With --output it writes the sky as a latitude-longitude picture, R, G and B alone: azimuth grows to the "
        "right, "
        "the zenith is at the top, and the middle is south, as USD has it for a stage with Z up; Blender has it in the "
        "east, --center 90. --usd adds a layer with the lights and the camera, in which the sun is a light of its own.",
    .options = {{"--output", "write the sky to FILE, an .exr", .files = "exr"},
                {"--set"},
                {"--frame"},
                {"--resolution", "size of the picture in pixels"},
                {"--disks"},
                {"--center"},
                {"--usd"},
                {"--tables"},
                {"--verify", "measure the tables against integrals and, along 24 rays, against the tracer"},
                {"--paths", "with --verify: paths of the tracer along each ray", "4096"},
                {"--dry-run"},
                {"--progress"}},
    .examples = {{"nephos sky clear.yaml", "print the irradiances"},
                 {"nephos sky clear.yaml -o sky.exr --resolution 64x32", "write the sky as a picture"},
                 {"nephos sky clear.yaml -o dome.exr --usd dome.usda --resolution 64x32", "write lights and camera"}},
};

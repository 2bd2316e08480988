/* SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "session.h"

static cli_exit check_output(const cli_options *options) {
  if (!options->output_count) return CLI_DONE;
  if (options->output_count == 1 && cli_has_extension(options->outputs[0], ".exr"))
    return cli_check_target(options->outputs[0]);
  cli_complain("--output of nephos sky must be one .exr");
  return CLI_USAGE;
}

static void print_plain(const char *label, const char *values, const char *bands, const char *space) {
  printf("%-15s %s W/m2/nm %s %s\n", label, values, bands ? "at" : "in", bands ? bands : space);
}

/* Three numbers parted by spaces, as the header has them, as a JSON array. */
static void print_json(const char *name, const char *values) {
  char *rest;
  double first = strtod(values, &rest), second = strtod(rest, &rest), third = strtod(rest, &rest);
  printf("\"%s\": [%.9g, %.9g, %.9g]", name, first, second, third);
}

static void print_irradiances(const cli_session *session, const neph_image *image) {
  const char *sun = neph_image_get_attribute(image, "nephos:sunIrradiance");
  const char *sky = neph_image_get_attribute(image, "nephos:skyIrradiance");
  const char *bands = neph_image_get_attribute(image, "nephos:bands");
  const char *space = neph_image_get_attribute(image, "nephos:colorSpace");
  const bool has_air = sun && sky;
  if (session->options->is_json) {
    printf("{\"color_space\": ");
    cli_print_json_text(space);
    if (has_air) printf(", ");
    if (has_air) print_json("sun_irradiance_w_m2_nm", sun);
    if (has_air) printf(", ");
    if (has_air) print_json("sky_irradiance_w_m2_nm", sky);
    printf("}\n");
  } else if (has_air) {
    print_plain("sun irradiance", sun, bands, space);
    print_plain("sky irradiance", sky, bands, space);
  } else {
    printf("the scene has no air, and so no sky\n");
  }
}

static neph_result render_sky(cli_session *session, neph_scene *scene, neph_image **out_image) {
  neph_sky_image_desc desc = NEPH_SKY_IMAGE_DESC_DEFAULT;
  neph_render_desc scene_desc;
  neph_result result = neph_scene_get_render_desc(scene, &scene_desc);
  if (result) return result;
  if (session->options->has_resolution) {
    desc.width = scene_desc.width;
    desc.height = scene_desc.height;
  }
  desc.progress = cli_progress_report;
  desc.progress_user = &session->progress;
  result = neph_render_sky(scene, &desc, out_image);
  cli_progress_finish(&session->progress);
  return result;
}

static cli_exit run(cli_session *session, neph_scene *scene) {
  const cli_options *options = session->options;
  if (options->is_dry_run) {
    if (options->output_count) printf("%s\n", options->outputs[0]);
    return CLI_DONE;
  }
  neph_image *image = NULL;
  neph_result result = render_sky(session, scene, &image);
  if (!result && options->output_count) result = neph_image_save_exr(image, options->outputs[0], NEPH_PIXEL_FLOAT);
  if (!result) print_irradiances(session, image);
  neph_image_destroy(image);
  return cli_exit_of(result);
}

cli_exit cli_command_sky(cli_session *session) {
  neph_scene *scene;
  cli_exit exit = check_output(session->options);
  if (!exit) exit = cli_load_scene(session, session->options->files[0], &scene);
  if (exit) return exit;
  cli_catch_interrupts();
  exit = run(session, scene);
  neph_scene_destroy(scene);
  return exit;
}

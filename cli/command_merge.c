/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs.h"

static cli_exit check_output(const cli_session *session) {
  const cli_options *options = session->options;
  if (options->output_count == 1 && cli_has_extension(options->outputs[0], ".exr"))
    return cli_check_target(session, options->outputs[0]);
  cli_complain("--output of nephos merge must be one .exr");
  return CLI_USAGE;
}

static cli_exit run_merge(cli_session *session) {
  const cli_options *options = session->options;
  neph_image *image = NULL;
  neph_pixel_type type;
  cli_exit exit = check_output(session);
  if (exit) return exit;
  neph_result result = neph_parts_merge(session->context, options->files, options->file_count, &type, &image);
  if (!result) result = neph_image_save_exr(image, options->outputs[0], type);
  neph_image_destroy(image);
  if (!result && options->is_json) {
    printf("{\"image\": ");
    cli_print_json_text(options->outputs[0]);
    printf(", \"parts\": %zu}\n", options->file_count);
  } else if (!result)
    printf("%s: merged from %zu part%s\n", options->outputs[0], options->file_count,
           options->file_count == 1 ? "" : "s");
  return cli_exit_of(result);
}

const cli_verb cli_verb_merge = {
    .name = "merge",
    .arguments = "PART...",
    .summary = "join tiles and ranges of samples to the bits of the whole picture",
    .argument_min = 1,
    .argument_max = (size_t)-1,
    .run = run_merge,
    .files = "npart exr",
    .exits = CLI_MAY(CLI_NOT_FOUND),
    .description =
        "Joins parts of one picture: .npart files, which hold sums over samples, and .exr files of tiles. Every "
        "channel "
        "gets the bits that one render of the whole gives it. Parts of another scene, frame, seed, version or "
        "instruction-set level are refused by the hash in their headers, and so are parts that overlap. Where some are "
        "missing, the message lists them by tile and range of samples, and the exit code is 4.",
    .options = {{"--output", "write the picture to FILE, an .exr", .files = "exr"}},
    .examples = {{"nephos merge frame.tile*.exr -o frame.exr", "join tiles"},
                 {"nephos merge frame.samples*.npart -o frame.exr", "join ranges of samples"}},
};

/* SPDX-License-Identifier: Apache-2.0 */
#include "print.h"
#include "verbs.h"
#include "view_program.h"

static cli_exit run_view(cli_session *session) {
  const cli_options *options = session->options;
  const cli_view_settings settings = {.path = options->files[0],
                                      .address = options->listen ? options->listen : "127.0.0.1",
                                      .port = (uint16_t)options->port,
                                      .allows_files = options->allows_files,
                                      .opens = options->opens_browser};
  if (settings.path[0] != '-' || settings.path[1]) return cli_view_run(session, &settings);
  cli_complain("the scene is standard input, must be a file: the view follows it");
  return CLI_USAGE;
}

const cli_verb cli_verb_view = {
    .name = "view",
    .arguments = "SCENE",
    .summary = "show the picture in a browser while its keys are edited",
    .argument_min = 1,
    .argument_max = 1,
    .run = run_view,
    .files = "yaml yml",
    .exits = CLI_MAY(CLI_BAD_SCENE) | CLI_MAY(CLI_NOT_FOUND),
    .description =
        "Serves one page, at an address of this machine that is printed, and renders the scene for it: a picture of "
        "few pixels at once, all pixels after it, then more samples as long as they lower the stated error. Every key "
        "can be edited on the page; an edit that the scene refuses changes nothing. The address ends in a token, "
        "without which the server answers nothing but the bare page: keep it to yourself.\n\n"
        "The view follows the scene's file: saved by an editor, it is read again. Keys that name files cannot be "
        "set on the page unless --allow-files is given. It ends with Ctrl-C.",
    .options = {{"--set"},
                {"--frame"},
                {"--frames"},
                {"--resolution"},
                {"--quality"},
                {"--integrator"},
                {"--samples"},
                {"--seed"},
                {"--cache"},
                {"--cache-size"},
                {"--path-mapping"},
                {"--port"},
                {"--listen"},
                {"--open"},
                {"--allow-files"}},
    .examples = {{"nephos view scene.yaml --quality draft", "print the address of the page, and serve it"},
                 {"nephos view scene.yaml --resolution 480x270 --samples 1", "show a smaller picture, sooner"}},
};

/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs.h"

static cli_exit run(cli_session *session) {
  const cli_options *options = session->options;
  const char *key = options->file_count ? options->files[0] : NULL;
  char *text;
  neph_result result = neph_schema_describe(session->context, key, cli_text_format(session), &text);
  if (!result) cli_print_text(session, text);
  return cli_exit_of(result);
}

const cli_verb cli_verb_schema = {
    .name = "schema",
    .arguments = "[KEY]",
    .summary = "list the keys of a scene",
    .argument_max = 1,
    .run = run,
    .words = "KEYS",
    .description = "Lists keys of a scene with their values, ranges, defaults and meanings: all, or KEY with all below "
                   "it, or all that begin with KEY. Old names of keys are listed as deprecated.",
    .examples = {{"nephos schema camera", "the keys of the camera"},
                 {"nephos schema clouds[0].phase --json", "phase functions, as JSON"},
                 {"nephos schema output.p", "the keys that begin so"}},
};

/* SPDX-License-Identifier: Apache-2.0 */
#include "session.h"

cli_exit cli_command_schema(cli_session *session) {
  char *text;
  neph_result result = neph_schema_describe(session->context, cli_text_format(session), &text);
  if (!result) cli_print_text(session, text);
  return cli_exit_of(result);
}

/* SPDX-License-Identifier: Apache-2.0 */
#include "view_messages.h"

/* Takes errors and warnings of an edit; of the view's many renders, those are printed. */
static bool hear(void *user, neph_log_level level, const char *message) {
  cli_view_messages *messages = user;
  const bool is_editor = pthread_equal(pthread_self(), messages->editor);
  if (is_editor && messages->is_judging && level <= NEPH_LOG_WARNING) {
    cli_text *text = level == NEPH_LOG_ERROR ? &messages->refusal : &messages->notice;
    cli_text_add(text, "%s%s", text->length ? "\n" : "", message);
    return true;
  }
  if (level <= NEPH_LOG_WARNING && !is_editor) cli_view_picture_set_message(messages->picture, message);
  return level >= NEPH_LOG_INFO && messages->session->options->log_level < NEPH_LOG_DEBUG;
}

void cli_view_messages_begin(cli_view_messages *messages, cli_session *session, cli_view_picture *picture) {
  *messages = (cli_view_messages){.session = session, .picture = picture, .editor = pthread_self()};
  cli_progress_set_listener(&session->progress, hear, messages);
}

void cli_view_messages_end(cli_view_messages *messages) {
  if (messages->session) cli_progress_set_listener(&messages->session->progress, NULL, NULL);
  cli_text_clear(&messages->refusal);
  cli_text_clear(&messages->notice);
}

void cli_view_messages_judge(cli_view_messages *messages, bool is_judging) {
  if (is_judging) {
    cli_text_clear(&messages->refusal);
    cli_text_clear(&messages->notice);
  }
  messages->is_judging = is_judging;
}

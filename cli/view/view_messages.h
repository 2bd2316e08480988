/* SPDX-License-Identifier: Apache-2.0 */
/* The library's messages during a view: errors of an edit are the reason of its refusal, its
 * warnings go to the page with its answer, errors and warnings of the renderer go to the page and to standard error. */
#ifndef NEPHOS_CLI_VIEW_MESSAGES_H
#define NEPHOS_CLI_VIEW_MESSAGES_H

#include <pthread.h>

#include "print.h"
#include "session.h"
#include "view_picture.h"

typedef struct cli_view_messages {
  cli_session *session;
  cli_view_picture *picture;
  pthread_t editor;         /* thread of the edits */
  bool is_judging;          /* an edit is judged on that thread */
  cli_text refusal, notice; /* errors and warnings of the last edit, a line each */
} cli_view_messages;

/* Takes over the messages of the session's context. The calling thread becomes the thread of edits. */
void cli_view_messages_begin(cli_view_messages *messages, cli_session *session, cli_view_picture *picture);
void cli_view_messages_end(cli_view_messages *messages);

/* Begins and ends the judgement of an edit, which clears the refusal. */
void cli_view_messages_judge(cli_view_messages *messages, bool is_judging);

#endif
